"""Springs between given particles."""

import math

import numpy as np

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.interactions.adjacency import Adjacency
from gen_art.interactions.base import ForcePart, ForceRequest, Interaction, interaction
from gen_art.interactions.implicit_springs import solve_implicit
from gen_art.interactions.links import capsules_along
from gen_art.interactions.sheets import NO_FACES, checked_faces, whole_faces
from gen_art.interactions.spring_kernels import spring_kernels
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME, MASS, POSITION, VELOCITY
from gen_art.registry import param

__all__ = ["Springs"]


@interaction("springs")
class Springs(Interaction):
    """Springs between pairs of particles: given pairs, or those of the chains, ropes and cloths that emitters lay.

    F_i = (k (l - rest_length) + c w) n,  n = (x_j - x_i) / l,  l = abs(x_j - x_i),  w = (v_j - v_i).n
    U = sum k (l - rest_length)^2 / 2,  k = share stiffness,  c = share damping

    pairs : (m, 2), ids of particles, in order of birth from 0
    stiffness : N/m, >= 0
    damping : N s/m, >= 0
    rest_length : m, one for each spring or one for all; the lengths at the start when left out; 0 makes a chain whose waves obey
        the same law along it and across
    share : each spring's part of the stiffness and damping
    method : "explicit", with any integrator, stable for w dt < 2. For springs far beyond that limit, with semi_implicit_euler:
        "implicit", backward Euler for the whole net, or "xpbd", sweeps over the strands of the net, each solved by backward Euler
        along its length. xpbd is much quicker, and exact for ropes and for whatever hangs by its strands; in other nets short
        steps and a tether keep a large net from stretching
    tear : strain beyond which a spring breaks for good; its energy is recorded as dissipated
    tether : with xpbd, largest strain of the shortest path along springs to each group of fixed particles
    sweeps : of xpbd in a step; 1 is enough where steps are short, and the stiffness does not depend on it
    faces : (k, 3), ids of the particles at the corners of the triangles that `draw: cloth` shows; no force comes from them
    The energy that backward Euler takes from oscillations faster than the step is recorded as dissipated too.
    A spring is removed when one of its ends dies. Fixed particles pull on others but do not move.
    Reciprocal; conservative except for damping and tearing.
    Sources: Baraff & Witkin (1998); Macklin et al., Small Steps in Physics Simulation (2019).
    """

    pairs: object = param(None, doc="pairs of particles; those that emitters lay when left out")
    stiffness: float = param(100.0, unit="N/m", min=0)
    rest_length: object = param(None, unit="m")
    damping: float = param(0.0, unit="N s/m", min=0)
    method: str = param("explicit", choices=("explicit", "implicit", "xpbd"))
    share: object = param(None)
    tear: float = param(None, min=0, doc="strain beyond which a spring breaks; none does when left out")
    tether: float = param(None, min=0, doc="largest strain of the path to fixed particles; none when left out")
    sweeps: int = param(2, min=1, max=100)
    faces: object = param(
        None, doc="triangles of particles to be drawn; those of the cloths that emitters lay when left out"
    )

    def prepare(self):
        values, self._broken = self.values, np.zeros(0, bool)
        if values["tether"] is not None and values["method"] != "xpbd":
            raise UsageError("tether goes with method 'xpbd'")
        if values["tether"] is not None and values["tear"] is not None:
            raise UsageError("a tether takes the load from the springs: give tear or tether, not both")
        if values["pairs"] is None:
            if values["share"] is not None:
                raise UsageError("share goes with pairs")
            if values["faces"] is not None:
                raise UsageError("faces go with pairs")
            length = values["rest_length"]
            if length is not None:
                values["rest_length"] = arguments.number("rest_length, without pairs,", length, "m", low=0.0)
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
        if values["faces"] is not None:
            values["faces"] = checked_faces(values["faces"], pairs)
        for key in ("rest_length", "share"):
            if values[key] is not None:
                what = f"one number or {len(pairs)} of them, finite and at least 0"
                array = arguments.array(key, values[key], what)
                if array.shape not in ((), (len(pairs),)) or (array < 0).any():
                    raise UsageError(f"{key} must be {what}")
                values[key] = np.broadcast_to(array, (len(pairs),))

    @property
    def implicit(self) -> bool:  # type: ignore[override]  # by the instance's method
        return self.values["method"] != "explicit"

    @property
    def breaks(self) -> bool:  # type: ignore[override]
        return self.values["tear"] is not None

    @property
    def parts(self):
        damped = (ForcePart(dissipates=True),) if self.values["damping"] > 0 else ()
        return () if self.implicit else (ForcePart(), *damped)

    def check(self, system):
        if self.implicit and system.scheme.name != "semi_implicit_euler":
            raise UsageError(
                f"springs: method '{self.values['method']}' is a backward Euler step beside the kick of semi_implicit_euler; "
                f"give '{system.name}' that integrator, or method 'explicit' with {system.scheme.name}"
            )
        laid = any(getattr(kind.scripted, "net", None) is not None for e in system.emitters for kind in e.kinds)
        if self.values["pairs"] is None and not laid:
            raise UsageError(
                f"springs: '{system.name}' has none; give pairs, or an emitter that lays them: chain, rope or cloth"
            )

    def check_masses(self, system, ids, masses):
        massless = ids[np.isin(ids, self._ids) & (masses <= 0)]
        if len(massless):
            raise UsageError(f"springs: particle {massless[0]} of '{system.name}' has no mass; give it one, or fix it")

    def attach(self, system, dt):
        state = system.state
        n = state.count
        pairs, rest, share = self.values["pairs"], self.values["rest_length"], self.values["share"]
        self._faces = NO_FACES if self.values["faces"] is None else self.values["faces"]
        if pairs is None:
            pairs, laid_rest, share, self._faces = self._from_emitters(system)
            rest = laid_rest if rest is None else np.full(len(pairs), float(rest))
        if len(pairs) and pairs.max() >= n > 0:
            raise UsageError(
                f"springs: a pair names particle {pairs.max()}, but '{system.name}' begins with {n} (0 to {n - 1})"
            )
        if rest is None:
            x = state.floats[POSITION, :n].astype(np.float64)
            rest = np.linalg.norm(x[:, pairs[:, 0]] - x[:, pairs[:, 1]], axis=0)
            self.values["rest_length"] = rest  # stored in snapshots
        share = np.ones(len(pairs)) if share is None else share
        k, c = self.values["stiffness"] * share, self.values["damping"] * share
        self._ids, self._spring_numbers, self._key = pairs, np.stack([k, rest, c], 1), (-1, -1)
        self._broken = np.zeros(len(pairs) if self.breaks else 0, bool)
        if n == 0:  # a snapshot is being restored: the particles come later
            return []
        mass = state.floats[MASS, :n].astype(np.float64)
        self.check_masses(system, state.id[:n], mass)
        if self.implicit:
            return []
        longest = self._longest_step(system, mass, fixed_lifetimes(state.floats[LIFETIME, :n]))
        if dt <= longest:
            return []
        return [
            f"a step of {dt:g} s is too long for springs of {self.values['stiffness']:g} N/m; the longest that is surely "
            f"stable is {longest:.3g} s (or method 'implicit' with semi_implicit_euler)"
        ]

    def _longest_step(self, system, mass, fixed) -> float:
        """The largest surely stable step, s: w^2 <= k_i / m_i + k_j / m_j, with k_i the sum of the stiffness at one end."""
        i, j = self._ids.T
        inverse_mass = np.where(fixed, 0.0, 1.0 / np.maximum(mass, 1e-300))

        def largest(amount):
            total = np.bincount(i, amount, len(mass)) + np.bincount(j, amount, len(mass))
            return float((total[i] * inverse_mass[i] + total[j] * inverse_mass[j]).max(initial=0.0))

        square, rate = largest(self._spring_numbers[:, 0]), largest(self._spring_numbers[:, 2])
        if square == 0:
            return math.inf
        limit = system.scheme.stability_limit
        if limit == 0:  # explicit Euler: only damping keeps an oscillation from growing
            return rate / square
        return limit / square * (math.sqrt(rate * rate / 4 + square) - rate / 2)

    @staticmethod
    def _from_emitters(system):
        """Pairs of ids, rest lengths, shares, and triangles of ids, of all nets that the system's emitters lay."""
        state, found = system.state, []
        for emission in system.emitters:
            for k, kind in enumerate(emission.kinds):
                net = getattr(kind.scripted, "net", None)
                if net is not None:
                    ids = state.id[: state.count][state.source[: state.count] == emission.first_source + k]
                    found.append((ids[net.pairs], net.rest_length, net.share, ids[net.faces]))
        return tuple(np.concatenate(part) for part in zip(*found))

    def _adjacency(self, state) -> Adjacency:
        """The unbroken springs whose ends are both alive, by slot, also in the order that the method needs."""
        if self._key != (state.next_id, state.count):
            self._key = (state.next_id, state.count)
            ids = state.id[: state.count]
            slots = np.minimum(np.searchsorted(ids, self._ids), state.count - 1)
            kept = (ids[slots] == self._ids).all(1)
            if self.breaks:
                kept &= ~self._broken
            self._unbroken = np.flatnonzero(kept)
            numbers, dtype = self._spring_numbers[kept], state.floats.dtype
            self._springs = Adjacency(slots[kept], numbers, state.count, dtype)
            if self.values["method"] == "xpbd":
                from gen_art.interactions import strands, tethers

                self._strands = strands.Strands(slots[kept], numbers, state.count, dtype)
                fixed = fixed_lifetimes(state.floats[LIFETIME, : state.count])
                self._tethers = []
                if self.values["tether"] is not None:
                    self._tethers = tethers.find_tethers(self._springs, fixed, dtype)
        return self._springs

    def shapes(self, state):
        """A capsule along each unbroken spring, as thick as its particles."""
        pairs = np.zeros((0, 2), np.int64)
        if state.count:
            springs = self._adjacency(state)
            pairs = springs.pairs[springs.numbers[:, 0] > 0]
        return capsules_along(
            state.floats[POSITION].astype(np.float64), state.floats[VELOCITY].astype(np.float64), pairs
        )

    def sheet(self, state):
        if not len(self._faces):
            return None
        broken = self._ids[self._broken] if self.breaks else self._ids[:0]
        return whole_faces(self._faces, state.id[: state.count], broken)

    def accelerate(self, request: ForceRequest, out):
        springs = self._adjacency(request.state)
        kernel, *_ = spring_kernels(request.precision)
        rows, floats = request.rows, request.state.floats
        kernel(rows, floats, springs.first, springs.other, springs.half_numbers, out, request.n, len(self.parts))

    def solve(self, state, stage) -> None:
        """Set the velocities to those at the end of the implicit step."""
        n, dt = state.count, stage.dt
        if not n:
            return
        springs = self._adjacency(state)
        if self.values["method"] == "implicit":
            solve_implicit(state.floats, n, springs, dt, stage.precision)
            return
        from gen_art.interactions import tethers, xpbd

        xpbd.sweep(state.floats, n, self._strands, dt, stage.precision, self.values["sweeps"])
        if self._tethers:
            tethers.apply_tethers(state.floats, n, self._tethers, self.values["tether"], dt, stage.precision)

    def break_bonds(self, state, precision: str) -> float | None:
        """Break the springs that are stretched by more than `tear`; returns their energy, J, or None if none breaks."""
        from gen_art.interactions.tearing import stretched

        if not state.count:
            return None
        springs = self._adjacency(state)
        broken = stretched(state.floats, springs, self.values["tear"], precision)
        if not len(broken):
            return None
        self._broken[self._unbroken[broken]] = True
        x, (k, rest, _) = state.floats[POSITION].astype(np.float64), springs.numbers[broken].T
        i, j = springs.pairs[broken].T
        energy = float((0.5 * k * (np.linalg.norm(x[:, i] - x[:, j], axis=0) - rest) ** 2).sum())
        springs.numbers[broken] = 0  # a broken spring has no stiffness and no damping
        springs.half_numbers[:, springs.halves[broken]] = 0
        if self.values["method"] == "xpbd":
            self._strands.numbers.reshape(-1)[self._strands.places[broken]] = 0
        return energy

    @property
    def saved_arrays(self):
        return {"torn": self._broken} if self.breaks else {}

    def restore_arrays(self, saved_arrays, time):
        self._broken, self._key = saved_arrays.get("torn", self._broken).copy(), (-1, -1)

    def dissipated(self, state, before: np.ndarray, dt: float) -> float:
        """The energy, J, that an implicit step takes, from velocities `before` (3, n) to those at its end, before its drift.

        Damping takes dt c u^2 at the velocities of the end. Backward Euler itself, m (v1 - v0) = -h grad U(x1), takes
        sum 1/2 m abs(v1 - v0)^2 + U(x0) - U(x1) + grad U(x1).(x1 - x0), from oscillations that the step cannot resolve. The
        ledger closes as far as the velocities solve that equation.
        """
        springs = self._adjacency(state)
        k, rest, c = springs.numbers.T
        i, j = springs.pairs.T
        d = (state.floats[POSITION, j] - state.floats[POSITION, i]).astype(np.float64)
        w = (state.floats[VELOCITY, j] - state.floats[VELOCITY, i]).astype(np.float64)
        d1 = d + dt * w
        length, length1 = (np.maximum(np.sqrt((x * x).sum(0)), 1e-300) for x in (d, d1))
        damped = dt * c * ((d * w).sum(0) / length) ** 2
        change = state.floats[VELOCITY, : state.count].astype(np.float64) - before
        kinetic = 0.5 * float((change * change).sum(0) @ state.floats[MASS, : state.count].astype(np.float64))
        stretch = length1 - rest
        elastic = 0.5 * k * ((length - rest) ** 2 - stretch**2) + k * stretch * dt * (d1 * w).sum(0) / length1
        return kinetic + float((damped + elastic).sum())

    def energy(self, state, slots, precision):
        if not len(slots):
            return 0.0
        springs = self._adjacency(state)
        i, j = springs.pairs.T
        selected = np.zeros(state.count, bool)
        selected[slots] = True
        both = selected[i] & selected[j]
        x = state.floats[POSITION, : state.count].astype(np.float64)
        k, rest, _ = springs.numbers[both].T
        return float((0.5 * k * (np.linalg.norm(x[:, i[both]] - x[:, j[both]], axis=0) - rest) ** 2).sum())
