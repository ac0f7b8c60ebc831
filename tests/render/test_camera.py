"""The camera: projection, paths, orbits, roll, and where a particle is projected."""

import numpy as np
import pytest

from gen_art.errors import PresetError, UsageError
from gen_art.preset.camera import CameraSpec
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.preset.reader import read_text
from gen_art.renderer.camera import Camera
from gen_art.renderer.camera_shake import shake_noise
from gen_art.renderer.painter import Painter
from tests.render.particles import scene, state

DOTS = """version: 1
clock: {duration: 1, fps: 30, step: 1/60}
systems: {dots: {particle: {lifetime: 1}, emitters: {a: {rate: 1}}}}
"""


def centroid(picture):
    weight = picture[..., 0].astype(np.float64)
    y, x = np.mgrid[: weight.shape[0], : weight.shape[1]] + 0.5
    return (weight * x).sum() / weight.sum(), (weight * y).sum() / weight.sum()


def test_perspective_is_the_tangent_and_rows_run_down():
    view = Camera(position=(0, 0, 5), fov=90).at(0)
    assert view.project([[0, 0, 0], [5, 0, 0], [0, 5, 0], [0, 2, 3]], (200, 100)) == pytest.approx(
        np.array([[100, 50, 5], [150, 50, 5], [100, 0, 5], [100, 0, 2]])
    )


def test_orthographic_by_height():
    view = Camera(position=(0, 0, 5), height=4.0).at(0)
    assert view.project([[1, 1, -7]], (200, 100))[0] == pytest.approx([125, 25, 12])


@pytest.mark.parametrize(
    "camera", [Camera(position=(2, 3, 9), target=(0, 1, 0), fov=50, roll=20), Camera(position=(3, 1, 4), height=3.0)]
)
@pytest.mark.parametrize("draw", ["point", "disc"])
def test_particles_land_where_they_are_projected_to_a_hundredth_of_a_pixel(camera, draw):
    for place in np.random.default_rng(4).uniform(-0.8, 0.8, (6, 3)):
        picture = Painter((320, 240), camera, {"a": Look(draw=draw)}).paint(
            scene(0.0, a=state([place], radius=0.02)), 0.0
        )
        assert centroid(picture) == pytest.approx(tuple(camera.at(0).project([place], (320, 240))[0, :2]), abs=0.01)


def test_what_is_behind_or_nearer_than_near_is_not_drawn():
    camera = Camera(position=(0, 0, 5), near=1.0, far=20.0)
    for z, seen in ((6.0, False), (4.5, False), (3.9, True), (-14.0, True), (-16.0, False)):
        picture = Painter((64, 64), camera, {"a": Look()}).paint(scene(0.0, a=state([[0, 0, z]])), 0.0)
        assert bool(picture.any()) == seen


def test_a_streak_through_the_camera_is_cut_at_near():
    camera = Camera(position=(0, 0, 5), near=1.0)
    look = {"a": Look(draw="streak", width=0.1)}
    picture = Painter((64, 64), camera, look, 1.0).paint(scene(1.0, a=state([[0.3, 0.2, 3.0]], [[0.5, 0, -8]])), 0.0)
    assert np.isfinite(picture).all() and picture.any()


def test_paths_pass_through_their_stops_and_rest_outside_them():
    stops = [
        {"time": 0, "position": [0, 0, 10]},
        {"time": 2, "position": [4, 0, 6], "fov": 60},
        {"time": 3, "roll": 90},
    ]
    for easing in ("linear", "smooth", "spline"):
        camera = Camera.from_spec(CameraSpec(path=stops, easing=easing, fov=40))
        assert camera.at(2).position == pytest.approx([4, 0, 6])
        assert camera.at(-5).position == pytest.approx([0, 0, 10]) == camera.at(0).position
        assert camera.at(9).position == pytest.approx([4, 0, 6])
        assert camera.at(2).fov == pytest.approx(60)
    speed = [np.linalg.norm(camera.at(t + 1e-4).position - camera.at(t).position) for t in (0.999, 1.0, 1.001)]
    assert max(speed) / min(speed) < 1.01, "a spline has no corners"
    assert Camera.from_spec(CameraSpec(path=stops, easing="linear")).at(1).position == pytest.approx([2, 0, 8])


