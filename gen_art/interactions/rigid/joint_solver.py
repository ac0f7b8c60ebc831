"""The impulses of joints: RATTLE, with the exact free motion of the bodies between its two halves.

Before a drift, impulses along the rows at the start of the drift bring the bodies to places where every row holds, by Newton's
method with the matrix of the start; after the last kick, they take away the speeds along the rows. The scheme is symplectic, of
order 2 and reversible. Bounds and motors are rows whose impulses have a sign or a largest size.
Source: Andersen (1983), J. Comput. Phys. 52, 24; Leimkuhler & Reich, Simulating Hamiltonian Dynamics, chapters 7 and 8.
"""

import math

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.rigid import contact_columns as col
from gen_art.interactions.rigid.joint import ANGLE, DISTANCE, DOT, POINT, SLIDE, Joint
from gen_art.interactions.rigid.joint_kernels import joint_kernels
from gen_art.interactions.rigid.small_matrices import apply, cross, dot, norm
from gen_art.maths.array_functions import arctan2

__all__ = ["JointSet"]

_TOLERANCE = (
    1e-13  # relative to the size of the first body, and to 1 rad: Newton's method ends when every row holds so well
)
_ENOUGH = 1e-9  # the same, where rounding keeps it from more
_NEWTON = 80  # steps of Newton's method
_TOUCHES = 1e-9  # relative to the size of the first body, and to 1 rad: nearer to a bound than that, a row is at it


