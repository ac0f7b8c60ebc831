"""A studio in a process of its own, as a user starts it, and a browser that looks at its page."""

import json
import os
import struct
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from playwright.sync_api import expect
from websockets.sync.client import connect

from tests.studio.piece import TEXT

ROOT = Path(__file__).parents[2]
PATIENCE = 120_000  # ms: kernels are compiled when they are first needed
expect.set_options(timeout=PATIENCE)


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


@pytest.fixture
def page(browser, studio):
    """The page with its first picture; what it prints to the console, or throws, makes the test fail."""
    page = browser.new_page(viewport={"width": 1360, "height": 820})
    wrong: list[str] = []

    def listen(message):
        lost = message.text.startswith("WebSocket connection to")  # by tests that kill the studio
        if message.type in ("error", "warning") and not lost:
            wrong.append(message.text)

    page.on("console", listen)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.set_default_timeout(PATIENCE)
    page.goto(studio.address)
    expect(page.locator("#picture")).to_have_attribute("data-exact", "true")
    has_own_size = "picture => picture.width === picture.clientWidth"  # the first one may be as large as none asked for
    until(lambda: page.locator("#picture").evaluate(has_own_size))
    yield page
    page.close()
    assert wrong == []


def until(holds, seconds: float = PATIENCE / 1000):
    """Wait until something holds; a test that waits in vain fails."""
    end = time.monotonic() + seconds
    while not (found := holds()):
        assert time.monotonic() < end, "it did not come about"
        time.sleep(0.02)
    return found