def test_orbits_keep_their_distance():
    camera = Camera.from_spec(CameraSpec(position=(0, 1, 10), orbit=90))
    assert camera.at(1).position == pytest.approx([10, 1, 0])
    assert camera.at(4).position == pytest.approx([0, 1, 10])


def test_roll_turns_the_picture_clockwise():
    view = Camera(position=(0, 0, 5), height=10.0, roll=90).at(0)
    x, y, _ = view.project([[0, 1, 0]], (100, 100))[0]
    assert (x, y) == pytest.approx((60, 50)), "what was up is right"


def test_looking_along_up_is_allowed():
    axes = Camera(position=(0, 9, 0)).at(0).axes
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [{"position": (0, 0, 0)}, {"fov": 0}, {"fov": 180}, {"height": -1}, {"up": (0, 1)}, {"position": (np.nan, 0, 1)}],
)
def test_cameras_that_see_nothing_are_refused(wrong):
    with pytest.raises(UsageError):
        Camera(**wrong)


def test_a_camera_frames_the_particles():
    for centre, spread in ((0, 1), (1000, 0.01), (-3, 50)):
        points = np.random.default_rng(3).normal(centre, spread, (1000, 3))
        seen = Camera.framing(points, 16 / 9).at(0).project(points, (1600, 900))
        inside = (seen[:, 0] > 0) & (seen[:, 0] < 1600) & (seen[:, 1] > 0) & (seen[:, 1] < 900) & (seen[:, 2] > 0)
        assert inside.mean() > 0.95
        assert np.ptp(seen[:, 1]) > 300, "and they fill a good part of it"
    assert Camera.framing(np.zeros((0, 3))) and Camera.framing([[1, 2, 3]])


def test_words_of_easing_say_how_the_way_between_two_stops_is_gone():
    half = {"linear": 2.0, "smooth": 2.0, "spline": 2.0, "accelerate": 1.0, "brake": 3.0, "hold": 0.0}
    start = {"linear": 1.0, "smooth": 0.0, "spline": 1.0, "accelerate": 0.0, "brake": 2.0, "hold": 0.0}
    for word, middle in half.items():
        path = [{"time": 1, "target": [0, 0, 0]}, {"time": 3, "target": [4, 0, 0]}]
        camera = Camera.from_spec(CameraSpec(position=(0, 0, 9), path=path, easing=word))
        x = [camera.at(t).distance for t in (1.0, 1.0 + 1e-5, 2.0, 3.0)]
        moved = np.sqrt(np.maximum(np.square(x) - 81.0, 0.0))
        assert moved[2:] == pytest.approx([middle, 4.0], abs=1e-9), word
        assert moved[1] == pytest.approx(2e-5 * start[word], abs=3e-7), word


def test_a_stop_s_own_easing_goes_before_the_camera_s():
    stops = [{"time": 0, "easing": "hold"}, {"time": 1, "roll": 40}, {"time": 2, "roll": 80}]
    camera = Camera.from_spec(CameraSpec(path=stops, easing="linear"))
    rolls = [np.degrees(np.arctan2(-camera.at(t).axes[0, 1], camera.at(t).axes[0, 0])) for t in (0.9, 1.0, 1.5)]
    assert np.abs(rolls) == pytest.approx([0, 40, 60])


