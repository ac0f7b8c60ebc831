"""The camera: projection, paths, orbits, roll, and where a particle lands on the film."""

import numpy as np
import pytest

from gen_art.errors import UsageError
from gen_art.preset.camera import CameraSpec
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.frame import Painter
from tests.render.particles import scene, state


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
