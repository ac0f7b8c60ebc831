"""The band of distant stars: where it lies, what its keys do, and what is wrong."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.preset.load import load_preset
from gen_art.preset.sky import Band, Sky
from gen_art.renderer.colour import luminance_of
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.sky_band import band_light
from gen_art.renderer.sky_table import directions_of_table, look_up


def directions(number=20_000):
    d = np.random.default_rng(3).normal(size=(number, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def light(d=None, **keys):
    return luminance_of(band_light(Band(**keys), directions() if d is None else d))


def test_the_table_holds_the_directions_that_it_is_read_with():
    table = directions_of_table()
    d = directions(500)
    found = look_up(table, d)
    assert found == pytest.approx(
        d, abs=2e-3
    )  # between entries 0.02 rad apart a chord is 5e-5 short; more at the poles


@pytest.mark.parametrize("normal", [(0, 1, 0), (0.5, 0.8, 0.1)])
def test_its_light_lies_near_its_plane(normal):
    """Seven tenths of the light within three widths, where a fifth of the sphere is; a mutant with another normal fails."""
    d, n = directions(), np.array(normal) / math.sqrt(sum(x * x for x in normal))
    got, height = light(normal=normal, core=(1, -0.2, 0.3), width=4), np.abs(d @ n)
    near = height < math.sin(math.radians(12))
    assert 0.18 < near.mean() < 0.24
    assert got[near].sum() > 0.7 * got.sum() and got[height > math.sin(math.radians(50))].max() < 1e-3


@pytest.mark.parametrize("width", [2, 8])
def test_its_width_is_that_of_its_light(width):
    """The root mean square of the height above the plane is that of a Gaussian, but for its wider part, the bulge at the core and the
    limit of a sphere. Mutants: half and twice the width."""
    d = directions(8000)
    got = light(d, width=width, dust=0)
    height = math.degrees(math.asin(math.sqrt((got * d[:, 1] ** 2).sum() / got.sum())))
    assert 0.8 * width < height < 1.4 * width


def test_a_normal_has_any_length_and_a_core_any_height():
    """Only directions count: of the normal, and of the core's part in the plane. Mutants: a normal or a core that is taken as it is."""
    d = directions(2000)
    assert light(d, normal=(0, 7, 0)) == pytest.approx(light(d, normal=(0, 1, 0)), rel=1e-9, abs=1e-12)
    assert light(d, core=(3, 4, 0)) == pytest.approx(light(d, core=(1, 0, 0)), rel=1e-9, abs=1e-12)


def test_its_core_is_brightest():
    d, core = directions(), np.array([1.0, 0.0, 0.0])
    got = light(core=tuple(core), dust=0)
    towards = d @ core
    near, away = (towards > 0.9) & (np.abs(d[:, 1]) < 0.1), (towards < -0.9) & (np.abs(d[:, 1]) < 0.1)
    assert got[near].mean() > 1.5 * got[away].mean()


def places(angle, height, number=400):
    """Directions at an angle (rad) from the core, +x, and at this height (rad) over the plane or below it."""
    rng = np.random.default_rng(1)
    a, h = angle + rng.uniform(-0.05, 0.05, number), height + rng.uniform(-0.007, 0.007, number)
    a, h = a * rng.choice([-1, 1], number), h * rng.choice([-1, 1], number)
    return np.stack([np.cos(h) * np.cos(a), np.sin(h), np.cos(h) * np.sin(a)], axis=1)


def over_seeds(angle, height, **keys):
    """The mean light of white clouds there, over many seeds."""
    keys |= {"color": ["white", "white"], "core": (1, 0, 0), "width": 4}
    d = places(angle, height)
    return np.mean([light(d, seed=seed, **keys).mean() for seed in range(60)])


@pytest.mark.parametrize("angle, widths", [(0, 0), (0.4, 0), (0.8, 0), (0, 1.5), (2.5, 1.5), (2.5, 3), (2.5, 5)])
def test_its_profile_is_that_of_the_formula(angle, widths):
    """Beside the light far from the core: exp(-(s / w)^2 / 2) (1 + 2 c) / 3 + exp(-(s / 3 w)^2 / 2) / 9, with c the core's Gaussian of
    0.4 rad, and w wider by 0.6 c in the first part. The clouds of 60 seeds differ by a hundredth and a half or so in the mean where
    one cloud covers the place, and by 5 times that at its rims: 12% in all.

    Mutants: no light of the core, half or twice as much; a core of half or twice the size; no bulge; no wide part, or of twice
    the width.
    """
    w = math.radians(4)
    core, s = math.exp(-(1 - math.cos(angle)) / 0.4**2), math.sin(widths * w)
    expected = (
        math.exp(-((s / w / (1 + 0.6 * core)) ** 2) / 2) * (1 + 2 * core) / 3 + math.exp(-((s / w / 3) ** 2) / 2) / 9
    )
    got = over_seeds(angle, widths * w, dust=0) / over_seeds(2.5, 0, dust=0)
    assert got == pytest.approx(expected / (1 / 3 + 1 / 9), rel=0.12)


def test_dust_lies_in_the_band():
    """Five widths over its plane there is none: exp(-25 / 2) of it. Mutant: dust over all the sky."""
    d = places(2.0, 5 * math.radians(4), 3000)
    clear, dusty = light(d, width=4, dust=0), light(d, width=4, dust=1)
    assert dusty == pytest.approx(clear, rel=1e-3)


def test_dust_darkens_and_intensity_is_a_factor():
    bare, dusty, twice = light(dust=0), light(dust=1), light(dust=1, intensity=2)
    assert np.all(dusty <= bare * (1 + 1e-9)) and dusty.mean() < 0.8 * bare.mean()
    assert twice == pytest.approx(2 * dusty, rel=1e-12) and np.all(dusty >= 0) and np.isfinite(bare).all()


def test_another_seed_gives_other_clouds():
    assert np.array_equal(light(seed=1), light(seed=1)) and np.corrcoef(light(seed=1), light(seed=2))[0, 1] < 0.95


def test_a_band_is_added_to_the_sky_behind_it():
    d, band = directions(300), Sky(band=True)
    both = SkyDome.of(Sky(color="#203040", band=True)).radiance(d)
    parts = SkyDome.of(Sky(color="#203040")).radiance(d) + SkyDome.of(band).radiance(d)
    assert both == pytest.approx(parts, abs=1e-6)
    twice = SkyDome.of(Sky(band=True, intensity=2)).radiance(d)
    assert twice == pytest.approx(2 * SkyDome.of(band).radiance(d), rel=1e-5)
    by_day = SkyDome.of(Sky(sun=20, band={"intensity": 5})).radiance(d)
    assert np.array_equal(
        by_day[d[:, 1] < -0.02], SkyDome.of(Sky(sun=20)).radiance(d)[d[:, 1] < -0.02]
    )  # the ground hides it


def test_a_sky_without_a_band_has_the_table_that_it_had():
    assert SkyDome.of(Sky(color="red")).table.shape[1] == 2 and SkyDome.of(Sky(band=False, color="red")).stars is None


def test_a_core_off_the_plane_is_one_sentence():
    base = {"version": 1, "clock": {"duration": 1, "step": "1/60"}, "systems": {"dots": {"look": {"draw": "point"}}}}
    with pytest.raises(PresetError, match="core"):
        load_preset({**base, "sky": {"band": {"normal": [0, 2, 0], "core": [0, 1, 0]}}})
    assert ga.load_preset({**base, "sky": {"band": 0.5}}).sky.band.intensity == 0.5