def test_a_zoom_changes_by_equal_factors_in_equal_times():
    path = [{"time": 0}, {"time": 2, "height": 0.04, "fov": 4}]
    flat = Camera.from_spec(CameraSpec(height=4.0, path=path, easing="linear"))
    assert [flat.at(t).height for t in (0, 1, 2)] == pytest.approx([4.0, 0.4, 0.04])
    deep = Camera.from_spec(CameraSpec(path=[path[0], {"time": 2, "fov": 4}], easing="linear"))
    scales = [deep.at(t).scale(100) for t in (0, 1, 2)]
    assert scales[1] / scales[0] == pytest.approx(scales[2] / scales[1])


def test_no_spline_widens_the_view_to_half_a_turn():
    path = [{"time": 0, "fov": 5}, {"time": 1, "fov": 169}, {"time": 2, "fov": 169}]
    camera = Camera.from_spec(CameraSpec(path=path))
    assert all(0 < camera.at(t).fov < 170 for t in np.linspace(0, 2, 41))


SHAKE = {"amplitude": 2.0, "frequency": 1.5, "roll": 0.5, "seed": 4}


def gaze(camera, times):
    """Pan and tilt in degrees at each time, of a camera that looks along -z."""
    forward = np.array([camera.at(t).axes[2] for t in times])
    return np.degrees(np.stack([np.arctan2(forward[:, 0], -forward[:, 2]), np.arcsin(forward[:, 1])], axis=1))


def test_shake_has_mean_0_and_its_amplitude_for_standard_deviation():
    times, camera = np.arange(0, 400, 0.1), Camera.from_spec(CameraSpec(shake=SHAKE))
    angles = gaze(camera, times)
    assert np.abs(angles.mean(axis=0)).max() < 0.03
    assert angles.std(axis=0) == pytest.approx([2.0, 2.0], rel=0.03)
    assert np.abs(np.corrcoef(angles.T)[0, 1]) < 0.1, "pan and tilt are apart"
    assert np.abs(angles).max() < 3.4 * 2.0
    up = np.array([camera.at(t).axes[0, 1] for t in times[:2000]])
    assert np.degrees(up).std() == pytest.approx(0.5, rel=0.1)


def test_shake_lies_between_half_and_twice_its_frequency():
    times = np.arange(4096) * 0.04
    spectrum = np.abs(np.fft.rfft(gaze(Camera.from_spec(CameraSpec(shake=SHAKE)), times)[:, 0] * np.hanning(4096))) ** 2
    f = np.fft.rfftfreq(4096, 0.04)
    assert spectrum[(f > 0.7) & (f < 3.1)].sum() > 0.995 * spectrum.sum()
    assert spectrum[f < 1.5].sum() > 2.0 * spectrum[f > 1.5].sum(), "and the slow parts are the wider ones"


def test_films_of_other_seeds_start_anywhere_in_the_movement():
    first = np.array([shake_noise(0.0, 1.0, seed, 1)[0] for seed in range(400)])
    assert abs(first.mean()) < 0.15
    assert first.std() == pytest.approx(1.0, rel=0.1)


def test_shake_is_a_function_of_film_time_and_seed_alone():
    def at(t, **more):
        return Camera.from_spec(CameraSpec(shake={**SHAKE, **more})).at(t).axes.tobytes()

    forwards = [at(t) for t in (0.1, 0.2, 5.0)]
    assert [at(t) for t in (5.0, 0.2, 0.1)] == forwards[::-1]
    assert at(0.1, seed=5) != forwards[0]
    small, large = (gaze(Camera.from_spec(CameraSpec(shake=a)), [0.7]) for a in (0.001, 0.002))
    assert large == pytest.approx(2 * small, rel=1e-4), "another amplitude is the same movement"
    still = Camera.from_spec(CameraSpec(shake=0)).at(0.7)
    assert np.array_equal(still.axes, Camera().at(0.7).axes)


