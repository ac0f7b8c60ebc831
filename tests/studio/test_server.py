"""The studio's server: who may ask, what it answers, and pictures over the websocket."""

import hashlib
import http.client
import io
import json
import socket as sockets
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from websockets.exceptions import ConnectionClosed, InvalidStatus

from gen_art.output import job
from gen_art.studio.server import LARGEST_MESSAGE
from tests.studio.conftest import ROOT, received, start
from tests.studio.piece import TEXT, THROUGH_TARGET


def answer(studio, path: str, host: str | None = None) -> tuple[int, str]:
    connection = http.client.HTTPConnection("127.0.0.1", studio.port, timeout=60)
    connection.request("GET", path, headers={"Host": host or f"127.0.0.1:{studio.port}"})
    found = connection.getresponse()
    return found.status, found.read().decode()


def send(socket, **message) -> None:
    socket.send(json.dumps(message))


def test_who_may_ask(studio):
    page = f"/?token={studio.token}"
    assert answer(studio, page)[0] == 200
    assert answer(studio, page, f"localhost:{studio.port}")[0] == 200
    assert answer(studio, "/?token=%C3%A9")[0] == 403
    assert answer(studio, "/")[0] == 403 and answer(studio, "/?token=guess")[0] == 403
    assert answer(studio, page, "evil.example")[0] == 403
    assert answer(studio, page, f"evil.example:{studio.port}")[0] == 403
    assert answer(studio, "/schema.json")[0] == 403
    schema = json.loads(answer(studio, f"/schema.json?token={studio.token}")[1])
    assert "camera" in schema["properties"]
    for path in ("/page/../server.py", "/page/%2e%2e/server.py", "/page//etc/passwd", "/mine.yaml", "/page/"):
        assert answer(studio, path)[0] in (400, 404), path


def test_who_may_open_a_socket(studio):
    for token, origin in (
        ("guess", None),
        ("", None),
        (None, "http://evil.example"),
        (None, f"https://127.0.0.1:{studio.port}"),
    ):
        with pytest.raises((InvalidStatus, ConnectionClosed)), studio.socket(token, origin) as socket:
            socket.recv(timeout=60)
    with studio.socket() as socket:
        assert received(socket, "hello")["editor"] is True


def test_it_listens_on_this_machine_alone(studio):
    own = {info[4][0] for info in sockets.getaddrinfo(sockets.gethostname(), None, sockets.AF_INET)} - {"127.0.0.1"}
    for address in own:
        with pytest.raises(OSError):
            sockets.create_connection((address, studio.port), timeout=5)


def test_a_knob_changes_the_picture_and_the_text(studio):
    with studio.socket() as socket:
        assert received(socket, "document")["text"] == TEXT
        send(socket, type="view", size=[160, 90], frame=20)
        first = received(socket, "picture", lambda picture: picture["width"] == 160 and picture["frame"] == 20)
        assert Image.open(io.BytesIO(first["jpeg"])).size == (160, 90) and first["exact"]
        send(socket, type="set", values={"develop.exposure": 3.0}, done=False)
        changed = received(socket, "picture", lambda picture: picture["version"] > first["version"])
        mean = [np.asarray(Image.open(io.BytesIO(p["jpeg"]))).mean() for p in (first, changed)]
        assert mean[1] > 1.3 * mean[0]
        send(socket, type="set", values={"develop.exposure": 2.5}, done=True)
        document = received(socket, "document")
        assert document["text"] == TEXT.replace("exposure: 0.5", "exposure: 2.5") and document["undo"]
        send(socket, type="undo")
        assert received(socket, "document")["text"] == TEXT


def test_a_film_plays_and_loops(studio):
    with studio.socket() as socket:
        send(socket, type="view", size=[64, 36], frame=55, playing=True)
        frames = [received(socket, "picture", lambda picture: picture["width"] == 64)["frame"] for _ in range(12)]
        steps = {(b - a) % 60 for a, b in zip(frames, frames[1:])}
        assert steps == {1}, frames
        send(socket, type="view", playing=False, frame=10)
        assert received(socket, "picture", lambda picture: picture["frame"] == 10)


