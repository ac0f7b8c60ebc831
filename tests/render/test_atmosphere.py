"""The air: closed forms of its columns, Rayleigh's law, energy, and the colours of day and dusk."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gen_art.preset.sky import Sky, Sun
from gen_art.renderer import atmosphere, daylight, scattering
from gen_art.renderer.atmosphere import AEROSOL_HEIGHT, AIR_HEIGHT, GROUND, TOP, Air, columns, sunlight
from gen_art.renderer.colour import LUMINANCE
from gen_art.renderer.daylight import sky_irradiance
from gen_art.renderer.scattering import aerosol_phase, along_rays, angle_to_sun, multiple_scattering, rayleigh_phase
from gen_art.renderer.sky import SkyDome

NONE = np.zeros(atmosphere.BANDS)
UP = np.linspace(0.0, math.pi / 2, 81)
UP = math.pi / 2 * (UP / UP[-1]) ** 2  # dense at the horizon
ROUND = np.linspace(0.0, math.pi, 25)


def midpoint_error(height: float) -> float:
    """The most that the midpoint rule in u, s = L u^2, is wrong for exp(-s / height): du^2 / 24 max|f''|."""
    length, du = TOP - GROUND, 1.0 / atmosphere._STEPS
    u = np.linspace(0.0, 1.0, 100_001)
    f = 2.0 * length * u * np.exp(-length * u * u / height)
    return float(du**2 / 24 * np.abs(np.diff(f, 2)).max() * 1e10)


@pytest.mark.parametrize("k, height", [(0, AIR_HEIGHT), (1, AEROSOL_HEIGHT)])
def test_straight_up_the_columns_are_those_of_an_exponential(k, height):
    exact = height * (1.0 - math.exp(-(TOP - GROUND) / height))
    assert abs(columns(GROUND, 1.0)[k] - exact) <= midpoint_error(height)
    assert abs(columns(GROUND, 1.0)[k] - 1.02 * exact) > midpoint_error(height), "two hundredths more would be noticed"


def test_straight_up_the_ozone_is_a_triangle_of_thirty_kilometres():
    """15,000 m of the densest; kinks of the triangle cost half a step of the sum at most."""
    assert columns(GROUND, 1.0)[2] == pytest.approx(15_000.0, rel=2e-3)


def test_along_the_horizon_the_column_is_chapman_s():
    """sqrt(pi R H / 2) (1 + 3 H / (8 R)), of which e^-7.5 lies above the top."""
    exact = math.sqrt(0.5 * math.pi * GROUND * AIR_HEIGHT) * (1.0 + 3.0 * AIR_HEIGHT / (8.0 * GROUND))
    assert columns(GROUND, 0.0)[0] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("height, slant", [(0.0, 0.05), (800.0, -0.01), (9_000.0, -0.03), (30_000.0, 0.0)])
def test_slant_columns_are_the_integrals_along_the_ray(height, slant):
    """The table is linear between its entries, which costs up to 0.5% between heights."""
    radius = GROUND + height
    length, meets = scattering.ray_length(radius, slant)
    assert not meets
    s = (np.arange(40_000) + 0.5) * (length / 40_000)
    exact = atmosphere.densities(np.sqrt(radius**2 + s * s + 2.0 * radius * s * slant) - GROUND).sum(0) * (
        length / 40_000
    )
    assert columns(radius, slant) == pytest.approx(exact, rel=5e-3, abs=1e-3)


@pytest.mark.parametrize("phase", [rayleigh_phase, aerosol_phase])
def test_phase_functions_give_all_of_the_light(phase):
    x, weight = np.polynomial.legendre.leggauss(64)
    assert 2.0 * math.pi * float(weight @ phase(x)) == pytest.approx(1.0, abs=1e-9)


def test_thin_air_scatters_as_the_inverse_fourth_power_of_the_wavelength():
    """L = scattering * H * phase to the depth of the air, 3e-4 of it, and the error of 32 steps in s = L u^2."""
    thin = 1e-3
    air = replace(Air.of_earth(0.0, 0.0), ozone=NONE)
    air = replace(air, rayleigh=thin * air.rayleigh)
    rays = along_rays(air, np.zeros((16, 28, 17)), GROUND + 1.0, [1.0], np.zeros(1), 1.0)
    expected = air.rayleigh * AIR_HEIGHT * (1.0 - math.exp(-(TOP - GROUND) / AIR_HEIGHT))
    assert rays.by_air[0, 0] == pytest.approx(expected, rel=2e-3)
    wavelength = np.array([390.0, 710.0])
    ratio = rays.by_air[0, 0, 0] / rays.by_air[0, 0, -1]
    assert ratio == pytest.approx((wavelength[1] / wavelength[0]) ** 4, rel=0.02), "bands of 20 nm"


def fluxes(air: Air, sun: float, psi) -> tuple[np.ndarray, np.ndarray]:
    """(17,) light that leaves the air at the top, and that falls on the ground, of that which comes in."""
    upward = along_rays(air, psi, GROUND + 1.0, np.sin(UP) + 1e-9, ROUND, sun, 64)
    light = upward.radiance(angle_to_sun(np.sin(UP)[:, None], ROUND, sun))
    on_ground = sunlight(air, GROUND + 1.0, sun) * sun + sky_irradiance(light, UP, ROUND)
    down = -np.sin(UP) - 1e-9
    rays = along_rays(air, psi, TOP - 1.0, down, ROUND, sun, 64)
    _, meets = scattering.ray_length(TOP - 1.0, down)
    light = rays.radiance(angle_to_sun(down[:, None], ROUND, sun))
    light = light + (rays.passed * meets[:, None] * air.albedo * on_ground / math.pi)[:, None]
    return sky_irradiance(light, UP, ROUND) / sun, on_ground / sun


def lossless(haze: float, albedo: float) -> Air:
    air = Air.of_earth(haze, albedo)
    return replace(air, ozone=NONE, aerosol_extinction=air.aerosol_scattering)


@pytest.mark.parametrize("haze, error", [(0.0, 0.02), (0.11, 0.03)])
@pytest.mark.parametrize("sun", [1.0, 0.5])
def test_air_that_absorbs_nothing_over_black_ground_returns_what_comes_in(haze, error, sun):
    """What leaves at the top and what the ground takes add up to 1, but for Hillaire's approximation. Its error, Psi the same in
    all directions, grows with the aerosol; what is scattered but once falls short by far more."""
    air = lossless(haze, 0.0)
    psi = multiple_scattering(air)
    total = sum(fluxes(air, sun, psi))
    assert np.abs(total - 1.0).max() < error
    assert (1.0 - sum(fluxes(air, sun, 0.0 * psi))).max() > 4.0 * error, "without the light that is scattered often"


@pytest.mark.parametrize("sun", [1.0, 0.5])
def test_air_that_absorbs_nothing_over_white_ground_returns_all_light(sun):
    air = lossless(0.11, 1.0)
    albedo, _ = fluxes(air, sun, multiple_scattering(air))
    assert albedo == pytest.approx(np.ones(17), abs=0.065)


def test_ozone_and_soot_take_light():
    air = Air.of_earth(1.0, 1.0)
    assert fluxes(air, 0.5, multiple_scattering(air))[0].max() < 1.0


def irradiance(dome: SkyDome) -> np.ndarray:
    """Of a level plane, by sky and sun, from the finished table."""
    e = math.pi / 2 * ((np.arange(400) + 0.5) / 400)
    a = 2.0 * math.pi * (np.arange(240) + 0.5) / 240
    d = np.stack(
        np.broadcast_arrays(np.cos(e)[:, None] * np.sin(a), np.sin(e)[:, None], -np.cos(e)[:, None] * np.cos(a)), -1
    )
    light = dome.radiance(d.reshape(-1, 3)).reshape(400, 240, 3)
    weight = (np.sin(e) * np.cos(e))[:, None, None] * (math.pi / 2 / 400) * (2.0 * math.pi / 240)
    return (light * weight).sum(axis=(0, 1)) + dome.sun_irradiance * dome.sun_direction[1]


@pytest.mark.parametrize("more", [{}, {"haze": 0.0}, {"haze": 8.0, "ground": "white"}])
def test_noon_lights_a_white_floor_with_light_1(more):
    assert irradiance(SkyDome.of(Sky(sun=90, **more))) == pytest.approx([math.pi] * 3, rel=0.01)


def test_other_heights_keep_the_ratio():
    noon, low = (SkyDome.of(Sky(sun=h)) for h in (90, 10))
    assert 0.05 < (irradiance(low) @ LUMINANCE) / math.pi < math.sin(math.radians(10)) * 1.2
    assert np.all(np.diff([SkyDome.of(Sky(sun=h)).sun_irradiance for h in (0.5, 3, 10, 90)], axis=0) > 0)
    assert noon.sun_irradiance.max() < math.pi


def up(degrees: float, toward: float = 0.0) -> list[float]:
    """A direction so many degrees above the horizon; toward : degrees from the sun's azimuth 0."""
    e, a = math.radians(degrees), math.radians(toward)
    return [math.cos(e) * math.sin(a), math.sin(e), -math.cos(e) * math.cos(a)]


