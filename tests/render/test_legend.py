"""Looks that go by joules, and their legends: the colours are those of the shares, the total is the ledger's, the text is readable."""

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.commands.main import run
from gen_art.output import job
from gen_art.output.read_recipe import read_recipe
from gen_art.output.rerun import rerun
from gen_art.particles.entries import LedgerEntry
from gen_art.preset.load import load_preset
from gen_art.renderer.legend import PLATE, DrawnLegend, draw_legends, joules_text, legend_of
from gen_art.renderer.look_tables import LookTables
from gen_art.renderer.painter import Painter
from tests.render.particles import scene, state

F = ga.forces
GRADIENT = ["#0000ff", "white", "#ff0000"]
LOOK = {
    "draw": "disc", "radius": 0.05, "legend": True,
    "emission": {"color": {"by": {"dissipated": "drag"}, "range": "0..0.02", "gradient": GRADIENT}},
}  # fmt: skip


def piece(look=LOOK, **overrides):
    data = {
        "name": "falling", "version": 1, "seed": 5, "clock": {"duration": 0.5, "fps": 20, "step": "1/80", "preroll": 0.25},
        "medium": {"density": 1.2, "wind": [1, 0, 0]},
        "forces": {"gravity": [0, -9.81, 0], "drag": {"cd": 0.5}},
        "systems": {
            "dust": {
                "particle": {"lifetime": "0.3..0.8", "radius": 0.02, "density": 200},
                "emitters": {"jet": {"rate": 400, "velocity": {"cone": [0, 1, 0], "angle": 30, "speed": "3..5"}}},
                "look": look,
            }
        },
        "camera": {"position": [0, 0.5, 5], "target": [0, 0.5, 0], "size": [320, 180]},
    }  # fmt: skip
    return load_preset(data, overrides={key.replace("__", "."): value for key, value in overrides.items()})


def pixels(path) -> np.ndarray:
    return np.asarray(Image.open(path))


def digest(path) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def ledger_at(preset, time: float) -> "ga.Simulation":
    sim = ga.Simulation(preset)
    sim.step(preset.clock.step_at(time))
    return sim


ENTRIES = (LedgerEntry("work", "drag"), LedgerEntry("dissipated", "drag"), LedgerEntry("dissipated"))


@pytest.mark.parametrize("k,entry", list(enumerate(ENTRIES)))
@pytest.mark.parametrize("key", ["color", "intensity", "blackbody", "size", "opacity", "albedo"])
def test_colours_and_numbers_follow_the_shares_as_they_follow_an_attribute(k, entry, key):
    """Particles whose share is a number are drawn as those that have it as an attribute: the same bytes."""
    joules = np.random.default_rng(k).uniform(-1, 5, 50)

    def picture(by, **kept):
        ramp = {"by": by, "range": "-1..4", "curve": [[0, 0.2], [0.3, 2], [1, 0.5]]}
        if key in ("color", "albedo"):
            ramp = {"by": by, "range": "-1..4", "gradient": GRADIENT}
        if key == "blackbody":
            ramp = {"by": by, "range": "-1..4", "curve": [[0, 1000], [1, 9000]]}
        look = {key: ramp} if key in ("size", "opacity", "albedo") else {"emission": {key: ramp}}
        more = {"blend": "alpha"} if key in ("opacity", "albedo") else {}
        look = ga.Look.model_validate({"draw": "disc", "radius": 0.3, **more, **look})
        dust = state(np.random.default_rng(9).normal(size=(50, 3)), **kept)
        if not kept:
            dust.entries = ENTRIES
            dust.booked = np.zeros((3, dust.floats.shape[1]))
            dust.booked[k, :50] = joules
        return Painter((64, 36), ga.Camera(position=(0, 0, 9)), {"dust": look}).paint(scene(dust=dust), 0.0).tobytes()

    by_share = picture(entry.plain)
    assert by_share == picture("heat", attributes={"heat": joules})
    assert by_share != picture("heat", attributes={"heat": joules[::-1]})


def test_a_declared_attribute_keeps_its_name():
    dust = ga.ParticleSystem(
        position=[[0, 0, 0]], attributes={"dissipated": 1.0}, forces=[F.Drag(0.1)], look={"size": {"by": "dissipated"}}
    )
    sim = ga.Simulation({"dust": dust}, dt=0.01)
    assert not sim.keeps_ledger and not dust.entries
    assert ga.render_frame(sim, (32, 18)).max() > 0


