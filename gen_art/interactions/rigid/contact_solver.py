"""The impulses of all contacts of one system at one moment.

Before a drift, no gap may close within the drift, and what arrives fast leaves at once with restitution times its speed. At
the end of a step, bodies that touch must not approach each other. Overlaps, which bodies that spin against each other build up
slightly, are removed slowly, by displacements that give no speed. With friction or several contacts at once, the speeds that
restitution gives can gain energy: the impulses are then scaled back towards the inelastic ones until none is gained.
"""

import numpy as np

from gen_art.interactions.rigid import contact_columns as col
from gen_art.interactions.rigid.body_kernels import contact_kernel
from gen_art.interactions.rigid.small_matrices import apply, apply_transposed, cross, dot, norm

__all__ = ["ContactSolver"]

_OVERLAP = 5e-3  # relative to the smaller body's size: overlaps up to this are not corrected
_CORRECTION = 0.1  # the part of a deeper overlap's excess that one step removes
_TOLERANCE = 1e-8  # relative to the largest speed: the sweeps end when they change no speed by more
_PAIRS_BETWEEN_JOINTS = 8  # pairs of sweeps over the contacts before the joints pass their impulses on

# columns of C as slices
_ARM_A = slice(col.ARM_A, col.ARM_A + 3)
_ARM_B = slice(col.ARM_B, col.ARM_B + 3)
_FRAME = slice(col.FRAME, col.FRAME + 9)
_IMPULSE = slice(col.IMPULSE, col.IMPULSE + 3)
_SURFACE_SPEED = slice(col.SURFACE_SPEED, col.SURFACE_SPEED + 3)


