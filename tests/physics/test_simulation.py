"""The surface of a Simulation: advancing, reading, saving, and refusing what cannot be meant."""

import numpy as np
import pytest

import gen_art as ga
from tests.physics.test_births import BURST, preset


def ball(**more):
    return ga.ParticleSystem(position=[[0, 0, 0]], velocity=[[1, 0, 0]], forces=[ga.forces.Gravity()], **more)


def test_advance_takes_whole_steps_only():
    sim = ga.Simulation({"b": ball()}, dt=0.01)
    sim.advance(0.5)
    assert sim.steps_done == 50 and sim.time == 0.5
    with pytest.raises(ValueError, match=r"nearest is 0\.01"):
        sim.advance(0.012)
    with pytest.raises(ga.UsageError):
        sim.advance(float("nan"))
    with pytest.raises(ga.UsageError):
        sim.step(-1)


def test_arrays_are_read_only_copies():
    sim = ga.Simulation({"b": ball()}, dt=0.01)
    x = sim["b"].position
    with pytest.raises(ValueError, match="read-only"):
        x[0] = 7
    sim.step(1)
    assert x[0, 0] == 0 and sim["b"].position[0, 0] == pytest.approx(0.01)
    assert sim["b"].emitter[0] == "initial"
    assert sim["b"].keys.dtype == np.uint64 and sim["b"].ids.dtype == np.int64


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_view_is_no_copy_and_read_only(precision):
    r = np.random.default_rng(0)
    system = ga.ParticleSystem(
        position=r.normal(size=(5, 3)),
        velocity=r.normal(size=(5, 3)),
        mass=r.uniform(1, 2, 5),
        attributes={"heat": 2.0},
    )
    sim = ga.Simulation({"s": system}, dt=0.01, precision=precision)
    for name in ("position", "velocity", "mass", "charge", "radius", "heat"):
        view = system.view(name)
        copy = system.attribute("heat") if name == "heat" else getattr(system, name)
        assert np.array_equal(view, copy) and view.dtype == copy.dtype and view.shape == copy.shape
        assert np.shares_memory(view, sim.systems["s"].floats) and not np.shares_memory(copy, sim.systems["s"].floats)
        with pytest.raises(ValueError, match="read-only"):
            view[0] = 1
    system.remove([1])
    assert np.array_equal(system.view("position"), system.position) and len(system.view("mass")) == 4
    with pytest.raises(ga.UsageError, match="has no 'positon' to view; did you mean 'position'"):
        system.view("positon")
    system.add((0, 0, 0), lifetime=1.0)
    with pytest.raises(ga.UsageError, match="particles of 's' may die"):
        system.view("position")
    with pytest.raises(ga.UsageError, match="not part of a simulation yet"):
        ball().view("position")


def test_a_system_says_what_it_is():
    one = ball(interactions=[ga.interactions.SelfGravity(G=1.0)])
    assert repr(one) == "<ParticleSystem: 1 particle, gravity, self_gravity, leapfrog; not part of a simulation yet>"
    ga.Simulation({"b": one}, dt=0.01)
    one.add(np.ones((1500, 3)) * np.arange(1500)[:, None])
    assert repr(one) == "<ParticleSystem 'b': 1,501 particles, gravity, self_gravity, leapfrog>"
    one.remove(one.ids[:1500])
    assert repr(one) == "<ParticleSystem 'b': 1 particle, gravity, self_gravity, leapfrog>"


@pytest.mark.parametrize("bad", [
    dict(position=[[1, 2]]), dict(position=[[1, 2, np.nan]]), dict(position=np.zeros((2, 3)), velocity=np.zeros((3, 3))),
    dict(position=np.zeros((2, 3)), mass=[1, 2, 3]), dict(position=np.zeros((2, 3)), mass=-1.0),
    dict(position=np.zeros((2, 3)), forces=["gravity"]), dict(position=np.zeros((2, 3)), interactions=[ga.forces.Gravity()]),
])  # fmt: skip
def test_bad_systems_are_refused_with_a_sentence(bad):
    with pytest.raises(ga.UsageError):
        ga.ParticleSystem(**bad)


def test_bad_simulations_are_refused_with_a_sentence():
    with pytest.raises(ga.UsageError, match="dt"):
        ga.Simulation({"b": ball()})
    with pytest.raises(ga.UsageError, match="precision"):
        ga.Simulation({"b": ball()}, dt=0.1, precision="f16")
    with pytest.raises(ga.UsageError, match="process of its own"):
        ga.Simulation({"b": ball()}, dt=0.1, threads=7)
    with pytest.raises(ga.UsageError, match="arch"):
        ga.Simulation({"b": ball()}, dt=0.1, arch="cuda")
    one = ball()
    ga.Simulation({"b": one}, dt=0.1)
    with pytest.raises(ga.UsageError, match="already"):
        ga.Simulation({"b": one}, dt=0.1)
    with pytest.raises(ga.UsageError, match="no system"):
        ga.Simulation({"b": ball()}, dt=0.1)["c"]


