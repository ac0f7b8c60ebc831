"""The Preset: what is accepted, what every part becomes, what must fit together."""

import copy
import json

import numpy as np
import pytest

from gen_art.errors import MemoryRefused, PresetError, UsageError
from gen_art.preset.estimate import estimate, refuse_if_too_large
from gen_art.preset.files import FOLDER
from gen_art.preset.load import load_preset
from gen_art.preset.reader import read_text
from gen_art.preset.schema import json_schema
from gen_art.preset.values import Curve, Range

from .piece import TEXT

PIECE = read_text(TEXT, "piece.yaml").plain()


def load(**overrides):
    return load_preset(PIECE, overrides={key.replace("__", "."): value for key, value in overrides.items()})


@pytest.fixture
def write(tmp_path):
    def save(text):
        path = tmp_path / "piece.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return save


def problems(text, write):
    with pytest.raises(PresetError) as caught:
        load_preset(write(text))
    return caught.value.problems


def test_the_parts_of_a_preset():
    piece = load_preset(PIECE)
    assert piece.seed == 5
    assert piece.clock.frames == 60
    assert piece.clock.steps_per_frame == 4
    assert piece.clock.preroll_steps == 60
    assert [force.name for force in piece.forces] == ["drag", "gravity"]
    assert [term.name for term in piece.medium.terms] == ["wind"]
    drops, splash = piece.systems.values()
    assert drops.particle.lifetime == Range(1, 2)
    assert drops.particle.attributes == {"hue": Range(0, 1)}
    nozzle, burst = drops.emitters["nozzle"], splash.emitters["burst"]
    assert nozzle.rate == 200
    assert nozzle.velocity.values["speed"] == (9.0, 9.0)
    assert nozzle.velocity.values["angle"] == pytest.approx(0.17453, rel=1e-4)
    assert (burst.source.system, burst.source.kind, burst.source.tag) == ("drops", "death", ("wet",))
    assert burst.count == Range(4, 4)


def test_a_rate_may_be_a_curve():
    piece = load(systems__drops__emitters__nozzle__rate=[[0, 0], [1, 50]])
    assert piece.systems["drops"].emitters["nozzle"].rate == Curve(((0, 0), (1, 50)))


def test_the_resolved_preset_is_plain_and_loads_to_the_same():
    piece = load_preset(PIECE, overrides={"knobs.push": 4}, seed=11)
    resolved = piece.resolved()
    assert json.loads(json.dumps(resolved)) == resolved
    assert "knobs" not in resolved
    again = load_preset(resolved)
    assert again == piece
    assert again.seed == 11
    assert again.systems["drops"].emitters["nozzle"].velocity.values["speed"] == (4.0, 4.0)
    assert load_preset(piece) == piece
    assert load_preset(PIECE) != piece


def test_loading_leaves_a_mapping_as_it_was():
    before = copy.deepcopy(PIECE)
    load_preset(PIECE, overrides={"clock": {"duration": 1}}, seed=3)
    assert before == PIECE


