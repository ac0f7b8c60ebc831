"""Surfaces that rest are lit once, and a film that shows them has the bytes of pictures drawn anew."""

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.renderer.surfaces import surface_pass
from tests.render.test_surfaces import matte, preset
from tests.render.test_tiles import bodies

SIZE = (96, 64)
CAMERA = {"position": [0.6, 1.1, 3], "target": [0, 0.4, 0], "fov": 40}
SMOKE = {
    "puff": {
        "particle": {"radius": 0.05},
        "forces": {"gravity": [0.9, 0.4, 0]},
        "emitters": {"burst": {"count": 400, "shape": {"gaussian": [0.2, 0.2, 0.2], "center": [0.2, 0.8, 0]}}},
        "look": {"draw": "disc", "radius": 0.1, "blend": "alpha", "opacity": 0.2},
    },
}
MIRROR = {"ground": {"mirror": True, "roughness": 0.15}, "sky": {"sun": 40}}
SCENES = {
    "smoke before boxes": {"ground": matte("#b08060"), "systems": SMOKE | bodies(3), "sky": {"sun": 40}},
    "smoke in a mirror": MIRROR | {"systems": SMOKE},
    "a collider that moves": {
        "ground": matte(), "sky": {"sun": 40},
        "colliders": {"sphere": {"center": [0, 0.4, 0], "radius": 0.3, "velocity": [2, 0, 0], "look": matte("red")}},
    },
    "a camera that moves": {
        "ground": matte("#b08060"), "systems": bodies(3), "sky": {"sun": 40},
        "camera": CAMERA | {"orbit": {"rate": 40}},
    },
    "waves": {"ground": matte() | {"waves": 0.08}, "sky": {"sun": 40}},
}  # fmt: skip


WATER = {
    "water": {
        "particle": {"radius": 0.03},
        "forces": {"gravity": [0, -9.81, 0]},
        "emitters": {"burst": {"count": 1500, "shape": {"box": [[-0.2, 0.6, -0.2], [0.2, 0.9, 0.2]]}}},
        "look": {"draw": "surface", "radius": 0.04},
    },
}
SCENES["a liquid without shadows"] = {"ground": matte(), "systems": WATER, "sky": {"sun": 40}, "shadows": False}
FALLING = {"boxes": bodies(3)["boxes"] | {"forces": {"gravity": [0, -9.81, 0]}}}
FALLING["boxes"]["emitters"] = {"boxes": {"body": bodies(3)["boxes"]["emitters"]["boxes"]["body"] | {"static": False}}}
LAMP = {"direction": [-1, -2, -1], "ambient_intensity": 0}  # without a sky, whose light would change with the bodies
SCENES["bodies that fall"] = {"ground": matte(), "systems": FALLING, "light": LAMP, "shadows": False}
RESTING = ("smoke before boxes", "smoke in a mirror")
STEPS = (0, 8, 16)


@pytest.mark.parametrize("scene", SCENES)
def test_a_film_shows_what_pictures_drawn_anew_show(scene, monkeypatch):
    """The same bytes, and what rests is traced once. Mutants: LightParts.rest always true; N at time 0 although colliders move; the
    waves not compared; one SurfacePass for the mirror and the picture; depths not found anew after a liquid was drawn into them."""
    given, calls = preset(**({"camera": CAMERA} | SCENES[scene])), []
    original = surface_pass.draw_kernel

    def counted(*options):
        calls.append(options)
        return original(*options)

    monkeypatch.setattr(surface_pass, "draw_kernel", counted)
    film = Playback(given, SIZE, "f32", None)
    pictures = [np.array(film.picture(step)) for step in STEPS]
    assert len(calls) == (1 if scene in RESTING else len(STEPS))
    for step, picture in zip(STEPS, pictures):
        np.testing.assert_array_equal(picture, Playback(given, SIZE, "f32", None).picture(step))
    if scene in RESTING:
        assert (pictures[0] != pictures[-1]).any()  # the smoke moved
