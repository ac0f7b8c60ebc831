"""A wormhole in the picture: its skies, the passage of a camera, the sides of systems, what is refused, and bytes that repeat."""

import hashlib
import math
from pathlib import Path

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError, UsageError
from gen_art.output.job import still
from gen_art.output.playback import Playback
from gen_art.preset.wormhole import Wormhole
from gen_art.renderer.camera import Camera
from gen_art.renderer.lensing.throat import Throat
from gen_art.simulation.no_effect import silent_parts

ROOT = Path(__file__).parents[2]
CAMERA = {"position": [0, 0, 8], "target": [0, 0, 0], "fov": 50}
SKIES = {"sky": {"color": "#0000ff"}, "wormhole": {"radius": 2, "sky": {"color": "#ff0000"}}}
SPECK = {"emitters": {"one": {"count": 1, "shape": {"point": [0, 0, -1e6]}}}, "look": {"draw": "disc", "radius": 1e-6}}


def preset(**more):
    base = {
        "version": 1, "clock": {"duration": 2, "fps": 30, "step": "1/60"}, "systems": {"speck": SPECK}, "camera": CAMERA,
        **SKIES,
    }  # fmt: skip
    return ga.load_preset({key: value for key, value in {**base, **more}.items() if value is not None})


def picture(size=(160, 90), time=0.0, transparent=False, **more):
    playback = Playback(preset(**more), size, "f32", None, transparent)
    return np.array(playback.picture(playback.step_of(time)))


def speck(position, **look):
    return {
        "emitters": {"one": {"count": 1, "shape": {"point": position}}},
        "look": {"draw": "disc", "radius": 0.1, **look},
    }


@pytest.mark.parametrize("distance", [3.0, 8.0, 30.0])
def test_the_other_side_fills_the_circle_of_rays_with_b_below_the_radius(distance):
    """Rays at an angle alpha from the middle go through where r sin(alpha) < a, with r^2 = z^2 + a^2 on the axis.

    The rim's pixels are means of 48 samples along one line each, so the area is right to a hundredth of a pixel times the rim.
    Mutants that fail: z for r, one sample at the rim, the skies exchanged.
    """
    size, slope = (240, 180), 2.0 * math.tan(math.radians(40)) / 180
    got = picture(size, camera={**CAMERA, "position": [0, 0, distance], "fov": 80})
    radius = math.tan(math.asin(2.0 / math.hypot(distance, 2.0))) / slope
    assert got[..., 0].sum() == pytest.approx(math.pi * radius**2, rel=2e-3, abs=0.3)
    assert got[..., 0] + got[..., 2] == pytest.approx(np.ones((180, 240)), abs=1e-5)
    assert np.all(got[..., 3] == 1.0)
    row = got[90, :, 0]
    assert row[120] == 1.0
    if radius < 119.0:  # the rim's pixel has the part of it that is inside, to 1 of 48 samples and the row's slant
        assert row[0] == 0.0 and row[120 + int(radius)] == pytest.approx(radius % 1.0, abs=0.03)


def test_the_rim_is_round_and_the_same_from_every_side():
    one = picture((120, 120), camera={**CAMERA, "position": [0, 0, 8]})[..., 0]
    assert one == pytest.approx(one.T, abs=0.03) and one == pytest.approx(one[::-1, ::-1], abs=0.03)
    # at the side the coordinates are those of the disc's edge: l^2 = x^2 - a^2
    r = math.sqrt(64.0 + 4.0)
    two = picture((120, 120), camera={**CAMERA, "position": [r, 0, 0]})[..., 0]
    assert two.sum() == pytest.approx(one.sum(), rel=0.01)


def test_the_sky_behind_stands_where_its_rays_end():
    """Above the wormhole a gradient of colours is that of the ray's end, by the weak deflection pi / 4 (a / b)^2 and its next term."""
    sky = {"gradient": ["black", "white"]}
    got = picture((90, 360), sky=sky, wormhole={"radius": 0.5}, camera={**CAMERA, "position": [0, 0, 40], "fov": 20})
    from gen_art.renderer.sky import SkyDome

    dome = SkyDome.of(ga.Sky(**sky))
    slope = 2.0 * math.tan(math.radians(10)) / 360
    for row in (20, 100, 140):
        x, y = 0.5 * slope, (180 - row - 0.5) * slope
        sine = math.hypot(x, y) / math.sqrt(1.0 + x * x + y * y)
        b = math.hypot(40.0, 0.5) * sine / 0.5
        turned = math.atan(math.hypot(x, y)) - math.pi / (4 * b * b) - 9 * math.pi / (64 * b**4)
        tangent = math.tan(turned) / math.hypot(x, y)
        light = dome.radiance([[x * tangent, y * tangent, -1.0]])[0]
        # a camera at 80 radii has not met all of the deflection: the part behind it is (a / r)^3 of a radian or less
        assert got[row, 45, :3] == pytest.approx(light, abs=2e-4)


