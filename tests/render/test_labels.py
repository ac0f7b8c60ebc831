"""Labels and axes: they stand where the camera projects their points, appear and disappear in time, and keep an alpha of their own."""

import hashlib
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.commands.main import run
from gen_art.font import FOLDER, characters, font, missing, text_size
from gen_art.output import job
from gen_art.output.rerun import rerun
from gen_art.preset.axes import Axes
from gen_art.preset.labels import Label
from gen_art.preset.load import load_preset
from gen_art.preset.verdicts import key
from gen_art.renderer.axes import draw_axes, tick_values
from gen_art.renderer.camera import Camera
from gen_art.renderer.labels import draw_labels, opacity_at

SIZE = (640, 360)


def piece(**more):
    data = {
        "name": "throw", "version": 1, "seed": 1, "clock": {"duration": 2, "fps": 10, "step": "1/100"},
        "systems": {
            "ball": {
                "particle": {"radius": 0.2, "lifetime": 1.5},
                "emitters": {"hand": {"count": 1, "velocity": [2, 1, 0]}},
                "look": {"draw": "sphere"},
            }
        },
        "camera": {"position": [0, 0, 10], "size": list(SIZE)},
    }  # fmt: skip
    return load_preset({**data, **more})


def drawn(*labels, camera=None, time=0.0, grey=0, means=None, size=SIZE, channels=3, taken=None) -> np.ndarray:
    picture = np.full((size[1], size[0], channels), grey, np.uint8)
    view = (camera or Camera()).at(time)
    draw_labels(picture, [Label.model_validate(label) for label in labels], view, time, means or {}, taken)
    return picture


def middle(picture, grey=0) -> np.ndarray:
    """(column, row) of the middle of the box of what was drawn."""
    rows, columns = np.nonzero((picture[..., :3] != grey).any(axis=2))
    return np.array([columns.min() + columns.max() + 1, rows.min() + rows.max() + 1]) / 2


CAMERAS = [
    Camera(),
    Camera(position=(3, 2, 7), target=(0.5, 0, 0), fov=55, roll=20),
    Camera(position=(3, 2, 7), height=6.0),
    Camera.from_spec(piece(camera={"position": [4, 1, 6], "orbit": 50}).camera),
]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("point", [(0.0, 0.0, 0.0), (1.2, -0.7, 0.4), (-1.0, 0.9, -2.0)])
def test_a_label_stands_at_its_projected_point(camera, point):
    """The letter o is round: its middle is that of the text across, and of its small letters down, up to half a pixel."""
    label = {"text": "o", "at": point, "offset": [0, 0], "size": 60}
    expected = camera.at(0.7).project([point], SIZE)[0, :2]
    found = middle(drawn(label, camera=camera, time=0.7))
    at_middle = middle(drawn({**label, "at": [0, 0, 0]}))
    shift = at_middle - np.array(SIZE) / 2  # of the letter from the point, the same everywhere
    assert abs(shift[0]) <= 1.0 and np.abs(found - shift - expected).max() <= 1.0


def test_a_line_ends_at_the_point_to_a_pixel():
    camera, point = CAMERAS[1], (1.0, 0.5, 0.3)
    expected = camera.at(0.0).project([point], SIZE)[0, :2]
    picture = drawn({"text": "here", "at": point, "line": True, "offset": [60, 50]}, camera=camera)[..., 0]
    column, row = expected.astype(int)
    assert picture[row, column] > 200  # the dot
    rows, columns = np.nonzero(picture > 30)
    left_of_text = columns < expected[0] + 8
    dot = np.array([columns[left_of_text].min() + 1.5, rows[left_of_text].max() - 0.5])
    assert np.abs(dot - expected).max() <= 1.5
    assert columns.max() > expected[0] + 60 * 0.5 and rows.min() < expected[1] - 40 * 0.5  # up and to the right


def test_a_moving_label_moves_by_parts_of_a_pixel():
    at = [
        middle_of_light(drawn({"text": "o", "at": [x, 0, 0], "offset": [0, 0], "size": 40})) for x in (0.0, 0.01, 0.02)
    ]
    moved = np.diff(at, axis=0)[:, 0]
    expected = Camera().at(0).scale(SIZE[1]) * 0.01 / 10
    assert (moved > 0).all() and moved.sum() == pytest.approx(2 * expected, abs=0.26) and expected < 0.6


