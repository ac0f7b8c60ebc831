"""The studio's page in a browser: what a person does there, and that page, text and picture stay in step."""

import random
import re

import pytest
from playwright.sync_api import expect
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from tests.studio.conftest import start, until
from tests.studio.piece import TEXT

WIDTHS = (390, 820, 1360)


def shown(page) -> int:
    return int(page.locator("#picture").get_attribute("data-shown"))


def pixels(page) -> str:
    return page.evaluate("document.getElementById('picture').toDataURL()")


def text(page) -> str:
    return page.locator("#text").input_value()


def open_all(page) -> None:
    """Open the groups of controls, also those inside others."""
    for _ in range(8):  # as deep as they lie in each other
        page.evaluate(
            "for (const group of document.querySelectorAll('#tree details')) { group.fill(); group.open = true; }"
        )


def turn(page, name: str, value: int) -> None:
    """Write a knob's value into its field, and wait for the text to have it."""
    field = knob(page, name).locator("input[type=text]")
    field.fill(str(value))
    field.blur()
    until(lambda: f"{name}: {value}" in text(page))


def knob(page, name: str):
    return page.locator(f'#knobs [data-path="knobs.{name}"]')


def test_a_slider_changes_the_picture_and_the_text(page):
    before = pixels(page)
    slider = knob(page, "push.value").locator("input[type=range]")
    box = slider.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.9, box["y"] + box["height"] / 2, steps=6)
    page.mouse.up()
    value = until(lambda: (match := re.search(r"push: \{value: ([\d.]+)", text(page))) and match[1] != "9" and match[1])
    assert 11 < float(value) < 14
    expect(knob(page, "push.value").locator("input[type=text]")).to_have_value(value)
    until(lambda: page.locator("#picture").get_attribute("data-exact") == "true" and pixels(page) != before)
    assert "# how fast" in text(page), "comments stay"
    expect(page.locator("#saved")).to_have_text("mine.yaml, changed")


def test_every_key_of_the_preset_has_a_control(page):
    open_all(page)
    found = {row.get_attribute("data-path") for row in page.locator("#controls [data-path]").all()}

    def leaves(data, path=""):
        if isinstance(data, dict) and data:
            return {leaf for key, item in data.items() for leaf in leaves(item, f"{path}.{key}" if path else key)}
        return {path}

    data = YAML(typ="safe").load(TEXT)
    wanted = leaves({key: value for key, value in data.items() if key not in ("version", "knobs")})
    assert wanted <= found and {"knobs.push.value", "knobs.glow"} <= found


def test_keys_that_the_preset_lacks_are_found_and_added(page):
    for key in ("vignette", "fog", "drag", "ground"):
        page.fill("#search", key)
        button = page.locator("#offers button").filter(has_text=re.compile(rf"^add ([\w.]*\.)?{key}$")).first
        button.click()
        until(lambda key=key: f"{key}:" in text(page))
        expect(page.locator("#problem")).to_be_hidden()


@pytest.mark.parametrize("edits", [60, pytest.param(200, marks=pytest.mark.proof)])
def test_text_and_controls_agree_after_many_edits(page, edits):
    """Random values by the fields of numbers, every tenth by the text, now and then undone."""
    choice = random.Random(7)
    open_all(page)
    paths = ["knobs.push.value", "knobs.glow", "seed", "develop.exposure", "camera.fov"]

    def agree():
        try:
            data = YAML(typ="safe").load(text(page))
        except YAMLError:  # looked at while the page puts another text in
            return False
        for path in paths:
            node = data
            for part in path.split("."):
                node = node[part]
            if float(page.locator(f'[data-path="{path}"] input[type=text]').input_value()) != float(node):
                return False
        return True

    for k in range(edits):
        path = choice.choice(paths)
        value = (
            choice.randint(0, 99)
            if path == "seed"
            else round(choice.uniform(*{"camera.fov": (20, 60)}.get(path, (0.5, 9))), 3)
        )
        if k % 25 == 24:
            page.click("#undo")
        elif k % 10 == 9:
            until(agree)  # nobody types into a text that changes under the hand
            page.click("#tab-yaml")
            page.fill("#text", re.sub(r"seed: \d+", f"seed: {choice.randint(100, 999)}", text(page)))
            page.locator("#text").blur()
            page.click("#tab-controls")
        else:
            field = page.locator(f'[data-path="{path}"] input[type=text]')
            field.fill(str(value))
            field.blur()

    until(agree)
    expect(page.locator("#problem")).to_be_hidden()
    assert "# A fountain for the studio." in text(page) and "# shrinks" in text(page)


