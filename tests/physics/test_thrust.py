"""A rocket: Tsiolkovsky's equation, the mass that is left, and the account of what the exhaust takes."""

import numpy as np
import pytest

import gen_art as ga

F = ga.forces
M0, SPEED, RATE, DURATION = 2.0, 30.0, 0.3, 5.0


def rocket(dt, integrator="leapfrog", forces=(), seconds=6.0, precision="f64", speed=SPEED, ledger=False, **engine):
    engine = {"direction": (0, 2.0, 0), "exhaust_speed": speed, "mass_rate": RATE, "duration": DURATION, **engine}
    ship = ga.ParticleSystem(
        position=[[0.2, 0, 0]], velocity=[[1.0, 0.5, 0]], mass=M0, integrator=integrator,
        forces=[F.Thrust(**engine), *forces],
    )  # fmt: skip
    sim = ga.Simulation({"r": ship}, dt=dt, precision=precision, ledger=ledger)
    sim.step(round(seconds / dt))
    return sim


GAIN = SPEED * np.log(M0 / (M0 - RATE * DURATION))


@pytest.mark.parametrize("integrator", ["leapfrog", "position_verlet", "yoshida4", "rk2", "rk4", "boris"])
def test_tsiolkovsky(integrator):
    sim = rocket(0.01, integrator)
    assert sim["r"].mass[0] == pytest.approx(M0 - RATE * DURATION, abs=1e-12)
    assert sim["r"].velocity[0, 1] - 0.5 == pytest.approx(GAIN, rel=1e-4)
    assert sim["r"].velocity[0, 0] == 1.0  # the mass that leaves takes its own momentum with it
    mutant = rocket(0.01, integrator, speed=SPEED * 1.001)["r"].velocity[0, 1] - 0.5
    assert mutant != pytest.approx(GAIN, rel=1e-4)


def test_float32():
    sim = rocket(0.01, precision="f32")
    assert sim["r"].velocity[0, 1] - 0.5 == pytest.approx(GAIN, rel=1e-4)
    assert sim["r"].mass[0] == pytest.approx(0.5, abs=2e-5)


@pytest.mark.parametrize("integrator,order", [("leapfrog", 2), ("rk4", 4)])
def test_order(integrator, order):
    errors = [abs(rocket(dt, integrator)["r"].velocity[0, 1] - 0.5 - GAIN) for dt in (0.1, 0.05)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.3)


def test_a_burn_that_ends_inside_a_step_burns_all_the_same():
    sim = rocket(0.04, start=0.113, duration=4.321)
    assert sim["r"].mass[0] == pytest.approx(M0 - RATE * 4.321, abs=1e-12)
    expected = SPEED * np.log(M0 / (M0 - RATE * 4.321))
    assert sim["r"].velocity[0, 1] - 0.5 == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("integrator", ["leapfrog", "position_verlet", "rk4"])
def test_the_account_has_what_the_exhaust_takes(integrator):
    """Work is the energy set free, rate speed^2 / 2; the exhaust leaves at v - speed n; mass, momentum and energy close."""
    forces = [F.Gravity(), F.Spring(stiffness=0.3)]
    accounts = {}
    for dt in (0.02, 0.01):
        sim = rocket(dt, integrator, forces, ledger=True)
        accounts[dt] = led = sim.ledger()
        gone = led.died["r.thrust"]
        assert gone.count == 0 and gone.mass == pytest.approx(RATE * DURATION, rel=1e-12)
        assert M0 - gone.mass == pytest.approx(sim.diagnostics().mass, rel=1e-12)
        assert led.work["r.thrust"] == pytest.approx(0.5 * RATE * DURATION * SPEED**2, rel=1e-3)
        assert np.abs(led.impulse["r.thrust"]).max() <= 1e-9  # an engine pushes on its own exhaust
        assert np.abs(led.momentum_residual).max() <= 1e-10
    order = {"rk4": 4}.get(integrator, 2)
    first, second = (abs(accounts[dt].residual) / accounts[dt].scale for dt in (0.02, 0.01))
    assert second <= 1e-12 or np.log2(first / second) >= order - 0.4
    assert second <= 1e-4
    assert abs(accounts[0.01].died.total.energy) > 0.01 * accounts[0.01].scale  # the mutant: exhaust not booked


def test_free_flight_keeps_momentum_of_ship_and_exhaust():
    sim = rocket(0.01, ledger=True)
    total = sim.diagnostics().momentum + sim.ledger().died["r.thrust"].momentum
    assert np.allclose(total, M0 * np.array([1.0, 0.5, 0]), atol=1e-10)
    turn = sim.diagnostics().angular_momentum + sim.ledger().died["r.thrust"].angular_momentum
    assert np.allclose(turn, M0 * np.cross((0.2, 0, 0), (1.0, 0.5, 0)), atol=1e-3)


def test_the_ledger_leaves_the_bits_alone():
    assert rocket(0.05, ledger=True).digest() == rocket(0.05).digest()


def test_with_a_mutual_force_the_stages_burn_alike():
    ship = ga.ParticleSystem(
        position=[[0, 0, 0], [50.0, 0, 0]], mass=[M0, M0], forces=[F.Thrust((0, 1, 0), SPEED, RATE, DURATION)],
        interactions=[ga.interactions.SelfGravity(G=1e-12, softening=0.1)],
    )  # fmt: skip
    sim = ga.Simulation({"r": ship}, dt=0.01, precision="f64")
    sim.step(600)
    assert sim["r"].velocity[:, 1] == pytest.approx(GAIN, rel=1e-4)
    assert sim["r"].mass == pytest.approx(0.5, abs=1e-12)


def test_a_particle_too_light_is_refused():
    with pytest.raises(ga.UsageError, match="would leave nothing of a particle of 2 kg"):
        rocket(0.1, duration=7.0)
    with pytest.raises(ga.UsageError, match="dry mass of 1 kg"):
        rocket(0.1, dry_mass=1.0)
    with pytest.raises(ga.UsageError, match="null vector"):
        F.Thrust((0, 0, 0))


@ga.force("test_leak")
class Leak(ga.Force):
    """Mass lost at rest with the particle, which keeps its velocity. dm/dt = -rate; rate in kg/s."""

    rate: float = ga.param(0.1, unit="kg/s", min=0)

    @ga.ti.func
    def mass_rate(self, p, t, q):
        return q.rate


def test_a_scripted_loss_of_mass_keeps_the_velocity():
    drop = ga.ParticleSystem(position=[[0, 0, 0]], velocity=[[1.0, 2.0, 0]], mass=1.0, forces=[Leak(0.1), F.Gravity()])
    sim = ga.Simulation({"d": drop}, dt=0.01, precision="f64", ledger=True)
    sim.step(500)
    assert sim["d"].mass[0] == pytest.approx(0.5, abs=1e-12)
    assert np.allclose(sim["d"].velocity[0], (1.0, 2.0 - 9.81 * 5, 0), atol=1e-11)
    led = sim.ledger()
    assert led.died["d.test_leak"].mass == pytest.approx(0.5, abs=1e-12)
    assert abs(led.residual) <= 1e-5 * led.scale
