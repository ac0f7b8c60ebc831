"""Where rays meet the surfaces of colliders, as a camera or a lamp sees them.

A side of a collider is seen from where its distance is positive: a solid from outside, a box that contains particles from
inside, so that a camera outside looks through its near walls onto the far ones.

Along a ray the distance from a convex solid is a convex function, so Newton's method from the near end never passes the first
root. Other shapes are marched through by their distance, which is never steeper than 1, where their `ray_span` says.
Source: Hart, Sphere tracing, The Visual Computer 12 (1996).
"""

# ruff: noqa: SIM102  (ti.static decides while tracing, so it must stand in an `if` of its own)
from functools import cache

import numpy as np

from gen_art.backend.kernel_views import traced
from gen_art.backend.runtime import kernel, ti
from gen_art.colliders.base import Collider
from gen_art.colliders.kinds import collider_kinds, numbers_of
from gen_art.colliders.surface import (
    distance_and_normal,
    is_of_kind,
    nearest_distance,
    rotated_about,
    to_start_frame,
)
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.renderer.surfaces.collider_sets import holds, with_collider

__all__ = [
    "ColliderTerms",
    "cast_by",
    "collider_distances",
    "cone_contact",
    "first_hit",
    "in_start_frame",
    "ray_in_start_frame",
    "side_hit",
    "surface_exit",
    "surface_normal",
    "without_itself",
]

F1, F2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)
_NEWTON_STEPS, _MARCH_STEPS, _CONE_STEPS = 64, 400, 100
_PARALLEL = 1e-6  # slope of the distance along a ray from which on the ray counts as leaving a convex solid


class ColliderTerms:
    """Colliders laid out for a kernel; equal for the same classes and fixed choices, whatever their numbers.

    kinds : the ColliderKinds, of which kernels read the colliders
    colliders : in the same order
    owners : for each surface, the index of its collider
    """

    def __init__(self, colliders):
        self._terms = KernelTerms(colliders=tuple(colliders))
        self.colliders: tuple[Collider, ...] = tuple(term.force for term in self._terms.colliders)
        self.kinds = collider_kinds(self._terms.colliders)
        self.owners = [k for k, collider in enumerate(self.colliders) for _ in range(collider.sides)]

    def numbers(self) -> np.ndarray:
        """The colliders' run-time numbers, (m,) float32."""
        return self._terms.numbers(np.float32)

    @property
    def fixed(self) -> tuple:
        """What kernels are compiled for."""
        return self._terms.fixed

    def __hash__(self):
        return hash(self._terms)

    def __eq__(self, other):
        return isinstance(other, ColliderTerms) and self._terms == other._terms


@traced
def cast_by(collider) -> bool:
    """Whether a collider shadows others: a solid does, a box or a hollow sphere that contains the scene does not."""
    return collider.sides == 1 and not collider.values.get("inside", False)


@ti.func
def ray_in_start_frame(collider: ti.template(), q: ti.template(), origin, direction, time):
    """Origin and direction of a ray in the collider's frame at time 0."""
    o, axis, angle = to_start_frame(collider, q, origin, time)
    d = direction
    if ti.static(collider.rotates):
        d = rotated_about(direction, axis, -angle)
    return o, d