def middle_of_light(picture):
    light = picture[..., 0].astype(float)
    return (light.sum(0) @ np.arange(light.shape[1])) / light.sum(), (
        light.sum(1) @ np.arange(light.shape[0])
    ) / light.sum()


def test_in_a_picture_it_follows_its_system_and_goes_with_it(tmp_path):
    label = {"text": "o", "follow": "ball", "offset": [0, 0], "size": 50, "color": "#ff0000"}
    for time, camera in ((0.0, {}), (1.0, {"position": [2, 3, 9], "orbit": 30})):
        preset = piece(labels=[label], camera={"position": [0, 0, 10], **camera, "size": list(SIZE)})
        picture = np.asarray(Image.open(job.still(preset, tmp_path / "a.png", time, overwrite=True)[0])).astype(int)
        red = np.stack([picture[..., 0] - picture[..., 1]] * 3, axis=2) > 60
        place = Camera.from_spec(preset.camera).at(time).project([[2 * time, time, 0]], SIZE)[0, :2]
        assert np.abs(middle(red) - place)[0] <= 1.0 and np.abs(middle(red) - place)[1] <= 4.0
    gone = np.asarray(Image.open(job.still(piece(labels=[label]), tmp_path / "a.png", 1.8, overwrite=True)[0])).astype(
        int
    )
    assert (gone[..., 0] - gone[..., 1]).max() < 30  # the ball has died


def test_the_same_bytes_in_stills_films_ranges_and_reruns(tmp_path):
    labels = [
        {"text": "v = 2 m/s", "follow": "ball", "line": True},
        {"text": "throw", "place": "top left", "from": 0.5},
    ]
    preset = piece(labels=labels, axes={"x": "0..3", "y": "0..2"})
    film = job.render(preset, tmp_path / "a_##.png")
    part = job.render(preset, tmp_path / "b_##.png", frames=[7, 8])
    (still,) = job.still(preset, tmp_path / "s.png", 0.7)
    (again,) = rerun(still, tmp_path / "r.png")
    digests = [hashlib.sha256(path.read_bytes()).hexdigest() for path in (*film[7:9], *part, still, again)]
    assert digests[0] == digests[2] == digests[4] == digests[5] and digests[1] == digests[3]
    (movie,) = job.render(preset, tmp_path / "a.gif", frames=range(8))
    (bare,) = job.render(piece(), tmp_path / "b.gif", frames=range(8))
    frames = []
    for path in (movie, bare):
        with Image.open(path) as shown:
            shown.seek(7)
            frames.append(np.asarray(shown.convert("RGB")).astype(int))
    assert np.abs(frames[0] - frames[1])[:40, :120].max() > 100


def test_fade():
    label = Label.model_validate({"text": "o", "place": "top", "from": 1.0, "until": 3.0, "fade": 0.5})
    times = [0.0, 1.0, 1.25, 1.5, 2.5, 2.75, 3.0, 4.0]
    assert [opacity_at(label, t) for t in times] == pytest.approx([0, 0, 0.5, 1, 1, 0.5, 0, 0])
    sudden = label.model_copy(update={"fade": 0.0})
    assert [opacity_at(sudden, t) for t in (0.99, 1.0, 2.99, 3.0)] == [0, 1, 1, 0]
    assert opacity_at(label.model_copy(update={"start": 0.0}), 0.0) == 1.0  # there from the first frame on
    text = {"text": "o", "place": "top", "from": 1.0, "fade": 0.5, "size": 80}
    full, half = (drawn(text, time=time).astype(int).max() for time in (2.0, 1.25))
    assert full == 255 and half == pytest.approx(127, abs=1) and not drawn(text, time=0.9).any()


def test_alpha_of_a_transparent_picture():
    clear = drawn({"text": "label", "place": "bottom right", "size": 60}, channels=4)
    black = drawn({"text": "label", "place": "bottom right", "size": 60})
    assert clear[..., 3].max() == 255 and not clear[:100, :, 3].any()
    over_black = clear[..., :3] * (clear[..., 3:] / 255.0)
    assert np.abs(over_black - black).max() <= 1.5
    halo = (clear[..., 3] > 100) & (clear[..., 0] < 20)
    assert halo.sum() > 200  # the outline covers too
    deep = np.zeros((SIZE[1], SIZE[0], 3), np.uint16)
    draw_labels(deep, [Label(text="label", place="bottom right", size=60)], Camera().at(0), 0.0, {})
    assert np.abs(deep / 257 - black).max() <= 0.5 + 1e-9


