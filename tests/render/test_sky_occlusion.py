"""The sky's light that colliders hide from surfaces near them, against form factors."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.renderer.surfaces.sky_occlusion import mean_radius
from tests.render.test_surfaces import matte, picture

EVEN = {"intensity": 0, "ambient": "white", "ambient_intensity": 0.5}


def ground_beside(collider, height=4.0, size=(80, 60), **more):
    """Radiance of white ground, from the side so that the collider does not hide it, and the places of its pixels."""
    camera = {"position": [0, 10, 10], "target": [0, 0, 0], "height": height}
    got = picture(ground=matte(), colliders=collider, light=EVEN, camera=camera, size=size, **more)
    pixel = height / size[1]
    x = (np.arange(size[0]) + 0.5 - size[0] / 2) * pixel
    z = (np.arange(size[1]) + 0.5 - size[1] / 2) * pixel * math.sqrt(2)
    return got[..., 0] / 0.5, *np.meshgrid(x, z)


def hidden_by_sphere(x, z, height, radius, samples=400):
    """The share of an even sky that a sphere hides from level ground, by a sum over the hemisphere's directions."""
    u = (np.arange(samples) + 0.5) / samples
    sine, angle = np.sqrt(u)[:, None], (2 * np.pi * u)[None, :]
    way = np.stack(
        np.broadcast_arrays(sine * np.cos(angle), np.sqrt(1 - sine**2), sine * np.sin(angle)), axis=-1
    ).reshape(-1, 3)
    center = np.array([-x, height, -z])
    along = way @ center
    return float(((along > 0) & (center @ center - along**2 < radius**2)).mean())


@pytest.mark.parametrize("height", [0.5, 0.3, 1.2])
def test_a_ball_hides_the_sky_as_its_form_factor_says(height):
    """A ball that touches the ground, one that is sunk into it, and one above it.

    The sum over 160,000 directions is right to 3e-3. Mutants: the distance in place of its square; the cosine left out; the
    horizon's part left out (at 0.3 and 0.5).
    """
    got, x, z = ground_beside({"sphere": {"center": [0, height, 0], "radius": 0.5, "look": matte()}})
    for row, column in ((35, 40), (36, 43), (35, 15), (50, 40), (40, 60), (55, 5)):
        a, b = x[row, column], z[row, column]
        assert got[row, column] == pytest.approx(1 - hidden_by_sphere(a, b, height, 0.5), abs=5e-3)


def test_two_balls_hide_one_after_the_other_and_shadows_false_hides_nothing():
    balls = [{"center": [s, 1.0, 0], "radius": 0.4, "look": matte()} for s in (-1.0, 1.0)]
    both, _, z = ground_beside({"sphere": balls})
    one, _, _ = ground_beside({"sphere": balls[0]})
    other, _, _ = ground_beside({"sphere": balls[1]})
    near = z > 0.6  # where no ball is seen
    assert np.abs(both - one * other)[near].max() < 1e-5 and both[near].min() < 0.9
    free, _, _ = ground_beside({"sphere": balls}, shadows=False)
    assert np.abs(free[near] - 1).max() < 1e-5


def test_glass_hides_little():
    ball = {"center": [0, 0.6, 0], "radius": 0.5}
    solid, _, z = ground_beside({"sphere": {**ball, "look": matte()}})
    clear, _, _ = ground_beside({"sphere": {**ball, "look": {"transmission": 1, "roughness": 0}}})
    near = z > 0.9
    assert (1 - clear[near]) == pytest.approx(0.15 * (1 - solid[near]), abs=1e-5)


def test_the_mean_radius_is_that_of_cauchys_shadow():
    c = ga.colliders
    assert mean_radius(c.Sphere(center=(0, 0, 0), radius=0.7)) == pytest.approx(0.7)
    assert mean_radius(c.Block(min=(0, 0, 0), max=(1, 2, 3))) == pytest.approx(math.sqrt(22 / 4 / math.pi))
    assert mean_radius(c.Capsule(a=(0, 0, 0), b=(0, 2, 0), radius=0.5)) == pytest.approx(
        math.sqrt((math.pi + 2 * math.pi) / 4 / math.pi)
    )
    assert mean_radius(c.Cylinder(a=(0, 0, 0), b=(0, 2, 0), radius=0.5)) == pytest.approx(
        math.sqrt((0.5 * math.pi + 2 * math.pi) / 4 / math.pi)
    )
    assert mean_radius(c.Plane()) == 0.0 and mean_radius(c.Sphere(radius=2, inside=True)) == 0.0
