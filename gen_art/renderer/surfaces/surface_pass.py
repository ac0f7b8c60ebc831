"""Draws the surfaces of a scene: gathers colliders, solids and light for the kernel of draw_surfaces.py."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gen_art.preset.surface import TRACED_ROUGHNESS, Finish, SurfaceLook
from gen_art.renderer.colour import linear
from gen_art.renderer.emissive_lighting import EmittedLight
from gen_art.renderer.picture_tiles import BIN, TILE
from gen_art.renderer.surfaces.caustics import caustic_photons
from gen_art.renderer.surfaces.cell_lists import cell_lists
from gen_art.renderer.surfaces.draw_surfaces import draw_kernel
from gen_art.renderer.surfaces.glow_scene import NO_GLOW, GlowScene
from gen_art.renderer.surfaces.lamp_shadows import lamp_disc
from gen_art.renderer.surfaces.light_parts import MIRROR_PARTS, OWN_PARTS, LightParts
from gen_art.renderer.surfaces.liquid_shadow import NO_LIQUID, LiquidShadow
from gen_art.renderer.surfaces.mirror_film import NO_MIRROR, MirrorFilm, blur_points
from gen_art.renderer.surfaces.photon_cells import NO_PHOTONS
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS
from gen_art.renderer.surfaces.reflection import reflected_share
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.scene_numbers import (
    PHOTON_CELL,
    SMOKE_CELL,
    SMOKE_CORNER,
    SMOKE_SHAPE,
    TIME,
    scene_numbers,
)
from gen_art.renderer.surfaces.shadow_casters import NO_SKY, ShadowCasters, filled
from gen_art.renderer.surfaces.sheet_rows import face_rectangles
from gen_art.renderer.surfaces.sky_light import RESOLUTION, SkyLight
from gen_art.renderer.surfaces.sky_occlusion import sky_occluders
from gen_art.renderer.surfaces.solid_grid import SolidGrid
from gen_art.renderer.surfaces.solid_rows import pieces, pixel_rectangles
from gen_art.renderer.surfaces.solids import BOUND, MATERIAL, NEVER
from gen_art.renderer.surfaces.surface_detail import (
    CHECKER,
    DAMP,
    EMISSION,
    IMAGE,
    IOR,
    LIGHT,
    LIGHT_FACTOR,
    MATERIAL_FLOATS,
    METAL,
    PER_LENGTH,
    PUDDLES,
    RELIEF,
    ROUGHNESS,
    SECOND_ALBEDO,
    TRANSMISSION,
    WAVE_FIELD,
    WAVES,
)
from gen_art.renderer.surfaces.surface_layers import NO_LAYERS, SurfaceLayers
from gen_art.renderer.surfaces.surface_maps import NO_MAPS, SurfaceMaps
from gen_art.renderer.surfaces.view_problems import check_camera, check_distances
from gen_art.renderer.surfaces.wave_field import NO_FIELD, wave_field

__all__ = ["SurfacePass"]


_THROUGH = 0.85  # of the sky's light, what clear glass lets pass: it reflects some 15% of light from all sides
_NO_DOME = np.zeros((2, 2, 3), np.float32)
_NO_PARTS = np.zeros((1, 1, OWN_PARTS), np.float32), np.zeros((1, 1, MIRROR_PARTS), np.float32)


class SceneArrays(NamedTuple):
    """What kernels read to light a place of a surface; the letters of draw_surfaces.py are in the comments."""

    numbers: np.ndarray  # N
    colliders: np.ndarray  # Q
    materials: np.ndarray  # M
    shares: np.ndarray  # E
    solids: np.ndarray  # B
    shadow_starts: np.ndarray
    shadow_solids: np.ndarray
    disc: np.ndarray  # D
    sky: np.ndarray
    open_sky: np.ndarray
    smoke: np.ndarray
    film: np.ndarray  # T
    levels: np.ndarray
    blur: np.ndarray  # G
    dome: np.ndarray
    liquid_first: np.ndarray
    liquid_depths: np.ndarray


class SurfacePass:
    """Draws surfaces into framebuffers of one size. Of the last picture it keeps

    depths : (rows, columns, SUBPIXELS) along the line of sight
    bounds : (down, across, 2), the least and the largest of each tile of 8 x 8 pixels
    arrays : SceneArrays, with which liquids are lit
    """

    arrays: SceneArrays

    def __init__(self, size: tuple[int, int]):
        self.size = size
        self.depths = np.full((size[1], size[0], SUBPIXELS), NEVER, np.float32)
        self.bounds = np.full((-(-size[1] // TILE), -(-size[0] // TILE), 2), NEVER, np.float32)
        self._checked = False  # whether the shapes' distances were tested, once for a film
        self._sky: tuple | None = None  # ((the light from all sides, what hides it), the SkyLight of these)
        self._parts: LightParts | None = None
        self._maps = NO_MAPS
        self._disc, self._blur = lamp_disc(), blur_points()

    def check_again(self) -> None:
        """Test the distances of the shapes at the next picture: it is of another scene."""
        self._checked = False

    def draw(
        self, scene: Scene, casters: ShadowCasters, finishes: Sequence[Finish], smoke, framebuffer,
        film: MirrorFilm = NO_MIRROR, clip=None, emitted: EmittedLight | None = None, liquid: LiquidShadow = NO_LIQUID,
        hidden_by=None, layers: SurfaceLayers | None = None, shaded: bool = True, resting_view: bool = False,
    ) -> None:  # fmt: skip
        """Draw the surfaces of a scene, solids and cloth into a clear framebuffer.

        casters : the scene's colliders and the rows of all solids and cloth
        finishes : of the solids' systems, then of the cloths', then of liquids, which are drawn later
        smoke : (Smoke along the lamp's axes, its optical depths from the lamp) that shadows surfaces, or None
        film : what the scene's mirror shows
        clip : (point, normal) of the plane before which nothing is drawn, or None
        emitted : the light of particles on the surfaces, or None
        liquid : the shadow that liquids cast
        hidden_by : (positions, extinction cross sections, radii) of their particles, which hide the sky, or None
        layers : which are filled, or None
        shaded : whether the picture is drawn; else the depths alone are found
        resting_view : whether the next pictures are drawn from the same view
        """
        view, time, rows, light, bins = casters.view, casters.time, casters.rows, casters.light, casters.bins
        if clip is None and shaded:
            check_camera(casters.terms, view, time)
            if not self._checked:
                check_distances(casters.terms, view, time)
                self._checked = True
        looks = [*(look for _, look in scene.surfaces), *finishes]
        table = np.stack([_material(look) for look in looks])
        maps = self._maps = SurfaceMaps.of(looks, table, (IMAGE, PUDDLES, LIGHT, RELIEF, WAVES), time, self._maps)
        shares = np.stack([reflected_share(look.roughness, look.ior) for look in looks])
        cloth = casters.sheets
        sky = self._sky_light(casters, table, hidden_by, scene.shadows) if shaded else NO_SKY
        grid, depths = smoke if smoke is not None and scene.shadows else (None, np.zeros(1, np.float32))
        mirror = scene.mirror if film is not NO_MIRROR else -1
        smooth = table[:, ROUGHNESS] <= TRACED_ROUGHNESS
        if scene.mirror >= 0 and (mirror >= 0 or clip is not None):
            smooth[scene.mirror] = False  # it is read from its film, and not seen from behind
        follows = table[:, TRANSMISSION].any() or (smooth.any() and _more_than_one(scene, len(rows)))
        follows = shaded and bool(follows)
        places = SolidGrid.of(rows) if follows else SolidGrid.none()
        numbers = scene_numbers(
            view, self.size, time, light, scene.shadows, bins, sky, grid, places, clip, mirror, liquid
        )
        rectangles = pixel_rectangles(rows, view, self.size)
        across, down = framebuffer.across, framebuffer.down
        bin_starts, bin_solids = _in_bins(rectangles, (down, across))
        of_faces = face_rectangles(cloth, view, self.size)
        face_starts, bin_faces = _in_bins(of_faces, (down, across))
        owners = np.array(casters.terms.owners or [0], np.int32)
        photons = NO_PHOTONS
        if shaded and scene.shadows and table[:, TRANSMISSION].any():
            photons = caustic_photons(casters, scene.surfaces, table, owners, numbers, depths, places)
            numbers[PHOTON_CELL] = photons.cell
        glow = None if emitted is None else GlowScene.of(casters, emitted)
        self.arrays = SceneArrays(
            numbers, casters.terms.numbers(), table, shares, filled(rows), bins.starts, filled(bins.solids), self._disc,
            sky.light, sky.open, depths, film.texels, film.levels, self._blur,
            light.dome.table if light.dome is not None else _NO_DOME, liquid.first, liquid.depths,
        )  # fmt: skip
        if clip is not None and len(scene.surfaces) == 1 and not len(rows) and not cloth.any:
            self.depths.fill(NEVER)  # behind the mirror there is none but the mirror itself
            self.bounds.fill(NEVER)
            self.forget()
            return
        of_glow = (NO_GLOW if glow is None else glow).arrays
        a, wanted, occluders = self.arrays, layers or NO_LAYERS, sky_occluders(scene.surfaces, _THROUGH)
        parts, drawn_with = None, numbers
        changes = follows or cloth.any or liquid is not NO_LIQUID or layers is not None
        if (
            resting_view
            and shaded
            and not changes
            and not any(look.waves for look in looks if isinstance(look, SurfaceLook))
        ):
            parts, drawn_with = self._light_parts(mirror >= 0), _without_smoke(numbers, scene.surfaces)
            resting = parts.rest(
                casters.terms, drawn_with, a.colliders, owners, a.materials, a.shares, a.solids, a.sky, a.open_sky, a.dome,
                occluders, maps.texels, maps.waves, *of_glow,
            )  # fmt: skip
        if parts is None:
            self.forget()
        if parts is None or not resting:
            field = self._wave_field(scene, table, maps, numbers, clip) if shaded else NO_FIELD
            own_light, mirrored = (parts.own, parts.mirrored) if parts is not None else _NO_PARTS
            options = follows, cloth.any, glow is not None, maps.any, layers is not None, shaded, parts is not None
            draw_kernel(casters.terms, *options)(
                drawn_with, a.colliders, owners, a.materials, a.shares, a.solids, filled(rectangles), bin_starts,
                filled(bin_solids), a.shadow_starts, a.shadow_solids, a.disc, a.sky, a.open_sky, a.smoke, across, down,
                framebuffer.buffer, framebuffer.stride, self.depths, self.bounds, a.film, a.levels, a.blur, a.dome,
                a.liquid_first, a.liquid_depths, places.starts, filled(places.solids), photons.rows, photons.starts,
                filled(cloth.corners), filled(cloth.faces), filled(cloth.looks), cloth.grid, cloth.starts,
                filled(cloth.listed), filled(of_faces), face_starts, filled(bin_faces),
                *of_glow, occluders, maps.texels, maps.waves, field, film.depths, wanted.values,
                wanted.earlier, wanted.solids, wanted.corners, own_light, mirrored,
            )  # fmt: skip
        if parts is not None:
            parts.put_together(numbers, a.smoke, film, a.blur, maps.any, self.depths, self.bounds, framebuffer)

    def _wave_field(self, scene: Scene, table: np.ndarray, maps: SurfaceMaps, numbers: np.ndarray, clip) -> np.ndarray:
        """The wave_field of the surfaces that have waves; `table` gets which array is whose."""
        waved = [k for k, (_, look) in enumerate(scene.surfaces) if look.waves is not None]
        if clip is not None:
            waved = [k for k in waved if k != scene.mirror]  # which is not drawn
        if not waved:
            return NO_FIELD
        table[waved, WAVE_FIELD] = np.arange(len(waved))
        heights = [scene.surfaces[k][0].values["point"][1] for k in waved]
        return wave_field(numbers, maps.waves, heights, table[waved, WAVES : WAVES + 3], self.size)

    def forget(self) -> None:
        """Draw the next picture anew, even if nothing has moved: for who changes the depths."""
        if self._parts is not None:
            self._parts.forget()

    def _light_parts(self, with_mirror: bool) -> LightParts:
        if self._parts is None or self._parts.with_mirror != with_mirror:
            self._parts = LightParts(self.size, with_mirror)
        return self._parts

    def _sky_light(self, casters: ShadowCasters, table: np.ndarray, hidden_by, shadows: bool) -> SkyLight:
        """The sky's light past what hides it; that of the last picture where neither has changed."""
        positions, areas, radii = _hiding_sky(casters, table, hidden_by)
        hiding = positions, areas * shadows, radii
        given = casters.light.ambient, *hiding
        if self._sky is None or not all(map(np.array_equal, self._sky[0], given)):
            self._sky = given, SkyLight.of(casters.light, *hiding)
        return self._sky[1]


def _without_smoke(numbers: np.ndarray, surfaces) -> np.ndarray:
    """N without the smoke's grid, and at time 0 where no collider moves: equal as long as the surfaces rest."""
    result = numbers.copy()
    result[SMOKE_CORNER : SMOKE_CORNER + 3], result[SMOKE_CELL], result[SMOKE_SHAPE : SMOKE_SHAPE + 3] = 0.0, 1.0, 0.0
    if not any(collider.moves for collider, _ in surfaces):
        result[TIME] = 0.0
    return result


def _more_than_one(scene: Scene, solids: int) -> bool:
    """Whether a ray that leaves a surface may meet another, or the same one again."""
    alone = all(collider.convex and collider.sides == 1 for collider, _ in scene.surfaces)
    return len(scene.surfaces) + solids > 1 or not alone


def _hiding_sky(casters: ShadowCasters, table: np.ndarray, hidden_by) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(positions, areas, radii) of what hides the sky: solids, cloth, and the particles of liquids; `table` of materials."""
    rows, cloth = casters.rows, casters.sheets
    row, centers, areas, radii = pieces(rows, 2.0 * _cell_of(rows))
    positions = centers + casters.view.position
    areas = areas * (1.0 - _THROUGH * table[rows[row, MATERIAL].astype(np.int64), TRANSMISSION])
    if cloth.any:  # a triangle's shadow is half as large as the triangle, as the mean over all directions
        positions, areas = np.concatenate([positions, cloth.centers]), np.concatenate([areas, 0.5 * cloth.areas])
        radii = np.concatenate([radii, np.sqrt(cloth.areas / np.pi)])
    if hidden_by is not None:
        positions, areas, radii = (np.concatenate(pair) for pair in zip((positions, areas, radii), hidden_by))
    return positions, areas, radii


def _cell_of(rows: np.ndarray) -> float:
    """About the cell of a SkyLight among solids of these rows, m."""
    if not len(rows):
        return 1.0
    bound = rows[:, BOUND, None]
    extent = (rows[:, :3] + bound).max(axis=0) - (rows[:, :3] - bound).min(axis=0)
    return float(extent.max()) / RESOLUTION


def _in_bins(rectangles: np.ndarray, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The lists of rectangles of pixels that touch each bin of a framebuffer of this many bins down and across."""
    return cell_lists(rectangles[:, 2::-2] // BIN, rectangles[:, 3::-2] // BIN, shape)


def _material(look: Finish) -> np.ndarray:
    """The row of the kernel's materials."""
    row = np.zeros(MATERIAL_FLOATS, np.float32)
    row[ROUGHNESS], row[IOR], row[METAL] = look.roughness, look.ior, look.metal
    row[TRANSMISSION], row[WAVE_FIELD] = look.transmission, -1.0
    row[PER_LENGTH] = 0.0 if look.attenuation_distance is None else 1.0 / look.attenuation_distance
    if isinstance(look, SurfaceLook):
        row[:3] = linear(look.albedo)
        if look.checker is not None:
            row[SECOND_ALBEDO : SECOND_ALBEDO + 3], row[CHECKER] = linear(look.checker.color), look.checker.size
        row[DAMP] = 0.0 if look.puddles is None else look.puddles.damp
        row[EMISSION : EMISSION + 3] = linear(look.emission) * look.emission_intensity
        row[LIGHT_FACTOR] = look.emission_intensity
    return row
