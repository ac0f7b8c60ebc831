"""Steering a preset over the studio's socket, and keeping what was steered."""

import numpy as np
import pytest
from ruamel.yaml import YAML

from gen_art.preset.load import load_preset
from gen_art.simulation import Simulation
from tests.studio.conftest import received, start
from tests.studio.test_server import send

TEXT = """\
version: 1
clock: {duration: 3, fps: 30, step: 1/120}
systems:
  probe:
    particle: {mass: 2, radius: 0.05}
    forces:
      thruster: {max_thrust: 30}   # newtons
      attractor: {GM: 4, softening: 0.3}
    emitters: {one: {count: 3, shape: {ball: 0.5}}}
    look: {draw: disc, emission: {color: white, intensity: 2}}
camera: {position: [0, 0, 6], target: [0, 0, 0], size: [320, 180]}
"""


@pytest.fixture
def steered(tmp_path):
    """A studio of a piece that can be steered."""
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT, encoding="utf-8")
    running = start(path)
    yield running
    running.stop()


def test_what_was_steered_is_kept_beside_the_preset_and_plays_as_it_was(steered):
    with steered.socket() as socket:
        send(socket, type="view", size=[64, 36])
        send(socket, type="steer", on=True)
        assert received(socket, "steering")["on"]
        first = received(socket, "picture", lambda picture: "steered" in picture)
        assert first["frame"] == 0 and not first["steered"]["begun"]
        send(socket, type="devices", held={"ArrowRight": 1})
        frames = [received(socket, "picture") for _ in range(10)]
        assert [picture["frame"] for picture in frames] == list(range(1, 11)), "none is left out"
        send(socket, type="devices", held={"w": 0.5, "mouse": 1}, pointer=[0.25, 0.75])
        last = [received(socket, "picture") for _ in range(15)][-1]
        send(socket, type="keep")
        document = received(socket, "document", lambda state: "controls" in state["text"])
        assert received(socket, "kept")["names"] == ["mine_attractor_1.csv", "mine_thruster_1.csv"]
        assert received(socket, "picture", lambda picture: "steered" not in picture), "the film is shown again"
        assert steered.path.read_text() == TEXT and "# newtons" in document["text"]
        send(socket, type="save")
        received(socket, "said", lambda message: message["text"].startswith("saved"))
    forces = YAML(typ="safe").load(steered.path.read_text())["systems"]["probe"]["forces"]
    assert forces["thruster"]["controls"] == "mine_thruster_1.csv"
    table = np.loadtxt(steered.path.with_name("mine_thruster_1.csv"), delimiter=",", skiprows=1)
    assert table.shape[0] > last["frame"] and table.shape[1] == 4
    assert 0 < table[1, 1] <= 1, "pressed at once"
    sim = Simulation(load_preset(str(steered.path)), precision="f32")
    sim.step(4 * last["frame"])
    velocity = sim["probe"].velocity.astype(np.float64).mean(axis=0)
    assert last["steered"]["speed"] == float(np.linalg.norm(velocity))


def test_steering_ends_by_leaving_and_by_a_change(steered):
    with steered.socket() as socket:
        for end in ({"type": "steer", "on": False}, {"type": "set", "values": {"develop.exposure": 1}}):
            send(socket, type="steer", on=True)
            assert received(socket, "steering")["on"]
            received(socket, "picture", lambda picture: "steered" in picture)
            send(socket, **end)
            assert not received(socket, "steering")["on"]
            assert received(socket, "picture", lambda picture: "steered" not in picture)["exact"]


def test_a_page_that_goes_ends_the_steering(steered):
    with steered.socket() as socket, steered.socket() as watcher:
        received(socket, "document")
        received(watcher, "document")
        send(watcher, type="steer", on=True)
        assert "another page" in received(watcher, "error")["text"]
        send(socket, type="steer", on=True)
        assert received(watcher, "steering")["on"]
        socket.close()
        assert not received(watcher, "steering")["on"]


@pytest.mark.parametrize(
    "held,pointer",
    [({"w": "much"}, None), ([1, 2], None), ({}, [0.5]), ({}, "here"), ({"w": float("nan")}, None), (None, None)],
)
def test_hands_that_cannot_be_are_answered(steered, held, pointer):
    with steered.socket() as socket:
        send(socket, type="steer", on=True)
        received(socket, "picture", lambda picture: "steered" in picture)
        send(socket, type="devices", held=held, pointer=pointer)
        assert "cannot be understood" in received(socket, "error")["text"]


def test_what_cannot_be_kept_or_steered_is_said(steered, studio):
    with steered.socket() as socket:
        send(socket, type="keep")
        assert "nothing was steered yet" in received(socket, "error")["text"]
        send(socket, type="text", text=TEXT.replace("max_thrust: 30", "max_thrust: -3"))
        send(socket, type="steer", on=True)
        assert "mend them" in received(socket, "error")["text"]
    assert not list(steered.path.parent.glob("*.csv"))
    with studio.socket() as socket:
        send(socket, type="steer", on=True)
        assert "nothing in this preset can be steered" in received(socket, "error")["text"]
    shipped = start("course/hand")
    try:
        with shipped.socket() as socket:
            send(socket, type="view", size=[64, 36])
            send(socket, type="steer", on=True)
            received(socket, "picture", lambda picture: "steered" in picture)
            send(socket, type="devices", held={"mouse": 1})
            received(socket, "picture", lambda picture: picture["steered"]["begun"])
            send(socket, type="keep")
            assert "gen-art new mine --from" in received(socket, "error")["text"]
            assert received(socket, "picture")["steered"]["begun"], "it goes on"
    finally:
        shipped.stop()
