"""What a simulation says of steps, schemes and precisions that cannot carry the motion, and that it stops at the first NaN."""

import contextlib
import re
import warnings

import numpy as np
import pytest

import gen_art as ga
from gen_art.particles.rows import LIFETIME

F, I = ga.forces, ga.interactions
GM_EARTH = 3.986004418e14  # m^3/s^2


def simulated(dt, precision="f64", advice="warn", **system):
    return ga.Simulation({"s": ga.ParticleSystem(**system)}, dt=dt, precision=precision, advice=advice)


def orbit(integrator="leapfrog", speed=1.0, softening=0.0):
    """A light body about a heavy one at 1 m, with a period of 2 pi s if speed is 1."""
    return dict(
        position=[[0, 0, 0], [1, 0, 0]], velocity=[[0, 0, 0], [0, speed, 0]], mass=[1, 1e-9], integrator=integrator,
        interactions=[I.SelfGravity(G=1.0, softening=softening)],
    )  # fmt: skip


def said(dt, steps=1200, precision="f64", **system):
    """The advice of a run, until it ends or diverges."""
    with warnings.catch_warnings(record=True) as caught, contextlib.suppress(ga.DivergedError):
        warnings.simplefilter("always")
        simulated(dt, precision, **system).step(steps)
    return [str(w.message) for w in caught if issubclass(w.category, ga.AdviceWarning)]


ONE = dict(position=[[1.0, 0, 0]], velocity=[[0, 1.0, 0]])
FIELD = dict(**ONE, charge=1.0, forces=[F.MagneticField((0, 0, 1.0))])
NOISE = dict(
    position=np.random.default_rng(0).normal(size=(50, 3)), forces=[F.CurlNoise(strength=1.0, scale=0.1)],
    velocity=np.tile([30.0, 0, 0], (50, 1)),
)  # fmt: skip
LOW_ORBIT = dict(
    position=[[6.771e6, 0, 0]], velocity=[[0, (GM_EARTH / 6.771e6) ** 0.5, 0]],
    forces=[F.CentralForce(strength=GM_EARTH, exponent=-2)],
)  # fmt: skip

# what: (dt, system, more, the words; None: nothing is said)
CASES = {
    "leapfrog in a magnetic field": (0.5, FIELD, {}, "leapfrog takes magnetic_field.* plain kick.* boris turns"),
    "boris that turns too far": (0.5, {**FIELD, "integrator": "boris"}, {}, r"w dt = 0\.5 rad a step.* at most 0\.1 s"),
    "boris": (0.05, {**FIELD, "integrator": "boris"}, {}, None),
    "drag in rk4": (1.0, dict(**ONE, forces=[F.Damping(10.0)], integrator="rk4"), {}, "step of 1 s is too long for particle 0"),
    "drag in leapfrog, which solves it": (1.0, dict(**ONE, forces=[F.Damping(10.0)]), {}, None),
    "a spring above the limit": (1.0, dict(**ONE, forces=[F.Spring(stiffness=100.0)]), {}, r"w dt = 10 .* at most 0\.2 s"),
    "a spring": (0.05, dict(**ONE, forces=[F.Spring(stiffness=100.0)]), {}, None),
    "a close encounter": (0.02, orbit(speed=0.2), {}, r"step of 0.02 s is too long.* or give self_gravity a softening"),
    "an unsoftened plunge": (1e-3, orbit(speed=0.001), {}, "step of 0.001 s is too long for particle 1"),
    "an orbit": (0.02, orbit(), {}, None),
    "an eccentric orbit, well resolved": (1e-3, orbit(speed=0.3), {"steps": 8000}, None),
    "a swarm past its noise": (0.05, NOISE, {}, r"past the 0\.1 m of curl_noise's scale; use a step of at most 0\.001 s"),
    "one of two past its noise": (0.05, {**NOISE, "position": [[0, 0, 0], [1, 0, 0]], "velocity": [[0, 0, 0], [30, 0, 0]]}, {}, None),
    "a swarm in its noise": (1e-3, {**NOISE, "velocity": None}, {}, None),
    "a low orbit in float32": (0.01, LOW_ORBIT, {"precision": "f32"}, "in float32 a position is rounded by .* precision f64"),
    "a low orbit in float64": (0.01, LOW_ORBIT, {}, None),
    "a low orbit in float32, longer steps": (1.0, LOW_ORBIT, {"precision": "f32"}, None),
}  # fmt: skip


@pytest.mark.parametrize("what", CASES)
def test_what_cannot_be_right_is_said_once(what):
    dt, system, more, words = CASES[what]
    sentences = said(dt, **more, **system)
    if words is None:
        assert sentences == []
    else:
        assert sum(re.search(f"^system 's': .*{words}", sentence) is not None for sentence in sentences) == 1, sentences
        assert len(set(sentences)) == len(sentences) <= 2


