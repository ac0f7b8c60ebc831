"""`gen-art doctor`: what it finds on this machine, and what it says of machines on which something is missing."""

import importlib.metadata
import json
import os
import platform
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import av
import pytest

from gen_art import __version__
from gen_art.backend import processor, runtime
from gen_art.output import extras, machine
from gen_art.output.encoders import encodable
from gen_art.output.formats import CODECS

ROOT = Path(__file__).resolve().parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


@pytest.fixture(scope="module")
def facts():
    done = subprocess.run(
        [sys.executable, str(ROOT / "cli.py"), "doctor", "--json"], capture_output=True, text=True, cwd="/"
    )
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def test_the_facts_are_this_machine_s(facts):
    assert facts["films"] and not facts["problems"]
    assert (facts["gen_art"], facts["python"]) == (__version__, platform.python_version())
    assert facts["taichi"] == {"version": importlib.metadata.version("taichi"), "supported": True, "patched": True}
    assert facts["processor"] == {
        "name": processor.name(), "vectors": processor.vectors(), "cores": processor.cores(), "all_cores": os.cpu_count(),
    }  # fmt: skip
    assert facts["kernel"] == {"runs": True, "threads": processor.cores(), "kept": platform.machine() == "x86_64"}
    assert facts["memory"]["bytes"] >= facts["memory"]["free"] > 2**28
    assert facts["cache"]["folder"] == str(runtime.cache_folder("cpu")) and facts["cache"]["limit"] == 2**30
    assert [codec["name"] for codec in facts["codecs"]] == list(CODECS)
    assert not any(codec["missing"] for codec in facts["codecs"])


def test_the_extras_are_those_of_the_project_each_with_its_purpose(facts):
    assert [extra["name"] for extra in facts["extras"]] == list(EXTRAS)
    assert extras.PURPOSES.keys() == EXTRAS.keys()
    installed = {re.sub(r"[-_.]+", "-", d.name).lower() for d in importlib.metadata.distributions()}
    for extra in facts["extras"]:
        names = {re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", r)[0]).lower(): r for r in EXTRAS[extra["name"]]}
        assert {names[name] for name in names.keys() - installed} <= set(extra["missing"])
        assert extra["installed"] == (not extra["missing"])


def test_the_extras_of_an_installed_package_come_from_its_metadata():
    text = importlib.metadata.Distribution.from_name("pytest").metadata
    found = extras._of_metadata(text)
    assert "hypothesis" in {re.match(r"[\w.-]+", one)[0] for one in found["dev"]}
    assert not any(
        "iniconfig" in one for many in found.values() for one in many
    )  # what pytest always needs is no extra


@pytest.mark.parametrize(
    ("requirement", "installed", "good"),
    [
        ("x>=3.3", "3.3", True),
        ("x>=3.3", "3.10.1", True),
        ("x>=3.3", "3.2.9", False),
        ("x>=3.3", "3.3rc1", True),
        ("x>=3", "2", False),
        ("x==1.7.4", "1.7.4", True),
        ("x", "0.1", True),
    ],
)
def test_an_old_package_does_not_count(monkeypatch, requirement, installed, good):
    monkeypatch.setattr(extras.metadata, "version", lambda name: installed)
    assert extras._satisfied(requirement) == good


def test_the_report_in_plain_lines(gen_art):
    result = gen_art("doctor")
    assert (result.status, result.err) == (0, "")
    lines = dict(
        re.split(r"\s{2,}", line.strip(), maxsplit=1) for line in result.out.splitlines() if "  " in line.strip()
    )
    assert lines["gen-art"] == __version__ and "the supported version" in lines["Taichi"]
    assert re.fullmatch(
        r"compiled and ran on \d+ threads?; (machine code is kept|each start compiles anew .*)", lines["kernel"]
    )
    assert lines["h264"] == ".mp4 .mov: yes" and "installed" in lines["dev"]
    assert result.out.endswith("\nFilms can be made.\n")


def environment_of(monkeypatch, tmp_path, **modules):
    """The trial's process imports these modules, given by their text, before all others of their names."""
    for name, text in modules.items():
        (tmp_path / f"{name}.py").write_text(text, encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))


def problems(result) -> list[tuple[str, str]]:
    return re.findall(r"Problem: (.*)\.\n    What to do: (.*)\.\n", result.out)


def test_another_version_of_taichi(gen_art, tmp_path, monkeypatch):
    other = tmp_path / "site" / "taichi-1.6.0.dist-info"
    other.mkdir(parents=True)
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: taichi\nVersion: 1.6.0\n")
    monkeypatch.setenv("PYTHONPATH", str(other.parent))
    monkeypatch.delenv("GEN_ART_STOCK_TAICHI", raising=False)
    result = gen_art("doctor")
    assert result.status == 2 and result.out.endswith("Films cannot be made until this is mended.\n")
    assert "1.6.0, not the supported version" in result.out
    ((what, remedy),) = problems(result)
    assert what == "this version needs taichi 1.7.4, but 1.6.0 is installed" and remedy.startswith(
        "run pip install 'taichi==1.7.4'"
    )


