"""How much of a distant lamp's disc a point sees past colliders and solids.

The lamp is sampled at LAMP_POINTS points, evenly spread over its disc. What hides a point of it is found by geometry: a ball by
its outline as the lamp's rays meet it, all else by the rays themselves. Each shadow is a set of bits, one for each point, so
shadows that overlap are counted once. A ray starts from the pixel's area instead of a point of it, in step with the lamp's
disc, so no edge of a shadow is sharper than a pixel.

Solids are listed in cells of a grid across the lamp's direction, each in the cells that its half-shadow may reach.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.kinds import numbers_of
from gen_art.maths.array_functions import cos, median, sin
from gen_art.renderer.surfaces.cell_lists import cell_lists
from gen_art.renderer.surfaces.collider_rays import cast_by, cone_contact, ray_in_start_frame, side_hit
from gen_art.renderer.surfaces.collider_sets import holds
from gen_art.renderer.surfaces.scene_numbers import BIN_CELL, BIN_CORNER, BIN_SHAPE, LAMP_SIDE, LAMP_UP, vector_at
from gen_art.renderer.surfaces.solids import BOUND, HALF, RADIUS, along_axes, box_meets, row_vector, solid_reaches_cone

__all__ = [
    "LAMP_POINTS",
    "SOLIDS_OF_TILE",
    "ShadowBins",
    "collider_shadow",
    "in_shadow_cells",
    "lamp_disc",
    "set_bits",
    "shadow_cell",
    "solid_shadow",
]

LAMP_POINTS = 64
SOLIDS_OF_TILE = 64  # most solids that are listed for a tile of the picture
_ALL = -1  # all bits of a set
_GOLDEN = np.pi * (3.0 - np.sqrt(5.0))
_CELLS = 1024  # most cells along a side of the grid
_UMBRAS = (
    4.0  # a ball's half-shadow is followed until it is this many radii wide, where the ball hides 1/16 of the lamp
)
_RIM = 24  # of the lamp's points, those along its rim
_LEAVES = 0.1  # slope of the distance along a ray from which on it leaves the surface that it starts at
_DEPTHS = 4  # places inside a collider at which a ray is tested for a full shadow


def lamp_disc(points: int = LAMP_POINTS) -> np.ndarray:
    """(points, 2) float32: points spread evenly over the unit disc, by the golden angle."""
    k = np.arange(points)
    radius = np.sqrt((k + 0.5) / points)
    return np.stack([radius * cos(k * _GOLDEN), radius * sin(k * _GOLDEN)], axis=1).astype(np.float32)


@dataclass(frozen=True)
class ShadowBins:
    """Solids in cells of a grid across the lamp's direction.

    axes : (3, 3), rows: two directions across the lamp's rays, then the direction in which they travel
    corner : (2,) of the grid along the first two axes
    cell : side of a cell
    shape : (2,) cells along both
    starts : (cells + 1,) int32, the first of each cell's solids
    solids : their indices
    """

    axes: np.ndarray
    corner: np.ndarray
    cell: float
    shape: tuple[int, int]
    starts: np.ndarray
    solids: np.ndarray

    @classmethod
    def of(cls, positions, radii, axes) -> "ShadowBins":
        """The bins of solids.

        positions, radii : (n, 3) and (n,), of the balls around them
        """
        if not len(positions):
            return cls(axes, np.zeros(2), 1.0, (1, 1), np.zeros(2, np.int32), np.zeros(1, np.int32))
        across = np.asarray(positions, np.float64) @ axes[:2].T
        reach = (1.0 + _UMBRAS) * radii
        low, high = (across - reach[:, None]).min(axis=0), (across + reach[:, None]).max(axis=0)
        cell = max(median(reach), float((high - low).max()) / _CELLS, 1e-9)
        shape = np.maximum(np.ceil((high - low) / cell).astype(np.int64), 1)
        first = np.clip(((across - reach[:, None] - low) / cell).astype(np.int64), 0, shape - 1)
        last = np.clip(((across + reach[:, None] - low) / cell).astype(np.int64), 0, shape - 1)
        rows, columns = int(shape[0]), int(shape[1])
        return cls(axes, low, cell, (rows, columns), *cell_lists(first, last, (rows, columns)))


@ti.func
def shadow_cell(N: ti.template(), place, further):
    """(2,) row and column of the cell of ShadowBins at a world position, moved by `further` along both."""
    u, v = place.dot(vector_at(N, LAMP_SIDE)) + further, place.dot(vector_at(N, LAMP_UP)) + further
    at = ti.Vector([u - N[BIN_CORNER], v - N[BIN_CORNER + 1]]) / N[BIN_CELL]
    return ti.cast(ti.floor(ti.min(ti.max(at, -1.0), 2.0 * _CELLS)), ti.i32)


@ti.func
def in_shadow_cells(N: ti.template(), row, column):
    """Whether the grid of ShadowBins has this cell."""
    return (
        row >= 0 and column >= 0 and row < ti.cast(N[BIN_SHAPE], ti.i32) and column < ti.cast(N[BIN_SHAPE + 1], ti.i32)
    )


@ti.func
def set_bits(hidden):
    """The number of set bits of a set of LAMP_POINTS."""
    rest, count = hidden, 0
    if rest == ti.i64(_ALL):
        count = LAMP_POINTS
    else:
        while rest != ti.i64(0):
            rest &= rest - ti.i64(1)
            count += 1
    return count


@ti.func
def solid_shadow(hidden, B: ti.template(), i, x, to_lamp, side, up, tangent, half_pixel, far, D: ti.template(), points):
    """The set `hidden` with the lamp's points that solid i hides from x (relative to the camera).

    far : distance of the lamp
    side, up : unit vectors across the direction `to_lamp`
    D : (points, 2) of lamp_disc, at most LAMP_POINTS
    """
    result = hidden
    offset, radius = ti.Vector([B[i, 0], B[i, 1], B[i, 2]]) - x, B[i, BOUND]
    along = offset.dot(to_lamp)
    ball = B[i, HALF] + B[i, HALF + 1] + B[i, HALF + 2] == 0.0
    if ball and offset.dot(offset) < radius * radius:  # x lies inside
        result = ti.i64(_ALL)
    if (along > 0.0 and along < far) or (not ball and along > -radius and along < far + radius):
        u, v = offset.dot(side), offset.dot(up)
        cone = half_pixel + ti.max(along, 0.0) * tangent
        distance2 = u * u + v * v
        reach = radius + cone
        if distance2 < reach * reach:
            if ball:
                if radius > cone and distance2 <= (radius - cone) * (radius - cone):
                    result = ti.i64(_ALL)
                else:
                    for k in range(points):
                        du, dv = u - cone * D[k, 0], v - cone * D[k, 1]
                        if du * du + dv * dv < radius * radius:
                            result |= ti.i64(1) << ti.cast(k, ti.i64)
            else:
                reaches = solid_reaches_cone(B, i, offset, to_lamp, tangent, half_pixel, far)
                if reaches == 2:
                    result = ti.i64(_ALL)
                # from the rim of the lamp inwards: a convex solid that hides the rim hides all of it
                k, rim_hidden = ti.select(reaches == 1, points - 1, -1), 1
                half, middle = row_vector(B, i, HALF), along_axes(B, i, to_lamp)
                sideways, upwards = along_axes(B, i, side), along_axes(B, i, up)
                # of the point of the ray that is nearest to the centre
                beside = along_axes(B, i, to_lamp * along - offset)
                width = half_pixel + along * tangent
                while k >= 0:
                    across = sideways * D[k, 0] + upwards * D[k, 1]
                    p, towards = beside + across * width, middle + across * tangent
                    bit = ti.i64(1) << ti.cast(k, ti.i64)
                    if (result & bit) == ti.i64(0):
                        length = towards.norm()  # of the ray, per length along its cone
                        towards, start = towards / length, -along * length
                        if box_meets(p, towards, half, B[i, RADIUS], start, start + far) == 1:
                            result |= bit
                        else:
                            rim_hidden = 0
                    k -= 1
                    if k == points - points * _RIM // LAMP_POINTS and rim_hidden == 1:
                        result = ti.i64(_ALL)
                        k = -1
    return result


@ti.func
def collider_shadow(
    kinds: ti.template(), Q: ti.template(), x, to_lamp, side, up, tangent, half_pixel, time, far, D: ti.template(),
    points, casters
):  # fmt: skip
    """The set of the lamp's points that some colliders hide from x; casters : the set of these."""
    hidden = ti.i64(0)
    for kind in ti.static(kinds):
        if ti.static(cast_by(kind.collider)):
            for j in range(kind.count):
                if hidden != ti.i64(_ALL) and holds(casters, kind.first + j):
                    q = numbers_of(Q, kind, j)
                    o, d = ray_in_start_frame(kind.collider, q, x, to_lamp, time)
                    reaches, low = _reaches_cone(kind.collider, q, o, d, tangent, half_pixel, far)
                    if reaches == 2:
                        hidden = ti.i64(_ALL)
                    if reaches == 1:
                        for k in range(points):
                            across = side * D[k, 0] + up * D[k, 1]
                            towards = (to_lamp + across * tangent).normalized()
                            o_k, d_k = ray_in_start_frame(kind.collider, q, x + across * half_pixel, towards, time)
                            if side_hit(kind.collider, q, 0, o_k, d_k, low, far, 1e-4 * half_pixel, 1e-6) < far:
                                hidden |= ti.i64(1) << ti.cast(k, ti.i64)
    return hidden


