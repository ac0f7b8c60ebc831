"""The sky under the picture: its table, gradients, the formula of compositing, the sun's disc, and what must not change."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.errors import PresetError, UsageError
from gen_art.output.job import still
from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.preset.sky import Sky, Sun
from gen_art.preset.verdicts import key
from gen_art.renderer import sky_table
from gen_art.renderer.camera import Camera
from gen_art.renderer.colour import linear
from gen_art.renderer.painter import Painter
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.surfaces.scene import Scene
from tests.render.particles import scene, state

SIZE = (160, 90)
CAMERA = Camera(position=(0, 0, 6), target=(0, 0.5, 0), fov=50)
ROOT = Path(__file__).parents[2]


def paint(sky, camera=CAMERA, size=SIZE, look=None, supersample=1, transparent=False, **systems):
    surroundings = Scene(dome=None if sky is None else SkyDome.of(sky))
    painter = Painter(size, camera, dict.fromkeys(systems, look), 0.0, supersample, surroundings, transparent)
    return np.array(painter.paint(scene(1.0, **systems), 0.0))


def directions(camera, size) -> np.ndarray:
    """(height, width, 3), through the middles of the pixels, 1 along the line of sight."""
    view = camera.at(0.0)
    scale = 0.5 * size[1] / math.tan(math.radians(view.fov) / 2)
    x, y = (np.arange(size[0]) + 0.5 - 0.5 * size[0]) / scale, (0.5 * size[1] - np.arange(size[1]) - 0.5) / scale
    return view.axes[2] + x[None, :, None] * view.axes[0] + y[:, None, None] * view.axes[1]


def solid_angles(camera, size) -> np.ndarray:
    scale = 0.5 * size[1] / math.tan(math.radians(camera.at(0.0).fov) / 2)
    return np.linalg.norm(directions(camera, size), axis=2) ** -3 / scale**2


# the table


def test_the_table_is_read_where_it_was_written():
    """A table of row and column numbers gives back the number of the place, at entries and halfway between."""
    rows, columns = np.meshgrid(np.arange(sky_table.ROWS), np.arange(sky_table.COLUMNS), indexing="ij")
    table = np.stack([rows, columns, 0 * rows], axis=-1).astype(float)
    e, a = sky_table.elevations()[1:-1:7], sky_table.azimuths()[:-1:11]
    x, z = np.sin(a) * np.cos(e)[:, None], -np.cos(a) * np.cos(e)[:, None]
    for sign, row in (
        (1.0, sky_table.HALF + np.arange(sky_table.HALF)),
        (-1.0, sky_table.HALF - 1 - np.arange(sky_table.HALF)),
    ):
        d = np.stack(np.broadcast_arrays(x, sign * np.sin(e)[:, None], z), axis=-1).reshape(-1, 3)
        got = sky_table.look_up(table, 3.7 * d).reshape(len(e), len(a), 3)
        assert got[..., 0] == pytest.approx(np.broadcast_to(row[1:-1:7, None], got.shape[:2]), abs=1e-6)
        assert got[..., 1] == pytest.approx(
            np.broadcast_to(np.arange(sky_table.COLUMNS)[:-1:11], got.shape[:2]), abs=1e-6
        )


@pytest.mark.parametrize(
    "direction", [[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1e-30, -1]]
)
def test_poles_and_axes_are_finite(direction):
    light = SkyDome.of(Sky(sun=20)).radiance([direction])
    assert np.isfinite(light).all() and np.all(light >= 0)


def test_the_kernel_reads_the_table_as_numpy_does():
    """Off the horizon light is interpolated over 0.005 rad, which costs 0.005^2 / 8 of the second derivative, at most 60 times
    the light (at the sun), and a quarter of the change of slope at the table's lines, 0.02 rad apart: 0.2% in all."""
    sky = Sky(sun=Sun(height=15, azimuth=8, disc=0.0))
    camera = Camera(position=(0, 0, 6), target=(1, 0.9, 0), fov=60, roll=5)
    expected = SkyDome.of(sky).radiance(directions(camera, SIZE).reshape(-1, 3)).reshape(*SIZE[::-1], 3)
    picture = paint(sky, camera)
    off = np.abs(directions(camera, SIZE)[..., 1]) > 1.5 * 2.0 * math.tan(math.radians(30)) / SIZE[1]
    assert off.mean() > 0.9
    assert picture[off][:, :3] == pytest.approx(expected[off], rel=2e-3)
    assert np.all(picture[..., 3] == 1.0)


