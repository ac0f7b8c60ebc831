"""AOVs (extra layers) of a picture for compositing: depth and motion of all that it shows, and what its surfaces are like.

Z is the distance along the line of sight in world units. `velocity` is how far a pixel's content moved since the previous
frame, in pixels to the right and down, including the camera's own motion. Both are means over the sprites and surfaces of a
pixel, each weighted by the light and the coverage that it adds, and 0 where nothing is drawn.

The others are of surfaces alone, as if no sprite were before them: smoke has no normal. `albedo` is the part of light that is
scattered, times the share of the pixel that surfaces cover, as for red, green and blue. `normal` is the mean unit normal in the
world, 0 where there is no surface. `shadow` is the share of the lamp's light that arrives: 0 in the shadow and on the far side,
1 where there is no surface, so that one may multiply by it. Trails and ribbons are not part of these layers;
what flashes left is, if it is half opaque or more.
"""

import numpy as np

from gen_art.particles.rows import POSITION, VELOCITY
from gen_art.renderer.colour import LUMINANCE
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, GREEN, RED
from gen_art.renderer.surfaces.surface_layers import ALBEDO, DISTANCE, MOTION, NORMAL, SHADOWED, SurfaceLayers

__all__ = ["LAYERS", "SURFACE_LAYERS", "render_aovs"]

LAYERS = ("Z", "velocity.x", "velocity.y")
SURFACE_LAYERS = ("albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "shadow")
_WEIGHTS = LUMINANCE.astype(np.float32)


def render_aovs(painter, sim, film_time: float, frame: float, seconds: float) -> dict[str, np.ndarray]:
    """LAYERS, and SURFACE_LAYERS of a painter that shows surfaces, each (height, width) float32.

    frame : film seconds of a frame
    seconds : simulated seconds of a frame
    """
    back = min(frame, film_time)
    view, earlier = painter.view(sim, film_time), painter.view(sim, film_time, back, seconds * back / frame)
    layers = SurfaceLayers.of(painter.size, view, earlier, seconds) if painter.shows_surfaces else None

    def weigh(system, channels):
        channels[RED] = np.tensordot(_WEIGHTS, channels[RED : BLUE + 1], 1) + channels[ALPHA]
        channels[GREEN : BLUE + 1] = 0.0

    def measure(system, channels):
        weigh(system, channels)
        position = np.asarray(system.floats[POSITION, : channels.shape[1]], np.float64).T
        before = position - seconds * np.asarray(system.floats[VELOCITY, : channels.shape[1]], np.float64).T
        with np.errstate(all="ignore"):
            motion = view.project(position, painter.size) - earlier.project(before, painter.size)
        motion[~np.isfinite(motion).all(axis=1)] = 0.0
        weight = channels[RED].copy()
        channels[RED], channels[GREEN], channels[BLUE] = (
            weight * channels[DEPTH],
            weight * motion[:, 0],
            weight * motion[:, 1],
        )

    def weigh_surfaces(pixels):
        pixels[..., 0] = pixels[..., :3] @ _WEIGHTS + pixels[..., 3]
        pixels[..., 1:3] = 0.0

    def measure_surfaces(pixels):
        weigh_surfaces(pixels)
        if layers is not None:  # sums over the share of the pixel that is covered, of which the weight is a mean
            weight = pixels[..., 0] / np.maximum(pixels[..., 3], 1e-30)
            pixels[..., :3] = layers.values[..., DISTANCE : MOTION + 2] * weight[..., None]

    sums, weights = painter.draw_passes(sim, film_time, [(measure, measure_surfaces), (weigh, weigh_surfaces)], layers)
    total = weights[..., 0]
    drawn = total > 1e-6 * max(float(total.max()), 1e-30)
    mean = sums[..., :3] / np.where(drawn, total, 1.0)[..., None]
    mean = np.where(drawn[..., None], mean, 0.0).astype(np.float32)
    mean[..., 1:] /= painter.supersample
    found = {name: np.ascontiguousarray(mean[..., k]) for k, name in enumerate(LAYERS)}
    if layers is not None:
        of_surfaces = _of_surfaces(layers.values, painter.supersample)
        found |= {name: np.ascontiguousarray(of_surfaces[..., k]) for k, name in enumerate(SURFACE_LAYERS)}
    return found


def _of_surfaces(values: np.ndarray, times: int) -> np.ndarray:
    """(height, width, 7) of SURFACE_LAYERS from the layers of a picture that is `times` as wide and as high."""
    rows, columns = values.shape[0] // times, values.shape[1] // times
    means = values.reshape(rows, times, columns, times, -1).mean(axis=(1, 3))
    normal = means[..., NORMAL : NORMAL + 3]
    length = np.sqrt((normal * normal).sum(axis=2))[..., None]
    normal = np.where(length > 1e-6, normal / np.maximum(length, 1e-6), 0.0)
    shadow = np.clip(1.0 - means[..., SHADOWED, None], 0.0, 1.0)
    return np.concatenate([means[..., ALBEDO : ALBEDO + 3], normal, shadow], axis=2).astype(np.float32)
