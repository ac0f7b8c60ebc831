"""What a frame needs of the time before it: subframes, ribbons, supersampling; always the same, whatever was asked for first."""

import numpy as np
import pytest

from gen_art.errors import UsageError
from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset

SIZE = (160, 90)


def orbits(look: dict, *, subframes=1, shutter=180.0, supersample=1, step="1/800", stiffness=(2 * np.pi) ** 2, **more):
    """Five bodies that swing about the origin once a second, the k-th at radius 0.4 + 0.3 k."""
    return load_preset(
        {
            "name": "orbits", "version": 1,
            "clock": {"duration": 1, "fps": 10, "step": step, "preroll": 0.1},
            "systems": {
                "bodies": {
                    "forces": {"spring": {"center": [0, 0, 0], "stiffness": stiffness}},
                    "particle": {"mass": 1.0},
                    "integrator": "leapfrog",
                    "emitters": {
                        f"e{k}": {"count": 1, "shape": {"point": [0.4 + 0.3 * k, 0, 0]},
                                  "velocity": {"constant": [0, 2 * np.pi * (0.4 + 0.3 * k), 0]}}
                        for k in range(5)
                    },
                    "look": look,
                }
            },
            "camera": {"height": 4, "shutter": shutter, "subframes": subframes, "supersample": supersample},
            **more,
        }
    )  # fmt: skip


def frame(preset, k: int = 3, size=SIZE) -> np.ndarray:
    clock = preset.clock
    return np.array(Playback(preset, size, "f32", None).picture(clock.preroll_steps + k * clock.steps_per_frame))


STREAK = {"draw": "streak", "width": 0.1, "emission": {"intensity": 1}}
DISC = {"draw": "disc", "radius": 0.05, "emission": {"intensity": 1}}


def test_streaks_and_subframes_agree_in_the_limit():
    """Of bodies that fly straight on, 23 to 150 pixels while the shutter is open."""
    large, fine = (640, 360), {"shutter": 90, "step": "1/3200", "stiffness": 0.0}
    streaks = frame(orbits(STREAK, **fine), size=large)[..., 0]
    errors = []
    for n in (1, 8, 80):
        many = frame(orbits(DISC, subframes=n, **fine), size=large)[..., 0]
        assert many.sum() == pytest.approx(streaks.sum(), rel=1e-4), "the light is the same"
        errors.append(np.abs(many - streaks).sum() / streaks.sum())
    assert errors[0] > 1.0 > 0.4 > errors[1] > errors[2] and errors[2] < 0.06, errors


def test_streaks_follow_the_curve():
    """One streak and twenty short ones lie on the circle; a straight one, a mutant without a past, does not."""
    y, x = np.mgrid[:360, :640] + 0.5
    radius, thin = np.hypot(x - 320, 180 - y) * 4 / 360, {**STREAK, "width": 0.02}

    def off(preset, straight=False):
        play = Playback(preset, (640, 360), "f32", None)
        if straight:
            play._path_steps = {}
        picture = play.picture(preset.clock.preroll_steps + 3 * preset.clock.steps_per_frame)[..., 0]
        outermost = radius > 1.45
        return (picture * np.abs(radius - 1.6))[outermost].sum() / picture[outermost].sum()

    whole = orbits(thin, shutter=360)
    assert off(whole) < 1.1 * off(orbits(thin, shutter=360, subframes=20)) < 0.3 * off(whole, straight=True)


@pytest.mark.parametrize("look", [STREAK, DISC, {"draw": "point"}, {"draw": "sphere", "radius": 0.08}])
def test_twice_the_size_averaged_is_the_picture(look):
    one, two = frame(orbits(look)), frame(orbits(look, supersample=2))
    assert two.shape == one.shape
    assert two.sum(dtype=float) == pytest.approx(one.sum(dtype=float), rel=1e-5)
    larger = frame(orbits(look), size=(320, 180)).reshape(90, 2, 160, 2, 4).mean(axis=(1, 3))
    assert np.abs(two - larger).max() < 1e-6 * larger.max(), "it is the picture of twice the size, averaged"


def test_supersampling_does_not_move_the_picture():
    look = {"draw": "disc", "radius": 0.25}
    one, two = (frame(orbits(look, supersample=n), size=(320, 180)) for n in (1, 2))
    assert np.abs(one - two).sum() < 0.01 * one.sum()


def test_too_large_a_drawing_is_refused():
    with pytest.raises(UsageError, match="16384"):
        Playback(orbits(DISC, supersample=8), (4096, 100), "f32", None)


