"""Discs with the shape of their neighbourhood: beside a direct sum, in lines, planes and even clouds, and the light that stays."""

import numpy as np
import pytest

from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.neighbour_shapes import neighbour_shapes
from gen_art.renderer.neighbour_sums import NeighbourSums
from gen_art.renderer.painter import Painter
from gen_art.renderer.sprite import AREA, KERNEL_VARIANCE
from tests.render.particles import scene, state

SIZE = (400, 240)
PIXELS = Camera(position=(0, 0, 500), height=240.0)  # one world unit is one pixel
BALL = [1, 1, 1, 0, 0, 0]


def matrices(positions, reach, most=4.0, **more) -> np.ndarray:
    s = np.asarray(neighbour_shapes(NeighbourSums.of(state(positions, **more), 1.0, reach), most), np.float64)
    return s[:, [[0, 3, 4], [3, 1, 5], [4, 5, 2]]]


def direct(positions, reach, most) -> np.ndarray:
    """The formulas of neighbour_shapes.py over all pairs, with NumPy's eigenvalues."""
    found = []
    for p in positions:
        d = (positions - p) / reach
        w = np.maximum(1 - (d * d).sum(axis=1), 0) ** 3
        e = d - (w @ d) / w.sum()
        covariance = (w[:, None] * e).T @ e
        even = np.trace(covariance) / 3
        count = w.sum() ** 2 / (w @ w)
        chance = 2 / 3 * (w * w) @ ((e * e).sum(axis=1) ** 2) * count / (count - 1) if count > 1 + 1e-9 else np.inf
        rest = covariance - even * np.eye(3)
        part = max(1 - chance / (rest**2).sum(), 0) if np.isfinite(chance) else 0
        squares, axes = np.linalg.eigh(np.eye(3) + part * rest / even if part > 0 else np.eye(3))
        squares = np.maximum(squares, squares.max() / most**2)
        found.append(axes @ np.diag(squares / np.prod(squares) ** (1 / 3)) @ axes.T)
    return np.array(found)


def turned(angle: float, ahead: float) -> np.ndarray:
    """A direction at an angle to the right on the picture, inclined to it."""
    a, b = np.radians([angle, ahead])
    return np.array([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)])


def first_disc(positions, look: dict) -> np.ndarray:
    """(xx, xy, yy) in pixels to the right and down of the light of the first particle, which alone shines."""
    light = {"intensity": {"by": "id", "range": "0..1", "curve": [[0, 1], [1, 0]]}}
    painter = Painter(SIZE, PIXELS, {"a": Look(draw="disc", emission=light, **look)}, 1.0)
    p = np.array(painter.paint(scene(1.0, a=state(positions)), 0.0), np.float64)[..., 0]
    y, x = np.mgrid[: p.shape[0], : p.shape[1]] + 0.5
    p /= p.sum()
    x, y = x - (p * x).sum(), y - (p * y).sum()
    return np.array([(p * x * x).sum(), (p * x * y).sum(), (p * y * y).sum()])


def on_picture(shape: np.ndarray, radius: float) -> np.ndarray:
    variance = KERNEL_VARIANCE * (1.5 * radius) ** 2
    return variance * np.array([shape[0, 0], -shape[0, 1], shape[1, 1]]) + KERNEL_VARIANCE * 1.5**2 * np.array(
        [1, 0, 1]
    )


@pytest.mark.parametrize("reach, most", [(0.15, 4.0), (0.3, 1.5), (0.25, 16.0)])
def test_the_shape_is_that_of_a_direct_sum(reach, most):
    """Up to 16 particles a cell all count. The sums are those of float32: 1e-6 of the matrix, of which the least eigenvalue is the
    16th part squared at most.

    Mutants: the places not from their mean; weights squared; 1 - d^3 in place of (1 - d^2)^3; no chance; chance without its 2/3
    or its N / (N - 1); the greatest length bounded in place of the least; no volume.
    """
    rng = np.random.default_rng(4)
    curve = rng.uniform(0, 6, 150)
    thread = np.stack([np.cos(curve), np.sin(curve), 0.3 * curve], axis=1) + rng.normal(0, 0.01, (150, 3))
    positions = np.concatenate([thread, rng.uniform(-1, 1, (150, 3))])
    cells = np.floor((positions - positions.min(axis=0)) / reach)
    assert np.unique(cells, axis=0, return_counts=True)[1].max() <= 16
    found = matrices(positions, reach, most)
    assert found == pytest.approx(direct(positions, reach, most), rel=1e-3, abs=1e-3)
    assert (np.linalg.eigvalsh(found)[:, 2] > 1.5).sum() > 60  # not all are balls