@ti.func
def in_start_frame(kinds: ti.template(), Q: ti.template(), surface, x, a, b, c, time):
    """The position x and the directions a, b and c in the frame at time 0 of the collider that has the surface."""
    place, first, second, third = x, a, b, c
    for kind in ti.static(kinds):
        if is_of_kind(kind, surface):
            q = numbers_of(Q, kind, (surface - kind.first_surface) // kind.collider.sides)
            place, axis, angle = to_start_frame(kind.collider, q, x, time)
            if ti.static(kind.collider.rotates):
                first, second = rotated_about(a, axis, -angle), rotated_about(b, axis, -angle)
                third = rotated_about(c, axis, -angle)
    return place, first, second, third


@ti.func
def side_hit(collider: ti.template(), q: ti.template(), side, o, d, low, high, tolerance, per_length):
    """The distance along a ray at which it enters a side from its positive side, or `high` if it does not before that.

    o, d : origin and unit direction in the collider's frame at time 0
    tolerance, per_length : the hit is exact to tolerance + per_length * (distance along the ray)
    """
    t, result = low, high
    if ti.static(collider.convex):
        f = collider.distance(o + d * t, q, side)
        if f > 0.0:
            steps = 0
            while steps < _NEWTON_STEPS:
                slope = collider.gradient(o + d * t, q, side).dot(d)
                steps += 1
                t -= f / ti.min(slope, -_PARALLEL)
                if slope > -_PARALLEL or t >= high:
                    steps = _NEWTON_STEPS
                else:
                    f = collider.distance(o + d * t, q, side)
                    if f <= tolerance + per_length * t:
                        # a ray that only passes near by is on its way out
                        if collider.gradient(o + d * t, q, side).dot(d) < 0.0:
                            result = t
                        steps = _NEWTON_STEPS
    else:
        span = collider.ray_span(o, d, q, 0.0, 0.0)
        t, end = ti.max(low, span[0]), ti.min(high, span[1])
        f = collider.distance(o + d * t, q, side)
        steps, was_outside, before = ti.select(t < end, 0, _MARCH_STEPS), f > 0.0, t
        while steps < _MARCH_STEPS:
            steps += 1
            before = t
            previous = f
            t += ti.max(abs(f), tolerance + per_length * t)
            f = collider.distance(o + d * t, q, side)
            if was_outside and f <= tolerance + per_length * t:
                if f < 0.0:
                    t = before + (t - before) * previous / (previous - f)
                result = ti.min(t, high)
                steps = _MARCH_STEPS
            if t >= end:
                steps = _MARCH_STEPS
            was_outside = was_outside or f > 0.0
    return result


@ti.func
def cone_contact(collider: ti.template(), q: ti.template(), o, d, radius, tangent, low, far):
    """The distance along a ray at which the cone about it may reach the collider's first side; `far` if nowhere before that.

    o, d : in the collider's frame at time 0; radius : of the cone at o; tangent : by which it grows per length
    low : where on the ray to begin

    The distance less the cone's radius falls by 1 + tangent per length at most; for a convex collider it is convex.
    """
    t, end, steps = low, far, 0
    if ti.static(not collider.convex):
        span = collider.ray_span(o, d, q, radius, tangent)
        t, end = ti.max(low, span[0]), ti.min(far, span[1])
        if t >= end:
            t, steps = far, _CONE_STEPS
    f = collider.distance(o + d * t, q, 0) - radius - tangent * t
    while f > 1e-3 * (radius + tangent * t) and steps < _CONE_STEPS:
        steps += 1
        slope = -(1.0 + tangent)
        if ti.static(collider.convex):
            slope = collider.gradient(o + d * t, q, 0).dot(d) - tangent
        t -= f / ti.min(slope, -_PARALLEL)
        if slope > -_PARALLEL or t >= end:
            t, steps = far, _CONE_STEPS
        else:
            f = collider.distance(o + d * t, q, 0) - radius - tangent * t
    return t


@ti.func
def first_hit(
    kinds: ti.template(), Q: ti.template(), origin, direction, time, low, high, tolerance, per_length, among
):  # fmt: skip
    """(distance along the ray, surface, facet) of the first surface that a ray enters, or (high, -1, 0).

    among : the set of the colliders that it may enter, as of collider_sets.py
    facet : the face of its side that it meets
    """
    nearest, surface, facet = high, -1, 0
    for kind in ti.static(kinds):
        for j in range(kind.count):
            if holds(among, kind.first + j):
                q = numbers_of(Q, kind, j)
                o, d = ray_in_start_frame(kind.collider, q, origin, direction, time)
                for side in range(kind.collider.sides):
                    t = side_hit(kind.collider, q, side, o, d, low, nearest, tolerance, per_length)
                    if t < nearest:
                        inside = 1
                        if ti.static(
                            kind.collider.sides > 1
                        ):  # a side's surface goes on beyond the edges of the others
                            inside = ti.cast(
                                kind.collider.nearest(o + d * t, q) >= -4.0 * (tolerance + per_length * t), ti.i32
                            )
                        if inside == 1:
                            nearest, surface, facet = t, kind.first_surface + j * kind.collider.sides + side, 0
                            if ti.static(kind.collider.faceted):
                                facet = kind.collider.facet(o + d * t, q)
    return nearest, surface, facet


@ti.func
def without_itself(kinds: ti.template(), colliders, surface):
    """A set of colliders without the one that has the surface, if it is a convex solid: it shadows itself nowhere else."""
    result = colliders
    for kind in ti.static(kinds):
        if ti.static(kind.collider.convex and kind.collider.sides == 1):
            if is_of_kind(kind, surface):
                result &= ~with_collider(ti.i64(0), kind.first + surface - kind.first_surface)
    return result


@ti.func
def surface_exit(kinds: ti.template(), Q: ti.template(), surface, origin, direction, time, tolerance):
    """The distance along a ray inside a solid collider at which it leaves it."""
    t = 2.0 * tolerance
    for kind in ti.static(kinds):
        if ti.static(kind.collider.sides == 1):
            if is_of_kind(kind, surface):
                q = numbers_of(Q, kind, surface - kind.first_surface)
                o, d = ray_in_start_frame(kind.collider, q, origin, direction, time)
                f, steps = kind.collider.distance(o + d * t, q, 0), 0
                while f < -tolerance and steps < _MARCH_STEPS:
                    steps += 1
                    t -= f
                    f = kind.collider.distance(o + d * t, q, 0)
    return t


@ti.func
def surface_normal(kinds: ti.template(), Q: ti.template(), surface, x, time):
    """The unit normal (3,) of a surface at the position x and the time."""
    found = distance_and_normal(kinds, Q, surface, x, time, 1)
    return ti.Vector([found[0], found[1], found[2]])


@cache
def _distance_kernel(terms: ColliderTerms):
    kinds = terms.kinds

    @ti.kernel
    def distances(Q: F1, X: F2, time: ti.f32, out: F2):
        """out[i, k], m: the distance of X[i] from the nearest side of collider k."""
        for i in range(X.shape[0]):
            x = ti.Vector([X[i, 0], X[i, 1], X[i, 2]])
            for kind in ti.static(kinds):
                for j in range(kind.count):
                    out[i, kind.first + j] = nearest_distance(kind.collider, numbers_of(Q, kind, j), x, time)

    return kernel(distances)


def collider_distances(terms: ColliderTerms, points, time: float) -> np.ndarray:
    """(n, colliders) m, the distances of points (n, 3) from each collider at a time; positive where particles may be."""
    x = np.ascontiguousarray(points, np.float32).reshape(-1, 3)
    out = np.zeros((len(x), len(terms.colliders)), np.float32)
    if out.size:
        _distance_kernel(terms)(terms.numbers(), x, float(time), out)
    return out
