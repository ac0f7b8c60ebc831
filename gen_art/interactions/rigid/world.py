"""The rigid bodies of one system: their state, and one step of it in the parts that the simulation asks for."""

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import Shapes
from gen_art.interactions.rigid.body import AXLED, FREE, STATIC, Body
from gen_art.interactions.rigid.body_kernels import particle_kernels
from gen_art.interactions.rigid.contact_set import ContactSet
from gen_art.interactions.rigid.free_motion import MAX_ANGLE, inverse_inertia, rotation_kernel, splitting_table
from gen_art.interactions.rigid.joint import joints_of
from gen_art.interactions.rigid.joint_solver import JointSet
from gen_art.interactions.rigid.quaternions import matrices, product, rotation
from gen_art.interactions.rigid.small_matrices import apply, apply_transposed, compose, cross, dot, norm, transposed
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME

__all__ = ["World"]

_POSITION = slice(1, 4)  # columns of the particle table, see kernels.py


class World:
    """The state of b bodies.

    x, q : (b, 3) m and (b, 4), positions of the origins, and attitudes as quaternions
    v, L : (b, 3) m/s and (b, 3) kg m^2/s, velocities of the origins and angular momenta about them
    R, w, inverse_inertia : rotation matrices, spins (b, 3) rad/s and inverse inertia (b, 3, 3) in the world, derived from q and L
    displacement : (b, 6) m and rad, by which the coming drift moves the bodies beside their motion, or None
    at_rest : whether all bodies are static
    collider_impulses : each collider's impulse, N s, and work, J, in the last solve, by name
    """

    def __init__(self, members: list[Body], colliders, values: dict, system, dt: float):
        self.members, self.precision = members, "f64" if system.state.floats.dtype == np.float64 else "f32"
        stack = lambda f: np.array([f(b) for b in members], float)  # noqa: E731
        self.x, self.q = stack(lambda b: b.place), stack(lambda b: b.attitude)
        self.v = stack(lambda b: b.velocity)
        self.constraint = np.array([b.constraint for b in members])
        self.inertia, self.axle = stack(lambda b: b.inertia), stack(lambda b: b.axle)
        self.inverse_mass = np.where(self.constraint == FREE, 1 / stack(lambda b: b.mass), 0.0)
        self._body_inverse_inertia = inverse_inertia(self.inertia, self.constraint, self.axle)
        R = matrices(self.q)
        body_spin = apply_transposed(R, stack(lambda b: b.spin))
        self.L = apply(R, self.inertia * body_spin)
        self.at_rest = bool((self.constraint == STATIC).all())
        self._splitting = splitting_table(self.inertia, self.constraint, self.axle)
        counts = [len(b.local) for b in members]
        self._first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._owner = np.repeat(np.arange(len(members)), counts).astype(np.int32)
        self._table = np.concatenate([np.column_stack([b.masses, b.local, b.normals, 0 * b.masses]) for b in members])
        rows = system.state.channels
        self._rows = np.array([rows.get(k, -1) for k in ("normal_x", "normal_y", "normal_z", "shade")], np.int32)
        lamp = np.array(values["lamp"], float)
        self._lamp = lamp / norm(lamp)
        self._check(system)
        self._update_derived()
        self.joints: JointSet | None = None
        if values["joints"]:
            self.joints = JointSet(joints_of(values["joints"], members), self)
        self.contacts = ContactSet(self, colliders, values, dt)
        self.displacement: np.ndarray | None = None
        self.collider_impulses: dict[str, tuple[np.ndarray, float]] = {}
        if system.state.count:
            if self.joints is not None:
                self.joints.check_start(system.name)
            self.contacts.detect(0.0)
            self.contacts.refuse_overlaps(system.name)
            self._write_particles(system.state, True)

    def _check(self, system) -> None:
        state = system.state
        n = state.count
        if n == 0:  # a snapshot is being restored: the particles come later
            return
        if n != len(self._owner):
            raise UsageError(f"system '{system.name}' has {n} particles, but its bodies have {len(self._owner)}")
        lifetime = state.floats[LIFETIME, :n]
        if state.may_die and (np.isfinite(lifetime) & ~fixed_lifetimes(lifetime)).any():
            raise UsageError(f"rigid bodies do not die: leave out the lifetime of system '{system.name}'")

    def _update_derived(self) -> None:
        """Update rotation matrices, inverse inertia and spins from attitudes and angular momenta."""
        self.R = matrices(self.q)
        self.inverse_inertia = compose(compose(self.R, self._body_inverse_inertia), transposed(self.R))
        self.w = apply(self.inverse_inertia, self.L)

    @property
    def saved_arrays(self) -> dict[str, np.ndarray]:
        joints = {"joints": self.joints.forces} if self.joints is not None else {}
        return {"x": self.x, "q": self.q, "v": self.v, "L": self.L, **joints, **self.contacts.saved_arrays}

    def restore_arrays(self, saved_arrays: dict[str, np.ndarray], time: float) -> None:
        self.x, self.q, self.v, self.L = (saved_arrays[k].copy() for k in ("x", "q", "v", "L"))
        self._update_derived()
        if self.joints is not None:
            self.joints.forces = saved_arrays["joints"].copy()
        self.contacts.restore_arrays(saved_arrays)
        self.contacts.detect(time)

    def shapes(self) -> Shapes:
        """The parts of all bodies where they are now."""
        parts = [(k, part) for k, body in enumerate(self.members) for part in body.parts]
        owner = np.array([k for k, _ in parts])
        R = self.R[owner]
        arm = apply(R, np.array([part.center for _, part in parts]))
        return Shapes(
            particle=self._first[owner],
            center=self.x[owner] + arm,
            half=np.array([part.half for _, part in parts]),
            radius=np.array([part.radius for _, part in parts]),
            axes=transposed(compose(R, np.array([part.axes for _, part in parts]))),
            velocity=self.v[owner] + np.cross(self.w[owner], arm),
            spin=self.w[owner],
        )

    def disturb(self, share: float, push: np.ndarray) -> None:
        """Move the velocities of free bodies towards `push`, m/s, by a share, and lessen their angular momenta by it."""
        free, turning = self.constraint == FREE, self.constraint != STATIC
        self.v[free] = (1 - share) * self.v[free] + share * push
        self.L[turning] *= 1 - share
        self._update_derived()

    def _frames(self) -> np.ndarray:
        return np.concatenate([self.x, self.R.reshape(-1, 9), self.v, self.w], 1)

    def _write_particles(self, state, moves: bool) -> None:
        _, put = particle_kernels(self.precision)
        put(state.floats, self._table, self._frames(), self._owner, self._lamp, self._rows, int(moves))

    def solve(self, state, stage) -> None:
        """Collect what forces gave the particles since their velocities were stage.old, and add the impulses of contacts."""
        if self.at_rest:
            return
        gained = np.zeros((len(self.members), 6))
        gather, _ = particle_kernels(self.precision)
        gather(state.floats, np.ascontiguousarray(stage.old), self._table, self._frames(), self._first, gained)
        v, w = self.v, self.w
        self.v = v + gained[:, :3] * self.inverse_mass[:, None]
        self.L = self._allowed(self.L + gained[:, 3:])
        self._update_derived()
        if self.joints is None:
            self.collider_impulses = self.contacts.solve(v, w, stage)
        else:
            self.collider_impulses = self._solve_with_joints(v, w, stage)
        if stage.with_ledger or not stage.drift:
            self._write_particles(state, False)

    def _solve_with_joints(self, v: np.ndarray, w: np.ndarray, stage) -> dict[str, tuple[np.ndarray, float]]:
        """Impulses of contacts, which joints pass on, then those of the joints; entries of the ledger by name."""
        joints = self.joints
        assert joints is not None
        joints.prepare(stage)
        entries = self.contacts.solve(v, w, stage)
        joints.solve(stage, np.concatenate([v, w], 1))
        return {**entries, **joints.entries}

    def moved(self, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Places (b, 3) and rotation matrices (b, 3, 3) after a drift of h, s, with the present velocities."""
        x, q = self._moved(h)
        return x, matrices(q)

    def _moved(self, h: float) -> tuple[np.ndarray, np.ndarray]:
        """Places and attitudes (b, 4) after a drift of h, s."""
        x, q = self.x + h * self.v, self.q.copy()
        if self.displacement is not None:
            x, q = x + self.displacement[:, :3], product(rotation(self.displacement[:, 3:]), q)
        rotation_kernel()(q, self.L, self._splitting, self.axle, h, MAX_ANGLE)
        return x, q

    def particle_displacement(self) -> np.ndarray | float:
        """(3, n) m, how far the coming drift moves the particles beside their velocities; or 0."""
        if self.displacement is None:
            return 0.0
        arm = apply(self.R[self._owner], self._table[:, _POSITION])
        by = self.displacement[self._owner]
        return (by[:, :3] + cross(by[:, 3:], arm)).T

    def apply_impulse(self, P: np.ndarray, L: np.ndarray) -> None:
        """Apply impulses (b, 3), N s, and angular impulses (b, 3), N m s, about the origins."""
        self.set_motion(self.v, self.L, np.concatenate([P, L], 1))

    def set_motion(self, v: np.ndarray, L: np.ndarray, P: np.ndarray, only_to_drift: bool = False) -> None:
        """Set velocities and angular momenta to v and L, (b, 3), changed by impulses and angular impulses P (b, 6).

        only_to_drift : leave the spins as they are; a drift does not need them
        """
        self.v = v + P[:, :3] * self.inverse_mass[:, None]
        self.L = self._allowed(L + P[:, 3:])
        if not only_to_drift:
            self._update_derived()

    def _allowed(self, L: np.ndarray) -> np.ndarray:
        """The part of an angular momentum (b, 3) that the bodies' constraints allow."""
        if not self.constraint.any():
            return L
        axle = apply(self.R, self.axle)
        L = np.where((self.constraint == AXLED)[:, None], axle * dot(axle, L)[:, None], L)
        L[self.constraint == STATIC] = 0.0
        return L

    def drift(self, state, stage) -> None:
        """Move the bodies with their present velocities, and find the contacts at their new positions."""
        if self.at_rest:
            return
        self.x, self.q = self._moved(stage.drift)
        self._update_derived()
        self._write_particles(state, True)
        self.contacts.detect(stage.time + stage.dt)
