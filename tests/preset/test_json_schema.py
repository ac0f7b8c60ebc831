"""The JSON schema: a YAML editor must accept what gen-art accepts, and know every registered name."""

import copy

import jsonschema
import pytest

from gen_art.preset.load import open_source
from gen_art.preset.reader import read_text
from gen_art.preset.registered import registry
from gen_art.preset.schema import json_schema
from gen_art.preset.shipped import preset_names

from .piece import TEXT

SCHEMA = json_schema()
CHECK = jsonschema.Draft202012Validator(SCHEMA)
PIECE = read_text(TEXT, "piece.yaml").plain()


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_it_accepts_the_test_preset():
    CHECK.validate(PIECE)


@pytest.mark.parametrize("name", preset_names())
def test_it_accepts_every_shipped_preset(name):
    source, _ = open_source(name)
    CHECK.validate(source.plain())


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (["systems", "drops", "emitters", "nozzle", "rte"], 5),
        (["systems", "drops", "emitters", "nozzle", "rate"], -5),
        (["systems", "drops", "emitters", "nozzle", "velocity"], {"kone": [0, 1, 0]}),
        (["systems", "drops", "emitters", "nozzle", "velocity"], {"cone": [0, 1, 0], "angel": 5}),
        (["forces", "gravty"], 5),
        (["forces", "drag"], {"cd": -1}),
        (["medium", "drag"], {}),
        (["clock", "fps"], 0),
        (["clock", "duraton"], 5),
        (["camera", "fov"], [1]),
        (["version"], 2),
        (["extra"], 1),
    ],
)
def test_it_refuses_what_is_wrong(path, value):
    piece = copy.deepcopy(PIECE)
    node = piece
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    with pytest.raises(jsonschema.ValidationError):
        CHECK.validate(piece)


def test_every_registered_class_is_in_it_with_a_description():
    system, emitter = SCHEMA["$defs"]["SystemSpec"]["properties"], SCHEMA["$defs"]["EmitterSpec"]["properties"]
    for kind, known in (
        ("forces", system["forces"]["properties"]),
        ("interactions", system["interactions"]["properties"]),
        ("emitters", emitter),
    ):
        for name in registry(kind):
            assert known[name]["description"], name
    for kind, key in (("shapes", "shape"), ("velocities", "velocity")):
        options = [set(option.get("required", ())) for option in emitter[key]["anyOf"]]
        assert all({name} in options for name in registry(kind))
