"""Light in smoke: Beer and Lambert's law, shadow from all sides alike, no more light out than in, the glow of others."""

import numpy as np
import pytest

from gen_art.preset.light import Light
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.emissive_lighting import EmittedLight, cluster_lights, scatter_emitted_light
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.painter import Painter
from gen_art.renderer.smoke_density import DIRECTIONS, STEP, WEIGHTS, Smoke
from gen_art.renderer.smoke_lighting import (
    LitParticles,
    octaves,
    phase_function,
    scattered_light,
    scattered_light_of_system,
)
from tests.render.particles import scene, state

DARK = {"ambient_intensity": 0.0}


def slab(n=60_000, depth=3.0):
    """A uniform cube of side 2 with this optical depth along any of its axes."""
    rng = np.random.default_rng(1)
    return rng.uniform(-1, 1, (n, 3)).astype(np.float32), np.full(n, depth * 4.0 / n, np.float32)


def ball(n=40_000, depth=12.0):
    """A uniform ball of radius 1 with this optical depth through its middle."""
    rng = np.random.default_rng(3)
    x = rng.normal(0, 1, (n, 3))
    x *= rng.uniform(0, 1, (n, 1)) ** (1 / 3) / np.linalg.norm(x, axis=1, keepdims=True)
    return x.astype(np.float32), np.full(n, depth / 2 * 4 / 3 * np.pi / n, np.float32)


def turned(axis, degrees):
    k = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    a = np.radians(degrees)
    return np.eye(3) + np.sin(a) * cross + (1 - np.cos(a)) * cross @ cross


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, -1, 0), (1, 0, 0)])
def test_the_lamp_s_light_falls_off_exponentially_through_a_uniform_slab(direction):
    x, section = slab()
    lamp = Light(direction=direction, intensity=2.0, scatter=0.0, resolution=32, **DARK)
    got = scattered_light_of_system(lamp, x, section, (0, 0, 9))[:, 1]
    along = x @ np.array(direction, np.float32)
    inside = np.delete(np.abs(x), int(np.flatnonzero(direction)[0]), axis=1).max(axis=1) < 0.8
    for place in (-0.6, 0.0, 0.33, 0.8):
        here = inside & (np.abs(along - place) < 0.05)
        assert got[here].mean() == pytest.approx(2.0 * np.exp(-1.5 * (place + 1.0)), rel=0.04), place
    assert got.max() <= 2.0


def test_depth_counts_the_opacity_it_is_told():
    x, section = slab()
    thin, thick = (
        np.log(scattered_light_of_system(Light(depth=d, scatter=0, intensity=1, **DARK), x, section, (0, 0, 9))).mean()
        for d in (0.5, 1.5)
    )
    assert thick == pytest.approx(3 * thin, rel=1e-3)


@pytest.mark.parametrize("g", [-0.7, 0.0, 0.4, 0.9])
def test_the_phase_function_integrates_to_1_over_the_sphere(g):
    cosine, weight = np.polynomial.legendre.leggauss(200)
    p = phase_function(cosine, g)
    assert 2 * np.pi * (weight * p).sum() == pytest.approx(1.0, rel=1e-6)
    assert 2 * np.pi * (weight * p * cosine).sum() == pytest.approx(g, abs=1e-6), "and its mean cosine is g"


def test_the_phase_function_is_what_a_camera_sees():
    x, section = np.zeros((1, 3), np.float32), np.zeros(1, np.float32)
    lamp = Light(direction=(0, 0, 2), phase=0.6, scatter=0.0, intensity=1.0, **DARK)
    for eye, cosine in (((0, 0, 5), 1.0), ((0, 0, -5), -1.0), ((4, 0, 0), 0.0), ((3, 0, 4), 0.8)):
        assert scattered_light_of_system(lamp, x, section, eye)[0, 0] == pytest.approx(
            4 * np.pi * phase_function(cosine, 0.6), rel=1e-5
        )
    assert scattered_light_of_system(lamp, x, section, (0, 0, -1), parallel=True)[0, 0] == pytest.approx(
        4 * np.pi * phase_function(1.0, 0.6), rel=1e-5
    )


