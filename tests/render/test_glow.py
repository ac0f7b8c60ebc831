"""The light of emitting particles on surfaces: closed formulas, direct sums, shadows."""

import math

import numpy as np
import pytest

import gen_art as ga
import gen_art.renderer.painter as painting
from gen_art.errors import PresetError
from gen_art.interactions.rigid.shapes import parts_of
from gen_art.output.job import still
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.sprite import profile_integral
from gen_art.renderer.surfaces.light_tree import LightTree
from gen_art.renderer.surfaces.near_bins import COLUMNS, ROWS, NearBins, quarter_angle
from gen_art.renderer.surfaces.scene import Scene

DARK = {"intensity": 0, "ambient_intensity": 0.0}
MATTE = {"albedo": "white", "ior": 1}
ABOVE = {"position": [0, 6, 0], "target": [0, 0, 0], "up": [0, 0, -1], "height": 4}
DISC = (1.5 * profile_integral()) ** 2  # the area of a disc of radius 1


def flame(shape, count=1, radius=0.02, **emission):
    look = {"draw": "disc", "radius": radius, "emission": {"intensity": 2.0, **emission}}
    emitters = {"one": {"count": count, "shape": shape}}
    return {"flame": {"particle": {"lifetime": 100}, "emitters": emitters, "look": look}}


def preset(systems=None, light=None, **more):
    given = {
        "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/120"}, "camera": ABOVE, "ground": MATTE,
        "systems": systems or flame({"point": [0, 0.5, 0]}), "light": {**DARK, "glow": "flame", **(light or {})},
    }  # fmt: skip
    return ga.load_preset({k: v for k, v in {**given, **more}.items() if v is not None})


def surfaces(given, monkeypatch, size=(96, 64)):
    """The picture of the surfaces alone, what emits, and the view."""
    sim = ga.Simulation(given)
    scene = Scene.of(given, sim.members.values())
    painter = Painter(size, Camera.from_spec(given.camera), {k: m.look for k, m in sim.members.items()}, scene=scene)
    monkeypatch.setattr(painting, "splat", lambda *_: None)
    view = painter.view(sim, 0.0)
    return np.array(painter.paint(sim, 0.0)), painter._emitted_light(sim, view, 0.0, 1.0), view


def on_plane(view, axis, at, size=(96, 64)):
    """(rows, columns, 3) the places of the pixels on the plane where the coordinate `axis` is `at`."""
    column, row = np.meshgrid(np.arange(size[0]) + 0.5 - size[0] / 2, size[1] / 2 - np.arange(size[1]) - 0.5)
    offset = (column[..., None] * view.axes[0] + row[..., None] * view.axes[1]) / view.scale(size[1])
    origin, way = np.broadcast_to(view.position, offset.shape), view.axes[2] + offset
    if view.height is not None:
        origin, way = view.position + offset, np.broadcast_to(view.axes[2], offset.shape)
    return origin + ((at - origin[..., axis]) / way[..., axis])[..., None] * way


