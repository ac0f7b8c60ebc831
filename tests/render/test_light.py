"""The lamp in the smoke: Beer and Lambert's law through a slab, ambient light, and the same light in the same order."""

import numpy as np
import pytest

from gen_art.preset.look import KeyLight, Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.frame import Painter
from gen_art.renderer.light import incoming_light, optical_depth
from tests.render.particles import scene, state


def slab(n=60_000):
    """A uniform cube of side 2 whose total depth along any axis is 3."""
    rng = np.random.default_rng(1)
    return rng.uniform(-1, 1, (n, 3)).astype(np.float32), np.full(n, 3.0 * 4.0 / n, np.float32)


@pytest.mark.parametrize("direction", [(0, 0, 1), (0, -1, 0), (1, 0, 0)])
def test_depth_grows_evenly_through_a_uniform_slab(direction):
    x, section = slab()
    before, behind = optical_depth(x, section, direction, 32)
    along = x @ np.array(direction, np.float32)
    inside = (np.abs(x) < 0.7).all(axis=1)
    assert np.abs(before - 1.5 * (along + 1))[inside].mean() < 0.12
    assert np.abs(before + behind - 3.0)[inside].mean() < 0.15


def test_the_lamp_s_light_falls_off_exponentially_without_scatter():
    x, section = slab()
    lamp = KeyLight(direction=(0, 0, 1), intensity=2.0, ambient_intensity=0.0, scatter=0.0, resolution=32)
    got = incoming_light(lamp, x, section, (0, 0, 9))
    deep = np.abs(x[:, 2] - 0.33) < 0.05
    assert np.median(got[deep]) == pytest.approx(2.0 * np.exp(-2.0), rel=0.15)
    assert got.max() <= 2.0


def test_forward_scattering_favours_a_camera_that_looks_into_the_lamp():
    x, section = slab(500)
    lamp = KeyLight(direction=(0, 0, 1), phase=0.5, resolution=16)
    towards, away = (incoming_light(lamp, x, section, (0, 0, z)).mean() for z in (30, -30))
    assert towards > 4 * away


def test_no_smoke_no_shadow():
    lamp = KeyLight(intensity=1.0, ambient_intensity=0.0)
    assert incoming_light(lamp, np.zeros((3, 3), np.float32), np.zeros(3, np.float32), (0, 0, 9)) == pytest.approx(
        np.ones((3, 3))
    )


def test_a_lit_ball_has_a_bright_side_two_stops_above_its_shadow():
    rng = np.random.default_rng(3)
    x = rng.normal(0, 1, (20000, 3))
    x *= rng.uniform(0, 1, (20000, 1)) ** (1 / 3) / np.linalg.norm(x, axis=1, keepdims=True)
    look = Look(draw="disc", blend="alpha", radius=0.07, opacity=0.2, light={"direction": [1, 0, 0], "intensity": 2.0})
    picture = Painter((200, 200), Camera(position=(0, 0, 10), height=2.6), {"a": look}).paint(
        scene(0.0, a=state(x)), 0.0
    )
    grey = picture[..., 1] / np.maximum(picture[..., 3], 1e-3)
    assert grey[80:120, 40:55].mean() > 4 * grey[80:120, 145:160].mean()
    assert picture[100, 100, 3] > 0.98
