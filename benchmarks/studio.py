"""How soon does the studio show a change? From the message of the page to the picture, beside drawing one frame."""

import json
import os
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from _bench import ROOT, Bench
from websockets.sync.client import connect

from gen_art.output.player import Player
from gen_art.preset.load import load_preset

bench = Bench("studio", __doc__)
SIZE = (64, 36) if bench.quick else (640, 360)
TURNS = 2 if bench.quick else 15
FRAME = 1 if bench.quick else 30
PIECE = {"knobs": {"fuel": {"value": 2000 if bench.quick else 60000}}}
# what is changed, its values in turns, and how many times the drawing of one frame it may take
CHANGES = {
    "develop": ("develop.exposure", (0.5, 1.0), 2.0),
    "look": ("systems.flame.look.radius", (0.0150, 0.0146), 2.0),
    "force": ("knobs.turbulence", (1.5, 2.0), 5.0),
}
bench.settings = {"preset": "fire", "size": SIZE, "frame": FRAME, "turns": TURNS}


def of_frame() -> float:
    """Median seconds of drawing and developing one frame of the film, without the steps before it."""
    preset = load_preset("fire", PIECE)
    player = Player()
    player.change(preset)
    player.show(FRAME, SIZE)
    assert player.sim is not None and player.playback is not None
    seconds = []
    for frame in range(FRAME + 1, FRAME + 1 + TURNS):
        player.sim.step(preset.clock.steps_per_frame)
        started = time.perf_counter()
        linear = player.playback.painter.paint(player.sim, frame / preset.clock.fps)
        player.playback.developed(linear, 0.0, frame)
        seconds.append(time.perf_counter() - started)
    player.close()
    return statistics.median(seconds)


def received(socket) -> dict:
    """The next picture's header, which is confirmed as the page does."""
    while True:
        data = socket.recv(timeout=300)
        if isinstance(data, bytes):
            socket.send('{"type": "shown"}')
            return json.loads(data[4 : 4 + struct.unpack(">I", data[:4])[0]])


def quiet(socket) -> None:
    """Wait until no picture has come for a second: the motion is computed, the picture whole."""
    while True:
        try:
            data = socket.recv(timeout=1.0)
            if isinstance(data, bytes):
                socket.send('{"type": "shown"}')
        except TimeoutError:
            return


drawing = of_frame()
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "fire.yaml"
    subprocess.run(
        [sys.executable, str(ROOT / "cli.py"), "new", str(path), "--from", "fire"], check=True, capture_output=True
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "gen_art", "studio", str(path), "--no-browser"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment)
    try:
        assert server.stdout is not None
        address = server.stdout.readline().strip()
        host, token = address.split("/")[2], address.split("token=")[1]
        rows = [("change", "ms", "drawing one frame", "ratio")]
        with connect(f"ws://{host}/ws?token={token}", origin=f"http://{host}", max_size=2**26) as socket:
            socket.send(
                json.dumps({"type": "set", "values": {"knobs.fuel": PIECE["knobs"]["fuel"]["value"]}, "done": True})
            )
            socket.send(json.dumps({"type": "view", "size": SIZE, "frame": FRAME}))
            received(socket)
            for name, (key, values, most) in CHANGES.items():
                seconds = []
                for k in range(TURNS + 2):  # the first two load kernels
                    quiet(socket)
                    started = time.perf_counter()
                    socket.send(json.dumps({"type": "set", "values": {key: values[k % 2]}, "done": True}))
                    received(socket)
                    seconds.append(time.perf_counter() - started)
                taken = statistics.median(seconds[2:])
                bench.figures[name] = {"seconds": taken, "drawing": drawing}
                rows.append((name, f"{1e3 * taken:.0f}", f"{1e3 * drawing:.0f}", f"{taken / drawing:.1f}"))
                bench.require(f"a change of a {name}, times the drawing of a frame", taken / drawing, at_most=most)
    finally:
        server.terminate()
        server.wait()
bench.table(rows)
bench.finish()
