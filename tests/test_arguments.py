"""A wrong argument of any public function is a sentence that names it: the table of wrong values meets every argument."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.preset.registered import registry

SMALL_GRID = np.ones((2, 2, 2, 3))
REQUIRED = {  # of registered classes: the arguments that they need
    "vector_field": {"field": SMALL_GRID},
    "electric_grid": {"field": SMALL_GRID},
    "magnetic_grid": {"field": SMALL_GRID},
    "sdf": {"function": np.ones((2, 2, 2))},
    "body": {"shape": {"sphere": 1.0}, "points": 20},
}
KINDS = ("forces", "interactions", "colliders", "shapes", "velocities", "emitters")


class Thing:
    """An object that no argument can be."""


WRONG = {
    "a truth value": True,
    "a word": "x",
    "no text": "",
    "digits": "123",
    "bytes": b"xyz",
    "a negative number": -1,
    "zero": 0,
    "a fraction": 2.5,
    "not a number": float("nan"),
    "infinity": float("inf"),
    "400 digits": 10**400,
    "a complex number": 1j,
    "an empty list": [],
    "a pair": [1, 2],
    "three numbers": [1, 2, 3],
    "words": ["a", "b", "c"],
    "a ragged list": [[1, 2], [3]],
    "a mapping": {"a": 1},
    "a mapping of numbers": {1: 2},
    "an object": Thing(),
    "a flat array": np.zeros((2, 2)),
    "positions": np.zeros((2, 3)),
    "an array of words": np.array(["a", "b", "c"]),
    "an array of objects": np.array([1, None, Thing()], object),
    "a function": lambda: 0,
    "a class": ga.ParticleSystem,
    "a range": range(3),
    "a set": {1, 2},
    "nothing": None,
    "a date": np.datetime64("2020-01-01"),
}


def gravity():
    return ga.forces.Gravity((0.0, -9.81, 0.0))


def system(**changes):
    return ga.ParticleSystem(**{"position": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], **changes})


def simulation(**changes):
    return ga.Simulation({"stars": system()}, **{"dt": 0.01, **changes})


PRESET = {
    "version": 1,
    "clock": {"duration": 1, "step": "1/60"},
    "systems": {"stars": {"emitters": {"one": {"count": 3}}}},
}
# label -> (function of one argument by keyword, the names of its arguments)
CALLS = {
    "ParticleSystem": (
        system,
        "position velocity mass charge radius forces interactions colliders integrator speed_of_light exact_gyration medium "
        "attributes fixed emitters look",
    ),
    "attributes": (lambda hue: system(attributes={"hue": hue}), "hue"),
    "look": (lambda **change: system(look=change), "draw radius pixels size emission opacity trail ribbon light"),
    "Simulation": (lambda **change: simulation(**change), "dt seed precision arch threads"),
    "systems": (lambda systems: ga.Simulation(systems, dt=0.01), "systems"),
    "one system": (lambda systems: ga.Simulation({"stars": systems}, dt=0.01), "systems"),
    "preset": (lambda **change: ga.Simulation(ga.load_preset(PRESET), **change), "dt seed"),
    "advance": (lambda time: simulation().advance(time), "time"),
    "step": (lambda steps: simulation().step(steps), "steps"),
    "advance_to_frame": (lambda frame: ga.Simulation(ga.load_preset(PRESET)).advance_to_frame(frame), "frame"),
    "system of a name": (lambda system: simulation()[system], "system"),
    "attribute": (lambda attribute: simulation()["stars"].attribute(attribute), "attribute"),
    "adaptive": (lambda **change: ga.adaptive(**{"sim": simulation(), "seconds": 0.01, **change}), "sim seconds rtol atol"),
    "set": (
        lambda **change: simulation()["stars"].set(**change),
        "position velocity mass charge radius attributes where",
    ),
    "add": (
        lambda **change: simulation()["stars"].add(**{"position": (0, 0, 0), **change}),
        "position velocity mass charge radius attributes lifetime",
    ),
    "remove": (lambda ids: simulation()["stars"].remove(ids), "ids"),
    "view": (lambda name: simulation()["stars"].view(name), "name"),
    "record": (lambda **change: simulation().record(**change), "every what to"),
    "save of a record": (lambda path: simulation().record().save(path), "path"),
    "orbital_elements": (
        lambda **change: ga.orbital_elements(**{"position": (1, 0, 0), "velocity": (0, 1, 0), "GM": 1.0, **change}),
        "position velocity GM axis reference",
    ),
    "orbital_elements of particles": (
        lambda **change: simulation()["stars"].orbital_elements(**{"of": 1, "about": 0, "G": 1.0, **change}),
        "of about G axis reference",
    ),
    "Medium": (ga.Medium, "density wind curl_noise vortices field"),
    "noise": (lambda curl_noise: ga.Medium(curl_noise={"strength": curl_noise}), "curl_noise"),
    "Camera": (ga.Camera, "position target up fov height roll near far shutter lens spec"),
    "lens": (lambda lens: ga.Camera(lens=(lens, None)), "lens"),
    "focus": (lambda lens: ga.Camera(lens=(0.1, lens)), "lens"),
    "framing": (ga.Camera.framing, "points"),
    "aspect": (lambda aspect: ga.Camera.framing([[0, 0, 0]], aspect), "aspect"),
    "render_frame": (
        lambda **change: ga.render_frame(**{"sim": simulation(), "size": (8, 6), **change}),
        "sim size camera",
    ),
    "body": (
        lambda **change: ga.body(**{"shape": {"sphere": 0.5}, "points": 20, **change}),
        "shape mass density hollow position turn velocity spin pivot axle static draw points grain tint name",
    ),
    "sphere": (lambda sphere: ga.body({"sphere": sphere}, points=20), "sphere"),
    "box": (lambda box: ga.body({"box": box}, points=20), "box"),
    "bodies": (ga.bodies, "members"),
    "bodies.system": (
        lambda **change: ga.bodies([ga.body({"sphere": 0.5}, points=20)]).system(**change),
        "rigid interactions attributes forces",
    ),
    "chain": (
        lambda **change: ga.chain(**{"start": (0, 0, 0), "end": (1, 0, 0), "count": 3, **change}),
        "start end count",
    ),
    "rope": (
        lambda **change: ga.rope(**{"start": (0, 0, 0), "end": (1, 0, 0), "count": 3, **change}),
        "start end count length bend",
    ),
    "cloth": (
        lambda **change: ga.cloth(
            **{"corner": (0, 0, 0), "across": (1, 0, 0), "down": (0, -1, 0), "columns": 2, "rows": 2, **change}
        ),
        "corner across down columns rows shear bend",
    ),
    "load_preset": (lambda **change: ga.load_preset(**{"preset": PRESET, **change}), "preset overrides seed"),
    "a value of a preset": (lambda fps: ga.load_preset(PRESET, overrides={"clock.fps": fps}), "fps"),
    "a colour of a preset": (
        lambda gradient: ga.load_preset(PRESET, overrides={"systems.stars.look": {"emission": gradient}}),
        "gradient",
    ),
    "render": (
        lambda **change: ga.render(**{"preset": PRESET, "out": "no-such-ending.xyz", **change}),
        "preset out frames size scale fps quality precision threads codec profile bits plugins",
    ),
    "param": (lambda **change: ga.param(1.0, **change), "min max choices kind"),
    "force": (lambda name: ga.force(name)(type("Unnamed", (ga.Force,), {})), "name"),
}  # fmt: skip


def refused(call, **arguments) -> str:
    """The sentence with which a call refuses its argument; empty if it takes it. Any other exception is a failure."""
    try:
        call(**arguments)
    except ga.GenArtError as error:
        sentence = str(error)
        assert sentence and len(sentence) < 700 and "Traceback" not in sentence and "0x" not in sentence
        return sentence
    return ""


@pytest.mark.parametrize("label", WRONG)
@pytest.mark.parametrize("kind", KINDS)
def test_registered_classes(kind, label):
    classes = registry(kind)
    for name in classes:
        for key in classes[name].parameters:
            sentence = refused(classes[name], **{**REQUIRED.get(name, {}), key: WRONG[label]})
            if label == "an object":
                assert key in sentence or "field" in sentence, (name, key, sentence)


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.filterwarnings("ignore")
def test_public_functions(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, keys = CALLS[name]
    for key in keys.split():
        for label, value in WRONG.items():
            sentence = refused(call, **{key: value})
            if label == "an object":
                assert sentence, (key, label)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: system(forces=gravity()), "forces must be a list of objects such as ga.forces.Gravity(...)"),
        (lambda: system(forces=["gravity"]), "'gravity' is none"),
        (lambda: system(interactions=ga.interactions.SelfGravity()), "interactions must be a list"),
        (lambda: system(colliders=ga.colliders.Plane()), "colliders must be a list"),
        (lambda: system(mass="heavy"), "mass must be one number, or one for each particle, not 'heavy'"),
        (lambda: system(radius=[0.1, [0.2]]), "radius must be one number"),
        (lambda: system(radius=-1.0), "radius must not be negative"),
        (lambda: system(medium={"density": 1.2}), "medium must be a ga.Medium, not a mapping of 1"),
        (lambda: system(emitters=3), "emitters must be a list"),
        (lambda: ga.Simulation(system(), dt=0.01), 'write {"stars": system}'),
        (lambda: ga.Simulation({1: system()}, dt=0.01), "must be text, not 1"),
        (lambda: ga.Simulation("fire"), "ga.load_preset(...)"),
        (lambda: simulation(dt="fast"), "dt, the time step, must be a finite number above 0 s, not 'fast'"),
        (lambda: simulation(seed=1.5), "seed must be a whole number of at least 0, not 1.5"),
        (lambda: simulation(seed=-1), "seed must be a whole number"),
        (lambda: simulation(threads=0), "threads must be a whole number from 1 to 1,024, not 0"),
        (lambda: simulation(threads="two"), "threads must be a whole number from 1 to 1,024, not 'two'"),
        (lambda: simulation().advance("x"), "the time to advance by must be a finite number s, not 'x'"),
        (lambda: simulation().step(2.5), "the number of steps must be a whole number of at least 0, not 2.5"),
        (lambda: ga.render_frame(simulation(), camera={"fov": 30}), "camera must be a ga.Camera"),
        (lambda: ga.forces.Drag(medium={"wind": 1}), "medium must be a ga.Medium"),
        (lambda: ga.forces.Gravity("123"), "field must be three finite numbers"),
        (lambda: ga.force(type("Swirl", (ga.Force,), {})), '@ga.force("name")'),
    ],
)  # fmt: skip
def test_the_sentence_names_the_argument_and_what_it_must_be(call, words):
    with pytest.raises(ga.UsageError) as error:
        call()
    assert words in str(error.value)
