"""How much of the sky colliders hide from the surfaces near them.

A ball that the solid angle of a hemisphere holds entirely hides cos(t) (r / d)^2 of an even sky from a surface, at the distance
d of its middle in the direction t from the normal; below the horizon a part of it does not count. Another solid counts as the
ball that touches it at its nearest point and has its mean shadow's area over all directions (a quarter of a convex solid's
surface, Cauchy).
Source: Quilez, Sphere ambient occlusion (the form factor of a sphere that the horizon cuts); Martinez, Radiation heat transfer.

The one-letter names in kernels are in docs/glossary.md.
"""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.base import Collider
from gen_art.colliders.kinds import numbers_of
from gen_art.colliders.surface import rotated_about, to_start_frame
from gen_art.renderer.surfaces.collider_rays import cast_by
from gen_art.renderer.surfaces.collider_sets import holds
from gen_art.renderer.surfaces.scene_numbers import CAMERA, SHADOWS, TIME, vector_at

__all__ = ["FARTHEST_OCCLUDER", "mean_radius", "open_sky_share", "sky_occluders"]

FARTHEST_OCCLUDER = 12.0  # mean radii: farther away a collider hides less than 1/169 of the sky


def mean_radius(collider: Collider) -> float:
    """Radius of the ball whose shadow is as large as the collider's, as the mean over all directions, m; 0 if not known.

    The mean shadow of a convex solid is a quarter of its surface (Cauchy).
    """
    return math.sqrt(collider.surface_area() / (4.0 * math.pi))


def sky_occluders(surfaces, through: float) -> np.ndarray:
    """(colliders, 2) float32: mean radius, and the part of the sky's light behind it that a collider hides.

    surfaces : (collider, look) of a scene; through : what a transparent one lets pass
    """
    rows = [(mean_radius(collider), 1.0 - through * look.transmission) for collider, look in surfaces]
    return np.array(rows or [(0.0, 0.0)], np.float32)


@ti.func
def _arc_tangent_share(c):
    """acos(c) / pi for c from -1 to 1, to 7e-5 (Abramowitz and Stegun 4.4.45)."""
    a = ti.abs(c)
    value = (
        ti.sqrt(ti.max(1.0 - a, 0.0)) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - 0.0187293 * a))) * 0.31830989
    )
    return ti.select(c < 0.0, 1.0 - value, value)


@ti.func
def _hidden_by_ball(cosine, h2):
    """The share of an even sky that a ball hides from a surface.

    cosine : of the angle of its direction with the normal; h2 : (distance of its middle / its radius)^2, at least 1
    """
    result = ti.max(cosine, 0.0) / h2
    cut = 1.0 - h2 * cosine * cosine
    if cut > 0.0:  # the horizon passes through the ball
        sine2 = ti.max(1.0 - cosine * cosine, 1e-12)
        rim = ti.sqrt(ti.max(h2 - 1.0, 0.0))
        angle = _arc_tangent_share(ti.min(ti.max(-cosine * rim / ti.sqrt(sine2), -1.0), 1.0))
        # atan(sqrt(cut) / rim) / pi, by the cosine of that angle
        beyond = _arc_tangent_share(rim / ti.sqrt(ti.max(rim * rim + cut, 1e-20)))
        result = (cosine * angle - 0.31830989 * ti.sqrt(cut) * rim) / h2 + beyond
    return ti.min(ti.max(result, 0.0), 1.0)


@ti.func
def open_sky_share(kinds: ti.template(), scene: ti.template(), x, n, occluders):
    """The share of the sky's light that colliders leave to a surface at x (relative to the camera) with the normal n.

    occluders : the set of the colliders that may hide it
    """
    N = ti.static(scene.N)
    share = 1.0
    if N[SHADOWS] > 0.5:
        for kind in ti.static(kinds):
            if ti.static(cast_by(kind.collider)):
                for k in range(kind.first, kind.first + kind.count):
                    radius = scene.occluders[k, 0]
                    if radius > 0.0 and holds(occluders, k):
                        q = numbers_of(scene.Q, kind, k - kind.first)
                        y, axis, angle = to_start_frame(kind.collider, q, x + vector_at(N, CAMERA), N[TIME])
                        f = ti.max(kind.collider.distance(y, q, 0), 0.0)
                        if f < FARTHEST_OCCLUDER * radius:
                            g = kind.collider.gradient(y, q, 0)
                            if ti.static(kind.collider.rotates):
                                g = rotated_about(g, axis, angle)
                            h = 1.0 + f / radius
                            share *= 1.0 - scene.occluders[k, 1] * _hidden_by_ball(-n.dot(g), h * h)
    return share
