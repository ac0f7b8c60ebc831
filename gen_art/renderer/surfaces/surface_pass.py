"""Draws the surfaces of a scene: gathers colliders, solids and light for the kernel of draw_surfaces.py."""

import numpy as np

from gen_art.preset.surface import Finish, SurfaceLook
from gen_art.renderer.colour import linear
from gen_art.renderer.emissive_lighting import EmittedLight
from gen_art.renderer.surfaces.cell_lists import cell_lists
from gen_art.renderer.surfaces.draw_surfaces import BIN, SUBPIXELS, TILE, draw_kernel
from gen_art.renderer.surfaces.glow_scene import NO_GLOW, GlowScene
from gen_art.renderer.surfaces.lamp_shadows import lamp_disc
from gen_art.renderer.surfaces.mirror_film import NO_MIRROR, MirrorFilm, blur_points
from gen_art.renderer.surfaces.reflection import reflected_share
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.scene_numbers import scene_numbers
from gen_art.renderer.surfaces.shadow_casters import ShadowCasters, filled
from gen_art.renderer.surfaces.sky_light import SkyLight
from gen_art.renderer.surfaces.solid_rows import SolidSystem, mean_areas, pixel_rectangles
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
        self, scene: Scene, casters: ShadowCasters, solids: list[SolidSystem], smoke, framebuffer,
        film: MirrorFilm = NO_MIRROR, clip=None, emitted: EmittedLight | None = None,
    ) -> None:  # fmt: skip
        """Draw the surfaces of a scene, and solids, into a clear framebuffer.

        casters : the scene's colliders and the rows of all solids
        smoke : (Smoke along the lamp's axes, its optical depths from the lamp) that shadows surfaces, or None
        film : what the scene's mirror shows
        clip : (point, normal) of the plane before which nothing is drawn, or None
        emitted : the light of particles on the surfaces, or None
        """
        view, time, rows, light, bins = casters.view, casters.time, casters.rows, casters.light, casters.bins
        if clip is None:
            check_camera(casters.terms, view, time)
            if not self._checked:
                check_distances(casters.terms, view, time)
                self._checked = True
        looks = [*(look for _, look in scene.surfaces), *(system.finish for system in solids)]
        table = np.stack([_material(look) for look in looks])
        shares = np.stack([reflected_share(look.roughness, look.ior) for look in looks])
        positions, radii = rows[:, :3].astype(np.float64) + view.position, rows[:, BOUND].astype(np.float64)
        sky = SkyLight.of(light, positions, mean_areas(rows) * scene.shadows, radii)
        grid, depths = smoke if smoke is not None and scene.shadows else (None, np.zeros(1, np.float32))
        mirror = scene.mirror if film is not NO_MIRROR else -1
        numbers = scene_numbers(view, self.size, time, light, scene.shadows, bins, sky, grid, clip, mirror)
        rectangles = pixel_rectangles(rows, view, self.size)
        across, down = framebuffer.across, framebuffer.down
        first, last = rectangles[:, 2::-2] // BIN, rectangles[:, 3::-2] // BIN
        bin_starts, bin_solids = cell_lists(first, last, (down, across))
        owners = np.array(casters.terms.owners or [0], np.int32)
        glow = None if emitted is None else GlowScene.of(scene, casters, solids, emitted)
        draw_kernel(casters.terms, glow is not None)(
            numbers, casters.terms.numbers(), owners, table, shares, filled(rows), filled(rectangles), bin_starts,
            filled(bin_solids), bins.starts, filled(bins.solids), self._disc, sky.light, sky.open, depths, across, down,
            framebuffer.buffer, framebuffer.stride, self.depths, self.bounds, film.texels, film.levels, self._blur,
            light.dome.table if light.dome is not None else _NO_DOME, *(NO_GLOW if glow is None else glow).arrays,
        )  # fmt: skip


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
