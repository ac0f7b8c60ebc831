"""The numbers in the presets of the course are those of the formulas their first lines name."""

import math

import numpy as np
import pytest

import gen_art as ga


def test_the_pendulums_make_whole_numbers_of_swings_a_minute():
    """T = 2 pi sqrt(I / (M g d)) by the masses of each body about its held top: 60 s / n, n = 24 .. 43; all end in step."""
    system = ga.Simulation(ga.load_preset("course/pendulums"), precision="f64")["pendulums"]
    tints = system.attribute("tint")
    swings = []
    for tint in np.unique(tints):
        of = tints == tint
        x, m = system.position[of, :2], system.mass[of]
        if np.linalg.norm(m @ x) < 0.1 * m.sum():  # the beam
            continue
        swings.append(60 / (2 * math.pi * math.sqrt(m @ (x * x).sum(1) / (9.81 * np.linalg.norm(m @ x)))))
    assert swings == pytest.approx(np.arange(24, 44), abs=2e-3)
    assert np.abs(np.sqrt(np.array(swings) ** 2 * 1.01) - np.arange(24, 44)).max() > 0.1  # the mutant: lengths 1% off


def test_each_chain_is_driven_at_a_frequency_of_its_own():
    """w_j = 2 sqrt(k / m) sin(j pi / (2 (N + 1))), N = 39."""
    systems = ga.load_preset("course/chain").systems
    for j in (1, 3, 5, 7, 9):
        forces, chain = systems[f"mode_{j}"].forces, systems[f"mode_{j}"].interactions
        driver = next(f for f in forces if f.name == "driver")
        stiffness = next(c for c in chain if c.name == "springs").values["stiffness"]
        w = 2 * math.sqrt(stiffness) * math.sin(j * math.pi / 80)
        assert 2 * math.pi * driver.values["frequency"] == pytest.approx(w, rel=1e-4)
