"""The layers of surfaces: depth, motion, albedo, normal and shadow against closed geometry.

Mutants that were tried, each of which fails a test here: the distance along the ray in place of that along the line of sight;
a normal of the other sign, or along the camera's axes; the checker's two colours exchanged; the lamp's direction of the other
sign; the velocity of the other sign, without the seconds, or without the turning; the camera's motion of the other sign;
sprites that surfaces do not hide, and surfaces that opaque sprites do not hide.
"""

import math

import numpy as np
import pytest

from gen_art.interactions.links import capsules_along
from gen_art.output.playback import Playback
from gen_art.preset.light import Light
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.preset.surface import ground_of
from gen_art.renderer.aovs import LAYERS, SURFACE_LAYERS, render_aovs
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.surfaces.scene import Scene
from tests.render.particles import scene, state

SIZE = (64, 48)
LAMP = {"direction": [0, -1, 0], "ambient_intensity": 0.3, "size": 0.01}
NOTHING = {"dot": {"emitters": {"one": {"count": 1, "shape": {"point": [0, 0, 1e6]}}}, "look": {"draw": "point"}}}
AHEAD = {"position": [0, 0, 5], "target": [0, 0, 0], "fov": 30}
ABOVE = {"position": [0, 4, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 30}


def layers_of(frame=0, size=SIZE, transparent=False, **keys):
    """(layers of a frame at 10 frames/s, the playback)."""
    basis = {
        "version": 1,
        "clock": {"duration": 1, "fps": 10, "step": 0.025},
        "light": LAMP,
        "systems": NOTHING,
        "camera": AHEAD,
    }
    playback = Playback(load_preset({**basis, **keys}), size, "f32", None, transparent)
    playback.picture(playback.step_of(frame / 10))
    return playback.aovs(), playback


def ball(position, velocity=(0, 0, 0), radius=0.5, **look):
    emitter = {"count": 1, "shape": {"point": list(position)}, "velocity": {"constant": list(velocity)}}
    look = {"draw": "sphere", "blend": "opaque", "albedo": "white", **look}
    return {"particle": {"radius": radius}, "emitters": {"one": emitter}, "look": look}


def rays(view, size=SIZE):
    """Origins and unit directions (rows, columns, 3) of the rays through the pixels' middles, in the world."""
    column, row = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    x, y = (column - size[0] / 2) / view.scale(size[1]), (size[1] / 2 - row) / view.scale(size[1])
    aside = x[..., None] * view.axes[0] + y[..., None] * view.axes[1]
    if view.height is not None:
        return view.position + aside, np.broadcast_to(view.axes[2], aside.shape)
    d = aside + view.axes[2]
    return np.broadcast_to(view.position, d.shape), d / np.linalg.norm(d, axis=2)[..., None]


def sphere_hits(view, centre, radius, size=SIZE):
    """(places (rows, columns, 3), of which pixels lie inside the outline by a pixel and more)."""
    o, d = rays(view, size)
    c = np.asarray(centre) - o
    along = (c * d).sum(2)
    aside = np.linalg.norm(c - along[..., None] * d, axis=2)
    inside = aside < radius - 1.5 * np.linalg.norm(c, axis=2) / view.scale(size[1])
    if view.height is not None:
        inside = aside < radius - 1.5 / view.scale(size[1])
    t = along - np.sqrt(np.maximum(radius**2 - aside**2, 0))
    return o + t[..., None] * d, inside


def plane_hits(view, size=SIZE):
    """The places (rows, columns, 3) where rays meet the ground y = 0."""
    o, d = rays(view, size)
    return o - d * (o[..., 1:2] / d[..., 1:2])


def normal_of(layers):
    return np.stack([layers[f"normal.{c}"] for c in "XYZ"], axis=2)


def motion_of(layers):
    return np.stack([layers["velocity.x"], layers["velocity.y"]], axis=2)


def moved(playback, places, velocities, frame):
    """(rows, columns, 2) pixels that these places moved since the frame before, by projection."""
    shape = places.shape
    before = places - 0.1 * np.broadcast_to(velocities, shape)
    views = [playback.painter.view(playback.sim, k / 10) for k in (frame, frame - 1)]
    now, then = (view.project(x.reshape(-1, 3), SIZE)[:, :2] for view, x in zip(views, (places, before)))
    return (now - then).reshape(*shape[:2], 2)


CAMERAS = [
    AHEAD,
    {**AHEAD, "position": [1.5, 2, 3]},
    {**AHEAD, "position": [0, 0, 1.2], "fov": 100},
    {"position": [1, 2, 5], "height": 2},
]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("collider", [False, True])
def test_depth_and_normal_of_a_ball(camera, collider):
    """Where the ray through a pixel's middle meets a sphere, to the round-off of float32 over ten lengths."""
    centre = (0.2, 0.1, -0.3)
    if collider:
        keys = {"colliders": {"sphere": {"center": list(centre), "radius": 0.5, "look": "white"}}}
    else:
        keys = {"systems": {"ball": ball(centre)}}
    layers, playback = layers_of(camera=camera, **keys)
    view = playback.painter.view(playback.sim, 0)
    places, inside = sphere_hits(view, centre, 0.5)
    assert inside.sum() > 20
    depth = (places - view.position) @ view.axes[2]
    # a collider's hit is exact to 1/250 of a pixel, and the normal turns by that over the radius
    tolerance = 0.008 * 6 / view.scale(48)
    assert layers["Z"][inside] == pytest.approx(depth[inside], abs=tolerance)
    assert np.abs(normal_of(layers) - (places - centre) / 0.5)[inside].max() < 2 * tolerance / 0.5
    outside = layers["albedo.R"] == 0
    assert outside.any() and (layers["Z"][outside] == 0).all() and (normal_of(layers)[outside] == 0).all()
    assert (layers["shadow"][outside] == 1).all()
    length = np.linalg.norm(normal_of(layers)[~outside], axis=1)
    assert np.abs(length - 1).max() < 1e-5


def test_albedo_of_a_checker_is_that_of_its_squares():
    """Squares of 0.5 m; a pixel that lies in one square has its colour, wherever the lamp is; edges lie between."""
    ground = {"albedo": [1, 0.5, 0.25], "checker": {"size": 0.5, "color": "black"}}
    layers, playback = layers_of(ground=ground, camera=ABOVE)
    places = plane_hits(playback.painter.view(playback.sim, 0))
    pixel = 4 / playback.painter.view(playback.sim, 0).scale(48)
    cell = np.floor(places[..., [0, 2]] / 0.5)
    first = (cell.sum(2) % 2) == 0
    from_edge = np.abs(places[..., [0, 2]] / 0.5 - np.round(places[..., [0, 2]] / 0.5)).min(2) * 0.5
    within = from_edge > 0.51 * pixel
    assert within.mean() > 0.4
    for channel, value in zip("RGB", (1, 0.5, 0.25)):
        linear = value if value == 1 else ((value + 0.055) / 1.055) ** 2.4
        got = layers[f"albedo.{channel}"]
        assert got[within & first] == pytest.approx(linear, abs=1e-5)
        assert got[within & ~first] == pytest.approx(0, abs=1e-5)
        # over whole squares, half of the light is scattered
        assert 0.4 * linear < got.mean() < 0.6 * linear


@pytest.mark.parametrize("angle", [0, 40])
def test_shadow_is_that_of_the_ball(angle):
    """The lamp is small: a place is dark if its way to the lamp passes the ball's centre by less than the radius."""
    down = math.radians(angle)
    lamp = {**LAMP, "direction": [math.sin(down), -math.cos(down), 0]}
    centre, radius = np.array([-0.3, 1.0, 0.1]), 0.35
    layers, playback = layers_of(
        ground="grey",
        light=lamp,
        camera={**ABOVE, "position": [0, 9, 0.01]},
        systems={"ball": ball(centre, radius=radius)},
    )
    view = playback.painter.view(playback.sim, 0)
    places = plane_hits(view)
    _, hidden = sphere_hits(view, centre, radius + 0.2)
    to_lamp = -np.array(lamp["direction"])
    past = np.linalg.norm(np.cross(places - centre, to_lamp), axis=2)
    pixel = 9 / view.scale(48)
    dark, lit = (past < radius - 2 * pixel) & ~hidden, (past > radius + 2 * pixel) & ~hidden
    if angle:
        assert dark.sum() > 5
        assert layers["shadow"][dark] == pytest.approx(0, abs=1e-6)
    assert lit.sum() > 1000 and layers["shadow"][lit] == pytest.approx(1, abs=1e-6)
    # the side of the ball that faces the lamp is lit, the other is not
    places, inside = sphere_hits(view, centre, radius)
    towards = (places - centre) @ to_lamp / radius
    assert layers["shadow"][inside & (towards > 0.05)] == pytest.approx(1, abs=1e-6)
    assert layers["shadow"][inside & (towards < -0.05)] == pytest.approx(0, abs=1e-6)


def test_without_shadows_only_the_far_side_is_dark():
    layers, _ = layers_of(ground="grey", shadows=False, camera=ABOVE, systems={"ball": ball((0, 1, 0))})
    assert (layers["shadow"] == 1).all()


@pytest.mark.parametrize("camera", [AHEAD, {**AHEAD, "orbit": {"rate": 40}}, {"position": [0, 1, 5], "height": 3}])
def test_motion_of_a_ball_and_of_the_camera(camera):
    """The projection of a place now and of where it was in the frame before, to a thousandth of a pixel."""
    velocity = np.array([0.6, -0.4, 0.8])
    layers, playback = layers_of(3, camera=camera, systems={"ball": ball((0, 0.2, 0), velocity)})
    view = playback.painter.view(playback.sim, 0.3)
    places, inside = sphere_hits(view, np.array([0, 0.2, 0]) + 0.3 * velocity, 0.5)
    expected = moved(playback, places, velocity, 3)
    assert inside.sum() > 50 and np.abs(expected[inside]).max() > 0.3
    assert np.abs(motion_of(layers) - expected)[inside].max() < 1e-3


def test_motion_of_a_sprite_before_a_camera_that_orbits():
    """A soft disc has the motion of its middle: the projection now, less that of where it was in the frame before."""
    velocity = np.array([0.6, -0.4, 0.8])
    camera = {**AHEAD, "orbit": {"rate": 40}}
    look = {"draw": "disc", "radius": 0.1, "emission": "white"}
    layers, playback = layers_of(3, camera=camera, systems={"spark": {**ball((0, 0.2, 0), velocity), "look": look}})
    place = (np.array([0, 0.2, 0]) + 0.3 * velocity).reshape(1, 1, 3)
    expected = moved(playback, place, velocity, 3)[0, 0]
    seen = layers["Z"] > 0
    assert seen.sum() > 4 and np.abs(expected).min() > 0.3
    assert np.abs(motion_of(layers)[seen] - expected).max() < 1e-3
    depth = (place[0, 0] - playback.painter.view(playback.sim, 0.3).position) @ playback.painter.view(
        playback.sim, 0.3
    ).axes[2]
    assert layers["Z"][seen] == pytest.approx(depth, rel=1e-5)


@pytest.mark.parametrize("still", [False, True])
def test_motion_of_the_ground_before_a_camera(still):
    camera = {**AHEAD, "position": [0, 2, 5], "orbit": {"rate": 0 if still else 40}}
    layers, playback = layers_of(2, ground="grey", camera=camera)
    places = plane_hits(playback.painter.view(playback.sim, 0.2))
    expected = moved(playback, places, 0, 2)
    seen = layers["albedo.R"] > 0
    if still:
        assert (motion_of(layers) == 0).all()
    else:
        seen &= layers["Z"] < 50  # the middles of farther pixels lie a little beside what they show
        assert seen.sum() > 500 and np.abs(expected[seen]).max() > 1
        assert np.abs(motion_of(layers) - expected)[seen].max() < 2e-3


def test_motion_of_a_collider_that_moves_and_turns():
    """u = v + w x (x - pivot), the pivot moving with v."""
    v, w = np.array([0.2, 0.1, 0.0]), np.array([0.0, 2.0, 0.0])
    sphere = {
        "center": [0, 0, 0],
        "radius": 0.6,
        "velocity": v.tolist(),
        "angular_velocity": w.tolist(),
        "pivot": [0, 0, 0],
        "look": "white",
    }
    layers, playback = layers_of(2, colliders={"sphere": sphere})
    places, inside = sphere_hits(playback.painter.view(playback.sim, 0.2), 0.2 * v, 0.6)
    velocities = v + np.cross(w, places - 0.2 * v)
    expected = moved(playback, places, velocities, 2)
    assert np.abs(expected[inside]).max() > 2
    # the hit is exact to 1/250 of a pixel
    assert np.abs(motion_of(layers) - expected)[inside].max() < 0.02


def test_motion_of_a_body_that_turns():
    """A free body turns about its centre at a constant rate: every part of it goes by v + w x (x - centre)."""
    spin = np.array([0.0, 0.0, 3.0])
    body = {"shape": {"sphere": 0.6}, "velocity": [0.5, 0, 0], "spin": spin.tolist()}
    systems = {
        "one": {
            "integrator": "leapfrog", "interactions": {"rigid": {}}, "emitters": {"one": {"body": body}},
            "look": {"draw": "body"},
        }
    }  # fmt: skip
    layers, playback = layers_of(2, systems=systems)
    centre = np.array([0.1, 0, 0])
    places, inside = sphere_hits(playback.painter.view(playback.sim, 0.2), centre, 0.6)
    expected = moved(playback, places, np.array([0.5, 0, 0]) + np.cross(spin, places - centre), 2)
    assert inside.sum() > 50 and np.abs(expected[inside]).max() > 3
    assert np.abs(motion_of(layers) - expected)[inside].max() < 1e-3


def test_motion_of_a_thread():
    """A rod between two particles that part and turn: the velocity goes evenly from one to the other."""
    ends, velocities = [[-0.5, 0, 0], [0.5, 0, 0]], [[0, 1, 0], [0, -0.5, 0]]
    shapes = capsules_along(np.array(ends).T, np.array(velocities).T, np.array([[0, 1]]))
    for x in (-0.5, 0.0, 0.3):
        expected = [0, 1 - 1.5 * (x + 0.5), 0]
        place = np.array([x, 0, 0]) - shapes.center[0]
        assert shapes.velocity[0] + np.cross(shapes.spin[0], place) == pytest.approx(np.array(expected), abs=1e-12)


def test_motion_and_albedo_of_cloth():
    """A cloth that falls freely has one velocity; what it scatters on both sides together is its albedo."""
    cloth = {
        "corner": [-0.6, 0.6, 0],
        "across": [1.2, 0, 0],
        "down": [0, -1.2, 0],
        "columns": 8,
        "rows": 8,
        "pinned": "none",
    }
    systems = {
        "sheet": {
            "particle": {"mass": 0.001}, "integrator": "semi_implicit_euler", "forces": {"gravity": [0, -4, 0]},
            "interactions": {"springs": {"stiffness": 10, "method": "xpbd"}}, "emitters": {"cloth": {"cloth": cloth}},
            "look": {"draw": "cloth", "albedo": [1, 0.5, 1], "translucency": 0.4},
        }
    }  # fmt: skip
    layers, playback = layers_of(2, systems=systems, light={**LAMP, "direction": [0, 0, -1]})
    o, d = rays(playback.painter.view(playback.sim, 0.2))
    places = o - d * (o[..., 2:3] / d[..., 2:3])
    floats = playback.sim.systems["sheet"].floats[:6, :64]
    inside = (np.abs(places[..., 0]) < 0.5) & (np.abs(places[..., 1] - floats[1].mean()) < 0.5)
    expected = moved(playback, places, floats[3:6].mean(axis=1), 2)
    assert inside.sum() > 50 and np.abs(expected[inside]).max() > 0.5
    assert np.abs(motion_of(layers) - expected)[inside].max() < 2e-3
    assert layers["albedo.R"][inside] == pytest.approx(1, abs=1e-5)
    assert layers["albedo.G"][inside] == pytest.approx(((0.5 + 0.055) / 1.055) ** 2.4, abs=1e-5)
    assert layers["normal.Z"][inside] == pytest.approx(1, abs=1e-4)
    assert layers["Z"][inside] == pytest.approx(5, abs=1e-4)


@pytest.mark.parametrize("clear", [False, True])
def test_a_liquid_has_its_own_surface(clear):
    """A flat pool whose particles all move at 1 m/s: its depth, a normal upwards and its motion; its albedo, or the bottom's."""
    axis = np.arange(-0.5, 0.501, 0.03)
    points = np.stack(np.meshgrid(axis, [-0.05, -0.02, 0.01], axis), axis=-1).reshape(-1, 3)
    velocity = np.array([1.0, 0.0, 0.0])
    look = {"draw": "surface", "albedo": [0.5, 1, 1], "liquid": {"clear": clear}}
    camera = Camera(**{**ABOVE, "position": (0, 4, 0)})
    where = Scene(Light(**LAMP), ground_of({"albedo": "white", "height": -0.1}), True)
    painter = Painter(SIZE, camera, {"w": Look.model_validate(look)}, scene=where)
    sim = scene(w=state(points, np.tile(velocity, (len(points), 1)), radius=0.03))
    layers = render_aovs(painter, sim, 0.1, 0.1, 0.1)
    places = plane_hits(camera.at(0.1))
    inside = np.abs(places[..., [0, 2]]).max(axis=2) < 0.35
    assert inside.sum() > 60
    assert layers["Z"][inside] == pytest.approx(4 - 0.035, abs=0.01)  # spheres reach from 0.025 to 0.04
    if not clear:
        assert layers["albedo.R"][inside] == pytest.approx(((0.5 + 0.055) / 1.055) ** 2.4, abs=1e-3)
    else:  # a tenth of a metre of pure water takes less than 4% of red light, and reflects 2%
        assert layers["albedo.R"][inside].min() > 0.9 and layers["albedo.R"][inside].max() < 0.985
    assert (layers["normal.Y"][inside] > 0.95).all()
    scale = camera.at(0.1).scale(48) / (4 - 0.035)
    assert layers["velocity.x"][inside] == pytest.approx(0.1 * scale, rel=0.01)
    assert np.abs(layers["velocity.y"][inside]).max() < 1e-3


def test_sprites_and_surfaces_share_depth_and_motion():
    """An opaque sprite hides the ball behind it, the ball hides one behind itself; a sprite has neither normal nor albedo."""

    def sprite(z, velocity=(0, 0, 0)):
        return ball((0, 0, z), velocity, 0.3, draw="disc", blend="alpha", opacity=50, albedo="black")

    alone, _ = layers_of(systems={"ball": ball((0, 0, 0))})
    behind, _ = layers_of(systems={"ball": ball((0, 0, 0)), "far": sprite(-2)})
    before, playback = layers_of(1, systems={"ball": ball((0, 0, 0)), "near": sprite(2, (0.5, 0, 0))})
    assert np.array_equal(behind["Z"][20:28, 28:36], alone["Z"][20:28, 28:36])
    scale = playback.painter.view(playback.sim, 0).scale(48)
    row, column = 24, int(32 + 0.05 * scale / 3)
    assert before["Z"][row, column] == pytest.approx(3, rel=0.02)  # a disc covers 98%
    assert before["velocity.x"][row, column] == pytest.approx(0.05 * scale / 3, rel=0.04)
    for name in SURFACE_LAYERS:
        assert np.array_equal(before[name], alone[name]), name


def test_a_glow_counts_by_its_light():
    """Additive sprites of light L before a surface of light S and coverage 1: Z is (L z + (S + 1) Z) / (L + S + 1)."""
    glow = ball(
        (0, 0, 0), radius=6, draw="disc", blend="add", emission={"color": "white", "intensity": 2}, albedo="black"
    )
    ground = {"plane": {"point": [0, 0, -2], "normal": [0, 0, 1], "look": {"albedo": "grey", "ior": 1}}}
    light = {**LAMP, "direction": [0, 0, -1]}
    layers, playback = layers_of(systems={"glow": glow}, colliders=ground, light=light)
    both = playback.picture(0)[24, 32, 0]
    surface = Playback(
        load_preset(
            {
                "version": 1,
                "clock": {"duration": 1, "fps": 10, "step": 0.025},
                "light": light,
                "systems": {"glow": {**glow, "look": None}},
                "colliders": ground,
                "camera": AHEAD,
            }
        ),
        SIZE,
        "f32",
        None,
    ).picture(0)[24, 32, 0]
    added = both - surface
    assert added > 0.1
    expected = (added * 5 + (surface + 1) * 7) / (added + surface + 1)
    assert layers["Z"][24, 32] == pytest.approx(expected, rel=1e-4)


def test_transparent_pictures_have_the_same_layers():
    keys = {
        "sky": {"sun": 30},
        "ground": "grey",
        "systems": {"ball": ball((0, 0.5, 0))},
        "camera": {**AHEAD, "position": [0, 2, 5]},
    }
    with_sky, _ = layers_of(**keys)
    transparent, _ = layers_of(transparent=True, **keys)
    assert set(with_sky) == {*LAYERS, *SURFACE_LAYERS}
    for name, values in with_sky.items():
        assert np.array_equal(values, transparent[name]), name


def test_without_surfaces_there_are_no_layers_of_surfaces():
    layers, playback = layers_of(light=None)
    assert set(layers) == set(LAYERS) and not playback.painter.shows_surfaces


@pytest.mark.parametrize("size", [(1, 1), (7, 5)])
@pytest.mark.parametrize("supersample", [1, 2])
def test_tiny_pictures_and_empty_systems(size, supersample):
    empty = {**ball((0, 0, 0)), "emitters": {"one": {"count": 1, "at": 5, "shape": {"point": [0, 0, 0]}}}}
    for systems in ({"ball": ball((0, 0, 0))}, {"ball": empty}, {"behind": ball((0, 0, 9))}):
        layers, _ = layers_of(
            size=size,
            systems=systems,
            ground="grey",
            camera={**AHEAD, "position": [0, 2, 5], "supersample": supersample},
        )
        for name, values in layers.items():
            assert values.shape == size[::-1] and np.isfinite(values).all(), name


def test_supersampled_layers_are_means():
    camera = {**AHEAD, "position": [0, 2, 5]}
    keys = {"ground": "grey", "systems": {"ball": ball((0, 0.5, 0), (1, 0, 0))}}
    fine, _ = layers_of(1, size=(128, 96), camera=camera, **keys)
    coarse, _ = layers_of(1, camera={**camera, "supersample": 2}, **keys)
    blocks = fine["albedo.R"].reshape(48, 2, 64, 2).mean(axis=(1, 3))
    assert coarse["albedo.R"] == pytest.approx(blocks, abs=1e-6)
    alike = (
        np.abs(np.diff(fine["velocity.x"].reshape(48, 2, 64, 2).transpose(0, 2, 1, 3).reshape(48, 64, 4), axis=2)).max(
            2
        )
        < 1e-3
    )
    half = fine["velocity.x"].reshape(48, 2, 64, 2).mean(axis=(1, 3)) / 2
    assert coarse["velocity.x"][alike] == pytest.approx(half[alike], abs=1e-3)