def test_a_camera_that_goes_through_sees_no_jump():
    """A thousandth of a radius on both sides of the disc, the skies differ by the parallax of that: of 1 pixel in 10,000."""
    skies = {
        "sky": {"gradient": ["black", "blue", "white"]},
        "wormhole": {"radius": 2, "sky": {"gradient": ["yellow", "red", "black"]}},
    }
    path = [{"time": 0, "position": [0.3, 0.2, 0.002]}, {"time": 1, "position": [0.3, 0.2, -0.002]}]
    camera = {**CAMERA, "target": [1, 0, -9], "path": path, "easing": "hold"}
    systems = {
        "speck": SPECK,
        "one": speck([1.0, 0.4, -3.0], side="far"),
        "two": speck([0.5, 0.2, -1.0], side="through"),
    }
    before, after = (picture(time=t, camera=camera, systems=systems, **skies) for t in (0.0, 1.0))
    assert np.abs(before - after).max() < 0.02 * before.max()
    jumped = picture(
        time=1.0, camera={**camera, "path": [{"time": 0, "position": [0.3, 0.2, -0.002]}]}, systems=systems, **skies
    )
    assert np.abs(jumped - after).max() > 0.2


def test_a_path_changes_sides_only_through_the_disc():
    throat, spec = Throat(Wormhole(radius=2.0)), {"target": [0, 0, -90]}

    def sides(*positions):
        path = [{"time": float(k), "position": list(p)} for k, p in enumerate(positions)]
        camera = Camera.from_spec(ga.load_preset({**BARE, "camera": {**spec, "path": path, "easing": "linear"}}).camera)
        return [Throat(throat.spec).lens(camera.at(t), t, camera).far for t in range(len(positions))]

    assert sides([0, 0, 5], [0, 0, -5]) == [False, True]
    assert sides([0, 0, 5], [0, 0, -5], [0, 1, 5]) == [False, True, False]
    assert sides([5, 0, 5], [5, 0, -5]) == [False, False]
    assert sides([0, 0, 5], [0, 0, -5], [5, 0, 5]) == [False, True, True]


BARE = {"version": 1, "clock": {"duration": 2, "fps": 30, "step": "1/60"}, "systems": {"speck": SPECK}}


def test_systems_are_seen_on_their_side():
    """On the axis in front of the camera, a far particle is in the middle and its light is that of its distance through the throat.

    Its second image is a part of a ring round the middle, as large as the rim, which is 43 pixels away, and is left out here.
    """
    none = {"sky": None, "wormhole": {"radius": 2}}
    size = (161, 161)
    for side, depth in (("near", 5.0), ("far", -3.0), ("through", -3.0)):
        got = picture(size, systems={"speck": SPECK, "one": speck([0.0, 0.0, depth], side=side)}, **none)[
            50:111, 50:111, 0
        ]
        rows, columns = np.indices(got.shape)
        assert (got * rows).sum() / got.sum() == pytest.approx(30.0, abs=0.05)
        assert (got * columns).sum() / got.sum() == pytest.approx(30.0, abs=0.05)
    # on the axis D = r_c r_p sin(f), f = atan(l_c) - atan(l_p), in units of a: b d(angle)/db of the limit b = 0
    light = {}
    for depth in (-1.0, -6.0):
        one = picture(size, systems={"speck": SPECK, "one": speck([0.0, 0.0, depth], side="far")}, **none)[
            50:111, 50:111, 0
        ]
        light[depth] = one.sum()
    widths = [2 * math.hypot(4, 1) * math.hypot(z / 2, 1) * (math.atan(4) + math.atan(-z / 2)) for z in (-1.0, -6.0)]
    assert light[-1.0] / light[-6.0] == pytest.approx((widths[1] / widths[0]) ** 2, rel=1e-3)


def test_a_particle_behind_has_two_images():
    systems = {"speck": SPECK, "one": speck([0.6, 0.0, -6.0])}
    got = picture((320, 180), sky=None, wormhole={"radius": 2}, systems=systems)[..., 0]
    assert got[90, 160:].max() > 0.05 and got[90, :160].max() > 1e-3
    assert got[:, 160:].sum() > got[:, :160].sum() > 0