@pytest.mark.parametrize("angle", [0, 30, 90, 135])
@pytest.mark.parametrize("ahead", [0, 50])
def test_a_line_gives_ellipses_along_it(angle, ahead):
    """A straight line of equal distances has no width, and the least lengths are bounded: m^(2/3), m^(-1/3), m^(-1/3) with
    m = 4 times a disc's. The kernel's variance on pixels errs by 0.4%, as that of all stretched discs.

    Mutants: the sign of y; k in place of k^2; the columns of the eigenvectors as rows; no volume.
    """
    d, radius = turned(angle, ahead), 6.0
    steps = np.arange(-30, 31) * 2.0
    places = np.concatenate([[0.0], steps[steps != 0]])[:, None] * d + (3.3, 4.1, 0)
    got = first_disc(places, {"radius": radius, "stretch": {"by": "neighbours", "reach": 30, "most": 4}})
    shape = 4 ** (4 / 3) * np.outer(d, d) + 4 ** (-2 / 3) * (np.eye(3) - np.outer(d, d))
    expected = on_picture(shape, radius)
    assert got == pytest.approx(expected, rel=0.004, abs=0.004 * expected.max())


def test_the_direction_of_a_rough_line():
    """Particles at random along a line, n a reach, and sigma beside it: the principal axis is off by sigma (sum w^2 x^2)^(1/2) /
    (sum w x^2) in both directions across. With w = (1 - x^2)^3 the integrals from -1 to 1 are 0.0455 and 0.1016: sigma / sqrt(0.227 n).
    The sums of few particles vary: a quarter is allowed, and the square root of 2 ln 200, 3.3, is passed once in 200.

    Mutants: weights squared (half as much again); places not from their mean; the axes of Jacobi's method turned the other way.
    """
    rng, sigma, n = np.random.default_rng(3), 0.03, 12
    d = turned(25, 40)
    along, across = rng.uniform(0, 200, 200 * n), rng.normal(0, sigma, (200 * n, 3))
    places = along[:, None] * d + across - (across @ d)[:, None] * d
    axis = np.linalg.eigh(matrices(places, 1.0))[1][:, :, 2]
    off = np.sqrt(np.maximum(1 - (axis @ d) ** 2, 0))[(along > 2) & (along < 198)]
    one = sigma / np.sqrt(0.227 * n)
    assert np.sqrt((off**2).mean()) == pytest.approx(np.sqrt(2) * one, rel=0.25)
    assert np.percentile(off, 99.5) < 3.3 * 1.25 * one


@pytest.mark.parametrize("tilt", [0, 35, 90])
def test_a_plane_gives_its_ellipses(tilt):
    """A square lattice, by its symmetry even in its plane: lengths m^(1/3), m^(1/3), m^(-2/3). Face-on a disc, edge-on of ratio m.

    Mutants: the greatest length bounded by the least; one axis alone; no volume.
    """
    a, radius = np.radians(tilt), 6.0
    right, up = np.array([1.0, 0, 0]), np.array([0, np.cos(a), np.sin(a)])
    grid = np.stack(np.meshgrid(np.arange(-9, 10), np.arange(-9, 10)), axis=2).reshape(-1, 2) * 4.0
    grid = grid[np.argsort((grid**2).sum(axis=1), kind="stable")]
    places = grid[:, :1] * right + grid[:, 1:] * up + (0.3, 0.2, 0)
    got = first_disc(places, {"radius": radius, "stretch": {"by": "neighbours", "reach": 15.5, "most": 3}})
    normal = np.cross(right, up)
    shape = 3 ** (2 / 3) * np.eye(3) + (3 ** (-4 / 3) - 3 ** (2 / 3)) * np.outer(normal, normal)
    expected = on_picture(shape, radius)
    assert got == pytest.approx(expected, rel=0.006, abs=0.006 * expected[2])


def test_an_even_cloud_stays_one_of_balls():
    """A lattice has no direction at all. In a random cloud the square of D is chance times chi squared of its five components,
    nearly, divided by 5: it is less than chance in 58% of cases, and those are balls.

    Mutants: no chance (none is a ball); twice as much (93%); half as much (22%).
    """
    lattice = np.stack(np.meshgrid(*[np.arange(9) * 0.4] * 3, indexing="ij"), axis=3).reshape(-1, 3)
    inner = (np.abs(lattice - 1.6) < 0.7).all(axis=1)
    assert matrices(lattice, 0.9)[inner] == pytest.approx(np.broadcast_to(np.eye(3), (27, 3, 3)), abs=1e-4)
    places = np.random.default_rng(2).uniform(0, 5, (3000, 3))
    inside = (np.abs(places - 2.5) < 1.7).all(axis=1)
    squares = np.linalg.eigvalsh(matrices(places, 0.8))[inside]
    ratio = np.sqrt(squares[:, 2] / squares[:, 0])
    assert 0.45 < (ratio < 1.001).mean() < 0.75
    assert np.percentile(ratio, 90) < 1.6
    assert squares.prod(axis=1) == pytest.approx(np.ones(len(squares)), rel=1e-4)


