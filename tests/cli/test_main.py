"""Start-up, help, and what every kind of error becomes."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest

from gen_art.commands import main as command_line
from gen_art.commands.main import COMMANDS, run
from gen_art.errors import EncoderError, GenArtError, MemoryRefused, OutputError, PresetError, UsageError

ROOT = Path(__file__).resolve().parents[2]


def python(code, **more):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, **more)


@pytest.mark.parametrize("arguments", [["--help"], *([name, "--help"] for name in COMMANDS)])
def test_help(gen_art, arguments):
    result = gen_art(*arguments)
    assert result.status == 0
    assert "Usage: gen-art" in result.out
    assert not result.err


def test_help_starts_without_taichi_numpy_or_pydantic():
    code = "import sys; from gen_art.commands.main import run; run(['--help']); print(sorted(sys.modules), file=sys.stderr)"
    loaded = python(code).stderr
    assert not any(f"'{module}'" in loaded for module in ("taichi", "numpy", "pydantic", "rich"))


def test_the_launcher_and_the_module_are_the_command_line():
    for arguments in (["cli.py"], ["-m", "gen_art"]):
        result = subprocess.run([sys.executable, *arguments, "list"], capture_output=True, text=True, cwd=ROOT)
        assert result.returncode == 0, result.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["rendr", "fire"],
        ["render"],
        ["render", "fire"],
        ["still", "fire"],
        ["render", "fire", "-o", "a.mp4", "--sped", "1"],
    ],
)
def test_wrong_usage_is_2(gen_art, arguments):
    result = gen_art(*arguments)
    assert result.status == 2
    assert "Error: " in result.err
    assert not result.out


def test_an_unknown_command_is_suggested(gen_art):
    assert "did you mean 'render'?" in gen_art("rendr").err


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (GenArtError("sentence"), 1, "gen-art: sentence"),
        (UsageError("sentence"), 2, "gen-art: sentence"),
        (PresetError("f.yaml:1:1: sentence"), 3, "f.yaml:1:1: sentence"),
        (MemoryRefused("sentence"), 4, "gen-art: sentence"),
        (OutputError("sentence"), 5, "gen-art: sentence"),
        (EncoderError("sentence"), 6, "gen-art: sentence"),
        (MemoryError(), 4, "out of memory"),
        (RuntimeError("Virtual memory allocation (1073741824 B) failed."), 4, "past a limit of it (ulimit -v)"),
        (PermissionError(13, "Permission denied", "x.png"), 5, "Permission denied (x.png)"),
        (OSError(28, "No space left on device"), 5, "No space left"),
        (KeyboardInterrupt(), 130, "stopped"),
        (click.UsageError("sentence"), 2, "sentence"),
        (click.Abort(), 130, "stopped"),
        (ZeroDivisionError("by zero"), 1, "this is a bug: ZeroDivisionError: by zero"),
    ],
)
def test_errors_become_a_sentence_and_a_status(capsys, monkeypatch, error, status, words):
    def fail(*arguments, **options):
        raise error

    monkeypatch.setattr(command_line.cli, "main", fail)
    assert run([]) == status
    captured = capsys.readouterr()
    assert words in captured.err
    assert "Traceback" not in captured.err
    assert not captured.out


def test_a_bug_shows_its_traceback_on_request(capsys, monkeypatch):
    monkeypatch.setattr(command_line.cli, "main", lambda *a, **k: 1 / 0)
    monkeypatch.setenv("GEN_ART_DEBUG", "1")
    assert run([]) == 1
    assert "Traceback" in capsys.readouterr().err


def test_sigterm_is_143_and_unwinds():
    code = (
        "import sys, time\nfrom gen_art.commands import main as m\n"
        "def wait(*a, **k):\n    try:\n        print('ready', flush=True); time.sleep(30)\n    finally:\n        print('cleaned', flush=True)\n"
        "m.cli.main = wait\nsys.exit(m.run([]))"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=environment)
    assert process.stdout.readline() == "ready\n"
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=20)[0] == "cleaned\n"
    assert process.returncode == 143


def test_output_into_a_closed_pipe_is_no_error():
    code = "from gen_art.commands.main import main; main(['schema'])"
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    process.stdout.read(10)
    process.stdout.close()
    error = process.stderr.read()
    assert b"Traceback" not in error
    assert process.wait(timeout=20) == 0


def test_start_up_is_fast():
    python("from gen_art.commands.main import run; run(['--help'])")
    before = os.times()
    python("from gen_art.commands.main import run; run(['--help'])")
    after = os.times()  # processor time of the child: what else the machine does is no matter
    assert after.children_user + after.children_system - before.children_user - before.children_system < 1.0


def test_schema_is_json(gen_art):
    result = gen_art("schema")
    assert result.status == 0
    assert json.loads(result.out)["title"] == "Gen Art preset"