def test_no_more_than_two_pictures_wait_for_the_page(studio):
    with studio.socket() as socket:
        send(socket, type="view", size=[64, 36], frame=50)
        for _ in range(2):  # at once, and in full: then nothing is on its way
            received(socket, "picture", lambda picture: picture["frame"] == 50)
        send(socket, type="view", playing=True)
        for _ in range(2):
            while not isinstance(socket.recv(timeout=120), bytes):
                pass
        with pytest.raises(TimeoutError):
            while not isinstance(socket.recv(timeout=3), bytes):
                pass
        send(socket, type="shown")
        while not isinstance(socket.recv(timeout=120), bytes):
            pass


def test_the_final_picture_has_the_bytes_of_the_still(studio, tmp_path):
    with studio.socket() as socket:
        send(socket, type="set", values={"knobs.push": 12}, done=True)
        send(socket, type="final", frame=30)
        import base64

        made = received(socket, "final")
        assert made["name"] == "mine.png"
    studio.path.write_text(TEXT.replace("value: 9", "value: 12"), encoding="utf-8")
    (path,) = job.still(studio.path, tmp_path / "still.png", 1.0)
    assert hashlib.sha256(base64.b64decode(made["png"])).digest() == hashlib.sha256(path.read_bytes()).digest()


def test_saving_writes_the_file(studio):
    with studio.socket() as socket:
        send(socket, type="set", values={"knobs.push": 8}, done=True)
        send(socket, type="save")
        assert received(socket, "said")["text"] == "saved mine.yaml"
    assert studio.path.read_text(encoding="utf-8") == TEXT.replace("value: 9", "value: 8")


def test_a_second_page_watches(studio):
    with studio.socket() as first:
        assert received(first, "hello")["editor"]
        with studio.socket() as second:
            assert received(second, "hello")["editor"] is False
            send(second, type="set", values={"knobs.push": 8}, done=True)
            assert "another page edits" in received(second, "error")["text"]
            send(first, type="view", frame=33, size=[64, 36])
            assert received(second, "picture", lambda picture: picture["frame"] == 33)
            first.close()
            assert received(second, "hello")["editor"] is True, "now it edits"
            send(second, type="set", values={"knobs.push": 8}, done=True)
            assert "value: 8," in received(second, "document", lambda state: state["undo"])["text"]


MEANT_BY_NOBODY = [
    ('{"type": "set", "values": 3}', "cannot be understood"),
    ('{"type": "nothing"}', "cannot be understood"),
    ('{"type": "_take"}', "cannot be understood"),
    ("[1, 2", "cannot be understood"),
    ("3", "cannot be understood"),
    ('{"type": "remove", "path": "systems.nothing"}', "is not in the preset"),
    ('{"type": "view", "size": [1e99, "a"]}', "cannot be understood"),
    ('{"type": "view", "frame": 1e999}', "cannot be understood"),
    ('{"type": "final", "frame": 999}', "lies past the end"),
    ("[" * 100_000, "cannot be understood"),
]


def test_messages_that_cannot_be_meant(studio):
    """Each is answered with a sentence, and the studio goes on."""
    for k, (message, words) in enumerate(MEANT_BY_NOBODY):
        with studio.socket() as socket:
            received(socket, "document")
            socket.send(message)
            assert words in received(socket, "error")["text"], message
            send(socket, type="view", frame=7 + k, size=[64, 36])
            assert received(socket, "picture", lambda picture, frame=7 + k: picture["frame"] == frame), message


def test_a_word_that_a_control_cannot_have_is_a_problem_of_the_document(studio):
    with studio.socket() as socket:
        received(socket, "document")
        send(socket, type="set", values={"systems.drops.look.draw": "disk"})
        document = received(socket, "document", lambda state: state["problems"])
        assert "did you mean 'disc'" in document["problems"][0]["text"]
        send(socket, type="view", frame=7, size=[64, 36])
        assert received(socket, "picture", lambda picture: picture["frame"] == 7), "it goes on"


def test_a_message_of_megabytes_closes_the_socket(studio):
    with studio.socket() as socket:
        received(socket, "document")
        with pytest.raises(ConnectionClosed):
            socket.send("x" * (LARGEST_MESSAGE + 1))
            while True:
                socket.recv(timeout=60)
    with studio.socket() as socket:
        assert received(socket, "hello")


def test_a_preset_of_which_no_picture_can_be_made_is_a_sentence(studio):
    with studio.socket() as socket:
        send(socket, type="text", text=THROUGH_TARGET)
        assert "camera" in received(socket, "error")["text"]
        send(socket, type="text", text=TEXT)
        assert received(socket, "picture")


