"""Stars: their number and light by the stated law, and an energy that does not depend on where they fall between pixels."""

import math

import numpy as np
import pytest

from gen_art.preset.sky import Sky, Stars
from gen_art.renderer.camera import Camera
from gen_art.renderer.colour import luminance_of
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.stars import StarField, add_stars, star_field, stars_brighter

UNIT = math.pi * math.radians(0.1) ** 2  # sr, the light of a star of magnitude 0


def magnitudes(field: StarField) -> np.ndarray:
    return -2.5 * np.log10(luminance_of(field.light) / UNIT)


def test_as_many_stars_as_the_eye_sees():
    assert 5_000 < len(star_field(Stars()).light) < 9_500
    assert len(star_field(Stars(magnitude=4)).light) == pytest.approx(513, rel=0.02)


@pytest.mark.parametrize("seed", [0, 7])
def test_the_number_grows_as_ten_to_half_the_magnitude(seed):
    """One star stands in each whole number of the law, so a count differs from it by less than 1."""
    m = magnitudes(star_field(Stars(magnitude=7, seed=seed)))
    assert np.all(np.diff(m) > 0) and m[0] > -2.1
    for limit in (0.0, 2.0, 4.5, 6.9):
        assert abs((m < limit).sum() - 5.1 * 10 ** (limit / 2)) < 1.0
        assert abs((m < limit).sum() - stars_brighter(limit)) < 1.0


def test_all_light_is_the_integral_of_the_law():
    """Sum over ranks n of (n / 5.1)^-0.8; each term lies between those at k + 1/2 and k + 1, where it stands."""
    light = luminance_of(star_field(Stars(magnitude=6)).light).sum() / UNIT
    k = np.arange(int(stars_brighter(6.0)))
    low, high = (((k + end) / 5.1) ** -0.8 for end in (1.0, 0.5))
    assert low.sum() < light < high.sum()
    # the mean rank is k + 3/4, in the middle of k + 1/4 .. k + 5/4
    integral = 5.1 / 0.2 * ((len(k) / 5.1) ** 0.2 - (0.25 / 5.1) ** 0.2)
    assert light == pytest.approx(integral, rel=0.03)


def test_fainter_stars_move_none_and_a_seed_moves_all():
    few, many, other = (
        star_field(Stars(**keys)) for keys in ({"magnitude": 5}, {"magnitude": 6}, {"magnitude": 5, "seed": 1})
    )
    n = len(few.light)
    assert np.array_equal(few.directions, many.directions[:n]) and np.array_equal(few.light, many.light[:n])
    assert np.abs(few.directions - other.directions).max(axis=1).min() > 1e-6


def test_they_are_even_over_the_sphere():
    """Means of a coordinate and of its square within four standard errors of 0 and 1/3."""
    d = star_field(Stars()).directions
    n = len(d)
    assert np.linalg.norm(d, axis=1) == pytest.approx(np.ones(n), abs=1e-12)
    assert np.all(np.abs(d.mean(axis=0)) < 4 * math.sqrt(1 / 3 / n))
    assert np.all(np.abs((d**2).mean(axis=0) - 1 / 3) < 4 * math.sqrt((1 / 5 - 1 / 9) / n))


def test_their_colours_go_from_red_to_blue():
    light = star_field(Stars()).light
    ratio = light[:, 2] / light[:, 0]
    assert ratio.min() < 0.3 and ratio.max() > 1.4
    assert 0.2 < np.mean(ratio > 1.0) < 0.6


@pytest.mark.parametrize("scale", [100.0, 1234.5])
@pytest.mark.parametrize("x, y", [(0.0, 0.0), (0.5, 0.5), (0.13, -0.48), (20.3, 11.77)])
def test_a_star_s_energy_is_the_same_wherever_it_falls(scale, x, y):
    """x, y : pixels from the middle. The sum of its pixels, times the solid angle of a pixel there."""
    d = np.array([x / scale, y / scale, -1.0])
    cosine = 1.0 / np.linalg.norm(d)
    pixels = np.zeros((60, 80, 4), np.float32)
    add_stars(
        StarField((d * cosine)[None], np.array([[1e-5, 2e-5, 3e-5]])),
        Camera(position=(0, 0, 9)).at().axes,
        scale,
        pixels,
    )
    energy = pixels[..., :3].sum(axis=(0, 1), dtype=float) * cosine**3 / scale**2
    assert energy == pytest.approx([1e-5, 2e-5, 3e-5], rel=1e-5)
    rows, columns = np.nonzero(pixels[..., 0])
    weights = pixels[rows, columns, 0] / pixels[..., 0].sum()
    assert weights @ (columns + 0.5) == pytest.approx(40 + x, abs=1e-4) and weights @ (rows + 0.5) == pytest.approx(
        30 - y, abs=1e-4
    )


def test_what_hides_the_sky_hides_the_stars():
    star = StarField(np.array([[0.0, 0.0, -1.0]]), np.array([[1.0, 1.0, 1.0]]))
    clear, covered = np.zeros((9, 9, 4), np.float32), np.zeros((9, 9, 4), np.float32)
    covered[..., 3] = 0.75
    for pixels in (clear, covered):
        add_stars(star, Camera(position=(0, 0, 9)).at().axes, 10.0, pixels)
    assert covered[..., :3] == pytest.approx(0.25 * clear[..., :3])


def test_the_stars_behind_the_camera_are_not_drawn():
    pixels = np.zeros((9, 9, 4), np.float32)
    back = StarField(np.array([[0.0, 0.0, 1.0]]), np.array([[1.0, 1.0, 1.0]]))
    add_stars(back, Camera(position=(0, 0, 9)).at().axes, 10.0, pixels)
    assert not pixels.any()


def test_the_air_dims_and_reddens_stars_and_the_ground_hides_them():
    bare, seen = SkyDome.of(Sky(stars=True)).stars, SkyDome.of(Sky(sun=-5, stars=True)).stars
    ratio = seen.light / bare.light
    y = bare.directions[:, 1]
    assert np.all(ratio[y < 0] == 0.0)
    high, low = ratio[y > 0.95].mean(axis=0), ratio[(y > 0.05) & (y < 0.1)].mean(axis=0)
    assert np.all(high > 0.7) and np.all(low < high)
    assert low[2] / low[0] < 0.7 * high[2] / high[0]
