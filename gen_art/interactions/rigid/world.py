"""The bodies of one system together: their state, and one step of it in the parts that the simulation asks for."""

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.rigid.body import AXLED, FREE, STATIC, Body
from gen_art.interactions.rigid.contact_set import ContactSet
from gen_art.interactions.rigid.free_motion import ANGLE, inverse_inertia, plan, turn_kernel
from gen_art.interactions.rigid.kernels import particle_kernels
from gen_art.interactions.rigid.quaternions import cross, matrices, product, rotation
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME

__all__ = ["World"]


class World:
    """State: place x (b, 3), attitude q (b, 4), velocity v (b, 3) of the origins, angular momentum L (b, 3) about them."""

    def __init__(self, members: list[Body], colliders, values: dict, system, dt: float):
        self.members, self.precision = members, "f64" if system.state.floats.dtype == np.float64 else "f32"
        stack = lambda f: np.array([f(b) for b in members], float)  # noqa: E731
        self.x, self.q = stack(lambda b: b.place), stack(lambda b: b.attitude)
        self.v = stack(lambda b: b.velocity)
        self.hold = np.array([b.hold for b in members])
        self.inertia, self.axle = stack(lambda b: b.inertia), stack(lambda b: b.axle)
        self.ease = np.where(self.hold == FREE, 1 / stack(lambda b: b.mass), 0.0)
        self.turning = inverse_inertia(self.inertia, self.hold, self.axle)
        R = matrices(self.q)
        own = np.einsum("bji,bj->bi", R, stack(lambda b: b.spin))
        self.L = np.einsum("bij,bj->bi", R, self.inertia * own)
        self._still = bool((self.hold == STATIC).all())
        self._plan = plan(self.inertia, self.hold, self.axle)
        counts = [len(b.local) for b in members]
        self._first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._of = np.repeat(np.arange(len(members)), counts).astype(np.int32)
        self._table = np.concatenate([np.column_stack([b.masses, b.local, b.normals, 0 * b.masses]) for b in members])
        rows = system.state.channels
        self._rows = np.array([rows.get(k, -1) for k in ("normal_x", "normal_y", "normal_z", "shade")], np.int32)
        lamp = np.array(values["lamp"], float)
        self._lamp = lamp / np.linalg.norm(lamp)
        self._check(system)
        self._bound()
        self.contacts = ContactSet(self, colliders, values, dt)
        self.shift: np.ndarray | None = None  # (b, 6) that the drift moves and turns the bodies by beside their motion
        self.given: dict[str, tuple[np.ndarray, float]] = {}
        if system.state.count:
            self.contacts.look(0.0)
            self.contacts.refuse_overlaps(system.name)
            self._put(system.state, True)

    def _check(self, system) -> None:
        state = system.state
        n = state.count
        if n == 0:  # a snapshot is being restored: the particles come later
            return
        if n != len(self._of):
            raise UsageError(f"system '{system.name}' has {n} particles, but its bodies have {len(self._of)}")
        if (
            state.may_die
            and (np.isfinite(state.floats[LIFETIME, :n]) & ~fixed_lifetimes(state.floats[LIFETIME, :n])).any()
        ):
            raise UsageError(f"rigid bodies do not die: leave out the lifetime of system '{system.name}'")

    def _bound(self) -> None:
        """How the bodies stand now: matrices, inverse inertia and spin in the world."""
        self.R = matrices(self.q)
        self.J = np.einsum("bij,bjk,blk->bil", self.R, self.turning, self.R)
        self.w = np.einsum("bij,bj->bi", self.J, self.L)

    @property
    def saved_arrays(self) -> dict[str, np.ndarray]:
        return {"x": self.x, "q": self.q, "v": self.v, "L": self.L, **self.contacts.saved_arrays}

    def restore_arrays(self, saved_arrays: dict[str, np.ndarray], time: float) -> None:
        self.x, self.q, self.v, self.L = (saved_arrays[k].copy() for k in ("x", "q", "v", "L"))
        self._bound()
        self.contacts.restore_arrays(saved_arrays)
        self.contacts.look(time)

    def _frames(self) -> np.ndarray:
        return np.concatenate([self.x, self.R.reshape(-1, 9), self.v, self.w], 1)

    def _put(self, state, moves: bool) -> None:
        put = particle_kernels(self.precision)[1]
        put(state.floats, self._table, self._frames(), self._of, self._lamp, self._rows, int(moves))

    def push(self, state, turn) -> None:
        """What forces gave the particles since their velocities were turn.old, then the impulses of contacts."""
        if self._still:
            return
        gained = np.zeros((len(self.members), 6))
        particle_kernels(self.precision)[0](
            state.floats, np.ascontiguousarray(turn.old), self._table, self._frames(), self._first, gained
        )
        v, w = self.v, self.w
        self.v = v + gained[:, :3] * self.ease[:, None]
        self.L = self._allowed(self.L + gained[:, 3:])
        self._bound()
        self.given = self.contacts.solve(v, w, turn)
        if turn.booked or not turn.drift:
            self._put(state, False)

    def shifts(self) -> np.ndarray | float:
        """(3, n) m, how far the coming drift moves the particles beside their velocities."""
        if self.shift is None:
            return 0.0
        arm = np.einsum("nij,nj->ni", self.R[self._of], self._table[:, 1:4])
        by = self.shift[self._of]
        return (by[:, :3] + cross(by[:, 3:], arm)).T

    def impulse(self, P: np.ndarray, L: np.ndarray) -> None:
        """Take impulses (b, 3) and angular impulses (b, 3) about the origins."""
        self.v = self.v + P * self.ease[:, None]
        self.L = self._allowed(self.L + L)
        self._bound()

    def _allowed(self, L: np.ndarray) -> np.ndarray:
        """The part of an angular momentum that bodies may have, as they are held."""
        R = self.R
        along = np.einsum("bij,bj->bi", R, self.axle)
        L = np.where((self.hold == AXLED)[:, None], along * (along * L).sum(1)[:, None], L)
        L[self.hold == STATIC] = 0.0
        return L

    def drift(self, state, turn) -> None:
        """Move on with the velocities as they are, and see what touches there."""
        if self._still:
            return
        self.x = self.x + turn.drift * self.v
        if self.shift is not None:
            self.x += self.shift[:, :3]
            self.q = product(rotation(self.shift[:, 3:]), self.q)
        turn_kernel()(self.q, self.L, self._plan, self.axle, turn.drift, ANGLE)
        self._bound()
        self._put(state, True)
        self.contacts.look(turn.time + turn.dt)
