"""Ten minutes at the studio: its memory, and the page's, stay what they were."""

import random
import re
import time
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.studio.conftest import start, until
from tests.studio.piece import TEXT

MINUTES = 10
WARM = 3  # minutes in which kernels are compiled, snapshots are laid down and the history of undo fills
GROWTH = (
    0.05  # of the memory once warm: what collectors of garbage leave uncollected, and less than a picture each second
)
FIELDS = {"knobs.glow": (1, 9), "develop.exposure": (-1, 1), "knobs.push.value": (5, 13), "camera.fov": (25, 60)}


@pytest.fixture
def studio(tmp_path):
    """A studio of the fountain, with jets that can be steered."""
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT.replace("-9.81, 0]\n", "-9.81, 0]\n  thruster: {max_thrust: 0.01}\n"), encoding="utf-8")
    running = start(path)
    yield running
    running.stop()


def resident(process: int) -> int:
    """Bytes of memory that a process holds."""
    return int(re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{process}/status").read_text())[1]) * 1024


def in_the_page(devtools) -> int:
    """Bytes that the page's scripts hold, once their garbage is collected."""
    devtools.send("HeapProfiler.collectGarbage")
    measured = devtools.send("Performance.getMetrics")["metrics"]
    return next(int(one["value"]) for one in measured if one["name"] == "JSHeapUsedSize")


def work(page, choice: random.Random) -> None:
    """What somebody does within some seconds: numbers, seeds, the camera, the film, plots, undo, and the stick."""
    picture = page.locator("#picture")
    for path in choice.sample(sorted(FIELDS), 3):
        field = page.locator(f'[data-path="{path}"] input[type=text]')
        field.fill(str(round(choice.uniform(*FIELDS[path]), 3)))
        field.blur()
    page.locator('[data-path="seed"] button', has_text="dice").click()
    expect(picture).to_have_attribute("data-exact", "true")
    page.click("#undo")
    box = page.locator("#frame-holder").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 200 + choice.randint(-60, 60), box["y"] + 100, steps=8)
    page.mouse.up()
    page.locator("#scrub").fill(str(choice.randint(0, 59)))
    page.click("#tab-plots")
    page.click("#play")
    shown = int(picture.get_attribute("data-shown"))
    until(lambda: int(picture.get_attribute("data-shown")) > shown + 30)
    page.click("#play")
    page.click("#tab-controls")
    page.click("#steer")
    expect(page.locator("#notice")).to_contain_text("begins")
    page.keyboard.down("d")
    until(lambda: int(picture.get_attribute("data-frame")) > 20)
    page.keyboard.up("d")
    page.keyboard.press("Escape")
    expect(page.locator("body")).to_have_attribute("data-steering", "false")


@pytest.mark.proof
def test_ten_minutes_leave_the_memory_flat(page, studio):
    page.evaluate(
        "for (const group of document.querySelectorAll('#tree details')) { group.fill(); group.open = true; }"
    )
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable")
    choice, rounds, began = random.Random(3), 0, time.monotonic()
    by_minute = []  # (bytes of the studio, bytes of the page)
    while len(by_minute) < MINUTES:
        work(page, choice)
        rounds += 1
        if time.monotonic() - began >= 60 * (len(by_minute) + 1):
            by_minute.append((resident(studio.process.pid), in_the_page(devtools)))
    print(
        rounds,
        "rounds; megabytes of the studio and the page:",
        *(f"{a / 1e6:.0f}, {b / 1e6:.2f};" for a, b in by_minute),
    )
    for memory in np.array(by_minute, float).T:
        assert max(memory[WARM:]) <= (1 + GROWTH) * max(memory[:WARM])