def test_outline_of_a_colour():
    """Mutant: an outline that is left out, or white whatever it is called."""
    label = {"text": "label", "place": "bottom right", "size": 60, "color": "navy"}
    red = drawn(label | {"outline": "#ff0000"}).astype(int)
    around = (red[..., 0] > 150) & (red[..., 1] < 20)
    assert around.sum() > 200 and not (red[..., 1] > 60).any()


def luminance(code):
    c = code / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


@pytest.mark.parametrize("color", ["white", "amber", "navy", "gray"])
@pytest.mark.parametrize("grey", [0, 60, 128, 255])
def test_text_stands_out_of_any_picture_by_itself_or_by_its_outline(color, grey):
    """WCAG 2 asks for 3 to 1 of large text: against the picture, or the outline against the letters and the picture."""
    picture = drawn({"text": "Hill", "place": [0.5, 0.5], "color": color, "size": 40}, grey=grey)
    levels = [
        0.2126 * luminance(r) + 0.7152 * luminance(g) + 0.0722 * luminance(b)
        for r, g, b in np.unique(picture.reshape(-1, 3), axis=0)
    ]
    assert (max(levels) + 0.05) / (min(levels) + 0.05) >= 3


def test_places_and_stacks():
    for place in ("top left", "top", "top right", "bottom left", "bottom", "bottom right"):
        at = middle(drawn({"text": "label", "place": place})) / SIZE
        assert (at[1] < 0.2) == place.startswith("top")
        assert (at[0] < 0.3) == place.endswith("left") and (at[0] > 0.7) == place.endswith("right")
    two = drawn({"text": "label", "place": "top left"}, {"text": "label", "place": "top left"})
    one = drawn({"text": "label", "place": "top left"})
    assert (two > 0).sum() == pytest.approx(2 * (one > 0).sum(), rel=0.05)
    below = drawn({"text": "label", "place": "top left"}, taken={"top left": 100})
    assert np.nonzero(below)[0].min() > 100
    assert np.abs(middle(drawn({"text": "HOH", "place": [0.25, 0.75], "anchor": "centre"})) - (160, 270)).max() < 3


def test_a_label_stays_in_the_picture_with_its_point_and_leaves_with_it():
    view = Camera().at(0)
    edge = 0.5 * SIZE[0] / view.scale(SIZE[1]) * 10
    inside = drawn({"text": "a long label", "at": [0.99 * edge, 0, 0]})
    assert np.nonzero(inside)[1].max() < SIZE[0] - 1
    leaving = drawn({"text": "a long label", "at": [1.1 * edge, 0, 0]})
    assert 0 < (leaving > 0).sum() < (inside > 0).sum()
    assert not drawn({"text": "a long label", "at": [5 * edge, 0, 0]}).any()


def test_behind_the_camera_a_label_is_hidden():
    assert not drawn({"text": "label", "at": [0, 0, 20]}, {"text": "label", "at": [0, 0, 10], "line": True}).any()
    assert drawn({"text": "label", "at": [0, 0, 20]}, camera=Camera(height=5.0)).any()  # which sees what is behind it


def test_a_narrow_picture_has_smaller_text():
    label = {"text": "a label of quite a few words", "place": "top"}
    narrow, wide = drawn(label, size=(120, 360)), drawn(label, size=(640, 360))
    for picture in (narrow, wide):
        columns = np.nonzero(picture)[1]
        assert columns.min() > 0 and columns.max() < picture.shape[1] - 1
    assert drawn(label, size=(8, 6)).shape == (6, 8, 3)


def test_size_scales_with_the_height():
    def height(size):
        return np.ptp(np.nonzero(drawn({"text": "H", "place": "top", "size": 100}, size=size))[0])

    assert height((1280, 720)) == pytest.approx(2 * height((640, 360)), abs=3)
    assert 65 < height((1280, 720)) < 100  # capitals of 100 pixels