def test_it_ends_when_it_is_asked_to(studio):
    assert studio.stop() == 143


def test_a_port_in_use_and_standard_input_are_sentences(studio):
    def run(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "gen_art", "studio", *arguments, "--no-browser"],
            capture_output=True,
            text=True,
            cwd=ROOT,
        )

    taken = run("fire", "--port", str(studio.port))
    assert taken.returncode == 5 and "--port 0 takes a free one" in taken.stderr
    assert run("-").returncode == 2 and run("piza").returncode == 2


def test_the_token_is_kept_for_the_next_start(studio):
    again = start(studio.path)
    assert again.token == studio.token and again.port != studio.port
    again.stop()


def test_a_file_that_is_saved_elsewhere_is_seen(studio):
    with studio.socket() as socket:
        received(socket, "picture")
        studio.path.write_text(TEXT.replace("exposure: 0.5", "exposure: 2"), encoding="utf-8")
        document = received(socket, "document", lambda state: "exposure: 2" in state["text"])
        assert document["saved"] and document["undo"]
        received(socket, "picture")
        studio.path.write_text(TEXT.replace("fov: 40", "fov: 400"), encoding="utf-8")
        assert received(socket, "document", lambda state: state["problems"])["problems"][0]["path"] == "camera.fov"
        studio.path.unlink()
        assert "cannot read mine.yaml" in received(socket, "error")["text"]
        studio.path.write_text(TEXT, encoding="utf-8")
        assert received(socket, "document", lambda state: state["text"] == TEXT)["problems"] == []


PLUGIN = '''\
import gen_art as ga
from gen_art import ti


@ga.force("lift")
class Lift(ga.Force):
    """A push upwards. a = strength y; strength in m/s^2."""

    strength: float = ga.param(0.0, unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        return ti.Vector([0.0, q.strength, 0.0])
'''


def test_a_plugin_that_is_saved_is_loaded_again(tmp_path):
    plugin, path = tmp_path / "lift.py", tmp_path / "mine.yaml"
    plugin.write_text(PLUGIN, encoding="utf-8")
    path.write_text(TEXT.replace("forces:\n", "forces:\n  lift: {strength: 5}\n"), encoding="utf-8")
    running = start(path, "--plugin", str(plugin))
    try:
        with running.socket() as socket:
            send(socket, type="view", size=[160, 90], frame=30)
            first = received(socket, "picture", lambda picture: picture["width"] == 160 and picture["frame"] == 30)
            plugin.write_text(PLUGIN.replace("0.0, q.strength, 0.0", "q.strength, 0.0, 0.0"), encoding="utf-8")
            assert received(socket, "picture", lambda picture: picture["jpeg"] != first["jpeg"])
            plugin.write_text("import nothing_of_this_name", encoding="utf-8")
            assert "lift.py:1" in received(socket, "error")["text"]
            plugin.write_text(PLUGIN, encoding="utf-8")
            assert received(socket, "picture", lambda picture: picture["jpeg"] == first["jpeg"])
    finally:
        running.stop()


def test_broken_text_and_controls_at_once(studio):
    with studio.socket() as socket:
        received(socket, "document")
        send(socket, type="text", text="seed: [5")
        assert received(socket, "document", lambda state: state["problems"])
        send(socket, type="set", values={"seed": 3}, done=True)
        assert "mend it" in received(socket, "error")["text"]
        send(socket, type="undo")
        assert received(socket, "document")["text"] == TEXT
        send(socket, type="set", values={"clock.step": 0}, done=False)
        assert "clock.step" in received(socket, "error")["text"]
        send(socket, type="set", values={"clock.step": 0}, done=True)
        assert received(socket, "document")["problems"]
        send(socket, type="view", size=[640, 360], frame=12)
        assert received(socket, "picture", lambda picture: picture["frame"] == 12)["width"] == 640, (
            "in full: nothing moves"
        )


def test_numbers_that_json_does_not_have(studio):
    with studio.socket() as socket:
        received(socket, "document")
        send(socket, type="text", text=TEXT.replace("seed: 5", "seed: 1e999"))
        state = received(socket, "document", lambda state: state["problems"])
        assert state["problems"][0]["path"] == "seed"