def test_light_that_was_scattered_before_has_forgotten_its_direction_by_halves():
    lamp = Light(direction=(0, 0, 1), phase=0.6, scatter=0.5, intensity=1.0, **DARK)
    x, section = np.zeros((1, 3), np.float32), np.zeros(1, np.float32)
    for eye, cosine in (((0, 0, 5), 1.0), ((0, 0, -5), -1.0)):
        expected = sum(w * 4 * np.pi * phase_function(cosine, 0.6 / 2**i) for i, w in enumerate(octaves(0.5)))
        assert scattered_light_of_system(lamp, x, section, eye)[0, 0] == pytest.approx(expected, rel=1e-5)


def test_no_smoke_no_shadow():
    lamp = Light(intensity=1.0, ambient_intensity=0.5, scatter=0.7)
    got = scattered_light_of_system(lamp, np.zeros((3, 3), np.float32), np.zeros(3, np.float32), (0, 0, 9))
    assert got == pytest.approx(np.full((3, 3), 1.5))


@pytest.mark.parametrize("scatter", [0.0, 0.5, 1.0])
def test_a_slab_gives_off_no_more_light_than_falls_on_it(scatter):
    """What leaves a slab (mean depth d, isotropic scatterers of albedo 1, a lamp of irradiance 1 along its normal) is the
    light its particles scatter times the chance to get out, (E2(t) + E2(d - t)) / 2, and the lamp's own exp(-d).
    """
    s, weight = np.polynomial.legendre.leggauss(40)
    mu = 0.5 + 0.5 * s
    for depth in (0.3, 3.0, 20.0):
        x, section = slab(40_000, depth)
        lamp = Light(direction=(0, 0, 1), scatter=scatter, intensity=1.0, resolution=48, **DARK)
        middle = (np.abs(x[:, :2]) < 0.8).all(axis=1)
        light = scattered_light_of_system(lamp, x, section, (0, 0, 9))[middle, 0]
        t = (x[middle, 2] + 1.0) * depth / 2
        out = sum(0.5 * w * (np.exp(-t / m) + np.exp((t - depth) / m)) for m, w in zip(mu, weight)) / 2
        scattered = (section[middle] * light * out).sum() / 2.56
        assert light.max() <= 1.0
        assert scattered + np.exp(-depth) <= 1.0
        if scatter == 0.0:
            assert (section[middle] * light).sum() / 2.56 == pytest.approx(1.0 - np.exp(-depth), rel=0.1)


@pytest.mark.parametrize(("depth", "least"), [(8.0, 0.95), (64.0, 0.65), (200.0, 0.19)])
def test_the_skin_of_dense_smoke_takes_in_light(depth, least):
    """All that falls on a thick slab should be scattered once. Cells of 1/4, 2 and 6 optical depths, blurred over their
    neighbours, take in 98%, 68% and 22% of it; counting half of a node's own layer would leave 62% and 13%.
    """
    x, section = slab(60_000, depth)
    lamp = Light(direction=(0, 0, 1), scatter=0.0, intensity=1.0, resolution=32, **DARK)
    middle = (np.abs(x[:, :2]) < 0.8).all(axis=1)
    light = scattered_light_of_system(lamp, x, section, (0, 0, 9))[middle, 0]
    assert least < (section[middle] * light).sum() / 2.56 <= 1.02


def test_scattered_light_goes_deeper():
    x, section = slab(20_000, 10.0)
    deep = x[:, 2] > 0.8
    light = [
        scattered_light_of_system(Light(direction=(0, 0, 1), scatter=s, **DARK), x, section, (0, 0, 9))[deep].mean()
        for s in (0.0, 0.3, 0.6)
    ]
    assert light[2] > 2 * light[1] > 20 * light[0]
    assert octaves(0.5).sum() == pytest.approx(1.0)
    assert octaves(0.5)[1] == pytest.approx(0.5 * octaves(0.5)[0])


def test_fourteen_directions_are_a_rule_of_degree_5():
    way = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
    for powers, mean in (((2, 0, 0), 1 / 3), ((4, 0, 0), 1 / 5), ((2, 2, 0), 1 / 15), ((3, 1, 1), 0), ((1, 0, 0), 0)):
        assert (WEIGHTS * np.prod(way ** np.array(powers), axis=1)).sum() == pytest.approx(mean, abs=1e-12)


