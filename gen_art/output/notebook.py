"""`ga.play`: a preset in a notebook, with a slider of its film, its seed and its knobs."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.output.extras import check_installed

if TYPE_CHECKING:
    from gen_art.output.notebook_widget import NotebookPlayer
    from gen_art.preset.schema import Preset

__all__ = ["play"]

_WIDTH = 480  # pixels of the picture where no size is given


def play(
    preset: "str | Path | Mapping[str, Any] | Preset",
    *,
    size: tuple[int, int] | None = None,
    frame: int = 0,
    overrides: Mapping[str, Any] | None = None,
    seed: int | str | None = None,
    precision: str = "f32",
    threads: int | None = None,
) -> "NotebookPlayer":
    """A player of a preset, which a notebook shows when it is the last line of a cell.

    preset, overrides, seed : as for load_preset
    size : (width, height) of the picture, pixels; 480 wide in the shape of the preset's camera when None
    frame : the first one that is shown
    precision, threads : as for Simulation
    It has a slider of the film's frames, a button that plays it, a field and a die for the seed, and sliders of the knobs for
    which the preset states a range. From Python the same are `frame`, `seed` and `knobs`; `preset` is the one that is shown.
    It needs the extra `notebook`. Raises the errors of load_preset, and UsageError for numbers that cannot be.
    """
    check_installed("ga.play", "anywidget")
    from gen_art.output.notebook_widget import NotebookPlayer
    from gen_art.output.player import Player
    from gen_art.preset.camera import CameraSpec
    from gen_art.preset.load import PresetSource

    source = PresetSource.of(preset)
    loaded = source.load(overrides, seed)
    if size is None:
        width, height = (loaded.camera or CameraSpec()).size
        shown = (_WIDTH, max(1, round(_WIDTH * height / width)))
    else:
        if not isinstance(size, (tuple, list)) or len(size) != 2:
            raise UsageError(f"size must be (width, height) in pixels, not {arguments.shown(size)}")
        shown = (arguments.whole("size", size[0], 1, 16384), arguments.whole("size", size[1], 1, 16384))
    first = arguments.whole("frame", frame, 0, loaded.clock.frames - 1)
    return NotebookPlayer(Player(precision, threads), source, overrides, loaded, shown, first)
