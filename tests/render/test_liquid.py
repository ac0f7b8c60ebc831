"""`draw: surface`: where the surface of a liquid lies, the light it reflects and lets through, and what it hides."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.output.job import still
from gen_art.preset.light import Light
from gen_art.preset.look import Look
from gen_art.preset.surface import ground_of
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.surfaces.reflection import fresnel
from gen_art.renderer.surfaces.scene import Scene
from tests.render.particles import scene, state

EVEN = Light(intensity=0, ambient_intensity=1)
BLACK = {"clear": False}
RADIUS = 0.03
SPACING = 1.2 * RADIUS
SMOOTHED = 4.0 * RADIUS  # liquid.smoothing is 4 radii


def lattice(low, high, spacing=SPACING):
    """Points of a cubic lattice in a box."""
    axes = [np.arange(a + 0.5 * spacing, b, spacing) for a, b in zip(low, high)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def above(height=2.0, **more):
    """An orthographic camera that looks straight down on the origin; its picture is `height` high."""
    return Camera(position=(0, 4, 0), target=(0, 0, 0), up=(0, 0, -1), height=height, **more)


def drawn(points, camera, size=(96, 64), *, look=None, radius=RADIUS, light=EVEN, ground=None, colliders=(), painter=False,
          shadows=True, **more):  # fmt: skip
    """A picture of points as a liquid, and the painter that drew it if asked for."""
    keys = {"draw": "surface", **(look or {})}
    where = Scene(light, ground_of(ground), shadows, tuple(colliders))
    artist = Painter(size, camera, {"w": Look.model_validate(keys)}, scene=where, **more)
    picture = artist.paint(scene(w=state(points, radius=radius)), 0.0).copy()
    return (picture, artist) if painter else picture


def depth_of(artist, parallel):
    """The smoothed depths that a painter drew last, NaN where there is no liquid."""
    plane = artist._liquids._smooth.astype(float)
    return np.where(plane > 1e29, np.nan, plane if parallel else 1.0 / plane)


def wave_left(wavelength):
    """What one pass of the filter at least takes a wave down to: its Fourier transform is 105 j3(x) / x^3, below 105 / x^4."""
    return 105.0 / (2 * math.pi * SMOOTHED / wavelength) ** 4


def test_a_flat_layer_is_flat():
    """Spheres in a lattice leave dips between them, which the passes smooth away; see `wave_left`.

    Mutants: no smoothing (dips of half a radius); a filter of a quarter of the radius.
    """
    dip = RADIUS - math.sqrt(RADIUS**2 - 0.5 * SPACING**2)
    points = lattice((-2, -0.2, -1.5), (2, 0, 1.5))
    _, artist = drawn(points, above(1.0), (192, 128), look={"liquid": BLACK}, painter=True)
    depth = depth_of(artist, True)[32:-32, 32:-32]  # the passes read 2.4 radii of the filter: 37 pixels
    top = 4.0 - (points[:, 1].max() + RADIUS)
    # twice along each axis, and once with 0.4 of the radius, which is left out here
    assert np.ptp(depth) < 0.005 * dip
    assert top < depth.mean() < top + dip
    _, artist = drawn(points, above(1.0), (192, 128), look={"liquid": {**BLACK, "smoothing": 0}}, painter=True)
    assert np.ptp(depth_of(artist, True)) == pytest.approx(dip, rel=0.05)  # the spheres themselves


@pytest.mark.parametrize("tilt", [0, 30, 60])
def test_the_normal_of_a_flat_layer_is_its_own(tilt):
    """A smooth black liquid reflects an even sky as Fresnel's formulas say for the angle between normal and view.

    To a degree: the share at the angle one degree less, and one more, are the bounds. Mutants: the sign of a slope, 1/depth for
    depth, a normal that looks along the line of sight.
    """
    angle = math.radians(tilt)
    camera = Camera(position=(0, 3 * math.cos(angle), 3 * math.sin(angle)), target=(0, 0, 0), up=(0, 1, -0.01), fov=8)
    look = {"albedo": "black", "liquid": BLACK, "finish": {"roughness": 0, "ior": 1.33}}
    points = lattice((-1.2, -0.15, -1.2), (1.2, 0, 1.2))
    got = drawn(points, camera, (96, 64), look=look, shadows=False)[16:48, 24:72]
    assert (got[..., 3] == 1.0).all()
    column = np.arange(24, 72) + 0.5 - 48
    row = 32 - np.arange(16, 48) - 0.5
    scale = 32 / math.tan(math.radians(4))
    ray = np.stack([*np.broadcast_arrays(column[None] / scale, row[:, None] / scale), np.ones((32, 48))], axis=-1)
    normal = np.array([0, math.sin(angle), -math.cos(angle)])  # along the camera's right, up and forward
    view = np.degrees(np.arccos(np.clip(-(ray @ normal) / np.linalg.norm(ray, axis=-1), -1, 1)))
    low, high = (fresnel(np.cos(np.radians(np.maximum(view + d, 0))), 1.33) for d in (-1, 1))
    wide = np.maximum(high - low, 1e-4)
    assert (got[..., 0] > low - 0.01 * wide - 1e-5).all() and (got[..., 0] < high + 0.01 * wide + 1e-5).all()


@pytest.mark.parametrize("tilt", [10, 45, 70])
def test_the_slope_of_a_sheet_has_its_direction(tilt):
    """An orthographic camera sees a sheet that leans to the right: depth rises along the picture by tan(tilt), to 1 degree."""
    slope = math.tan(math.radians(tilt))
    flat = lattice((-2, -1.5, -0.3), (2, 1.5, 0))
    cosine, sine = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
    points = np.stack(
        [flat[:, 0] * cosine + flat[:, 2] * sine, flat[:, 1], flat[:, 2] * cosine - flat[:, 0] * sine], axis=1
    )
    camera = Camera(position=(0, 0, 4), target=(0, 0, 0), height=0.6)
    _, artist = drawn(points, camera, look={"liquid": BLACK}, painter=True)
    depth = depth_of(artist, True)[16:48, 24:72]
    x = np.broadcast_to(np.arange(48) * 0.6 / 64, depth.shape)
    found = np.polyfit(x.ravel(), depth.ravel(), 1)[0]
    assert math.degrees(math.atan(found)) == pytest.approx(tilt, abs=1.0)
    light = {"direction": (-sine, 0, -cosine), "intensity": 0.25, "ambient_intensity": 0}  # along the sheet's normal
    matte = {"liquid": BLACK, "finish": {"ior": 1}, "albedo": "white"}
    got = drawn(points, camera, look=matte, light=Light(**light))[16:48, 24:72, 0]
    assert got.mean() == pytest.approx(1.0, abs=1 - math.cos(math.radians(2)) + 0.01)
    assert slope > 0


def ball(radius=0.8, inner=0.6):
    """Particles evenly spread over shells of a ball, the outermost such that their spheres reach the radius."""
    shells, r = [], radius - RADIUS
    while r > inner:
        n = int(4 * math.pi * r * r / SPACING**2)
        k = np.arange(n) + 0.5
        y, turn = 1 - 2 * k / n, k * math.pi * (3 - math.sqrt(5))
        flat = np.sqrt(1 - y * y)
        shells.append(r * np.stack([flat * np.cos(turn), y, flat * np.sin(turn)], axis=1))
        r -= SPACING
    return np.concatenate(shells)


@pytest.mark.parametrize("direction", [(-1.0, -1.0, -2.0), (0.8, -0.5, -1.0)])
def test_a_ball_of_particles_has_the_light_of_a_sphere(direction):
    """A matt one has n.l of the lamp at each place, and a smooth one its highlight half-way between lamp and camera.

    Smoothing over the variance s^2 = 2.16 R^2 / 9 (two passes with R, one with 0.4 R) changes the slope by 2 s^2 / B^2 of it near
    the middle, and four times as much where n.v = 0.5; 2% are added for the shells' unevenness.
    Mutants: normals mirrored left to right or upside down; a slope by half the pixel.
    """
    to_lamp = -np.array(direction) / np.linalg.norm(direction)
    camera, size, big = Camera(position=(0, 0, 4), target=(0, 0, 0), height=2.0), (160, 160), 0.8
    y, x = np.meshgrid((79.5 - np.arange(160)) / 80, (np.arange(160) - 79.5) / 80, indexing="ij")
    facing = np.sqrt(np.maximum(big**2 - x * x - y * y, 0)) / big
    normal = np.stack([x / big, y / big, facing], axis=-1)
    light = Light(direction=direction, intensity=0.25, ambient_intensity=0)
    matt = {"liquid": BLACK, "finish": {"ior": 1}, "albedo": "white"}
    got = drawn(ball(), camera, size, look=matt, light=light)[..., 0]
    middle = facing > 0.5
    wanted = np.maximum(normal @ to_lamp, 0.0)
    bias = 8 * (2.16 * SMOOTHED**2 / 9) / big**2
    # shadows begin a few particles' radii behind the edge of day and night
    lit = middle & (normal @ to_lamp > 0.35)
    assert np.abs(got - wanted)[lit].max() < bias + 0.02 * math.sqrt(2)
    glossy = {"liquid": BLACK, "finish": {"roughness": 0.3, "ior": 1.5}, "albedo": "black"}
    got = drawn(ball(), camera, size, look=glossy, light=light)[..., 0]
    bright = np.where(got > 0.5 * got.max(), got, 0.0)
    centre = np.array([(x * bright).sum(), (y * bright).sum()]) / bright.sum()
    half = to_lamp + [0, 0, 1]
    half /= np.linalg.norm(half)
    # a degree of the normal, and the skew of the lobe: half its width times its distance from the middle
    assert np.abs(centre - big * half[:2]).max() < big * (math.radians(1.0) + bias)


@pytest.mark.parametrize("depth,distance", [(0.5, 1.0), (1.0, 0.5), (1.0, 2.0)])
def test_a_layer_absorbs_as_beer_and_lambert_say(depth, distance):
    """White ground under a layer of thickness T: exp(-T / distance) in a colour that is 1/e after `distance`, to 2%.

    Mutants: thickness without the packing; twice the chord; a colour that is not made linear.
    """
    srgb = 1.055 * math.exp(-1 / 2.4) - 0.055  # sRGB of 1/e
    layers = round(depth / SPACING)
    points = lattice((-2.5, 0, -2), (2.5, (layers + 0.01) * SPACING, 2))
    thick = layers * SPACING
    look = {"liquid": {"color": [srgb, 1.0, 1.0], "distance": distance}, "finish": {"ior": 1}}
    ground = {"height": -2.0, "albedo": "white", "ior": 1}
    got = drawn(points, above(1.0), look=look, ground=ground)[16:48, 24:72, :3].mean(axis=(0, 1))
    assert got[0] == pytest.approx(math.exp(-thick / distance), rel=0.02)
    assert got[1:] == pytest.approx([1, 1], abs=0.002)


def test_scattering_hides_what_is_behind_by_its_mean_length():
    """Black ground under a white liquid that scatters: 1 - exp(-T / s) of the even light comes back, where nothing hides the sky."""
    layers = 12
    thick = layers * SPACING
    points = lattice((-2.5, 0, -2), (2.5, (layers + 0.01) * SPACING, 2))
    look = {"liquid": {"color": "white", "scattering": 0.7}, "finish": {"ior": 1}, "albedo": "white"}
    ground = {"height": -2.0, "albedo": "black", "ior": 1}
    got = drawn(points, above(1.0), look=look, ground=ground, shadows=False)[16:48, 24:72, :3].mean()
    assert got == pytest.approx(1 - math.exp(-thick / 0.7), rel=0.02)


@pytest.mark.parametrize("angle", [0, 45, 70])
def test_clear_water_over_black_reflects_fresnels_share(angle):
    """An even sky of light 1 in water over black ground; what lies below takes nothing from what is reflected."""
    a = math.radians(angle)
    camera = Camera(position=(0, 3 * math.cos(a), 3 * math.sin(a)), target=(0, 0, 0), up=(0, 1, -0.01), fov=8)
    points = lattice((-1.2, -0.4, -1.2), (1.2, 0, 1.2))
    ground = {"height": -1, "albedo": "black", "ior": 1}
    got = drawn(points, camera, look={}, ground=ground)[31:33, 40:56, 0]  # a quarter of a degree
    low, high = (fresnel(math.cos(max(a + math.radians(d), 0)), 1.33) for d in (-1, 1))
    assert low - 1e-4 < got.min() and got.max() < high + 1e-4


def test_clear_water_in_an_even_light_over_white_is_white():
    """What is reflected and what passes add up to the light that arrives: a furnace. Mutant: transmission without 1 - F."""
    ground = {"height": -1, "albedo": "white", "ior": 1}
    points = lattice((-1.2, -0.4, -1.2), (1.2, 0, 1.2))
    camera = Camera(position=(0, 2, 2), target=(0, 0, 0), fov=20)
    got = drawn(points, camera, look={"liquid": "white"}, ground=ground)[..., :3]
    assert np.abs(got - 1).max() < 0.005


def test_water_lifts_the_ground_below_it():
    """A coin at the bottom of water is seen where Snell's law puts it, and not where it is. Mutant: the straight ray."""
    layers = 12
    depth, a = layers * SPACING, math.radians(45)
    camera = Camera(position=(0, 4 * math.cos(a), 4 * math.sin(a)), target=(0, 0, 0), height=1.0)
    points = lattice((-1.5, -(layers - 0.01) * SPACING, -1.5), (1.5, 0, 1.5)) + [0, 0, 0]
    floor = -depth
    stripe = ga.colliders.Block(
        min=(-2, floor - 0.1, -0.02), max=(2, floor + 0.004, 0.02), look={"albedo": "white", "ior": 1}
    )
    look = {"liquid": "white"}
    got = drawn(
        points, camera, (64, 128), look=look, ground={"height": floor, "albedo": "black", "ior": 1}, colliders=[stripe]
    )
    column = got[:, 32, 0] - np.median(got[:, 32, 0])
    rows = np.arange(128) + 0.5
    seen = (rows * column).sum() / column.sum() if column.max() > 0.2 else math.nan
    surface = points[:, 1].max() + 0.4 * RADIUS  # between the spheres' tops and their dips
    inside = math.asin(math.sin(a) / 1.33)
    # the ray that meets the stripe enters the water this far before it, and lies this high in the picture
    enters = (surface - floor) * math.tan(inside)
    high = -enters * math.cos(a) + surface * math.sin(a)
    straight = floor * math.sin(a)
    assert seen == pytest.approx(64 - 128 * high, abs=0.15 * 128 * abs(high - straight))


