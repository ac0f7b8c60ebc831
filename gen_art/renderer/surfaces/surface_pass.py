"""Draws the surfaces of a scene: gathers colliders, solids and light for the kernel of draw_surfaces.py."""

import numpy as np

from gen_art.preset.surface import Finish, SurfaceLook
from gen_art.renderer.colour import linear
from gen_art.renderer.smoke_lighting import lamp_axes
from gen_art.renderer.surfaces.cell_lists import cell_lists
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.draw_surfaces import BIN, SUBPIXELS, TILE, draw_kernel
from gen_art.renderer.surfaces.lamp_shadows import ShadowBins, lamp_disc
from gen_art.renderer.surfaces.mirror_film import NO_MIRROR, MirrorFilm, blur_points
from gen_art.renderer.surfaces.reflection import reflected_share
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.scene_numbers import lamp_tangent, scene_numbers
from gen_art.renderer.surfaces.sky_light import SkyLight
from gen_art.renderer.surfaces.solid_rows import SolidSystem, pixel_rectangles, solid_rows
from gen_art.renderer.surfaces.solids import BOUND
from gen_art.renderer.surfaces.surface_shading import (
    CHECKER,
    EMISSION,
    IOR,
    MATERIAL_FLOATS,
    METAL,
    ROUGHNESS,
    SECOND_ALBEDO,
)
from gen_art.renderer.surfaces.view_problems import check_camera, check_distances

__all__ = ["SurfacePass"]


_NO_DOME = np.zeros((2, 2, 3), np.float32)


class SurfacePass:
    """Draws surfaces into framebuffers of one size. Of the last picture it keeps

    depths : (rows, columns, SUBPIXELS) along the line of sight
    bounds : (down, across, 2), the least and the largest of each tile of 8 x 8 pixels
    """

    def __init__(self, size: tuple[int, int]):
        self.size = size
        self.depths = np.zeros((size[1], size[0], SUBPIXELS), np.float32)
        self.bounds = np.zeros((-(-size[1] // TILE), -(-size[0] // TILE), 2), np.float32)
        self._checked = False  # whether the shapes' distances were tested, once for a film
        self._disc, self._blur = lamp_disc(), blur_points()

    def draw(
        self, scene: Scene, view, time: float, solids: list[SolidSystem], smoke, framebuffer,
        film: MirrorFilm = NO_MIRROR, clip=None,
    ) -> bool:  # fmt: skip
        """Draw what there is into a clear framebuffer; False if there is nothing to draw.

        solids : of each system of them
        smoke : (Smoke along the lamp's axes, its optical depths from the lamp) that shadows surfaces, or None
        film : what the scene's mirror shows
        clip : (point, normal) of the plane before which nothing is drawn, or None
        """
        surfaces = scene.surfaces
        rows = solid_rows(solids, len(surfaces), view)
        if not surfaces and not len(rows):
            return False
        light = scene.lighting
        terms = ColliderTerms([collider for collider, _ in surfaces])
        if clip is None:
            check_camera(terms, view, time)
            if not self._checked:
                check_distances(terms, view, time)
                self._checked = True
        looks = [*(look for _, look in surfaces), *(system.finish for system in solids)]
        table = np.stack([_material(look) for look in looks])
        shares = np.stack([reflected_share(look.roughness, look.ior) for look in looks])
        positions, radii = rows[:, :3].astype(np.float64) + view.position, rows[:, BOUND].astype(np.float64)
        depth = _extent(positions, radii, view)
        bins = ShadowBins.of(positions, radii, lamp_axes(light.direction), lamp_tangent(light), depth)
        sky = SkyLight.of(light, positions, np.pi * radii**2 * scene.shadows, radii)
        grid, depths = smoke if smoke is not None and scene.shadows else (None, np.zeros(1, np.float32))
        mirror = scene.mirror if film is not NO_MIRROR else -1
        numbers = scene_numbers(view, self.size, time, light, scene.shadows, bins, sky, grid, clip, mirror)
        rectangles = pixel_rectangles(rows, view, self.size)
        across, down = framebuffer.across, framebuffer.down
        first, last = rectangles[:, 2::-2] // BIN, rectangles[:, 3::-2] // BIN
        bin_starts, bin_solids = cell_lists(first, last, (down, across))
        draw_kernel(terms)(
            numbers, terms.numbers(), np.array(terms.owners or [0], np.int32), table, shares, _some(rows), _some(rectangles),
            bin_starts, _some(bin_solids), bins.starts, _some(bins.solids), self._disc, sky.light, sky.open, depths, across, down,
            framebuffer.buffer, framebuffer.stride, self.depths, self.bounds, film.texels, film.levels, self._blur,
            light.dome.table if light.dome is not None else _NO_DOME,
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


def _extent(positions, radii, view) -> float:
    """How far a shadow may fall: twice the extent of all solids, and the distance to the camera's target."""
    if not len(positions):
        return view.distance
    return 2.0 * float(np.ptp(positions, axis=0).max() + radii.max()) + view.distance