def test_the_depth_along_each_direction_is_the_smoke_s():
    x, section = ball(80_000)
    smoke = Smoke.of(x, section, np.zeros(len(x), np.float32), np.eye(3), 40)
    middle = tuple(np.round(-smoke.corner).astype(int))
    for way in DIRECTIONS:
        before, behind = smoke.depth(way)[middle], smoke.depth(-way)[middle]
        assert before == pytest.approx(6.0, rel=0.08), way
        assert behind == pytest.approx(6.0, rel=0.08), way
        step = tuple(np.array(middle) + 8 * way)
        assert smoke.depth(way)[step] > before > smoke.depth(way)[tuple(np.array(middle) - 8 * way)]


def test_the_sky_is_darker_in_the_middle_of_a_ball_than_at_its_skin_from_every_side_alike():
    x, section = ball()
    sky = scattered_light_of_system(Light(intensity=0.0, ambient_intensity=1.0, scatter=0.0), x, section, (0, 0, 9))[
        :, 1
    ]
    r = np.linalg.norm(x, axis=1)
    core, skin = r < 0.3, r > 0.93
    assert sky[core].mean() < 0.1 * sky[skin].mean()
    assert 0.25 < sky[skin].mean() < 0.5, "half the sky is behind the ball"
    sides = np.array([sky[skin & (x @ (way / np.linalg.norm(way)) > 0.8)].mean() for way in DIRECTIONS])
    assert np.ptp(sides) < 0.08 * sides.mean()


def test_the_sky_and_the_ground_have_their_own_colours():
    x, section = ball()
    lamp = Light(direction=(1, -1, 0), intensity=0, ambient=(0, 0, 1), ground=(1, 0, 0), ambient_intensity=1)
    got = scattered_light_of_system(lamp, x, section, (0, 0, 9))
    top, bottom = got[x[:, 1] > 0.9].mean(axis=0), got[x[:, 1] < -0.9].mean(axis=0)
    assert top[2] > 2.0 * top[0]
    assert bottom[0] > 2.0 * bottom[2]
    assert top[2] == pytest.approx(bottom[0], rel=0.05)


@pytest.mark.parametrize(("axis", "degrees"), [((0, 1, 0), 37), ((1, 1, 0), 60), ((1, -2, 3), 45)])
def test_light_turns_with_the_scene(axis, degrees):
    x, section = ball()
    x *= (0.5, 1.0, 0.7)
    turn = turned(axis, degrees)
    eye, way = np.array((2.0, 1.0, 9.0)), np.array((-1.0, -0.6, -0.5))
    lights = [
        scattered_light_of_system(
            Light(direction=tuple(r @ way), phase=0.3, ambient_intensity=1.0, intensity=1.0),
            x @ r.T.astype(np.float32), section, r @ eye, radii=np.full(len(x), 0.08, np.float32),
        )[:, 1]
        for r in (np.eye(3), turn)
    ]  # fmt: skip
    assert np.abs(lights[1] - lights[0]).mean() < 0.05 * lights[0].mean()


def test_light_does_not_crawl_with_the_grid():
    x, section = ball()
    radii = np.full(len(x), 0.08, np.float32)
    lamp = Light(resolution=48, ambient_intensity=0.5, intensity=1.0)
    cell = Smoke.of(x, section, radii, np.eye(3), 48).cell
    base = scattered_light_of_system(lamp, x, section, (0, 0, 9), True, radii)[:, 1]
    for shift in (cell / 3, 2.4 * cell):
        moved = scattered_light_of_system(lamp, x + np.float32(shift), section, (0, 0, 9), True, radii)[:, 1]
        assert np.abs(moved - base).mean() < 0.02 * base.mean()
    finer = scattered_light_of_system(
        lamp.model_copy(update={"resolution": 68}), x, section, (0, 0, 9), True, radii
    )[:, 1]  # fmt: skip
    assert np.abs(finer - base).mean() < 0.03 * base.mean(), "a cloud that outgrows its cells does not flicker"


def test_a_cloud_that_grows_or_drifts_keeps_its_nodes():
    x, section = ball(2000)
    none = np.zeros(len(x), np.float32)
    first, grown, moved = (
        Smoke.of(y, section, none, np.eye(3), 40) for y in (x, x * np.float32(1.04), x + np.float32(0.013))
    )
    assert first.cell == grown.cell == moved.cell
    assert np.log2(first.cell) * 2 == pytest.approx(round(np.log2(first.cell) * 2), abs=1e-9)
    for smoke in (first, grown, moved):
        assert np.all(smoke.corner % STEP == 0), "so that the nodes of all levels stay where they are"


