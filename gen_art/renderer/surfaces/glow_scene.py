"""The light of emitting particles, gathered for the kernel that draws surfaces: the tree, its lamps, and what may hide them."""

from dataclasses import dataclass

import numpy as np

from gen_art.colliders.plane import Plane
from gen_art.renderer.emissive_lighting import EmittedLight
from gen_art.renderer.surfaces.caustics import bounding_ball
from gen_art.renderer.surfaces.collider_rays import cast_by
from gen_art.renderer.surfaces.glow_light import GLOW_POINTS, LAMP_FLOATS, LAMP_RADIUS, SOFTENING2
from gen_art.renderer.surfaces.lamp_shadows import lamp_disc
from gen_art.renderer.surfaces.light_tree import LIGHT_FLOATS, NODE_FLOATS, LightTree, lamp_radii
from gen_art.renderer.surfaces.near_bins import NearBins
from gen_art.renderer.surfaces.shadow_casters import ShadowCasters
from gen_art.renderer.surfaces.solids import AXES, BOUND, CENTER, HALF, MATERIAL, RADIUS

_DISC = lamp_disc(GLOW_POINTS)

__all__ = ["NO_GLOW", "GlowScene"]


@dataclass(frozen=True)
class GlowScene:
    """What the kernel reads, relative to the camera.

    arrays : nodes, links and lights of the LightTree, (k, 2) parts, (k, LAMP_FLOATS) lamps, then starts and
        solids of NearBins, and the points of a lamp's disc
    """

    arrays: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, casters: ShadowCasters, emitted: EmittedLight) -> "GlowScene | None":
        """None if nothing emits any light."""
        key = casters.light.key
        power = emitted.power * key.glow_intensity
        rows = casters.rows
        own = np.isin(rows[:, MATERIAL], casters.glowing)
        centers, radii = rows[:, CENTER : CENTER + 3].astype(np.float64), rows[:, BOUND].astype(np.float64)
        balls = _casting_balls(casters, centers[~own], radii[~own])
        tree = LightTree.of(emitted.positions, power, emitted.areas, key.glow_softness, casters.view.position, balls)
        if tree is None:
            return None
        top = tree.nodes[tree.lamps[:, 0]]
        lamps = np.zeros((len(top), LAMP_FLOATS), np.float32)
        lamps[:, :3], lamps[:, SOFTENING2] = top[:, :3], key.glow_softness**2
        lamps[:, LAMP_RADIUS] = lamp_radii(top)
        places = lamps[:, :3].astype(np.float64)
        holding = np.array([_around(rows, place) for place in places])
        bins = NearBins.of(places, lamps[:, LAMP_RADIUS].astype(np.float64), centers, radii, own, holding)
        return cls((tree.nodes, tree.links, tree.lights, tree.lamps, lamps, bins.starts, bins.solids, _DISC))


def _casting_balls(casters: ShadowCasters, centers: np.ndarray, radii: np.ndarray):
    """(centres relative to the camera, radii) of balls around solids, as given, and colliders that cast shadows; None where a
    collider's extent is not known."""
    for collider in casters.terms.colliders:
        if cast_by(collider) and not isinstance(collider, Plane):
            ball = bounding_ball(collider, casters.time)
            if ball is None:
                return None
            centers = np.concatenate([centers, (ball[0] - casters.view.position)[None]])
            radii = np.append(radii, ball[1])
    return centers, radii


def _around(rows: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(n,) bool, the solids that contain a place; rows : (n, SOLID_FLOATS)."""
    numbers = rows.astype(np.float64)
    offset, axes = place - numbers[:, CENTER : CENTER + 3], numbers[:, AXES : AXES + 9].reshape(-1, 3, 3)
    beyond = abs((axes * offset[:, None, :]).sum(axis=2)) - numbers[:, HALF : HALF + 3]
    return np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1)) <= numbers[:, RADIUS]


NO_GLOW = GlowScene(
    (
        np.zeros((1, NODE_FLOATS), np.float32), np.zeros((1, 3), np.int32), np.zeros((1, LIGHT_FLOATS), np.float32),
        np.zeros((1, 2), np.int32), np.zeros((1, LAMP_FLOATS), np.float32), np.zeros(2, np.int32), np.zeros(1, np.int32),
        _DISC,
    )
)  # fmt: skip