def test_without_taichi(gen_art, tmp_path, monkeypatch):
    environment_of(
        monkeypatch, tmp_path, sitecustomize="import importlib.metadata as m\nreal = m.version\n"
        "def version(name):\n    if name == 'taichi':\n        raise m.PackageNotFoundError(name)\n    return real(name)\nm.version = version\n",
    )  # fmt: skip
    ((what, remedy),) = problems(result := gen_art("doctor"))
    assert result.status == 2 and re.search(r"^Taichi +not installed$", result.out, re.M)
    assert (what, remedy) == (
        "this version needs taichi 1.7.4, which is not installed",
        "run pip install 'taichi==1.7.4'",
    )


@pytest.mark.parametrize(
    ("taichi", "words"),
    [
        ("raise ImportError('GLIBC_2.99 not found')", "Taichi fails with ImportError: GLIBC_2.99 not found"),
        ("raise OSError('libc.so: cannot open')", "Taichi fails with OSError: libc.so: cannot open"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGILL)", "Taichi ended the process by the signal SIGILL"),
        (
            "import os, sys; print('no GPU here', file=sys.stderr, flush=True); os._exit(3)",
            "Taichi ended the process: no GPU here",
        ),
    ],
)
def test_a_taichi_that_does_not_start(gen_art, tmp_path, monkeypatch, taichi, words):
    environment_of(monkeypatch, tmp_path, taichi=taichi)
    result = gen_art("doctor")
    ((what, remedy),) = problems(result)
    assert result.status == 2 and what == words and "pip install --force-reinstall taichi" in remedy
    assert re.search(r"^kernel +did not run$", result.out, re.M)


def test_a_kernel_with_wrong_numbers_is_found(gen_art, tmp_path, monkeypatch):
    """A NumPy in which arange is shifted: the comparison is made, and made with all numbers."""
    environment_of(
        monkeypatch, tmp_path, sitecustomize="import numpy\nreal = numpy.arange\n"
        "def arange(*args, **more):\n    x = real(*args, **more)\n    x[-1:] += args == (100_000,)\n    return x\nnumpy.arange = arange\n",
    )  # fmt: skip
    ((what, _),) = problems(result := gen_art("doctor"))
    assert result.status == 2 and what == "a kernel ran and wrote wrong numbers"


def test_a_cache_that_cannot_be_written_prevents_no_film(gen_art, tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("GEN_ART_CACHE", str(tmp_path / "file"))
    result = gen_art("doctor")
    ((what, remedy),) = problems(result)
    assert result.status == 0 and "cannot be used (Not a directory)" in what and remedy.startswith("set GEN_ART_CACHE")
    assert re.search(r"^kernel cache .*, cannot be written$", result.out, re.M)


def test_without_temporary_files_the_status_is_5(gen_art, tmp_path, monkeypatch):
    environment_of(
        monkeypatch, tmp_path, sitecustomize="import tempfile\n"
        "def refuse(*args, **more):\n    raise OSError(28, 'No space left on device')\ntempfile.TemporaryDirectory = refuse\n",
    )  # fmt: skip
    ((what, remedy),) = problems(result := gen_art("doctor"))
    assert (
        result.status == 5
        and what == "temporary files cannot be written (No space left on device)"
        and "TMPDIR" in remedy
    )


def test_too_little_memory_is_4(gen_art, monkeypatch):
    monkeypatch.setattr(machine, "available_memory", lambda: 100 * 2.0**20)
    result = gen_art("doctor")
    assert result.status == 4 and "only 100 MiB of memory are free" in result.out


def without(*encoders):
    """PyAV's class of encoders, without these."""
    real = av.Codec

    def find(name, mode):
        return real("no such encoder" if name in encoders else name, mode)

    return find


def test_a_missing_encoder_is_named_and_other_films_can_be_made(gen_art, monkeypatch):
    monkeypatch.setattr(av, "Codec", without("libx264", "libwebp_anim"))
    result = gen_art("doctor")
    assert result.status == 0
    assert [what for what, _ in problems(result)] == [
        "H.264 cannot be made: the encoder libx264 is missing", "WebP cannot be made: the encoder libwebp_anim is missing",
    ]  # fmt: skip
    assert all("pip install --force-reinstall" in remedy for _, remedy in problems(result))


def test_a_missing_pixel_format_is_named(monkeypatch):
    class EightBits:
        video_formats = [kind for kind in av.Codec("libx265", "w").video_formats if "10" not in kind.name]

    real = av.Codec
    monkeypatch.setattr(av, "Codec", lambda name, mode: EightBits if name == "libx265" else real(name, mode))
    lacking = {one.codec.name: one.missing for one in encodable() if one.missing}
    assert lacking == {"h265": "yuv420p10le of the encoder libx265"}


def test_without_any_encoder_the_status_is_6(gen_art, monkeypatch):
    monkeypatch.setattr(av, "Codec", without(*(codec.encoder for codec in CODECS.values())))
    assert gen_art("doctor").status == 6


def test_pyav_that_cannot_be_loaded_is_6(gen_art, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    result = gen_art("doctor")
    assert result.status == 6 and "PyAV cannot be loaded" in result.out


def test_nothing_imports_taichi_in_the_command_s_own_process():
    code = "import sys; from gen_art.commands.main import run; run(['doctor']); print(sorted(sys.modules), file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert "'gen_art.output.machine'" in done.stderr and "'taichi'" not in done.stderr
