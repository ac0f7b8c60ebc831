"""`gen-art audit` from the command line."""

import builtins
import json

import numpy as np
import pytest
from PIL import Image

from gen_art.audit import audit
from gen_art.preset.load import load_preset


def test_the_command_prints_both_forms(gen_art):
    words = gen_art("audit", "charged", "--time", "0.1")
    assert words.status == 0 and "ledger at dt" in words.out and "Everything closes." in words.out
    data = json.loads(gen_art("audit", "charged", "--time", "0.1", "--json").out)
    assert data["problems"] == [] and data["positions"]["ions"]["order"] == pytest.approx(2, abs=0.2)
    assert gen_art("audit", "charged", "--time", "77").status == 2
    assert gen_art("audit", "chargd").status in (2, 3)


SHORT = ("audit", "course/two_stars", "--time", "0.1")


def test_an_audit_is_drawn(gen_art, tmp_path):
    pytest.importorskip("matplotlib")
    path = tmp_path / "a.png"
    assert gen_art(*SHORT, "-o", str(path)).status == 0
    with Image.open(path) as picture:
        assert picture.size[0] > 1000 and np.asarray(picture.convert("L")).std() > 10
    assert gen_art(*SHORT, "-o", str(path)).status == 5, "it exists"
    assert gen_art(*SHORT, "-o", str(path), "--overwrite").status == 0
    page = tmp_path / "a.html"
    assert gen_art(*SHORT, "-o", str(page)).status == 0
    text = page.read_text(encoding="utf-8")
    assert "data:image/png;base64," in text and "Everything closes." in text
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.html", "a.png"]


def test_what_cannot_be_drawn_is_a_sentence(gen_art, tmp_path, monkeypatch):
    wrong = gen_art(*SHORT, "-o", str(tmp_path / "a.docx"))
    assert wrong.status == 2 and ".png, .svg, .html" in wrong.err
    real = builtins.__import__

    def none(name, *args, **more):
        if name == "matplotlib":
            raise ImportError(name)
        return real(name, *args, **more)

    monkeypatch.setattr(builtins, "__import__", none)
    missing = gen_art(*SHORT, "-o", str(tmp_path / "a.png"))
    assert missing.status == 2 and "pip install matplotlib" in missing.err
    assert not list(tmp_path.iterdir())


def test_the_history_is_the_account_moment_by_moment():
    """What is drawn: the energy less the residual is start + work + born - died - dissipated."""
    report = audit(load_preset("fire", overrides={"clock.preroll": 0}), time=0.25, precision="f64", moments=5)
    history, ledger = report.runs[0].history, report.ledger
    assert len(history.times) == 6 and history.times[0] == 0 and history.times[-1] == pytest.approx(report.simulated)
    passed = ledger.work.total + ledger.born.total.energy - ledger.died.total.energy - ledger.dissipated.total
    assert history.accounted[-1] == pytest.approx(report.start.energy + passed, rel=1e-12)
    assert history.kinetic[-1] + history.potential[-1] == pytest.approx(report.end.energy, rel=1e-12)
    assert np.allclose(history.momentum[-1], report.end.momentum)
    flame = history.paths["flame"]
    assert flame.shape[1:] == (6, 3) and np.isfinite(flame).any() and np.isnan(flame).any()