@pytest.mark.parametrize("time", [0.0, 0.25])
def test_the_legend_s_total_is_the_ledger_s(tmp_path, time):
    (path,) = job.still(piece(), tmp_path / "a.png", time)
    sim = ledger_at(piece(), time)
    entry = sim.ledger().dissipated["dust.drag"]
    assert read_recipe(path)["joules"] == [
        {"system": "dust", "by": {"dissipated": "drag"}, "total": entry, "unit": "J"}
    ]
    painter = Painter((320, 180), None, {"dust": piece().systems["dust"].look})
    (legend,) = painter.legends(sim)
    assert legend.title == f"dissipated by drag: {joules_text(entry)} in all" and entry > 0.1
    assert (legend.low, legend.high) == ("0 J", "0.02 J")
    sim.step(1)
    assert painter.legends(sim)[0].title != legend.title  # the mutant: a step too late
    plain, drawn = pixels(job.still(piece(systems__dust__look__legend=None), tmp_path / "b.png", time)[0]), pixels(path)
    assert read_recipe(tmp_path / "b.png")["joules"] == read_recipe(path)["joules"]
    rows, columns = np.nonzero((plain != drawn).any(axis=2))
    assert rows.min() > 90 and columns.max() < 210, "only the corner is drawn over"


def test_the_legend_of_every_frame_is_that_of_its_time(tmp_path):
    paths = job.render(piece(), tmp_path / "a_###.png", frames=range(0, 10, 3))
    totals = [read_recipe(path)["joules"][0]["total"] for path in paths]
    expected = [ledger_at(piece(), k / 20).ledger().dissipated["dust.drag"] for k in range(0, 10, 3)]
    assert totals == expected and totals == sorted(set(totals))
    (path,) = job.still(piece(), tmp_path / "s.png", 9 / 20)
    assert digest(path) == digest(paths[-1])
    (film,) = job.render(piece(), tmp_path / "a.gif", frames=range(3))
    bare = job.render(piece(systems__dust__look__legend=None), tmp_path / "b.gif", frames=range(3))[0]
    with Image.open(film) as drawn, Image.open(bare) as plain:
        assert drawn.n_frames == 3
        difference = np.asarray(drawn.convert("RGB")).astype(int) - np.asarray(plain.convert("RGB"))
    assert np.abs(difference[120:, :160]).max() > 100 and np.abs(difference[:80, 200:]).max() < 40


def test_rerun_and_show(tmp_path, capsys):
    for name, bits in (("a.png", 8), ("a.png", 16), ("a.webp", 8)):
        (path,) = job.still(piece(), tmp_path / name, 0.1, bits=bits, overwrite=True)
        assert digest(rerun(path, tmp_path / f"again_{name}", overwrite=True)[0]) == digest(path)
    total = read_recipe(path)["joules"][0]["total"]
    assert run(["show", str(path)]) == 0
    assert f"# dust: dissipated by drag: {total:.6g} J in all" in capsys.readouterr().out


def test_threads_draw_the_same_bytes(tmp_path):
    script = (
        "import sys; from tests.render.test_legend import job, piece\n"
        "job.still(piece(systems__dust__emitters__jet__rate=200000), sys.argv[2], 0.0, threads=int(sys.argv[1]))"
    )
    root = Path(__file__).parents[2]
    for threads in "12":
        subprocess.run([sys.executable, "-c", script, threads, str(tmp_path / f"{threads}.png")], check=True, cwd=root)
    assert digest(tmp_path / "1.png") == digest(tmp_path / "2.png")


def test_units_of_a_preset(tmp_path):
    preset = piece(units={"mass": "g", "length": "cm", "time": "s"})
    (path,) = job.still(preset, tmp_path / "a.png", 0.0)
    assert read_recipe(path)["joules"][0]["unit"] == "g cm^2/s^2"
    small = piece(units={"mass": "\u00b5g", "length": "\u212b"})
    (legend,) = Painter((320, 180), None, {"dust": small.systems["dust"].look}).legends(ga.Simulation(small))
    assert legend.low == "0 \u00b5g \u212b^2/s^2"
    foreign = piece(units={"mass": "\u0436\u1e05"})
    (legend,) = Painter((320, 180), None, {"dust": foreign.systems["dust"].look}).legends(ga.Simulation(foreign))
    assert legend.low == "0 ?b m^2/s^2"  # what the font has
    assert load_preset(preset, overrides={"units.velocity": "cm/s"}).units.energy == "g (cm/s)^2"


@pytest.mark.parametrize(
    "value,text",
    [
        (0.0, "0 J"), (-3.2149, "-3.21 J"), (48213.4, "48213 J"), (1.26e-6, "1.26e-06 J"), (2.5e9, "2.50e+09 J"), (999.6, "1000 J"), (2.4, "2.40 J"), (100.0, "100 J"),
    ],
)  # fmt: skip
def test_numbers_in_words(value, text):
    assert joules_text(value) == text