def test_without_a_wormhole_the_key_side_says_that_it_has_no_effect():
    systems = {"speck": {**SPECK, "look": {"draw": "point", "side": "far"}}}
    assert "systems.speck.look.side has no effect" in silent_parts(preset(wormhole=None, systems=systems))[0]
    assert silent_parts(preset(systems=systems)) == []


@pytest.mark.parametrize(
    "change, words",
    [
        ({"camera": {"position": [0, 0, 8], "height": 4}}, "perspective camera"),
        ({"ground": "grey"}, "not of surfaces"),
        ({"wormhole": {"radius": 0}}, "radius"),
        ({"wormhole": {"radius": 1, "axis": [0, 0, 0]}}, "axis"),
        ({"wormhole": {"radius": 1, "sky": {"sun": 20}}}, "no sun"),
        ({"sky": {"sun": 20}}, "no sun"),
        ({"wormhole": {"radius": 1, "camera": "behind"}}, "near"),
    ],
)
def test_what_cannot_be_drawn_is_one_sentence(change, words):
    with pytest.raises((PresetError, UsageError), match=words):
        picture((8, 6), **change)


def test_a_camera_from_python_with_parallel_rays_is_refused():
    sim = ga.Simulation(preset())
    with pytest.raises(UsageError, match="perspective camera"):
        ga.render_frame(sim, (8, 6), camera=Camera(height=3.0))


@pytest.mark.filterwarnings("ignore:systems.none has no emitters")
@pytest.mark.parametrize("size", [(1, 1), (7, 5)])
@pytest.mark.parametrize("position", [[0, 0, 0], [2, 0, 0], [0, 0, -1e-9], [1e6, 0, 0], [1.999, 0, 1e-7]])
def test_strange_places_give_numbers(size, position):
    systems = {"speck": speck([0, 0, 0]), "camera": speck(position), "none": {**SPECK, "emitters": {}}}
    got = picture(size, camera={**CAMERA, "position": position, "target": [0.1, 0.2, -3]}, systems=systems)
    assert np.isfinite(got).all() and np.all(got[..., 3] == 1.0)


def test_a_transparent_picture_keeps_its_alpha_and_its_bent_particles():
    systems = {"speck": SPECK, "one": speck([0.6, 0.0, -6.0])}
    got = picture(transparent=True, systems=systems)
    with_sky = picture(systems=systems, sky=None, wormhole={"radius": 2})
    assert got[..., 3].max() < 1.0 and np.array_equal(got[..., :3], with_sky[..., :3]) and got[..., 0].max() > 0.0


def test_a_film_shows_the_still_of_its_moment():
    path = [{"time": 0, "position": [0.4, 0, 1.0]}, {"time": 1, "position": [0, 0, -1.0]}]
    more = {"camera": {**CAMERA, "target": [0, 1, -9], "path": path, "supersample": 2}}
    systems = {"speck": SPECK, "one": speck([0.5, 0.2, -1.0], side="through", trail=0.2)}
    film = Playback(preset(systems=systems, **more), (48, 27), "f32", None)
    steps = [film.step_of(k / 30) for k in range(25)]
    frames = [np.array(frame) for frame, _ in film.pictures(steps)]
    assert np.array_equal(frames[24], picture((48, 27), 24 / 30, systems=systems, **more))


def test_a_still_is_written_with_both_skies(tmp_path):
    (path,) = still(preset(), tmp_path / "one.exr", 0.0, size=(32, 18))
    assert path.stat().st_size > 0 and hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize("side", ["near", "far"])
def test_far_from_the_throat_each_side_has_its_own_sky(side):
    """120 radii away, seen away from the throat, the rest of the bend is (a / r)^2 of a radian, 1e-4.

    The axis is the sky's, so a mutant that does not turn the other side's axis, of the sky's light or of its stars, fails.
    """
    sky = {"gradient": ["red", "black", "blue", "white"], "stars": {"magnitude": 4, "intensity": 50, "seed": 2}}
    skies = {side: sky, ({"near", "far"} - {side}).pop(): {"color": "#004000"}}
    wormhole = {"radius": 0.5, "axis": [0, 1, 0], "camera": side, "sky": skies["far"]}
    camera = {**CAMERA, "position": [0, 0, 60], "target": [5, 20, 90], "fov": 70}
    got = picture(sky=skies["near"], wormhole=wormhole, camera=camera)
    plain = picture(sky=sky, wormhole=None, camera=camera)
    assert got.sum() == pytest.approx(plain.sum(), rel=1e-3)
    assert np.abs(got - plain).mean() < 2e-3 * plain.mean()
    assert np.abs(got - plain[::-1]).mean() > 0.1 * plain.mean()