RIBBON = {"draw": "streak", "width": 0.1, "emission": {"intensity": 1}, "ribbon": {"length": 0.25, "points": 20}}


def test_a_ribbon_is_the_path_of_the_last_moments():
    """A quarter of a turn: it lies on the circle, behind the body, narrower and fainter towards its end."""
    picture = frame(orbits(RIBBON), k=9)[..., 0]
    y, x = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    radius, angle = np.hypot(x - 80, 45 - y) * 4 / 90, np.degrees(np.arctan2(45 - y, x - 80))
    head = 360 * (1.0 % 1.0)  # frame 9 is at 0.1 + 0.9 s: a whole turn
    behind = (head - angle) % 360
    ring = np.abs(radius - 1.6) < 0.1
    lit = lambda low, high: picture[ring & (behind > low) & (behind < high)].sum()  # noqa: E731
    assert lit(5, 20) > 1.5 * lit(40, 55) > 2.5 * lit(75, 90) > 0
    assert lit(100, 350) < 0.01 * lit(0, 90), "nothing ahead of the body, nor older than the ribbon is long"
    off_the_rings = np.min([np.abs(radius - 0.4 - 0.3 * k) for k in range(5)], axis=0) > 0.12
    assert picture[off_the_rings].sum() < 0.01 * picture.sum()


def test_a_ribbon_is_as_bright_as_the_look_says_at_any_speed():
    ribbon = {**RIBBON, "ribbon": {"length": 0.1, "points": 20, "taper": 1, "tail": 1}}
    picture = frame(orbits(ribbon), k=9, size=(1600, 900))[..., 0]
    for k in range(5):  # 10 degrees behind each body
        radius = (0.4 + 0.3 * k) * 900 / 4
        column, row = 800 + radius * np.cos(np.radians(-10)), 450 - radius * np.sin(np.radians(-10))
        assert picture[int(row) - 3 : int(row) + 4, int(column) - 3 : int(column) + 4].max() == pytest.approx(
            1, rel=0.03
        )


@pytest.mark.parametrize(
    "preset",
    [
        orbits(RIBBON),
        orbits(DISC, subframes=4),
        orbits({**STREAK, "trail": {"half_life": 0.05, "substeps": 4}}, subframes=2),
    ],
    ids=["ribbon", "subframes", "trail"],
)
def test_a_frame_is_the_same_whichever_came_before(preset):
    clock = preset.clock
    step = lambda k: clock.preroll_steps + k * clock.steps_per_frame  # noqa: E731
    film = Playback(preset, SIZE, "f32", None)
    pictures = [np.array(film.picture(step(k))) for k in range(6)]
    for k in (0, 5):
        assert np.array_equal(pictures[k], frame(preset, k))
    assert pictures[5].any()


def test_layers_hold_depth_and_motion():
    """A body that flies past at a known distance and speed, seen by a camera that pans."""
    preset = load_preset(
        {
            "name": "flyby", "version": 1, "clock": {"duration": 1, "fps": 10, "step": 0.05},
            "systems": {
                "near": {"emitters": {"a": {"count": 1, "shape": {"point": [0, 0, 2]}, "velocity": {"constant": [3, -1, 0]}}},
                         "look": {"draw": "disc", "radius": 0.3}},
                "far": {"emitters": {"a": {"count": 1, "shape": {"point": [-2, 1, -4]}}},
                        "look": {"draw": "disc", "blend": "alpha", "opacity": 3, "albedo": "black", "radius": 0.5}},
            },
            "camera": {"position": [0, 0, 10], "target": [0, 0, 0], "fov": 40},
        }
    )  # fmt: skip
    run = Playback(preset, SIZE, "f32", None)
    run.picture(4)  # film time 0.2
    layers = run.aovs()
    scale = 45 / np.tan(np.radians(20))

    def at(x, y, depth):
        return int(45 - y * scale / depth), int(80 + x * scale / depth)

    near, far = at(0.6, -0.2, 8), at(-2, 1, 14)
    assert layers["Z"][near] == pytest.approx(8, rel=1e-4) and layers["Z"][far] == pytest.approx(14, rel=1e-4)
    assert layers["velocity.x"][near] == pytest.approx(0.3 * scale / 8, rel=1e-3)
    assert layers["velocity.y"][near] == pytest.approx(0.1 * scale / 8, rel=1e-3), "rows go down"
    assert layers["velocity.x"][far] == pytest.approx(0, abs=1e-4)
    assert layers["Z"][0, 0] == 0 and {v.shape for v in layers.values()} == {(90, 160)}