def test_sheets_at_different_depths_do_not_mix():
    """A sheet before another: each keeps its depth up to the edge. Mutant: no limit of the depths that take part."""
    low = lattice((-1.5, -0.2, -1.2), (1.5, 0, 1.2))
    high = lattice((-1.5, 0.5, -1.2), (0, 0.7, 1.2))
    _, artist = drawn(np.concatenate([low, high]), above(1.0), (192, 128), look={"liquid": BLACK}, painter=True)
    depth = depth_of(artist, True)
    tops = [4 - high[:, 1].max() - RADIUS, 4 - low[:, 1].max() - RADIUS]
    # of the spheres at the edge the sides are seen, too
    near, far = (depth > top - 0.01 * RADIUS for top in tops)
    assert near.all()
    between = (depth > tops[0] + RADIUS) & ~far
    assert not between.any()
    assert 0.4 < (depth < tops[0] + RADIUS).mean() < 0.6


def test_the_picture_is_the_same_at_any_size():
    """Smoothing is in lengths of the world: the surface of the small picture is that of the large one, where both are smooth."""
    rng = np.random.default_rng(3)
    points = lattice((-1, -0.3, -1), (1, 0, 1)) + rng.normal(0, 0.1 * RADIUS, (1, 3))
    points[:, 1] += 0.1 * np.sin(5 * points[:, 0])
    large, small = (
        depth_of(drawn(points, above(1.0), size, look={"liquid": BLACK}, painter=True)[1], True)
        for size in ((384, 256), (96, 64))
    )
    averaged = large.reshape(64, 4, 96, 4).mean(axis=(1, 3))
    assert np.abs(averaged - small)[4:-4, 4:-4].max() < 0.1 * RADIUS