def test_shake_moves_an_orthographic_picture_as_it_moves_a_perspective_one():
    spec = {"position": (0, 0, 50), "shake": {"amplitude": 1.0, "roll": 0.0, "seed": 2}}
    deep, flat = CameraSpec(**spec, fov=40), CameraSpec(**spec, height=4.0, fov=40)
    for t in (0.3, 1.7):
        a, b = (Camera.from_spec(s).at(t) for s in (deep, flat))
        at = [v.project([[0, 0, 0]], (160, 90))[0, :2] for v in (a, b)]
        assert at[0] == pytest.approx(at[1], abs=0.05)
        assert np.abs(at[0] - (80, 45)).max() > 0.5
        assert b.axes[2] == pytest.approx([0, 0, -1]), "which is why planes seen edge-on stay so"


def test_a_lens_focuses_on_the_target_unless_told_and_can_rack():
    assert Camera().at(0).lens is None
    assert Camera(position=(0, 3, 4), lens=(0.1, None)).at(0).lens == pytest.approx((0.1, 5.0))
    moving = CameraSpec(position=(0, 0, 4), lens=0.05, path=[{"time": 0}, {"time": 2, "target": [0, 0, -4]}])
    assert Camera.from_spec(moving).at(2).lens == pytest.approx((0.05, 8.0))
    rack = CameraSpec(position=(0, 0, 4), lens={"radius": 0.05}, path=[{"time": 0}, {"time": 2, "focus": 9}])
    assert [Camera.from_spec(rack).at(t).lens[1] for t in (0, 2, 9)] == pytest.approx([4, 9, 9])
    assert Camera.from_spec(rack).at(1).lens[1] == pytest.approx(6.0), "equal factors in equal times"
    assert Camera.from_spec(CameraSpec(lens={"radius": 0.0, "focus": 3})).at(0).lens is None, "a pinhole"


def test_a_camera_in_the_plane_takes_two_lines():
    text = DOTS + "camera: {height: 4}\n"
    view = Camera.from_spec(load_preset(read_text(text, "plane.yaml").plain()).camera).at(0)
    corners = view.project([[0, 0, 0], [2, 2, 0], [-2, -2, 30], [1, 1, -1e6]], (400, 400))
    assert corners[:, :2] == pytest.approx(np.array([[200, 200], [400, 0], [0, 400], [300, 100]]))
    picture = Painter((64, 64), Camera(height=4.0), {"a": Look()}).paint(
        scene(0.0, a=state([[0, 0, 0], [1, 1, 30], [1, -1, -1e6]])), 0.0
    )
    assert np.count_nonzero(picture[..., 0] > 0) >= 3, "at any depth, behind the camera's place too"
    assert view.near == -np.inf
    assert Camera(height=4.0, near=2.0).at(0).near == 2.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("{near: 5, far: 2}", r"near \(5\) must be less than its far \(2\)"),
        ("{height: 4, lens: 0.1}", "orthographic camera .* has no depth of field"),
        ("{path: [{time: 0}, {time: 1, height: 3}]}", "needs `height` in the camera"),
        ("{path: [{time: 0}, {time: 1, focus: 3}]}", "needs `lens` in the camera"),
        ("{path: [{time: 1}, {time: 1}]}", "times must increase: 1 follows 1"),
        ("{path: [{time: 1, position: [0, 0, 0]}]}", "must differ, also at 1 s"),
        ("{path: [{time: 1, easing: bouncy}]}", "one of linear, smooth, spline, accelerate, brake, hold"),
        ("{orbit: {axis: [0, 0, 0]}}", r"axis must not be \[0, 0, 0\]"),
        ("{shake: {amplitude: -1}}", "from 0 to 45"),
        ("{shake: {frequency: 0}}", "more than 0"),
        ("{shake: {wobble: 1}}", "unknown key"),
        ("{lens: {radius: -1}}", "at least 0"),
    ],
)
def test_a_preset_s_camera_is_refused_in_a_sentence(wrong, words):
    with pytest.raises(PresetError, match=words):
        load_preset(read_text(DOTS + f"camera: {wrong}\n", "wrong.yaml").plain())
