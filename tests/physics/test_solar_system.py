"""The Solar System after a year, against an ephemeris and against steps of an eighth (examples/solar_system.py)."""

import importlib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
AU = 149597870.7  # km
START, YEAR = 2451545.0, 365.25
INNER = ("mercury", "venus", "earth", "moon", "mars")


@pytest.fixture(scope="module")
def example():
    return importlib.import_module("examples.solar_system")


@pytest.fixture(scope="module")
def year(example):
    return example.positions(YEAR)


@pytest.fixture(scope="module")
def ephemeris():
    """name, Julian date (TDB) -> km from the Sun, by JPL's DE421 (Folkner, Williams & Boggs 2009)."""
    spk = pytest.importorskip("jplephem.spk")
    pytest.importorskip("skyfield_data")
    kernel = spk.SPK.open(str(files("skyfield_data") / "data" / "de421.bsp"))
    paths = {  # segments from the Solar System's barycentre to the body
        "mercury": [(0, 1), (1, 199)], "venus": [(0, 2), (2, 299)], "earth": [(0, 3), (3, 399)], "moon": [(0, 3), (3, 301)],
        "mars": [(0, 4), (4, 499)], "jupiter": [(0, 5)], "saturn": [(0, 6)], "uranus": [(0, 7)], "neptune": [(0, 8)],
    }  # fmt: skip

    def place(name, date):
        return sum(kernel[segment].compute(date)[:3] for segment in paths[name]) - kernel[0, 10].compute(date)[:3]

    yield place
    kernel.close()


def errors(year, ephemeris) -> dict[str, float]:
    return {name: float(np.linalg.norm(place * AU - ephemeris(name, START + YEAR))) for name, place in year.items()}


def test_a_year_agrees_with_the_ephemeris(year, ephemeris):
    """To 1e3 km for the inner bodies, 1e4 km for the outer ones; the states themselves begin up to 520 km away."""
    assert len(year) == 9
    for name, error in errors(year, ephemeris).items():
        assert error < (1e3 if name in INNER else 1e4), f"{name} is {error:.0f} km away"


def test_without_jupiter_or_with_another_sun_it_does_not(example, ephemeris, monkeypatch):
    for name, factor in (("SUN", 1 + 1e-5), ("GM", None)):
        with monkeypatch.context() as changed:
            if factor:
                changed.setattr(example, name, example.SUN * factor)
            else:
                changed.setattr(example, name, {**example.GM, "jupiter": 0.0})
            found = errors(example.positions(YEAR), ephemeris)
        assert max(found[name] for name in INNER) > 1e3


def test_the_table_of_the_docs_is_what_comes_out(year, ephemeris):
    page = (ROOT / "docs" / "solar_system.md").read_text(encoding="utf-8")
    for name, error in errors(year, ephemeris).items():
        row = next(line for line in page.splitlines() if line.startswith(f"| {name} "))
        told = float(row.split("|")[2])
        assert told == pytest.approx(error, rel=0.05, abs=5), row


@pytest.mark.proof
def test_a_year_agrees_with_steps_of_an_eighth(example, year):
    fine = example.positions(YEAR, example.STEP / 8)
    for name, place in year.items():
        assert np.linalg.norm(place - fine[name]) * AU < (1e3 if name in INNER else 1e4), name
