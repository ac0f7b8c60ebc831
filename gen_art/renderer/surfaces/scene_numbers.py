"""The numbers of the view and of the light that kernels of surfaces read, N, and the camera's rays.

The one-letter names in kernels are in docs/glossary.md.
"""

import math

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.renderer.camera import CameraView
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.smoke_lighting import lamp_axes

__all__ = ["NUMBERS", "camera_ray", "first_distance", "lamp_tangent", "scene_numbers", "vector_at"]

(
    CAMERA, RIGHT, UP, FORWARD, SCALE, PARALLEL, NEAR, FAR, WIDTH, ROWS, TIME, TO_LAMP, LAMP_SIDE, LAMP_UP, LAMP_TANGENT,
    LAMP_COLOUR, SHADOWS, SHADOW_REACH, FOG_START, FOG_RATE, FOG_COLOUR, BIN_CORNER, BIN_CELL, BIN_SHAPE, SKY_ORIGIN, SKY_CELL,
    SKY_SHAPE, SMOKE_CORNER, SMOKE_CELL, SMOKE_SHAPE, CLIP, MIRROR, HAS_DOME, FOG_IS_SKY, GRID_CORNER, GRID_CELL, GRID_SHAPE,
    PHOTON_CELL, LIQUID_CORNER, LIQUID_CELL, LIQUID_FIRST, LIQUID_BIAS, SKY_LIFT,
) = (
    0, 3, 6, 9, 12, 13, 14, 15, 16, 17, 18, 19, 22, 25, 28, 29, 32, 33, 34, 35, 36, 39, 41, 42, 44, 47, 48, 51, 54, 55, 58,
    62, 63, 64, 65, 68, 71, 74, 75, 77, 78, 79, 80,
)  # fmt: skip
NUMBERS = 81
_FARTHEST = 1e15  # its square is a float32


@ti.func
def vector_at(N: ti.template(), k):
    """The three numbers from N[k] on."""
    return ti.Vector([N[k], N[k + 1], N[k + 2]])


@ti.func
def first_distance(N: ti.template(), o, d):
    """The distance along a ray from which on the scene is drawn: 0, or where it crosses the plane of a mirror from behind.

    It is _FARTHEST for a ray that does not.
    """
    result, normal = 0.0, vector_at(N, CLIP)
    if normal.dot(normal) > 0.0:
        towards, result = normal.dot(d), ti.static(_FARTHEST)
        if towards > 1e-9:
            result = ti.max((N[CLIP + 3] - normal.dot(o)) / towards, 0.0)
    return result


@ti.func
def camera_ray(N: ti.template(), column, row):
    """Origin relative to the camera and unit direction of the ray through a place of the picture."""
    across, down = (column - 0.5 * N[WIDTH]) / N[SCALE], (0.5 * N[ROWS] - row) / N[SCALE]
    offset = vector_at(N, RIGHT) * across + vector_at(N, UP) * down
    origin, direction = offset * 0.0, vector_at(N, FORWARD)
    if N[PARALLEL] > 0.5:
        origin = offset
    else:
        direction = (direction + offset).normalized()
    return origin, direction


def lamp_tangent(light: Lighting) -> float:
    """The tangent of half the lamp's angle."""
    return math.tan(math.radians(light.size) / 2.0)


def scene_numbers(
    view: CameraView, size, time: float, light: Lighting, shadows: bool, bins, sky, smoke, grid=None, clip=None, mirror: int = -1,
    liquid=None,
) -> np.ndarray:  # fmt: skip
    """N, (NUMBERS,) float32.

    size : (width, height) of the picture
    time : simulated seconds
    bins : ShadowBins
    sky : SkyLight
    smoke : the Smoke that shadows the lamp, along the lamp's axes, or None
    grid : the SolidGrid that rays between surfaces walk through, or None
    clip : (point, normal) of the plane before which nothing is drawn, as behind a mirror, or None
    mirror : the material of the mirror, or -1
    liquid : the LiquidShadow that liquids cast, or None
    """
    n = np.zeros(NUMBERS)
    n[CAMERA : CAMERA + 3] = view.position
    n[RIGHT : RIGHT + 9] = view.axes.reshape(-1)
    n[SCALE], n[PARALLEL] = view.scale(size[1]), view.height is not None
    n[NEAR], n[FAR] = max(view.near, -_FARTHEST), min(view.far, _FARTHEST)
    if view.height is not None and view.near == -math.inf:
        n[NEAR] = -_parallel_reach(view)
    n[FOG_IS_SKY] = view.fog_is_sky
    n[WIDTH], n[ROWS], n[TIME] = size[0], size[1], time
    side, up, forward = lamp_axes(light.direction)
    n[TO_LAMP : TO_LAMP + 3], n[LAMP_SIDE : LAMP_SIDE + 3], n[LAMP_UP : LAMP_UP + 3] = -forward, side, up
    n[LAMP_TANGENT], n[LAMP_COLOUR : LAMP_COLOUR + 3] = lamp_tangent(light), light.lamp
    n[SHADOWS], n[SHADOW_REACH] = shadows, 1e4 * (view.distance + (view.height or 0.0))
    if view.fog:
        n[FOG_START], n[FOG_RATE] = view.fog[0], 1.0 / view.fog[1]
        n[FOG_COLOUR : FOG_COLOUR + 3] = view.fog[2]
    n[BIN_CORNER : BIN_CORNER + 2], n[BIN_CELL], n[BIN_SHAPE : BIN_SHAPE + 2] = bins.corner, bins.cell, bins.shape
    n[SKY_ORIGIN : SKY_ORIGIN + 3], n[SKY_CELL], n[SKY_SHAPE : SKY_SHAPE + 3] = sky.origin, sky.cell, sky.shape
    n[SMOKE_CELL] = 1.0
    if smoke is not None:
        n[SMOKE_CORNER : SMOKE_CORNER + 3], n[SMOKE_CELL] = smoke.corner, smoke.cell
        n[SMOKE_SHAPE : SMOKE_SHAPE + 3] = smoke.extinction.shape
    if grid is not None:
        n[GRID_CORNER : GRID_CORNER + 3], n[GRID_CELL : GRID_CELL + 3] = grid.corner, grid.cell
        n[GRID_SHAPE : GRID_SHAPE + 3] = grid.shape
    if clip is not None:
        point, normal = (np.asarray(vector, np.float64) for vector in clip)
        n[CLIP : CLIP + 3], n[CLIP + 3] = normal, (point - view.position) @ normal
    if liquid is not None:
        n[LIQUID_CORNER : LIQUID_CORNER + 2], n[LIQUID_CELL], n[LIQUID_FIRST] = (
            liquid.corner,
            liquid.cell,
            liquid.nearest,
        )
    n[MIRROR], n[HAS_DOME] = mirror, light.dome is not None
    return n.astype(np.float32)


def _parallel_reach(view: CameraView) -> float:
    """How far behind itself an orthographic camera sees surfaces: a hundred times what its picture shows."""
    return 100.0 * (view.distance + (view.height or 0.0))
