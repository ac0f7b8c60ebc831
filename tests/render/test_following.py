"""A camera that follows a system: what it follows stays in its place of the picture, and the rest of the world goes by."""

import math

import numpy as np
import pytest

from gen_art.errors import PresetError, UsageError
from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset
from gen_art.renderer.camera import Camera
from gen_art.renderer.following import followed
from gen_art.simulation import Simulation

SIZE = (80, 60)
PIECE = {
    "version": 1, "clock": {"duration": 2, "fps": 10, "step": "1/40"},
    "systems": {
        "plane": {
            "emitters": {"pair": {"count": 2, "shape": {"line": {"start": [3, 1, -2], "end": [3, 1, -1]}}, "velocity": [3, 0.5, 4]}},
            "look": {"draw": "disc", "radius": 0.1, "emission": {"color": "white", "intensity": 1}},
        },
        "post": {"emitters": {"one": {"count": 1, "shape": {"point": [4, 0, 2]}}}},
    },
    "camera": {"position": [-6, 2, 1], "target": [0, 0.5, 0], "follow": {"system": "plane", "turn": True}},
}  # fmt: skip

PLAIN = Camera(position=(-6, 2, 1), target=(0, 0.5, 0)).at(0.0)  # of the piece, without following


def at_frame(frame: int, **camera) -> Playback:
    playback = Playback(load_preset({**PIECE, "camera": {**PIECE["camera"], **camera}}), SIZE, "f64", None)
    playback.sim.step(4 * frame)
    return playback


def seen(playback: Playback, points, frame: int, **other) -> np.ndarray:
    return playback.painter.view(playback.sim, frame / 10, **other).project(np.atleast_2d(points), SIZE)


@pytest.mark.parametrize("turn", [False, True])
def test_what_is_followed_stays_and_what_rests_goes_by(turn):
    """Mutants: the position of the first particle alone; a velocity in place of the position."""
    places = []
    for frame in (0, 7, 20):
        playback = at_frame(frame, follow={"system": "plane", "turn": turn})
        middle = playback.sim["plane"].position.mean(axis=0)
        places.append(seen(playback, [middle, [4, 0, 2]], frame))
    places = np.array(places)
    assert places[1:, 0] == pytest.approx(np.broadcast_to(places[0, 0], (2, 3)), abs=1e-9)
    assert places[0, 0] == pytest.approx(PLAIN.project([[0, 0, 0]], SIZE)[0], abs=1e-9)
    assert np.abs(places[1:, 1] - places[0, 1]).max() > 5


def test_turned_the_picture_is_that_of_a_subject_that_heads_along_x():
    """The heading is that of (3, 4) in x and z. Mutants: its opposite; heading from x towards -z."""
    playback = at_frame(5)
    subject = followed(playback.sim, "plane")
    assert math.degrees(subject.heading) == pytest.approx(53.13010235)
    ahead, right = np.array([0.6, 0.0, 0.8]), np.array([-0.8, 0.0, 0.6])
    own = np.array([[5.0, 1.0, 0.0], [2.0, 0.0, 3.0]])  # as seen from the subject: ahead, up, to the right
    world = subject.position + own[:, :1] * ahead + own[:, 1:2] * [0, 1, 0] + own[:, 2:] * right
    assert seen(playback, world, 5) == pytest.approx(PLAIN.project(own, SIZE), abs=1e-9)


@pytest.mark.parametrize("velocity", [[3, 0.5, 0], [3, 0.5, 4]])
def test_it_leans_into_a_turn_by_the_angle_of_level_flight(velocity):
    """tan(bank) = a / g: 30 degrees here, the right side down. Mutants: the opposite; the acceleration along the flight."""
    heading = math.atan2(velocity[2], velocity[0])
    right = np.array([-math.sin(heading), 0.0, math.cos(heading)])
    pull = (
        9.81 * math.tan(math.radians(30)) * right + 2.0 * np.array([math.cos(heading), 0.0, math.sin(heading)])
    ).tolist()
    plane = {"forces": {"gravity": pull}, "emitters": {"one": {"count": 1, "velocity": velocity}}}
    camera = {"position": [-6, 0, 0], "follow": {"system": "plane", "turn": True, "bank": 9.81}}
    playback = Playback(load_preset({**PIECE, "systems": {"plane": plane}, "camera": camera}), SIZE, "f64", None)
    axes = playback.painter.view(playback.sim, 0.0).axes
    assert axes[0] == pytest.approx(math.cos(math.radians(30)) * right - [0, 0.5, 0], abs=1e-12)
    assert axes[2] == pytest.approx([math.cos(heading), 0, math.sin(heading)], abs=1e-12)


def test_a_path_is_relative_too_and_a_still_is_the_frame_of_the_film():
    path = [{"time": 0, "position": [-6, 2, 1]}, {"time": 2, "position": [-3, 4, 0]}]
    film = Playback(load_preset({**PIECE, "camera": {**PIECE["camera"], "path": path}}), SIZE, "f32", None)
    assert film.camera is not None and film.camera.moves
    last = [picture.copy() for picture, _ in film.pictures([0, 4, 8, 60])][-1]
    alone = Playback(film.preset, SIZE, "f32", None)
    assert np.array_equal(next(alone.pictures([60]))[0], last) and last.any()


def test_before_a_particle_is_born_the_camera_is_at_the_origin():
    data = {**PIECE, "systems": {**PIECE["systems"], "late": {"emitters": {"one": {"rate": 1, "start": 1.5}}}}}
    playback = Playback(load_preset({**data, "camera": {**PIECE["camera"], "follow": "late"}}), SIZE, "f64", None)
    assert seen(playback, [0, 0.5, 0], 0)[0, :2] == pytest.approx([40, 30])


def test_motion_since_the_frame_before_is_that_of_the_picture():
    """What is followed has moved nowhere. Mutant: the earlier view at the place of now."""
    playback = at_frame(9)
    subject = followed(playback.sim, "plane")
    now = seen(playback, subject.position, 9)
    before = seen(playback, subject.position - 0.1 * subject.velocity, 9, earlier=0.1, seconds=0.1)
    assert now == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize(
    "change,words",
    [
        ({"camera": {"follow": "plan"}}, "camera.follow: there is no system 'plan'; did you mean 'plane'"),
        ({"camera": {"follow": {"system": "nobody"}}}, "camera.follow.system: there is no system 'nobody'"),
        ({"camera": {"follow": "plane", "frame": "auto"}}, "which a camera with `follow` leaves"),
        ({"camera": {"follow": {"turn": True}}}, "system"),
        ({"camera": {"follow": {"system": "plane", "bank": 9.81}}}, "give `turn: true`"),
        ({"camera": {"follow": "plane"}, "wormhole": {"radius": 1}}, "leave out `follow`"),
    ],
)
def test_wrong_input_is_a_sentence(change, words):
    with pytest.raises(PresetError, match=words):
        load_preset({**PIECE, **change})


def test_a_camera_of_another_simulation_says_whom_it_misses():
    other = Simulation(load_preset({**PIECE, "systems": {"post": PIECE["systems"]["post"]}, "camera": {}}))
    with pytest.raises(UsageError, match="no system 'plane' to follow; there are post"):
        at_frame(0).painter.view(other, 0.0)