# path, value, words of the problem, path it stands under
WRONG = [
    ("systems.drops.emitters.nozzle.rte", 5, "did you mean 'rate'?", "systems.drops.emitters.nozzle.rte"),
    ("systems.drops.emitters.nozzle.rate", -1, "at least 0", "systems.drops.emitters.nozzle.rate"),
    ("systems.drops.emitters.nozzle.rate", "many", "must be a number", "systems.drops.emitters.nozzle.rate"),
    ("systems.drops.emitters.nozzle.rate", [[0, 1], [1, -1]], "at least 0", "systems.drops.emitters.nozzle.rate"),
    ("systems.drops.emitters.nozzle.count", 3, "rate and count are alternatives", "systems.drops.emitters.nozzle"),
    ("systems.drops.emitters.nozzle.at", [1], "rate and at are alternatives", "systems.drops.emitters.nozzle"),
    (
        "systems.drops.emitters.nozzle.rate",
        None,
        "needs one of rate, at, count or from",
        "systems.drops.emitters.nozzle",
    ),
    ("systems.drops.emitters.nozzle.stop", 0, "later than start", "systems.drops.emitters.nozzle"),
    (
        "systems.drops.emitters.nozzle.attributes",
        {"hu": 1},
        "did you mean 'hue'",
        "systems.drops.emitters.nozzle.attributes.hu",
    ),
    (
        "systems.splash.emitters.burst.rate",
        3,
        "needs a count, not a rate|alternatives",
        "systems.splash.emitters.burst",
    ),
    ("systems.splash.emitters.burst.start", 1, "start and from are alternatives", "systems.splash.emitters.burst"),
    ("systems.splash.emitters.burst.stop", 1, "stop and from are alternatives", "systems.splash.emitters.burst"),
    ("systems.splash.emitters.burst.motion", {}, "motion and from are alternatives", "systems.splash.emitters.burst"),
    ("systems.splash.emitters.burst.count", None, "needs a count", "systems.splash.emitters.burst"),
    ("systems.splash.emitters.burst.count", 1.5, "whole number", "systems.splash.emitters.burst.count"),
    ("systems.splash.emitters.burst.from", "drops.path", "needs a rate", "systems.splash.emitters.burst"),
    (
        "systems.splash.emitters.burst.from.event",
        "drop.death",
        "did you mean 'drops'",
        "systems.splash.emitters.burst.from.event",
    ),
    (
        "systems.splash.emitters.burst.from.event",
        "drops.deth",
        "did you mean 'death'",
        "systems.splash.emitters.burst.from",
    ),
    ("systems.splash.emitters.burst.from.tag", "dry", "has the tag 'dry'", "systems.splash.emitters.burst.from.tag"),
    (
        "systems.splash.emitters.burst.from.inherit",
        "all",
        "one of velocity, none",
        "systems.splash.emitters.burst.from.inherit",
    ),
    ("systems.splash.particle.density", 5, "mass and density are alternatives", "systems.splash.particle"),
    ("systems.splash.particle.lifetime", 0, "more than 0", "systems.splash.particle.lifetime"),
    ("systems.splash.particle.lifetime", "4..2", "write 2..4", "systems.splash.particle.lifetime"),
    ("systems.splash.integrator", "rk5", "unknown integrator", "systems.splash.integrator"),
    ("systems.splash.forces", {"gravty": 1}, "did you mean 'gravity'", "systems.splash.forces.gravty"),
    ("systems.splash.look.emission.color.dry", "red", "nor a tag", "systems.splash.look.emission.color.dry"),
    ("systems.a.b", {}, "there is no 'a' in systems", ""),
    ("systems.splash.forces", {"self_gravity": {}}, "goes under interactions:", "systems.splash.forces.self_gravity"),
    ("systems.splash.interactions", {"lift": {}}, "it is a force", "systems.splash.interactions.lift"),
    ("systems.splash.emitters.burst.from", "drops.impact", "has action: emit", "systems.splash.emitters.burst.from"),
    ("medium.density", 0, "needs the fluid's density", "forces.drag"),
    ("medium.density", -1, "at least 0", "medium.density"),
    ("medium.drag", {}, "unknown key", "medium.drag"),
    ("forces.drag.cd", "big", "must be a number", "forces.drag.cd"),
    ("clock.fps", 31, "the nearest fps is 30", "clock.fps"),
    ("clock.fps", 0, "more than 0", "clock.fps"),
    ("clock.duration", 0.01, "makes no frame", "clock.duration"),
    ("clock.preroll", 0.501, "nearest is 0.5", "clock.preroll"),
    ("clock.step", 1e-300, "steps a frame, and may have 1,000,000 at most: give a longer step", "clock.step"),
    ("version", 2, "version 2", "version"),
    ("version", "1", "must be 1", "version"),
    ("seed", 1.5, "whole number", "seed"),
    ("seed", -1, "whole number", "seed"),
    ("systems", 3, "mapping of keys", "systems"),
    ("camera.fov", float("nan"), "finite", "camera.fov"),
    ("clock.duration", float("inf"), "finite", "clock.duration"),
]


@pytest.mark.parametrize(("path", "value", "words", "place"), WRONG)
def test_what_is_wrong_is_named_with_its_place(path, value, words, place):
    with pytest.raises((PresetError, UsageError), match=words) as caught:
        load_preset(PIECE, overrides={path: value})
    if place:
        assert place in [_dotted(problem) for problem in caught.value.problems]


def test_impacts_need_one_collider_that_emits_shared_or_own():
    wall = {"plane": {"normal": [0, 1, 0], "action": "emit"}}
    fed = {"systems.splash.emitters.burst.from": "drops.impact"}
    several = {"plane": [{"normal": [0, 1, 0]}, *wall.values()]}
    for given in ({"colliders": wall}, {"systems.drops.colliders": wall}, {"colliders": several}):
        load_preset(PIECE, overrides={**fed, **given})
    with pytest.raises(PresetError, match="no collider of 'drops'"):
        load_preset(PIECE, overrides={**fed, "colliders": wall, "systems.drops.inherit_colliders": False})


def test_the_files_of_colliders_are_part_of_the_preset(tmp_path):
    np.save(tmp_path / "ball.npy", np.ones((2, 2, 2)))
    for where in ("colliders", "systems.drops.colliders"):
        token = FOLDER.set(tmp_path)
        try:
            piece = load_preset(PIECE, overrides={where: {"sdf": {"function": "ball.npy"}}})
        finally:
            FOLDER.reset(token)
        assert [str(file) for file in piece.files] == ["ball.npy"]


def _dotted(problem):
    return ".".join(map(str, problem.path))


