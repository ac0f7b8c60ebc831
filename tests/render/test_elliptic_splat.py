"""Stretched discs: their energy at any size and direction, their form by formula, and that nothing changes without them."""

import numpy as np
import pytest

from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.sprite import AREA, KERNEL_VARIANCE
from tests.render.particles import scene, state

SIZE = (400, 240)
PIXELS = Camera(position=(0, 0, 10), height=240.0)  # one world unit is one pixel


def paint(look: dict, position, velocity, *, size=SIZE, camera=PIXELS, **more):
    painter = Painter(size, camera, {"a": Look(draw="disc", **look)}, 1.0)
    return np.array(painter.paint(scene(1.0, a=state(position, velocity, **more)), 0.0), np.float64)


def covariance(picture) -> np.ndarray:
    """(xx, xy, yy) of the light, in pixels to the right and down."""
    p = picture[..., 0] / picture[..., 0].sum()
    y, x = np.mgrid[: p.shape[0], : p.shape[1]] + 0.5
    x, y = x - (p * x).sum(), y - (p * y).sum()
    return np.array([(p * x * x).sum(), (p * x * y).sum(), (p * y * y).sum()])


@pytest.mark.parametrize("radius", [0.01, 0.3, 0.8, 2.0, 6.0, 10.6, 15, 22, 43])
@pytest.mark.parametrize("most", [1.5, 8])
def test_an_ellipse_gives_its_energy_at_any_size_and_direction(radius, most):
    """Mutants: the sum of a disc's weights in place of the ellipse's; its integral; no narrowest disc added."""
    rng = np.random.default_rng(7)
    places, velocity = rng.uniform(-40, 40, (40, 3)) * (1, 1, 0), rng.normal(0, 5 * radius, (40, 3))
    stretch = {"time": 1.0, "most": most}
    camera = Camera(position=(0, 0, 9), height=600.0)
    got = paint({"radius": radius, "stretch": stretch}, places, velocity, size=(900, 600), camera=camera)
    assert got.sum(axis=(0, 1))[:3] == pytest.approx([40 * AREA * (1.5 * radius) ** 2] * 3, rel=1e-5)


@pytest.mark.parametrize("radius", [5.0, 30.0])
@pytest.mark.parametrize("angle", [0, 30, 45, 80, 90, 135])
@pytest.mark.parametrize("ahead", [0.0, 1.0, 20.0])
def test_its_form_is_that_of_the_ellipsoid(radius, angle, ahead):
    """The covariance of the light is F^2 v (k^(-2/3) I + (k^(4/3) - k^(-2/3)) d d^T) and that of the narrowest disc, where v is
    the kernel's variance, F the footprint, d the direction on the picture, and k^2 = 1 + l^2 / (12 v F^2) for a way l. A disc
    has it with k = 1.
    Mutants: the sign of y; k in place of k^(4/3); the way without the part ahead."""
    way = 3.0 * radius
    velocity = np.array([way * np.cos(np.radians(angle)), way * np.sin(np.radians(angle)), ahead * way])
    got = covariance(paint({"radius": radius, "stretch": {"time": 1.0, "most": 16}}, [[3.3, 4.1, 0]], [velocity]))
    variance = KERNEL_VARIANCE * (1.5 * radius) ** 2
    length = np.linalg.norm(velocity)
    k = min(np.sqrt(1 + length**2 / (12 * variance)), 16)
    d = velocity / length
    longer = k ** (4 / 3) - k ** (-2 / 3)
    shape = np.array([k ** (-2 / 3) + longer * d[0] ** 2, -longer * d[0] * d[1], k ** (-2 / 3) + longer * d[1] ** 2])
    expected = variance * shape + KERNEL_VARIANCE * 1.5**2 * np.array([1, 0, 1])
    assert got == pytest.approx(expected, rel=0.004, abs=0.004 * expected.max())


def test_resting_particles_are_discs():
    place = np.random.default_rng(3).uniform(-90, 90, (30, 3)) * (1, 1, 0)
    still = np.zeros_like(place)
    for radius in (0.4, 4.0, 25.0):
        disc = paint({"radius": radius}, place, still)
        assert np.allclose(paint({"radius": radius, "stretch": 0.5}, place, still), disc, atol=2e-6 * disc.max())
        moving = paint({"radius": radius, "stretch": 0.0}, place, still + (30, 5, 0))
        assert np.allclose(moving, disc, atol=2e-6 * disc.max())


def test_what_hides_stays_within_bounds():
    """Towards the camera an ellipsoid covers less, and never more than all. Mutant: coverage that is not held at 1."""
    look = {"radius": 8.0, "stretch": {"time": 1.0, "most": 8}, "blend": "alpha", "opacity": 9, "albedo": "black",
            "emission": {"intensity": 0.5}}  # fmt: skip
    places = np.random.default_rng(1).uniform(-20, 20, (60, 3))
    picture = paint(look, places, np.zeros((60, 3)) + (3, 0, 200))
    assert picture.min() >= 0.0 and picture[..., 3].max() <= 1.0 + 1e-6
    front = Painter(SIZE, PIXELS, {
        "far": Look(draw="disc", radius=3.0),
        "near": Look(draw="disc", radius=12.0, blend="alpha", opacity=4, albedo="black", stretch=0.2),
    }, 1.0)  # fmt: skip
    systems = {"far": state([[60, 0, -5], [0, 60, -5]]), "near": state([[0, 0, 0]], [[400, 0, 0]])}
    pixels = np.array(front.paint(scene(1.0, **systems), 0.0))[..., 0]
    assert pixels[120, 240] == 0 or pixels[115:125, 255:265].max() < pixels[55:65, 195:205].max()


@pytest.mark.parametrize("camera", [Camera(position=(0, 0, 60), fov=60), PIXELS])
@pytest.mark.parametrize("size", [(1, 1), (7, 5), SIZE])
def test_any_motion_gives_finite_light(camera, size):
    """Behind the camera, without particles, with velocities that are no numbers, on the frame's border."""
    places = [[0, 0, 0], [0, 0, 70], [3, 3, 59.9], [1e9, 0, 0], [200, 0, 0], [5, 5, 0], [6, 5, 0]]
    velocities = [[9, 0, 0], [9, 9, 9], [0, 0, 50], [1, 0, 0], [300, 0, 0], [1e30, 0, 0], [np.nan, 0, 0]]
    look = {"radius": 2.0, "stretch": 1.0}
    assert np.isfinite(paint(look, places, velocities, size=size, camera=camera)).all()
    assert not paint(look, np.zeros((0, 3)), None, size=size, camera=camera).any()


def test_an_ellipse_reaches_into_the_picture():
    """A long one whose middle lies outside: as in a larger picture, but for the border, where coarse pixels have no neighbours.

    Mutant: the margin of a disc.
    """
    look, velocity = {"radius": 20.0, "stretch": {"time": 1.0, "most": 16}}, [[2000, 0, 0]]
    inside = paint(look, [[270, 0, 0]], velocity)
    larger = paint(look, [[270, 0, 0]], velocity, size=(800, 240))[:, 200:600]
    inner = (slice(None), slice(0, -8))
    assert inside[inner][..., 0].max() > 0 and np.allclose(inside[inner], larger[inner], atol=1e-6 * larger.max())


def test_only_discs_stretch():
    for draw in ("point", "streak", "sphere"):
        with pytest.raises(ValueError, match="stretch needs draw: disc"):
            Look(draw=draw, stretch=0.1)
