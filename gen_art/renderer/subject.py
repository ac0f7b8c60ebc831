"""The subject of a film in the camera's picture: how much of it the subject takes, and what share of its light is cut off."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from gen_art.renderer.camera import CameraView
from gen_art.renderer.shading import REFERENCE_ROWS
from gen_art.renderer.survey import Moment

__all__ = ["Extent", "SeenPoints", "counted", "extent_of", "seen_points", "union"]

NEAREST = 0.02  # of the distance to the target: what is nearer, or behind the camera, counts as if it were there
CELL, FAR_CELLS = 8.0, 2**20  # pixels of a picture 720 high; cells from the middle, beyond which all count as one
FAINT = 1e-3  # a moment with less than this part of the brightest moment's visible area does not count


@dataclass(frozen=True)
class SeenPoints:
    """The points of a moment in the picture. Lengths are in halves of the picture: its sides are at -1 and 1.

    at, radius : (n, 2) to the right and up
    depth : (n,) along the line of sight, world units
    weight : (n,) area that is seen, pixels of a picture 720 high
    """

    at: np.ndarray
    radius: np.ndarray
    depth: np.ndarray
    weight: np.ndarray


@dataclass(frozen=True)
class Extent:
    """What the subject takes of a picture, in halves of it, without its stray part.

    low, high : (2,) left and bottom, right and top
    depths : (2, 2) of the points at low and at high
    cut : the part of the visible area that is outside the picture, stray or not
    weight : visible area, pixels of a picture 720 high
    """

    low: np.ndarray
    high: np.ndarray
    depths: np.ndarray
    cut: float
    weight: float

    @property
    def size(self) -> np.ndarray:
        """(2,) parts of the picture's width and height."""
        return 0.5 * (self.high - self.low)


def seen_points(moment: Moment, view: CameraView, aspect: float) -> SeenPoints:
    """The points of a moment in a picture whose width is `aspect` times its height."""
    rows = int(REFERENCE_ROWS)
    offset = moment.points - view.position
    right, up, ahead = ((offset * axis).sum(axis=1) for axis in view.axes)
    if view.height:
        scale = np.full(len(ahead), view.scale(rows))
    else:
        ahead = np.maximum(ahead, NEAREST * view.distance)
        scale = view.scale(rows) / ahead
    half = 0.5 * rows * np.array([aspect, 1.0])
    radius = moment.radius * scale + moment.radius_pixels
    at = np.stack([right * scale, up * scale], axis=1)
    return SeenPoints(
        at=at / half,
        radius=radius[:, None] / half,
        depth=ahead,
        weight=_visible(at, radius, moment.weight * scale**2 + moment.weight_pixels),
    )


def _visible(at: np.ndarray, radius: np.ndarray, area: np.ndarray) -> np.ndarray:
    """The part of each point's area that is seen: those of one size that lie on each other in a cell share what there is.

    Cells are at least CELL and a sprite's diameter wide. Of areas that add up to s cells, 1 - exp(-s) of the cell is seen.
    """
    level = np.ceil(np.log2(np.maximum(2.0 * radius / CELL, 1.0)))
    side = CELL * 2.0**level
    place = np.clip(np.floor(at / side[:, None]), -FAR_CELLS, FAR_CELLS).astype(np.int64) + FAR_CELLS
    key = (level.astype(np.int64) * (2 * FAR_CELLS + 1) + place[:, 0]) * (2 * FAR_CELLS + 1) + place[:, 1]
    _, cell = np.unique(key, return_inverse=True)
    filled = np.bincount(cell, area / side**2)[cell]
    return area * -np.expm1(-filled) / np.maximum(filled, 1e-300)


def extent_of(seen: SeenPoints, stray: float = 0.01) -> Extent | None:
    """What the points take of the picture; None where nothing is seen.

    stray : the part of the visible area, farthest from the median, that does not count for the size
    """
    total = float(seen.weight.sum())
    if not total > 0.0:
        return None
    median = np.array([_weighted_median(seen.at[:, k], seen.weight) for k in (0, 1)])
    away = np.abs(seen.at - median).max(axis=1)
    inwards = np.argsort(-away, kind="stable")
    beyond = np.cumsum(seen.weight[inwards])
    kept = inwards[(beyond > stray * total) & (seen.weight[inwards] > 0.0)]
    low, high = seen.at[kept] - seen.radius[kept], seen.at[kept] + seen.radius[kept]
    ends = low.argmin(axis=0), high.argmax(axis=0)
    radius = np.maximum(seen.radius, 1e-6)
    covered = np.clip(np.minimum(seen.at + radius, 1.0) - np.maximum(seen.at - radius, -1.0), 0.0, None)
    inside = (covered / (2.0 * radius)).prod(axis=1)
    return Extent(
        low=low.min(axis=0),
        high=high.max(axis=0),
        depths=np.stack([seen.depth[kept[end]] for end in ends]),
        cut=max(0.0, 1.0 - float((seen.weight * inside).sum()) / total),
        weight=total,
    )


def union(extents: Sequence[Extent]) -> Extent:
    """What the subject takes over all these moments, and the largest part that is cut off at any of them."""
    lows, highs = (np.array([getattr(e, name) for e in extents]) for name in ("low", "high"))
    ends = lows.argmin(axis=0), highs.argmax(axis=0)
    depths = np.array([[extents[k].depths[side, axis] for axis, k in enumerate(end)] for side, end in enumerate(ends)])
    return Extent(
        lows.min(axis=0), highs.max(axis=0), depths, max(e.cut for e in extents), max(e.weight for e in extents)
    )


def counted(extents: Iterable[Extent | None]) -> dict[int, Extent]:
    """By number, the extents of the moments at which something is seen, against the brightest of them."""
    seen = {k: extent for k, extent in enumerate(extents) if extent is not None}
    most = max((extent.weight for extent in seen.values()), default=0.0)
    return {k: extent for k, extent in seen.items() if extent.weight >= FAINT * most}


def _weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(below, 0.5 * below[-1])]])
