"""What a notebook shows of simulations, presets, ledgers and pictures; and the notebooks of examples/ run to their end."""

import io
import os
import re
from html.parser import HTMLParser
from pathlib import Path

import nbformat
import numpy as np
import pytest
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from PIL import Image

import gen_art as ga
from gen_art.html_table import html_table

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


class _Tables(HTMLParser):
    """The captions and the cells of tables; every element must be closed in order."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.captions: list[str] = []
        self.rows: list[list[str]] = []
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag, attrs):
        assert tag in ("table", "caption", "thead", "tbody", "tr", "th", "td")
        self._open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("th", "td"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self._open.pop() == tag

    def handle_data(self, data):
        if self._open[-1:] == ["caption"]:
            self.captions.append(data)
        elif self._open[-1:] in (["th"], ["td"]):
            self.rows[-1][-1] += data


def tables(shown) -> _Tables:
    """The tables by which an object is shown, which name no colour and nothing from elsewhere."""
    html = shown._repr_html_()
    assert not re.search(r"color|background|src=|href=|url\(|<script|class=", html)
    return _Tables(html)


def test_text_in_a_table_is_no_markup():
    html = html_table("<b>&", [("<i>", 1.5, "a<b>&amp;")], ("<u>", "value", "text"))
    read = _Tables(html)
    assert read.captions == ["<b>&"] and read.rows == [["<u>", "value", "text"], ["<i>", "1.5", "a<b>&amp;"]]


def simulation(**more) -> ga.Simulation:
    """Three stones that fall, and one particle that nothing moves; the step is a power of two."""
    stones = ga.ParticleSystem(
        position=np.zeros((3, 3)),
        mass=2.0,
        integrator="rk4",
        forces=[ga.forces.Gravity((0, -8, 0)), ga.forces.Drag(linear=0.5)],
    )
    still = ga.ParticleSystem(position=[[0, 0, 1]], integrator="leapfrog")
    return ga.Simulation({"stones": stones, "still": still}, dt=0.125, precision="f64", **more)


def test_a_simulation_shows_its_time_and_systems():
    sim = simulation()
    sim.step(4)
    sim["stones"].remove([1])
    read = tables(sim)
    assert read.captions == ["Simulation at 0.5 s, 4 steps of 0.125 s, f64"]
    assert read.rows[1:] == [
        ["stones", "2", "gravity, drag", "rk4"],
        ["still", "1", "none", "leapfrog"],
    ]


def test_a_ledger_shows_what_it_holds():
    sim = simulation(ledger=True)
    sim.step(4)
    sim["stones"].remove([1])
    ledger, read = sim.ledger(), tables(sim.ledger())
    by_name = {row[0]: row[1:] for row in read.rows}
    assert float(by_name["stones.drag"][1]) == pytest.approx(ledger.dissipated["stones.drag"], rel=1e-5)
    assert ledger.dissipated["stones.drag"] > 0.1
    assert by_name["stones.gravity"][2] == "(0, -24, 0)"  # 3 x 2 kg x -8 m/s^2 x 0.5 s
    assert float(by_name["total"][1]) == pytest.approx(ledger.dissipated.total, rel=1e-5)
    outside = next(row for row in read.rows if row[1] == "outside")
    assert outside[0] == "stones" and float(outside[3]) == -2.0
    assert by_name["energy, J"][0] == f"{ledger.residual:.3g}"


def test_a_ledger_without_births_has_no_table_of_them():
    read = tables(simulation(ledger=True).ledger())
    assert len(read.captions) == 2 and [row[0] for row in read.rows] == ["Force", "total", "energy, J", "momentum, N s"]


def test_diagnostics_show_every_sum():
    sim = simulation()
    sim.step(4)
    d, read = sim.diagnostics(), tables(sim.diagnostics())
    shown = {row[0]: row[1:] for row in read.rows}
    assert shown["Particles"][0] == "4" and shown["Mass"] == ["7", "kg"]
    assert float(shown["Energy"][0]) == pytest.approx(d.energy, rel=1e-7) and shown["Energy"][1] == "J"
    assert len(shown) == len(d.as_dict()) - 1  # the time is in the caption


def loaded(text: str, tmp_path: Path):
    path = tmp_path / "piece.yaml"
    path.write_text(text, encoding="utf-8")
    return ga.load_preset(path)


PIECE = """# Sparks <rise> & fall.
# Physics: gravity.
version: 1
seed: 5
knobs: {heat: {value: 1500, range: 900..2200, unit: K}, count: 7}
clock: {duration: 2, fps: 25, step: 1/50}
camera: {position: [0, 0, 5], size: [640, 360]}
systems: {sparks: {emitters: {base: {count: $count, shape: {point: [0, 0, 0]}}}}}
"""


def test_a_preset_shows_its_film_and_knobs(tmp_path):
    read = tables(loaded(PIECE, tmp_path))
    assert read.captions == ["piece: Sparks <rise> & fall.", "Knobs"]
    assert read.rows == [
        ["Film", "2 s, 25 frames a second"], ["Picture", "640 x 360 pixels"], ["Step", "0.02 s"], ["Seed", "5"],
        ["Systems", "sparks"], ["Knob", "Value", "Range", "Unit"], ["heat", "1500", "900..2200", "K"], ["count", "7", "", ""],
    ]  # fmt: skip


def test_a_preset_without_a_first_line_and_knobs(tmp_path):
    plain = loaded(
        "\n".join(line for line in PIECE.splitlines()[2:] if "knobs" not in line).replace("$count", "7"), tmp_path
    )
    assert plain.title == "" and tables(plain).captions == ["piece"]
    assert tables(ga.load_preset(plain.resolved())).captions == ["preset"]


@pytest.fixture(scope="module")
def light():
    return np.random.default_rng(3).uniform(0, 1, (6, 9, 4)).astype(np.float32)


@pytest.mark.parametrize("transparent", [False, True])
def test_a_picture_is_shown_as_a_png_of_its_values(light, transparent):
    picture = ga.develop(light, transparent=transparent)
    read = np.asarray(Image.open(io.BytesIO(picture._repr_png_())))
    assert read.shape == (6, 9, 4 if transparent else 3) and np.array_equal(read, picture)
    part = picture[1:4, 2:7]
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(part._repr_png_()))), read[1:4, 2:7])


def test_what_is_no_picture_is_not_shown_as_one(light):
    picture = ga.develop(light)
    for other in (
        picture[0],
        picture[..., 0],
        picture[..., :2],
        picture[:0],
        picture.astype(float),
        ga.develop(light, bits=16),
    ):
        assert other._repr_png_() is None


def test_a_picture_counts_as_an_ordinary_array(light):
    picture = ga.develop(light)
    plain = np.asarray(picture)
    assert isinstance(picture, np.ndarray) and type(plain) is np.ndarray and plain.dtype == np.uint8
    assert type(picture.mean()) is np.float64 and picture.mean() == plain.mean()
    assert type(picture / 2) is np.ndarray and np.array_equal(picture / 2, plain / 2)
    assert type(picture.max(axis=0)) is np.ndarray and type(picture == plain) is np.ndarray
    picture[0, 0] = 9
    assert picture[0, 0].tolist() == [9, 9, 9] and plain[0, 0].tolist() == [9, 9, 9]  # one memory


def test_there_are_notebooks():
    assert "first_look" in [path.stem for path in NOTEBOOKS]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(path, tmp_path):
    """In a kernel of this interpreter that reads this checkout, whatever kernels are installed."""
    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code), "a notebook is stored without outputs"
    environment = {
        **os.environ, "PYTHONPATH": str(ROOT), "IPYTHONDIR": str(tmp_path), "JUPYTER_CONFIG_DIR": str(tmp_path),
        "JUPYTER_RUNTIME_DIR": str(tmp_path),
    }  # fmt: skip
    manager = AsyncKernelManager(kernel_spec_manager=KernelSpecManager(kernel_dirs=[]), kernel_name="python3")
    manager.connection_file = str(tmp_path / "kernel.json")
    client = NotebookClient(notebook, km=manager, timeout=None, resources={"metadata": {"path": str(tmp_path)}})
    environment.pop("PYTEST_CURRENT_TEST", None)  # in a test a kernel would not capture what native code prints
    client.execute(env=environment)  # raises the error of the first cell that fails
    assert [one.text for cell in code for one in cell.outputs if one.output_type == "stream"] == []  # and no warnings
    shown = {cell.id: cell.outputs[-1].data if cell.outputs else {} for cell in code}
    assert any("image/png" in data for data in shown.values())
    for name, data in shown.items():
        assert "text/html" in data or "image/png" in data or name == "well", name
    assert sorted(file.suffix for file in tmp_path.iterdir() if file.is_file()) in ([], [".json"])  # it writes no file