def test_colours_of_particles_run_into_each_other():
    """Emission by x: each place glows as its particles do, between their colours."""
    points = lattice((-1, -0.2, -1), (1, 0, 1))
    look = {"liquid": BLACK, "albedo": "black", "finish": {"ior": 1}}
    look["emission"] = {"intensity": {"by": "x", "curve": [[-1, 0], [1, 2]]}}
    got = drawn(points, above(1.0), look=look, light=Light(intensity=0, ambient_intensity=0))[16:48, :, 0]
    x = (np.arange(96) + 0.5 - 48) / 64
    assert np.abs(got - (1 + x)).max() < 2 * SPACING


def test_an_opaque_liquid_shadows_the_ground_and_clear_water_hardly():
    camera = Camera(position=(0, 6, 0), target=(0, 0, 0), up=(0, 0, -1), height=4.0)
    tilted = Light(direction=(1, -1, 0), intensity=0.25, ambient_intensity=0)
    points = ball(0.3, 0.0) + [-1, 1, 0]
    ground = {"albedo": "white", "ior": 1}
    lit = math.cos(math.radians(45))
    red = ((0xE1 / 255 + 0.055) / 1.055) ** 2.4  # of pure water after 1 m; 0.6 m are crossed, and 2% reflected
    passed = red**0.6 * (1 - float(fresnel(1.0, 1.33)))
    for look, low, high in (({"liquid": BLACK}, 0.0, 0.02), ({}, 0.93 * passed, 1.07 * passed)):
        got = drawn(points, camera, (96, 96), look=look, ground=ground, light=tilted)[48, :, 0] / lit
        assert low <= got[48] <= high  # the ball's middle throws its shadow on the origin
        reach = 0.3 * math.sqrt(2) * 24
        assert got[int(48 + reach + 3)] == pytest.approx(1, abs=1e-3)
        assert got[int(48 + reach - 3)] < 0.995


