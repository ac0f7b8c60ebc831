"""How a preset's subject lies in its pictures: its size and what is cut off, in the film and in the still, and advice."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gen_art.renderer.camera import Camera
from gen_art.renderer.fitting import fit_of
from gen_art.renderer.subject import Extent, counted, extent_of, seen_points, union
from gen_art.renderer.survey import Moment, survey

if TYPE_CHECKING:
    from gen_art.preset.camera import Fit
    from gen_art.preset.schema import Preset

__all__ = ["Framing", "Shown", "framing_of"]

SMALL = 0.35  # of the picture's height, and of its width
CUT = 0.02  # of the subject's light
REMEDY = "`camera: {frame: auto}` finds a place for it"


@dataclass(frozen=True)
class Shown:
    """The subject in a still or a film.

    height, width : the parts of the picture's that it takes, without the hundredth of its light that is farthest out; over 1 if
        it is larger than the picture
    cut : the part of its light that is outside the picture, at the moment when most is
    time : film time of that moment, s
    """

    height: float
    width: float
    cut: float
    time: float

    def __str__(self) -> str:
        outside = f"{_percent(self.cut)} of its light is outside the frame at {self.time:.3g} s"
        return f"{self.height:.0%} of the height, {self.width:.0%} of the width; {outside if self.cut else 'nothing is cut'}"


@dataclass(frozen=True)
class Framing:
    """The subject in a preset's film and in its still; None where nothing is seen. `fit` is that of `camera.frame`."""

    film: Shown | None
    still: Shown | None
    still_time: float
    fit: "Fit | None"

    @property
    def advice(self) -> list[str]:
        """Sentences about a subject that is cut off or small."""
        if self.film is None:
            return ["nothing is seen in the film: give a system a `look` with light, or move the camera"]
        remedy = f"; {REMEDY}" if self.fit is None else ""
        found = []
        for where, shown in (("the film", self.film), (f"the still at {self.still_time:.6g} s", self.still)):
            if shown is None:
                found.append(f"in {where} nothing is seen: give another `gallery.time`")
                continue
            if shown.cut > CUT:
                found.append(
                    f"in {where} {_percent(shown.cut)} of the subject's light is outside the frame at {shown.time:.3g} s: move "
                    f"the camera back or its target, or leave it so if the picture is meant to be filled{remedy}"
                )
            if max(shown.height, shown.width) < SMALL:
                found.append(
                    f"in {where} the subject takes {shown.height:.0%} of the height and {shown.width:.0%} of the width: bring "
                    f"the camera nearer, or give a smaller fov or height{remedy}"
                )
        return found


def framing_of(preset: "Preset", size, precision: str = "f32", threads: int | None = None) -> Framing:
    """How the subject lies in pictures of this size. It costs the run of gen_art/renderer/survey.py, whose errors it raises."""
    surveyed = survey(preset, precision, threads)
    aspect, fit = size[0] / size[1], fit_of(preset, size, precision, threads, surveyed)
    camera = Camera.from_spec(preset.camera, fit) if preset.camera is not None else None
    moments = [moment for moment in surveyed if moment.time >= 0.0]
    extents = [_extent(moment, camera, aspect) for moment in moments]
    seen = counted(extents)
    film = still = None
    if seen:
        worst = max(seen, key=lambda k: seen[k].cut)
        film = _shown(union(list(seen.values())), moments[worst].time)
    poster = min(range(len(moments)), key=lambda k: abs(moments[k].time - preset.poster_time), default=None)
    if poster is not None and poster in seen:
        still = _shown(seen[poster], moments[poster].time)
    return Framing(film, still, preset.poster_time, fit)


def _extent(moment: Moment, camera: Camera | None, aspect: float) -> Extent | None:
    if camera is None:  # as the painter does it: each picture frames its own particles
        camera = Camera.framing(moment.points, aspect)
    return extent_of(seen_points(moment, camera.at(moment.time), aspect))


def _shown(extent: Extent, time: float) -> Shown:
    width, height = (float(share) for share in extent.size)
    return Shown(height, width, extent.cut if extent.cut > 1e-4 else 0.0, time)


def _percent(share: float) -> str:
    return f"{share:.1%}" if share < 0.0995 else f"{share:.0%}"
