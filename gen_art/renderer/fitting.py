"""`camera.frame`: the camera moved so that its picture holds what is seen in the whole film.

The fit follows from the preset, the picture's ratio of width to height and the precision. It is rounded to about a thousandth
of the picture, so that the last bits of a processor do not move the camera. A Preset keeps its fits, and a recipe holds the one
of its picture.
"""

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import AdviceWarning
from gen_art.preset.camera import Fit, Frame
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.subject import Extent, counted, extent_of, seen_points, union
from gen_art.renderer.survey import Moment, survey

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["fit_camera", "fit_key", "fit_of"]

NOTHING = "nothing is seen in the film"
AIR = 0.1  # part of the picture that stays free at each side
FIRST_STEPS, STEPS, CLOSE = 3, 30, 1e-3  # fewest and most rounds, and the relative change at which they end
NEARLY = 0.05  # relative change after the last round from which on the place is doubtful
LEAST, MOST = 1e-12, 1e12  # of the factor
CUT = 0.02  # part of the subject's light that may be outside a picture, besides its stray part
REWEIGHTED = 60  # rounds of Lawson's algorithm
SIDEWAYS = 0.03  # part of the best seen direction from which on a direction is seen from the side well enough to centre along it


def fit_key(size, precision: str) -> tuple[int, int, str]:
    """What a fit depends on besides the preset: the picture's width and height without common factors, and the precision."""
    common = math.gcd(*size)
    return size[0] // common, size[1] // common, precision


def fit_of(
    preset: "Preset", size, precision: str = "f32", threads: int | None = None, moments: Sequence[Moment] | None = None
) -> Fit | None:
    """The fit of a preset's camera in pictures of this size; None for a camera without `frame`.

    moments : of the preset's survey with this precision; when None, the survey runs unless the preset has the fit already
    """
    if preset.camera is None or preset.camera.frame is None:
        return None
    key = fit_key(size, precision)
    if key not in preset.fits:
        moments = survey(preset, precision, threads) if moments is None else moments
        preset.fits[key] = fit_camera(moments, Camera.from_spec(preset.camera), size[0] / size[1], preset.camera.frame)
    return preset.fits[key]


def fit_camera(moments: Sequence[Moment], camera: Camera, aspect: float, frame: Frame) -> Fit:
    """The fit of a camera (without its own) to what is seen at these moments.

    aspect : width / height of the picture
    The target moves so that the extremes to the left and right, and those above and below, over all moments are equally far
    from the middle (Lawson's algorithm: least squares whose weights are multiplied by the residuals); along directions that no
    moment sees from the side, it goes to the middle of the points. Then the distance, or the height, is solved for the size.
    """
    moments = [moment for moment in moments if len(moment.points)]
    views = [camera.at(moment.time) for moment in moments]
    move, factor, found = _search(moments, views, aspect, frame, 1.0)
    if not found:
        warnings.warn(f"camera.frame: {NOTHING}, so the camera stays where it is", AdviceWarning, stacklevel=2)
        return Fit()
    if not _is_shown(moments, views, move, factor, aspect, frame.stray):
        # a path may begin among the points, where those behind the camera lead the search away: come from outside
        move, factor, found = _search(moments, views, aspect, frame, _outside(moments, views))
    if not _is_shown(moments, views, move, factor, aspect, frame.stray):
        warnings.warn(
            "camera.frame: no distance was found at which the subject is in the picture in the whole film, so the camera stays "
            "where it is: leave out `frame`, or name another subject by its `of`",
            AdviceWarning,
            stacklevel=2,
        )
        return Fit()
    return _rounded(move, factor, _half_height(views[0]) * factor)


def _outside(moments: Sequence[Moment], views: Sequence[CameraView]) -> float:
    """A factor with which the camera is outside of what is seen, however its path turns."""
    points = np.concatenate([m.points for m in moments])
    reach = float(np.ptp(np.quantile(points, [0.01, 0.99], axis=0), axis=0).max())
    return min(max(4.0 * reach / min(view.distance for view in views), 1.0), MOST)


def _search(moments, views, aspect: float, frame: Frame, factor: float) -> tuple[np.ndarray, float, bool]:
    """The move of the target and the factor, from a first factor on, and whether anything is seen."""
    move = _middle(moments, views)
    for step in range(STEPS):
        shown = [_moved(view, move, factor) for view in views]
        found = counted(extent_of(seen_points(m, v, aspect), frame.stray) for m, v in zip(moments, shown))
        if not found:
            return move, factor, False
        extents, seen_by = list(found.values()), [shown[k] for k in found]
        move_on = _centring(extents, seen_by, aspect)
        move, before = move + move_on, factor
        if _has_size(moments):
            needed = _needed(union(extents), seen_by[0], factor, frame.fill)
            factor = min(max(needed, 0.25 * factor, LEAST), 4.0 * factor, MOST)
        still = np.abs(move_on).max() < CLOSE * _half_height(shown[0]) and abs(factor / before - 1.0) < CLOSE
        if step >= FIRST_STEPS and still:
            break
    else:
        if not abs(factor / before - 1.0) < NEARLY:
            warnings.warn(
                "camera.frame: no distance was found at which the subject has its size, so it may be cut off or small: look "
                "at the film's ends, or give the camera `position` and `target` instead",
                AdviceWarning,
                stacklevel=3,
            )
    return move, factor, True