def test_a_crowd_is_stood_for_by_some():
    """100 particles a reach along a rough line, of which 16 of a cell count. Of the 40 samples in reach 0.6 count by their
    weights, so that a shape errs by the root of 1 / 24. Where one particle of fifty dies, one sample of fifty is another: a change
    of less than the root of 2 / 50 of that error, and films do not flicker.

    Mutants: the particles of a cell in the order of their ids, evenly chosen (the change is as large as the error); a sample
    that counts as one particle.
    """
    d, rng = turned(40, 20), np.random.default_rng(5)
    places = rng.uniform(0, 12, 1200)[:, None] * d + rng.normal(0, 0.15, (1200, 3))
    places[400:] = places[400:600].repeat(4, axis=0)[:800] + rng.normal(0, 0.05, (800, 3))
    expected = direct(places, 1.0, 4.0)
    size = np.linalg.norm(expected, axis=(1, 2)).mean()
    found = matrices(places, 1.0)
    error = np.linalg.norm(found - expected, axis=(1, 2)).mean() / size
    lives = np.arange(1200) % 50 != 0
    fewer = matrices(places, 1.0, life=np.where(lives, 9.0, 0.5))
    change = np.linalg.norm(found - fewer, axis=(1, 2))[lives].mean() / size
    assert error < 24**-0.5
    assert change < (2 / 50) ** 0.5 * 24**-0.5


def test_few_particles_are_balls():
    """One, two at any distance, three at the corners of a triangle, all at one place; none, the dead, and no numbers."""
    for places in ([[1, 2, 3]], [[0, 0, 0], [0.4, 0.1, 0]], [[0, 0, 0], [0, 0.99, 0]], np.zeros((40, 3)),
                   [[0, 0, 0], [0.5, 0, 0], [0.25, 0.433, 0]]):  # fmt: skip
        found = neighbour_shapes(NeighbourSums.of(state(places), 1.0, 1.0), 4.0)
        assert found == pytest.approx(np.broadcast_to(BALL, found.shape), abs=2e-6)
    assert neighbour_shapes(NeighbourSums.of(state(np.zeros((0, 3))), 1.0, 1.0), 4.0).tolist() == [BALL]
    line = np.arange(12)[:, None] * [0.1, 0, 0] * np.ones(3)
    line[9], line[10] = np.nan, 1e30
    found = neighbour_shapes(NeighbourSums.of(state(line, birth=[5.0] * 9 + [0.0] * 3), 1.0, 1.0), 4.0)
    assert found == pytest.approx(np.broadcast_to(BALL, found.shape), abs=2e-6)


@pytest.mark.parametrize("radius", [0.3, 2.0, 9.0])
@pytest.mark.parametrize("camera", [PIXELS, Camera(position=(20, 60, 900), fov=40)])
def test_the_light_stays(radius, camera):
    """As much as of discs, with `spread` too, whatever the shapes. Mutant: an ellipse with the norm of a disc."""
    rng = np.random.default_rng(7)
    places = np.concatenate([rng.uniform(-60, 60, (60, 3)), rng.uniform(-60, 60, (60, 1)) * [1, 0.5, 0.2]])
    shape = {"stretch": {"by": "neighbours", "reach": 25, "most": 8}}
    discs, *ellipses = (
        np.array(Painter(SIZE, camera, {"a": Look(draw="disc", radius=radius, **more)}, 1.0).paint(
            scene(1.0, a=state(places)), 0.0), np.float64)
        for more in ({}, shape, {**shape, "spread": {"reach": 20, "most": 2}})
    )  # fmt: skip
    for picture in ellipses:
        assert not np.allclose(picture, discs, atol=0.02 * discs.max())
        assert picture.sum(axis=(0, 1))[:3] == pytest.approx(discs.sum(axis=(0, 1))[:3], rel=1e-5)
    if camera is PIXELS:
        assert discs[..., 0].sum() == pytest.approx(120 * AREA * (1.5 * radius) ** 2, rel=1e-5)


@pytest.mark.parametrize("camera", [Camera(position=(0, 0, 60), fov=60), PIXELS])
@pytest.mark.parametrize("size", [(1, 1), (7, 5), SIZE])
def test_any_places_give_finite_light(camera, size):
    places = [
        [0, 0, 0],
        [0, 0, 70],
        [3, 3, 59.9],
        [1e9, 0, 0],
        [200, 0, 0],
        [5, 5, 0],
        [6, 5, 0],
        [np.nan, 0, 0],
        [7, 5, 0],
    ]
    look = Look(draw="disc", radius=2.0, stretch={"by": "neighbours", "reach": 9})
    for some in (places, places[:1], places[:0]):
        picture = Painter(size, camera, {"a": look}, 1.0).paint(scene(1.0, a=state(np.reshape(some, (-1, 3)))), 0.0)
        assert np.isfinite(picture).all() and (len(some) > 0 or not picture.any())


@pytest.mark.parametrize(
    "stretch, said",
    [
        ({"by": "neighbours"}, "by: neighbours needs `reach`"),
        ({"by": "neighbours", "reach": 1, "time": 1}, "by: neighbours has no `time`"),
        ({"reach": 1}, "by: motion needs `time`"),
        ({"time": 1, "reach": 1}, "by: motion has no `reach`"),
        ({"by": "neighbours", "reach": 0}, "reach"),
        ({"by": "neighbors", "reach": 1}, "did you mean 'neighbours'"),
    ],
)
def test_what_it_needs(stretch, said):
    with pytest.raises(ValueError, match=said):
        Look(draw="disc", stretch=stretch)
