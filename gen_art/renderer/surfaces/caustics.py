"""Caustics: the lamp's light that transparent bodies gather on the surfaces behind them.

Photons start from a disc before each transparent body, in directions from all over the lamp. They are
refracted until they meet a surface that scatters light, and are kept there. A place of a surface receives the photons near it,
each spread over a small disc, so the light of a body is kept whatever its shape.
Source: Jensen, Global illumination using photon maps, Eurographics Workshop on Rendering (1996).

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache, lru_cache

import numpy as np

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.colliders.base import Collider
from gen_art.maths.array_functions import cos, sin
from gen_art.maths.elementary import exp, log
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.collider_sets import every_caster
from gen_art.renderer.surfaces.lamp_shadows import lamp_disc
from gen_art.renderer.surfaces.photon_cells import NO_PHOTONS, PHOTON_FLOATS, Photons
from gen_art.renderer.surfaces.ray_tree import leaving_distance, nearest_hit, refracted, surface_point
from gen_art.renderer.surfaces.reflection import fresnel_of
from gen_art.renderer.surfaces.scene_numbers import (
    LAMP_COLOUR,
    LAMP_SIDE,
    LAMP_TANGENT,
    LAMP_UP,
    TO_LAMP,
    vector_at,
)
from gen_art.renderer.surfaces.shadow_casters import ShadowCasters, filled
from gen_art.renderer.surfaces.solid_grid import SolidGrid
from gen_art.renderer.surfaces.solids import BOUND, MATERIAL
from gen_art.renderer.surfaces.surface_detail import IOR, PER_LENGTH, TRANSMISSION
from gen_art.renderer.surfaces.surface_light import lamp_share

__all__ = ["caustic_photons"]

F1, F2, I1 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 1)
_PHOTONS = 400_000  # of all bodies together
_MOST, _FEWEST = 60_000, 2_000  # of one body
_SPREAD = 4.0  # radius of a photon's disc, in distances between photons as they start
_SURFACES = 12  # that a photon may meet
_FOUR = 4.0  # the radiance of a white surface in the light of a lamp of brightness 1


@cache
def _photon_kernel(terms: ColliderTerms):
    kinds, surfaces = terms.kinds, len(terms.owners)

    @ti.kernel
    def send(
        N: F1, Q: F1, owners: I1, M: F2, B: F2, shadow_starts: I1, shadow_solids: I1, D: F2, smoke: F1, grid_starts: I1,
        grid_solids: I1, bodies: F2, of_each: ti.i32, starts: F2, out: F2,
    ):  # fmt: skip
        """Fill out[i] with a photon's place relative to the camera, its light and the radius of its disc; a radius of 0: none.

        bodies : (n, 4) centre relative to the camera, and radius, of balls around transparent bodies
        starts : (of_each, 4) points of the unit disc from which photons start, then of the lamp's disc
        """
        ti.loop_config(block_dim=1)
        for block in range((bodies.shape[0] * of_each + 255) // 256):
            scene = arrays(
                N=N, Q=Q, owners=owners, M=M, B=B, shadow_starts=shadow_starts, shadow_solids=shadow_solids, D=D, smoke=smoke,
                grid_starts=grid_starts, grid_solids=grid_solids, with_sheets=False, mapped=False,
            )  # fmt: skip
            for i in range(block * 256, ti.min((block + 1) * 256, bodies.shape[0] * of_each)):
                body, k = i // of_each, i % of_each
                radius = bodies[body, 3]
                side, up, to_lamp = vector_at(N, LAMP_SIDE), vector_at(N, LAMP_UP), vector_at(N, TO_LAMP)
                across = side * starts[k, 0] + up * starts[k, 1]
                o = ti.Vector([bodies[body, 0], bodies[body, 1], bodies[body, 2]]) + (across + to_lamp * 1.02) * radius
                from_lamp = to_lamp + (side * starts[k, 2] + up * starts[k, 3]) * N[LAMP_TANGENT]
                d, pixel = -from_lamp.normalized(), 1e-3 * radius
                spacing = radius * ti.sqrt(3.14159265 / ti.cast(of_each, ti.f32))
                light = lamp_share(kinds, scene, o, pixel, every_caster()) * spacing * spacing * _FOUR
                colour = vector_at(N, LAMP_COLOUR) * light
                inside, met, refractions, reached = -1, 0, 0, 0
                while met < _SURFACES and colour.max() > 0.0:
                    met += 1
                    t, who = 0.0, inside
                    if inside >= 0:
                        t = leaving_distance(kinds, surfaces, scene, inside, o, d, pixel)
                    else:
                        t, who = nearest_hit(kinds, surfaces, scene, o, d, pixel)
                    if who < 0:
                        met = _SURFACES
                    else:
                        n, x, m, albedo, _, _, _, _, _ = surface_point(kinds, surfaces, scene, who, o + d * t, d, pixel)
                        if inside >= 0:
                            for c in ti.static(range(3)):
                                colour[c] *= exp(log(ti.max(albedo[c], 1e-6)) * t * M[m, PER_LENGTH])
                            go = refracted(d, -n, M[m, IOR])
                            if go.dot(go) > 0.0:
                                colour *= 1.0 - fresnel_of(ti.max(go.dot(n), 1e-4), M[m, IOR])
                                o, d, inside = x + n * pixel, go, -1
                            else:
                                o, d = x - n * pixel, d - n * (2.0 * n.dot(d))
                        elif M[m, TRANSMISSION] > 0.0:
                            colour *= M[m, TRANSMISSION] * (1.0 - fresnel_of(ti.max(-n.dot(d), 1e-4), M[m, IOR]))
                            o, d, inside = x - n * pixel, refracted(d, n, 1.0 / M[m, IOR]), who
                            refractions += 1
                        else:
                            met = _SURFACES
                            if refractions > 0:
                                reached = 1
                                for c in ti.static(range(3)):
                                    out[i, c], out[i, 3 + c] = x[c], colour[c]
                out[i, 6] = ti.select(reached == 1, _SPREAD * spacing, 0.0)

    return kernel(send)


@lru_cache(4)
def _starts(count: int) -> np.ndarray:
    """(count, 4) float32: points of two unit discs, spread evenly over both together.

    Source: Roberts, The unreasonable effectiveness of quasirandom sequences (2018): multiples of the powers of 1/g,
    g^5 = g + 1, modulo 1.
    """
    g = 1.1673039782614187
    u = (0.5 + np.arange(1, count + 1)[:, None] / g ** np.arange(1, 5)) % 1.0
    radius, angle = np.sqrt(u[:, ::2]), 2.0 * np.pi * u[:, 1::2]
    return np.stack([radius * cos(angle), radius * sin(angle)], axis=2).reshape(count, 4).astype(np.float32)


def bounding_ball(collider: Collider, time: float) -> tuple[np.ndarray, float] | None:
    """(centre, radius), m, of a ball around a solid collider at a time; None for one whose extent is not known."""
    ball = collider.ball()
    return None if ball is None else (ball[0] + np.array(collider.values["velocity"], np.float64) * time, ball[1])


def caustic_photons(casters: ShadowCasters, surfaces, table, owners, numbers, smoke, grid: SolidGrid) -> Photons:
    """The photons behind a scene's transparent colliders and solids.

    surfaces : (collider, look) of the scene
    table : (materials, MATERIAL_FLOATS); owners : (surfaces,) int32 the collider of each
    numbers : of scene_numbers; smoke : optical depths from the lamp
    """
    view, rows = casters.view, casters.rows
    bodies = [np.zeros((0, 4))]
    for collider, look in surfaces:
        ball = bounding_ball(collider, casters.time) if look.transmission else None
        if ball is not None:
            bodies.append(np.append(ball[0] - view.position, ball[1])[None])
    clear = table[rows[:, MATERIAL].astype(np.int64), TRANSMISSION] > 0.0
    bodies.append(np.concatenate([rows[clear, :3], rows[clear, BOUND, None]], axis=1))
    found = np.ascontiguousarray(np.concatenate(bodies), np.float32)
    if not len(found) or not casters.light.lamp.any():
        return NO_PHOTONS
    of_each = int(np.clip(_PHOTONS // len(found), _FEWEST, _MOST))
    out = np.zeros((len(found) * of_each, PHOTON_FLOATS), np.float32)
    _photon_kernel(casters.terms)(
        numbers, casters.terms.numbers(), owners, table, filled(rows), casters.bins.starts, filled(casters.bins.solids),
        lamp_disc(), smoke, grid.starts, filled(grid.solids), found, of_each, _starts(of_each), out,
    )  # fmt: skip
    return Photons.of(out)
