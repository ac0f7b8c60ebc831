"""Light that smoke scatters many times: the white furnace, slabs against the integral equation, energy, and who gets it."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.preset.light import Light
from gen_art.renderer import multiple_scattering
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.multiple_scattering import albedo_on_nodes, light_scattered_many_times
from gen_art.renderer.smoke_density import Smoke
from gen_art.renderer.smoke_lighting import LitParticles, scattered_light

LAYERS, FIRST, WIDE = 16, 5, 97


def exponential_integral(n, x):
    """E_n(x) = integral of mu^(n - 2) e^(-x / mu) over 0..1, n >= 2, by Gauss's rule in mu = s^2."""
    s, w = np.polynomial.legendre.leggauss(200)
    s, w = 0.5 * (s + 1), 0.5 * w
    mu = s * s
    return (w * 2 * s * mu ** (n - 2) * np.exp(-np.asarray(x)[..., None] / mu)).sum(axis=-1)


def exact_slab(depth, albedo, lamp, sky, layers=200):
    """(reflected, transmitted) shares of light on a slab with isotropic scattering: S = albedo / 2 integral E1 S + once scattered light.

    lamp : irradiance that falls straight down; sky : the radiance of all directions from above
    """
    edge = np.linspace(0, depth, layers + 1)
    middle = 0.5 * (edge[1:] + edge[:-1])
    e2 = exponential_integral(2, np.abs(middle[:, None] - edge[None]))
    above = edge[None] <= middle[:, None]
    kernel = np.where(above[:, :-1] & ~above[:, 1:], 2.0 - e2[:, :-1] - e2[:, 1:], np.abs(e2[:, 1:] - e2[:, :-1]))
    given = albedo * (lamp / (4 * np.pi) * np.exp(-middle) + 0.5 * sky * exponential_integral(2, middle))
    source = np.linalg.solve(np.eye(layers) - 0.5 * albedo * kernel, given)
    width = depth / layers
    up = 2 * np.pi * (source * exponential_integral(2, middle)).sum() * width
    down = 2 * np.pi * (source * exponential_integral(2, depth - middle)).sum() * width
    down += lamp * np.exp(-depth) + 2 * np.pi * sky * float(exponential_integral(3, np.array(depth)))
    return up / (lamp + np.pi * sky), down / (lamp + np.pi * sky)


