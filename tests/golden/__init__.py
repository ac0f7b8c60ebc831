"""Golden pictures: small frames of sixteen presets, kept so that a change of any picture is seen."""

from pathlib import Path

import numpy as np

from tests.small import SMALL

FOLDER = Path(__file__).parent
SIZE = (128, 72)
BLOCK = 8  # pixels on a side
# Pictures of one version differ between processors by rounding: a code here and there, which moves no mean by more than one.
# A sprite that moves or changes shows in the block where it is.
MEAN_LIMIT = 1.0  # codes of 255, over the whole picture
BLOCK_LIMIT = 4.0  # codes, over the block that differs most

# preset -> (film time, overrides): early moments, before rounding grows into other positions
PICTURES: dict[str, tuple[float, dict]] = {
    **{name: (0.1, overrides) for name, overrides in SMALL.items() if name != "galaxy"},
    "galaxy": (0.0, SMALL["galaxy"]),
    "course/bouncing_balls": (1.0, {"clock.preroll": 1}),
    "course/cloth_over_ball": (0.3, {}),
    "course/pour": (0.5, {}),
    "course/penning_trap": (0.5, {}),
    "course/tower": (0.5, {}),
    "course/painted_flow": (0.5, {}),
    "course/rain": (0.5, {"clock.preroll": 1}),
    "course/satellites": (0.5, {}),
    "course/wind_turbine": (0.2, {}),
    "course/attractors": (0.5, {}),
}


def draw(name: str, more: dict | None = None) -> np.ndarray:
    """(72, 128, 3) uint8: the golden picture of a preset, as this version draws it. more : further overrides"""
    from gen_art.output.playback import Playback
    from gen_art.preset.load import load_preset
    from gen_art.renderer.tone_map import develop

    time, overrides = PICTURES[name]
    preset = load_preset(name, overrides={**overrides, **(more or {})})
    playback = Playback(preset, SIZE, "f32", None)
    linear, exposure = next(playback.pictures([playback.step_of(time)]))
    return np.array(develop(linear, preset.develop, frame=0, bits=8, exposure=exposure))


def path(name: str) -> Path:
    return FOLDER / f"{name.replace('/', '_')}.png"


def differences(a: np.ndarray, b: np.ndarray) -> tuple[float, float]:
    """Mean absolute difference of two pictures, over all and over the block that differs most, in codes of 255."""
    error = np.abs(a.astype(float) - b.astype(float)).mean(axis=2)
    height, width = error.shape
    blocks = error.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean(axis=(1, 3))
    return float(error.mean()), float(blocks.max())
