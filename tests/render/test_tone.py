"""Tone maps against their published formulas, in float64; the sRGB transfer; no bands."""

import numpy as np
import pytest

from gen_art.preset.develop import DevelopSpec
from gen_art.renderer.colour import LUMINANCE, encode_srgb, to_linear
from gen_art.renderer.tone_curves import matrices
from gen_art.renderer.tone_map import develop

COLOURS = np.random.default_rng(5).exponential(1.0, (40, 64, 3)) ** 2 * 2.0
COLOURS[0, :32] = np.geomspace(1e-4, 30.0, 32)[:, None]  # greys
COLOURS[0, 32:35] = np.eye(3)


def seen(light: np.ndarray, tone: str, **more) -> np.ndarray:
    """The linear light of a developed picture, float64; a 16-bit code is about 4e-5 of it at most."""
    linear = np.zeros((*light.shape[:2], 4), np.float32)
    linear[..., :3] = light
    return to_linear(develop(linear, DevelopSpec(tone=tone, bloom=0, **more), bits=16) / 65535)


def agrees(picture: np.ndarray, formula: np.ndarray, within: float = 6e-5) -> None:
    assert np.abs(picture - np.clip(formula, 0.0, 1.0)).max() < within


def test_extended_reinhard_is_its_formula():
    for white in (2.0, 8.0):
        agrees(seen(COLOURS, "reinhard", white=white), COLOURS * (1.0 + COLOURS / white**2) / (1.0 + COLOURS))
    assert seen(np.full((1, 8, 3), 3.0), "reinhard", white=3.0) == pytest.approx(1.0, abs=5e-5)


def test_neutral_is_khronos_formula():
    """Khronos PBR Neutral: F90 0.04, compression from 0.8 - F90, desaturation 0.15."""
    least = COLOURS.min(axis=2, keepdims=True)
    light = COLOURS - np.where(least < 0.08, least - 6.25 * least**2, 0.04)
    peak = light.max(axis=2, keepdims=True)
    start, room = 0.8 - 0.04, 1.0 - (0.8 - 0.04)
    compressed = 1.0 - room**2 / (np.maximum(peak, start) + room - start)
    white = 1.0 - 1.0 / (0.15 * (np.maximum(peak, start) - compressed) + 1.0)
    bright = light / np.maximum(peak, 1e-9) * compressed * (1.0 - white) + compressed * white
    agrees(seen(COLOURS, "neutral"), np.where(peak < start, light, bright))
    # by hand: grey 0.5 loses 0.04; grey 1 has peak 0.96, so 1 - 0.0576 / 0.44
    assert seen(np.full((1, 8, 3), 0.5), "neutral") == pytest.approx(0.46, abs=5e-5)
    assert seen(np.full((1, 8, 3), 1.0), "neutral") == pytest.approx(0.869090909, abs=5e-5)


def test_aces_is_hills_fit():
    into = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
    out = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07603]])
    v = COLOURS @ into.T
    fit = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    agrees(seen(COLOURS, "aces"), np.maximum(fit, 0.0) @ out.T, 1.5e-4)  # rows sum to 1 within 1e-4
    assert seen(np.full((1, 8, 3), 1.0), "aces") == pytest.approx(0.61911, abs=1e-4)
    assert seen(np.full((1, 8, 3), 0.18), "aces") == pytest.approx(0.10551, abs=1e-4)


def test_log_density_is_its_formula():
    """The brightest channel goes by log(1 + density L) / log(1 + density white), the colour with it; without vibrancy each goes by itself."""
    for density, white, vibrancy in ((100.0, 8.0, 1.0), (5.0, 2.0, 0.0), (1e4, 30.0, 0.4)):
        whole = np.log1p(density * white)
        peak = COLOURS.max(axis=2, keepdims=True)
        together = COLOURS * np.log1p(density * peak) / (peak * whole)
        apart = np.log1p(density * COLOURS) / whole
        formula = vibrancy * together + (1.0 - vibrancy) * apart
        agrees(seen(COLOURS, "log", density=density, white=white, vibrancy=vibrancy), formula)
    assert seen(np.full((1, 8, 3), 8.0), "log") == pytest.approx(1.0, abs=5e-5)


