"""What a mirror shows of ribbons and of its own shadow.

Mutants that were tried, each of which fails a test here: ribbons that the mirror's plane does not cut; the part behind the plane
left in place of that before it; a mirror that is left out of its own picture; a mirror that shows every system; one that shows only those left out.
"""

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset

SIZE = (160, 120)
MIRROR = {"albedo": "white", "metal": 1, "roughness": 0, "mirror": True}


def picture(step, **keys):
    basis = {
        "version": 1, "clock": {"duration": 2, "fps": 10, "step": "1/40"},
        "light": {"intensity": 0, "ambient_intensity": 0},
        "camera": {"position": [0, 1.2, 5], "target": [0, 0, 0], "fov": 40},
    }  # fmt: skip
    return Playback(load_preset({**basis, **keys}), SIZE, "f32", None).picture(step)[..., :3].copy()


def ribbon(height, velocity, points=20):
    return {
        "emitters": {"one": {"count": 1, "shape": {"point": [0, height, 0]}, "velocity": {"constant": list(velocity)}}},
        "look": {"draw": "streak", "radius": 0.03, "emission": {"color": "white", "intensity": 20},
                 "ribbon": {"length": 1, "points": points}},
    }  # fmt: skip


def test_a_mirror_does_not_show_ribbons_below_it():
    got = picture(40, systems={"path": ribbon(-0.3, (0.5, 0, 0))}, ground=MIRROR)
    plain = picture(40, systems={"path": ribbon(-0.3, (0.5, 0, 0))}, ground={**MIRROR, "mirror": False})
    assert np.array_equal(got, plain)


def test_a_mirror_shows_ribbons_above_it_where_optics_puts_them():
    got = picture(40, systems={"path": ribbon(0.4, (0.5, 0, 0))}, ground=MIRROR)
    image = picture(40, systems={"path": ribbon(-0.4, (0.5, 0, 0))})
    real = picture(40, systems={"path": ribbon(0.4, (0.5, 0, 0))})
    assert image.sum() > 1 and np.abs(got - (image + real)).max() < 0.02 * got.max()


def test_a_mirror_leaves_out_what_is_not_mirrored():
    left, right = ribbon(0.4, (0.5, 0, 0)), ribbon(0.4, (-0.5, 0, 0))
    hidden = {**left, "look": left["look"] | {"mirrored": False}}
    got = picture(40, systems={"left": hidden, "right": right}, ground=MIRROR)
    alone = picture(40, systems={"right": right}, ground=MIRROR)
    unseen = picture(40, systems={"left": left}, ground={**MIRROR, "mirror": False})
    assert unseen.sum() > 1 and np.abs(got - (alone + unseen)).max() < 1e-4 * got.max()


@pytest.mark.parametrize("speed", [0.8, -0.8])
def test_of_a_ribbon_through_the_mirror_it_shows_the_part_above(speed):
    """A path that crosses the ground where the camera looks: below that place the picture shows the image of the upper part,
    above it the upper part alone. A segment that is cut fades over the length that is left: to a twentieth of the light."""
    start = -0.43 if speed > 0 else 0.37
    got, plain = (
        picture(40, systems={"path": ribbon(start, (0, speed, 0), 4)}, ground={**MIRROR, "mirror": m})
        for m in (True, False)
    )
    image = picture(40, systems={"path": ribbon(-start, (0, -speed, 0), 4)})
    most = image.sum(axis=(1, 2)).max()
    below, above = slice(62, None), slice(0, 58)
    assert image[below].sum() > 1 and image[above].sum() > 1
    assert np.abs(got[below] - image[below]).sum(axis=(1, 2)).max() < 0.1 * most
    assert np.array_equal(got[above], plain[above])


@pytest.mark.parametrize("shadows", [True, False])
def test_a_mirror_shadows_what_it_shows(shadows):
    """A lamp behind a wall: the wall hides it from all before it, and the wall's mirror shows them as dark as they are."""
    ball = {
        "particle": {"radius": 0.5}, "emitters": {"one": {"count": 1, "shape": {"point": [0, 0, 0]}}},
        "look": {"draw": "sphere", "blend": "opaque", "albedo": "white"},
    }  # fmt: skip
    wall = {"plane": {"point": [0, 0, -1], "normal": [0, 0, 1], "look": MIRROR}}
    lamp = {"direction": [0, -0.2, 1], "intensity": 1, "ambient_intensity": 0}
    camera = {"position": [1.5, 0.5, 5], "target": [0, 0, 0], "fov": 40}
    got = picture(0, systems={"ball": ball}, colliders=wall, light=lamp, camera=camera, shadows=shadows)
    assert got.any() == (not shadows)


@pytest.mark.parametrize("height", [-0.1, 0.1])
def test_a_mirror_shows_of_a_ball_what_rays_show_that_are_followed(height):
    """Of a ball that shines, whose middle lies below or above the ground. The mutant: what lies below has no colour there."""
    ball = {
        "particle": {"radius": 0.5}, "emitters": {"one": {"count": 1, "shape": {"point": [0, height, 0]}}},
        "look": {"draw": "sphere", "blend": "opaque", "albedo": "black", "emission": "white", "finish": {"ior": 1}},
    }  # fmt: skip
    got, followed = (picture(0, systems={"ball": ball}, ground={**MIRROR, "mirror": m}) for m in (True, False))
    assert followed.sum() > 1000
    # they differ at the edges, where a film lies between its pixels
    assert np.abs(got - followed).sum() < 0.05 * followed.sum()
