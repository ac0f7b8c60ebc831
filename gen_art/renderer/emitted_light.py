"""The light that the systems named by `glow` of a preset's `light:` emit to all sides, wherever the camera looks.

A sprite of radius r and brightness L in its middle is a light of the intensity L A to all sides, A being the area by which
the picture multiplies its brightness: 2.49 r^2 of a disc or a streak, pi r^2 of a sphere. Points, and sprites measured in
pixels, have the size that they show at the distance of the camera's target. Of a ribbon only the head counts.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from gen_art.particles.rows import POSITION
from gen_art.renderer.emissive_lighting import EmittedLight
from gen_art.renderer.look_tables import AREA_OF, KIND, RIBBON, ROWS, SCALE, SIZE_MODE, SNAP, WIDTH, kernel_numbers
from gen_art.renderer.projected_particles import LIT_RADIUS, ProjectedParticles
from gen_art.renderer.shading import REFERENCE_ROWS, shade
from gen_art.renderer.sprite import BLUE, DISC, POINT, RED, STREAK

__all__ = ["emitted_light"]


def emitted_light(
    systems: Iterable[tuple], view, size, time: float, film_time: float, weight: float = 1.0
) -> EmittedLight | None:
    """The light of systems, or None if there are none.

    systems : (ParticleSystem's particles, LookTables, accelerations or None) of each
    view : the camera's view; only its distance from its target and its scale count
    size : (width, height) of the picture
    """
    positions, power, areas = [], [], []
    projected = ProjectedParticles()  # its arrays are kept here no longer than this
    # all particles, in an orthographic view of scale 1: nothing depends on where they stand in the picture
    even = replace(view, height=1.0, near=-np.inf, far=np.inf, fog=None, lens=None)
    pixel = (1.0 if view.height is not None else view.distance) / view.scale(size[1]) * size[1] / REFERENCE_ROWS
    for particles, tables, acceleration in systems:
        q = kernel_numbers(tables, even, (1, 1), time, film_time, 0.0, False, weight=weight, lit=True)
        q[SCALE], q[WIDTH], q[ROWS], q[RIBBON], q[SNAP] = 1.0, REFERENCE_ROWS, REFERENCE_ROWS, 0.0, 0.0
        is_point = q[KIND] == POINT and q[SIZE_MODE] < 2
        if q[KIND] == STREAK:
            q[KIND] = DISC
        shade(projected, particles, tables, q, acceleration)
        n = projected.count
        in_pixels = is_point or q[SIZE_MODE] == 2
        square = pixel * pixel if in_pixels else 1.0
        light = projected.used[RED : BLUE + 1].T.astype(np.float64) * square
        radius = projected.lit[:n, LIT_RADIUS].astype(np.float64)
        positions.append(np.array(particles.floats[POSITION, :n].T, np.float64))
        power.append(np.where(np.isfinite(light), light, 0.0))
        areas.append(np.full(n, square) if is_point else q[AREA_OF] * radius * radius * square)
    if not positions:
        return None
    return EmittedLight(np.concatenate(positions), np.concatenate(power), np.concatenate(areas))