def test_colour_by_acceleration():
    """On a circle it is (2 pi)^2 times the radius, from the first frame on."""
    look = {**DISC, "emission": {"intensity": {"by": "acceleration", "range": "0..80", "curve": [[0, 0], [1, 8]]}}}
    preset = orbits(look, clock={"duration": 1, "fps": 10, "step": "1/800"})
    for k in (0, 2):
        bright, plain = (
            frame(p, k, (640, 360))[..., 0]
            for p in (preset, orbits(DISC, clock={"duration": 1, "fps": 10, "step": "1/800"}))
        )
        for body in range(5):
            radius = 0.4 + 0.3 * body
            angle = 2 * np.pi * k / 10
            row, column = int(180 - radius * np.sin(angle) * 90), int(320 + radius * np.cos(angle) * 90)
            around = slice(row - 8, row + 9), slice(column - 8, column + 9)
            assert bright[around].sum() / plain[around].sum() == pytest.approx((2 * np.pi) ** 2 * radius / 10, rel=0.02)


def flash(dark: float, bright: float, **develop):
    """A light that changes at film time 0.26 s."""
    curve = {"by": "seconds", "range": "0..1", "curve": [[0, dark], [0.36, dark], [0.361, bright], [1, bright]]}
    return orbits({"draw": "disc", "radius": 0.3, "emission": {"intensity": curve}}, develop=develop)


def test_automatic_exposure_follows_the_light_and_is_the_same_whichever_frames_are_made():
    """One half-life of 0.2 s is two frames; a frame is exposed by itself and the six before it."""
    auto = {"key": 0.18, "half_life": 0.2, "range": "-12..12"}

    def stops(preset, frames):
        clock = preset.clock
        steps = [clock.preroll_steps + k * clock.steps_per_frame for k in frames]
        return [exposure for _, exposure in Playback(preset, SIZE, "f32", None).pictures(steps)]

    everyone = stops(flash(0.1, 8.0, auto_exposure=auto), range(10))
    steady = stops(flash(0.1, 0.1, auto_exposure=auto), range(10))
    change, weights = np.log2(80.0), 2.0 ** (-np.arange(7) / 2)
    assert everyone[:3] == steady[:3]
    assert everyone[9] == pytest.approx(steady[9] - change, abs=1e-3), "all the way within three half-lives"
    assert everyone[4] == pytest.approx(steady[4] - change * weights[:2].sum() / weights[:5].sum(), abs=1e-3)
    preset = flash(0.1, 8.0, auto_exposure=auto)
    for some in ([9], [3, 7], [4, 5, 6], [0, 9]):
        assert stops(preset, some) == [everyone[k] for k in some]


def test_what_is_written_has_its_exposure(tmp_path):
    from PIL import Image

    from gen_art.output import job

    def mean(**spec) -> float:
        preset = flash(8.0, 8.0, tone="none", bloom=0, exposure=-2, **spec)
        (path,) = job.still(preset, tmp_path / "a.png", 0.9, size=SIZE, overwrite=True)
        (frame,) = job.render(preset, tmp_path / "b_#.png", frames=9, size=SIZE, overwrite=True)
        assert np.array_equal(Image.open(path), Image.open(frame))
        return float(np.asarray(Image.open(path)).mean())

    dark, bright = (mean(auto_exposure={"key": key}) for key in (0.1, 0.4))
    assert 0 < dark < 0.7 * bright and mean() not in (dark, bright)


def test_a_ribbon_breaks_where_it_passes_the_side_of_a_periodic_box():
    """A particle that has just come in at the left: the ribbon is there and at the right, and nothing crosses the middle."""
    preset = load_preset({
        "version": 1, "clock": {"duration": 1, "fps": 20, "step": 0.01},
        "domain": {"periodic": {"min": [-1, -1, -1], "max": [1, 1, 1]}},
        "systems": {"s": {"emitters": {"one": {"count": 1, "shape": [0.5, 0, 0], "velocity": [2, 0, 0]}}, "look": RIBBON}},
        "camera": {"position": [0, 0, 5], "target": [0, 0, 0], "height": 2},
    })  # fmt: skip
    open_space = load_preset(preset, overrides={"domain": None})
    for given, sides in ((preset, True), (open_space, False)):
        playback = Playback(given, (200, 100), "f32", None)
        light = playback.picture(playback.step_of(0.35))[..., 0].sum(
            axis=0
        )  # 0.2 beyond the side; the ribbon is 0.5 long
        left, middle, right = light[:65].sum(), light[65:130].sum(), light[130:].sum()
        assert middle < 1e-3 * right  # the picture is 4 m wide: the box is from column 50 to 150
        assert (left > 0.1 * right) == sides