def test_large_sprites_cast_wide_shadows():
    centre = np.zeros((1, 3), np.float32)
    rim = np.array([[-3, -3, -3], [3, 3, 3]], np.float32)
    for radius in (0.3, 0.6, 1.0):
        x, section = np.concatenate([centre, rim]), np.array([4.0, 1e-9, 1e-9], np.float32)
        smoke = Smoke.of(x, section, np.array([radius] * 3, np.float32), np.eye(3), 48)
        place = [(smoke.corner[c] + np.arange(smoke.extinction.shape[c])) * smoke.cell for c in range(3)]
        for c in range(3):
            line = smoke.extinction.sum(axis=tuple(k for k in range(3) if k != c))
            spread = np.sqrt((line * place[c] ** 2).sum() / line.sum() - ((line * place[c]).sum() / line.sum()) ** 2)
            assert spread == pytest.approx(radius / 2.2, rel=0.15), radius
        assert smoke.extinction.sum() == pytest.approx(4.0, rel=1e-4), "and nothing is lost on the way"


def test_smoke_of_one_system_shadows_another():
    x, section = slab()
    behind = np.array([[a, b, 2.0] for a in (-0.5, 0, 0.5) for b in (-0.5, 0, 0.5)], np.float32)
    lamps = [Light(direction=(0, 0, 1), scatter=0, intensity=1.0, **DARK) for _ in range(2)]
    one = LitParticles(Lighting.of(lamps[0]), x, section, np.full(len(x), 0.15, np.float32))
    two = LitParticles(Lighting.of(lamps[1]), behind, np.full(9, 1e-6, np.float32), np.zeros(9, np.float32))
    assert scattered_light([one, two], (0, 0, 9))[1][:, 0].mean() == pytest.approx(np.exp(-3.0), rel=0.1)
    assert scattered_light([two], (0, 0, 9))[0] == pytest.approx(np.ones((9, 3)), abs=2e-3)


def test_the_glow_of_others_falls_with_the_square_of_the_distance_and_through_the_smoke():
    rng = np.random.default_rng(5)
    lights = rng.normal(0, 0.05, (3000, 3))
    power = np.tile([[2e-3, 1e-3, 0.0]], (3000, 1))
    x = np.array([[1.0, 0, 0], [2, 0, 0], [0, 4, 0], [0, 0, -4]], np.float32)
    lamp = Light(intensity=0.0, scatter=0.0, resolution=64, **DARK)
    thin = LitParticles(Lighting.of(lamp), x, np.full(4, 1e-7, np.float32), np.zeros(4, np.float32))
    got = scattered_light([thin], (0, 0, 9), False, [EmittedLight(lights, power)])[0]
    assert got[:, 0] == pytest.approx(6.0 / (4 * np.pi) / np.array([1, 4, 16, 16]), rel=0.12)
    assert got[:, 1] == pytest.approx(got[:, 0] / 2, rel=1e-5)
    assert np.all(got[:, 2] == 0.0)
    screen = rng.uniform(-1, 1, (20_000, 3)).astype(np.float32) * np.float32((0.1, 2, 2)) + np.float32((0.5, 0, 0))
    wall = LitParticles(Lighting.of(lamp), np.concatenate([x, screen]), np.concatenate([np.full(4, 1e-7), np.full(20_000, 16 / 20_000)]).astype(
        np.float32), np.zeros(20_004, np.float32))  # fmt: skip
    through = scattered_light([wall], (0, 0, 9), False, [EmittedLight(lights, power)])[0]
    assert through[1, 0] == pytest.approx(got[1, 0] * np.exp(-1.0), rel=0.2)
    assert through[3, 0] > 0.7 * got[3, 0]


