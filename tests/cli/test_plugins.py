"""A user's Python file: its classes become keys that are accepted, checked and described."""

import hashlib
import json

import pytest

from gen_art.errors import OutputError, UsageError
from gen_art.plugins import load_plugin
from tests.preset.piece import TEXT

SWIRL = '''
import gen_art as ga
from gen_art import ti


@ga.force("test_swirl")
class TestSwirl(ga.Force):
    """A solid-body push around the y axis. a = strength (y x r)."""

    strength: float = ga.param(1.0, unit="1/s^2", min=0)

    @ti.func
    def acceleration(self, p, t, q):
        return q.strength * ti.Vector([-p.position.z, 0.0, p.position.x])
'''
WITH = TEXT.replace("  drag: {cd: 0.5}", "  drag: {cd: 0.5}\n  test_swirl: {strength: 2}")


@pytest.fixture
def swirl(tmp_path):
    path = tmp_path / "swirl.py"
    path.write_text(SWIRL, encoding="utf-8")
    return path


def test_a_plugin_is_known_by_its_hash_and_runs_once(swirl, tmp_path):
    plugin = load_plugin(swirl)
    assert plugin.sha256 == hashlib.sha256(swirl.read_bytes()).hexdigest()
    assert plugin.name == "swirl.py"
    assert load_plugin(swirl) is plugin


def test_its_force_is_a_key(gen_art, swirl, tmp_path):
    (tmp_path / "piece.yaml").write_text(WITH, encoding="utf-8")
    facts = json.loads(gen_art("inspect", "piece.yaml", "--plugin", swirl, "--json").out)
    assert "TestSwirl(strength=2.0)" in facts["systems"]["drops"]["forces"]
    wrong = tmp_path / "wrong.yaml"
    wrong.write_text(WITH.replace("strength: 2", "strenght: 2"), encoding="utf-8")
    result = gen_art("validate", "wrong.yaml", "--plugin", swirl)
    assert result.status == 3
    assert "forces.test_swirl.strenght: unknown key; did you mean 'strength'?" in result.err


def test_its_force_is_in_the_schema(gen_art, swirl):
    schema = json.loads(gen_art("schema", "--plugin", swirl).out)
    described = schema["properties"]["forces"]["properties"]["test_swirl"]
    assert "solid-body push" in described["description"]
    assert described["anyOf"][0]["properties"]["strength"]["unit"] == "1/s^2"


@pytest.mark.parametrize("path", ["-", "none.py"])
def test_what_is_no_file_is_refused(path):
    with pytest.raises((UsageError, OutputError)):
        load_plugin(path)


def test_a_class_without_a_docstring_is_refused_by_name(tmp_path):
    path = tmp_path / "bare.py"
    path.write_text("import gen_art as ga\n\n@ga.force('bare')\nclass Bare(ga.Force):\n    pass\n")
    with pytest.raises(UsageError, match=r"bare\.py:3: .*needs a docstring"):
        load_plugin(path)
