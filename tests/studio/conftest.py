"""A studio in a process of its own, as a user starts it, and a browser that looks at its page."""

import json
import os
import struct
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from websockets.sync.client import connect

from tests.studio.piece import TEXT

ROOT = Path(__file__).parents[2]


@dataclass
class Running:
    """A studio that runs: its process, address, port, token, and the preset's file."""

    process: subprocess.Popen
    address: str
    path: Path
    port: int = field(init=False)
    token: str = field(init=False)

    def __post_init__(self):
        parts = urlsplit(self.address)
        assert parts.port is not None
        self.port, self.token = parts.port, parse_qs(parts.query)["token"][0]

    def socket(self, token: str | None = None, origin: str | None = None):
        """A websocket as the page opens it."""
        address = f"ws://127.0.0.1:{self.port}/ws?token={self.token if token is None else token}"
        return connect(address, origin=origin or f"http://127.0.0.1:{self.port}", max_size=2**26)

    def stop(self) -> int:
        self.process.terminate()
        return self.process.wait(60)


def start(path: Path, *arguments: str) -> Running:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(
        [sys.executable, "-m", "gen_art", "studio", str(path), "--no-browser", *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
    )  # fmt: skip
    assert process.stdout is not None and process.stderr is not None
    address = process.stdout.readline().strip()
    assert address, process.stderr.read()
    return Running(process, address, path)


@pytest.fixture
def studio(tmp_path):
    """A studio of the small piece."""
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT, encoding="utf-8")
    running = start(path)
    yield running
    if running.process.poll() is None:
        running.stop()


def received(socket, kind: str, holds=lambda message: True) -> dict:
    """The next message of a kind that holds; pictures are confirmed as the page does, and come with their bytes as "jpeg"."""
    while True:
        data = socket.recv(timeout=120)
        if isinstance(data, bytes):
            length = struct.unpack(">I", data[:4])[0]
            message = {**json.loads(data[4 : 4 + length]), "jpeg": data[4 + length :]}
            socket.send(json.dumps({"type": "shown"}))
        else:
            message = json.loads(data)
        if message["type"] == kind and holds(message):
            return message
