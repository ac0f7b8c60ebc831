"""Transparent and smooth surfaces: what is seen through them and in them, and the lamp's light behind them, against optics."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.renderer.surfaces import caustics
from gen_art.renderer.surfaces.photon_cells import Photons
from gen_art.renderer.surfaces.reflection import fresnel
from tests.render.test_surfaces import DARK, matte, one_ball, picture

EVEN = {"intensity": 0, "ambient": "white", "ambient_intensity": 0.8}
ABOVE = {"position": [0, 8, 0], "target": [0, 0, 0], "up": [0, 0, -1]}


def glass(ior=1.5, **more):
    return {"albedo": "white", "roughness": 0, "ior": ior, "transmission": 1, **more}


def as_collider(finish):
    return {"colliders": {"sphere": {"center": [0, 0, 0], "radius": 0.6, "look": finish}}}


def as_particle(finish):
    keys = {k: v for k, v in finish.items() if k != "albedo"}
    return {"systems": one_ball([0, 0, 0], 0.6, finish=keys, albedo="white")}


@pytest.mark.parametrize("given", [as_collider, as_particle])
@pytest.mark.parametrize("ior", [1.1, 1.5, 2.4])
def test_white_furnace(given, ior):
    """In an even light clear glass cannot be seen: what it reflects and what passes add up.

    Mutants: a share of 1 instead of 1 - back for what leaves; Fresnel's reflectance left out of one side.
    """
    got = picture(**given(glass(ior)), ground=matte(height=-0.7), light=EVEN, size=(128, 96), shadows=False)
    assert np.abs(got[..., :3] / 0.8 - 1).max() < 0.02


@pytest.mark.parametrize("given", [as_collider, as_particle])
def test_glass_of_index_1_is_air(given):
    """Through a body that refracts nothing the ground is seen where it is, in the lamp's full light.

    Photons bring that light: the mean over the shadow's place is theirs to a percent, of some 5,000 photons.
    Mutants: the direction of refraction, d * ratio with 1 / ratio (no change at index 1: the block's test), the photon's area.
    """
    light = {"direction": [0.2, -1, 0.1], "intensity": 0.25, "size": 3, **DARK}
    ground = matte(checker={"size": 0.5, "color": "black"}, height=-0.7)
    common = {"ground": ground, "light": light, "camera": {**ABOVE, "height": 2.4}, "size": (96, 96)}
    with_glass, without = picture(**given(glass(1.0)), **common), picture(**common)
    assert with_glass.mean() == pytest.approx(without.mean(), rel=0.01)
    # white squares only, away from their edges, where a photon's disc reaches black ones or the shadow's rim
    white = without[..., 0] > 0.9 * without[..., 0].max()
    assert np.median(np.abs(with_glass - without)[white][:, 0]) < 0.05 * without.max()


@pytest.mark.parametrize("ior", [1.2, 1.5])
def test_a_block_moves_what_is_behind_it(ior):
    """An edge seen through a slab of thickness h at the angle a is moved by h sin a (1 - cos a / sqrt(n^2 - sin^2 a)).

    The picture is orthographic, so that all rays have that angle. Mutant: the ratio of indices turned over.
    """
    a, h, height = math.radians(50), 0.5, 2.0
    camera = {"position": [1, 10 * math.cos(a), 10 * math.sin(a)], "target": [1, 0, 0], "height": height}
    ground = matte(checker={"size": 50, "color": "black"})  # its edge at z = 0 is all that is seen of it
    rows = {}
    for name, index in (("through", ior), ("bare", 1.0)):
        slab = {"block": {"look": glass(index), "min": [-1, 0.2, -4], "max": [3, 0.2 + h, 4]}}
        got = picture(colliders=slab, ground=ground, camera=camera, light=EVEN, size=(60, 400), shadows=False)
        column = got[:, 30, 0]
        middle = 0.5 * (column[150] + column[350])
        rows[name] = int(np.argmin(np.abs(column[150:350] - middle))) + 150
    moved = (rows["bare"] - rows["through"]) * height / 400
    expected = h * math.sin(a) * (1 - math.cos(a) / math.sqrt(ior**2 - math.sin(a) ** 2))
    assert moved == pytest.approx(expected, abs=2 * height / 400)


def test_coloured_glass_keeps_its_albedo_in_each_attenuation_distance():
    """A block of thickness 0.6 and attenuation distance 0.2 lets albedo^3 pass. Mutant: a rate of 1 instead of ln(albedo)."""
    camera = {**ABOVE, "height": 1.0}
    look = glass(1.0, albedo="#808080", attenuation_distance=0.2)
    ground = {**matte("black"), "emission": "white"}
    got = picture(
        colliders={"block": {"min": [-1, 0.1, -1], "max": [1, 0.7, 1], "look": look}}, ground=ground, camera=camera,
        light={"intensity": 0, **DARK}, size=(99, 99),
    )  # fmt: skip
    albedo = ((128 / 255 + 0.055) / 1.055) ** 2.4
    assert got[49, 49, :3] == pytest.approx(
        albedo**3, rel=0.01
    )  # the ray starts and ends up to a twentieth of a pixel inside


def test_photons_carry_what_a_ball_lets_through(monkeypatch):
    """A ball of glass gathers pi r^2 of the lamp's light; each ray passes its surface twice, at the same angle.

    The sum is exact but for the photons' places, some 2,000 over the disc of the angle. Mutants: one factor of 1 - F; half a disc.
    """
    found = []
    of = Photons.of
    monkeypatch.setattr(Photons, "of", classmethod(lambda cls, rows: found.append(np.array(rows)) or of(rows)))
    light = {"direction": [0, -1, 0], "intensity": 0.7, "size": 0.01, **DARK}
    ball = {"sphere": {"center": [0, 2.0, 0], "radius": 0.6, "look": glass(1.3)}}
    picture(colliders=ball, ground=matte(), light=light, camera={**ABOVE, "position": [0, 8, 6]})
    rows = found[0]
    arrived = rows[rows[:, 6] > 0.0]
    s = (np.arange(4000) + 0.5) / 4000  # sin^2 of the angle of incidence, even over the disc
    passes = (1.0 - fresnel(np.sqrt(1.0 - s), 1.3)) ** 2
    # rays near the rim leave upwards or miss the ground nowhere: all that turn by less than 90 degrees come down
    turn = 2.0 * (np.arcsin(np.sqrt(s)) - np.arcsin(np.sqrt(s) / 1.3))
    expected = 4 * 0.7 * math.pi * 0.36 * passes[turn < math.pi / 2].sum() / 4000
    assert arrived[:, 3].sum() == pytest.approx(expected, rel=2e-3)
    # a ball of index n has its focus at f = n r / (2 (n - 1)) from its middle: rays near the axis arrive at 1 - 2.0 / f times
    # their distance from it; at a tenth of the radius the error of that is a hundredth
    apart = np.hypot(rows[:, 0], rows[:, 2] + 6.0)
    starts = 0.6 * np.linalg.norm(caustics._starts(len(rows))[:, :2], axis=1)
    paraxial = (starts > 0.03) & (starts < 0.06)
    assert np.median(apart[paraxial] / starts[paraxial]) == pytest.approx(abs(1 - 2.0 / (1.3 * 0.6 / 0.6)), rel=0.02)


def test_a_smooth_floor_reflects_solids_as_a_mirror_film_does():
    """Rays and the picture of a mirrored camera are two ways to one image. Mutant: h.d in place of 2 h.d in the mirrored ray."""
    common = {
        "systems": one_ball([0, 0.6, 0], 0.3, albedo="red", finish={"ior": 1}), "size": (160, 120),
        "light": {"direction": [-0.5, -1, -0.5], "intensity": 0.5, "ambient_intensity": 0.2},
        "camera": {"position": [0, 1.0, 4], "target": [0, 0.2, 0], "fov": 30},
    }  # fmt: skip
    floor = {"albedo": "white", "metal": 1, "roughness": 0}
    film, rays = picture(ground={**floor, "mirror": True}, **common), picture(ground=floor, **common)
    differs = np.abs(film - rays).max(axis=2) > 0.05 * film.max()
    image = film[60:, :, 0] - film[60:, :, 1] > 0.1
    assert image.sum() > 300  # there is a red image on the floor
    assert differs.mean() < 0.01  # at edges, which a film blends with its neighbours


def test_metal_shows_its_neighbours():
    near = one_ball([0.75, 0, 0], 0.2, albedo="black", emission={"color": "red", "intensity": 3.0}, finish={"ior": 1})
    metal = {"sphere": {"center": [0, 0, 0], "radius": 0.5, "look": {"albedo": "white", "metal": 1, "roughness": 0}}}
    camera = {"position": [0, 0, 5], "target": [0, 0, 0], "fov": 20}
    got = picture(systems=near, colliders=metal, ground=matte(height=-9), light=EVEN, camera=camera, size=(120, 90))
    left, right = got[45, 30:60], got[45, 60:85]
    assert (right[:, 0] - right[:, 1]).max() > 1.0 and np.abs(left[:, 0] - left[:, 1]).max() < 0.05


def test_an_orthographic_camera_and_a_tiny_picture_see_glass():
    for camera in ({**ABOVE, "height": 2}, {**ABOVE, "fov": 20}):
        got = picture(**as_collider(glass()), ground="white", light={}, camera=camera, size=(1, 1))
        assert np.isfinite(got).all() and got[0, 0, 0] > 0


@pytest.mark.parametrize(
    "collider", [{"plane": {"look": glass()}}, {"box": {"min": [-9, -9, -9], "max": [9, 9, 9], "look": glass()}}]
)
def test_what_has_no_other_side_cannot_be_glass(collider):
    with pytest.raises(ga.UsageError, match="goes through a solid only"):
        picture(colliders=collider)


def test_bounding_balls_hold_their_colliders():
    c = ga.colliders
    for collider, center, radius in (
        (c.Sphere(center=(1, 2, 3), radius=0.5, velocity=(1, 0, 0)), (3, 2, 3), 0.5),
        (c.Capsule(a=(0, 0, 0), b=(0, 2, 0), radius=0.5), (0, 1, 0), 1.5),
        (c.Block(min=(0, 0, 0), max=(2, 2, 2)), (1, 1, 1), math.sqrt(3)),
        (c.Cylinder(a=(0, 0, 0), b=(0, 0.8, 0), radius=0.3), (0, 0.4, 0), 0.5),
    ):
        found = caustics.bounding_ball(collider, 2.0)
        assert found is not None and found[0] == pytest.approx(center) and found[1] == pytest.approx(radius)


def test_a_mirror_in_fog_is_fog_at_the_horizon():
    """No light of the film passes there; the picture is the fog's. Mutant: the film's light divided by the air's share, 0."""
    camera = {"position": [0, 1, 5], "target": [0, 1, 0], "fov": 40, "fog": {"distance": 5, "color": "#406080"}}
    got = picture(ground={"mirror": True, "roughness": 0.3}, light={}, camera=camera)
    assert np.isfinite(got).all()
    assert got[25, 32, :3] == pytest.approx([((c / 255 + 0.055) / 1.055) ** 2.4 for c in (0x40, 0x60, 0x80)], rel=0.05)
