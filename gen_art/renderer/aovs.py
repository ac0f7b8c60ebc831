"""Depth and motion of a picture, for compositing: means over the sprites of a pixel, weighted by what each shows there.

Z is the distance along the line of sight in world units; `velocity` how far a pixel's content moved since the frame before,
in pixels to the right and down, the camera's own motion included. Both are 0 where nothing is drawn.
Trails and ribbons have none.
"""

import numpy as np

from gen_art.particles.rows import POSITION, VELOCITY
from gen_art.renderer.colour import LUMINANCE
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, RED
from gen_art.renderer.supersample import box_averaged

__all__ = ["LAYERS", "render_aovs"]

LAYERS = ("Z", "velocity.x", "velocity.y")


def render_aovs(painter, sim, film_time: float, frame: float, seconds: float) -> dict[str, np.ndarray]:
    """Z, velocity.x and velocity.y, each (height, width) float32.

    frame : film seconds of a frame      seconds : simulated seconds of it
    """
    sums = []
    for weighed in (True, False):

        def recolour(system, columns, weighed=weighed):
            n = columns.shape[1]
            shown = np.tensordot(LUMINANCE.astype(np.float32), columns[RED : BLUE + 1], 1) + columns[ALPHA]
            columns[ALPHA], columns[RED] = 0.0, shown
            if weighed:
                place = np.asarray(system.floats[POSITION, :n], np.float64).T
                before = place - seconds * np.asarray(system.floats[VELOCITY, :n], np.float64).T
                with np.errstate(all="ignore"):
                    moved = painter.view(sim, film_time).project(place, painter.size)
                    moved = moved - painter.view(sim, max(film_time - frame, 0.0)).project(before, painter.size)
                moved[~np.isfinite(moved).all(axis=1)] = 0.0
                columns[RED] = shown * columns[DEPTH]
                columns[RED + 1], columns[BLUE] = shown * moved[:, 0], shown * moved[:, 1]

        film = FrameBuffer(painter.size)
        painter.draw(sim, film_time, film, recolour)
        sums.append(film.pixels if painter.times == 1 else box_averaged(film, painter.times))
    weight = sums[1][..., 0]
    drawn = weight > 1e-6 * max(float(weight.max()), 1e-30)
    mean = np.where(drawn[..., None], sums[0][..., :3] / np.where(drawn, weight, 1.0)[..., None], 0.0).astype(
        np.float32
    )
    mean[..., 1:] /= painter.times
    return {name: np.ascontiguousarray(mean[..., k]) for k, name in enumerate(LAYERS)}