def test_the_font_has_its_characters_and_knows_what_it_lacks():
    """A character that the font lacks would be drawn as its empty box."""
    letters = font(40)
    box = letters.getmask("\uffff").getbbox(), bytes(letters.getmask("\uffff"))
    for c in sorted(characters()):
        mask = letters.getmask(c)
        assert (mask.getbbox(), bytes(mask)) != box, f"U+{ord(c):04X}"
    for c in "aäßΩαµ²₀∇∂∫√≤≈·×−→∞ℏ°′Åẋ½":
        assert c in characters()
    assert missing("aЖb漢Ж\n") == ["Ж", "漢"]
    files = {path.name: path.stat().st_size for path in FOLDER.iterdir()}
    assert files["DejaVuSansCondensed-subset.ttf"] < 100_000 and files["LICENSE-DejaVu.txt"] > 4000
    assert text_size("ab", 20)[0] == pytest.approx(2 * text_size("ab", 10)[0])
    assert text_size("a\nb", 20)[1] == 2 * text_size("ab", 20)[1]


def test_verdicts_and_motion_know_nothing_of_labels():
    plain = piece()
    shown = piece(labels=["throw"], axes={"x": "0..1"}, camera={"position": [0, 0, 10], "frame": "auto"})
    assert key(plain, "1") == key(shown, "1") != key(piece(clock={"duration": 2, "fps": 10, "step": "1/200"}), "1")


@pytest.mark.parametrize(
    "label,sentence",
    [
        ("{text: 'Ж', place: top}", ":8:12: labels[0].text: the font has no Ж (U+0416): it has Latin, Greek and mathematical"),
        ("{text: a, follow: bal}", ":8:23: labels[0].follow: there is no system 'bal'; did you mean 'ball'?"),
        ("{text: a, place: midle}", ":8:22: labels[0].place: must be one of top left,"),
        ("{text: a, place: [2, 0]}", ":8:22: labels[0].place: [x, y] run from 0 at the left and top to 1 at the right and bottom, not [2, 0]"),
        ("{text: a, at: [0, 0]}", ":8:19: labels[0].at: must be three numbers"),
        ("{text: a}", ":8:5: labels[0]: give one of at, follow and place"),
        ("{text: a, at: [0, 0, 0], place: top}", ":8:5: labels[0]: give one of at, follow and place"),
        ("{text: a, place: top, line: true}", ":8:33: labels[0].line: a line leads to a point"),
        ("{text: a, place: top, from: 2, until: 1}", ":8:43: labels[0].until: must be later than `from`, 2 s; not 1"),
        ("{text: ' ', place: top}", "labels[0].text: must be text"),
        ("{text: a, place: top, size: 2}", "labels[0].size: must be from 6 to 360"),
        ("{text: a, place: top, colour: red}", "labels[0].colour: unknown key; did you mean 'color'?"),
        ("{text: a, place: top, color: rad}", "labels[0].color: no colour named"),
        ("{text: wwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwww, place: top, size: 60}", ":8:12: labels[0].text: the text is"),
        ("{text: 'a\\n\\n\\n\\n\\n\\nb', place: top, size: 200}", "labels[0].text: the text is"),
    ],
)  # fmt: skip
def test_validate_says_what_is_wrong_and_where(tmp_path, capsys, label, sentence):
    label = label.replace("'a\\n", '"a\\n').replace("\\nb'", '\\nb"')
    said = problems(tmp_path, capsys, f"labels:\n  - {label}\n")
    assert sentence in said and "Traceback" not in said


@pytest.mark.parametrize(
    "axes,sentence",
    [
        ("{}", ":7:1: axes: needs x, y or z"),
        ("{x: 3}", ":7:11: axes.x: an axis runs from one coordinate to another: write a range such as 0..4, not 3"),
        ("{x: {range: 0..4, step: 0.001}}", ":7:31: axes.x.step: would make 4,000 ticks"),
        ("{x: {range: 0..4, label: 漢}}", "axes.x.label: the font has no 漢"),
        ("{w: 0..3}", "axes.w: unknown key"),
    ],
)
def test_validate_says_what_is_wrong_with_axes(tmp_path, capsys, axes, sentence):
    said = problems(tmp_path, capsys, f"axes: {axes}\n")
    assert sentence in said and "Traceback" not in said


def problems(tmp_path, capsys, end: str) -> str:
    text = f"""\
# A.
# B.
# C.
version: 1
clock: {{duration: 1, fps: 10, step: 0.01}}
systems: {{ball: {{emitters: {{e: {{rate: 100}}}}, look: {{}}}}}}
{end}"""
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    assert run(["validate", str(tmp_path / "a.yaml")]) != 0
    said = capsys.readouterr()
    return said.out + said.err