def test_what_is_being_typed_stays_under_the_hand(page, studio):
    """A value that comes from elsewhere goes into a field that is selected, but not into one that is typed in."""
    field = knob(page, "glow").locator("input[type=text]")
    field.select_text()
    studio.path.write_text(TEXT.replace("glow: 3", "glow: 4"), encoding="utf-8")
    expect(field).to_have_value("4")
    page.keyboard.type("1.")
    expect(field).to_have_value("1.")
    studio.path.write_text(TEXT.replace("glow: 3", "glow: 6"), encoding="utf-8")
    until(lambda: "glow: 6" in text(page))
    page.keyboard.type("5")
    expect(field).to_have_value("1.5")
    field.blur()
    until(lambda: "glow: 1.5" in text(page))


def test_a_field_that_is_left_as_it_was_shows_what_came_meanwhile(page, studio):
    field = knob(page, "glow").locator("input[type=text]")
    field.focus()
    page.keyboard.press("End")
    page.keyboard.type("1")
    studio.path.write_text(TEXT.replace("glow: 3", "glow: 6"), encoding="utf-8")
    until(lambda: "glow: 6" in text(page))
    page.keyboard.press("Backspace")
    field.blur()
    expect(field).to_have_value("6")


def test_problems_stand_at_their_lines_and_the_last_picture_stays(page):
    before = pixels(page)
    page.click("#tab-yaml")
    page.fill("#text", TEXT.replace("fov: 40", "fov: 400"))
    expect(page.locator("#lines .bad")).to_have_text(f"{TEXT[: TEXT.index('fov: 40')].count(chr(10)) + 1}\n")
    expect(page.locator("#problems")).to_contain_text("camera.fov")
    assert pixels(page) == before
    page.locator("#problems button").first.click()
    assert page.evaluate("document.getElementById('text').selectionStart") == TEXT.index("40, size")
    page.fill("#text", TEXT.replace("fov: 40", "fov: 20"))
    expect(page.locator("#problems li")).to_have_count(0)
    until(lambda: pixels(page) != before)


def test_undo_and_redo(page):
    field = knob(page, "glow").locator("input[type=text]")
    expect(page.locator("#undo")).to_be_disabled()
    field.fill("7")
    field.blur()
    until(lambda: "glow: 7" in text(page))
    page.click("#undo")
    until(lambda: text(page) == TEXT)
    expect(field).to_have_value("3")
    page.click("#redo")
    until(lambda: "glow: 7" in text(page))


def test_the_mouse_orbits_pans_and_dollies_the_camera(page):
    def numbers(key):
        return [float(x) for x in re.search(rf"{key}: \[([^\]]+)\]", text(page))[1].split(",")]

    def distance():
        return sum((a - b) ** 2 for a, b in zip(numbers("position"), numbers("target"))) ** 0.5

    box = page.locator("#frame-holder").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def drag(dx, dy):
        before = text(page)
        page.mouse.move(*middle)
        page.mouse.down()
        page.mouse.move(middle[0] + dx, middle[1] + dy, steps=4)
        page.mouse.up()
        until(lambda: text(page) != before)

    drag(150, 0)
    assert numbers("target") == [0, 2, 0] and distance() == pytest.approx(9, rel=1e-3) and numbers("position")[0] < -3
    drag(0, 100)
    assert numbers("position")[1] > 5 and distance() == pytest.approx(9, rel=1e-3), "from above"
    page.keyboard.down("Shift")
    drag(0, 100)
    page.keyboard.up("Shift")
    assert numbers("target")[1] > 2.5 and distance() == pytest.approx(9, rel=1e-3)
    before = text(page)
    page.mouse.wheel(0, -400)
    until(lambda: text(page) != before)
    assert distance() == pytest.approx(9 * 2.718281828**-0.4, rel=0.02)


