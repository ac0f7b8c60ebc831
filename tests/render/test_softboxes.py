"""Softboxes of a sky: where they are, how much light they are, what mirrors them, and what is wrong."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.preset.load import load_preset
from gen_art.preset.sky import Sky, Softbox
from gen_art.renderer.colour import linear
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.sky_softboxes import coverage

BASE = {
    "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/120"},
    "systems": {"ball": {"particle": {"radius": 1}, "emitters": {"one": {"count": 1, "shape": {"point": [0, 0, 0]}}},
                         "look": {"draw": "sphere", "radius": 1, "blend": "opaque", "albedo": "white",
                                  "finish": {"metal": 1, "roughness": 0}}}},
    "camera": {"position": [0, 0, 20], "target": [0, 0, 0], "fov": 8},
}  # fmt: skip


def direction(height, azimuth):
    """Of a height and an azimuth in degrees: clockwise seen from above, from -z over +x."""
    h, a = math.radians(height), math.radians(azimuth)
    return np.array([math.cos(h) * math.sin(a), math.sin(h), -math.cos(h) * math.cos(a)])


def light(places, **box):
    dome = SkyDome.of(Sky(color="black", softboxes=(Softbox(**box),)))
    return dome.radiance(np.array([direction(*place) for place in places]))[:, 0]


@pytest.mark.parametrize("height, azimuth", [(0, 0), (20, 90), (50, 215), (-30, -60), (90, 0)])
def test_its_middle_has_its_light_and_its_sides_half_of_it(height, azimuth):
    """The sides lie at half the angles that it is wide and tall, up and down by the height alone. Mutants: an azimuth the other way
    round, a height upside down, width and tall exchanged, whole instead of half angles."""
    middle = light([(height, azimuth)], height=height, azimuth=azimuth, width=20, tall=40, edge=10, intensity=3)
    assert middle == pytest.approx([3.0], rel=1e-6)
    ends = [height - 20] if height == 90 else [height - 20, height + 20]
    box = Softbox(height=height, azimuth=azimuth, width=20, tall=40, edge=10, intensity=3)
    assert coverage(box, np.array([direction(h, azimuth) for h in ends])) == pytest.approx(0.5, abs=1e-12)
    m, across = (
        direction(height, azimuth),
        np.array([math.cos(math.radians(azimuth)), 0, math.sin(math.radians(azimuth))]),
    )
    aside = m * math.cos(math.radians(10)) + across * math.sin(math.radians(10))
    assert coverage(box, aside[None]) == pytest.approx(0.5, abs=1e-12)
    assert coverage(box, np.array([-m, direction(height, azimuth + 180) if height < 60 else -m])).max() == 0.0


@pytest.mark.parametrize("edge", [0, 8])
@pytest.mark.parametrize("place", [(30, 40), (-10, 200)])
def test_its_light_is_that_of_its_solid_angle(place, edge):
    """A pyramid of the angles a and b has the solid angle 4 asin(sin(a / 2) sin(b / 2)); the mean light is that part of 4 pi. A fade
    of slope e about a side is even in slope, not in angle: 2% at 8 degrees. The table's cells are 1 degree, which smooths edges and
    keeps their light to 1%. Mutants: a factor of 1.1 on either angle."""
    box = Softbox(height=place[0], azimuth=place[1], width=30, tall=50, edge=edge, intensity=7)
    lighting = Lighting.of(None, SkyDome.of(Sky(color="black", softboxes=(box,))))
    angle = 4 * math.asin(math.sin(math.radians(15)) * math.sin(math.radians(25)))
    assert lighting.ambient[:, 0] == pytest.approx(7 * angle / (4 * math.pi), rel=0.03)
    slope = lighting.ambient[0, 1:]
    assert slope / np.linalg.norm(slope) == pytest.approx(direction(*place), abs=0.02)  # from where it comes


def test_it_hides_the_sky_behind_it_and_an_earlier_box():
    red, blue = (Softbox(height=30, color=c, width=w, tall=w, intensity=1) for c, w in (("red", 40), ("blue", 10)))
    dome = SkyDome.of(Sky(color="white", softboxes=(red, blue), intensity=2))
    places = np.array([direction(30, 0), direction(30, 12), direction(30, 60)])
    assert dome.radiance(places) == pytest.approx(2 * np.array([linear(c) for c in ("blue", "red", "white")]), abs=1e-6)


def test_by_day_it_is_in_the_sky_too():
    with_box, without = (
        SkyDome.of(Sky(sun=20, softboxes=boxes)) for boxes in ((Softbox(height=60, azimuth=180, intensity=4),), ())
    )
    places = np.array([direction(60, 180), direction(60, 0)])
    got, bare = with_box.radiance(places), without.radiance(places)
    assert got[0] == pytest.approx([4, 4, 4], rel=1e-6) and np.array_equal(got[1], bare[1])


def test_a_metal_ball_mirrors_it_where_the_law_of_reflection_says():
    """The normal halfway between the camera and the middle of the box. On a white metal a mirror keeps all of the light; the box is
    10 degrees wide, a pixel of the ball near there less than one. Mutant: azimuth the other way round."""
    box = {"height": 40, "azimuth": 120, "width": 10, "tall": 10, "edge": 0, "intensity": 5}
    sim = ga.Simulation(load_preset({**BASE, "sky": {"color": "black", "softboxes": [box]}}))
    size = 240
    picture = ga.render_frame(sim, (size, size))[..., 0]
    normal = direction(40, 120) + np.array([0, 0, 1])
    normal /= np.linalg.norm(normal)
    scale = size / (2 * math.tan(math.radians(4)))
    depth = 20 - normal[2]
    column, row = size / 2 + scale * normal[0] / depth, size / 2 - scale * normal[1] / depth
    assert picture[int(row), int(column)] == pytest.approx(5.0, rel=1e-3)
    rows, columns = np.nonzero(picture > 2.5)
    assert (rows.mean(), columns.mean()) == pytest.approx((row, column), abs=2.0)
    assert picture[int(row), size - 1 - int(column)] == 0.0


def test_a_sky_without_them_has_the_table_that_it_had():
    assert SkyDome.of(Sky(color="red")).table.shape[1] == 2


@pytest.mark.parametrize(
    "keys, word",
    [
        ({"softboxes": [{"azimuth": 3}]}, "height"),
        ({"softboxes": [{"height": 100}]}, "height"),
        ({"softboxes": [{"height": 10, "width": 0}]}, "width"),
        ({"softboxes": [{"height": 10, "tall": 170}]}, "tall"),
        ({"softboxes": [{"height": 10, "hight": 3}]}, "hight"),
        ({"softboxes": []}, "softboxes"),
        ({"softboxes": 3}, "softboxes"),
    ],
)
def test_what_is_wrong_is_one_sentence(keys, word):
    with pytest.raises(PresetError, match=word):
        load_preset({**BASE, "sky": keys})
