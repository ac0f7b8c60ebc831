"""`ga.play`: its pictures are those of the film, its page and its kernel agree, and what cannot be is a sentence."""

import base64
import io
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import expect

import gen_art as ga
from gen_art.renderer.render_frame import render_frame

PAGE = Path(ga.__file__).parent / "output" / "notebook_page"
SIZE = (96, 54)
PIECE = """# Sparks in the wind.
# Physics: gravity.
version: 1
seed: 5
knobs: {pull: {value: -2, range: -6..6, unit: m/s^2}, glow: 0.4}
clock: {duration: 1, fps: 25, step: 1/50}
camera: {position: [0, 0, 6], size: [640, 360]}
forces: {gravity: [0, $pull, 0]}
systems:
  sparks:
    particle: {radius: 0.12}
    emitters: {base: {count: 30, shape: {sphere: 0.8}}}
    look: {draw: disc, emission: {color: "#ffaa55", intensity: $glow}}
"""


@pytest.fixture
def piece(tmp_path):
    path = tmp_path / "piece.yaml"
    path.write_text(PIECE, encoding="utf-8")
    return path


def picture(player) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(player.picture)).convert("RGB")).astype(float)


def expected(piece, frame, **more) -> np.ndarray:
    preset = ga.load_preset(piece, **more)
    sim = ga.Simulation(preset)
    sim.advance_to_frame(frame)
    linear = render_frame(sim, size=SIZE)
    return np.asarray(ga.develop(linear, spec=preset.develop, frame=frame))[..., :3].astype(float)


def apart(a, b) -> float:
    """Mean difference of two pictures in levels; a JPEG of this quality differs by about one from what it is of."""
    return float(np.abs(a - b).mean())


def test_each_picture_is_that_of_the_film(piece):
    player = ga.play(piece, size=SIZE, frame=3)
    assert (player.frame, player._frames, player._fps, player.seed) == (3, 25, 25.0, 5)
    shown = {}
    for frame in (20, 4, 24):
        player.frame = frame
        shown[frame] = picture(player)
        assert shown[frame].shape == (*SIZE[::-1], 3) and shown[frame].max() > 60
        right, wrong = (
            apart(shown[frame], expected(piece, frame)),
            apart(shown[frame], expected(piece, (frame + 12) % 25)),
        )
        assert right < 0.25 * wrong, (right, wrong)
    player.frame = 99
    assert player.frame == 24 and np.array_equal(picture(player), shown[24])
    player.close()


def test_seed_and_knobs_are_those_of_the_preset(piece):
    player = ga.play(str(piece), size=SIZE, frame=20)
    assert player.knobs == {"pull": -2.0} and [one["name"] for one in player._sliders] == ["pull"]  # glow has no range
    before = picture(player)
    player.seed = 8
    assert player.preset.seed == 8 and player._drawn == 2
    other = picture(player)
    assert apart(other, expected(piece, 20, seed=8)) < 0.25 * apart(other, before)
    player.knobs = {"pull": 5.0}
    raised = picture(player)
    assert apart(raised, expected(piece, 20, seed=8, overrides={"knobs.pull": 5.0})) < 0.25 * apart(raised, other)
    # as it was: the motion is computed from its start, with no trace of what was shown between
    player.knobs = {"pull": -2.0}
    player.seed = 5
    assert np.array_equal(picture(player), before)
    player.close()


def test_what_cannot_be_is_a_sentence_and_the_picture_stays(piece):
    player = ga.play(piece, size=SIZE)
    kept = player.picture
    player.seed = -1
    assert "must be a whole number" in player.problem and player.picture == kept and player.preset.seed == 5
    player.seed = 6
    assert player.problem == "" and player.picture != kept
    player.close()
    with pytest.raises(ga.UsageError, match=r"frame must be .* 24, not 25"):
        ga.play(piece, frame=25)
    for size in (320, (320, 0), (320, 180, 3), "wide"):
        with pytest.raises(ga.UsageError, match="size"):
            ga.play(piece, size=size)
    with pytest.raises(ga.UsageError, match="no preset"):
        ga.play("no_such_piece")


def test_the_shape_is_the_cameras_and_a_preset_without_knobs_has_no_sliders(piece):
    plain = ga.load_preset(piece)
    player = ga.play(plain.resolved())
    assert player._size == [480, 270] and player._sliders == [] and player.knobs == {}
    player.close()