def test_the_horizon_is_smooth_where_the_camera_is_tilted():
    """Along a column each pixel holds the share of black and white that its height above the horizon says."""
    table = np.zeros((sky_table.ROWS, 2, 3), np.float32)
    table[sky_table.HALF :] = 1.0
    camera = Camera(position=(0, 0, 6), target=(0, 0, 0), fov=30, roll=4)
    painter = Painter((200, 60), camera, scene=Scene(dome=replace(SkyDome.of(Sky(color="black")), table=table)))
    picture = painter.paint(scene(1.0), 0.0)[..., 0]
    y = directions(camera, (200, 60))[..., 1] * 30 / math.tan(math.radians(15))  # in pixels from the horizon
    assert np.all(picture[y > 0.8] > 0.99) and np.all(picture[y < -0.8] < 0.01)
    # the area of a pixel above a line at 4 degrees through it differs from the height above it by 0.02 at most
    near = np.abs(y) < 0.4
    assert picture[near] == pytest.approx(0.5 + y[near] / math.cos(math.radians(4)), abs=0.03)


# gradients and colours


def test_a_gradient_shows_its_colours_at_nadir_horizon_and_zenith():
    dome = SkyDome.of(Sky(gradient=["#102030", "#ffcc88", "#2255ff"]))
    got = dome.radiance([[0, -1, 0], [0, 0.0, -1], [1, 0, 0], [0, 1, 0]])
    assert got == pytest.approx(np.array([linear(c) for c in ("#102030", "#ffcc88", "#ffcc88", "#2255ff")]), abs=1e-6)


def test_a_gradient_goes_by_the_angle():
    """Black to white in OKLab is the cube of the position; between the table's rows (1.3 degrees) it is linear."""
    dome = SkyDome.of(Sky(gradient=["black", "white"]))
    for degrees in (-60, -10, 10, 45, 70):
        e = math.radians(degrees)
        assert dome.radiance([[math.cos(e), math.sin(e), 0]])[0] == pytest.approx(
            [(0.5 + degrees / 180) ** 3] * 3, abs=2e-4
        )


@pytest.mark.parametrize("sky", [Sky(color="#88aaff"), Sky.model_validate("paper")])
def test_an_even_sky_is_even_in_every_direction(sky):
    d = np.random.default_rng(1).normal(size=(500, 3))
    expected = linear(sky.color).astype(np.float32)
    assert np.all(SkyDome.of(sky).radiance(d) == expected)
    assert np.all(paint(sky, Camera(position=(0, 0, 6), fov=120, roll=30))[..., :3] == expected)


def test_intensity_is_a_factor():
    for sky in ({"sun": 30}, {"gradient": ["black", "white"]}, {"color": "red"}):
        one, three = (SkyDome.of(Sky(**sky, intensity=i)) for i in (1.0, 3.0))
        assert three.table == pytest.approx(3.0 * one.table, rel=1e-6)
        assert three.sun_irradiance == pytest.approx(3.0 * one.sun_irradiance)
        assert three.disc == pytest.approx(3.0 * one.disc, rel=1e-6)


def test_an_orthographic_camera_sees_the_sky_by_its_fov():
    flat, deep = (Camera(position=(0, 0, 6), target=(0, 1, 0), fov=50, **more) for more in ({"height": 4.0}, {}))
    assert np.array_equal(paint(Sky(sun=20), flat), paint(Sky(sun=20), deep))


# under the picture


@pytest.mark.parametrize("sky", [Sky(sun=12), Sky(stars=True), Sky.model_validate("studio")])
@pytest.mark.parametrize(
    "look",
    [
        Look(draw="disc", radius=1.0, blend="alpha", opacity=0.7, emission={"color": "red", "intensity": 0.4}),
        Look(draw="sphere", radius=1.0, blend="opaque", albedo="black"),
        Look(draw="disc", radius=1.0, emission={"color": "gold"}),
    ],
)
def test_the_sky_is_composited_under_the_film(sky, look):
    """light + (1 - alpha) sky, alpha 1; three roundings of float32."""
    balls = {"balls": state([[0, 0.6, 0], [0.9, 0.2, -1.0]], radius=1.0)}
    film, alone = paint(sky, look=look, transparent=True, **balls), paint(sky)
    both = paint(sky, look=look, **balls)
    expected = film[..., :3] + np.maximum(1.0 - film[..., 3:], 0.0) * alone[..., :3]
    error = 4 * 2.0**-24 * (np.abs(film[..., :3]) + np.abs(alone[..., :3]))
    assert np.all(np.abs(both[..., :3] - expected) <= error + 1e-30)
    assert np.all(both[..., 3] == 1.0)
    if look.blend != "add":
        assert film[..., 3].max() > 0.3, "something hides the sky"


def test_without_a_sky_the_alpha_stays():
    assert np.all(paint(None) == 0.0)


