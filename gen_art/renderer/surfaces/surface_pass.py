"""Draws the surfaces of a scene: gathers colliders, balls and light for the kernel of draw_surfaces.py."""

from dataclasses import dataclass

import numpy as np

from gen_art.preset.light import KeyLight
from gen_art.preset.surface import Finish, SurfaceLook
from gen_art.renderer.colour import linear
from gen_art.renderer.shading import LIT_ALBEDO, LIT_POSITION, LIT_RADIUS
from gen_art.renderer.smoke_lighting import lamp_axes
from gen_art.renderer.sprite import ALPHA, BLUE, RED
from gen_art.renderer.surfaces.cell_lists import cell_lists
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.draw_surfaces import BALL_ALBEDO, BALL_EMISSION, BALL_FLOATS, BALL_MATERIAL, BIN, RADIUS, SUBPIXELS, TILE, draw_kernel
from gen_art.renderer.surfaces.lamp_shadows import BallBins, lamp_disc
from gen_art.renderer.surfaces.reflection import reflected_share
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.scene_numbers import lamp_tangent, scene_numbers
from gen_art.renderer.surfaces.sky_light import SkyLight
from gen_art.renderer.surfaces.surface_shading import CHECKER, EMISSION, IOR, MATERIAL_FLOATS, METAL, ROUGHNESS, SECOND_ALBEDO

__all__ = ["Balls", "SurfacePass"]

_EXACT = 2.0**24  # pixels beyond which a rectangle of the picture is cut


@dataclass(frozen=True)
class Balls:
    """The balls of one system, as shaded.

    finish : how they reflect
    channels : (11, n) of ProjectedParticles
    columns : (n, 8) LIT_... of shading.py
    """

    finish: Finish
    channels: np.ndarray
    columns: np.ndarray