def test_solids_hide_the_liquid_and_the_liquid_hides_sprites():
    points = lattice((-1, -0.2, -1), (1, 0, 1))
    cover = ga.colliders.Block(min=(-3, 0.5, -3), max=(0, 0.6, 3), look={"albedo": "black", "ior": 1})
    look = {"liquid": BLACK, "albedo": "white", "finish": {"ior": 1}}
    got = drawn(points, above(1.0), look=look, colliders=[cover])[32, :, 0]
    assert got[:47].max() < 0.01 and got[50:].min() > 0.5
    looks = {"w": Look.model_validate({"draw": "surface", **look}), "dot": Look.model_validate({"draw": "disc"})}
    for height, seen in ((-0.5, False), (0.5, True)):
        artist = Painter((96, 64), above(1.0), looks, scene=Scene(Light(intensity=0, ambient_intensity=0)))
        dots = state([[0, height, 0]], radius=0.1)
        assert bool(artist.paint(scene(w=state(points, radius=RADIUS), dot=dots), 0.0)[..., :3].any()) is seen


def test_a_transparent_picture_keeps_the_share_that_passes():
    points = lattice((-1, -0.3, -1), (1, 0, 1))
    got = drawn(points, above(1.0), look={"liquid": "white"}, transparent=True)[32, 48]
    reflected = float(fresnel(1.0, 1.33))
    assert got == pytest.approx([reflected] * 4, abs=1e-3)
    alone = drawn(points[:0], above(1.0), look={})
    assert not alone.any()


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (33, 40)])
@pytest.mark.parametrize("points", [[[0, 0, 0]], [[0, 9, 0]], [], [[0, 4, 0.001]]])
@pytest.mark.parametrize("parallel", [True, False])
def test_few_particles_and_tiny_pictures(size, points, parallel):
    camera = above(1.0) if parallel else Camera(position=(0, 4, 0), target=(0, 0, 0), up=(0, 0, -1), fov=30)
    got = drawn(np.array(points, float).reshape(-1, 3), camera, size, ground="white", supersample=2)
    assert np.isfinite(got).all() and (got[..., 3] > 0.99).all()