def test_diagnostics():
    r = np.random.default_rng(0)
    x, v, m, q = r.normal(size=(100, 3)), r.normal(size=(100, 3)), r.uniform(1, 2, 100), r.normal(size=100)
    sim = ga.Simulation(
        {"s": ga.ParticleSystem(position=x, velocity=v, mass=m, charge=q, forces=[ga.forces.Gravity()])},
        dt=0.1,
        precision="f64",
    )
    d = sim.diagnostics()
    assert (d.count, d.time) == (100, 0.0)
    assert d.mass == pytest.approx(m.sum()) and d.charge == pytest.approx(q.sum())
    assert np.allclose(d.momentum, (m[:, None] * v).sum(0))
    assert np.allclose(d.angular_momentum, (m[:, None] * np.cross(x, v)).sum(0))
    assert np.allclose(d.center_of_mass, (m[:, None] * x).sum(0) / m.sum())
    assert d.kinetic_energy == pytest.approx(0.5 * (m * (v**2).sum(1)).sum())
    assert d.energy == pytest.approx(d.kinetic_energy + 9.81 * (m * x[:, 1]).sum())
    assert d.as_dict()["energy"] == d.energy


@pytest.mark.parametrize("precision", ["f32", "f64"])
def test_a_snapshot_goes_on_to_the_same_bits(tmp_path, precision):
    whole = ga.Simulation(preset(BURST, forces={"gravity": [0, -9.81, 0]}), precision=precision)
    whole.step(17)
    whole.save(tmp_path / "state.gas")
    again = ga.Simulation.restore(tmp_path / "state.gas")
    assert again.digest() == whole.digest() and again.steps_done == 17
    whole.step(20)
    again.step(20)
    assert again.digest() == whole.digest()


@pytest.mark.parametrize("integrator", ["leapfrog", "rk4", "yoshida4"])
def test_a_snapshot_of_systems_made_in_python(tmp_path, integrator):
    r = np.random.default_rng(1)
    make = ga.ParticleSystem(
        position=r.normal(size=(30, 3)), velocity=r.normal(size=(30, 3)), attributes={"heat": np.arange(30.0)},
        forces=[ga.forces.Drag(0.1, medium=ga.Medium(wind=(1, 0, 0)))], interactions=[ga.interactions.SelfGravity(G=0.01, softening=0.1)],
        integrator=integrator,
    )  # fmt: skip
    whole = ga.Simulation({"s": make}, dt=0.01, precision="f64")
    whole.step(7)
    whole.save(tmp_path / "s.gas")
    again = ga.Simulation.restore(tmp_path / "s.gas")
    whole.step(9)
    again.step(9)
    assert again.digest() == whole.digest()
    assert np.array_equal(again["s"].attribute("heat"), np.arange(30.0))


def test_bad_snapshots(tmp_path):
    with pytest.raises(ga.GenArtError, match="cannot read"):
        ga.Simulation.restore(tmp_path / "none.gas")
    (tmp_path / "bad.gas").write_bytes(b"hello")
    with pytest.raises(ga.UsageError, match="not a snapshot"):
        ga.Simulation.restore(tmp_path / "bad.gas")
    sim = ga.Simulation({"b": ball()}, dt=0.1)
    with pytest.raises(ga.GenArtError, match="cannot write"):
        sim.save(tmp_path / "no" / "such" / "folder.gas")


def test_numbers_compile_nothing():
    """Changing any number, a rate or the seed generates no new kernel."""
    from gen_art.backend import runtime

    def run(g, rate, seed, octaves, radius):
        systems = {
            "s": {
                "particle": {"lifetime": 0.3, "radius": radius},
                "emitters": {
                    "e": {"rate": rate, "shape": {"ball": radius}, "velocity": {"cone": [0, 1, 0], "speed": "1..3"}}
                },
            }
        }
        forces = {
            "gravity": [0, g, 0],
            "damping": 0.1 + rate / 1e4,
            "curl_noise": {"strength": 1.0, "octaves": octaves},
        }
        sim = ga.Simulation(preset(systems, forces=forces, seed=seed))
        sim.step(10)
        return sim.digest()

    first = run(-9.81, 100, 1, 2, 0.1)
    before = runtime.compilations()
    assert (
        len(
            {
                first,
                run(-3.0, 100, 1, 2, 0.1),
                run(-9.81, 777, 1, 2, 0.1),
                run(-9.81, 100, 2, 2, 0.1),
                run(-9.81, 100, 1, 5, 0.1),
                run(-9.81, 100, 1, 2, 0.3),
            }
        )
        == 6
    )
    assert runtime.compilations() == before


def test_memory_of_a_particle_is_at_most_120_bytes():
    systems = {"s": {"particle": {"attributes": {"heat": 1, "spin": 2}}, "emitters": {"e": {"count": 200000}}}}
    sim = ga.Simulation(preset(systems))
    state = sim.systems["s"]
    assert state.nbytes <= 120 * state.capacity
