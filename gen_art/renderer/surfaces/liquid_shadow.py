"""The lamp's light that passes through liquids: a map across the lamp's rays, with the first liquid and how much follows.

In each texel stand the distance along the rays at which they first meet liquid, the length that they cross in all, and the
optical depth of each colour over that length. A place at the distance p is reached through min(length, p - first) of it.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.maths.elementary import exp
from gen_art.renderer.surfaces.lamp_shadows import LAMP_POINTS
from gen_art.renderer.surfaces.scene_numbers import (
    LAMP_SIDE,
    LAMP_TANGENT,
    LAMP_UP,
    LIQUID_BIAS,
    LIQUID_CELL,
    LIQUID_CORNER,
    LIQUID_FIRST,
    TO_LAMP,
    vector_at,
)
from gen_art.renderer.surfaces.solids import NEVER

__all__ = ["NO_LIQUID", "LiquidShadow", "liquid_light"]


@dataclass(frozen=True, eq=False)
class LiquidShadow:
    """The map of all liquids.

    corner : (2,) of the map along the two axes across the lamp's rays, m
    cell : side of a texel, m; 0 for no liquid
    first : (rows, columns) float32, distance along the rays at which they meet the liquid, NEVER where they do not
    depths : (rows, columns, 4) float32, optical depth of each colour, and the length in m
    """

    corner: np.ndarray
    cell: float
    first: np.ndarray
    depths: np.ndarray

    @property
    def nearest(self) -> float:
        """The least distance along the rays at which any ray meets the liquid."""
        return float(self.first.min())


NO_LIQUID = LiquidShadow(np.zeros(2), 0.0, np.full((1, 1), NEVER, np.float32), np.zeros((1, 1, 4), np.float32))


@ti.func
def _passed(N: ti.template(), first: ti.template(), depths: ti.template(), x, y, p):
    """(4,) light of each colour that passes to a place at the distance p, and how far above it the liquid begins."""
    result, weight_above, above = ti.Vector([0.0, 0.0, 0.0, 0.0]), 0.0, 0.0
    u, v = x - 0.5, y - 0.5
    i, j = ti.cast(ti.floor(v), ti.i32), ti.cast(ti.floor(u), ti.i32)
    fv, fu = v - ti.cast(i, ti.f32), u - ti.cast(j, ti.f32)
    for k in range(4):
        a, b = i + k // 2, j + k % 2
        weight = ti.select(k // 2 == 1, fv, 1.0 - fv) * ti.select(k % 2 == 1, fu, 1.0 - fu)
        share, begins = 0.0, NEVER
        if a >= 0 and b >= 0 and a < first.shape[0] and b < first.shape[1]:
            begins = first[a, b]
            if begins + N[LIQUID_BIAS] < p:
                share = ti.min((p - begins - N[LIQUID_BIAS]) / ti.max(depths[a, b, 3], 1e-20), 1.0)
                above += weight * (p - begins)
                weight_above += weight
        for c in range(3):  # not unrolled: every surface's kernel holds this
            passed = 1.0
            if share > 0.0:
                passed = exp(-share * depths[a, b, c])
            result[c] += weight * passed
    if weight_above > 0.0:
        result[3] = above / weight_above
    return result


@ti.func
def liquid_light(N: ti.template(), first: ti.template(), depths: ti.template(), D: ti.template(), place, pixel):
    """(3,) the share of the lamp's light of each colour that passes through liquids to a position in the world.

    first, depths : of a LiquidShadow; D : of lamp_disc; pixel : side of a pixel there, m
    """
    result = ti.Vector([1.0, 1.0, 1.0])
    if N[LIQUID_CELL] > 0.0:
        x = (place.dot(vector_at(N, LAMP_SIDE)) - N[LIQUID_CORNER]) / N[LIQUID_CELL]
        y = (place.dot(vector_at(N, LAMP_UP)) - N[LIQUID_CORNER + 1]) / N[LIQUID_CELL]
        p = -place.dot(vector_at(N, TO_LAMP))
        widest = (N[LAMP_TANGENT] * ti.max(p - N[LIQUID_FIRST], 0.0) + 0.5 * pixel) / N[LIQUID_CELL]
        columns, rows = ti.cast(first.shape[1], ti.f32), ti.cast(first.shape[0], ti.f32)
        near = x > -widest - 1.0 and y > -widest - 1.0 and x < columns + widest + 1.0 and y < rows + widest + 1.0
        if near and p > N[LIQUID_FIRST]:
            # first, how far above the place is what shadows it, on average: that says how wide its half-shadow is
            reach, stage = widest, 0
            while stage < 2:
                passed, above, found = ti.Vector([0.0, 0.0, 0.0]), 0.0, 0.0
                every = ti.select(widest < 1.0, LAMP_POINTS, ti.select(stage == 0, 4, 1))
                for j in range(LAMP_POINTS // every):
                    k = every * j + every - 1
                    across = ti.select(widest < 1.0, 0.0, reach)
                    one = _passed(N, first, depths, x + across * D[k, 0], y + across * D[k, 1], p)
                    above, found = above + one[3], found + ti.select(one[3] > 0.0, 1.0, 0.0)
                    for c in range(3):
                        passed[c] += one[c]
                stage += 1
                if widest < 1.0 or stage == 2:
                    stage = 2
                    result = passed * (ti.cast(every, ti.f32) / LAMP_POINTS)
                elif found > 0.0:
                    reach = (N[LAMP_TANGENT] * above / found + 0.5 * pixel) / N[LIQUID_CELL]
                else:
                    stage = 2
    return result