def sample(place="bottom left", title="work of driver: -3.21 J in all"):
    ramp = np.linspace(0, 1, 256)
    return DrawnLegend(place, title, "0 J", "0.02 J", np.repeat(ramp[:, None], 3, axis=1), np.ones(256))


def luminance(code):
    c = code / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


@pytest.mark.parametrize("size", [(1280, 720), (640, 360)])
@pytest.mark.parametrize("grey", [0, 128, 255])
def test_text_is_readable_on_any_picture(size, grey):
    """WCAG 2 asks for a contrast of 4.5 to 1; the strokes of the letters reach it, and stand at least 10 pixels high."""
    picture = np.full((size[1], size[0], 3), grey, np.uint8)
    draw_legends(picture, [sample()])
    rows, columns = np.nonzero((picture != grey).any(axis=2))
    corner = picture[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1, 0].astype(int)
    assert 0.05 < corner.shape[0] / size[1] < 0.25 and corner.shape[1] / size[0] < 0.5
    plate = np.bincount(corner.ravel()).argmax()
    contrast = (luminance(corner.max()) + 0.05) / (luminance(plate) + 0.05)
    assert contrast >= 4.5
    text = np.nonzero((corner[: corner.shape[0] // 2] > (plate + corner.max()) / 2).any(axis=1))[0]
    assert text.max() - text.min() >= 10


def test_legends_of_one_corner_do_not_cover_each_other():
    one, two = (np.full((360, 640, 3), 255, np.uint8) for _ in range(2))
    draw_legends(one, [sample()])
    draw_legends(two, [sample(), sample(), sample("top right")])
    drawn, more = ((picture != 255).any(axis=2) for picture in (one, two))
    assert more[180:, :320].sum() == 2 * drawn.sum() and more[:180, 320:].sum() == drawn.sum()
    assert np.array_equal(one[drawn], two[drawn])


@pytest.mark.parametrize("shape", [(36, 64, 3), (9, 16, 3), (600, 60, 3), (12, 12, 4)])
def test_a_small_picture_has_what_fits(shape):
    picture = np.zeros(shape, np.uint8)
    draw_legends(picture, [sample(title="a long title of very many words: 1 J in all")] * 3)
    assert picture.any()


def test_transparent_pictures_and_deep_ones():
    clear, deep, plain = (
        np.zeros((360, 640, 4), np.uint8),
        np.zeros((360, 640, 3), np.uint16),
        np.zeros((360, 640, 3), np.uint8),
    )
    for picture in (clear, deep, plain):
        draw_legends(picture, [sample()])
    assert clear[-8, 8, 3] == round(255 * PLATE) and clear[10, 10, 3] == 0
    assert np.abs(deep / 257 - plain.astype(float)).max() <= 0.5 + 1e-9
    assert np.abs(clear[..., :3] * (clear[..., 3:] / 255.0) - plain).max() <= 2  # light over nothing is the same light


def test_the_bar_has_the_gradient_or_the_curve():
    def bar(**look):
        look = ga.Look.model_validate({"legend": "top left", **look})
        entries = look.ledger_entries()
        return legend_of(look, LookTables.of(look, {}, entries), dict.fromkeys(entries, 2.0), "J")

    by = {"by": {"work": "wind"}}
    colour = bar(
        emission={
            "color": {**by, "range": "-2..2", "gradient": GRADIENT},
            "intensity": {"by": "dissipated", "range": "0..1"},
        }
    )
    assert (colour.place, colour.title, colour.low, colour.high) == (
        "top left",
        "work of wind: 2.00 J in all",
        "-2 J",
        "2 J",
    )
    assert np.allclose(colour.colours[[0, -1]], [(0, 0, 1), (1, 0, 0)], atol=2e-3) and (colour.heights == 1).all()
    number = bar(emission={"color": "#ff0000", "intensity": {**by, "range": "0..4", "curve": [[0, 0], [1, 5]]}})
    assert np.allclose(number.colours, (1, 0, 0), atol=2e-3) and np.allclose(
        number.heights, np.linspace(0, 1, 256), atol=1e-6
    )
    size = bar(size={"by": "dissipated", "curve": [[0, 1], [8, 2]]}, legend={"label": "lost"})
    assert (size.title, size.high, size.place) == ("lost: 2.00 J in all", "8 J", "bottom left") and size.heights[
        0
    ] == 0.5
    assert bar(legend=None, size={"by": "dissipated"}) is None


@pytest.mark.parametrize(
    "by,sentence",
    [
        ("{work: drog}", ":12:37: systems.a.look.emission.color.by.work: the ledger has no entry {work: drog}; did you mean 'drag'?"),
        ("{dissipated: gravity}", "no entry {dissipated: gravity}: the work of a conservative force"),
        ("{wrk: drag}", ":12:26: systems.a.look.emission.color.by: an entry of the ledger is of work or dissipated, not 'wrk'; did you mean"),
        ("{work: 3}", "work needs the name of a force"),
        ("7", "must be the name of a quantity, such as speed"),
    ],
)  # fmt: skip
def test_validate_says_what_is_wrong_and_where(tmp_path, capsys, by, sentence):
    text = f"""\
# A.
# B.
# C.
version: 1
clock: {{duration: 1, fps: 10, step: 0.01}}
forces: {{gravity: [0, -9.81, 0], drag: 0.1}}
systems:
  a:
    emitters: {{e: {{rate: 100}}}}
    look:
      legend: true
      emission: {{color: {{by: {by}, range: 0..1, gradient: inferno}}}}
"""
    (tmp_path / "a.yaml").write_text(text)
    assert run(["validate", str(tmp_path / "a.yaml")]) != 0
    said = capsys.readouterr()
    assert sentence in said.out + said.err and "Traceback" not in said.err


@pytest.mark.parametrize(
    "look,sentence",
    [
        ({"legend": True}, "a legend shows joules"),
        ({"legend": {"label": "\u71b1"}}, "label: must be at most 60 characters of those that the font has"),
        ({"legend": "middle"}, "place: must be one of top left"),
        ({"emission": {"color": {"by": "dissipated", "gradient": GRADIENT}}}, "colours by dissipated need a range"),
        (
            {"emission": {"color": {"by": {"work": "drag"}, "gradient": GRADIENT}}},
            "colours by {work: drag} need a range",
        ),
    ],
)
def test_a_look_that_cannot_be_is_a_sentence(look, sentence):
    with pytest.raises(ga.UsageError) as error:
        ga.ParticleSystem(position=[[0, 0, 0]], forces=[F.Drag(0.1)], look=look)
    assert sentence in str(error.value)


def test_joules_that_are_too_many_are_a_sentence(tmp_path):
    fast = {"cone": [0, 1, 0], "angle": 1, "speed": 1e10}
    heavy = piece(
        systems__dust__particle__density=1e30, systems__dust__emitters__jet__velocity=fast, forces={"drag": {"linear": 1e25}}
    )  # fmt: skip
    with pytest.raises(ga.PresetError, match=r"dissipated by drag in system 'dust' is .*too large"):
        job.still(heavy, tmp_path / "a.png", 0.1)
    with pytest.raises(ga.PresetError, match="too large"):
        job.render(heavy, tmp_path / "a.gif", frames=range(2))
    assert not list(tmp_path.iterdir())


def test_inspect_and_the_schema_know_it(tmp_path, capsys):
    import jsonschema

    from gen_art.preset.schema import json_schema

    (tmp_path / "a.json").write_text(json.dumps(piece().resolved()))
    assert run(["inspect", str(tmp_path / "a.json")]) == 0
    assert "dissipated by drag" in capsys.readouterr().out
    check = jsonschema.Draft202012Validator(json_schema())
    plain = piece().resolved()
    check.validate(plain)
    for legend in (True, False, "top right", {"label": "lost"}):
        plain["systems"]["dust"]["look"]["legend"] = legend
        check.validate(plain)
        load_preset(plain)
    for by in ("dissipated", {"work": "drag"}):
        plain["systems"]["dust"]["look"]["emission"]["color"]["by"] = by
        check.validate(plain)
    plain["systems"]["dust"]["look"]["emission"]["color"]["by"] = {"wrk": "drag"}
    with pytest.raises(jsonschema.ValidationError):
        check.validate(plain)


def test_ribbons_show_the_present_share(tmp_path):
    look = {**LOOK, "draw": "streak", "ribbon": {"length": 0.2, "points": 8}}
    look = {k: v for k, v in look.items() if k != "radius"} | {"width": 0.05}
    look["emission"] = {"color": {**LOOK["emission"]["color"], "range": "0..0.006"}}
    picture = pixels(job.still(piece(look), tmp_path / "a.png", 0.25)[0]).astype(int)
    assert (picture[:100, :, 0] > picture[:100, :, 2] + 40).any() and (picture[:, :, 2] > picture[:, :, 0] + 40).any()
