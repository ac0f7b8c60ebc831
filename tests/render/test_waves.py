"""The waves of a floor: the way they lean, what a pixel keeps of them, and what it makes of the rest."""

import math

import numpy as np
import pytest

from gen_art.preset.surface import Waves
from gen_art.preset.values import Range
from gen_art.renderer.surfaces.surface_maps import wave_rows
from tests.render.test_surface_maps import FROM_ABOVE
from tests.render.test_surfaces import DARK, matte, picture


def one_length(length: float, slope: float, direction: float = 0.0) -> tuple[dict, np.ndarray]:
    """(keys, rows) of waves of one length and one direction."""
    keys = {"slope": slope, "length": f"{length}..{length}", "spread": 0, "direction": direction}
    rows = wave_rows(Waves.model_validate({**keys, "length": Range(length, length)}), 0.0)
    return keys, rows.astype(np.float64)


@pytest.mark.parametrize("direction", [0, 90, 30])
@pytest.mark.parametrize("lamp", [[-0.5, -0.8, 0], [0, -0.8, 0.6], [0.3, -0.8, -0.5]])
def test_a_long_wave_leans_as_its_slope_says(direction, lamp):
    """Waves far longer than the picture are a level that leans by their slopes: 4 I times the cosine of the lamp with its normal
    (-a, 1, -b). Mutants: the sign of the slope along x, of that along z; x and z exchanged; half the slope; sines for cosines."""
    keys, rows = one_length(5000.0, 0.4, direction)
    along = (rows[:, 2] * np.cos(rows[:, 3])).sum()
    a, b = along * math.cos(math.radians(direction)), along * math.sin(math.radians(direction))
    assert abs(along) > 0.1
    light = {"direction": lamp, "intensity": 0.25, **DARK}
    got = picture(ground=matte(waves=keys), light=light, camera=FROM_ABOVE, size=(16, 16))[..., 0]
    to_lamp = -np.array(lamp) / np.linalg.norm(lamp)
    cosine = float(to_lamp @ [-a, 1, -b]) / math.sqrt(1 + a * a + b * b)
    assert got == pytest.approx(cosine, rel=5e-3)


@pytest.mark.parametrize("pixels", [3, 5])
def test_a_pixel_keeps_its_mean_of_a_wave(pixels):
    """A wave with this many pixels a period keeps exp(-(k p)^2 / 24) of its slope in pixels of side p, as a Gaussian of a square's
    variance would. The light of a white floor goes with the slope, to its square. Mutants: no filter, a pixel of twice the size.
    """
    size, height, slope = 120, 4.0, 0.01
    keys, rows = one_length(pixels * height / size * 1.03, slope)
    light = {"direction": [-0.6, -0.8, 0], "intensity": 0.25, **DARK}
    got = picture(ground=matte(waves=keys), light=light, camera=FROM_ABOVE, size=(size, size))[..., 0].mean(axis=0)
    k, pixel = rows[0, 0], height / size
    phase = k * ((np.arange(size) + 0.5 - size / 2) * pixel)
    columns = np.stack([np.cos(phase), np.sin(phase), np.ones(size)], axis=1)
    cosine, sine, _ = np.linalg.lstsq(columns, got.astype(float), rcond=None)[0]
    whole = abs((rows[:, 2] * np.exp(1j * rows[:, 3])).sum())
    assert math.hypot(cosine, sine) == pytest.approx(0.6 * whole * math.exp(-((k * pixel) ** 2) / 24), rel=0.03)


def test_waves_that_a_pixel_does_not_show_make_it_rougher():
    """The highlight is that of a floor with roughness^4 + s^2, s^2 the mean square slope. Mutants: none is added; twice as much."""
    camera = {"position": [0, 4000, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 40}
    light, finish = {"direction": [0, -1, 0], "intensity": 1, **DARK}, {"albedo": "black", "ior": 1.33}
    square = 0.08**2
    waves = {"slope": 0.08, "length": "0.01..0.02", "spread": 180}
    wavy, rough, smooth = (
        picture(ground={**finish, **more}, light=light, camera=camera)[..., 0]
        for more in (
            {"roughness": 0.25, "waves": waves},
            {"roughness": (0.25**4 + square) ** 0.25},
            {"roughness": 0.25},
        )
    )
    assert wavy == pytest.approx(rough, rel=2e-3) and smooth.max() > 1.3 * rough.max()


def test_the_speed_of_waves():
    """At twice the speed they are where they would be after twice the time. Mutant: the speed is left out."""
    fast, late = (wave_rows(Waves(slope=0.1, speed=speed), time) for speed, time in ((2.0, 0.7), (1.0, 1.4)))
    assert fast == pytest.approx(late, abs=1e-4)
    assert not np.allclose(fast[:, 3], wave_rows(Waves(slope=0.1), 0.7)[:, 3], atol=0.1)