class ContactSolver:
    """Solves for the impulses of a ContactSet. Impulses are (k, 3): along the normal and two tangents.

    v, w (b, 3): velocities and spins before the forces' kick
    stage: the part of the step
    bounces (k,): the contacts that bounce
    sign (k, 1): -1 where the first of the pair is a collider, else 1
    """

    def __init__(self, contacts, v: np.ndarray, w: np.ndarray, stage):
        self._contacts, self._world = contacts, contacts.world
        world, k = contacts.world, len(contacts.gap)
        n = contacts.normal
        axis = np.zeros((k, 3))
        axis[np.arange(k), np.abs(n).argmin(1)] = 1.0
        tangent = cross(n, axis)
        tangent /= norm(tangent)[:, None]
        self._frame = np.stack([n, tangent, cross(n, tangent)], 1)
        first, second = contacts.first, contacts.second
        self._a, self._b = np.maximum(first, 0), np.maximum(second, 0)
        self._has_a, self._has_b = (first >= 0)[:, None], (second >= 0)[:, None]
        self._arm_a = np.where(self._has_a, contacts.point - world.x[self._a], 0.0)
        self._arm_b = np.where(self._has_b, contacts.point - world.x[self._b], 0.0)
        self.sign = np.where(self._has_a, 1.0, -1.0)
        self._surface_velocity = np.zeros((k, 3))
        met = contacts.collider >= 0
        self._surface_velocity[met] = contacts.colliders.velocity[contacts.collider[met]] * self.sign[met]
        self._kick = stage.kick
        self._set_targets(v, w, stage)

    def _contact_velocities(self, v, w):
        """The velocities of the two bodies at each contact, (k, 3) each."""
        first = np.where(self._has_a, v[self._a] + cross(w[self._a], self._arm_a), 0.0)
        return first, np.where(self._has_b, v[self._b] + cross(w[self._b], self._arm_b), 0.0)

    def _relative_velocity(self, v, w):
        first, second = self._contact_velocities(v, w)
        return first - second - self._surface_velocity

    def _set_targets(self, v, w, stage) -> None:
        """Set each contact's least speed along the normal, without bounces and with them, and its friction coefficient."""
        world, contacts, n = self._world, self._contacts, self._contacts.normal
        was, now = self._contact_velocities(v, w), self._contact_velocities(world.v, world.w)
        self._before = was[0] - was[1] - self._surface_velocity
        self._after = now[0] - now[1] - self._surface_velocity
        w0, w1 = dot(self._before, n), dot(self._after, n)
        restitution, kinetic, static = contacts.materials[contacts.collider + 1].T
        steps_per_kick = stage.dt / stage.kick
        # summed over both bodies: the same force may press both against a third body
        pressing = steps_per_kick * sum(np.abs(dot(b - a, n)) for a, b in zip(was, now))
        fast = (-restitution * w0 > pressing) & (w0 < 0)
        span = stage.drift if stage.drift > 0 else stage.dt
        self._inelastic = -np.maximum(contacts.gap, 0.0) / span
        self._lone, self._wait = np.zeros(len(w0), bool), np.zeros(len(w0))
        if stage.drift > 0:
            self.bounces = fast & (contacts.gap + span * w1 < 0)
            self._find_lone_impacts(w1, stage)
            w0 = dot(self._before, n)
            self._elastic = np.where(self.bounces, w1 - (1 + restitution) * w0, self._inelastic)
        else:
            self.bounces = fast
            # it bounces in the next step, with its restitution
            self._inelastic = np.where(fast, col.NO_TARGET, self._inelastic)
            self._elastic = self._inelastic
        slide = self._before - w0[:, None] * n
        change = steps_per_kick * sum(norm(b - a) for a, b in zip(was, now))
        self._friction = np.where(dot(slide, slide) <= change**2, static, kinetic)

    def _find_lone_impacts(self, w1: np.ndarray, stage) -> None:
        """Find the time of impact of balls without joints that touch nothing but one collider, and their speed at that time.

        All other bodies bounce where they are: other shapes rotate before they arrive, and an eccentric impact spins them.

        _lone (k,): such contacts
        _wait (k,): s, from the start of the drift to the impact
        """
        contacts, bodies = self._contacts, len(self._world.members)
        first, second = contacts.first, contacts.second
        touched = np.bincount(first[first >= 0], minlength=bodies) + np.bincount(second[second >= 0], minlength=bodies)
        alone = touched[np.maximum(first, second)] == 1
        levers = sum(np.abs(cross(arm, contacts.normal)).max(1) for arm in (self._arm_a, self._arm_b))
        central = levers <= 1e-9 * contacts.sizes
        if self._world.joints is not None:
            alone &= ~self._world.joints.jointed[np.maximum(first, second)]
        self._lone = self.bounces & alone & central & (contacts.collider >= 0) & (contacts.gap > 0)
        self._wait[self._lone] = -contacts.gap[self._lone] / w1[self._lone]
        self._before += (self._wait / stage.kick)[:, None] * (self._after - self._before)

    def delays(self, v: np.ndarray, w: np.ndarray) -> np.ndarray | None:
        """Displacements, m and rad, (b, 6), that let v and w (b, 3) from before the impulses last until the impact; or None."""
        if not self._lone.any():
            return None
        world, out = self._world, np.zeros((len(v), 6))
        k = np.flatnonzero(self._lone)
        b = np.maximum(self._contacts.first, self._contacts.second)[k]
        out[b] = self._wait[k, None] * np.concatenate([v - world.v, w - world.w], 1)[b]
        return out

    def _solve(self, target: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Impulses for the target speeds, and their changes of the velocities at the contacts, both (k, 3)."""
        world = self._world
        C = self._contact_array(target)
        C[:, col.FRICTION], C[:, _IMPULSE] = self._friction, start
        C[:, _SURFACE_SPEED] = apply(self._frame, self._surface_velocity)
        V = self._sweep(C, np.concatenate([world.v, world.w], 1))
        change = self._relative_velocity(V[:, :3], V[:, 3:]) - self._after
        return C[:, _IMPULSE], apply(self._frame, change)

    def _contact_array(self, target: np.ndarray) -> np.ndarray:
        C = np.zeros((len(target), col.CONTACT_COLUMNS))
        C[:, _ARM_A], C[:, _ARM_B] = self._arm_a, self._arm_b
        C[:, _FRAME], C[:, col.TARGET_SPEED] = self._frame.reshape(-1, 9), target
        return C

    def _sweep(self, C: np.ndarray, start: np.ndarray, place_only: bool = False) -> np.ndarray:
        """Velocities and spins (b, 6) after the contacts C have acted on those of `start`; the impulses are left in C.

        place_only : they are displacements
        """
        contacts, world, bodies = self._contacts, self._world, len(start)
        V, B = np.zeros((bodies + 1, col.VELOCITY_COLUMNS)), np.zeros((bodies + 1, col.BODY_COLUMNS))
        V[:bodies], B[:bodies, col.INVERSE_MASS] = start, world.inverse_mass
        B[:bodies, col.INVERSE_INERTIA :] = world.inverse_inertia.reshape(-1, 9)
        first, second = (np.where(i >= 0, i, bodies).astype(np.int32) for i in (contacts.first, contacts.second))
        target = C[:, col.TARGET_SPEED]
        fastest = float(max(np.abs(V).max(), np.abs(target).max(where=target > 0.1 * col.NO_TARGET, initial=0)))
        D, M = np.zeros((len(C), col.DIRECTION_COLUMNS)), np.zeros((len(C), col.SCRATCH_COLUMNS))
        tolerance = _TOLERANCE * fastest + 1e-300
        if world.joints is None:
            contact_kernel()(B, V, first, second, C, D, M, contacts.iterations, tolerance)
            return V[:bodies]
        joined = V.copy()  # with what the joints have passed on
        change, x = world.joints.first_guess(0.0 if place_only else self._kick)
        joined[:bodies] += change
        for _ in range(contacts.iterations):
            V = joined.copy()
            contact_kernel()(B, V, first, second, C, D, M, _PAIRS_BETWEEN_JOINTS, tolerance)
            change, x = world.joints.project(V[:bodies], x, place_only)
            joined[:bodies] += change
            V[:bodies] += change
            if np.abs(change).max() <= tolerance:
                break
        return V[:bodies]

    def overlap_correction(self) -> np.ndarray | None:
        """Displacements, m and rad, (b, 6), that remove a part of the overlaps; None if there are none."""
        contacts = self._contacts
        deep = np.maximum(-contacts.gap - _OVERLAP * contacts.sizes, 0.0)
        if not deep.any():
            return None
        C = self._contact_array(_CORRECTION * deep - np.maximum(contacts.gap, 0.0))
        return self._sweep(C, np.zeros((len(self._world.v), 6)), place_only=True)

    def impulses(self, start: np.ndarray) -> np.ndarray:
        """The impulses of the contacts, found from the guess `start`."""
        start = np.where(self.bounces[:, None], 0.0, start)
        full, full_change = self._solve(self._elastic, start)
        if self._elastic is self._inelastic or not self.bounces.any():
            return full
        # impulses P gain the energy sum P (before + change / 2), a quadratic on the line from the inelastic ones to `full`
        before = apply(self._frame, self._before)
        gained = (full * (before + 0.5 * full_change)).sum()
        if gained <= 0:
            return full
        least, least_change = self._solve(self._inelastic, start)
        rest, rest_change = full - least, full_change - least_change
        gained_by_least = (least * (before + 0.5 * least_change)).sum()
        slope = (rest * before).sum() + 0.5 * ((least * rest_change).sum() + (rest * least_change).sum())
        curvature = 0.5 * (rest * rest_change).sum()
        allowed = max(gained_by_least, 0.0) - gained_by_least
        if gained <= max(gained_by_least, 0.0) or curvature <= 0:
            return full
        part = (np.sqrt(max(slope * slope + 4 * curvature * allowed, 0.0)) - slope) / (2 * curvature)
        return least + min(max(part, 0.0), 1.0) * rest

    def apply(self, impulses: np.ndarray) -> np.ndarray:
        """Apply the impulses to the bodies. Returns the impulse on the first body of each pair, (k, 3), N s, in world axes."""
        given = apply_transposed(self._frame, impulses)
        P, L = np.zeros_like(self._world.v), np.zeros_like(self._world.v)
        sides = ((self._a, self._has_a, self._arm_a, 1.0), (self._b, self._has_b, self._arm_b, -1.0))
        for body, has_body, arm, sign in sides:
            on = has_body[:, 0]
            np.add.at(P, body[on], sign * given[on])
            np.add.at(L, body[on], sign * cross(arm[on], given[on]))
        self._world.apply_impulse(P, L)
        return given
