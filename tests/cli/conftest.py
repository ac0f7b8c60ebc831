"""Commands run in this process: status, standard output, standard error."""

from dataclasses import dataclass

import pytest

from gen_art.commands.main import run
from tests.preset.piece import TEXT


@dataclass
class Result:
    status: int
    out: str
    err: str


@pytest.fixture
def gen_art(capsys, tmp_path, monkeypatch):
    """Run `gen-art ARGUMENTS` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments) -> Result:
        capsys.readouterr()
        status = run([str(argument) for argument in arguments])
        return Result(status, *capsys.readouterr())

    return call


@pytest.fixture
def piece(tmp_path):
    """A file with the test preset, in the folder that commands run in."""
    path = tmp_path / "piece.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path