def test_the_step_that_is_advised_will_do():
    """With the step that the warning of a close encounter names, nothing is said, and the energy is kept."""
    sentence = next(s for s in said(0.02, **orbit(speed=0.2)) if "too long" in s)
    for _ in range(6):  # each shorter step comes closer to the pericentre, where the force changes faster
        better = float(re.search(r"at most (\S+) s", sentence)[1])
        sim = simulated(better, advice="none", **orbit(speed=0.2))
        start = sim.diagnostics().energy
        again = said(better, steps=round(2.5 / better), **orbit(speed=0.2))
        if not again:
            break
        sentence = again[0]
    assert not again
    sim.step(round(2.5 / better))
    assert sim.diagnostics().energy == pytest.approx(start, rel=0.05)


def test_advice_can_be_an_error_or_nothing():
    with pytest.raises(ga.UsageError, match="system 's': leapfrog takes magnetic_field"):
        simulated(0.5, advice="error", **FIELD)
    sim = simulated(1e-3, advice="error", **orbit(speed=0.001))
    with pytest.raises(ga.UsageError, match=r"step of 0.001 s is too long for particle 1"):
        sim.step(2000)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulated(0.5, advice="none", **FIELD).step(10)
    with pytest.raises(ga.UsageError, match="advice must be warn, error or none, not 'warm'; did you mean 'warn'"):
        simulated(0.5, advice="warm", **FIELD)


def test_looking_changes_no_bits():
    digests = set()
    for advice, batch in (("none", 300), ("warn", 300), ("warn", 7)):
        sim = simulated(0.01, advice=advice, precision="f32", **NOISE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for _ in range(0, 300, batch):
                sim.step(min(batch, 300 - sim.steps_done))
        digests.add(sim.digest())
    assert len(digests) == 1


def exploding():
    """A chain that is far too stiff for its step, fixed at one end, beside a particle that nothing acts on."""
    net = ga.chain((0, 0, 0), (1, 0, 0), 4)
    return dict(
        position=net.position + [[0, 0, 0], [0.1, 0, 0], [0, 0, 0], [0, 0, 0]], fixed=[0],
        interactions=[net.springs(1e6)], mass=1e-3,
    )  # fmt: skip


def test_a_run_that_leaves_the_finite_numbers_stops():
    sim = simulated(0.1, advice="none", **exploding())
    with pytest.raises(
        ga.DivergedError, match=r"^system 's': .*particle \d.* left the finite numbers by step (\d+)"
    ) as caught:
        sim.step(100_000)
    assert "a step of 0.1 s is too long for the forces of springs" in str(caught.value)
    assert caught.value.exit_code == 3
    stopped = sim.steps_done
    with pytest.raises(ga.DivergedError):
        sim.digest()
    with pytest.raises(ga.DivergedError):
        sim.diagnostics()
    with pytest.raises(ga.DivergedError):
        sim.step(64)
    # it was noticed within 64 steps: a run that ends 65 steps before is finite
    before = simulated(0.1, advice="none", **exploding())
    before.step(max(0, stopped - 65))
    assert np.isfinite(before["s"].position).all()


def test_a_dead_particle_stops_nothing():
    """Only the living count."""
    sim = simulated(0.1, advice="none", **ONE)
    sim["s"].add(position=[[2.0, 0, 0]], lifetime=1.0)
    sim["s"].state.floats[0, 1] = np.nan
    with pytest.raises(ga.DivergedError, match="particle 1 left"):
        sim.digest()
    sim["s"].state.floats[LIFETIME, 1] = 0.0
    sim.digest()


@pytest.mark.parametrize("weight,sign", [("mass", -1), ("charge", 1)])
def test_bodies_at_the_same_place_have_an_infinite_energy(weight, sign):
    """It was 0; with a softening, or where one of them has no weight, it is finite."""
    law = I.SelfGravity(G=1.0, softening=0.0) if weight == "mass" else I.Coulomb(k=1.0, softening=0.0)

    def made(law, amounts):
        return dict(
            position=[[0, 0, 1], [0, 0, 0], [0, 1, 0], [0, 0, 1.0]], interactions=[law], **{"mass": 1.0, weight: amounts}
        )  # fmt: skip

    with pytest.warns(ga.AdviceWarning, match="particles 0 and 3 are at the same place.*infinite energy.*softening"):
        sim = simulated(0.01, **made(law, [1.0, 2.0, 3.0, 4.0]))
    assert sim.diagnostics().potential_energy == sign * np.inf
    for other, amounts in (
        (type(law)(softening=0.1), [1.0, 2.0, 3.0, 4.0]),
        (type(law)(softening=0.0), [1.0, 2.0, 3.0, 0.0]),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert np.isfinite(simulated(0.01, **made(other, amounts)).diagnostics().potential_energy)
