"""Palettes: every name resolves, known ones are what they are known for, perceptual ones rise in lightness."""

import numpy as np
import pytest

from gen_art.commands.main import run
from gen_art.errors import UsageError
from gen_art.preset.colour_names import COLOURS, Gradient
from gen_art.preset.develop import DevelopSpec
from gen_art.preset.load import load_preset
from gen_art.preset.palettes import PALETTES, PERCEPTUAL, names
from gen_art.preset.schema import json_schema
from gen_art.renderer.colour import gradient_table, linear, to_oklab

KNOWN = {  # colours at 0, 1/8 ... 1, read from matplotlib 3.10
    "viridis": ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"],
    "magma": ["#000004", "#1d1147", "#51127c", "#832681", "#b73779", "#e75263", "#fc8961", "#fec488", "#fcfdbf"],
    "inferno": ["#000004", "#210c4a", "#57106e", "#8a226a", "#bc3754", "#e45a31", "#f98e09", "#f9cb35", "#fcffa4"],
    "plasma": ["#0d0887", "#4c02a1", "#7e03a8", "#aa2395", "#cc4778", "#e66c5c", "#f89540", "#fdc527", "#f0f921"],
    "cividis": ["#00224e", "#1a386f", "#434e6c", "#61656f", "#7d7c78", "#9b9476", "#bcae6c", "#dec958", "#fee838"],
    "turbo": ["#30123b", "#466be3", "#28bceb", "#32f298", "#a4fc3c", "#eecf3a", "#fb7e21", "#d02f05", "#7a0403"],
    "twilight": ["#e2d9e2", "#95b5c7", "#6276ba", "#592a8f", "#2f1436", "#741e4f", "#b25652", "#cca389", "#e2d9e2"],
}


def lab(name: str, size: int = 257) -> np.ndarray:
    return to_oklab(gradient_table(Gradient.of(name), size))


def test_there_are_palettes_enough_and_every_name_resolves():
    assert len(PALETTES) >= 24 and len(PERCEPTUAL) >= 8
    assert not set(PALETTES) & set(COLOURS), "a name is a colour or a palette, not both"
    for name in names():
        gradient = Gradient.of(name)
        assert len(gradient.stops) >= 2 and gradient.stops[0][0] == 0.0 and gradient.stops[-1][0] == 1.0
        table = gradient_table(gradient)
        assert np.isfinite(table).all() and table.min() >= 0.0 and table.max() < 1.03
        assert Gradient.of(gradient.written()) == gradient


@pytest.mark.parametrize("name", KNOWN)
def test_known_names_are_the_known_colours(name):
    known = to_oklab(np.array([linear(c) for c in KNOWN[name]]))
    assert np.linalg.norm(lab(name)[::32] - known, axis=1).max() < 0.02


@pytest.mark.parametrize("name", PERCEPTUAL)
def test_perceptual_palettes_rise_evenly_in_lightness(name):
    steps = np.diff(lab(name)[:, 0])
    assert steps.min() > 0.0
    assert lab(name)[-1, 0] - lab(name)[0, 0] > 0.55
    assert np.percentile(steps, 90) < 2.5 * np.percentile(steps, 10)


def test_palettes_differ():
    middles = {name: lab(name, 9) for name in PALETTES}
    for one in middles:
        for other in middles:
            assert one == other or np.abs(middles[one] - middles[other]).max() > 0.03, (one, other)


def test_reversed_runs_from_the_far_end():
    for name in ("magma", "turbo", "mono"):
        assert gradient_table(Gradient.of(f"{name} reversed")) == pytest.approx(gradient_table(Gradient.of(name))[::-1])
    assert Gradient.of("  Magma   REVERSED ") == Gradient.of("magma reversed")


def test_a_palette_goes_wherever_a_gradient_does():
    assert DevelopSpec(background="magma reversed").background == Gradient.of("magma reversed")
    piece = {
        "version": 1, "clock": {"duration": 1, "step": "1/60"},
        "systems": {"s": {"particle": {"lifetime": 1}, "emitters": {"jet": {"rate": 5}}, "look": {"draw": "disc", "emission": "tide"}}},
    }  # fmt: skip
    assert load_preset(piece).systems["s"].look.emission.color.gradient == Gradient.of("tide")
    text = str(json_schema())
    assert "'magma'" in text and "'magma reversed'" in text


def test_an_unknown_palette_is_named_with_the_one_that_is_near():
    for wrong, near in (("magam", "magma"), ("virids reversed", "viridis"), ("crimsn", "crimson")):
        with pytest.raises(UsageError, match=f"no colour or palette named '{wrong}'; did you mean '{near}'"):
            Gradient.of(wrong)
    with pytest.raises(UsageError, match="no colour or palette named 'qqq'; write"):
        Gradient.of("qqq")
    with pytest.raises(UsageError, match="is a palette"):
        Gradient.of(["red", "magma"])


def test_the_command_lists_them(capsys):
    assert run(["list", "palettes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(PALETTES)
    assert sum("perceptual" in line for line in lines) == len(PERCEPTUAL)
