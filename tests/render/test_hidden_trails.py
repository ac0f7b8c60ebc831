"""Trails among surfaces: each moment's light is hidden by the surfaces of that moment.

Mutants that were tried, each of which fails a test here: trails that nothing hides; all of a trail hidden by the surfaces of
the last moment; surfaces of the earlier moments without those of particles, or without liquids.
"""

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset

SIZE = (96, 64)
BLACK = {"albedo": "black", "ior": 1}


def pictures(steps, trail=True, size=SIZE, **keys):
    """The pictures after these steps of 1/40 s, at 10 frames/s."""
    basis = {
        "version": 1, "clock": {"duration": 2, "fps": 10, "step": "1/40"}, "light": {"ambient_intensity": 0.5},
        "camera": {"position": [0, 0, 6], "target": [0, 0, 0], "fov": 30}, **keys,
    }  # fmt: skip
    systems = {}
    for name, system in basis.pop("systems").items():
        look = dict(system["look"])
        if not trail:
            look.pop("trail", None)
        systems[name] = {**system, "look": look}
    playback = Playback(load_preset({**basis, "systems": systems}), size, "f32", None)
    return [playback.picture(step).copy() for step in steps]


def spark(position, velocity=(0, 0, 0), **trail):
    return {
        "emitters": {"one": {"count": 1, "shape": {"point": list(position)}, "velocity": {"constant": list(velocity)}}},
        "look": {
            "draw": "disc",
            "radius": 0.05,
            "emission": {"color": "white", "intensity": 50},
            "trail": {"half_life": 1, "substeps": 4, **trail},
        },
    }


def in_ball(radius, centre=(0, 0), size=SIZE):
    """Pixels whose middles lie in a ball's outline by a pixel and more, before a camera at a distance of 6 and a fov of 30."""
    scale = 0.5 * size[1] / np.tan(np.radians(15))
    x, y = np.meshgrid(np.arange(size[0]) + 0.5 - size[0] / 2, size[1] / 2 - np.arange(size[1]) - 0.5)
    direction = np.stack([x / scale, y / scale, -np.ones_like(x)], axis=2)
    direction /= np.linalg.norm(direction, axis=2)[..., None]
    to_centre = np.array([*centre, -6.0])
    aside = np.linalg.norm(to_centre - (direction @ to_centre)[..., None] * direction, axis=2)
    return aside < radius - 1.5 * 6 / scale


BALL = {"particle": {"radius": 0.5}, "emitters": {"one": {"count": 1, "shape": {"point": [0, 0, 0]}}},
        "look": {"draw": "sphere", "blend": "opaque", "albedo": "grey"}}  # fmt: skip
SURFACES = {
    "collider": ({"colliders": {"sphere": {"center": [0, 0, 0], "radius": 0.5, "look": "grey"}}}, {}),
    "particle": ({}, {"ball": BALL}),
    "liquid": ({}, {"drop": {**BALL, "look": {"draw": "surface", "albedo": "grey", "liquid": {"clear": False}}}}),
}


@pytest.mark.parametrize("what", SURFACES)
@pytest.mark.parametrize("behind", [True, False])
def test_a_trail_behind_a_ball_is_hidden_and_one_before_it_is_not(what, behind):
    more, systems = SURFACES[what]
    line = {"spark": spark((-1.4, 0, -1 if behind else 1), (2, 0, 0))}
    if what == "collider":
        more = {"systems": {"spark": {**line["spark"], **more}}}  # it only meets the spark's system, and is far from it
        keys = {"trail": True, **more}
    else:
        keys = {"systems": {**line, **systems}}
    with_trail, without = (pictures([56], **{**keys, "trail": trail})[0] for trail in (True, False))
    added = (with_trail - without)[..., :3]
    inside = in_ball(0.5)
    row = added[32, :, 0]
    assert inside.sum() > 100 and row[:35].max() > 0.01, "the trail is there, beside the ball"
    if behind:
        assert np.abs(added[inside]).max() == 0
    else:
        assert row[inside[32]].min() > 0.01


def test_the_afterglow_is_that_of_the_moments_when_nothing_hid_it():
    """A black ball passes before a spark at rest and is gone. Of exposures at the film times t_k the part f^(n - k) (1 - f) is
    left, f = 0.5^(interval / half_life): without those at which the ball hid the spark."""
    ball = {"center": [-2, 0, 0], "radius": 0.5, "velocity": [2, 0, 0], "look": BLACK}
    spark_alone = {"spark": spark((0, 0, -1))}
    passed = {"spark": {**spark((0, 0, -1)), "colliders": {"sphere": {**ball, "action": "bounce"}}}}
    step = 64  # 1.6 s: the ball is at x = 1.2
    lit = pictures([step], systems=spark_alone)[0] - pictures([step], systems=spark_alone, trail=False)[0]
    got = pictures([step], systems=passed)[0] - pictures([step], systems=passed, trail=False)[0]
    row, column = np.unravel_index(lit[..., 0].argmax(), lit.shape[:2])
    # exposures lie on every step and from 16 half-lives before frame 0 on, which here is the first step
    times = np.arange(1, step + 1) / 40
    left = 0.5 ** ((step / 40 - times) / 1.0)
    hidden = np.abs(-2 + 2 * times) < 0.5 - 0.08
    unsure = (np.abs(np.abs(-2 + 2 * times) - 0.5) <= 0.08) & ~hidden
    low, high = (left[~hidden & ~unsure].sum() / left.sum(), left[~hidden].sum() / left.sum())
    ratio = got[row, column, 0] / lit[row, column, 0]
    assert high < 0.8 and low - 1e-3 <= ratio <= high + 1e-3


def test_a_film_and_the_still_of_its_frame_have_the_same_bytes():
    keys = {"systems": {"ball": BALL, "spark": spark((-1.4, 0, -1), (2, 0, 0))}}
    film = pictures([0, 4, 8, 40], **keys)
    assert np.array_equal(film[-1], pictures([40], **keys)[0])
    tiny = pictures([8], size=(1, 1), **keys)[0]
    assert np.isfinite(tiny).all()