def solved_slab(depth, albedo, lamp, sky, asymmetry=0.0):
    """The same from light_scattered_many_times: what leaves the middle of a wide slab."""
    extinction = np.zeros((WIDE, WIDE, LAYERS + 2 * FIRST), np.float32)
    extinction[:, :, FIRST : FIRST + LAYERS] = depth / LAYERS
    smoke = Smoke(np.eye(3), 1.0, np.zeros(3), extinction)
    part = 1.0 - albedo * asymmetry
    straight = np.exp(-part * smoke.depth((0, 0, 1)).reshape(-1))
    direct = np.repeat((lamp / (4 * np.pi) * straight)[:, None], 3, axis=1)
    found = light_scattered_many_times(
        smoke, np.full(3, albedo), asymmetry, direct, lambda w: np.full(3, sky * (w[2] < -1e-9))
    )
    source = (found + direct).reshape(*extinction.shape, 3)[WIDE // 2, WIDE // 2, FIRST : FIRST + LAYERS, 0]
    source = source * albedo * (1 - asymmetry) / part
    depth = depth * part
    edge = np.linspace(0, depth, LAYERS + 1)
    leaves = exponential_integral(3, edge)
    up = 2 * np.pi * (source * -np.diff(leaves)).sum()
    down = 2 * np.pi * (source[::-1] * -np.diff(leaves)).sum()
    down += lamp * np.exp(-depth) + 2 * np.pi * sky * leaves[-1]
    return up / (lamp + np.pi * sky), down / (lamp + np.pi * sky)


def test_the_reference_conserves_energy():
    for depth in (0.3, 2.0, 8.0):
        assert sum(exact_slab(depth, 1.0, 1.0, 0.0)) == pytest.approx(1.0, abs=2e-3)
        assert sum(exact_slab(depth, 1.0, 0.0, 1.0)) == pytest.approx(1.0, abs=2e-3)
    # far inside a conservative slab light diffuses: T = (4 / 3) / (depth + 1.4209)
    assert exact_slab(12.0, 1.0, 0.0, 1.0)[1] == pytest.approx(4 / 3 / 13.4209, rel=5e-3)


@pytest.mark.parametrize("lamp,sky", [(1.0, 0.0), (0.0, 1.0)])
@pytest.mark.parametrize("depth", [0.5, 2.0, 6.0])
def test_a_slab_reflects_and_transmits_as_the_integral_equation_says(depth, lamp, sky):
    """To 4% of the light that falls on it. Mutants that fail: a mean cosine in place of isotropic scattering, only one scattering,
    the end of a cell for its mean, diagonals as long as the axes."""
    expected, got = exact_slab(depth, 1.0, lamp, sky), solved_slab(depth, 1.0, lamp, sky)
    assert got == pytest.approx(expected, abs=0.04)
    # the 14 directions see 4% less of half a sky than there is
    assert sum(got) == pytest.approx(1.0, abs=0.05 if lamp else 0.07)


def test_what_smoke_absorbs_is_missing():
    for albedo in (0.0, 0.6, 0.9):
        assert solved_slab(2.0, albedo, 1.0, 0.0) == pytest.approx(exact_slab(2.0, albedo, 1.0, 0.0), abs=0.03)


def test_forward_scattering_is_less_scattering():
    """Similarity: with a mean cosine g, a slab of depth t is one of depth t (1 - g) that scatters evenly."""
    assert solved_slab(4.0, 1.0, 0.0, 1.0, 0.5) == pytest.approx(exact_slab(2.0, 1.0, 0.0, 1.0), abs=0.04)
    assert solved_slab(2.0, 1.0, 0.0, 1.0, -0.5) == pytest.approx(exact_slab(3.0, 1.0, 0.0, 1.0), abs=0.04)


def test_the_iteration_has_converged(monkeypatch):
    """Dense knots in thin smoke, some cells 10 deep: twenty times the iterations change nothing by 2% of the largest light."""
    rng = np.random.default_rng(5)
    extinction = np.zeros((29, 37, 29), np.float32)
    extinction[6:23, 6:31, 6:23] = 0.1 * rng.uniform(0, 1, (17, 25, 17))
    extinction[tuple(rng.integers(6, 23, (3, 200)))] = 10.0 * rng.uniform(0, 1, 200)
    smoke = Smoke(np.eye(3), 1.0, np.zeros(3), extinction)
    direct = np.exp(-smoke.depth((0, 0, 1))).reshape(-1, 1) * np.array([1.0, 0.8, 0.5])
    albedo = np.array([0.8, 0.9, 1.0])

    def solved():
        return light_scattered_many_times(smoke, albedo, 0.0, direct, lambda w: np.array([0.1, 0.2, 0.4]) * (1 + w[2]))

    got = solved()
    monkeypatch.setattr(multiple_scattering, "ITERATIONS", (240, 1, 1))
    expected = solved()
    assert np.abs(got - expected).max() < 0.02 * expected.max()


def ball(n, depth, radius=1.0):
    rng = np.random.default_rng(3)
    x = rng.normal(0, 1, (n, 3))
    x *= radius * rng.uniform(0, 1, (n, 1)) ** (1 / 3) / np.linalg.norm(x, axis=1, keepdims=True)
    return x.astype(np.float32), np.full(n, depth / 2 * 4 / 3 * np.pi * radius**2 / n, np.float32)


@pytest.mark.parametrize("depth", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("phase", [0.0, 0.6])
def test_white_furnace(depth, phase):
    """Smoke that absorbs nothing, in an even sky, has the light of the sky at every place."""
    x, section = ball(20_000, depth)
    light = Lighting.of(Light(intensity=0.0, ambient_intensity=0.7, phase=phase, resolution=48), of_scene=True)
    got = scattered_light([LitParticles(light, x, section, np.full(len(x), 0.05, np.float32))], (0, 0, 9))[0]
    assert got == pytest.approx(np.full_like(got, 0.7), rel=1e-3)


@pytest.mark.parametrize("opacity", [0.005, 0.05, 0.5])
def test_white_smoke_before_an_even_sky_is_invisible(opacity):
    """Mutant that fails: a look's own light, where light is scattered once."""
    given = {
        "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/60"}, "sky": {"color": "#c8c8c8"},
        "systems": {"smoke": {
            "particle": {"radius": 0.15}, "emitters": {"all": {"count": 3000, "shape": {"ball": 1.0}}},
            "look": {"draw": "disc", "blend": "alpha", "opacity": opacity, "albedo": "white"},
        }},
        "camera": {"position": [0, 0, 6], "target": [0, 0, 0], "fov": 40},
    }  # fmt: skip
    got = ga.render_frame(ga.Simulation(ga.load_preset(given)), (96, 64))
    assert got[..., 0] == pytest.approx(np.full((64, 96), got[0, 0, 0]), rel=0.02)
    given["systems"]["smoke"]["look"]["light"] = {"intensity": 0, "ambient": "#c8c8c8", "ambient_intensity": 1}
    once = ga.render_frame(ga.Simulation(ga.load_preset(given)), (96, 64))
    assert opacity < 0.01 or once[32, 48, 0] < 0.9 * once[0, 0, 0]


def test_who_follows_light_and_who_does_not():
    assert Lighting.of(Light()).scatter == 0.2 and Lighting.of(Light(), of_scene=True).scatter is None
    assert Lighting.of(Light(scatter="full")).scatter is None
    assert Lighting.of(Light(scatter=0.5), of_scene=True).scatter == 0.5
    given = {"version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/60"}, "systems": {"a": {"look": {}}}}
    with pytest.raises(PresetError, match=r"light\.scatter: must be `full` or a number"):
        ga.load_preset({**given, "light": {"scatter": "often"}})


