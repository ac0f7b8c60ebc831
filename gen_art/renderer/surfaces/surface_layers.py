"""Layers of what surfaces show in each pixel, for compositing: albedo, normal, shadow, depth and motion.

The motion is that since the frame before: a place x of a surface that moves at u was at x - u T, and the earlier camera saw
it there. The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass, field

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.colliders.surface import surface_properties
from gen_art.renderer.projected_particles import LIT_EXTINCTION
from gen_art.renderer.surfaces.collider_sets import every_caster
from gen_art.renderer.surfaces.draw_sheets import sheet_velocity
from gen_art.renderer.surfaces.liquid_shadow import liquid_light
from gen_art.renderer.surfaces.ray_tree import surface_point
from gen_art.renderer.surfaces.scene_numbers import (
    CAMERA,
    FORWARD,
    LIQUID_BIAS,
    PARALLEL,
    RIGHT,
    ROWS,
    SCALE,
    TIME,
    TO_LAMP,
    UP,
    WIDTH,
    vector_at,
)
from gen_art.renderer.surfaces.surface_light import lamp_share

__all__ = [
    "ALBEDO",
    "DISTANCE",
    "LAYER_FLOATS",
    "MOTION",
    "NORMAL",
    "SHADOWED",
    "NO_LAYERS",
    "SurfaceLayers",
    "layers_of_place",
    "layers_of_surface",
]

# of each pixel, sums over the share of it that surfaces cover: albedo, normal, the part of the lamp's light that does not
# arrive, distance along the line of sight, pixels moved to the right and down
ALBEDO, NORMAL, SHADOWED, DISTANCE, MOTION, LAYER_FLOATS = 0, 3, 6, 7, 8, 10
# P, the earlier view: how far the camera has moved, its axes, scale, whether it is orthographic, seconds since then
_MOVED, _AXES, _SCALE, _PARALLEL, _SECONDS, _NUMBERS = 0, 3, 12, 13, 14, 15
_SPIN, _MOTION_FLOATS = 3, 6  # of a solid: velocity of its centre, angular velocity


@dataclass(eq=False)
class SurfaceLayers:
    """The layers of one picture, which drawing fills.

    values : (rows, columns, LAYER_FLOATS) float32, linear in the share of the pixel that surfaces cover
    earlier : (15,) float32, the view and the time of the frame before
    solids : (n, 6) float32, velocity and angular velocity of each
    corners : (n, 3) float32, velocity of each corner of cloth
    """

    values: np.ndarray
    earlier: np.ndarray
    solids: np.ndarray = field(default_factory=lambda: np.zeros((1, _MOTION_FLOATS), np.float32))
    corners: np.ndarray = field(default_factory=lambda: np.zeros((1, 3), np.float32))

    @classmethod
    def of(cls, size: tuple[int, int], view, earlier, seconds: float) -> "SurfaceLayers":
        """Empty ones.

        view, earlier : CameraView of the picture and of the frame before
        seconds : simulated seconds between them
        """
        p = np.zeros(_NUMBERS)
        p[_MOVED : _MOVED + 3], p[_AXES : _AXES + 9] = view.position - earlier.position, earlier.axes.reshape(-1)
        p[_SCALE], p[_PARALLEL], p[_SECONDS] = earlier.scale(size[1]), earlier.height is not None, seconds
        return cls(np.zeros((size[1], size[0], LAYER_FLOATS), np.float32), p.astype(np.float32))

    def take_motion(self, solids, sheets) -> None:
        """Take over how the solids (SolidSystem) and the corners of cloth (SheetSystem) of the picture move."""
        rows = [_solid_motion(system) for system in solids]
        corners = [system.velocities[:, system.used].T for system in sheets]
        if sum(map(len, rows)):
            self.solids = np.ascontiguousarray(np.concatenate(rows), np.float32)
        if sum(map(len, corners)):
            self.corners = np.ascontiguousarray(np.concatenate(corners), np.float32)


NO_LAYERS = SurfaceLayers(np.zeros((1, 1, LAYER_FLOATS), np.float32), np.zeros(_NUMBERS, np.float32))


def _solid_motion(system) -> np.ndarray:
    """(n, 6) velocity and angular velocity of the solids of one system, in the order of solid_rows."""
    shapes = system.shapes
    particle = np.arange(system.channels.shape[1]) if shapes is None else shapes.particle
    here = np.flatnonzero(system.columns[particle, LIT_EXTINCTION] > 0.0)
    motion = np.zeros((len(here), _MOTION_FLOATS))
    if shapes is None:
        motion[:, :_SPIN] = system.velocities[:, here].T
    else:
        motion[:, :_SPIN], motion[:, _SPIN:] = shapes.velocity[here], shapes.spin[here]
    return motion


@ti.func
def _place_seen(x, right, up, forward, scale, parallel):
    """(right, down, distance) in pixels from the middle of the picture, of x relative to the camera."""
    ahead = x.dot(forward)
    if parallel < 0.5:
        scale /= ti.max(ahead, 1e-30)
    return x.dot(right) * scale, -x.dot(up) * scale, ahead


@ti.func
def _moved(N: ti.template(), P: ti.template(), x, u):
    """(2,) pixels to the right and down that x, relative to the camera, moved since the frame before; u : its velocity."""
    was = x - u * P[_SECONDS] + vector_at(P, _MOVED)
    # both by one formula, so that what stands still before a camera that stands still has moved by exactly 0
    right, down, _ahead = _place_seen(
        x, vector_at(N, RIGHT), vector_at(N, UP), vector_at(N, FORWARD), N[SCALE], N[PARALLEL]
    )
    old_right, old_down, ahead = _place_seen(
        was, vector_at(P, _AXES), vector_at(P, _AXES + 3), vector_at(P, _AXES + 6), P[_SCALE], P[_PARALLEL]
    )
    result = ti.Vector([right - old_right, down - old_down])
    # of what the earlier camera had behind it, or beside it by many pictures, no pixel is known
    if (P[_PARALLEL] < 0.5 and ahead <= 0.0) or abs(result).max() > 1e3 * (N[WIDTH] + N[ROWS]):
        result *= 0.0
    return result


@ti.func
def _velocity(kinds: ti.template(), surfaces: ti.template(), scene: ti.template(), moves: ti.template(), who, x):
    """(3,) m/s, of a surface, solid or cloth at x relative to the camera."""
    N, B = ti.static(scene.N, scene.B)
    u = x * 0.0
    if who >= surfaces + B.shape[0]:
        if ti.static(scene.with_sheets):
            u = sheet_velocity(scene, moves.corners, who - surfaces - B.shape[0], x)
    elif who >= surfaces:
        i = who - surfaces
        spin = vector_of(moves.solids, i, _SPIN)
        u = vector_of(moves.solids, i, 0) + spin.cross(x - vector_of(B, i, 0))
    else:
        if ti.static(surfaces > 0):
            _, u = surface_properties(kinds, scene.Q, who, x + vector_at(N, CAMERA), N[TIME])
    return u


@ti.func
def vector_of(A: ti.template(), i, k):
    return ti.Vector([A[i, k], A[i, k + 1], A[i, k + 2]])


@ti.func
def layers_of_place(kinds: ti.template(), scene: ti.template(), P: ti.template(), x, n, albedo, u, depth, pixel):
    """(LAYER_FLOATS,) of a place of a surface.

    x : relative to the camera; n : unit normal; u : velocity; depth : along the line of sight; pixel : its side at x
    """
    N = ti.static(scene.N)
    arriving = 0.0
    if n.dot(vector_at(N, TO_LAMP)) > 0.0:
        arriving = lamp_share(kinds, scene, x + n * (0.6 * pixel), pixel, every_caster())
        place = x + vector_at(N, CAMERA) + n * N[LIQUID_BIAS]
        passed = liquid_light(N, scene.liquid_first, scene.liquid_depths, scene.D, place, pixel)
        arriving *= (passed[0] + passed[1] + passed[2]) / 3.0
    motion = _moved(N, P, x, u)
    return ti.Vector([albedo[0], albedo[1], albedo[2], n[0], n[1], n[2], 1.0 - arriving, depth, motion[0], motion[1]])


@ti.func
def layers_of_surface(
    kinds: ti.template(), surfaces: ti.template(), scene: ti.template(), moves: ti.template(), who, o, d, t, depth
):  # fmt: skip
    """(LAYER_FLOATS,) of what the ray from o along d meets at the distance t."""
    N = ti.static(scene.N)
    pixel = ti.select(N[PARALLEL] > 0.5, 1.0, t) / N[SCALE]
    # a name each for what is not used: Taichi gives a name one type
    n, x, _m, albedo, through, _emission, _clear, _flat, _detail = surface_point(
        kinds, surfaces, scene, who, o + d * t, d, pixel
    )
    u = _velocity(kinds, surfaces, scene, moves, who, x)
    return layers_of_place(kinds, scene, moves.P, x, n, albedo + through, u, depth, pixel)