def test_the_schema_knows_labels_and_axes():
    import jsonschema

    from gen_art.preset.schema import json_schema

    check = jsonschema.Draft202012Validator(json_schema())
    labels = ["short", {"text": "a", "at": [0, 1, 0], "line": True, "offset": [1, 2]}, {"text": "b", "place": [0.5, 0.1]},
              {"text": "c", "follow": "ball", "from": 1, "until": 2, "anchor": "centre"}]  # fmt: skip
    axes = {"x": "0..4", "y": {"range": "0..2", "label": "height (m)", "step": 0.5}}
    for frame in ("auto", False, 0.5, {"fill": 0.5, "stray": 0}):
        preset = piece(labels=labels, axes=axes, camera={"position": [0, 0, 10], "frame": frame})
        check.validate(preset.resolved())
        assert load_preset(json.loads(json.dumps(preset.resolved()))) == preset
    for wrong in ({"labels": [{"text": 3}]}, {"axes": {"w": 1}}, {"labels": [{"text": "a", "place": "middle"}]}):
        with pytest.raises(jsonschema.ValidationError):
            check.validate({**piece().resolved(), **wrong})


@pytest.mark.parametrize("low,high,expected", [(0, 4, [0, 1, 2, 3, 4]), (-3, 3, [-3, -2, -1, 0, 1, 2, 3]), (0, 0.3, [0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3]), (0, 1e9, [0, 2e8, 4e8, 6e8, 8e8, 1e9]), (0.5, 1.4, [0.6, 0.8, 1, 1.2, 1.4])])  # fmt: skip
def test_ticks_are_round(low, high, expected):
    axis = Axes.model_validate({"x": f"{low}..{high}"}).x
    assert tick_values(axis) == expected


def test_axes_run_where_the_camera_sees_them():
    axes = Axes.model_validate(
        {"x": "-2..2", "y": {"range": "0..1.5", "step": 0.5}, "color": "white", "origin": [-2, 0, 0]}
    )
    camera = Camera(position=(0, 0, 10), height=6)
    picture = np.zeros((360, 640, 3), np.uint8)
    draw_axes(picture, axes, camera.at(0), "m")
    for point in ([-2, 0, 0], [0.3, 0, 0], [1.9, 0, 0], [-2, 1.2, 0]):
        column, row = camera.at(0).project([point], (640, 360))[0, :2].round().astype(int)
        assert picture[row - 1 : row + 2, column - 1 : column + 2].max() > 150
    column, row = camera.at(0).project([[0.3, 0.5, 0]], (640, 360))[0, :2].round().astype(int)
    assert not picture[row - 5 : row + 5, column - 5 : column + 5].any()
    tick = camera.at(0).project([[1, 0, 0]], (640, 360))[0, :2].round().astype(int)
    plain = camera.at(0).project([[0.7, 0, 0]], (640, 360))[0, :2].round().astype(int)
    above = [picture[place[1] - 3, place[0] - 1 : place[0] + 2].max() for place in (tick, plain)]
    assert above[0] > 100 > above[1]


def test_axes_behind_the_camera_end_before_it():
    axes = Axes.model_validate({"x": "-5..5", "z": "-50..50"})
    picture = np.zeros((90, 160, 3), np.uint8)
    draw_axes(picture, axes, Camera(position=(0.5, 2, 10)).at(0), "m")
    assert 0 < (picture > 100).any(axis=2).mean() < 0.2
    nothing = np.zeros((90, 160, 3), np.uint8)
    draw_axes(nothing, Axes.model_validate({"z": "20..50"}), Camera(position=(0.5, 2, 10)).at(0), "m")
    assert not nothing.any()


def test_linear_pictures_have_no_labels(tmp_path):
    pytest.importorskip("OpenEXR")
    one, two = (
        job.still(piece(**more), tmp_path / f"{k}.exr", 0.5)[0] for k, more in enumerate(({}, {"labels": ["text"]}))
    )
    import OpenEXR

    pixels = []
    for path in (one, two):
        with OpenEXR.File(str(path)) as file:
            pixels.append(next(iter(file.channels().values())).pixels.copy())
    assert np.array_equal(*pixels)


def test_the_licence_of_the_font_lies_beside_it_in_the_wheel():
    text = (FOLDER / "LICENSE-DejaVu.txt").read_text(encoding="utf-8")
    assert re.search(r"Permission is hereby granted", text) and FOLDER.parent == Path(ga.__file__).parent