def test_several_liquids_are_drawn_from_the_farthest_on():
    """Red mud below green mud, whatever their names: from above green is seen."""
    low, high = lattice((-1, -0.2, -1), (1, 0, 1)), lattice((-1, 0.5, -1), (1, 0.7, 1))
    for names in (("a", "b"), ("b", "a")):
        looks = {
            name: Look.model_validate({"draw": "surface", "liquid": BLACK, "albedo": colour, "finish": {"ior": 1}})
            for name, colour in zip(names, ("#ff0000", "#00ff00"))
        }
        artist = Painter((32, 32), above(1.0), looks, scene=Scene(EVEN, None, False))
        got = artist.paint(scene(**{names[0]: state(low, radius=RADIUS), names[1]: state(high, radius=RADIUS)}), 0.0)
        assert got[16, 16, 1] > 0.5 and got[16, 16, 0] < 0.01


PIECE = {
    "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/120"}, "sky": {"sun": 40}, "forces": {"gravity": [0, -9.81, 0]},
    "ground": {"checker": 0.3},
    "systems": {
        "water": {
            "particle": {"radius": 0.03}, "emitters": {"all": {"count": 4000, "shape": {"sphere": 0.4, "center": [0, 0.7, 0]}}},
            "look": {"draw": "surface", "albedo": {"by": "random", "gradient": ["white", "teal"]}, "liquid": {"scattering": 0.3}},
        },
        "steel": {
            "particle": {"radius": 0.03}, "emitters": {"all": {"count": 800, "shape": {"sphere": 0.2, "center": [0.8, 0.3, 0]}}},
            "look": {"draw": "surface", "liquid": {"clear": False}, "finish": {"metal": 1, "roughness": 0.2}},
        },
        "smoke": {
            "emitters": {"all": {"count": 300, "shape": {"box": [2, 1, 2]}}}, "particle": {"radius": 0.2},
            "look": {"draw": "disc", "blend": "alpha", "opacity": 0.2},
        },
    },
    "camera": {"position": [2, 1.5, 3], "target": [0, 0.4, 0]},
}  # fmt: skip


def test_a_frame_of_a_film_is_the_still(tmp_path):
    film = ga.render(ga.load_preset(PIECE), tmp_path / "f_####.png", size=(64, 48), frames=range(3))
    again = still(ga.load_preset(PIECE), tmp_path / "s.png", 2 / 30, size=(64, 48))
    assert film[2].read_bytes() == again[0].read_bytes()


@pytest.mark.parametrize(
    "look,words",
    [
        ({"draw": "surface", "blend": "alpha"}, "leave out `blend`"),
        ({"draw": "surface", "trail": 1}, "trail"),
        ({"draw": "disc", "liquid": "white"}, "give draw: surface"),
        ({"draw": "surface", "liquid": {"distance": 0}}, "must be more than 0"),
        ({"draw": "surface", "liquid": {"colour": "red"}}, "did you mean 'color'"),
        ({"draw": "surface", "finish": {"metal": 1}}, "clear: false"),
    ],
)  # fmt: skip
def test_wrong_keys_are_sentences(look, words):
    with pytest.raises(PresetError, match=words):
        ga.load_preset({**PIECE, "systems": {"water": {**PIECE["systems"]["water"], "look": look}}})
