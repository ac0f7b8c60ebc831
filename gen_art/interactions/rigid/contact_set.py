"""Contacts of the bodies of one system, with each other and with colliders: where they are, and the impulses they give."""

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.rigid.body import STATIC
from gen_art.interactions.rigid.collider_contacts import RigidColliders, probe_points
from gen_art.interactions.rigid.collision_detection import MAX_FEATURES, Shapes, detect_contacts, pair_key
from gen_art.interactions.rigid.contact_solver import ContactSolver
from gen_art.interactions.rigid.small_matrices import apply, compose, dot, norm

__all__ = ["ContactSet"]

_SPEED_MARGIN = 1.2  # contacts are searched for as if speeds could grow by this factor within a step
_SIZE_MARGIN = 0.01  # relative to a shape's size: what is nearer is always a candidate
_OVERLAP = 1e-4  # relative to the smaller body's size, tolerated at the start


class ContactSet:
    """The contacts found last, with the impulses of the last solve, which are the first guess of the next one."""

    def __init__(self, world, colliders, values: dict, dt: float):
        self.world, self.dt = world, dt
        self.colliders = RigidColliders(colliders)
        self.iterations = values["iterations"]
        bodies = len(world.members)
        shapes = [(b, part) for b, member in enumerate(world.members) for part in member.parts]
        shapes += [(bodies + k, part) for k, part in self.colliders.solids]
        self._body = np.array([b for b, _ in shapes], int)  # colliders are numbered after the bodies
        self._kind = np.array([p.kind for _, p in shapes], int)
        self._half = np.array([p.half for _, p in shapes]).reshape(-1, 3)
        self._radius = np.array([p.radius for _, p in shapes])
        self._center = np.array([p.center for _, p in shapes]).reshape(-1, 3)
        self._axes = np.array([p.axes for _, p in shapes]).reshape(-1, 3, 3)
        self._size = 2 * self._radius + 2 * np.where(self._half > 0, self._half, 0).max(1, initial=0.0)
        static = np.concatenate([world.constraint == STATIC, np.ones(len(self.colliders.members), bool)])
        self._movable = ~static[self._body]
        moving = [k for k, (b, _) in enumerate(shapes) if b < bodies and not static[b]]
        points = [probe_points(shapes[k][1], self.colliders.flat) for k in moving]
        self._probe_shape = np.repeat(np.array(moving, int), [len(p) for p in points])
        self._probes = np.concatenate(points) if points else np.zeros((0, 3))
        # farthest point of each shape from its body's origin
        self._extent = np.array([norm(p.center) + norm(p.half) + p.radius for _, p in shapes])
        # restitution, kinetic and static friction: first between two bodies, then with each collider
        between_bodies = np.array([[values["restitution"], *values["friction"]]])
        with_colliders = np.column_stack([self.colliders.restitution, self.colliders.friction])
        self.materials = np.concatenate([between_bodies, with_colliders])
        # pairs of bodies that a joint joins, which do not collide with each other
        pairs = world.joints.pairs if world.joints else ()
        self._joined = np.array(sorted(pair_key(one, other) for one, other in pairs), np.int64)
        self._keys = np.zeros(0, np.int64)
        self._forces = np.zeros((0, 3))

    @property
    def saved_arrays(self) -> dict[str, np.ndarray]:
        return {"keys": self._keys, "impulses": self._forces}

    def restore_arrays(self, saved_arrays) -> None:
        self._keys, self._forces = saved_arrays["keys"].copy(), saved_arrays["impulses"].copy()

    def _shapes(self, time: float) -> Shapes:
        world, bodies = self.world, len(self.world.members)
        b = np.minimum(self._body, bodies - 1)
        center = world.x[b] + apply(world.R[b], self._center)
        axes = compose(world.R[b], self._axes)
        fixed = np.flatnonzero(self._body >= bodies)
        if len(fixed):
            center[fixed] = self._center[fixed] + self.colliders.velocity[self._body[fixed] - bodies] * time
            axes[fixed] = self._axes[fixed]
        return Shapes(self._kind, self._body, self._half, self._radius, center, axes)

    def _margins(self) -> np.ndarray:
        """(s,) m, the distance from each shape within which another can touch it in the next step."""
        bodies = len(self.world.members)
        b = np.minimum(self._body, bodies - 1)
        speed = norm(self.world.v[b]) + norm(self.world.w[b]) * self._extent
        margin = _SPEED_MARGIN * self.dt * speed + _SIZE_MARGIN * self._size
        fixed = self._body >= bodies
        margin[fixed] = self.dt * norm(self.colliders.velocity[self._body[fixed] - bodies])
        return margin

    def _probe_contacts(self, time: float, margin: np.ndarray):
        """Contacts with the colliders that are no shapes: probe point (k,), surface (k,), position (k, 3), normal, gap (k,)."""
        shape = self._probe_shape
        body = self._body[shape]
        points = self.world.x[body] + apply(self.world.R[body], self._probes)
        distance, normals = self.colliders.distances(points, time)
        gap = distance - self._radius[shape][:, None]
        fastest = self.dt * norm(self.colliders.velocity).max(initial=0.0)
        p, s = np.nonzero(gap < (margin[shape] + fastest)[:, None])
        g, n = gap[p, s], normals[p, s]
        return p, s, points[p] - (self._radius[shape[p]] + 0.5 * g)[:, None] * n, n, g

    def detect(self, time: float) -> None:
        """Find the contacts at the bodies' present positions, at `time`, s."""
        bodies, margin = len(self.world.members), self._margins()
        found = detect_contacts(self._shapes(time), margin, self._movable, self._joined)
        p, s, point, normal, gap = self._probe_contacts(time, margin)
        first, second = self._body[found.first], self._body[found.second]
        shape = self._probe_shape[p]
        self.first = np.concatenate([np.where(first < bodies, first, -1), self._body[shape]]).astype(np.int32)
        self.second = np.concatenate([np.where(second < bodies, second, -1), np.full(len(p), -1)]).astype(np.int32)
        solid = np.maximum(first, second) - bodies
        self.collider = np.concatenate([np.where(solid >= 0, solid, -1), self.colliders.owner[s]]).astype(int)
        self.point = np.concatenate([found.point, point])
        self.normal = np.concatenate([found.normal, normal])
        self.gap = np.concatenate([found.gap, gap])
        probe_keys = MAX_FEATURES * len(self._kind) ** 2 + p * len(self.colliders.owner) + s
        self.key = np.concatenate([found.key, probe_keys])
        smaller = np.minimum(self._size[found.first], self._size[found.second])
        self.sizes = np.concatenate([smaller, self._size[shape]])

    def refuse_overlaps(self, name: str) -> None:
        """Raise UsageError with the names of two bodies, or a body and a collider, that overlap."""
        deep = self.gap + _OVERLAP * self.sizes
        if not len(deep) or deep.min() >= 0:
            return
        k = int(deep.argmin())
        met = [f"body {b + 1} ('{self.world.members[b].name}')" for b in (self.first[k], self.second[k]) if b >= 0]
        if self.collider[k] >= 0:
            met.append(f"the {self.colliders.members[self.collider[k]].name}")
        raise UsageError(
            f"system '{name}': {' and '.join(met)} overlap by {-self.gap[k]:.3g} m at the start: move them apart"
        )

    def solve(self, v: np.ndarray, w: np.ndarray, stage) -> dict[str, tuple[np.ndarray, float]]:
        """Give the bodies the impulses of this part of the step; v, w (b, 3): velocity and spin before the forces' kick.

        Returns each collider's impulse, N s, and its work, J, by name.
        """
        self.world.displacement = None
        if not len(self.gap):
            self._keys, self._forces = np.zeros(0, np.int64), np.zeros((0, 3))
            return {}
        solver = ContactSolver(self, v, w, stage)
        start = self._last_forces() * stage.kick
        impulses = solver.impulses(start)
        if stage.drift > 0:
            self.world.displacement = solver.overlap_correction()
        before = self.world.v, self.world.w
        self._keys = self.key
        # forces, because the next solve may be over another length of time
        self._forces = np.where(solver.bounces[:, None], 0.0, impulses) / stage.kick
        given = solver.apply(impulses) * solver.sign
        delays = solver.delays(*before)
        if delays is not None:
            self.world.displacement = delays if self.world.displacement is None else self.world.displacement + delays
        out: dict[str, tuple[np.ndarray, float]] = {}
        for c in np.unique(self.collider[self.collider >= 0]):
            total = given[self.collider == c].sum(0)
            out[self.colliders.names[c]] = (total, float(dot(total, self.colliders.velocity[c])))
        return out

    def _last_forces(self) -> np.ndarray:
        """The forces, N, that the same contacts had in the last solve; 0 for new contacts."""
        out = np.zeros((len(self.key), 3))
        if len(self._keys):
            order = np.argsort(self._keys, kind="stable")
            at = np.minimum(np.searchsorted(self._keys[order], self.key), len(order) - 1)
            known = self._keys[order[at]] == self.key
            out[known] = self._forces[order[at[known]]]
        return out