def test_the_sky_is_blue_by_day_and_red_at_the_horizon_where_the_sun_sets():
    day, dusk = SkyDome.of(Sky(sun=60)), SkyDome.of(Sky(sun=1))
    red, green, blue = day.radiance([up(60, 180)])[0]
    assert blue > 1.3 * green > 1.3 * 1.3 * red
    red, green, blue = dusk.radiance([up(1)])[0]
    assert red > 1.5 * green > 1.5 * 3.0 * blue
    red, green, blue = dusk.sun_irradiance
    assert red > 2.0 * green > 2.0 * 5.0 * blue, "the sun itself"


def test_ozone_keeps_the_zenith_blue_at_dusk():
    """Without it the zenith of a set sun is pale (Hulburt 1953)."""
    air, clear = Air.of_earth(0.3, 0.2), replace(Air.of_earth(0.3, 0.2), ozone=NONE)
    shares = []
    for one in (air, clear):
        light = along_rays(
            one, multiple_scattering(one), GROUND + 200.0, [1.0], np.zeros(1), math.sin(math.radians(-4))
        )
        spectrum = light.radiance(np.full((1, 1), math.sin(math.radians(-4))))[0, 0]
        shares.append(spectrum[3] / spectrum[10])  # 450 and 590 nm
    assert shares[0] > 2.0 * shares[1]