def test_the_keyboard_alone(page):
    page.locator("#frame-holder").focus()
    frame = int(page.locator("#picture").get_attribute("data-frame"))
    page.keyboard.press("ArrowRight")
    expect(page.locator("#picture")).to_have_attribute("data-frame", str(frame + 1))
    page.keyboard.press("Home")
    expect(page.locator("#picture")).to_have_attribute("data-frame", "0")
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_text("Pause")
    until(lambda: int(page.locator("#picture").get_attribute("data-frame")) > 3)
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_text("Play")
    page.keyboard.press("Shift+ArrowLeft")
    until(lambda: text(page) != TEXT)
    page.keyboard.press("Control+z")
    until(lambda: text(page) == TEXT)
    reached = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.id || document.activeElement.ariaLabel"))
    assert {"play", "scrub", "tab-controls", "search", "knobs.push.value, slider", "knobs.glow"} <= reached


def test_scrubbing_and_the_times_of_frames(page):
    page.locator("#scrub").fill("45")
    expect(page.locator("#picture")).to_have_attribute("data-frame", "45")
    expect(page.locator("#clock")).to_have_text("1.50 s, frame 45 of 60")


def test_nothing_overflows(page):
    def fits(width):
        box = page.locator("#picture").bounding_box()
        return box and box["x"] >= 0 and box["x"] + box["width"] <= width and box["width"] > 0.4 * min(width, 600)

    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 800})
        for tab in ("#tab-controls", "#tab-yaml", "#tab-plots"):
            page.click(tab)
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        until(lambda width=width: fits(width))


def test_plots_follow_the_film(page):
    page.click("#tab-plots")
    page.click("#play")
    expect(page.locator("#count-now")).to_have_text(re.compile(r"^\d+$"))
    expect(page.locator("#energy-now")).to_have_text(re.compile(r"^-?[\d.e+]+$"))
    page.click("#play")


def test_it_goes_on_when_the_studio_was_killed_and_comes_back(page, studio):
    studio.process.kill()
    studio.process.wait()
    expect(page.locator("#notice")).to_contain_text("does not answer")
    count = shown(page)
    again = start(studio.path, "--port", str(studio.port))
    until(lambda: shown(page) > count)
    turn(page, "glow", 6)
    again.stop()


def test_unsaved_changes_outlive_the_studio(page, studio):
    turn(page, "glow", 6)
    studio.stop()
    again = start(studio.path, "--port", str(studio.port))
    expect(page.locator("#notice")).to_contain_text("has your unsaved changes")
    until(lambda: "glow: 6" in text(page))
    page.keyboard.press("Control+s")
    until(lambda: "glow: 6" in studio.path.read_text(encoding="utf-8"))
    again.stop()


def test_a_refused_value_gives_way_to_the_one_that_stays(page):
    field = page.locator('[data-path="camera.fov"] input[type=text]')
    field.fill("abc")
    field.blur()
    expect(page.locator("#problem")).to_contain_text("camera.fov")
    expect(field).to_have_value("40")


def test_the_wheel_adds_up(page):
    box = page.locator("#frame-holder").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    for _ in range(10):
        page.mouse.wheel(0, -100)
    until(
        lambda: (
            float(re.search(r"position: \[[^,]+,[^,]+, ([^\]]+)\]", text(page))[1])
            == pytest.approx(9 * 2.718281828**-1, rel=0.02)
        )
    )


def test_a_second_page_watches_and_cannot_edit(page, studio, browser):
    second = browser.new_page()
    second.goto(studio.address)
    expect(second.locator("#saved")).to_contain_text("this one watches")
    assert second.evaluate("document.querySelector('aside').inert && document.querySelector('header').inert")
    second.close()


def test_the_file_is_saved(page, studio):
    turn(page, "glow", 6)
    page.keyboard.press("Control+s")
    expect(page.locator("#saved")).to_have_text("mine.yaml, saved")
    assert studio.path.read_text(encoding="utf-8") == TEXT.replace("glow: 3", "glow: 6")
