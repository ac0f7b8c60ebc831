"""A run that somebody steers, and that what was steered renders as a film: the same motion to the last bit."""

import copy

import numpy as np
import pytest

from gen_art.errors import UsageError
from gen_art.forces import Aircraft, Hand, Propeller, Thruster
from gen_art.forces.steering import Button, Hands, Lever, Pointer, Stick
from gen_art.output.input_tables import InputTable, controls_paths, input_tables
from gen_art.output.playback import Playback
from gen_art.output.steered_run import Device, SteeredRun
from gen_art.preset import overrides
from gen_art.preset.load import load_preset
from gen_art.preset.writing import yaml_text

PIECE = {
    "version": 1, "clock": {"duration": 1, "fps": 20, "step": "1/80", "preroll": 0.1}, "seed": 3,
    "systems": {
        "probe": {
            "particle": {"mass": 2.0, "radius": 0.05},
            "forces": {"thruster": {"max_thrust": 30.0}, "attractor": {"GM": 4.0, "softening": 0.3}},
            "emitters": {"one": {"count": 3, "shape": {"ball": 0.5}}},
            "look": {"draw": "disc", "emission": {"color": "white", "intensity": 2}},
        },
        "dust": {
            "forces": {"attractor": {"GM": 4.0, "softening": 0.3}, "damping": 0.5},
            "emitters": {"cloud": {"count": 40, "shape": {"ball": 1.0}}},
            "look": {"draw": "streak", "width": 0.02, "ribbon": {"length": 0.3}},
        },
    },
    "camera": {"position": [0, 0, 6], "target": [0, 0, 0], "size": [96, 54], "subframes": 2},
}  # fmt: skip
SIZE = (96, 54)


def played(frames: int) -> tuple[SteeredRun, list[np.ndarray]]:
    """A run with keys that are pressed and let go, and a mouse that wanders and rests."""
    run, pictures = SteeredRun(load_preset(PIECE), SIZE), []
    for k in range(frames):
        held = {"ArrowRight": 1.0, "mouse": float(k % 7 < 4)} if k < 9 else {"w": 0.37, "mouse": 1.0}
        run.advance(Device(held, (0.2 + 0.031 * k, 0.7 - 0.013 * k) if k % 3 else None))
        pictures.append(run.picture())
    return run, pictures


def with_kept_tables(run: SteeredRun, folder) -> str:
    """The file of the piece as it names the tables of a run, which lie beside it."""
    data = copy.deepcopy(PIECE)
    for table in run.tables:
        name = f"{table.kind.name}.csv"
        (folder / name).write_text(table.text(), encoding="utf-8")
        overrides.apply(data, dict.fromkeys(controls_paths(PIECE, table), name))
    file = folder / "piece.yaml"
    file.write_text(yaml_text(data), encoding="utf-8")
    return str(file)


def test_the_film_of_kept_inputs_is_the_one_that_was_steered(tmp_path):
    run, pictures = played(14)
    assert not np.array_equal(pictures[0], pictures[-1])
    playback = Playback(load_preset(with_kept_tables(run, tmp_path)), SIZE, "f32", None)
    first, per_frame = playback.preset.clock.preroll_steps, playback.preset.clock.steps_per_frame
    steps = [first + k * per_frame for k in range(15)]
    for k, (linear, exposure) in enumerate(playback.pictures(steps)):
        if k:
            assert np.array_equal(playback.developed(linear, exposure, k)[..., :3], pictures[k - 1]), k
    for name, system in run.sim.systems.items():
        assert np.array_equal(system.floats, playback.sim.systems[name].floats), name


def test_hands_change_the_motion():
    still, moved = SteeredRun(load_preset(PIECE), SIZE), SteeredRun(load_preset(PIECE), SIZE)
    for run, held in ((still, {}), (moved, {"ArrowRight": 1.0})):
        for _ in range(10):
            run.advance(Device(held))
            run.picture()
    assert moved.instruments()["speed"] > still.instruments()["speed"] + 1.0


