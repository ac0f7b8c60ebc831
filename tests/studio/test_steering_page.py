"""Steering in the studio's page: by keyboard and mouse, with instruments, again, kept, left."""

import numpy as np
import pytest
from playwright.sync_api import expect

from tests.studio.conftest import start, until
from tests.studio.test_steering import TEXT


@pytest.fixture
def studio(tmp_path):
    """A studio of a piece that can be steered, in place of the fountain."""
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT.replace("duration: 3", "duration: 60"), encoding="utf-8")
    running = start(path)
    yield running
    running.stop()


def steer(page) -> None:
    page.click("#steer")
    expect(page.locator("body")).to_have_attribute("data-steering", "true")
    expect(page.locator("#notice")).to_contain_text("begins")


def frame(page) -> int:
    return int(page.locator("#picture").get_attribute("data-frame"))


def value(page, name: str) -> float:
    return float(page.locator(f"#inputs meter[aria-label={name}]").evaluate("meter => meter.value"))


def test_keys_steer_and_what_was_steered_becomes_a_film(page, studio):
    steer(page)
    assert frame(page) == 0
    text = page.locator("#text").input_value()
    page.keyboard.down("d")
    until(lambda: value(page, "x") == 1.0)
    assert page.locator("#picture").get_attribute("data-frame") != "0"
    page.keyboard.up("d")
    page.keyboard.down("ArrowDown")
    until(lambda: value(page, "x") == 0.0 and value(page, "y") == -1.0)
    page.keyboard.up("ArrowDown")
    page.keyboard.press("Control+z")  # neither the transport nor the text takes a key meanwhile
    page.keyboard.press("End")
    assert page.locator("#text").input_value() == text
    page.click("#keep")
    expect(page.locator("#kept")).to_contain_text("mine_thruster_1.csv")
    expect(page.locator("body")).to_have_attribute("data-steering", "false")
    expect(page.locator("#cockpit")).to_be_hidden()
    until(lambda: "controls: mine_thruster_1.csv" in page.locator("#text").input_value())
    rows = np.loadtxt(studio.path.with_name("mine_thruster_1.csv"), delimiter=",", skiprows=1)
    assert rows[:, 1].max() == 1.0 and rows[:, 2].min() == -1.0 and rows[:, 3].any() is np.False_
    page.keyboard.press("Control+s")
    expect(page.locator("#saved")).to_have_text("mine.yaml, saved")


def test_the_mouse_moves_the_attractor_and_not_the_camera(page):
    camera = page.locator("#text").input_value()
    steer(page)
    box = page.locator("#picture").bounding_box()
    page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.8 * box["width"], box["y"] + 0.25 * box["height"], steps=5)
    shown = page.locator("#inputs dd:nth-of-type(3n+2)")
    until(lambda: float(shown.nth(1).text_content().split()[0]) > 0.5)  # x to the right
    until(lambda: float(shown.nth(2).text_content().split()[0]) > 0.3)  # y above the middle
    page.mouse.up()
    page.keyboard.press("Escape")
    expect(page.locator("body")).to_have_attribute("data-steering", "false")
    until(lambda: page.locator("#picture").get_attribute("data-exact") == "true")
    assert page.locator("#text").input_value() == camera
    expect(page.locator("#play")).to_be_enabled()


def test_again_begins_at_the_start_and_a_gamepad_steers(page):
    page.evaluate(
        """navigator.getGamepads = () => [null, {axes: [0.05, -0.9, 0, 0], buttons: Array(16).fill({value: 0})}]"""
    )
    page.click("#steer")
    until(
        lambda: page.locator("#inputs meter").count() and 0.85 < value(page, "y") < 0.95
    )  # beyond the dead zone, of the rest
    assert value(page, "x") == 0.0, "a stick at rest is at rest"
    page.evaluate("navigator.getGamepads = () => []")
    page.click("#again")
    expect(page.locator("#notice")).to_contain_text("begins")
    assert frame(page) == 0


def test_a_preset_with_nothing_to_steer_has_no_button(page, studio):
    expect(page.locator("#steer")).to_be_visible()
    page.click("#tab-yaml")
    page.fill(
        "#text",
        TEXT.replace("thruster: {max_thrust: 30}   # newtons", "damping: 1").replace(
            "attractor: {GM: 4, softening: 0.3}", ""
        ),
    )
    expect(page.locator("#steer")).to_be_hidden()


def test_the_instruments_fit_the_page(page):
    steer(page)
    for width in (390, 820, 1360):
        page.set_viewport_size({"width": width, "height": 800})
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        for part in ("#dials", "#inputs", "#leave"):
            box = page.locator(part).bounding_box()
            assert box["x"] >= 0 and box["x"] + box["width"] <= width, part
