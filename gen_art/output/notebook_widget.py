"""The widget of `ga.play`: what the notebook's page and the kernel tell each other."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import anywidget
import traitlets
from PIL import Image

from gen_art.errors import GenArtError
from gen_art.output.player import Player
from gen_art.preset.load import PresetSource
from gen_art.preset.schema import Preset

__all__ = ["NotebookPlayer"]

_FOLDER = Path(__file__).parent / "notebook_page"
_JPEG_QUALITY = 90
_MOST_STEPS = 200  # of a knob's slider


class NotebookPlayer(anywidget.AnyWidget):
    """A preset with its film, seed and knobs. `frame`, `seed` and `knobs` may be set; each picture is that of the film.

    frame : number of the frame, from 0
    seed : a whole number from 0
    knobs : values by name, of the knobs with a range
    picture : the frame as JPEG
    problem : a sentence about what could not be shown, or ""
    """

    _esm = _FOLDER / "player.js"
    _css = _FOLDER / "player.css"
    frame = traitlets.Int(0).tag(sync=True)
    seed = traitlets.Int(0).tag(sync=True)
    knobs = traitlets.Dict().tag(sync=True)
    picture = traitlets.Bytes(b"").tag(sync=True)
    problem = traitlets.Unicode("").tag(sync=True)
    _drawn = traitlets.Int(0).tag(sync=True)  # the number of pictures so far, also where two are alike
    _shown = traitlets.Int(0).tag(sync=True)  # the frame of the picture
    _frames = traitlets.Int(1).tag(sync=True)
    _fps = traitlets.Float(30.0).tag(sync=True)
    _size: traitlets.List[int] = traitlets.List().tag(sync=True)
    _sliders: traitlets.List[dict[str, Any]] = traitlets.List().tag(sync=True)
    _title = traitlets.Unicode("").tag(sync=True)

    def __init__(
        self,
        player: Player,
        source: PresetSource,
        overrides: Mapping[str, Any] | None,
        preset: Preset,
        size: tuple[int, int],
        frame: int,
    ) -> None:
        self._player, self._source, self._overrides = player, source, dict(overrides or {})
        self.preset = preset
        sliders = [
            {
                "name": name, "low": knob.range.lo, "high": knob.range.hi, "unit": knob.unit,
                "step": (knob.range.hi - knob.range.lo) / _MOST_STEPS,
            }
            for name, knob in preset.knobs.items()
            if knob.range is not None and knob.number is not None
        ]  # fmt: skip
        super().__init__(
            frame=frame,
            seed=preset.seed,
            knobs={str(one["name"]): preset.knobs[str(one["name"])].number for one in sliders},
            _frames=preset.clock.frames,
            _fps=float(preset.clock.fps),
            _size=list(size),
            _sliders=sliders,
            _title=preset.title or preset.name,
        )
        self._known_knobs = dict(self.knobs)
        self._player.change(preset)
        self._draw()
        self.observe(self._new_preset, ["seed", "knobs"])
        self.observe(self._draw, "frame")

    def close(self) -> None:
        """End the player; its files go."""
        self._player.close()
        super().close()

    @traitlets.validate("frame")
    def _in_the_film(self, proposal: Any) -> int:
        return min(max(0, proposal["value"]), self._frames - 1)

    def _new_preset(self, _: Any = None) -> None:
        """Go on with the seed and the knobs of now; where they cannot be, say so and keep the picture."""
        changed = {f"knobs.{name}": value for name, value in self.knobs.items() if self._known_knobs.get(name) != value}
        try:
            preset = self._source.load({**self._overrides, **changed}, self.seed)
            self._player.change(preset)
            self.preset = preset
            for _ in self._player.settle(self.frame, self._wanted):
                pass
        except GenArtError as error:
            self.problem = str(error)
            return
        self._draw()

    @property
    def _wanted(self) -> tuple[int, int]:
        width, height = self._size
        return width, height

    def _draw(self, _: Any = None) -> None:
        try:
            shown = self._player.show(self.frame, self._wanted)
        except GenArtError as error:
            self.problem = str(error)
            return
        data = io.BytesIO()
        Image.fromarray(shown.picture).save(data, "JPEG", quality=_JPEG_QUALITY, subsampling=0)
        with self.hold_sync():
            self.problem, self.picture, self._shown = "", data.getvalue(), shown.frame
            self._drawn += 1
