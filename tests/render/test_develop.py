"""Developing: neutrals stay neutral, no bands, black is black."""

import numpy as np
import pytest

from gen_art.errors import UsageError
from gen_art.preset.colour_names import srgb
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer.colour import encode_srgb
from gen_art.renderer.tone_map import develop

TONES = ["agx", "aces", "reinhard", "neutral", "log", "none"]


def linear_of(grey, width=64) -> np.ndarray:
    linear = np.zeros((4, len(np.atleast_1d(grey)) if np.ndim(grey) else width, 4), np.float32)
    linear[..., :3] = np.broadcast_to(grey, linear.shape[1])[None, :, None]
    return linear


@pytest.mark.parametrize("tone", TONES)
def test_neutral_grey_stays_neutral_and_rises(tone):
    grey = np.geomspace(1e-5, 200, 300)
    picture = develop(linear_of(grey), DevelopSpec(tone=tone, bloom=0), bits=16).astype(int)
    assert np.ptp(picture, axis=2).max() <= 1
    values = picture[0, :, 1]
    assert (np.diff(values) >= 0).all()
    assert values[0] < 200 and values[-1] >= 64_000


@pytest.mark.parametrize("tone", TONES)
def test_black_is_black_and_no_value_is_out_of_range(tone):
    assert not develop(linear_of(0.0), DevelopSpec(tone=tone)).any()
    wild = np.random.default_rng(3).uniform(0, 1, (40, 40, 4)).astype(np.float32) ** 8 * 1e6
    picture = develop(wild, DevelopSpec(tone=tone, saturation=2.0, contrast=1.5))
    assert picture.dtype == np.uint8 and picture.shape == (40, 40, 3)


def test_agx_keeps_middle_grey():
    assert develop(linear_of(0.18), DevelopSpec(bloom=0), bits=16)[0, 0, 0] / 65535 == pytest.approx(
        encode_srgb(0.18), abs=2e-3
    )


def test_no_tone_map_is_the_srgb_transfer_exactly():
    grey = np.linspace(0, 1, 500)
    picture = develop(linear_of(grey), DevelopSpec(tone="none", bloom=0), bits=16)
    assert np.abs(picture[0, :, 0] / 65535 - encode_srgb(grey.astype(np.float32))).max() < 4e-5


def test_exposure_is_in_stops():
    one = develop(linear_of(0.05), DevelopSpec(tone="none", bloom=0, exposure=2), bits=16)
    assert one[0, 0, 0] / 65535 == pytest.approx(encode_srgb(0.2), abs=1e-4)


def test_dark_gradients_have_no_bands():
    """Where 8 bits have steps 30 pixels wide, the mean over rows must follow the gradient to a tenth of a step."""
    ramp = np.zeros((400, 600, 4), np.float32)
    ramp[..., :3] = np.linspace(0.001, 0.004, 600)[None, :, None]
    spec = DevelopSpec(tone="none", bloom=0)
    fine = develop(ramp, spec, bits=16)[0, :, 0] / 65535 * 255
    mean = develop(ramp, spec).astype(np.float64).mean(axis=0)[:, 0]
    plain = develop(ramp, DevelopSpec(tone="none", bloom=0, dither=False)).astype(np.float64).mean(axis=0)[:, 0]
    assert np.abs(mean - fine).max() < 0.12 < 0.4 < np.abs(plain - fine).max()


def test_dither_changes_with_the_frame_and_repeats_with_it():
    linear = linear_of(0.01, 200)
    assert np.array_equal(develop(linear, frame=3), develop(linear, frame=3))
    assert not np.array_equal(develop(linear, frame=3), develop(linear, frame=4))


def test_vignette_takes_its_stops_in_the_corner_and_none_in_the_middle():
    linear = np.full((201, 201, 4), 0.25, np.float32)
    picture = develop(linear, DevelopSpec(tone="none", bloom=0, vignette=1), bits=16)[..., 0] / 65535
    assert picture[100, 100] == pytest.approx(encode_srgb(0.25), abs=1e-3)
    assert picture[0, 0] == pytest.approx(encode_srgb(0.125), abs=4e-3)


def test_backgrounds_lie_behind_what_covers():
    linear = np.zeros((10, 30, 4), np.float32)
    linear[:, 10:20] = (0, 0, 0, 1)
    linear[:, 20:] = (0, 0, 0, 0.5)
    picture = develop(linear, DevelopSpec(tone="none", bloom=0, background=[0.5, 0.5, 0.5]), bits=16) / 65535
    assert picture[5, 5, 0] == pytest.approx(0.5, abs=1e-3)
    assert picture[5, 15, 0] == 0.0
    assert picture[5, 25, 0] == pytest.approx(encode_srgb(0.5 * ((0.5 + 0.055) / 1.055) ** 2.4), abs=1e-3)
    for tone in TONES:
        plain = develop(linear[:, :10], DevelopSpec(tone=tone, exposure=3, background="teal"), bits=16)[0, 0] / 65535
        assert plain == pytest.approx(srgb("teal"), abs=1e-3), "as it is written"
    night = develop(np.zeros((90, 16, 4), np.float32), DevelopSpec(background="night"), bits=16)
    assert (np.diff(night[:, 0, 2].astype(int)) >= 0).all() and night[0, 0].max() < night[-1, 0].max() < 20_000


def test_transparent_light_over_black_is_the_picture_itself():
    rng = np.random.default_rng(2)
    linear = rng.uniform(0, 0.8, (20, 20, 4)).astype(np.float32)
    linear[..., 3] *= linear[..., :3].max(axis=2)
    spec = DevelopSpec(tone="none", bloom=0)
    plain = develop(linear, spec, bits=16) / 65535
    clear = develop(linear, spec, transparent=True, bits=16) / 65535

    def decode(e):
        return np.where(e <= 0.04045, e / 12.92, ((e + 0.055) / 1.055) ** 2.4)

    assert clear.shape[2] == 4
    assert np.abs(decode(clear[..., :3]) * clear[..., 3:] - decode(plain)).max() < 1e-3
    assert not develop(np.zeros((4, 4, 4), np.float32), spec, transparent=True)[..., 3].any()


def test_grain_has_its_deviation_at_middle_grey():
    linear = np.full((300, 300, 4), 0.2140411, np.float32)  # encodes to one half
    picture = develop(linear, DevelopSpec(tone="none", bloom=0, grain=0.03), bits=16) / 65535
    assert picture.std() == pytest.approx(0.03, rel=0.03) and picture.mean() == pytest.approx(0.5, abs=2e-3)


def test_other_depths_are_refused():
    with pytest.raises(UsageError, match="8 or 16"):
        develop(linear_of(0.1), bits=10)