def test_agx_is_its_sigmoid_within_a_step_of_eight_bits():
    """log2 from -10 to +6.5 stops about grey; slope 2.4 through grey^(1/2.2), power 1.5 on either side; then to the power 2.2."""
    x = np.geomspace(1e-5, 40.0, 4000)
    stops = np.clip((np.log2(x / 0.18) + 10.0) / 16.5, 0.0, 1.0)
    pivot, grey = 10.0 / 16.5, 0.18 ** (1 / 2.2)

    def bend(distance, longest, tallest):
        scale = (tallest**-1.5 - (2.4 * longest) ** -1.5) ** (-1 / 1.5)
        return 2.4 * distance / (1.0 + (2.4 * distance / scale) ** 1.5) ** (1 / 1.5)

    above = grey + bend(np.maximum(stops - pivot, 0.0), 1.0 - pivot, 1.0 - grey)
    below = grey - bend(np.maximum(pivot - stops, 0.0), pivot, grey)
    curve = np.clip(np.where(stops >= pivot, above, below), 0.0, 1.0) ** 2.2
    light = seen(np.repeat(x[None, :, None], 3, axis=2), "agx")[0, :, 1]
    assert np.abs(encode_srgb(light) - encode_srgb(curve)).max() * 255 < 0.8
    assert seen(np.full((1, 8, 3), 0.18), "agx") == pytest.approx(0.18, abs=5e-5)
    assert seen(np.full((1, 8, 3), 0.18 * 2**6.5), "agx") == pytest.approx(1.0, abs=5e-5)


def test_agx_pales_what_is_bright_and_keeps_hues_apart():
    red = np.zeros((1, 64, 3))
    red[0, :, 0] = np.geomspace(0.01, 100.0, 64)
    light = seen(red, "agx")[0]
    saturation = 1.0 - light[:, 1] / np.maximum(light[:, 0], 1e-6)
    assert saturation[10] > 0.8 > 0.5 > saturation[-1], "a colour of the lamp becomes white"
    assert (light[:, 0] > light[:, 1]).sum() >= 60


def test_neutrals_pass_every_matrix():
    for tone in ("agx", "aces", "reinhard", "neutral", "log", "none"):
        for saturation in (0.0, 0.5, 2.0):
            for matrix in matrices(tone, saturation):
                assert matrix.sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    assert matrices("none", 0.0)[1] == pytest.approx(np.tile(LUMINANCE, (3, 1)))


def test_contrast_is_a_power_about_grey_before_the_tone_map():
    light = np.minimum(COLOURS, 0.9)
    agrees(seen(light, "none", contrast=1.5), 0.18 * (light / 0.18) ** 1.5)
    powered = 0.18 * (COLOURS / 0.18) ** 0.8
    agrees(seen(COLOURS, "reinhard", contrast=0.8), powered * (1.0 + powered / 64.0) / (1.0 + powered))


def test_the_srgb_transfer_is_right_to_a_code_of_sixteen_bits():
    """Rounded to the nearest code: the exact value lies within half a code, but for 0.15 of the polynomial and of float32."""
    x = np.concatenate([np.linspace(0, 1, 100_001), np.geomspace(1e-6, 0.02, 20_000)]).astype(np.float32)
    linear = np.zeros((1, len(x), 4), np.float32)
    linear[0, :, :3] = x[:, None]
    codes = develop(linear, DevelopSpec(tone="none", bloom=0), bits=16)[0].astype(np.float64)
    assert np.abs(codes - encode_srgb(x.astype(np.float64))[:, None] * 65535).max() < 0.65
    eight = develop(linear, DevelopSpec(tone="none", bloom=0, dither=False))[0].astype(np.float64)
    assert np.abs(eight - encode_srgb(x.astype(np.float64))[:, None] * 255).max() < 0.501


def test_dark_gradients_have_no_bands_anywhere():
    """The mean of each 16 x 16 pixels of a gradient of two codes over 640 pixels follows it within a fraction of a code."""
    ramp = np.zeros((96, 640, 4), np.float32)
    ramp[..., :3] = to_linear(np.linspace(3.0, 5.0, 640) / 255)[None, :, None]
    exact = np.linspace(3.0, 5.0, 640).reshape(40, 16).mean(axis=1)

    def blocks(dither):
        picture = develop(ramp, DevelopSpec(tone="none", bloom=0, dither=dither), frame=2).astype(np.float64)
        return picture.reshape(6, 16, 40, 16, 3).mean(axis=(1, 3)) - exact[None, :, None]

    assert np.abs(blocks(True)).max() < 0.15 and np.abs(blocks(True).mean(axis=0)).max() < 0.06
    assert np.abs(blocks(False)).max() > 0.4
    noise = (
        develop(ramp, DevelopSpec(tone="none", bloom=0), frame=2).astype(np.float64)
        - np.linspace(3.0, 5.0, 640)[None, :, None]
    )
    for one, other in ((noise[1:], noise[:-1]), (noise[:, 1:], noise[:, :-1]), (noise[..., 1:], noise[..., :-1])):
        assert abs((one * other).mean()) < 0.02 * noise.var() + 3e-3, "neighbours, rows and channels go their own ways"