class JointSet:
    """The joints of one system.

    pairs : the pairs of bodies that are joined, which do not collide with each other
    jointed : (b,), whether a body has a joint
    forces : (m,) N or N m, along the rows in the last solve: the first guess while contacts and joints are solved in turn
    entries : by joint, the impulse of the world on the bodies, N s, and the motor's work, J, in the last solve
    """

    def __init__(self, joints: list[Joint], world):
        self.joints, self.world = joints, world
        bodies = len(world.members)
        self.pairs = {(j.first, j.second) for j in joints if j.second >= 0}
        self.jointed = np.zeros(bodies + 1, bool)
        self.jointed[[end for j in joints for end in (j.first, j.second)]] = True
        self.entries: dict[str, tuple[np.ndarray, float]] = {}
        held = [(k, row) for k, j in enumerate(joints) for row in j.held]
        free = [(k, j.free) for k, j in enumerate(joints) if j.free is not None and j.bounds is not None]
        motors = [(k, j.free) for k, j in enumerate(joints) if j.free is not None and j.speed is not None]
        rows = held + free + free + motors  # held, low bounds, high bounds, motors
        self._held, self._bounds, self._motors = len(held), len(free), len(motors)
        self._owner = np.array([k for k, _ in rows], int)
        self._kind = np.array([row.kind for _, row in rows], np.int64)
        self._s, self._t, self._origin = (
            np.array([getattr(row, key) for _, row in rows]).reshape(-1, 3) for key in ("s", "t", "origin")
        )
        self._anchors = [np.array([joints[k].anchors[side] for k in self._owner]).reshape(-1, 3) for side in (0, 1)]
        self._length = np.array([joints[k].length for k in self._owner])
        ends = [[joints[k].first for k in self._owner], [joints[k].second for k in self._owner]]
        self._first, self._second = (np.array([bodies if b < 0 else b for b in end], np.int32) for end in ends)
        self._low, self._high = np.array([joints[k].bounds for k, _ in free], float).reshape(-1, 2).T
        self._speed = np.array([joints[k].speed for k, _ in motors], float)
        self._limit = np.array([joints[k].limit for k, _ in motors])
        sizes = np.array([world.members[joints[k].first].reach for k in self._owner])
        self._scale = np.where((self._kind == DOT) | (self._kind == ANGLE), 1.0, sizes)
        m, n = len(rows), len(rows) - len(held)
        self._K, self._F, self._P = np.zeros((m, m)), np.zeros((m, m)), np.zeros(m, np.int32)
        self._Y, self._S = np.zeros((n + 1, max(m, 1))), np.zeros((n + 1, n + 1))
        self.forces = np.zeros(m)

    # -- the rows

    def _placed(self, x: np.ndarray, R: np.ndarray):
        """Places and rotation matrices with those of the world added at the end."""
        return np.concatenate([x, np.zeros((1, 3))]), np.concatenate([R, np.eye(3)[None]])

    def _values(self, x: np.ndarray, R: np.ndarray, derivatives: bool = False):
        """The rows' values (m,), m or rad; with `derivatives` also those by places and turns of the two bodies, (m, 6) each."""
        x, R = self._placed(x, R)
        a, b, kind = self._first, self._second, self._kind
        Ra, Rb = R[a], R[b]
        arm_a, arm_b = apply(Ra, self._anchors[0]), apply(Rb, self._anchors[1])
        d = x[a] + arm_a - (x[b] + arm_b)
        s, t = apply(Ra, self._s), apply(Rb, self._t)
        length = norm(d)
        n = np.where((kind == POINT)[:, None], self._t, t)
        stretched = kind == DISTANCE
        if stretched.any():
            n = np.where(stretched[:, None], d / np.where(length > 0, length, 1.0)[:, None], n)
        value = dot(d, n)
        value = np.where(stretched, length - self._length, value)
        turning = kind == DOT
        if turning.any():
            value = np.where(turning, dot(s, t), value)
        angles = kind == ANGLE
        if angles.any():
            origin = apply(Rb, self._origin)
            value = np.where(angles, arctan2(dot(t, cross(origin, s)), dot(origin, s)), value)
        if not derivatives:
            return value
        linear = (~(turning | angles))[:, None]
        lever_b = np.where((kind == SLIDE)[:, None], arm_b + d, arm_b)
        turn = np.where(turning[:, None], cross(s, t), t)
        J1 = np.concatenate([np.where(linear, n, 0.0), np.where(linear, cross(arm_a, n), turn)], 1)
        J2 = -np.concatenate([np.where(linear, n, 0.0), np.where(linear, cross(lever_b, n), turn)], 1)
        return value, J1, J2

    def _prepare(self) -> np.ndarray:
        """Rows, matrix and factors at the bodies' present places; returns the rows' values."""
        world, bodies = self.world, len(self.world.x)
        value, self._J1, self._J2 = self._values(world.x, world.R, True)
        B = np.zeros((bodies + 1, col.BODY_COLUMNS))
        B[:bodies, col.INVERSE_MASS] = world.inverse_mass
        B[:bodies, col.INVERSE_INERTIA :] = world.inverse_inertia.reshape(-1, 9)
        factor, _ = joint_kernels()
        factor(B, self._first, self._second, self._J1, self._J2, self._K, self._F, self._P, self._held)
        return value

    def _speeds(self, V: np.ndarray) -> np.ndarray:
        """The speeds along the rows, m/s or rad/s, of velocities and spins V (b, 6)."""
        V = np.concatenate([V, np.zeros((1, 6))])
        Va, Vb = V[self._first], V[self._second]
        return (dot(self._J1[:, :3], Va[:, :3]) + dot(self._J1[:, 3:], Va[:, 3:])) + (
            dot(self._J2[:, :3], Vb[:, :3]) + dot(self._J2[:, 3:], Vb[:, 3:])
        )

    def _impulses(self, x: np.ndarray) -> np.ndarray:
        """Impulses and angular impulses (b, 6) of the rows' impulses x (m,)."""
        out = np.zeros((len(self.world.x) + 1, 6))
        np.add.at(out, self._first, self._J1 * x[:, None])
        np.add.at(out, self._second, self._J2 * x[:, None])
        return out[:-1]

    def _solve(self, r: np.ndarray, low: np.ndarray, high: np.ndarray, x: np.ndarray) -> None:
        _, solve = joint_kernels()
        if len(x):
            solve(self._K, self._F, self._P, self._Y, self._S, r, low, high, x, self._held)

    def check_start(self, name: str) -> None:
        """Raise UsageError for joints of system `name` that contradict each other, or do not fit, where the bodies are."""
        self._prepare()
        diagonal, needed = self._F.diagonal()[: self._held], self._K.diagonal()[: self._held]
        for k in range(self._held):
            if diagonal[k] == 0.0:
                joint = self.joints[self._owner[k]]
                raise UsageError(
                    f"system '{name}': joint '{joint.name}' holds what is held already{' by the others' * bool(needed[k])}: "
                    "leave it out, or use a joint that holds less, such as ball for hinge"
                )
        V = np.concatenate([self.world.v, self.world.w], 1)
        speeds = np.abs(self._speeds(V))[: self._held]
        fastest = max(float(np.abs(V).max(initial=0.0)), 1e-300)
        if self._held and speeds.max() > 1e-6 * fastest * max(1.0, float(self._scale.max())):
            joint = self.joints[self._owner[int(speeds.argmax())]]
            raise UsageError(
                f"system '{name}': the bodies of joint '{joint.name}' start with velocities that pull it apart, by "
                f"{speeds.max():.3g} m/s or rad/s: give both bodies the velocities of a motion that the joint allows"
            )

    # -- solves

    def prepare(self, stage) -> None:
        """Make the rows ready for `project` and `solve`, at the bodies' present places."""
        self._value = value = self._prepare()
        m, held, bounds = len(self._kind), self._held, self._bounds
        self._lower, self._upper = slice(held, held + bounds), slice(held + bounds, held + 2 * bounds)
        self._motor = slice(held + 2 * bounds, m)
        self._least, self._most = np.full(m, -math.inf), np.full(m, math.inf)  # of the impulses
        self._room = np.zeros(m)  # m/s or rad/s, minus the speed that a row may have
        self._room[self._motor] = -self._speed
        self._least[self._motor], self._most[self._motor] = -self._limit * stage.kick, self._limit * stage.kick
        self._least[self._lower], self._most[self._upper] = 0.0, 0.0
        to_low, to_high = value[self._lower] - self._low, value[self._upper] - self._high
        if stage.drift > 0:
            self._room[self._lower], self._room[self._upper] = to_low / stage.drift, to_high / stage.drift
        else:  # only what is at a bound feels it
            touch = _TOUCHES * self._scale
            self._most[self._lower] = np.where(to_low <= touch[self._lower], math.inf, 0.0)
            self._least[self._upper] = np.where(to_high >= -touch[self._upper], -math.inf, 0.0)

    def first_guess(self, kick: float) -> tuple[np.ndarray, np.ndarray]:
        """The change of velocities and spins (b, 6) by the forces of the last solve over `kick`, s, and their impulses (m,)."""
        x = np.clip(self.forces * kick, self._least, self._most)
        return self._response(x), x

    def _response(self, x: np.ndarray) -> np.ndarray:
        P, world = self._impulses(x), self.world
        return np.concatenate([P[:, :3] * world.inverse_mass[:, None], apply(world.inverse_inertia, P[:, 3:])], 1)

    def project(self, V: np.ndarray, before: np.ndarray, place_only: bool) -> tuple[np.ndarray, np.ndarray]:
        """The change of V (b, 6) by impulses that give the rows the speeds they may have, and all impulses so far (m,).

        before : the impulses that V has already
        place_only : V are displacements, which motors and bounds leave as they are
        """
        x, r, none = before.copy(), self._speeds(V), np.zeros(len(self._kind))
        if place_only:
            self._solve(r, none, none, x)
        else:
            self._solve(r + self._room, self._least, self._most, x)
        return self._response(x - before), x

    def solve(self, stage, V0: np.ndarray) -> None:
        """Give the bodies the joints' impulses of this part of the step.

        V0 : (b, 6) velocities and spins before the forces' kick, for the motors' work
        Raises UsageError where no impulse keeps the joints together.
        """
        world, x = self.world, np.zeros(len(self._kind))
        if stage.drift > 0:
            self._meet_after_drift(stage, x)
        else:
            v, L = world.v, world.L
            for _ in range(2):  # the second takes away what rounding left
                r = self._speeds(np.concatenate([world.v, world.w], 1)) + self._room
                self._solve(r, self._least, self._most, x)
                world.set_motion(v, L, self._impulses(x))
        self.forces = x / stage.kick
        self._record(x, V0)

    def _meet_after_drift(self, stage, x: np.ndarray) -> None:
        """Newton's method for impulses x that let every row hold after the drift."""
        world, h = self.world, stage.drift
        lower, upper, motor = self._lower, self._upper, self._motor
        v, L = world.v, world.L
        speeds = self._speeds(np.concatenate([v, world.w], 1))[motor] - self._speed
        mobility = np.maximum(self._K.diagonal(), 1e-300)
        last = math.inf
        for _ in range(_NEWTON):
            value = self._values(*world.moved(h))
            r = value / h
            r[lower] = (value[lower] - self._low) / h
            r[upper] = (value[upper] - self._high) / h
            r[motor] = speeds + (self._K[motor] * x).sum(1)
            # what is left in rows whose impulse may still change
            left = np.abs(x - np.clip(x - r / mobility, self._least, self._most)) * mobility * h / self._scale
            error = float(left.max(initial=0.0))
            if error <= _TOLERANCE or (error <= _ENOUGH and error > 0.5 * last):
                world.set_motion(v, L, self._impulses(x))
                return
            if not math.isfinite(error):
                break
            last = error
            self._solve(r, self._least, self._most, x)
            world.set_motion(v, L, self._impulses(x), only_to_drift=True)
        joint = self.joints[self._owner[int(np.nan_to_num(left, nan=math.inf).argmax())]]
        raise UsageError(
            f"joint '{joint.name}' cannot be kept together at {stage.time:g} s: joints or contacts ask for what cannot be, or "
            f"the step of {stage.dt:g} s is too long for the speed there"
        )

    def _record(self, x: np.ndarray, V0: np.ndarray) -> None:
        """Store the entries of the ledger: a force works with the mean of the speeds before and after."""
        world = self.world
        mean = 0.5 * (self._speeds(V0) + self._speeds(np.concatenate([world.v, world.w], 1)))
        self.entries = {}
        for k, joint in enumerate(self.joints):
            mine = self._owner == k
            impulse = np.zeros(3) if joint.second >= 0 else (self._J1[mine, :3] * x[mine, None]).sum(0)
            mine[: self._motor.start] = False
            if joint.second < 0 or mine.any():
                self.entries[joint.name] = (impulse, float((x[mine] * mean[mine]).sum()))
