"""Springs between given particles."""

import math
import warnings

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.adjacency import Adjacency
from gen_art.interactions.base import ForceRequest, Interaction, interaction
from gen_art.interactions.implicit_springs import solve
from gen_art.interactions.spring_kernels import spring_kernels
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME, MASS, POSITION, VELOCITY
from gen_art.registry import param

__all__ = ["Springs"]

_REACH = {"rk4": 2.828, "yoshida4": 1.573}  # largest stable w dt of an oscillator, 2 for the others


@interaction("springs")
class Springs(Interaction):
    """Springs between pairs of particles: those given, or those of the chains, ropes and cloths that emitters lay.

    F_i = (k (l - rest_length) + c w) n,  n = (x_j - x_i) / l,  l = abs(x_j - x_i),  w = (v_j - v_i).n
    U = sum k (l - rest_length)^2 / 2,  k = share stiffness,  c = share damping

    pairs : (m, 2) ids of particles, in order of birth from 0     stiffness : N/m, >= 0     damping : N s/m, >= 0
    rest_length : m, each or all; as they are laid when left out; 0 makes a chain whose waves obey one law along it and across
    share : each spring's part of the stiffness and damping
    method : "explicit" with any integrator, stable for w dt < 2; far beyond that, with semi_implicit_euler, "implicit", backward
    Euler for the whole net, or "xpbd", sweeps over the threads of the net, each backward Euler along itself: much quicker, and
    exact for ropes and for what hangs by its threads; elsewhere short steps and a tether keep a large net from stretching
    tear : strain beyond which a spring breaks for good; its energy is booked as dissipated
    tether : with xpbd, the strain at most of the shortest way along springs to each group of fixed particles
    sweeps : of xpbd in a step; 1 does where steps are short, and no stiffness depends on it
    What backward Euler takes of swings faster than the step is booked as dissipated too.
    A spring goes when one of its ends dies. Fixed particles pull and stay. Reciprocal; conservative but for damping and tearing.
    Sources: Baraff & Witkin (1998); Macklin et al., Small Steps in Physics Simulation (2019).
    """

    pairs: object = param(None, doc="pairs of particles; those that emitters lay when left out")
    stiffness: float = param(100.0, unit="N/m", min=0)
    rest_length: object = param(None, unit="m")
    damping: float = param(0.0, unit="N s/m", min=0)
    method: str = param("explicit", choices=("explicit", "implicit", "xpbd"))
    share: object = param(None)
    tear: float = param(None, min=0, doc="strain beyond which a spring breaks; none does when left out")
    tether: float = param(None, min=0, doc="largest strain of the way to fixed particles; none when left out")
    sweeps: int = param(2, min=1, max=100)

    def prepare(self):
        values, self._torn = self.values, np.zeros(0, bool)
        if values["tether"] is not None and values["method"] != "xpbd":
            raise UsageError("tether goes with method 'xpbd'")
        if values["tether"] is not None and values["tear"] is not None:
            raise UsageError("a tether takes the load from the springs: give tear or tether, not both")
        if values["pairs"] is None:
            if values["share"] is not None:
                raise UsageError("share goes with pairs")
            length = values["rest_length"]
            if length is not None and (np.shape(length) or not math.isfinite(length) or length < 0):
                raise UsageError(f"rest_length, without pairs, must be one number, at least 0, not {length!r}")
            return
        try:
            pairs = np.asarray(values["pairs"])
        except ValueError:
            raise UsageError("pairs must be whole numbers of the shape (m, 2); some pair is no pair") from None
        if pairs.ndim != 2 or pairs.shape[1] != 2 or not np.issubdtype(pairs.dtype, np.integer):
            raise UsageError(f"pairs must be whole numbers of the shape (m, 2), not {pairs.dtype} of {pairs.shape}")
        if (pairs < 0).any():
            raise UsageError("pairs must be ids from 0 on")
        if (pairs[:, 0] == pairs[:, 1]).any():
            raise UsageError(f"a spring joins particle {pairs[pairs[:, 0] == pairs[:, 1]][0, 0]} to itself")
        known, times = np.unique(np.sort(pairs, 1), axis=0, return_counts=True)
        if (times > 1).any():
            i, j = known[times > 1][0]
            raise UsageError(f"two springs contradict each other: particles {i} and {j} are joined twice")
        values["pairs"] = pairs.astype(np.int64)
        for key in ("rest_length", "share"):
            if values[key] is not None:
                array = np.asarray(values[key], float)
                if array.shape not in ((), (len(pairs),)) or not np.isfinite(array).all() or (array < 0).any():
                    raise UsageError(f"{key} must be one number or {len(pairs)} of them, finite and at least 0")
                values[key] = np.broadcast_to(array, (len(pairs),))

    @property
    def implicit(self) -> bool:
        return self.values["method"] != "explicit"

    @property
    def breaks(self) -> bool:
        return self.values["tear"] is not None

    @property
    def parts(self):
        return () if self.implicit else ("", "damping") if self.values["damping"] > 0 else ("",)

    def attach(self, system, dt):
        state = system.state
        n = state.count
        pairs, rest, share = self._laid(system) if self.values["pairs"] is None else (
            self.values["pairs"], self.values["rest_length"], self.values["share"],
        )  # fmt: skip
        if self.values["pairs"] is None and self.values["rest_length"] is not None:
            rest = np.full(len(pairs), float(self.values["rest_length"]))
        if len(pairs) and pairs.max() >= n > 0:
            raise UsageError(
                f"springs: a pair names particle {pairs.max()}, but '{system.name}' begins with {n} (0 to {n - 1})"
            )
        if rest is None:
            x = state.floats[POSITION, :n].astype(np.float64)
            rest = np.linalg.norm(x[:, pairs[:, 0]] - x[:, pairs[:, 1]], axis=0)
            self.values["rest_length"] = rest  # a snapshot keeps it
        share = np.ones(len(pairs)) if share is None else share
        k, c = self.values["stiffness"] * share, self.values["damping"] * share
        self._ids, self._numbers, self._key = pairs, np.stack([k, rest, c], 1), (-1, -1)
        self._torn = np.zeros(len(pairs) if self.breaks else 0, bool)
        if n == 0:  # a snapshot is being restored: the particles come later
            return
        mass = state.floats[MASS, :n].astype(np.float64)
        light = np.unique(pairs)[mass[np.unique(pairs)] <= 0]
        if len(light):
            raise UsageError(f"springs: particle {light[0]} of '{system.name}' has no mass; give it one, or fix it")
        if self.implicit:
            if system.scheme.name != "semi_implicit_euler":
                raise UsageError(
                    f"springs: method '{self.values['method']}' is a backward Euler step beside the kick of semi_implicit_euler; "
                    f"give '{system.name}' that integrator, or method 'explicit' with {system.scheme.name}"
                )
            return
        longest = self._longest(system, mass, fixed_lifetimes(state.floats[LIFETIME, :n]))
        if dt > longest:
            warnings.warn(
                f"system '{system.name}': a step of {dt:g} s is too long for springs of {self.values['stiffness']:g} N/m; "
                f"the longest that is surely stable is {longest:.3g} s (or method 'implicit' with semi_implicit_euler)",
                stacklevel=2,
            )

    def _longest(self, system, mass, fixed) -> float:
        """The largest surely stable step, s: w^2 <= k_i / m_i + k_j / m_j, k_i the sum of the stiffness at an end."""
        i, j = self._ids.T
        give = np.where(fixed, 0.0, 1.0 / np.maximum(mass, 1e-300))

        def largest(amount):
            at = np.bincount(i, amount, len(mass)) + np.bincount(j, amount, len(mass))
            return float((at[i] * give[i] + at[j] * give[j]).max(initial=0.0))

        square, rate = largest(self._numbers[:, 0]), largest(self._numbers[:, 2])
        reach = _REACH.get(system.scheme.name, 2.0)
        return math.inf if square == 0 else reach / square * (math.sqrt(rate * rate / 4 + square) - rate / 2)

    @staticmethod
    def _laid(system):
        """Pairs of ids, rest lengths and shares of every net that the system's emitters lay."""
        state, found = system.state, []
        for emission in system.emitters:
            for k, kind in enumerate(emission.kinds):
                net = getattr(kind.scripted, "net", None)
                if net is not None:
                    ids = state.id[: state.count][state.source[: state.count] == emission.first_source + k]
                    found.append((ids[net.pairs], net.rest_length, net.share))
        if not found:
            raise UsageError(
                f"springs: '{system.name}' has none; give pairs, or an emitter that lays them: chain, rope or cloth"
            )
        return tuple(np.concatenate(part) for part in zip(*found))

    def _adjacency(self, state) -> Adjacency:
        """The springs whose ends both live, by slot, and in the order their method takes them."""
        if self._key != (state.next_id, state.count):
            self._key = (state.next_id, state.count)
            ids = state.id[: state.count]
            slots = np.minimum(np.searchsorted(ids, self._ids), state.count - 1)
            whole = (ids[slots] == self._ids).all(1)
            if self.breaks:
                whole &= ~self._torn
            self._left = np.flatnonzero(whole)
            numbers, dtype = self._numbers[whole], state.floats.dtype
            self._springs = Adjacency(slots[whole], numbers, state.count, dtype)
            if self.values["method"] == "xpbd":
                from gen_art.interactions import strands, tethers

                self._strands = strands.Strands(slots[whole], numbers, state.count, dtype)
                held = fixed_lifetimes(state.floats[LIFETIME, : state.count])
                self._tethers = [] if self.values["tether"] is None else tethers.ways(self._springs, held, dtype)
        return self._springs

    def accelerate(self, request: ForceRequest, out):
        springs = self._adjacency(request.state)
        spring_kernels(request.precision)[0](
            request.rows,
            request.state.floats,
            springs.first,
            springs.other,
            springs.of,
            out,
            request.n,
            len(self.parts),
        )

    def solve(self, state, turn) -> None:
        """The implicit step: velocities at its end."""
        if not state.count:
            return
        springs = self._adjacency(state)
        if self.values["method"] == "implicit":
            solve(state.floats, state.count, springs, turn.dt, turn.precision)
            return
        from gen_art.interactions import tethers, xpbd

        xpbd.sweep(state.floats, state.count, self._strands, turn.dt, turn.precision, self.values["sweeps"])
        if self._tethers:
            tethers.hold(state.floats, state.count, self._tethers, self.values["tether"], turn.dt, turn.precision)

    def break_bonds(self, state, precision: str) -> float | None:
        """Break the springs that are stretched by more than `tear`; the energy they held, J."""
        from gen_art.interactions.tearing import stretched

        if not state.count:
            return None
        springs = self._adjacency(state)
        broken = stretched(state.floats, springs, self.values["tear"], precision)
        if not len(broken):
            return None
        self._torn[self._left[broken]] = True
        x, (k, rest, _) = state.floats[POSITION].astype(np.float64), springs.numbers[broken].T
        i, j = springs.pairs[broken].T
        energy = float((0.5 * k * (np.linalg.norm(x[:, i] - x[:, j], axis=0) - rest) ** 2).sum())
        springs.numbers[broken] = 0  # what has no stiffness and no damping is gone
        springs.of[:, springs.halves[broken]] = 0
        if self.values["method"] == "xpbd":
            self._strands.numbers.reshape(-1)[self._strands.at[broken]] = 0
        return energy

    @property
    def saved_arrays(self):
        return {"torn": self._torn} if self.breaks else {}

    def restore_arrays(self, saved_arrays, time):
        self._torn, self._key = saved_arrays.get("torn", self._torn), (-1, -1)

    def dissipated(self, state, before: np.ndarray, dt: float) -> float:
        """J that an implicit step takes, from velocities `before` (3, n) to those at its end, before its drift of dt.

        Damping takes dt c u^2 at the velocities of the end. Backward Euler itself, m (v1 - v0) = -h grad U(x1), takes
        sum 1/2 m abs(v1 - v0)^2 + U(x0) - U(x1) + grad U(x1).(x1 - x0): what swings faster than the step can follow. The
        account closes with it as far as the velocities found solve that equation.
        """
        springs = self._adjacency(state)
        k, rest, c = springs.numbers.T
        i, j = springs.pairs.T
        d = (state.floats[POSITION, j] - state.floats[POSITION, i]).astype(np.float64)
        w = (state.floats[VELOCITY, j] - state.floats[VELOCITY, i]).astype(np.float64)
        far = d + dt * w
        length, longer = (np.maximum(np.sqrt((x * x).sum(0)), 1e-300) for x in (d, far))
        damped = dt * c * ((d * w).sum(0) / length) ** 2
        change = state.floats[VELOCITY, : state.count].astype(np.float64) - before
        kicked = 0.5 * float((change * change).sum(0) @ state.floats[MASS, : state.count].astype(np.float64))
        stretch = longer - rest
        pulled = 0.5 * k * ((length - rest) ** 2 - stretch**2) + k * stretch * dt * (far * w).sum(0) / longer
        return kicked + float((damped + pulled).sum())

    def energy(self, state, slots, precision):
        i, j = self._adjacency(state).pairs.T
        here = np.zeros(state.count, bool)
        here[slots] = True
        both = here[i] & here[j]
        x = state.floats[POSITION, : state.count].astype(np.float64)
        k, rest, _ = self._adjacency(state).numbers[both].T
        return float((0.5 * k * (np.linalg.norm(x[:, i[both]] - x[:, j[both]], axis=0) - rest) ** 2).sum())
