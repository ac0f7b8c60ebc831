"""Lift turns the path, in a medium that moves, and its account closes."""

import numpy as np
import pytest

import gen_art as ga

F = ga.forces
DENSITY, AREA, COEFFICIENT, MASS = 1.2, 0.5, 0.9, 2.0
RADIUS = MASS / (0.5 * DENSITY * AREA * COEFFICIENT)


def fly(lift, dt, integrator="rk4", wind=(0.0, 0.0, 0.0), seconds=4.0, ledger=False, precision="f64"):
    glider = ga.ParticleSystem(
        position=[[0, 0, 0]], velocity=[(3.0 + wind[0], wind[1], wind[2])], mass=MASS, forces=[lift],
        medium=ga.Medium(density=DENSITY, wind=wind), integrator=integrator,
    )  # fmt: skip
    sim = ga.Simulation({"g": glider}, dt=dt, precision=precision, ledger=ledger)
    sim.step(round(seconds / dt))
    return sim


def looped(t, wind):
    """A loop of radius m / (1/2 density area coefficient), whatever the speed, carried along by the wind."""
    angle = 3.0 * t / RADIUS
    return RADIUS * np.array([np.sin(angle), 1 - np.cos(angle), 0.0]) + np.array(wind) * t


@pytest.mark.parametrize("wind", [(0.0, 0.0, 0.0), (1.0, -0.5, 0.25)])
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-8), ("f32", 3e-5)])
def test_loops_have_the_radius_of_the_formula(wind, precision, tolerance):
    lift = F.Lift(COEFFICIENT, AREA)
    found = fly(lift, 0.01, wind=wind, precision=precision)["g"].position[0]
    assert np.abs(found - looped(4.0, wind)).max() <= tolerance * RADIUS
    mutant = fly(F.Lift(-COEFFICIENT, AREA), 0.01, wind=wind)["g"].position[0]
    assert np.abs(mutant - looped(4.0, wind)).max() > 0.1


@pytest.mark.parametrize("integrator,order", [("rk2", 2), ("rk4", 4), ("leapfrog", 1)])
def test_order(integrator, order):
    wind = (1.0, 0.0, 0.0)
    errors = [
        np.abs(fly(F.Lift(COEFFICIENT, AREA), dt, integrator, wind)["g"].position[0] - looped(4.0, wind)).max()
        for dt in (0.04, 0.02)
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)


def test_the_account_closes_and_still_air_takes_no_energy():
    lift = F.Lift(COEFFICIENT, AREA)
    still = fly(lift, 0.01, ledger=True)
    assert abs(still.ledger().work["g.lift"]) <= 1e-7 * still.diagnostics().energy
    windy = fly(lift, 0.01, wind=(1.0, -0.5, 0.25), ledger=True).ledger()
    assert abs(windy.work["g.lift"]) > 0.1
    assert abs(windy.residual) <= 1e-7 * windy.scale


def test_it_needs_a_density_and_an_axis():
    with pytest.raises(ga.UsageError, match="density"):
        ga.ParticleSystem(position=np.zeros((1, 3)), forces=[F.Lift()])
    with pytest.raises(ga.UsageError, match="span_axis"):
        F.Lift(span_axis=(0, 0, 0))


def test_a_kick_that_loses_an_order_is_named():
    from gen_art.audit.advice import advice
    from gen_art.audit.invariants import expected_order

    def preset(integrator):
        return ga.load_preset(
            {
                "version": 1, "clock": {"duration": 1, "fps": 25, "step": 0.01}, "medium": {"density": 1.2},
                "systems": {"a": {"integrator": integrator, "forces": {"lift": {"area": 0.1}}, "emitters": {"e": {"count": 1}}}},
            }
        )  # fmt: skip

    assert expected_order(preset("leapfrog"), "a") == 1 and expected_order(preset("rk4"), "a") == 4
    assert any("lift" in line and "rk2" in line for line in advice(preset("leapfrog")))
    assert not advice(preset("rk4"))
