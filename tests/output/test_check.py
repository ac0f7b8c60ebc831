"""What `validate` accepts can be made; what cannot be made, `validate` refuses, with the sentence of the one that makes it."""

import pytest

from gen_art.errors import PresetError
from gen_art.output.check import check_preset
from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset

BASE = {
    "version": 1,
    "clock": {"duration": 1, "fps": 10, "step": "1/100"},
    "systems": {
        "dots": {
            "integrator": "semi_implicit_euler",
            "particle": {"radius": 0.05, "attributes": {"heat": 1}},
            "emitters": {"burst": {"count": 8, "shape": {"ball": 1}}},
            "look": {"draw": "disc"},
        }
    },
    "camera": {"position": [0, 0, 5], "size": [32, 18]},
}
BODY = {"burst": {"body": {"shape": {"box": [1, 1, 1]}, "points": 20}}}
ROPE = {"burst": {"rope": {"count": 5}}}
S = "systems.dots."

ACCEPTED = {
    "as it is": {},
    "no size": {S + "particle.radius": 0},
    "no births": {S + "emitters.burst.count": 0},
    "no emitters": {S + "emitters": {}},
    "a tiny sprite": {S + "look.radius": 1e-30},
    "a huge sprite": {S + "look.radius": 1e18},
    "bright": {S + "look.emission": {"intensity": 1e18}},
    "a narrow view": {"camera.fov": 1e-6},
    "a life of less than a step": {S + "particle.lifetime": 1e-9},
    "a colour by an attribute": {S + "look.emission": {"color": {"by": "heat", "range": "0..2", "gradient": ["red", "blue"]}}},
    "contacts": {S + "interactions": {"contacts": {}}},
    "a rope": {S + "emitters": ROPE, S + "interactions": {"springs": {"method": "xpbd"}}},
    "a body": {S + "emitters": BODY, S + "interactions": {"rigid": {}}},
    "a long body": {
        S + "emitters": {"burst": {"body": {"shape": {"box": [1e3, 0.01, 0.01]}, "points": 20}}},
        S + "interactions": {"rigid": {}},
    },
    "gravity of its own": {S + "interactions": {"self_gravity": {"G": 1, "softening": 0.1}}},
}  # fmt: skip
REFUSED = {
    "no mass for a force": ({S + "particle.mass": 0, S + "forces": {"spring": {}}}, "without mass has no acceleration"),
    "no mass for contacts": ({S + "particle.mass": 0, S + "interactions": {"contacts": {}}}, "has no mass"),
    "spin by another integrator": (
        {S + "integrator": "rk4", S + "interactions": {"contacts": {"rolling": 0.1}}}, "spin is advanced once a step",
    ),
    "springs without a net": ({S + "interactions": {"springs": {}}}, "springs: 'dots' has none"),
    "springs by another integrator": (
        {S + "integrator": "rk4", S + "emitters": ROPE, S + "interactions": {"springs": {"method": "implicit"}}},
        "semi_implicit_euler",
    ),
    "bodies by another integrator": (
        {S + "integrator": "rk4", S + "emitters": BODY, S + "interactions": {"rigid": {}}}, "rigid bodies move by leapfrog",
    ),
    "bodies of dots": ({S + "interactions": {"rigid": {}}}, "must lay such"),
    "bodies that die": (
        {S + "particle.lifetime": 1, S + "emitters": BODY, S + "interactions": {"rigid": {}}}, "rigid bodies do not die",
    ),
    "bodies that overlap": (
        {S + "emitters": {**BODY, "other": BODY["burst"]}, S + "interactions": {"rigid": {}}}, "overlap by",
    ),
    "bodies on a wheel": (
        {S + "emitters": BODY, S + "interactions": {"rigid": {}}, "colliders": {"plane": {"angular_velocity": [1, 0, 0]}}},
        "colliders that do not rotate",
    ),
    "a force without its attribute": ({S + "forces": {"panel": {"density": 1}}}, "needs particles with the attribute"),
    "a look by an unknown attribute": (
        {S + "look.emission": {"color": {"by": "heart", "range": "0..2", "gradient": ["red", "blue"]}}},
        "a look cannot go by 'heart'; did you mean 'heat'",
    ),
    "a camera at its target": ({"camera.position": [0, 0, 0]}, "camera"),
    "a path through its target": (
        {"camera.path": [{"time": -1, "position": [0, 0, 5], "easing": "linear"}, {"time": 1, "position": [0, 0, -5]}]},
        "looks nowhere",
    ),
    "a drawing too large": ({"camera.size": [16384, 16384], "camera.supersample": 2}, "supersample"),
    "a poster between steps": ({"gallery.time": 0.1234567}, "falls between steps"),
}  # fmt: skip


@pytest.mark.parametrize("label", ACCEPTED)
def test_what_is_accepted_is_made(label):
    preset = load_preset(BASE, overrides=ACCEPTED[label])
    check_preset(preset)
    assert Playback(preset, (32, 18), "f32", None).picture(2).shape == (18, 32, 4)


@pytest.mark.parametrize("label", REFUSED)
def test_what_cannot_be_made_is_refused(label):
    change, words = REFUSED[label]
    with pytest.raises(PresetError, match=words):
        check_preset(load_preset(BASE, overrides=change))