def test_every_problem_of_a_file_at_once(write):
    text = TEXT.replace("rate: 200", "rte: 200").replace("cd: 0.5", "cd: .nan").replace("angle: 10", "angle: 400")
    text = text.replace("fps: 30", "fps: 31").replace("drops.death", "drips.death").replace("draw: point", "draw: pint")
    found = problems(text, write)
    assert [(p.line, _dotted(p)) for p in found if p.line > 6] == [
        (7, "clock.fps"),
        (11, "forces.drag.cd"),
        (17, "systems.drops.emitters.nozzle.rte"),
        (19, "systems.drops.emitters.nozzle.velocity.angle"),
        (25, "systems.splash.emitters.burst.from.event"),
        (28, "systems.splash.look.draw"),
    ]


def test_the_message_has_the_form_of_the_design(write):
    problem = problems(TEXT.replace("rate: 200", "rte: 200"), write)[0]
    place, line, caret = str(problem).splitlines()
    assert place.endswith("piece.yaml:17:9: systems.drops.emitters.nozzle.rte: unknown key; did you mean 'rate'?")
    assert line == "            rte: 200"
    assert caret == "            ^"


def test_missing_keys_are_named(write):
    found = problems("version: 1\nclock: {fps: 30}\n", write)
    assert {p.text for p in found} == {"'systems' is missing", "'duration' is missing", "'step' is missing"}


def test_a_constant_of_gravitation_left_out_is_the_one_of_the_units():
    piece = load(units={"G": 4.3e-6}, systems__drops__interactions={"self_gravity": {"softening": 1}})
    assert piece.systems["drops"].interactions[0].values["G"] == 4.3e-6
    given = load(units={"G": 4.3e-6}, systems__drops__interactions={"self_gravity": {"G": 1}})
    assert given.systems["drops"].interactions[0].values["G"] == 1


def test_a_preset_has_a_system():
    with pytest.raises(PresetError, match="at least 1 entry"):
        load_preset({**PIECE, "systems": {}})


def test_knobs(write):
    problem = problems(TEXT.replace("$push", "$psh"), write)[0]
    assert problem.line == 19
    assert "did you mean '$push'?" in problem.text
    assert "not another knob" in problems(TEXT.replace("push: 9", "push: $life"), write)[0].text


@pytest.mark.parametrize("fps", [24, 25, 48, 50])
def test_the_nearest_fps_that_is_named_is_accepted(fps):
    try:
        load(clock__fps=fps)
    except PresetError as error:
        nearest = float(str(error).rpartition("nearest fps is ")[2].split()[0])
        assert load(clock__fps=nearest).clock.steps_per_frame >= 1


def test_the_estimate_counts_births_and_the_living():
    piece = load_preset(PIECE)
    expected = estimate(piece)
    simulated = piece.clock.simulated
    assert expected.born["drops"] == pytest.approx(200 * simulated, rel=0.01)
    assert expected.peak["drops"] == pytest.approx(200 * 1.5, rel=0.1)  # mean life 1.5 s
    assert expected.peak["splash"] == pytest.approx(4 * 200 * 0.5, rel=0.15)
    steady = estimate(load(systems__drops__particle__lifetime=100))
    assert steady.peak["drops"] == pytest.approx(200 * simulated, rel=0.01)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("systems.drops.emitters.nozzle.rate", 1e12),
        ("systems.drops.emitters.nozzle.rate", "1e300"),
        ("systems.splash.emitters.burst.count", 1e12),
        ("systems.drops.emitters.nozzle", {"count": 1_000_000_000_000, "tag": "wet"}),
    ],
)
def test_a_million_million_particles_are_refused_with_the_figure(path, value):
    piece = load_preset(PIECE, overrides={path: value})
    with pytest.raises(MemoryRefused, match=r"\d.* particles") as caught:
        refuse_if_too_large(piece)
    assert caught.value.exit_code == 4


def test_a_system_that_feeds_itself_without_end_is_refused():
    burst = {"from": "drops.death", "count": 40}
    with pytest.raises(MemoryRefused):
        refuse_if_too_large(load(systems__drops__emitters__again=burst, systems__drops__particle__lifetime=0.1))


def test_the_json_schema_holds_registered_classes_and_units():
    schema = json_schema()
    forces = schema["properties"]["forces"]["properties"]
    assert forces["gravity"]["anyOf"][0]["properties"]["field"]["unit"] == "m/s^2"
    emitter = schema["$defs"]["EmitterSpec"]["properties"]
    assert {"rate", "from", "shape", "velocity"} <= set(emitter)
    assert schema["$defs"]["Clock"]["properties"]["duration"]["unit"] == "s"
    assert schema["$defs"]["SystemSpec"]["additionalProperties"] is False
    json.dumps(schema, allow_nan=False)