def test_haze_reddens_and_dims_the_sun_and_whitens_the_horizon():
    clear, hazy = (SkyDome.of(Sky(sun=30, haze=haze)) for haze in (0.1, 6.0))
    assert np.all(hazy.sun_irradiance < clear.sun_irradiance)
    blueness = [dome.radiance([up(3, 180)])[0] for dome in (clear, hazy)]
    assert blueness[0][2] / blueness[0][0] > 1.2 * blueness[1][2] / blueness[1][0]


def test_the_earth_s_shadow_rises_opposite_the_sun_that_has_set():
    """Above the shadow the air is still lit, by red light: the belt of Venus."""
    dome = SkyDome.of(Sky(sun=-1.0))
    shadow, belt = dome.radiance([up(1, 180), up(8, 180)])
    assert belt[0] / belt[2] > 1.5 * shadow[0] / shadow[2]


def test_the_sun_s_azimuth_turns_the_sky():
    one, other = SkyDome.of(Sky(sun=20)), SkyDome.of(Sky(sun=Sun(height=20, azimuth=90)))
    e = math.radians(20)
    assert one.sun_direction == pytest.approx([0.0, math.sin(e), -math.cos(e)], abs=1e-12)
    assert other.sun_direction == pytest.approx([math.cos(e), math.sin(e), 0.0], abs=1e-12)
    assert other.radiance([up(10, 120)]) == pytest.approx(one.radiance([up(10, 30)]), rel=5e-3)
    assert one.radiance([up(10, 120)]) != pytest.approx(one.radiance([up(10, 30)]), rel=0.1)


def test_the_sky_is_lit_evenly_on_both_sides_of_the_sun():
    dome = SkyDome.of(Sky(sun=15))
    assert dome.radiance([up(7, 33)]) == pytest.approx(dome.radiance([up(7, -33)]), rel=1e-6)


def test_what_is_shown_at_the_horizon_touches_the_ground():
    """And straight up and down stay what they are."""
    e = float(daylight._seen(0.0))
    assert (GROUND + daylight.EYE) * math.cos(e) == pytest.approx(GROUND, abs=1e-3)
    assert daylight._seen(np.array([-1.0, 1.0]) * math.pi / 2) == pytest.approx([-math.pi / 2, math.pi / 2], abs=1e-12)


def test_the_horizon_is_a_line_in_clear_air_and_none_in_haze():
    step = []
    for haze in (0.0, 10.0):
        above, below = SkyDome.of(Sky(sun=40, haze=haze)).radiance([up(1e-7), up(-1e-7)]) @ LUMINANCE
        step.append(abs(above - below) / above)
    assert step[0] > 0.2 and step[1] < 0.01