@ti.func
def _reaches_cone(collider: ti.template(), q: ti.template(), o, d, tangent, half_pixel, far):
    """Whether a collider reaches into the cone of rays about a ray: (0 no, 1 in part, 2 it hides the lamp; from where on)."""
    at_start, low = collider.distance(o, q, 0), 0.0
    if ti.static(collider.has_clear_way):
        # a ray that leaves the surface from within half a pixel of it may meet it again only farther on
        slope = collider.gradient(o, q, 0).dot(d) - tangent
        if at_start >= 0.0 and at_start <= half_pixel and slope > _LEAVES:
            free = (1.1 * half_pixel - at_start) / slope
            if free < collider.clear_way(q) and collider.distance(o + d * free, q, 0) > half_pixel + tangent * free:
                low = free
    t = cone_contact(collider, q, o, d, half_pixel, tangent, low, far)
    state = ti.select(t < far, 1, 0)
    if at_start < 0.0:  # the ray starts inside
        state = 2
    if state == 1:
        # deeper inside than the cone is wide, no ray of the cone gets past
        depth = 2.0 * (half_pixel + tangent * t)
        for _ in range(_DEPTHS):
            at = t + depth
            depth *= 3.0
            if at < far and collider.distance(o + d * at, q, 0) <= -(half_pixel + tangent * at):
                state = 2
    return state, t * 0.99
