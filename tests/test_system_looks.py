"""ParticleSystem(look=...): what a script says is what is drawn."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import UsageError

CAMERA = ga.Camera(position=(0, 0, 5), target=(0, 0, 0), fov=30)


def picture(look):
    system = ga.ParticleSystem(position=[[0.3, 0.2, 0]], look=look)
    return ga.render_frame(ga.Simulation({"s": system}, dt=0.1), size=(64, 36), camera=CAMERA)


def test_a_look_is_drawn():
    red = ga.Look(draw="disc", radius=0.3, emission={"color": "#ff0000", "intensity": 2})
    linear = picture(red)
    assert linear[..., 0].sum() > 100 * linear[..., 1].sum() and (linear[..., 0] > 0).sum() > 20
    same = picture({"draw": "disc", "radius": 0.3, "emission": {"color": "#ff0000", "intensity": 2}})
    assert np.array_equal(linear, same)
    blue = picture({"draw": "disc", "radius": 0.3, "emission": {"color": "#0000ff", "intensity": 2}})
    assert blue[..., 2].sum() > 100 * blue[..., 0].sum()  # the mutant: another colour


def test_without_a_look_it_is_white_points():
    linear = picture(None)
    assert 1 <= (linear[..., 0] > 0).sum() <= 4 and np.array_equal(linear[..., 0], linear[..., 2])


@pytest.mark.parametrize(
    "look, words",
    [
        ({"drw": "disc"}, "look.drw: unknown key; did you mean 'draw'"),
        ({"draw": "dics"}, "look.draw: must be one of"),
        ("red", "look must be a ga.Look or a mapping"),
    ],
)
def test_a_look_that_is_none_is_a_sentence(look, words):
    with pytest.raises(UsageError, match=words):
        ga.ParticleSystem(position=[[0, 0, 0]], look=look)