class SurfacePass:
    """Draws surfaces into framebuffers of one size. Of the last picture it keeps

    depths : (rows, columns, SUBPIXELS) along the line of sight
    bounds : (down, across, 2), the least and the largest of each tile of 8 x 8 pixels
    """

    def __init__(self, size: tuple[int, int]):
        self.size = size
        self.depths = np.zeros((size[1], size[0], SUBPIXELS), np.float32)
        self.bounds = np.zeros((-(-size[1] // TILE), -(-size[0] // TILE), 2), np.float32)
        self._disc = lamp_disc()

    def draw(self, scene: Scene, view, time: float, balls: list[Balls], smoke, framebuffer) -> bool:
        """Draw what there is into a clear framebuffer; False if there is nothing to draw.

        balls : of each system of balls
        smoke : (Smoke along the lamp's axes, its optical depths from the lamp) that shadows surfaces, or None
        """
        surfaces = scene.surfaces
        rows, materials = _ball_rows(balls, len(surfaces), view)
        if not surfaces and not len(rows):
            return False
        light = scene.light or KeyLight()
        terms = ColliderTerms([collider for collider, _ in surfaces])
        looks = [look for _, look in surfaces] + materials
        table = np.stack([_material(look) for look in looks])
        shares = np.stack([reflected_share(look.roughness, look.ior) for look in looks])
        positions, radii = rows[:, :3].astype(np.float64) + view.position, rows[:, RADIUS].astype(np.float64)
        depth = _extent(positions, radii, view)
        bins = BallBins.of(positions, radii, lamp_axes(light.direction), lamp_tangent(light), depth)
        sky = SkyLight.of(light, positions, np.pi * radii**2 * scene.shadows, radii)
        grid, depths = smoke if smoke is not None and scene.shadows else (None, np.zeros(1, np.float32))
        numbers = scene_numbers(view, self.size, time, light, scene.shadows, bins, sky, grid)
        rectangles = _rectangles(rows, view, self.size)
        across, down = framebuffer.across, framebuffer.down
        first, last = rectangles[:, 2::-2] // BIN, rectangles[:, 3::-2] // BIN
        bin_starts, bin_balls = cell_lists(first, last, (down, across))
        draw_kernel(terms)(
            numbers, terms.numbers(), np.array(terms.owners or [0], np.int32), table, shares, _some(rows), _some(rectangles),
            bin_starts, _some(bin_balls), bins.starts, _some(bins.balls), self._disc, sky.light, sky.open, depths, across, down,
            framebuffer.buffer, framebuffer.stride, self.depths, self.bounds,
        )  # fmt: skip
        return True


def _some(array: np.ndarray) -> np.ndarray:
    """The array, or a row of zeros in place of an empty one, which kernels do not take."""
    return array if len(array) else np.zeros((1, *array.shape[1:]), array.dtype)


def _material(look: Finish) -> np.ndarray:
    """The row of the kernel's materials."""
    row = np.zeros(MATERIAL_FLOATS, np.float32)
    row[ROUGHNESS], row[IOR], row[METAL] = look.roughness, look.ior, look.metal
    if isinstance(look, SurfaceLook):
        row[:3] = linear(look.albedo)
        if look.checker is not None:
            row[SECOND_ALBEDO : SECOND_ALBEDO + 3], row[CHECKER] = linear(look.checker.color), look.checker.size
        row[EMISSION : EMISSION + 3] = linear(look.emission) * look.emission_intensity
    return row


def _ball_rows(balls: list[Balls], first_material: int, view) -> tuple[np.ndarray, list[Finish]]:
    """(n, BALL_FLOATS) rows of all balls that the camera could see, and the finish of each system."""
    found, materials = [np.zeros((0, BALL_FLOATS), np.float32)], []
    for system in balls:
        area = system.channels[ALPHA]
        here = np.flatnonzero(area > 0.0)
        columns, rows = system.columns[here], np.zeros((len(here), BALL_FLOATS), np.float32)
        rows[:, :3] = columns[:, LIT_POSITION].astype(np.float64) - view.position
        rows[:, RADIUS] = columns[:, LIT_RADIUS]
        rows[:, BALL_ALBEDO : BALL_ALBEDO + 3] = columns[:, LIT_ALBEDO] / area[here, None]
        rows[:, BALL_EMISSION : BALL_EMISSION + 3] = (system.channels[RED : BLUE + 1, here] / area[here]).T
        rows[:, BALL_MATERIAL] = first_material + len(materials)
        found.append(rows)
        materials.append(system.finish)
    return np.concatenate(found), materials


def _extent(positions, radii, view) -> float:
    """How far a ball's shadow may fall: twice the extent of all balls, and the distance to the camera's target."""
    if not len(positions):
        return view.distance
    return 2.0 * float(np.ptp(positions, axis=0).max() + radii.max()) + view.distance


def _rectangles(rows: np.ndarray, view, size) -> np.ndarray:
    """(n, 4) int32: first and last column and row of the pixels that balls may cover, clipped to the picture.

    The outline of a ball as the camera sees it lies between the two tangents through the camera, along each axis.
    """
    if not len(rows):
        return np.zeros((0, 4), np.int32)
    local = rows[:, :3].astype(np.float64) @ view.axes.T
    radius, scale = rows[:, RADIUS].astype(np.float64), view.scale(size[1])
    edges = np.zeros((len(rows), 2, 2))
    for axis, sign in ((0, 1.0), (1, -1.0)):
        x, z = sign * local[:, axis], local[:, 2]
        if view.height is not None:
            low, high = x - radius, x + radius
        else:
            square = z * z - radius * radius
            reach = radius * np.sqrt(np.maximum(x * x + square, 0.0))
            safe = np.where(square > 0.0, square, 1.0)
            low = np.where((square > 0.0) & (z > 0.0), (x * z - reach) / safe, -_EXACT)
            high = np.where((square > 0.0) & (z > 0.0), (x * z + reach) / safe, _EXACT)
        edges[:, axis, 0], edges[:, axis, 1] = low * scale + 0.5 * size[axis], high * scale + 0.5 * size[axis]
    limits = np.array(size)[None, :, None] - 1
    pixels = np.floor(np.clip(edges, -_EXACT, _EXACT)).astype(np.int64)
    outside = ((pixels[:, :, 1] < 0) | (pixels[:, :, 0] > limits[:, :, 0])).any(axis=1)
    pixels = np.clip(pixels, 0, limits)
    pixels[outside] = (0, -1)
    return np.ascontiguousarray(pixels.reshape(-1, 4), np.int32)