def test_supersampled_it_is_the_same_sky():
    """The mean of four samples a pixel differs by the curvature over a pixel, below a hundredth off the horizon."""
    sky = Sky(sun=Sun(height=30, disc=0.0))
    one, four = paint(sky), paint(sky, supersample=2)
    off = np.abs(directions(CAMERA, SIZE)[..., 1]) > 0.05
    assert four[off] == pytest.approx(one[off], rel=0.01)


# the sun's disc


@pytest.mark.parametrize("fov, rows", [(8.0, 90), (40.0, 90), (90.0, 90), (40.0, 300)])
@pytest.mark.parametrize("turn", [0.0, 0.13, 0.31])
def test_the_disc_has_the_light_of_the_sun_wherever_it_is_between_pixels(fov, rows, turn):
    """The samples at the rim, a twelfth of the disc (a seventh of the smallest), are taken for their middle: there (1 - u^2)^0.23
    differs by 5% from its mean and is half of the disc's, so 0.2 to 0.4% in all."""
    size = (rows * 4 // 3, rows)
    sun = Sun(height=20 + turn / 3, azimuth=turn)
    camera = Camera(
        position=(0, 0, 0), target=(0, math.sin(math.radians(20)), -math.cos(math.radians(20))), fov=fov, near=1e-3
    )
    with_disc, without = (
        paint(Sky(sun=s), camera, size).astype(float) for s in (sun, sun.model_copy(update={"disc": 0.0}))
    )
    energy = ((with_disc - without)[..., :3] * solid_angles(camera, size)[..., None]).sum(axis=(0, 1))
    assert energy == pytest.approx(SkyDome.of(Sky(sun=sun)).sun_irradiance, rel=5e-3)


def test_the_disc_is_darker_at_its_limb_and_darker_still_in_blue():
    sun = Sun(height=60)
    camera = Camera(position=(0, 0, 0), target=(0, math.sin(math.radians(60)), -0.5), fov=1.0, near=1e-3)
    sky, bare = (paint(Sky(sun=s), camera, (200, 200)) for s in (sun, sun.model_copy(update={"disc": 0.0})))
    disc = (sky - bare)[100, :, :3]
    radius = 100 * 0.267 / 0.5
    middle, limb = disc[100], disc[100 + int(0.9 * radius)]
    u = (int(0.9 * radius) + 0.5) / radius
    for c, a in enumerate((0.292 / 0.611 - 0.023, 0.292 / 0.549 - 0.023, 0.292 / 0.465 - 0.023)):
        assert limb[c] / middle[c] == pytest.approx((1 - u * u) ** (a / 2), rel=0.01)
    assert disc[int(100 + radius + 3)].max() == 0.0


def test_the_horizon_cuts_the_disc_and_hides_it_below():
    def lit(height):
        dome = SkyDome.of(Sky(sun=height))
        return (dome.disc[:, 0] > 0).mean()

    assert lit(0.3) == 1.0 and lit(0.0) == pytest.approx(0.5, abs=0.04) and lit(-0.3) == 0.0
    assert not SkyDome.of(Sky(sun=-2)).sun_irradiance.any()


# what must not change


PIECE = """version: 1
seed: 3
clock: {{duration: 1, fps: 10, step: 1/20}}
forces: {{gravity: [0, -1, 0]}}
systems:
  a:
    emitters: {{e: {{count: 200, shape: {{ball: 1}}}}}}
    look: {{draw: disc, radius: 0.4, blend: alpha, opacity: 0.5, emission: {{color: red}}}}
camera: {{position: [0, 0.4, 6], size: [96, 54]}}
{sky}
"""


def piece(tmp_path, sky=""):
    path = tmp_path / "piece.yaml"
    path.write_text(PIECE.format(sky=sky and f"sky: {sky}"), encoding="utf-8")
    return load_preset(path)


def test_a_sky_changes_neither_the_motion_nor_its_verdict(tmp_path):
    plain, under = piece(tmp_path), piece(tmp_path, "{sun: 20, stars: true}")
    digests = set()
    for preset in (plain, under):
        sim = ga.Simulation(preset)
        sim.step(10)
        digests.add(sim.digest())
    assert len(digests) == 1
    assert key(plain, "1") == key(under, "1")


def test_transparent_pictures_have_no_sky_and_keep_their_alpha(tmp_path):
    for name, sky in (("plain", ""), ("under", "{sun: 20, stars: true}")):
        still(piece(tmp_path, sky), tmp_path / f"{name}.png", 0.5, transparent=True)
    plain, under = (np.asarray(Image.open(tmp_path / f"{name}.png")) for name in ("plain", "under"))
    assert plain.shape[2] == 4 and 0 < np.mean(plain[..., 3] > 0) < 1
    # in the sky's light the spheres are balls, whose edges are drawn another way
    assert under[..., 3].mean() == pytest.approx(plain[..., 3].mean(), rel=0.05)
    assert under[0, 0].max() <= 1  # dither
    still(piece(tmp_path, "paper"), tmp_path / "opaque.png", 0.5)
    assert np.asarray(Image.open(tmp_path / "opaque.png"))[0, 0].min() > 150


def test_frames_stills_and_trails_show_the_preset_s_sky(tmp_path):
    preset = piece(tmp_path, "'#88aaff'")
    sim = ga.Simulation(preset)
    sim.step(5)
    frame = ga.render_frame(sim, (96, 54))
    assert np.array_equal(frame, Playback(preset, (96, 54), "f32", None).picture(5))
    assert frame[0, 0] == pytest.approx([*linear("#88aaff"), 1.0], rel=1e-6)
    assert ga.render_frame(sim, (96, 54), sky=ga.Sky(color="black"))[0, 0] == pytest.approx([0, 0, 0, 1.0])
    with pytest.raises(UsageError, match=r"sky must be a ga\.Sky"):
        ga.render_frame(sim, (96, 54), sky="paper")
    trailing = load_preset(preset, overrides={"systems.a.look": {"draw": "point", "trail": 0.4}, "camera.subframes": 2})
    picture = Playback(trailing, (96, 54), "f32", None).picture(6)
    assert picture[0, 0] == pytest.approx([*linear("#88aaff"), 1.0], rel=1e-6)
    assert picture[..., 0].max() > 1.02 * linear("#88aaff")[0], "the trail over it"


# the key


@pytest.mark.parametrize(
    "sky, place, says",
    [
        ("{sun: 200}", "sky.sun", "from -6 to 90, not 200"),
        ("{sun: -7}", "sky.sun", "from -6 to 90, not -7"),
        ("{sun: {azimuth: 3}}", "sky.sun", "'height' is missing"),
        ("{sun: noon}", "sky.sun", "must be a number, not 'noon'"),
        ("{sun: {height: 3, disk: 1}}", "sky.sun.disk", "did you mean 'disc'"),
        ("studoi", "sky", "did you mean 'studio'"),
        ("qqq", "sky", "no sky named 'qqq'; write studio, paper, night, a colour or a palette"),
        ("12", "sky", "must be a mapping of keys, not 12"),
        ("{}", "sky", "needs one of sun, gradient, color, stars, band and softboxes"),
        ("{gradient: [red]}", "sky.gradient", "needs two colours or more"),
        ("{gradient: red}", "sky.gradient", "needs two colours or more"),
        ("{gradient: [[0.5, red], [0.2, blue]]}", "sky.gradient", "positions must increase"),
        ("{color: reddish}", "sky.color", "no colour named 'reddish'"),
        ("{stars: -1}", "sky.stars", "from 0 to 9, not -1"),
        ("{stars: {seed: -1}}", "sky.stars.seed", "at least 0"),
        ("{stars: false}", "sky", "needs one of"),
        ("{sun: 3, color: red}", "sky", "give one of sun, gradient and color, not sun and color"),
        ("{color: red, haze: 2}", "sky", "`haze` is of the air"),
        ("{sun: 3, haze: -1}", "sky.haze", "from 0 to 30, not -1"),
        ("{sun: 3, intensity: .inf}", "sky.intensity", "inf"),
        ("{moon: 3}", "sky.moon", "unknown key"),
    ],
)
def test_what_is_wrong_is_a_sentence_with_its_place(tmp_path, sky, place, says):
    with pytest.raises(PresetError) as caught:
        piece(tmp_path, sky)
    text = str(caught.value)
    assert "piece.yaml:10:" in text and f" {place}: " in text, text
    assert says in text, text


@pytest.mark.parametrize(
    "short, long",
    [
        ("{sun: 12}", Sky(sun=Sun(height=12))),
        ("{stars: true}", Sky(stars={})),
        ("night", Sky(stars={"magnitude": 6.5})),
        ("{stars: 5}", Sky(stars={"magnitude": 5})),
        ("'#88aaff'", Sky(color="#88aaff")),
        ("[0.1, 0.2, 0.3]", Sky(color=[0.1, 0.2, 0.3])),
        ("[black, white]", Sky(gradient=["black", "white"])),
    ],
)
def test_short_forms(tmp_path, short, long):
    assert piece(tmp_path, short).sky == long


def test_a_dome_is_made_once_and_its_arrays_are_not_written_to():
    one = SkyDome.of(Sky(sun=33))
    assert SkyDome.of(Sky(sun=33)) is one
    with pytest.raises(ValueError):
        one.table[0, 0, 0] = 1.0
    with pytest.raises(UsageError, match=r"made of a ga\.Sky"):
        SkyDome.of({"sun": 33})
