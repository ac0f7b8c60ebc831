"""Colour: transfer, names, gradients, black bodies."""

import numpy as np
import pytest

from gen_art.errors import UsageError
from gen_art.preset.colour_names import COLOURS, PALETTES, Gradient, srgb
from gen_art.renderer.colour import (
    LUMINANCE,
    blackbody,
    bytes_to_linear,
    encode_srgb,
    from_oklab,
    gradient_table,
    linear,
    planck_luminance,
    rgb_to_xyz,
    to_linear,
    to_oklab,
)  # fmt: skip


def test_srgb_transfer_goes_both_ways_and_has_its_known_points():
    x = np.linspace(0, 1, 1001)
    assert np.abs(to_linear(encode_srgb(x)) - x).max() < 1e-12
    pixels = np.arange(256, dtype=np.uint8).reshape(8, 32)
    assert np.array_equal(bytes_to_linear(pixels), to_linear(pixels / 255.0))
    assert encode_srgb(0.18) == pytest.approx(0.46135612950044164, abs=1e-12)
    assert encode_srgb([0.0, 1.0]) == pytest.approx([0.0, 1.0], abs=1e-12)


def test_colours_are_read_in_every_form():
    assert srgb("#f00") == (1.0, 0.0, 0.0) == srgb("#ff0000") == srgb([1, 0, 0])
    assert linear("white") == pytest.approx([1, 1, 1])
    for name in COLOURS:
        assert all(0 <= c <= 1 for c in srgb(name))
    assert not set(COLOURS) & set(PALETTES), "a name is a colour or a palette, not both"
    assert len(PALETTES) >= 12


@pytest.mark.parametrize("bad", ["whit", "#ff", "#gggggg", [1, 2], [0, 0, 2], 7, None, [0.1, "x", 0.2]])
def test_what_is_no_colour_is_refused(bad):
    with pytest.raises(UsageError):
        srgb(bad)


def test_a_near_miss_is_named():
    with pytest.raises(UsageError, match="did you mean 'crimson'"):
        srgb("crimsn")


def test_gradients_hold_their_stops_and_pass_between_them_in_oklab():
    table = gradient_table(Gradient.of(["black", "red", "white"]), 257)
    assert table[[0, 128, 256]] == pytest.approx(np.array([linear(c) for c in ("black", "red", "white")]), abs=1e-6)
    half = from_oklab(0.5 * (to_oklab(linear("red")) + to_oklab(linear("white"))))
    assert table[192] == pytest.approx(half, abs=1e-6)
    assert np.ptp(gradient_table(Gradient.of("teal")), axis=0).max() == 0
    for palette in PALETTES:
        assert np.isfinite(gradient_table(Gradient.of(palette))).all()


def test_primaries_give_the_standard_luminances():
    assert rgb_to_xyz()[1] == pytest.approx(LUMINANCE, abs=1e-9)


def test_black_bodies_redden_as_they_cool_and_are_white_at_the_white_point():
    red_over_blue = [b[0] / max(b[2], 1e-6) for b in blackbody([1500, 3000, 6500, 15000])]
    assert red_over_blue == sorted(red_over_blue, reverse=True)
    assert blackbody(6504)[0] == pytest.approx([1, 1, 1], abs=0.06)
    assert blackbody(1500)[0, 2] == 0.0 and blackbody(1500)[0, 0] == 1.0
    # at 555 nm Wien's law alone gives exp(-c2 / lambda (1/T2 - 1/T1)): the ratio must be near it
    wien = np.exp(-1.4388e-2 / 600e-9 * (1 / 1000 - 1 / 2000))
    assert planck_luminance(1000)[0] / planck_luminance(2000)[0] == pytest.approx(wien, rel=0.6)
