"""Light that float32 does not hold is refused by a sentence, not drawn black."""

import numpy as np
import pytest

import gen_art as ga


def frame(**look):
    stars = ga.ParticleSystem(position=[[0.0, 0.0, 0.0]], radius=look.pop("particle", 0.1), look=look)
    sim = ga.Simulation({"stars": stars}, dt=0.1, precision="f64")
    return ga.render_frame(sim, size=(32, 18), camera=ga.Camera(position=(0, 0, 5)))


@pytest.mark.parametrize("radius", [1e19, 1e38])
def test_a_sprite_whose_square_is_infinite(radius):
    with pytest.raises(ga.PresetError, match="holds light that is not a finite number"):
        frame(particle=radius, draw="disc", blend="alpha", opacity=0.3)


def test_an_ordinary_picture_is_finite():
    picture = frame(draw="disc", emission={"intensity": 1e15})
    assert np.isfinite(picture).all() and picture.max() > 1e13