@pytest.mark.parametrize("parallel", [False, True])
def test_the_glow_in_thin_smoke_is_the_sum_over_cells_of_light(parallel):
    rng = np.random.default_rng(7)
    lights, power = rng.uniform(-1, 1, (300, 3)), rng.uniform(0, 1, (300, 3))
    x = rng.uniform(-2, 2, (60, 3)).astype(np.float32)
    smoke = Smoke.of(x, np.full(60, 1e-9, np.float32), np.zeros(60, np.float32), np.eye(3), 24)
    lamp = Light(phase=0.5, glow_intensity=3.0, glow_softness=0.4)
    eye = np.array((0.6, 0.0, -0.8)) if parallel else np.array((3.0, 1.0, 9.0))
    got = scatter_emitted_light(smoke, smoke, EmittedLight(lights, power), lamp, octaves(0.5), eye, parallel)
    nodes = (
        smoke.corner + np.stack(np.meshgrid(*map(np.arange, smoke.extinction.shape), indexing="ij"), axis=-1)
    ) * smoke.cell
    seen = -eye if parallel else (eye - nodes) / np.linalg.norm(eye - nodes, axis=-1, keepdims=True)
    expected = np.zeros_like(got)
    for cell in cluster_lights(lights, power):
        way = nodes - cell[:3]
        square = (way**2).sum(axis=-1)
        cosine = (way * seen).sum(axis=-1) / np.maximum(np.sqrt(square), 1e-9)
        p = sum(w * phase_function(cosine, 0.5 / 2**i) for i, w in enumerate(octaves(0.5)))
        near = square + cell[6] + 0.4**2 + smoke.cell**2 / 4
        expected += 3.0 * (p / near)[..., None] * cell[3:6]
    some = smoke.extinction > 0
    assert some.sum() > 200
    assert got[some] == pytest.approx(expected[some], rel=2e-3)


def test_cells_of_light_keep_their_power_and_their_middle():
    rng = np.random.default_rng(6)
    x, power = rng.normal(0, 1, (5000, 3)), rng.uniform(0, 1, (5000, 3))
    cells = cluster_lights(x, power)
    assert 40 < len(cells) < 512
    assert cells[:, 3:6].sum(axis=0) == pytest.approx(power.sum(axis=0))
    weight = power.sum(axis=1)
    assert (cells[:, :3] * cells[:, 3:6].sum(axis=1)[:, None]).sum(axis=0) == pytest.approx(
        (x * weight[:, None]).sum(axis=0)
    )
    assert len(cluster_lights(x, 0 * power)) == 0


def test_a_fire_shines_on_the_smoke_above_it_at_any_size_of_the_picture():
    smoke = Look(draw="disc", blend="alpha", radius=0.1, opacity=0.01,
                 light={"intensity": 0.0, "ambient_intensity": 0.0, "glow": "flame"})  # fmt: skip
    flame = Look(draw="disc", radius=0.1, emission={"color": [1.0, 0.5, 0.0], "intensity": 2.0})
    x = np.array([[0, 0.5, 0], [0, 1.0, 0]])
    seen = []
    for size in ((64, 64), (256, 256)):
        things = scene(0.0, plume=state(x), flame=state([[0, -0.5, 0]]))
        painter = Painter(size, Camera(position=(0, 0, 10), height=4.0), {"plume": smoke, "flame": flame})
        seen.append(painter.paint(things, 0.0)[: size[1] // 2 - 8 * size[1] // 64].mean(axis=(0, 1)) * 2)
    assert seen[0][:3] == pytest.approx(seen[1][:3], rel=0.05)
    assert seen[0][0] > 0
    assert seen[0][1] == pytest.approx(0.2140 * seen[0][0], rel=1e-3)
    dark = Painter((64, 64), Camera(position=(0, 0, 10), height=4.0), {"plume": smoke, "flame": None})
    assert dark.paint(things, 0.0)[..., :3].max() == 0.0


def test_a_lit_ball_has_a_bright_side_two_stops_above_its_shadow():
    x, _ = ball(20_000)
    look = Look(draw="disc", blend="alpha", radius=0.07, opacity=0.2, light={"direction": [1, 0, 0], "intensity": 2.0})
    picture = Painter((200, 200), Camera(position=(0, 0, 10), height=2.6), {"a": look}).paint(
        scene(0.0, a=state(x)), 0.0
    )
    grey = picture[..., 1] / np.maximum(picture[..., 3], 1e-3)
    assert grey[80:120, 40:55].mean() > 4 * grey[80:120, 145:160].mean()
    assert picture[100, 100, 3] > 0.98