def test_a_shared_table_is_one_and_kinds_without_a_file_are_one_each():
    tables = input_tables(load_preset(PIECE))
    assert [(table.kind.name, table.file, len(table.forces)) for table in tables] == [
        ("attractor", None, 2), ("thruster", None, 1),
    ]  # fmt: skip
    assert controls_paths(PIECE, tables[0]) == [
        "systems.probe.forces.attractor.controls", "systems.dust.forces.attractor.controls",
    ]  # fmt: skip


def test_paths_of_forces_in_a_list_and_shared_by_all():
    data = {
        "forces": {"hand": [{"stiffness": 1}, {"stiffness": 2, "controls": "a.csv"}]},
        "systems": {"s": {"forces": {"hand": {"stiffness": 3}}}},
    }
    table = InputTable(None, Hand, {}, {})
    assert controls_paths(data, table) == ["forces.hand[0].controls", "systems.s.forces.hand.controls"]
    table.file = "a.csv"
    assert controls_paths(data, table) == ["forces.hand[1].controls"]
    with pytest.raises(UsageError, match="as a mapping"):
        controls_paths({"systems": {"s": {"forces": {"thruster": 3}}}}, InputTable(None, Thruster, {}, {}))


def test_a_preset_without_inputs_cannot_be_steered():
    piece = {**PIECE, "systems": {"s": {"emitters": {"one": {"count": 1}}}}}
    with pytest.raises(UsageError, match="nothing in this preset can be steered"):
        SteeredRun(load_preset(piece), SIZE)


def test_the_pointer_is_where_the_picture_shows_it():
    """The point lies in the plane of the rest that faces the camera: projected, it is the place in the picture again."""
    run = SteeredRun(load_preset(PIECE), SIZE)
    for place in ((0.25, 0.6), (0.9, 0.1)):
        run.advance(Device({}, place))
        point = run.tables[0].rows[-1][2:]
        view = run.playback.painter.view(run.sim, 0.0)
        assert view.project(np.array([point]), SIZE)[0, :2] == pytest.approx(
            [place[0] * SIZE[0], place[1] * SIZE[1]], abs=1e-3
        )
        assert point[2] == pytest.approx(0.0, abs=1e-5)


def test_devices():
    """The rates of each, by hand: half a second of a frame's length of 0.1 s."""
    stick = Stick(less=("a",), more=("d",), low=-2.0, high=2.0, seconds=0.5)
    assert stick.moved(0.0, 0.0, Hands({"d": 1.0}), 0.1) == pytest.approx(0.4)
    assert stick.moved(0.4, 0.0, Hands(), 0.1) == pytest.approx(0.0)
    assert stick.moved(1.9, 0.0, Hands({"d": 1.0}), 0.1) == 2.0
    assert stick.moved(0.0, 0.0, Hands({"d": 0.1}), 0.5) == pytest.approx(0.2), "half pressed goes half way"
    assert stick.moved(0.0, 0.5, Hands({"a": 1.0}), 9.0) == -2.0
    lever = Lever(less=("s",), more=("w",), rate=0.8)
    assert lever.moved(0.5, 0.0, Hands({"w": 0.5}), 0.1) == pytest.approx(0.54)
    assert lever.moved(0.5, 0.0, Hands(), 0.1) == 0.5 and lever.moved(0.01, 0.0, Hands({"s": 1.0}), 0.1) == 0.0
    button = Button(less=("x",), more=("mouse",))
    assert [button.moved(0.3, 0.2, Hands(held), 0.1) for held in ({}, {"x": 0.4}, {"mouse": 1.0})] == [0.2, -1.0, 1.0]
    pointer = Pointer(axis=1)
    assert pointer.moved(3.0, 0.0, Hands(), 0.1) == 3.0
    assert pointer.moved(3.0, 0.0, Hands(point=(1.0, 2.0, 4.0)), 0.1) == 2.0


@pytest.mark.parametrize("kind", [Aircraft, Hand, Propeller, Thruster])
def test_the_ends_of_devices_are_allowed_inputs(kind):
    """What a device can give, a table takes."""
    for name, device in kind.steering.items():
        if isinstance(device, (Stick, Lever)):
            ends = [end for end in (device.low, device.high) if np.isfinite(end)]
            kind(controls={"time": list(range(len(ends))), name: ends}) if ends else None
