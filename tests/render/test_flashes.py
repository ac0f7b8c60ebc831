"""Solids as they were at earlier flashes: where they stand, how they turn, and how much they hide.

Mutants that were tried, each of which fails a test here: one flash more, twice as often, from the first step in place of the film's
first; solids of now for those of a flash; opacities oldest first; the weight of a picture its opacity; flashes forgotten by what a
lens sees; what rests drawn once for each flash; what only turned taken for resting; layers with all of them.
"""

from pathlib import Path

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import AdviceWarning, PresetError
from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset

SIZE = (96, 54)
CLOCK = {"duration": 3, "fps": 8, "step": "1/16", "preroll": 0.25}
LOOK = {"draw": "sphere", "blend": "opaque", "albedo": "black", "emission": "white", "finish": {"ior": 1}}
CAMERA = {"position": [0, 0, 9], "target": [0, 0, 0], "height": 4}
SPEED = 2.0


def balls(positions, velocity=0.0, **look):
    emitters = {
        f"ball{k}": {"count": 1, "shape": {"point": [x, 0.0, 0.0]}, "velocity": [velocity, 0, 0]}
        for k, x in enumerate(positions)
    }
    return {"particle": {"radius": 0.3, "lifetime": 99}, "emitters": emitters, "look": {**LOOK, **look}}


def playback(systems, camera=(), **keys):
    light = {"intensity": 0, "ambient_intensity": 0}
    camera = {key: value for key, value in (CAMERA | dict(camera)).items() if value is not None}
    basis = {"version": 1, "clock": CLOCK, "light": light, "camera": camera, "systems": systems}
    return Playback(load_preset({**basis, **keys}), SIZE, "f32", None)


def picture(step, systems, **keys):
    return playback(systems, **keys).picture(step).copy()


def place(step):
    """Where the ball is after so many steps; the film begins after 4 of them."""
    return -3.0 + SPEED * step / 16


