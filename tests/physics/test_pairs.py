"""Power laws between pairs: against NumPy, their sums, their energies; each law's mutant fails."""

import numpy as np
import pytest

import gen_art as ga

I = ga.interactions
EPS = {"f64": np.finfo(np.float64).eps, "f32": np.finfo(np.float32).eps}


def reference(x, c, m, k, n, soft):
    """Accelerations of a_i = -k c_i / m_i sum_j c_j s^(n-1) (x_i - x_j), and the energy with each pair once."""
    d = x[:, None] - x[None]
    s = np.sqrt((d**2).sum(2) + soft**2)
    np.fill_diagonal(s, 1.0)
    w = k * c[:, None] * c[None] * s ** (n - 1)
    np.fill_diagonal(w, 0.0)
    phi = np.log(s) if n == -1 else s ** (n + 1) / (n + 1)
    np.fill_diagonal(phi, 0.0)
    return -(w[..., None] * d).sum(1) / m[:, None], 0.5 * k * (c[:, None] * c[None] * phi).sum()


def cloud(n=300, seed=0):
    r = np.random.default_rng(seed)
    return r.normal(size=(n, 3)), r.normal(size=(n, 3)) * 0.3, r.uniform(0.5, 2, n), r.normal(size=n)


LAWS = {
    "coulomb": (lambda s: I.Coulomb(k=2.0, softening=s), "charge", -2.0, -2.0),
    "spring law": (lambda s: I.PairForce(0.7, 1.0, s), "mass", 0.7, 1.0),
    "log": (lambda s: I.PairForce(-0.7, -1.0, s), "mass", -0.7, -1.0),
    "cube": (lambda s: I.PairForce(0.3, -3.5, s), "mass", 0.3, -3.5),
    "square of charges": (lambda s: I.PairForce(0.3, -2.0, s, per_charge=True), "charge", 0.3, -2.0),
    "constant": (lambda s: I.PairForce(0.3, 0.0, s), "mass", 0.3, 0.0),
}


def first_step(law, soft, precision, h):
    make, row, _, _ = LAWS[law]
    x, _, m, q = cloud()
    system = ga.ParticleSystem(
        position=x, mass=m, charge=q, interactions=[make(soft)], integrator="semi_implicit_euler"
    )
    sim = ga.Simulation({"s": system}, dt=h, precision=precision)
    energy = sim.diagnostics().potential_energy
    sim.step(1)
    return x, m, q if row == "charge" else m, sim["s"].velocity.astype(float) / h, energy


@pytest.mark.parametrize("soft", [0.0, 0.2])
@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-12), ("f32", 5e-5)])
@pytest.mark.parametrize("law", LAWS)
def test_acceleration_energy_and_reaction(law, precision, tolerance, soft):
    k, n = LAWS[law][2:]
    x, m, c, found, energy = first_step(law, soft, precision, 1e-6 if precision == "f64" else 1e-3)
    a, expected = reference(x, c, m, k, n, soft)
    scale = np.abs(a).max()
    assert np.abs(found - a).max() <= tolerance * scale
    assert energy == pytest.approx(expected, rel=tolerance, abs=tolerance * abs(c).sum())
    force = m[:, None] * found
    assert np.abs(force.sum(0)).max() <= 4 * EPS[precision] * np.abs(force).sum()
    for wrong in (
        reference(x, c, m, -k, n, soft),
        reference(x, c, m, 1.01 * k, n, soft),
        reference(x, c, m, k, n + 0.1, soft),
    ):
        assert np.abs(found - wrong[0]).max() > 100 * tolerance * scale


@pytest.mark.parametrize("integrator", ["leapfrog", "rk4", "yoshida4", "position_verlet"])
def test_energy_and_momentum_of_charges(integrator):
    x, v, m, q = cloud(20)

    def drift(dt):
        system = ga.ParticleSystem(
            position=x, velocity=v, mass=m, charge=q, interactions=[I.Coulomb(k=0.3, softening=0.3)], integrator=integrator
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=dt, precision="f64", ledger=True)
        sim.step(round(1.0 / dt))
        account = sim.ledger()
        assert np.abs(account.momentum_residual).max() < 1e-13
        assert np.abs(account.impulse.total).max() < 1e-13
        return abs(account.residual)

    coarse, fine = drift(0.02), drift(0.01)
    assert np.log2(coarse / fine) > (1.7 if integrator in ("leapfrog", "position_verlet") else 3.5)


def test_two_bodies_on_a_spring_law_have_its_period():
    """For exponent 1 the pair is an oscillator: w^2 = strength (m1 + m2), whatever the amplitude."""
    m = np.array([1.0, 3.0])
    system = ga.ParticleSystem(
        position=[[0.75, 0, 0], [-0.25, 0, 0]], mass=m, interactions=[I.PairForce(2.0, 1.0)], integrator="leapfrog"
    )
    period = 2 * np.pi / np.sqrt(2.0 * m.sum())
    sim = ga.Simulation({"s": system}, dt=period / 1000, precision="f64")
    sim.step(250)
    assert np.abs(sim["s"].position).max() < 1e-4
    sim.step(750)
    assert np.abs(sim["s"].position - [[0.75, 0, 0], [-0.25, 0, 0]]).max() < 1e-4


def test_charges_of_another_system_act_without_reaction():
    x, _, m, q = cloud(30)
    both = {
        "dust": ga.ParticleSystem(position=[[3.0, 0, 0]], charge=2.0, interactions=[I.Coulomb(k=1.0, sources="ions")]),
        "ions": ga.ParticleSystem(position=x, mass=m, charge=q),
    }
    sim = ga.Simulation(both, dt=1e-6, precision="f64")
    sim.step(1)
    d = np.array([3.0, 0, 0]) - x
    a = (2.0 * q[:, None] * d / (d**2).sum(1)[:, None] ** 1.5).sum(0)
    assert np.allclose(sim["dust"].velocity[0] / 1e-6, a, rtol=1e-9)
    assert not sim["ions"].velocity.any()


def test_yaml_and_python_are_one():
    from gen_art.preset.registered import Many

    given = {"coulomb": {"softening": 0.1}, "pair_force": {"strength": 2, "exponent": -1, "per_charge": True}}
    one, other = Many("interactions").validate(given)
    assert one.values == I.Coulomb(softening=0.1).values
    assert other.values == I.PairForce(2.0, -1.0, per_charge=True).values


def test_a_charge_without_mass_is_refused():
    system = ga.ParticleSystem(position=np.eye(3), mass=0.0, charge=1.0, interactions=[I.Coulomb()])
    with pytest.raises(ga.UsageError, match="coulomb: a particle with a charge and no mass"):
        ga.Simulation({"s": system}, dt=0.1).step(1)


def test_the_parameters_of_a_tree_are_taken_and_the_tree_refused():
    for make, given in ((I.Coulomb, (1.0, 0.1)), (I.SelfGravity, (1.0, 0.1))):
        assert make(*given, "auto", 0.5).values["theta"] == 0.5
        with pytest.raises(ga.UsageError, match="there is no tree yet; give method 'direct'"):
            make(*given, "tree", 0.5)
    assert I.SelfGravity(1.0, 0.1, "direct", 0.5, 2, "stars").values["sources"] == "stars"