# A model as the front end of a notebook has it: what the page saves is kept in `sent`.
HARNESS = """
<!doctype html><meta charset="utf-8"><style>CSS</style><div id="at"></div>
<script type="module">
SCRIPT
const state = STATE, listeners = {};
window.sent = [];
const fire = (name) => (listeners["change:" + name] || []).forEach((act) => act());
const bytes = (text) => new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
state.picture = bytes(state.picture);
const model = {
  get: (name) => state[name],
  set(name, value) { state[name] = value; window.sent.push([name, value]); fire(name); },
  save_changes() {},
  on(event, act) { (listeners[event] = listeners[event] || []).push(act); },
  off(event, act) { listeners[event] = listeners[event].filter((one) => one !== act); },
};
window.receive = (values) => { Object.assign(state, values); Object.keys(values).forEach(fire); };
window.drawn = (frame) => window.receive({ _shown: frame, _drawn: state._drawn + 1 });
window.close = page.render({ model, el: document.getElementById("at") });
window.listening = () => Object.values(listeners).flat().length;
</script>
"""


@pytest.fixture
def page(browser, piece, tmp_path):
    player = ga.play(piece, size=SIZE)
    names = ["frame", "seed", "knobs", "problem", "_drawn", "_shown", "_frames", "_fps", "_size", "_sliders", "_title"]
    state = {name: getattr(player, name) for name in names}
    state["picture"] = base64.b64encode(player.picture).decode()
    player.close()
    script = (PAGE / "player.js").read_text(encoding="utf-8").replace("export default", "const page =")
    html = HARNESS.replace("CSS", (PAGE / "player.css").read_text(encoding="utf-8")).replace("SCRIPT", script)
    (tmp_path / "page.html").write_text(html.replace("STATE", json.dumps(state)), encoding="utf-8")
    opened = browser.new_page(viewport={"width": 700, "height": 500})
    problems: list[str] = []
    opened.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
    opened.on("pageerror", lambda error: problems.append(str(error)))
    opened.goto((tmp_path / "page.html").as_uri())
    yield opened
    assert problems == []
    opened.close()


def sent(page) -> list:
    return page.evaluate("window.sent.splice(0)")


def sent_soon(page) -> list:
    while not (found := sent(page)):
        page.wait_for_timeout(10)
    return found


def test_the_page_shows_the_picture_and_its_numbers(page):
    image = page.locator("img")
    expect(image).to_have_js_property("naturalWidth", SIZE[0])
    assert image.get_attribute("alt") == "Sparks in the wind."
    assert page.get_by_label("frame").get_attribute("max") == "24"
    assert page.get_by_label("seed").input_value() == "5"
    assert page.locator(".knobs output").inner_text() == "-2 m/s^2"
    assert page.locator(".bar > output").inner_text() == "0.00 s"
    page.evaluate("window.drawn(10)")
    assert page.locator(".bar > output").inner_text() == "0.40 s" and page.get_by_label("frame").input_value() == "10"
    assert sent(page) == []


def test_slider_seed_and_knobs_are_sent(page):
    page.get_by_label("frame").focus()
    page.keyboard.press("ArrowRight")
    assert sent(page) == [["frame", 1]]
    page.get_by_label("seed").fill("12")
    page.keyboard.press("Enter")
    assert sent(page) == [["seed", 12]]
    page.get_by_label("seed").fill("-3")
    page.keyboard.press("Enter")
    assert sent(page) == [] and page.get_by_label("seed").input_value() == "12"
    page.get_by_title("another seed").click()
    ((name, value),) = sent(page)
    player = page.locator(".gen-art-player")
    assert player.get_attribute("aria-busy") == "true"
    page.evaluate("window.drawn(0)")
    assert player.get_attribute("aria-busy") is None
    assert name == "seed" and value >= 0 and page.get_by_label("seed").input_value() == str(value)
    page.get_by_label("pull").focus()
    page.keyboard.press("Home")
    assert sent(page) == [["knobs", {"pull": -6}]]


def test_play_asks_for_a_frame_when_the_one_before_is_there(page):
    page.get_by_title("play the film").click()
    assert sent(page) == [["frame", 1]]
    page.evaluate("window.drawn(1)")
    assert sent_soon(page) == [["frame", 2]]
    page.evaluate("window.drawn(24)")
    assert sent_soon(page) == [["frame", 0]]  # the film begins anew
    page.evaluate("window.receive({ problem: 'memory is short' })")
    assert page.get_by_role("alert").inner_text() == "memory is short"
    page.evaluate("window.drawn(0)")
    page.wait_for_timeout(100)
    assert sent(page) == []  # it has stopped
    assert page.evaluate("(window.close(), window.listening())") == 0
