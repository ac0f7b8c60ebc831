"""Contacts of the bodies of one system, with each other and with colliders: where they are, and the impulses they give."""

import numpy as np

from gen_art.rigid.body import FIXED
from gen_art.rigid.kernels import NUMBERS, contact_kernel
from gen_art.rigid.touching import Shapes, touching
from gen_art.rigid.turns import cross
from gen_art.rigid.walls import Walls, probes
from gen_art.errors import UsageError

__all__ = ["Meeting"]

_REACH = 1.2  # how much faster than now a body may get in a step before its contact is seen too late
_NEAR = 0.01  # and how near to the next thing, in its own size, it is always seen
_OVERLAP = 1e-4  # of the smaller body's size, tolerated at the start
_EXACT = 1e-10  # of the largest speed: what a sweep over the contacts may still change


class Meeting:
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
        held = np.concatenate([world.hold == FIXED, np.ones(len(self.walls.colliders), bool)])
        self._movable = ~held[self._body]
        moving = [k for k, (b, _) in enumerate(pairs) if b < bodies and not held[b]]
        points = [probes(pairs[k][1], self.walls.flat) for k in moving]
        self._of_point = np.repeat(np.array(moving, int), [len(p) for p in points])
        self._points = np.concatenate(points) if points else np.zeros((0, 3))
        self._reach = np.array([np.linalg.norm(p.center) + np.linalg.norm(p.half) + p.radius for _, p in pairs])
        # restitution, kinetic and static friction by what is met: first the other bodies, then each collider
        own = np.array([[values["restitution"], *values["friction"]]])
        self._laws = np.concatenate([own, np.column_stack([self.walls.restitution, self.walls.friction])])
        self._keys = np.zeros(0, np.int64)
        self._impulses = np.zeros((0, 3))

    @property
    def memory(self) -> dict[str, np.ndarray]:
        return {"keys": self._keys, "impulses": self._impulses}

    def remember(self, memory) -> None:
        self._keys, self._impulses = memory["keys"].copy(), memory["impulses"].copy()

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

    def look(self, time: float) -> None:
        """Find the contacts at the bodies' places, at `time`, s."""
        world, many = self.world, len(self.world.members)
        shapes = self._shapes(time)
        speed = np.sqrt((world.v**2).sum(1))[np.minimum(self._body, many - 1)]
        speed += np.sqrt((world.w**2).sum(1))[np.minimum(self._body, many - 1)] * self._reach
        walls = self._body >= many
        if walls.any():
            speed[walls] = np.sqrt((self.walls.velocity[self._body[walls] - many] ** 2).sum(1))
        reach = _REACH * self.dt * speed + _NEAR * self._size
        reach[walls] = 1.0 * self.dt * speed[walls]
        found = touching(shapes, reach, self._movable)
        shape = self._of_point
        points = world.x[self._body[shape]] + np.einsum("pij,pj->pi", world.R[self._body[shape]], self._points)
        distance, normals = self.walls.distances(points, time)
        gap = distance - self._radius[shape][:, None]
        fastest = np.sqrt((self.walls.velocity**2).sum(1)).max(initial=0.0) * self.dt
        p, s = np.nonzero(gap < (reach[shape] + fastest)[:, None])
        g, n = gap[p, s], normals[p, s]
        first, second = self._body[found.first], self._body[found.second]
        base = 512 * len(self._kind) ** 2
        self.first = np.concatenate([np.where(first < many, first, -1), self._body[shape[p]]]).astype(np.int32)
        self.second = np.concatenate([np.where(second < many, second, -1), np.full(len(p), -1)]).astype(np.int32)
        wall = np.maximum(first, second) - many
        self.wall = np.concatenate([np.where(wall >= 0, wall, -1), self.walls.owner[s] if len(p) else s]).astype(int)
        self.point = np.concatenate([found.point, points[p] - (self._radius[shape[p]] + 0.5 * g)[:, None] * n])
        self.normal = np.concatenate([found.normal, n])
        self.gap = np.concatenate([found.gap, g])
        self.key = np.concatenate([found.key, base + p * max(len(self.walls.owner), 1) + s])
        self._sizes = np.concatenate([np.minimum(self._size[found.first], self._size[found.second]), self._size[shape[p]]])

    def refuse_overlaps(self, name: str) -> None:
        """UsageError that names two bodies, or a body and a collider, that overlap."""
        deep = self.gap + _OVERLAP * self._sizes
        if not len(deep) or deep.min() >= 0:
            return
        k = int(deep.argmin())
        title = lambda b: f"body {b + 1} ('{self.world.members[b].name}')"  # noqa: E731
        one = title(max(self.first[k], self.second[k]) if min(self.first[k], self.second[k]) < 0 else self.first[k])
        other = f"the {self.walls.colliders[self.wall[k]].name}" if self.wall[k] >= 0 else title(self.second[k])
        raise UsageError(f"system '{name}': {one} and {other} overlap by {-self.gap[k]:.3g} m at the start: move them apart")

    def solve(self, v: np.ndarray, w: np.ndarray, turn) -> dict[str, tuple[np.ndarray, float]]:
        """Give the bodies the impulses of this part of the step; v, w (b, 3): velocity and spin before the forces' kick.

        Before a drift, gaps must not close within it, and what comes in fast leaves at once with restitution times its
        speed; at the end of a step, what touches must not approach. Returns each collider's impulse, N s, and its work, J, by name.
        """
        k = len(self.gap)
        if k == 0:
            self._keys, self._impulses = np.zeros(0, np.int64), np.zeros((0, 3))
            return {}
        world = self.world
        first, second, n = self.first, self.second, self.normal
        along = np.zeros((k, 3))
        along[np.arange(k), np.abs(n).argmin(1)] = 1.0
        u = cross(n, along)
        u /= np.sqrt((u * u).sum(1))[:, None]
        a, b = np.maximum(first, 0), np.maximum(second, 0)
        on_a, on_b = (first >= 0)[:, None], (second >= 0)[:, None]
        ra, rb = np.where(on_a, self.point - world.x[a], 0.0), np.where(on_b, self.point - world.x[b], 0.0)
        sign = np.where(first >= 0, 1.0, -1.0)[:, None]  # a wall that stands first pushes the other way
        surface = np.where((self.wall >= 0)[:, None], self.walls.velocity[self.wall] * sign, 0.0) if len(self.walls.velocity) else 0 * n

        def sides(v, w):
            return np.where(on_a, v[a] + cross(w[a], ra), 0.0), np.where(on_b, v[b] + cross(w[b], rb), 0.0)

        was, was_two = sides(v, w)
        now, now_two = sides(world.v, world.w)
        before, after = was - was_two - surface, now - now_two - surface
        w0, w1 = (before * n).sum(1), (after * n).sum(1)
        laws = self._laws[self.wall + 1]
        share = self.dt / turn.kick
        # what presses two bodies together may be what pulls both of them against a third
        pull = (np.abs(((now - was) * n).sum(1)) + np.abs(((now_two - was_two) * n).sum(1))) * share
        fast = (-laws[:, 0] * w0 > pull) & (w0 < 0)
        span = turn.drift if turn.drift > 0 else self.dt
        aim = -np.maximum(self.gap, 0.0) / span
        if turn.drift > 0:
            hits = fast & (self.gap + span * w1 < 0)
            aim = np.where(hits, w1 - (1 + laws[:, 0]) * w0, aim)
        else:
            hits = fast
            aim = np.where(fast, -1e300, aim)  # it hits in the next step, with its restitution
        slide = before - w0[:, None] * n
        change = np.sqrt(((now - was) ** 2).sum(1)) + np.sqrt(((now_two - was_two) ** 2).sum(1))
        still = (slide * slide).sum(1) <= (change * share) ** 2
        C = np.zeros((k, NUMBERS))
        C[:, 0:3], C[:, 3:6], C[:, 6:9], C[:, 9:12], C[:, 12:15] = ra, rb, n, u, cross(n, u)
        C[:, 15], C[:, 16] = aim, np.where(still, laws[:, 2], laws[:, 1])
        C[:, 17:20] = self._warm()
        C[hits, 17:20] = 0.0
        C[:, 17:20] *= self._span(turn)
        for r in range(3):
            C[:, 20 + r] = (surface * C[:, 6 + 3 * r : 9 + 3 * r]).sum(1)
        many = len(world.v)
        V, B = np.zeros((many + 1, 6)), np.zeros((many + 1, 10))
        V[:many, :3], V[:many, 3:], B[:many, 0], B[:many, 1:] = world.v, world.w, world.ease, world.J.reshape(-1, 9)
        one, two = np.where(first >= 0, first, many).astype(np.int32), np.where(second >= 0, second, many).astype(np.int32)
        contact_kernel()(B, V, one, two, C, np.zeros((k, 36)), np.zeros((k, 9)), self.most, self._exact(V))
        given = C[:, 17:18] * n + C[:, 18:19] * u + C[:, 19:20] * C[:, 12:15]
        P, L = np.zeros_like(world.v), np.zeros_like(world.v)
        for which, arm, way in ((first, ra, 1.0), (second, rb, -1.0)):
            on = which >= 0
            np.add.at(P, which[on], way * given[on])
            np.add.at(L, which[on], way * cross(arm[on], given[on]))
        world.impulse(P, L)
        self._keys = self.key
        self._impulses = np.where(hits[:, None], 0.0, C[:, 17:20]) / self._span(turn)
        out: dict[str, tuple[np.ndarray, float]] = {}
        for c in np.unique(self.wall[self.wall >= 0]):
            total = (given * sign)[self.wall == c].sum(0)
            out[self.walls.names[c]] = (total, float((total * self.walls.velocity[c]).sum()))
        return out

    def _span(self, turn) -> float:
        """Impulses are kept as forces: the next solve may be over another length of time."""
        return turn.kick

    def _exact(self, V: np.ndarray) -> float:
        return _EXACT * float(np.abs(V).max(initial=0.0)) + 1e-300

    def _warm(self) -> np.ndarray:
        """The impulses that the same contacts had last."""
        out = np.zeros((len(self.key), 3))
        if len(self._keys):
            order = np.argsort(self._keys, kind="stable")
            at = np.minimum(np.searchsorted(self._keys[order], self.key), len(order) - 1)
            known = self._keys[order[at]] == self.key
            out[known] = self._impulses[order[at[known]]]
        return out
