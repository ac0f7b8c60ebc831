"""Ten minutes at the studio: its memory, and the browser's, stay what they were."""

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
WARM = 5  # minutes in which kernels are compiled, snapshots are laid down and the history of undo fills
PICTURE = 320 * 180 * 4  # bytes: what each round may leave behind, of the hundred pictures and more that it shows
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


def of_scripts(devtools) -> int:
    """Bytes that the page's scripts hold, once their garbage is collected."""
    devtools.send("HeapProfiler.collectGarbage")
    measured = devtools.send("Performance.getMetrics")["metrics"]
    return next(int(one["value"]) for one in measured if one["name"] == "JSHeapUsedSize")


def of_tab(browser) -> int:
    """Bytes of memory that the processes of the browser's tabs hold, which also have the pictures."""
    listed = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    return sum(resident(one["id"]) for one in listed if one["type"] == "renderer")


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
def test_ten_minutes_leave_the_memory_flat(page, studio, browser):
    page.evaluate(
        "for (const group of document.querySelectorAll('#tree details')) { group.fill(); group.open = true; }"
    )
    devtools = page.context.new_cdp_session(page)
    devtools.send("Performance.enable")
    choice, rounds, began = random.Random(3), 0, time.monotonic()
    readings = []  # each minute: the rounds until then; bytes of the studio, the tab, and the page's scripts
    while len(readings) < MINUTES:
        work(page, choice)
        rounds += 1
        if time.monotonic() - began >= 60 * (len(readings) + 1):
            readings.append((rounds, resident(studio.process.pid), of_tab(browser), of_scripts(devtools)))
    print(
        "rounds; megabytes of studio, tab, scripts:",
        *(f"{n}; {a:.0f}, {b:.0f}, {c:.1f}" for n, a, b, c in np.array(readings) / [1, 1e6, 1e6, 1e6]),
        sep="\n",
    )
    done, *memories = np.array(readings).T
    for memory in memories:
        assert memory[WARM:].max() - memory[:WARM].max() <= PICTURE * (done[-1] - done[WARM - 1])
