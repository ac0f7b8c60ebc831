"""Contacts of the bodies of one system, with each other and with colliders: where they are, and the impulses they give."""

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.rigid.body import STATIC
from gen_art.interactions.rigid.collider_contacts import Walls, probes
from gen_art.interactions.rigid.collision_detection import Shapes, detect_contacts
from gen_art.interactions.rigid.contact_solver import ContactSolver

__all__ = ["ContactSet"]

_REACH = 1.2  # how much faster than now a body may get in a step before its contact is seen too late
_NEAR = 0.01  # and how near to the next thing, in its own size, it is always seen
_OVERLAP = 1e-4  # of the smaller body's size, tolerated at the start


class ContactSet:
    """What touches, from one look to the next, with the impulses of the last solve to start the next one from."""

    def __init__(self, world, colliders, values: dict, dt: float):
        self.world, self.dt = world, dt
        self.walls = Walls(colliders)
        self.most = values["iterations"]
        bodies = len(world.members)
        pairs = [(b, p) for b, one in enumerate(world.members) for p in one.parts]
        pairs += [(bodies + k, p) for k, p in self.walls.solids]
        self._body = np.array([b for b, _ in pairs], int)
        self._kind = np.array([p.kind for _, p in pairs], int)
        self._half = np.array([p.half for _, p in pairs]).reshape(-1, 3)
        self._radius = np.array([p.radius for _, p in pairs])
        self._center = np.array([p.center for _, p in pairs]).reshape(-1, 3)
        self._axes = np.array([p.axes for _, p in pairs]).reshape(-1, 3, 3)
        self._size = 2 * self._radius + 2 * np.where(self._half > 0, self._half, 0).max(1, initial=0.0)
        held = np.concatenate([world.hold == STATIC, np.ones(len(self.walls.colliders), bool)])
        self._movable = ~held[self._body]
        moving = [k for k, (b, _) in enumerate(pairs) if b < bodies and not held[b]]
        points = [probes(pairs[k][1], self.walls.flat) for k in moving]
        self._of_point = np.repeat(np.array(moving, int), [len(p) for p in points])
        self._points = np.concatenate(points) if points else np.zeros((0, 3))
        self._reach = np.array([np.linalg.norm(p.center) + np.linalg.norm(p.half) + p.radius for _, p in pairs])
        # restitution, kinetic and static friction by what is met: first the other bodies, then each collider
        own = np.array([[values["restitution"], *values["friction"]]])
        self.laws = np.concatenate([own, np.column_stack([self.walls.restitution, self.walls.friction])])
        self._keys = np.zeros(0, np.int64)
        self._impulses = np.zeros((0, 3))

    @property
    def saved_arrays(self) -> dict[str, np.ndarray]:
        return {"keys": self._keys, "impulses": self._impulses}

    def restore_arrays(self, saved_arrays) -> None:
        self._keys, self._impulses = saved_arrays["keys"].copy(), saved_arrays["impulses"].copy()

    def _shapes(self, time: float) -> Shapes:
        world, many = self.world, len(self.world.members)
        b = np.minimum(self._body, many - 1)
        center = world.x[b] + np.einsum("sij,sj->si", world.R[b], self._center)
        axes = np.einsum("sij,sjk->sik", world.R[b], self._axes)
        still = np.flatnonzero(self._body >= many)
        if len(still):
            center[still] = self._center[still] + self.walls.velocity[self._body[still] - many] * time
            axes[still] = self._axes[still]
        return Shapes(self._kind, self._body, self._half, self._radius, center, axes)

    def _reaches(self) -> np.ndarray:
        """(s,) m, how far from each shape something may be that touches it in the next step."""
        many = len(self.world.members)
        b = np.minimum(self._body, many - 1)
        speed = np.sqrt((self.world.v[b] ** 2).sum(1)) + np.sqrt((self.world.w[b] ** 2).sum(1)) * self._reach
        reach = _REACH * self.dt * speed + _NEAR * self._size
        still = self._body >= many
        reach[still] = self.dt * np.sqrt((self.walls.velocity[self._body[still] - many] ** 2).sum(1))
        return reach

    def _by_distance(self, time: float, reach: np.ndarray):
        """What colliders touch that are known by their distance: (point's number, surface, place, normal, gap), each (k, ...)."""
        shape = self._of_point
        body = self._body[shape]
        points = self.world.x[body] + np.einsum("pij,pj->pi", self.world.R[body], self._points)
        distance, normals = self.walls.distances(points, time)
        gap = distance - self._radius[shape][:, None]
        fastest = self.dt * np.sqrt((self.walls.velocity**2).sum(1)).max(initial=0.0)
        p, s = np.nonzero(gap < (reach[shape] + fastest)[:, None])
        g, n = gap[p, s], normals[p, s]
        return p, s, points[p] - (self._radius[shape[p]] + 0.5 * g)[:, None] * n, n, g

    def look(self, time: float) -> None:
        """Find the contacts at the bodies' places, at `time`, s."""
        many, reach = len(self.world.members), self._reaches()
        found = detect_contacts(self._shapes(time), reach, self._movable)
        p, s, point, normal, gap = self._by_distance(time, reach)
        first, second = self._body[found.first], self._body[found.second]
        shape = self._of_point[p]
        self.first = np.concatenate([np.where(first < many, first, -1), self._body[shape]]).astype(np.int32)
        self.second = np.concatenate([np.where(second < many, second, -1), np.full(len(p), -1)]).astype(np.int32)
        solid = np.maximum(first, second) - many
        self.wall = np.concatenate([np.where(solid >= 0, solid, -1), self.walls.owner[s]]).astype(int)
        self.point = np.concatenate([found.point, point])
        self.normal = np.concatenate([found.normal, normal])
        self.gap = np.concatenate([found.gap, gap])
        own = 512 * len(self._kind) ** 2 + p * len(self.walls.owner) + s
        self.key = np.concatenate([found.key, own])
        smaller = np.minimum(self._size[found.first], self._size[found.second])
        self.sizes = np.concatenate([smaller, self._size[shape]])

    def refuse_overlaps(self, name: str) -> None:
        """UsageError that names two bodies, or a body and a collider, that overlap."""
        deep = self.gap + _OVERLAP * self.sizes
        if not len(deep) or deep.min() >= 0:
            return
        k = int(deep.argmin())
        met = [f"body {b + 1} ('{self.world.members[b].name}')" for b in (self.first[k], self.second[k]) if b >= 0]
        if self.wall[k] >= 0:
            met.append(f"the {self.walls.colliders[self.wall[k]].name}")
        raise UsageError(
            f"system '{name}': {' and '.join(met)} overlap by {-self.gap[k]:.3g} m at the start: move them apart"
        )

    def solve(self, v: np.ndarray, w: np.ndarray, turn) -> dict[str, tuple[np.ndarray, float]]:
        """Give the bodies the impulses of this part of the step; v, w (b, 3): velocity and spin before the forces' kick.

        Returns each collider's impulse, N s, and its work, J, by name.
        """
        self.world.shift = None
        if not len(self.gap):
            self._keys, self._impulses = np.zeros(0, np.int64), np.zeros((0, 3))
            return {}
        solver = ContactSolver(self, v, w, turn)
        start = self._warm() * turn.kick
        impulses = solver.impulses(start)
        if turn.drift > 0:
            self.world.shift = solver.parting()
        held = self.world.v, self.world.w
        self._keys = self.key  # kept as forces: the next solve may be over another length of time
        self._impulses = np.where(solver.hits[:, None], 0.0, impulses) / turn.kick
        given = solver.give(impulses) * solver.sign
        late = solver.late(*held)
        if late is not None:
            self.world.shift = late if self.world.shift is None else self.world.shift + late
        out: dict[str, tuple[np.ndarray, float]] = {}
        for c in np.unique(self.wall[self.wall >= 0]):
            total = given[self.wall == c].sum(0)
            out[self.walls.names[c]] = (total, float((total * self.walls.velocity[c]).sum()))
        return out

    def _warm(self) -> np.ndarray:
        """The impulses that the same contacts had last."""
        out = np.zeros((len(self.key), 3))
        if len(self._keys):
            order = np.argsort(self._keys, kind="stable")
            at = np.minimum(np.searchsorted(self._keys[order], self.key), len(order) - 1)
            known = self._keys[order[at]] == self.key
            out[known] = self._impulses[order[at[known]]]
        return out