def direct_sum(x, normal, lights, softness=0.0):
    """The radiance of a white matte surface: sum of P cos / max(d^2, a^2) / pi, in float64."""
    flat, out = x.reshape(-1, 3), []
    for part in np.array_split(flat, max(len(flat) // 200, 1)):
        way = lights.positions[None] - part[:, None]
        square = (way**2).sum(axis=-1)
        cosine = np.maximum(way @ np.asarray(normal, float), 0.0) / np.sqrt(square)
        near = np.maximum(square, lights.areas / np.pi) + softness**2
        out.append((cosine / near) @ lights.power / np.pi)
    return np.concatenate(out).reshape(x.shape)


@pytest.mark.parametrize("height", [0.5, 3.0])
def test_one_sprite_lights_the_floor_by_the_cosine_and_the_square_of_the_distance(height, monkeypatch):
    """Mutants that fail: the square of the cosine, 1/d, without pi, the sprite's radius for its area."""
    got, _, view = surfaces(preset(flame({"point": [0.2, height, -0.1]})), monkeypatch)
    way = np.array([0.2, height, -0.1]) - on_plane(view, 1, 0.0)
    distance = np.linalg.norm(way, axis=-1)
    expected = 2.0 * DISC * 0.02**2 * height / distance**3 / math.pi
    assert got[..., 0] == pytest.approx(expected, rel=3e-6)
    assert (got[..., 0] == got[..., 1]).all() and (got[..., 3] == 1.0).all()


def test_inside_a_sprite_the_floor_has_at_most_its_brightness(monkeypatch):
    """A ball of radiance L lights what touches it with pi L: a white floor has L cos. Mutant that fails: no limit."""
    got, _, view = surfaces(preset(flame({"point": [0, 0.3, 0]}, radius=1.0)), monkeypatch)
    x = on_plane(view, 1, 0.0)
    distance = np.linalg.norm([0, 0.3, 0] - x, axis=-1)
    near = distance < 0.98 * math.sqrt(DISC / math.pi)
    assert near.sum() > 200
    assert got[..., 0][near] == pytest.approx(2.0 * (0.3 / distance)[near], rel=1e-5)


def test_light_goes_with_area_brightness_and_factor_and_colours_add(monkeypatch):
    at = {"point": [0.5, 1.0, 0.3]}

    def total(radius=0.02, light=None, **emission):
        return surfaces(preset(flame(at, radius=radius, **emission), light), monkeypatch)[0][..., :3].sum(axis=(0, 1))

    one = total()
    assert total(radius=0.04) == pytest.approx(4 * one, rel=1e-5)
    assert total(intensity=6.0) == pytest.approx(3 * one, rel=1e-5)
    assert total(light={"glow_intensity": 0.5}) == pytest.approx(0.5 * one, rel=1e-5)
    red, blue = total(color="#ff0000"), total(color="#0000ff")
    assert (red > 0).tolist() == [True, False, False] and (blue > 0).tolist() == [False, False, True]
    two = flame(at, color="#ff0000")
    two["other"] = flame(at, color="#0000ff")["flame"]
    both = surfaces(preset(two, {"glow": ["flame", "other"]}), monkeypatch)[0][..., :3].sum(axis=(0, 1))
    assert both == pytest.approx(red + blue, rel=1e-5)


BY_X = {"color": {"by": "x", "range": "-1..1", "gradient": ["#ff0000", "#0000ff"]}}


@pytest.mark.parametrize(
    "shape,count,radius,height,emission",
    [
        ({"ball": 0.4, "center": [0, 0.56, 0]}, 7, 0.05, 6, {}),
        ({"ball": 0.4, "center": [0, 0.56, 0]}, 300, 0.05, 6, {}),
        ({"ball": 0.56, "center": [0, 0.56, 0]}, 8000, 0.05, 1.6, {}),
        ({"ball": 0.5, "center": [0, 0.2, 0]}, 8000, 0.03, 4, {}),
        ({"disc": 1.0, "center": [0, 0.05, 0]}, 8000, 0.04, 6, {}),
        ({"ball": 1.0, "center": [0, 1.0, 0]}, 8000, 0.3, 6, BY_X),
    ],
    ids=["few", "hundreds", "on the floor", "through the floor", "low and flat", "wide, of two colours"],
)
def test_many_sprites_light_the_floor_as_their_sum(shape, count, radius, height, emission, monkeypatch):
    """To 2% in every pixel and colour. Mutants that fail: without first or second moments, opening at a radius per distance."""
    systems = flame(shape, count, radius, **emission)
    systems["flame"]["look"]["size"] = {"by": "random", "curve": [[0, 0.3], [1, 1.0]]}
    got, lights, view = surfaces(preset(systems, camera={**ABOVE, "height": height}, shadows=False), monkeypatch)
    expected = direct_sum(on_plane(view, 1, 0.0), [0, 1, 0], lights)
    assert len(lights.positions) == count and (expected[..., 0] > 0).all()
    lit = expected > 0
    assert np.abs(got[..., :3][lit] / expected[lit] - 1).max() < 0.02


def test_many_sprites_light_a_wall_as_their_sum(monkeypatch):
    wall = {"plane": {"point": [0, 0, -0.6], "normal": [0, 0, 1], "look": MATTE}}
    camera = {"position": [0, 1, 6], "target": [0, 1, 0], "fov": 40}
    systems = flame({"ball": 0.5, "center": [0, 0.6, 0]}, 8000, 0.04)
    given = preset(systems, {"glow_softness": 0.2}, camera=camera, colliders=wall, ground=None, shadows=False)
    got, lights, view = surfaces(given, monkeypatch)
    expected = direct_sum(on_plane(view, 2, -0.6), [0, 0, 1], lights, 0.2)
    assert np.abs(got[..., :3] / expected - 1).max() < 0.02


def test_the_camera_does_not_matter(monkeypatch):
    """Light comes from behind the camera, and fog and perspective do not change it."""
    systems = flame({"ball": 0.3, "center": [0, 2, 0]}, 50)
    got, _, _ = surfaces(preset(systems), monkeypatch)
    below = {"position": [0, 1.0, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 60}
    fog = {"distance": 1e4, "start": 1.5, "color": "black"}
    near, _, view = surfaces(preset(systems, camera={**below, "fog": fog}), monkeypatch)
    x = on_plane(view, 1, 0.0)
    for row, column in ((31, 47), (10, 20), (60, 90)):
        at = int((x[row, column, 2] / 4 + 0.5) * 64), int(48 + x[row, column, 0] * 16)
        assert near[row, column, 0] == pytest.approx(got[(*at, 0)], rel=0.02)


def test_a_far_light_is_the_lamp_with_its_shadows_and_highlights():
    """A sprite of the intensity 4 pi i D^2 at the distance D is a lamp of intensity i. Mutants that fail: a factor of pi, highlights
    without the cosine, no shadows."""
    far, towards = 2000.0, np.array([0.6, 1.0, 0.5]) / math.sqrt(1.61)
    ball = {"sphere": {"center": [0, 0.5, 0], "radius": 0.5, "look": {"albedo": "#c08040", "roughness": 0.4}}}
    block = {"block": {"min": [0.7, 0, -1], "max": [1.2, 0.9, -0.5], "look": {"metal": 1, "roughness": 0.5}}}
    common = {
        "camera": {"position": [1.5, 1.6, 4], "target": [0.3, 0.4, 0], "fov": 36}, "colliders": {**ball, **block},
        "ground": {"albedo": "#8090a0", "roughness": 0.6},
    }  # fmt: skip
    power = 4 * math.pi * 0.25 * far**2
    size = 2.0 * math.degrees(math.atan(math.sqrt(DISC / math.pi) * 0.8 / far))
    systems = flame({"point": (far * towards).tolist()}, radius=0.8, intensity=power / (DISC * 0.8**2))
    lamp = {"direction": (-towards).tolist(), "size": size, "ambient_intensity": 0.0}
    size_of_picture = (192, 128)
    got = ga.render_frame(ga.Simulation(preset(systems, **common)), size_of_picture)
    expected = ga.render_frame(
        ga.Simulation(preset(systems, {**lamp, "intensity": 0.25, "glow": []}, **common)), size_of_picture
    )
    got, expected = got[44:, :, :3], expected[44:, :, :3]  # not the ground far away, which is nearer to the light
    difference = np.abs(got - expected).max(axis=-1) / np.maximum(expected.max(axis=-1), 1e-3)
    assert expected.max() > 0.8
    assert (difference > 0.02).mean() < 0.02  # shadows' edges in steps of a 16th
    assert np.median(difference) < 0.01


def test_what_stands_behind_the_light_casts_no_shadow(monkeypatch):
    """A ball beside the light shadows the floor on its far side only, at the place of the cone through it."""
    systems = flame({"point": [0, 0.5, 0]}, radius=0.01)
    ball = {"sphere": {"center": [0.5, 0.25, 0], "radius": 0.1, "look": MATTE}}
    free, _, view = surfaces(preset(systems), monkeypatch)
    got, _, _ = surfaces(preset(systems, colliders=ball), monkeypatch)
    x = on_plane(view, 1, 0.0)
    way = x - (0, 0.5, 0)
    along = np.array([0.5, -0.25, 0]) / math.hypot(0.5, 0.25)
    angle = np.arccos((way @ along) / np.linalg.norm(way, axis=-1))
    cone = math.asin(0.1 / math.hypot(0.5, 0.25))
    ball_seen = np.hypot(x[..., 0] - 0.5, x[..., 2]) < 0.13
    # a pixel is 1/16 m wide: half of its diagonal and the light's radius, 0.054 m, are 0.1 rad at the ball's distance from the light
    umbra = (angle < cone - 0.1) & ~ball_seen
    assert (got[..., 0][umbra] <= 0.1 * free[..., 0][umbra]).all()
    outside = (angle > cone + 0.1) & ~ball_seen
    assert got[..., 0][outside] == pytest.approx(free[..., 0][outside], rel=1e-5)
    assert umbra.sum() > 10


def test_a_few_lamps_each_cast_shadows_of_their_own(monkeypatch):
    """A wall between two lamps leaves each floor the light of its own lamp. Mutant that fails: both in one leaf, as one lamp."""
    systems = flame({"point": [-0.6, 0.5, 0.1]}, radius=0.02)
    systems["flame"]["emitters"]["two"] = {"count": 1, "shape": {"point": [0.5, 0.7, 0.2]}}
    wall = {"block": {"min": [-0.02, -1, -9], "max": [0.02, 1.5, 9], "look": MATTE}}
    got, lights, view = surfaces(preset(systems, colliders=wall), monkeypatch)
    x = on_plane(view, 1, 0.0)
    for sign in (-1.0, 1.0):
        floor, lamp = sign * x[..., 0] > 0.1, sign * lights.positions[:, 0] > 0
        own = type(lights)(lights.positions[lamp], lights.power[lamp], lights.areas[lamp])
        assert lamp.sum() == 1 and floor.sum() > 1000
        assert got[..., 0][floor] == pytest.approx(direct_sum(x, [0, 1, 0], own)[..., 0][floor], rel=1e-5)


@pytest.mark.parametrize(
    "shape",
    [
        {"capsule": [0.5, 0.08], "at": [0.25, 0.35, 0.1], "turn": [35, 10, 60]},
        {"box": [0.45, 0.25, 0.2], "at": [-0.2, 0.3, 0.1], "turn": [20, 50, -15]},
        {"box": [0.08, 0.6, 1.8], "at": [0.45, 0.3, 0], "turn": [0, 15, 4]},
    ],
    ids=["capsule", "box", "a wall whose ball holds the light"],
)
def test_a_turned_body_shadows_what_it_stands_before(shape, monkeypatch):
    """The floor is dark where the way to the light goes through the body. Mutants that fail: in the test of the box around the
    body, its offset with the other sign, the world's axes, half of its size; the ball around the body for the body."""
    systems = flame({"point": [0.1, 0.9, 0.0]}, radius=0.005)
    camera, more = {**ABOVE, "height": 1.6}, systems | {
        "thing": {
            "inherit_forces": False, "interactions": {"rigid": {}}, "look": {"draw": "body", "albedo": "white"},
            "integrator": "leapfrog", "emitters": {"one": {"body": {"shape": shape, "static": True, "points": 20}}},
        }
    }  # fmt: skip
    free, _, view = surfaces(preset(systems, camera=camera), monkeypatch)
    got, _, _ = surfaces(preset(more, camera=camera), monkeypatch)
    x, light, part = on_plane(view, 1, 0.0), np.array([0.1, 0.9, 0.0]), parts_of(shape)[0]
    way = np.linspace(0, 1, 401)[:, None] * (light - x).reshape(-1, 1, 3) + x.reshape(-1, 1, 3)
    inside = part.distance(way.reshape(-1, 3)).reshape(len(way), -1).min(axis=1).reshape(x.shape[:2])
    up = np.stack([x[..., 0], 0 * x[..., 0], x[..., 2]], axis=-1)[..., None, :] + np.linspace(0, 3, 301)[:, None] * [
        0,
        1,
        0,
    ]
    seen = (
        part.distance(up.reshape(-1, 3)).reshape(*x.shape[:2], -1).min(axis=-1) < 0.04
    )  # the camera sees the body there
    # a pixel's half diagonal and the light's radius are less than 0.025 m
    umbra, outside = (inside < -0.0225) & ~seen, (inside > 0.025) & ~seen
    assert umbra.sum() > 20 and outside.sum() > 1000
    assert (got[..., 0][umbra] <= 0.1 * free[..., 0][umbra]).all()
    assert got[..., 0][outside] == pytest.approx(free[..., 0][outside], rel=1e-5)


def test_a_glowing_ball_lights_the_floor_and_does_not_shadow_itself(monkeypatch):
    systems = flame({"point": [0, 0.6, 0]}, radius=0.2)
    systems["flame"]["look"] |= {"draw": "sphere", "blend": "opaque", "albedo": "black"}
    got, lights, view = surfaces(preset(systems), monkeypatch)
    x = on_plane(view, 1, 0.0)
    expected = direct_sum(x, [0, 1, 0], lights)[..., 0]
    assert lights.power[0, 0] == pytest.approx(2.0 * math.pi * 0.2**2, rel=1e-6)
    floor = np.hypot(x[..., 0], x[..., 2]) > 0.25
    assert got[..., 0][floor] == pytest.approx(expected[floor], rel=1e-5)


def three_lamps_over_balls(count, radius, box, monkeypatch, size=(384, 256)):
    """(what 4000 of the floor's pixels show, their places, each lamp's place and unshadowed light there, the balls' centres)"""
    lamps = np.array([[-4.0, 7.0, 1.0], [3.0, 8.0, -2.0], [0.5, 6.0, 4.0]])
    systems = flame({"point": lamps[0].tolist()}, radius=0.004)
    for k in (1, 2):
        systems["flame"]["emitters"][f"lamp{k}"] = {"count": 1, "shape": {"point": lamps[k].tolist()}}
    systems["balls"] = {
        "emitters": {"all": {"count": count, "shape": {"box": box}}},
        "look": {"draw": "sphere", "blend": "opaque", "radius": radius, "albedo": "black"},
    }
    given = preset(systems)
    got, lights, view = surfaces(given, monkeypatch, size)
    some = np.random.default_rng(1).choice(size[0] * size[1], 4000, replace=False)
    x = on_plane(view, 1, 0.0, size).reshape(-1, 3)[some]
    each = []
    for lamp in lamps:
        own = [int(np.argmin(np.linalg.norm(lights.positions - lamp, axis=1)))]
        part = type(lights)(lights.positions[own], lights.power[own], lights.areas[own])
        each.append((lights.positions[own[0]], direct_sum(x, [0, 1, 0], part)))
    return got[..., :3].reshape(-1, 3)[some], x, each, ga.Simulation(given)["balls"].position


def test_balls_shadow_each_lamp_by_itself(monkeypatch):
    """The floor has the light of those lamps to which the way is free. Mutants that fail: the cells of the first lamp for all; the
    direction to the lamp for that from it."""
    radius, pixel = 0.04, 4.0 / 256
    got, x, lamps, centers = three_lamps_over_balls(40, radius, [[-2.5, 0.25, -1.8], [2.5, 0.6, 1.8]], monkeypatch)
    expected = 0.0 * x
    sure = (
        np.linalg.norm((x[:, None] - centers)[..., ::2], axis=-1).min(axis=1) > radius + pixel
    )  # else the camera sees a ball
    for place, light in lamps:
        way = place - x
        for center in centers:
            along = np.clip(((center - x) * way).sum(-1) / (way**2).sum(-1), 0.0, 1.0)
            apart = np.linalg.norm(x + along[:, None] * way - center, axis=-1)
            light[apart < radius] = 0.0
            # half a pixel, the lamp's radius, and the way from 0.6 pixels above the floor
            sure &= abs(apart - radius) > 0.5 * pixel + 0.008 + 0.6 * pixel * (1.0 - along)
        expected += light
    assert sure.sum() > 1000 and expected[sure].min() < 0.8 * expected[sure].max()
    assert got[sure] == pytest.approx(expected[sure], rel=1e-4, abs=1e-6 * expected.max())


def test_lights_that_look_small_from_all_that_may_shadow_them_are_one_lamp():
    """Mutants that fail: the middle of a node for its box; the lamp cut as long as it can be; no limit without casters."""
    rng = np.random.default_rng(3)
    x, bulb = rng.normal(0, 10, (300, 3)), np.array([[0.0, -400, 0]])

    def lamps(caster, lights=x):
        balls = None if caster is None else (np.array(caster, float).reshape(-1, 3), np.full(len(caster), 2.0))
        return len(LightTree.of(lights, np.ones((len(lights), 3)), np.full(len(lights), 0.01), casters=balls).lamps)

    assert lamps([[0, -400, 0]]) == 1 and lamps([]) == 1
    assert lamps([[0, -40, 0]]) > 1 and lamps([[0, -400, 0], [0, 0, 0]]) > 1 and lamps(None) > 1
    assert lamps([[0, -398, 5]], np.concatenate([x, bulb])) == 2


def test_solids_are_found_in_the_cells_towards_them():
    """Every direction from a lamp that meets a ball lies in a cell that lists it."""
    rng = np.random.default_rng(4)
    lamps, widths = rng.normal(0, 1, (3, 3)), np.array([0.0, 0.2, 0.5])
    centers, radii = rng.normal(0, 3, (200, 3)), rng.uniform(0.05, 0.5, 200)
    bins = NearBins.of(lamps, widths, centers, radii, np.zeros(200, bool))
    for k in range(3):
        way = rng.normal(0, 1, (4000, 3))
        way /= np.linalg.norm(way, axis=1)[:, None]
        row = np.clip(((1 + way[:, 1]) * 0.5 * ROWS).astype(int), 0, ROWS - 1)
        column = np.clip((quarter_angle(way[:, 0], way[:, 2]) * COLUMNS / 4).astype(int), 0, COLUMNS - 1)
        offset = centers - lamps[k]
        along = way @ offset.T
        aside = np.sqrt(np.maximum((offset**2).sum(axis=1) - along**2, 0))
        met = (along > 0) & (aside < radii) & (np.linalg.norm(offset, axis=1) > radii)
        for i, j in zip(*np.nonzero(met)):
            cell = (k * ROWS + row[i]) * COLUMNS + column[i]
            assert j in bins.solids[bins.starts[cell] : bins.starts[cell + 1]]


def test_the_tree_keeps_the_power_and_each_light_once():
    rng = np.random.default_rng(2)
    for count in (1, 2, 9, 700):
        x, power = rng.normal(0, 1, (count, 3)), rng.uniform(0, 1, (count, 3))
        tree = LightTree.of(x, power, np.full(count, 0.01))
        seen = np.zeros(len(tree.lights), int)
        for first, number, _ in tree.links:
            seen[first : first + number] += 1
        assert (seen == 1).all() and tree.lights[:, 3:6].sum(axis=0) == pytest.approx(power.sum(axis=0), rel=1e-5)
        parts = [k for first, end in tree.lamps for k in range(first, end)]
        assert len(parts) == len(set(parts)) and tree.links[-1, 2] == len(tree.nodes)
    same = LightTree.of(np.zeros((5000, 3)), np.ones((5000, 3)), np.full(5000, 0.01))
    assert len(same.lights) == 1 and same.lights[0, 3] == 5000
    assert LightTree.of(np.zeros((3, 3)), np.zeros((3, 3)), np.ones(3)) is None


@pytest.mark.parametrize(
    "ground, is_lit",
    [
        ({"albedo": "black", "roughness": 0.9, "ior": 1.5}, False),
        ({"albedo": "#020000", "roughness": 0.9, "ior": 1.5}, True),
        ({"albedo": "black", "roughness": 0.3, "ior": 1.5}, True),
        ({"albedo": "black", "roughness": 0.9, "metal": 1}, True),
    ],
)
def test_only_what_is_black_and_dull_shows_no_light(ground, is_lit, monkeypatch):
    """The light on it is not even looked for. Mutants: nor is that on smooth black, on black metal, or on a colour of one channel."""
    picture, *_ = surfaces(preset(ground=ground), monkeypatch)
    assert (picture[..., :3].max() > 0) == is_lit


def test_without_light_nothing_changes():
    """Bytes of a picture whose glowing system emits nothing, or has no particles, are those without `glow`."""
    for systems in (flame({"point": [0, 1, 0]}, intensity=0.0), flame({"point": [0, 1, 0]}, count=0)):
        lamp = {"intensity": 0.3, "direction": [0, -1, 0.2]}
        dark = ga.render_frame(ga.Simulation(preset(systems, lamp)), (40, 30))
        without = ga.render_frame(ga.Simulation(preset(systems, {**lamp, "glow": []})), (40, 30))
        assert dark.tobytes() == without.tobytes()


@pytest.mark.parametrize("size", [(1, 1), (7, 5)])
@pytest.mark.parametrize("more", [{}, {"ground": {"mirror": True, "roughness": 0.2}}, {"sky": "#203040"}])
def test_small_pictures(size, more):
    got = ga.render_frame(ga.Simulation(preset(flame({"ball": 0.2, "center": [0, 0.4, 0]}, 30), **more)), size)
    assert np.isfinite(got).all() and got[..., 0].max() > 0


def test_film_and_still_show_the_same_light(tmp_path):
    systems = flame({"ball": 0.2, "center": [0, 0.4, 0]}, 30)
    systems["flame"]["forces"] = {"gravity": [0, -1, 0]}
    film = ga.render(preset(systems), tmp_path / "f_####.png", size=(64, 48), frames=range(3))
    again = still(preset(systems), tmp_path / "s.png", 2 / 30, size=(64, 48))
    assert film[2].read_bytes() == again[0].read_bytes()


def test_unknown_systems_are_sentences():
    with pytest.raises(PresetError, match=r"light\.glow: there is no system 'flam'; did you mean 'flame'"):
        preset(light={"glow": "flam"})
    with pytest.raises(PresetError, match="'bare' has no look, so it emits no light"):
        preset({**flame({"point": [0, 1, 0]}), "bare": {"emitters": {"one": {"count": 1}}}}, {"glow": "bare"})
    sim = ga.Simulation(preset())
    with pytest.raises(ga.UsageError, match=r"light\.glow names 'fire', and there is no such system"):
        ga.render_frame(sim, (8, 8), light={"glow": "fire"})
