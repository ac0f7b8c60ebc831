"""Discs as wide as the distance to their neighbours: the distance by a direct sum, the light that stays, and the width."""

import numpy as np
import pytest

from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.neighbour_sums import NeighbourSums
from gen_art.renderer.painter import Painter
from gen_art.renderer.spacing import KERNEL_INTEGRAL, spacing
from gen_art.renderer.sprite import AREA, KERNEL_VARIANCE
from tests.render.particles import scene, state

SIZE = (400, 240)
PIXELS = Camera(position=(0, 0, 500), height=240.0)  # one world unit is one pixel


def direct(positions, reach) -> np.ndarray:
    d = np.linalg.norm(positions[:, None] - positions, axis=2) / reach
    density = (np.maximum(1 - d * d, 0) ** 3).sum(axis=1) / (KERNEL_INTEGRAL * reach**3)
    return density ** (-1 / 3)


def paint(look: dict, position, *, size=SIZE, camera=PIXELS):
    painter = Painter(size, camera, {"a": Look(draw="disc", **look)}, 1.0)
    return np.array(painter.paint(scene(1.0, a=state(position)), 0.0), np.float64)


@pytest.mark.parametrize("reach", [0.05, 0.2, 3.0])
def test_the_distance_is_that_of_a_direct_sum(reach):
    """Up to 16 particles a cell all count. Mutants: a cell's row left out; the fourth power of 1 - r^2; no cube root."""
    positions = np.random.default_rng(4).uniform(-1, 1, (300, 3)) if reach < 1 else np.eye(3)
    found = spacing(NeighbourSums.of(state(positions), 1.0, reach, moments=False))
    assert found == pytest.approx(direct(positions, reach), rel=1e-5)


def test_it_is_the_distance_in_a_lattice_and_the_reach_where_there_is_none():
    """A cubic lattice of distance 0.1, of which 16 of 27 or more in a cell count. The kernel's sum over a lattice errs by 2%."""
    lattice = np.stack(np.meshgrid(*[np.arange(18) * 0.1] * 3, indexing="ij"), axis=3).reshape(-1, 3)
    inner = (np.abs(lattice - 0.85) < 0.5).all(axis=1)
    found = spacing(NeighbourSums.of(state(lattice), 1.0, 0.31, moments=False))[inner]
    assert np.median(found) == pytest.approx(0.1, rel=0.06)
    found = spacing(NeighbourSums.of(state([[0, 0, 0], [9, 9, 9]]), 1.0, 2.0, moments=False))
    assert found == pytest.approx(2 * KERNEL_INTEGRAL ** (1 / 3), rel=1e-6)


def test_only_particles_that_exist_count():
    """Not the dead, the unborn, or places that are no numbers."""
    positions = np.array([[0, 0, 0], [0.1, 0, 0], [np.nan, 0, 0], [1e30, 0, 0], [0, 0.1, 0]])
    particles = state(positions, life=[9, 9, 9, 9, 0.5], birth=[0, 5, 0, 0, 0])
    found = spacing(NeighbourSums.of(particles, 1.0, 1.0, moments=False))
    assert found == pytest.approx([KERNEL_INTEGRAL ** (1 / 3), 0, 0, 0, 0], rel=1e-6)
    assert not spacing(NeighbourSums.of(state(np.zeros((0, 3))), 1.0, 1.0)).any()


@pytest.mark.parametrize("radius", [0.3, 2.0, 9.0])
def test_the_light_stays(radius):
    """Mutant: brightness that does not fall with the area."""
    places = np.random.default_rng(7).uniform(-60, 60, (60, 3))
    for stretch in ({}, {"stretch": 0.1}):
        look = {"radius": radius, "spread": {"reach": 40, "overlap": 0.7, "most": 5}, **stretch}
        got = paint(look, places).sum(axis=(0, 1))[:3]
        assert got == pytest.approx([60 * AREA * (1.5 * radius) ** 2] * 3, rel=1e-5)


def test_smoke_keeps_its_extinction():
    """Coverage times area is the optical depth times area where it is thin: 1 - exp(-0.01) is less than 0.01 by 0.5%."""
    look = {"radius": 2.0, "blend": "alpha", "opacity": 0.01, "albedo": "black"}
    lone = paint(look, [[0, 0, 0]]), paint({**look, "spread": {"reach": 20, "most": 4}}, [[0, 0, 0]])
    alpha = [picture[..., 3].sum() for picture in lone]
    assert alpha[1] == pytest.approx(alpha[0], rel=0.006) and lone[1].max() < 0.1 * lone[0].max()


@pytest.mark.parametrize("overlap, most", [(0.5, 64), (2.0, 64), (0.01, 64), (1.0, 1.7)])
def test_the_radius_is_the_distance_within_its_bounds(overlap, most):
    """By the variance of a lone particle's light. Mutants: the larger of both bounds; the distance without `overlap`."""
    reach, radius = 12.0, 4.0
    p = paint({"radius": radius, "spread": {"reach": reach, "overlap": overlap, "most": most}}, [[0.3, 0.2, 0]])[..., 0]
    x = np.arange(SIZE[0]) + 0.5 - 200.3
    variance = (p.sum(axis=0) * x**2).sum() / p.sum()
    expected = min(max(overlap * reach * KERNEL_INTEGRAL ** (1 / 3), radius), most * radius)
    assert variance == pytest.approx(KERNEL_VARIANCE * ((1.5 * expected) ** 2 + 1.5**2), rel=6e-3)


def test_only_discs_spread():
    with pytest.raises(ValueError, match="spread needs draw: disc"):
        Look(draw="sphere", spread=0.1)
