"""AOVs (extra layers) of a picture for compositing: depth and motion, as means over the sprites of a pixel.

Each sprite is weighted by the light and the coverage that it adds to the pixel. Z is the distance along the line of sight in
world units. `velocity` is how far a pixel's content moved since the previous frame, in pixels to the right and down, including
the camera's own motion. Both are 0 where nothing is drawn. Trails and ribbons are not part of these layers.
"""

import numpy as np

from gen_art.particles.rows import POSITION, VELOCITY
from gen_art.renderer.colour import LUMINANCE
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, GREEN, RED
from gen_art.renderer.supersample import box_averaged

__all__ = ["LAYERS", "render_aovs"]

LAYERS = ("Z", "velocity.x", "velocity.y")


def render_aovs(painter, sim, film_time: float, frame: float, seconds: float) -> dict[str, np.ndarray]:
    """Z, velocity.x and velocity.y, each (height, width) float32.

    frame : film seconds of a frame
    seconds : simulated seconds of a frame
    """
    sums = []
    for weighted in (True, False):

        def recolour(system, channels, weighted=weighted):
            n = channels.shape[1]
            weight = np.tensordot(LUMINANCE.astype(np.float32), channels[RED : BLUE + 1], 1) + channels[ALPHA]
            channels[ALPHA], channels[RED] = 0.0, weight
            if weighted:
                position = np.asarray(system.floats[POSITION, :n], np.float64).T
                before = position - seconds * np.asarray(system.floats[VELOCITY, :n], np.float64).T
                with np.errstate(all="ignore"):
                    motion = painter.view(sim, film_time).project(position, painter.size)
                    motion = motion - painter.view(sim, max(film_time - frame, 0.0)).project(before, painter.size)
                motion[~np.isfinite(motion).all(axis=1)] = 0.0
                channels[RED] = weight * channels[DEPTH]
                channels[GREEN], channels[BLUE] = weight * motion[:, 0], weight * motion[:, 1]

        framebuffer = FrameBuffer(painter.size)
        painter.draw(sim, film_time, framebuffer, recolour)
        sums.append(framebuffer.pixels if painter.supersample == 1 else box_averaged(framebuffer, painter.supersample))
    total = sums[1][..., 0]
    drawn = total > 1e-6 * max(float(total.max()), 1e-30)
    mean = sums[0][..., :3] / np.where(drawn, total, 1.0)[..., None]
    mean = np.where(drawn[..., None], mean, 0.0).astype(np.float32)
    mean[..., 1:] /= painter.supersample
    return {name: np.ascontiguousarray(mean[..., k]) for k, name in enumerate(LAYERS)}