def test_the_shadowed_side_is_lit_by_the_lit_side():
    """Smoke of depth 12 lit from +x: its far side is dark grey, not black, and redder where the smoke is red."""
    x, section = ball(40_000, 12.0)
    radii = np.full(len(x), 0.08, np.float32)

    def far_side(albedo, **more):
        light = Lighting.of(
            Light(direction=(-1, 0, 0), intensity=1.0, ambient_intensity=0.0, resolution=48, **more), of_scene=True
        )
        particles = LitParticles(light, x, section, radii, np.tile(albedo, (len(x), 1)))
        return scattered_light([particles], (0, 0, 9))[0][x[:, 0] < -0.6].mean(axis=0)

    often, once = far_side([1.0, 0.8, 0.5]), far_side([1.0, 0.8, 0.5], scatter=0.0)
    assert once[0] < 0.01 and often[0] > 0.05 and often[0] > 1.5 * often[1] > 2 * often[2]


def test_no_particles_and_one():
    light = Lighting.of(Light(), of_scene=True)
    none, one = np.zeros((0, 3), np.float32), np.zeros((1, 3), np.float32)
    empty = LitParticles(light, none, np.zeros(0, np.float32), np.zeros(0, np.float32), none)
    single = LitParticles(light, one, np.full(1, 1e-3, np.float32), np.full(1, 0.1, np.float32), one + np.nan)
    assert scattered_light([empty], (0, 0, 5))[0].shape == (0, 3)
    assert np.isfinite(scattered_light([single, empty], (0, 0, 5))[0]).all()


def test_the_albedo_of_nodes_is_that_of_the_particles_around_them():
    rng = np.random.default_rng(8)
    x = rng.uniform(-1, 1, (4000, 3)).astype(np.float32)
    section, albedos = np.full(4000, 1e-3), np.where(x[:, :1] < 0, [[0.2, 0.4, 0.6]], [[0.9, 0.9, 0.9]])
    smoke = Smoke.of(x, section.astype(np.float32), np.full(4000, 0.1, np.float32), np.eye(3), 16)
    found = albedo_on_nodes(smoke, x, section, albedos).reshape(*smoke.extinction.shape, 3)
    place = (smoke.corner[0] + np.arange(smoke.extinction.shape[0])) * smoke.cell
    middle = tuple(n // 2 for n in smoke.extinction.shape[1:])
    left, right = np.argmin(np.abs(place + 0.6)), np.argmin(np.abs(place - 0.6))
    assert found[(left, *middle)] == pytest.approx([0.2, 0.4, 0.6]) and found[(right, *middle)] == pytest.approx(
        [0.9] * 3
    )
    albedos[:] = 0.3
    assert albedo_on_nodes(smoke, x, section, albedos) == pytest.approx([0.3] * 3)
    albedos[:] = np.nan
    assert albedo_on_nodes(smoke, x, section, albedos).tolist() == [1, 1, 1]


def test_a_wrong_scatter_names_what_is_known():
    with pytest.raises(ValueError, match="must be `full` or a number from 0 to 1, not 'fully'"):
        Light(scatter="fully")
    assert Light(scatter="1/4").scatter == 0.25 and Light(scatter="full").scatter == "full"