def _is_shown(moments, views, move: np.ndarray, factor: float, aspect: float, stray: float) -> bool:
    """Whether all but the stray part of what is seen, and CUT of it, is in the picture at every moment."""
    if not (np.isfinite(move).all() and LEAST < factor < MOST):
        return False
    shown = (extent_of(seen_points(m, _moved(v, move, factor), aspect), stray) for m, v in zip(moments, views))
    return all(extent.cut <= stray + CUT for extent in counted(shown).values())


def _has_size(moments: Sequence[Moment]) -> bool:
    """Whether it is more than one dot that stays where it is, whose size no distance changes."""
    first = moments[0].points[0]
    return any((m.points != first).any() or m.radius.any() for m in moments)


def _middle(moments: Sequence[Moment], views: Sequence[CameraView]) -> np.ndarray:
    """(3,) from the first target to the middle of the box that holds the points of all moments but those farthest out."""
    if not moments:
        return np.zeros(3)
    points = np.concatenate([m.points[:: max(1, len(m.points) // 2000)] for m in moments])
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    first = views[0]
    return 0.5 * (low + high) - (first.position + first.distance * first.axes[2])


def _moved(view: CameraView, move: np.ndarray, factor: float) -> CameraView:
    """The view as Camera.at makes it with a fit."""
    if view.height is not None:
        return replace(view, position=view.position + move, height=view.height * factor)
    back = (factor - 1.0) * view.distance
    return replace(view, position=view.position + move - back * view.axes[2], distance=view.distance + back)


def _half_height(view: CameraView) -> float:
    """Half the height of the picture at the target, world units."""
    return 0.5 * view.height if view.height is not None else math.tan(math.radians(view.fov) / 2) * view.distance


def _centring(extents: Sequence[Extent], views: Sequence[CameraView], aspect: float) -> np.ndarray:
    """(3,) the move of the target that centres the extremes of all moments, those to the sides and those above and below."""
    half = np.array([_half_height(view) for view in views])
    rows = np.array(
        [[view.axes[axis] / (h * ratio) for view, h in zip(views, half)] for axis, ratio in ((0, aspect), (1, 1.0))]
    )
    rows = np.concatenate([rows, rows], axis=1)  # (2, 2 n, 3): axis, low ends and high ends, x y z
    ends = np.array([[e.low[axis] for e in extents] + [e.high[axis] for e in extents] for axis in (0, 1)])
    weights = np.full(ends.shape, 1.0 / ends.shape[1])
    for _ in range(REWEIGHTED):
        normal = (rows[..., :, None] * rows[..., None, :] * weights[..., None, None]).sum(axis=(0, 1))
        side = (rows * (ends * weights)[..., None]).sum(axis=(0, 1))
        move = (np.linalg.pinv(normal, SIDEWAYS, hermitian=True) * side).sum(axis=1)
        weights = weights * np.maximum(np.abs((rows * move).sum(axis=2) - ends), 1e-9)
        weights /= weights.sum(axis=1, keepdims=True)
    return move


def _needed(whole: Extent, view: CameraView, factor: float, fill: float) -> float:
    """The factor with which the subject would fill its part of the picture, and have air at every side.

    A point at depth d moves from x to x d / (d + change) when the camera goes back by `change`.
    """
    needed = []
    for axis in (0, 1):
        low, high = whole.low[axis], whole.high[axis]
        for ratio, depth in (
            (0.5 * (high - low) / fill, whole.depths[:, axis].mean()),
            (-low / (1.0 - 2.0 * AIR), whole.depths[0, axis]),
            (high / (1.0 - 2.0 * AIR), whole.depths[1, axis]),
        ):
            own = view.distance / factor
            needed.append(factor * ratio if view.height is not None else factor + depth / own * (ratio - 1.0))
    return max(needed)


def _rounded(move: np.ndarray, factor: float, half_height: float) -> Fit:
    """Rounded to about a thousandth of the picture, to decimal places."""
    digits = 3 - math.floor(math.log10(2.0 * half_height))
    x, y, z = (round(float(part), digits) + 0.0 for part in move)
    return Fit((x, y, z), float(f"{factor:.4g}"))