@pytest.mark.parametrize(
    ("step", "left"),
    [(28, (20, 12, 4)), (29, (28, 20, 12)), (36, (28, 20, 12)), (12, (4,)), (11, (4,)), (4, ()), (3, ())],
)
def test_what_a_flash_left_stands_where_the_ball_was(step, left):
    """A flash every half second, 8 steps, from the film's first frame on: those before the picture, the last three."""
    moving = {"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 3})}
    still = {f"b{k}": balls([place(k)]) for k in (step, *left)}
    assert np.array_equal(picture(step, moving), picture(0, still))


def test_a_body_keeps_the_direction_it_had_and_its_shadow():
    """A turning box beside the boxes that it was, on a ground in a lamp; what moved is where the simulation says, to its round-off."""
    box = {"shape": {"box": [0.8, 0.3, 0.5]}, "points": 20}
    look = {"draw": "body", "albedo": "orange"}
    scene = {
        "light": {"direction": [0.3, -1, -0.2]}, "ground": {"height": -1.0}, "camera": {"height": 6, "position": [0, 3, 9]},
    }  # fmt: skip

    def boxes(turns, spin=0.0, **more):
        bodies = {
            f"b{k}": {
                "body": {**box, "position": [place(k), 0.2, 0], "velocity": [SPEED if spin else 0, 0, 0],
                         "turn": [0, 0, np.degrees(turn)], "spin": [0, 0, spin]}
            }
            for k, turn in turns.items()
        }  # fmt: skip
        system = {"interactions": {"rigid": {}}, "integrator": "leapfrog", "emitters": bodies, "look": {**look, **more}}
        return {"boxes": system}

    spin = 1.5
    got = picture(20, boxes({0: 0.0}, spin, flashes={"every": 0.5, "number": 2}), **scene)
    expected = picture(0, boxes({k: spin * k / 16 for k in (20, 12, 4)}), **scene)
    alone = picture(0, boxes({20: spin * 20 / 16}), **scene)
    assert np.abs(got - expected).mean() < 0.02 * np.abs(alone - expected).mean()


def test_each_flash_hides_as_much_as_its_opacity():
    """Bright balls before nothing: their light is their opacity, and the ball as it is now keeps its own."""
    look = {"flashes": {"every": 0.5, "number": 3, "opacity": 0.8, "tail": 0.25}}
    playing = playback({"ball": balls([-3.0], SPEED, **look)})
    got = playing.picture(28)
    scale = SIZE[1] / CAMERA["height"]
    columns = [int(0.5 * SIZE[0] + place(k) * scale) for k in (28, 20, 12, 4)]
    light = got[SIZE[1] // 2, columns, 0]
    assert light == pytest.approx([1.0, 0.8, 0.5, 0.2], abs=1e-6)
    assert got[SIZE[1] // 2, columns, 3] == pytest.approx([1.0, 0.8, 0.5, 0.2], abs=1e-6)


@pytest.mark.parametrize("with_lens", [False, True])
@pytest.mark.parametrize("mirror", [False, True])
def test_one_opacity_is_the_mean_of_the_picture_with_and_without(mirror, with_lens):
    """In what a mirror shows too, and through a lens."""
    keys = {"sky": {"color": "#304050"}, "light": {"direction": [0.2, -1, -0.3]}}
    keys["ground"] = {"height": -0.4, "mirror": mirror, "roughness": 0.0 if mirror else 0.5}
    if with_lens:
        keys["camera"] = {"height": None, "fov": 30, "lens": {"radius": 0.2, "focus": 9}}
    flashes = {"every": 0.5, "number": 2, "opacity": 0.25}
    whole = picture(20, {"ball": balls([-3.0], SPEED, flashes={**flashes, "opacity": 1.0})}, **keys)
    none = picture(20, {"ball": balls([-3.0], SPEED)}, **keys)
    part = picture(20, {"ball": balls([-3.0], SPEED, flashes=flashes)}, **keys)
    assert np.abs(whole - none).max() > 0.1
    assert part == pytest.approx(0.25 * whole + 0.75 * none, abs=4 * 2.0**-23 * float(whole.max()))


@pytest.mark.parametrize("subframes", [1, 2])
def test_a_picture_does_not_depend_on_the_frames_before_it(subframes):
    systems = {"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 3, "tail": 0.5})}
    camera = {"shutter": 360, "subframes": subframes}
    film = [p.copy() for p, _ in playback(systems, camera=camera).pictures(range(4, 52, 2))]
    for step in (4, 20, 22, 50):
        assert np.array_equal(film[(step - 4) // 2], picture(step, systems, camera=camera))


def test_a_film_may_be_played_from_where_its_flashes_begin():
    """`begins_at` leaves out births of particles that are dead by then; the ball of the oldest flash is not one of them."""
    short = {"systems": {"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 2})}}
    playing = playback(short["systems"])
    assert playing.begins_at(44) <= 28 - 8 and playing.begins_at(44) > 0


def test_a_lens_sees_what_flashes_left():
    camera = {"height": None, "fov": 30, "lens": {"radius": 0.2, "focus": 9}}
    moving = {"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 2})}
    still = {f"b{k}": balls([place(k)]) for k in (28, 20, 12)}
    assert np.array_equal(picture(28, moving, camera=camera), picture(0, still, camera=camera))


SHADED = {"light": {"direction": [0.2, -1, -0.3]}, "sky": {"color": "#8090a0"}, "ground": {"height": -0.3}}
MATT = {"albedo": "red", "emission": "black"}


@pytest.mark.parametrize("step", [20, 28])
def test_what_rests_is_there_once(step):
    """The sky's light on a grid would be dimmed by each of several balls at one place."""
    flashes = {"every": 0.5, "number": 3}
    resting = {"ball": balls([-1.0, 0.5], 0.0, **MATT)}
    assert np.array_equal(
        picture(step, {"ball": balls([-1.0, 0.5], 0.0, **MATT, flashes=flashes)}, **SHADED),
        picture(step, resting, **SHADED),
    )


def test_a_box_that_turns_where_it_is_has_moved():
    body = {"shape": {"box": [0.8, 0.3, 0.5]}, "points": 20, "position": [0, 0.2, 0], "spin": [0, 0, 1.0]}
    look = {"draw": "body", "albedo": "orange", "flashes": {"every": 0.5, "number": 1}}
    system = {"interactions": {"rigid": {}}, "integrator": "leapfrog", "emitters": {"b": {"body": body}}, "look": look}
    plain = {**system, "look": {**look, "flashes": None}}
    spinning, alone = (picture(20, {"box": one}, **SHADED) for one in (system, plain))
    assert np.abs(spinning - alone).max() > 0.1
    body["spin"] = [0, 0, 0]
    resting, alone = (picture(20, {"box": one}, **SHADED) for one in (system, plain))
    assert np.array_equal(resting, alone)


def test_a_simulation_that_is_at_the_start_gets_the_first_flash():
    preset = {
        "version": 1,
        "clock": {**CLOCK, "preroll": 0},
        "light": {"intensity": 0, "ambient_intensity": 0},
        "camera": CAMERA,
    }
    preset = load_preset({**preset, "systems": {"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 3})}})
    whole = Playback(preset, SIZE, "f32", None).picture(20).copy()
    sim = ga.Simulation(preset)
    assert np.array_equal(Playback(preset, SIZE, "f32", None, sim=sim).picture(20), whole)


def test_the_picture_is_drawn_as_often_as_there_are_opacities():
    playing = playback({"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 3, "opacity": 0.9, "tail": 0.5})})
    lengths = []
    for step in (4, 11, 13, 22, 60):
        playing.picture(step)
        lengths.append(len(playing.painter.album.exposures(playing.sim.time)))
    assert lengths == [1, 2, 3, 4, 4]


def test_layers_show_what_is_half_opaque():
    playing = playback(
        {"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 2, "opacity": 0.9, "tail": 0.5})}, **SHADED
    )
    playing.picture(28)
    depth = playing.aovs()["Z"][SIZE[1] // 2]
    scale = SIZE[1] / CAMERA["height"]
    now, newer, older = (depth[int(0.5 * SIZE[0] + place(k) * scale)] for k in (28, 20, 12))
    assert abs(now - newer) < 0.01 and not 8.6 < older < 8.8


def test_what_flashes_left_shares_the_image_of_its_look(monkeypatch):
    monkeypatch.chdir(Path(__file__).parents[2])
    image = {"file": "presets/course/stripe.png", "size": 0.5}
    playing = playback({"ball": balls([-3.0], SPEED, flashes={"every": 0.5, "number": 3}, finish={"image": image})})
    playing.picture(28)
    assert len(playing.painter._surfaces._maps.chains) == 1


def test_flashes_are_for_solids_in_a_light():
    with pytest.raises(PresetError, match="flashes need draw: body"):
        playback({"ball": balls([0.0], draw="disc", blend="add", flashes=0.5, finish={})})
    with pytest.raises(PresetError, match="every"):
        playback({"ball": balls([0.0], flashes={"number": 3})})
    with pytest.raises(PresetError, match="number"):
        playback({"ball": balls([0.0], flashes={"every": 0.5, "number": 0})})
    dark = {"version": 1, "clock": CLOCK, "camera": CAMERA, "systems": {"ball": balls([0.0], flashes=0.5, finish={})}}
    with pytest.warns(AdviceWarning, match=r"flashes has no effect, because balls are solid only in a light"):
        ga.Simulation(load_preset(dark), advice="warn")
