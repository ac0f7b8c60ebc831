"""The habits of the project: version, licence, layers, links, bitcode."""

import importlib.util
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import gen_art as ga

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
KERNEL_FILES = [
    path
    for path in sorted((ROOT / "gen_art").rglob("*.py"))
    if re.search(r"^\s*@ti\.kernel", path.read_text(encoding="utf-8"), re.M)
    and path.parent.name in ("integrators", "interactions", "rigid", "simulation")
]


def test_version_changelog_and_tag_say_the_same():
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert re.findall(r"^## (\d+\.\d+\.\d+)$", changelog, re.M)[0] == ga.__version__
    tags = subprocess.run(
        ["git", "tag", "--points-at", "HEAD"], cwd=ROOT, capture_output=True, text=True
    ).stdout.split()
    assert all(tag == f"v{ga.__version__}" for tag in tags)


def test_the_licence_is_where_it_is_said():
    assert "MIT License" in (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert PROJECT["project"]["license"] == "MIT"


def test_ci_runs_the_checks_the_site_and_the_tests():
    assert re.findall(r"make (\w+)", (ROOT / ".ci" / "run").read_text(encoding="utf-8")) == ["check", "docs", "test"]


@pytest.fixture(scope="module")
def links():
    spec = importlib.util.spec_from_file_location("check_links", ROOT / "docs" / "check_links.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_broken_link_is_found(links, tmp_path, monkeypatch):
    page = tmp_path / "page.md"
    page.write_text("# A heading\n[a](page.md#a-heading) [b](none.md) [c](#no-heading)\n```\n[d](code.md)\n```\n")
    monkeypatch.setattr(links, "ROOT", tmp_path)
    assert links.broken(page) == [
        "page.md: none.md: there is no such file",
        "page.md: #no-heading: there is no such heading",
    ]


def test_every_folder_is_a_layer():
    """A new folder has its place in the order, so that no import can go around it."""
    layers = " | ".join(PROJECT["tool"]["importlinter"]["contracts"][0]["layers"]).split(" | ")
    named = {layer.removeprefix("gen_art.") for layer in layers}
    there = {
        path.stem for path in (ROOT / "gen_art").iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()
    }
    assert named == there - {"__init__", "__main__"}


def test_an_import_that_goes_up_is_found(tmp_path):
    package = tmp_path / "gen_art"
    for folder in ("forces", "simulation"):
        (package / folder).mkdir(parents=True)
        (package / folder / "__init__.py").write_text("")
    (package / "__init__.py").write_text("")
    (package / "forces" / "gravity.py").write_text("from gen_art import simulation\n")
    (tmp_path / ".importlinter").write_text(
        "[importlinter]\nroot_package = gen_art\n[importlinter:contract:1]\nname = layers\ntype = layers\n"
        "layers =\n    gen_art.simulation\n    gen_art.forces\n"
    )
    linter = Path(sys.executable).parent / "lint-imports"
    done = subprocess.run([str(linter), "--no-cache"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1 and "gen_art.forces.gravity -> gen_art.simulation" in done.stdout


@pytest.mark.parametrize("path", KERNEL_FILES, ids=lambda path: path.name)
def test_kernel_files_link_to_the_glossary_of_their_letters(path):
    assert "docs/glossary.md" in path.read_text(encoding="utf-8"), path


def test_no_reach_ins():
    """Other packages see the read-only face of a Simulation and a ParticleSystem, no underscored attribute of them."""
    found = []
    for path in (ROOT / "gen_art").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        found += [
            f"{path.name}: {hit}" for hit in re.findall(r"\b(?:sim|simulation|system|playback|painter)\._\w+", text)
        ]
    assert not found
