"""The wheel: it holds the presets, and works from an empty folder."""

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder with the wheel's contents, as pip would put them."""
    made, folder = tmp_path_factory.mktemp("wheel"), tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(made)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = made.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(folder)
    return folder


def run(installed, folder, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    command = [sys.executable, "-m", "gen_art", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_the_wheel_holds_the_presets_and_the_command(installed):
    shipped = {path.name for path in (installed / "gen_art" / "presets").glob("*.yaml")}
    assert shipped == {path.name for path in (ROOT / "presets").glob("*.yaml")}
    assert shipped
    assert (installed / "gen_art" / "backend" / "intrinsics" / "prefetch.bc").is_file()
    entry = next(installed.glob("gen_art-*.dist-info")) / "entry_points.txt"
    assert "gen-art = gen_art.commands.main:main" in entry.read_text()


def test_it_works_from_an_empty_folder(installed, tmp_path):
    listed = run(installed, tmp_path, "list")
    assert listed.returncode == 0, listed.stderr
    names = [line.split()[0] for line in listed.stdout.splitlines()]
    checked = run(installed, tmp_path, "validate", *names)
    assert checked.returncode == 0, checked.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_lock_files_name_versions_and_hashes_and_no_index():
    for path in ROOT.glob("requirements*.lock"):
        text = path.read_text()
        assert "://" not in text
        assert "--index" not in text
        assert len(re.findall(r"^[a-z0-9._-]+==", text, re.M)) > 15
        assert text.count("--hash=sha256:") > 50


def test_the_lock_covers_what_the_project_asks_for():
    wanted = re.findall(
        r'"([A-Za-z0-9._-]+)[=><]=?', (ROOT / "pyproject.toml").read_text().split("[project.scripts]")[0]
    )
    locked = (
        "".join(path.read_text() for path in ROOT.glob("requirements*.lock"))
        .lower()
        .replace("_", "-")
        .replace(".", "-")
    )
    missing = [name for name in wanted if f"{name.lower().replace('_', '-').replace('.', '-')}==" not in locked]
    assert not missing
