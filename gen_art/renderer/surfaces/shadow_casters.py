"""What shadows the lamp of a picture: colliders with a look, solids and cloth; and the light among them on a grid of smoke.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from gen_art.backend.kernel_views import particle as arrays
from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.camera import CameraView
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.smoke_density import Smoke
from gen_art.renderer.smoke_lighting import lamp_axes
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.collider_sets import every_caster
from gen_art.renderer.surfaces.lamp_shadows import ShadowBins, lamp_disc
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.scene_numbers import scene_numbers
from gen_art.renderer.surfaces.sheet_rows import Sheets, SheetSystem
from gen_art.renderer.surfaces.sky_light import SkyLight
from gen_art.renderer.surfaces.solid_rows import SolidSystem, solid_rows
from gen_art.renderer.surfaces.solids import BOUND
from gen_art.renderer.surfaces.surface_light import lamp_share

__all__ = ["NO_SKY", "ShadowCasters", "filled"]

F1, F2, I1, I2 = (ti.types.ndarray(d, n) for d, n in ((ti.f32, 1), (ti.f32, 2), (ti.i32, 1), (ti.i32, 2)))
NO_SKY = SkyLight(np.zeros(3), 1.0, (1, 1, 1), np.zeros((1, 12), np.float32), np.zeros(12, np.float32))


def filled(array: np.ndarray) -> np.ndarray:
    """The array, or a row of zeros in place of an empty one, which kernels do not take."""
    return array if len(array) else np.zeros((1, *array.shape[1:]), array.dtype)


@cache
def _share_kernel(terms: ColliderTerms, with_sheets: bool):
    kinds = terms.kinds

    @ti.kernel
    def shares(
        N: F1, Q: F1, B: F2, shadow_starts: I1, shadow_solids: I1, D: F2, smoke: F1, X: F2, pixel: ti.f32, out: F1, V: F2,
        faces: I2, sheet_grid: F1, sheet_starts: I1, sheet_faces: I1,
    ):  # fmt: skip
        """out[i]: the share of the lamp's light that reaches X[i], relative to the camera; edges are `pixel` wide or wider."""
        ti.loop_config(block_dim=1)
        for block in range((X.shape[0] + 255) // 256):
            scene = arrays(
                N=N, Q=Q, B=B, shadow_starts=shadow_starts, shadow_solids=shadow_solids, D=D, smoke=smoke,
                with_sheets=with_sheets, V=V, faces=faces, sheet_grid=sheet_grid,
                sheet_starts=sheet_starts, sheet_faces=sheet_faces,
            )  # fmt: skip
            for i in range(block * 256, ti.min((block + 1) * 256, X.shape[0])):
                out[i] = lamp_share(kinds, scene, ti.Vector([X[i, 0], X[i, 1], X[i, 2]]), pixel, every_caster())

    return kernel(shares)


@dataclass(frozen=True, eq=False)
class ShadowCasters:
    """Colliders, solids and cloth that shadow a lamp.

    light : the lamp
    terms : the colliders, laid out for kernels
    rows : (n, SOLID_FLOATS) of the solids, relative to the camera
    bins : the solids in cells across the lamp's rays
    sheets : the cloth
    view, time : the camera, and simulated seconds
    glowing : materials of the solids whose own light falls on others
    """

    light: Lighting
    terms: ColliderTerms
    rows: np.ndarray
    bins: ShadowBins
    sheets: Sheets
    view: CameraView
    time: float
    glowing: tuple[int, ...] = ()

    @classmethod
    def of(
        cls, scene: Scene, solids: list[SolidSystem], sheets: list[SheetSystem], view: CameraView, time: float
    ) -> "ShadowCasters":
        """Those of a scene, its solids and its cloth. Their materials follow those of the scene's surfaces."""
        first = len(scene.surfaces)
        rows = solid_rows(solids, first, view)
        terms = ColliderTerms([collider for collider, _ in scene.surfaces])
        positions, radii = rows[:, :3].astype(np.float64) + view.position, rows[:, BOUND].astype(np.float64)
        light = scene.lighting
        axes = lamp_axes(light.direction)
        bins = ShadowBins.of(positions, radii, axes)
        glowing = tuple(first + k for k, system in enumerate(solids) if system.glows)
        return cls(light, terms, rows, bins, Sheets.of(sheets, first + len(solids), view, axes), view, time, glowing)

    def lamp_shares(self, light: Lighting, smoke: Smoke) -> np.ndarray:
        """(nodes,) float32: the share of a lamp's light that reaches each node of a grid of smoke past them.

        It is 1 for a lamp in another direction.
        """
        count = smoke.extinction.size
        if not np.array_equal(light.direction, self.light.direction):
            return np.ones(count, np.float32)
        nodes = np.indices(smoke.extinction.shape).reshape(3, -1).T + smoke.corner
        places = (nodes * smoke.cell) @ smoke.axes - self.view.position
        numbers = scene_numbers(self.view, (1, 1), self.time, self.light, True, self.bins, NO_SKY, None)
        out = np.zeros(count, np.float32)
        cloth = self.sheets
        _share_kernel(self.terms, cloth.any)(
            numbers, self.terms.numbers(), filled(self.rows), self.bins.starts, filled(self.bins.solids), lamp_disc(),
            np.zeros(1, np.float32), np.ascontiguousarray(places, np.float32), float(smoke.cell), out,
            filled(cloth.corners), filled(cloth.faces), cloth.grid, cloth.starts, filled(cloth.listed),
        )  # fmt: skip
        return out
