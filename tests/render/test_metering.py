"""Automatic exposure: the meter counts light by light, smoothing looks back a fixed time, and both repeat to the bit."""

import math

import numpy as np
import pytest

from gen_art.preset.develop import AutoExposure, DevelopSpec
from gen_art.renderer.auto_exposure import metered_stops, metering_ages, smoothed_exposure
from gen_art.renderer.colour import LUMINANCE, to_linear
from gen_art.renderer.tone_map import develop


def grey(level: float, size=(90, 160)) -> np.ndarray:
    return np.full((*size, 4), level, np.float32)


def test_even_light_is_metered_as_it_is():
    for stops in (-9.0, 0.0, 3.5):
        assert metered_stops(grey(0.18 * 2.0**stops)) == pytest.approx(stops, abs=1e-5)
    green = np.zeros((20, 30, 4), np.float32)
    green[..., 1] = 0.18 / LUMINANCE[1]
    assert metered_stops(green) == pytest.approx(0.0, abs=1e-5)
    assert metered_stops(grey(0.0)) == -math.inf


def test_the_meter_is_its_formula():
    rng = np.random.default_rng(4)
    linear = rng.exponential(0.3, (72, 128, 4)).astype(np.float32) * rng.integers(0, 2, (72, 128, 1))
    linear = linear.astype(np.float32)
    cells = (linear[..., :3].astype(np.float64) @ LUMINANCE).reshape(36, 2, 64, 2).mean(axis=(1, 3))
    lit = cells[cells > 0]
    formula = (lit * np.log2(lit)).sum() / lit.sum() - math.log2(0.18)
    assert metered_stops(linear) == pytest.approx(formula, abs=1e-5)


def test_twice_the_light_is_a_stop_and_black_around_it_counts_nothing():
    linear = np.random.default_rng(2).exponential(1.0, (72, 128, 4)).astype(np.float32)
    assert metered_stops(2 * linear) - metered_stops(linear) == pytest.approx(1.0, abs=1e-6)
    wide = np.zeros((144, 128, 4), np.float32)
    wide[:72] = grey(0.5, (72, 128))
    assert metered_stops(wide) == pytest.approx(metered_stops(grey(0.5)), abs=1e-6)


def test_a_picture_is_metered_alike_at_any_size():
    small = np.random.default_rng(3).exponential(1.0, (72, 128, 4)).astype(np.float32)
    large = small.repeat(3, axis=0).repeat(3, axis=1)
    assert metered_stops(large) == pytest.approx(metered_stops(small), abs=1e-5)
    for shape in ((1, 1), (5, 3), (37, 61), (1, 200)):
        assert metered_stops(grey(0.18, shape)) == pytest.approx(0.0, abs=1e-5)


def test_what_is_no_number_is_left_out():
    linear = grey(0.18)
    linear[3, 3, 0] = np.nan
    linear[80, 100, 1] = np.inf
    assert metered_stops(linear) == pytest.approx(0.0, abs=1e-5)


def test_smoothing_is_the_mean_by_half_lives():
    spec = AutoExposure(key=0.36, half_life=0.5, range="-3..3")
    assert smoothed_exposure([0.7], [0.0], spec) == pytest.approx(1.0 - 0.7)
    assert smoothed_exposure([1.0, 0.0], [0.0, 0.5], spec) == pytest.approx(1.0 - 1.0 / 1.5)
    assert smoothed_exposure([2.0, -math.inf, 1.0], [0.0, 0.5, 1.0], spec) == pytest.approx(1.0 - (2.0 + 0.25) / 1.25)
    assert smoothed_exposure([-9.0], [0.0], spec) == 3.0 and smoothed_exposure([9.0], [0.0], spec) == -3.0
    assert smoothed_exposure([-math.inf], [0.0], spec) == 0.0 and smoothed_exposure([], [], spec) == 0.0
    assert smoothed_exposure([2.0, 0.0], [0.0, 1.0], AutoExposure(half_life=0)) == pytest.approx(-2.0)


@pytest.mark.parametrize("fps", [24, 30, 59.94])
@pytest.mark.parametrize("half_life", [0, 0.01, 0.5, 4])
def test_ages_are_whole_frames_back_and_few(fps, half_life):
    back = metering_ages(AutoExposure(half_life=half_life), fps)
    assert back[0] == 0.0 and len(back) <= 9 and back == sorted(set(back))
    assert np.abs(np.array(back) * fps - np.round(np.array(back) * fps)).max() < 1e-9
    if half_life >= 0.5:
        assert 2.0 * half_life < back[-1] < 4.0 * half_life


def test_a_step_of_light_is_followed_half_way_in_a_half_life():
    """Each frame's exposure is a function of the film alone, so the same from whatever frame a render starts."""
    spec, fps = AutoExposure(half_life=0.5), 24
    metered = [0.0] * 48 + [4.0] * 72

    def exposure(k):
        times = [k / fps - age for age in metering_ages(spec, fps)]
        seen = [(k / fps - t, metered[round(t * fps)]) for t in times if t >= -1e-9]
        return smoothed_exposure([v for _, v in seen], [a for a, _ in seen], spec)

    way = [exposure(k) for k in range(120)]
    assert way[47] == 0.0 and way[-1] == pytest.approx(-4.0)
    assert (np.diff(way) <= 1e-12).all()
    assert way[48 + 12] == pytest.approx(-2.0, abs=0.8)


def test_an_exposed_picture_has_its_key():
    spec = DevelopSpec(tone="none", bloom=0, auto_exposure=0.3)
    linear = grey(0.01)
    stops = smoothed_exposure([metered_stops(linear)], [0.0], spec.auto_exposure)
    picture = develop(linear, spec, bits=16, exposure=stops) / 65535
    assert to_linear(picture).mean() == pytest.approx(0.3, rel=1e-3)
    assert DevelopSpec(auto_exposure={"key": 0.3}).auto_exposure == spec.auto_exposure
    with pytest.raises(ValueError, match="range of an exposure must lie within"):
        AutoExposure(range="-100..0")
