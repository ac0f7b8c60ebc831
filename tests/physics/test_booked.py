"""Each particle's share of the ledger: the shares of the living and the dead add up to the ledger's entry, and change no bit."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import gen_art as ga
from gen_art import ti
from gen_art.integrators.step_kernels import BLOCK
from tests.physics.test_births import BURST, preset

F, I, C = ga.forces, ga.interactions, ga.colliders
ROOT = Path(__file__).parents[2]
EPS = np.finfo(float).eps
N, STEPS, DT = 60, 50, 0.01


@ga.force("rotating_field")
class RotatingField(ga.Force):
    """A rotating electric field, which works on charges as a cyclotron does.

    E = strength (cos(rate t), -sin(rate t), 0)
    """

    strength: float = ga.param(1.0, unit="V/m")
    rate: float = ga.param(2.0, unit="1/s")
    depends_on_time = True

    @ti.func
    def electric(self, p, t, q):
        return q.strength * ti.Vector([ga.cos(q.rate * t), -ga.sin(q.rate * t), 0.0])


def cloud(integrator="leapfrog", order=slice(None), **parts):
    r = np.random.default_rng(0)
    arrays = dict(position=r.normal(size=(N, 3)), velocity=r.normal(size=(N, 3)), mass=r.uniform(0.5, 2, N))
    arrays = {name: array[order] for name, array in arrays.items()}
    return ga.ParticleSystem(integrator=integrator, **{**arrays, **parts})


def packed(**parts):
    """Spheres that fly together."""
    r = np.random.default_rng(3)
    x = np.stack(np.meshgrid(*[np.arange(4)] * 3), -1).reshape(-1, 3)[:N] * 0.25
    return cloud(position=x + r.uniform(-0.01, 0.01, (N, 3)), velocity=-2 * (x - x.mean(0)), radius=0.1, **parts)


FLOOR = {"normal": (0, 1, 0), "point": (0, -1, 0)}
# by case: the system, which takes `booked`, and the entries of its ledger that the test is about
CASES = {
    "gravity and linear drag": (lambda **k: cloud(forces=[F.Gravity(), F.Drag(linear=0.4)], **k), ["dissipated drag"]),
    "quadratic drag in wind": (
        lambda **k: cloud(forces=[F.Gravity(), F.Drag(0.1, 0.05)], medium=ga.Medium(wind=(2, 0, 0)), **k),
        ["work drag", "dissipated drag"],
    ),
    "two drags, rk4": (
        lambda **k: cloud("rk4", forces=[F.Drag(0.1), F.Drag(quadratic=0.2)], medium=ga.Medium(wind=(2, 0, 0)), **k),
        ["work drag", "work drag_2", "dissipated drag_2", "dissipated"],
    ),
    "cyclotron": (
        lambda **k: cloud("boris", forces=[F.MagneticField((0, 0, 2.0)), RotatingField()], charge=1.0, **k),
        ["work rotating_field", "work magnetic_field"],
    ),
    "relativistic": (
        lambda **k: cloud("vay", forces=[F.MagneticField((0, 0, 2.0)), RotatingField()], charge=1.0, speed_of_light=9.0, **k),
        ["work rotating_field"],
    ),
    "heat bath": (
        lambda **k: cloud(forces=[F.Langevin(temperature=2.0, friction=1.5, boltzmann=1.0)], **k),
        ["work langevin", "dissipated langevin"],
    ),
    "collider": (
        lambda **k: cloud(
            forces=[F.Gravity(), F.Drag(0.1)], colliders=[C.Plane(**FLOOR, restitution=0.5, friction=0.3)], **k
        ),
        ["dissipated plane", "work plane", "dissipated drag", "dissipated"],
    ),
    "collider that moves": (
        lambda **k: cloud(forces=[F.Gravity()], colliders=[C.Plane(**FLOOR, restitution=0.8, velocity=(0, 0.5, 0))], **k),
        ["work plane", "dissipated plane"],
    ),
    "contacts": (
        lambda **k: packed(interactions=[I.Contacts(restitution=0.5, friction=0.3, duration=20 * DT)], **k),
        ["dissipated contacts"],
    ),
    "contacts with a floor": (
        lambda **k: packed(
            forces=[F.Gravity(), F.Drag(0.1)], colliders=[C.Plane(normal=(0, 1, 0), restitution=0.4, friction=0.2)],
            interactions=[I.Contacts(restitution=0.5, friction=0.3, duration=20 * DT)], **k,
        ),
        ["dissipated plane", "dissipated contacts", "dissipated"],
    ),
    "rocket": (
        lambda **k: cloud(
            forces=[F.Gravity(), F.Thrust(direction=(0, 1, 0), exhaust_speed=30.0, mass_rate=0.3, duration=1.0)], **k
        ),
        ["work thrust"],
    ),
}  # fmt: skip


def entry_of(text: str):
    kind, _, name = text.partition(" ")
    return {kind: name} if name else kind


def entry_in(ledger, text: str, system: str = "s") -> float:
    kind, _, name = text.partition(" ")
    entries = getattr(ledger, kind)
    return entries[f"{system}.{name}"] if name else entries.total


@pytest.mark.parametrize("precision", ["f64", "f32"])
@pytest.mark.parametrize("case", CASES)
def test_shares_add_up_to_the_ledger_and_change_no_bit(case, precision):
    """A row of the ledger is the sum, block by block, of what each particle's row is the sum of in time.

    Of m numbers added in any order the error is at most m eps times the sum of their magnitudes; a step has at most 8 of them
    for each particle (4 stages, mass that leaves before and after), and what a share changes by in a step is at most their sum.
    """
    make, wanted = CASES[case]
    sim = ga.Simulation(
        {"s": make(booked=[entry_of(one) for one in wanted])}, dt=DT, precision=precision, advice="none"
    )
    shares = {one: [np.zeros(N)] for one in wanted}
    for _ in range(STEPS):
        sim.step(1)
        for one, history in shares.items():
            history.append(sim["s"].booked(*one.split()))
    ledger = sim.ledger()
    for one, history in shares.items():
        moved = np.abs(np.diff(history, axis=0)).sum()
        entry, bound = entry_in(ledger, one), 8 * N * STEPS * EPS
        assert abs(sim["s"].booked_total(*one.split()) - entry) <= bound * 2 * moved
        assert math.fsum(history[-1]) == sim["s"].booked_total(*one.split())  # nobody died
        assert list(sim.joules()["s"].values())[wanted.index(one)] == pytest.approx(entry, rel=bound)
        if one != "work magnetic_field" and one != "work plane":
            assert moved > 1e-2
    plain = ga.Simulation({"s": make()}, dt=DT, precision=precision, advice="none")
    plain.step(STEPS)
    assert not plain.keeps_ledger and plain.digest() == sim.digest()


@pytest.mark.parametrize("case", [case for case in CASES if not case.startswith(("contacts", "heat bath"))])
def test_each_has_its_own_share_wherever_it_is_stored(case):
    """In the opposite order the particles have the same shares, to the bit: none is booked for a neighbour in memory."""
    make, wanted = CASES[case]
    shares = []
    for order in (slice(None), slice(None, None, -1)):
        sim = ga.Simulation({"s": make(booked=[entry_of(one) for one in wanted], order=order)}, dt=DT, advice="none")
        sim.step(STEPS)
        shares.append([sim["s"].booked(*one.split())[order] for one in wanted])
    assert np.array_equal(*shares)
    assert all(len(np.unique(one)) > N / 4 for one in shares[0] if one.any())


def test_two_equal_spheres_that_meet_lose_the_same():
    """Head on at v and -v: the elastic force works on neither, so each loses what is booked for it, m v^2 (1 - e^2) / 2.

    With 400 steps a contact the restitution is right to order 1 / steps (docs/proofs.md): a bound of 2 / 400.
    """
    spheres = ga.ParticleSystem(
        position=[[-0.11, 0, 0], [0.11, 0, 0]], velocity=[[1, 0, 0], [-1, 0, 0]], mass=2.0, radius=0.1,
        interactions=[I.Contacts(restitution=0.5, duration=0.02)], booked=[{"dissipated": "contacts"}],
    )  # fmt: skip
    sim = ga.Simulation({"s": spheres}, dt=5e-5, precision="f64")
    sim.step(1200)
    lost = 1 - 0.5 * 2 * (sim["s"].velocity ** 2).sum(1)
    assert sim["s"].booked("dissipated", "contacts") == pytest.approx(lost, rel=2 / 400)
    assert lost == pytest.approx([0.75, 0.75], rel=0.05)


def test_a_moving_collider_works_and_a_magnet_does_not():
    make, _ = CASES["collider that moves"]
    sim = ga.Simulation({"s": make(booked=[{"work": "plane"}])}, dt=DT, precision="f64")
    sim.step(100)
    assert sim["s"].booked_total("work", "plane") > 1.0
    make, _ = CASES["cyclotron"]
    sim = ga.Simulation({"s": make(booked=[{"work": "magnetic_field"}])}, dt=DT, precision="f64")
    sim.step(STEPS)
    assert not sim["s"].booked("work", "magnetic_field").any()


def fountain(**look):
    systems = {
        "s": {
            "particle": {"lifetime": "0.05..0.3", "radius": "0.01..0.02", "density": 1000},
            "emitters": {"a": {"rate": 20000, "velocity": {"cone": [0, 1, 0], "angle": 30, "speed": "1..3"}}},
            **look,
        }
    }
    return preset(systems, 0.01, forces={"gravity": [0, -9.81, 0], "drag": {"cd": 0.5}}, medium={"density": 1.2})


DRAG = {"look": {"emission": {"color": {"by": {"dissipated": "drag"}, "range": "0..1e-3", "gradient": "inferno"}}}}


def test_the_dead_keep_their_shares():
    """With births at their own times within steps, and deaths; a look asks for the shares, so the ledger is kept.

    What drag takes is positive, so the sum of magnitudes is the sum: each of at most 20000 births has 2 kicks a step for 0.3 s.
    """
    sim = ga.Simulation(fountain(**DRAG), precision="f64")
    assert sim.keeps_ledger
    sim.step(100)
    entry, total = sim.ledger().dissipated["s.drag"], sim["s"].booked_total("dissipated", "drag")
    assert abs(total - entry) <= 20000 * 60 * EPS * entry
    state, living = sim["s"].state, sim["s"].booked("dissipated", "drag")
    assert len(living) == len(sim["s"].ids) and (living >= 0).all()
    assert state.removed[0] > 0.5 * total, "most have died and were removed"
    assert entry - math.fsum(living) > 0.5 * entry  # the mutant: the living alone
    assert sim.digest() == _after(fountain(), 100)


def _after(given, steps) -> str:
    sim = ga.Simulation(given, precision="f64")
    assert not sim.keeps_ledger
    sim.step(steps)
    return sim.digest()


def test_children_begin_with_nothing():
    """Shells burst into stars that are moved to the end of the step in which they are born, and these shed glitter."""
    systems = {name: {**system, **(DRAG if name != "shells" else {})} for name, system in BURST.items()}
    more = dict(forces={"gravity": [0, -9.81, 0], "drag": {"cd": 0.5}}, medium={"density": 1.2})
    sim = ga.Simulation(preset(systems, 0.01, **more), precision="f64")
    sim.step(45)
    ledger = sim.ledger()
    for name in ("stars", "glitter"):
        entry = ledger.dissipated[f"{name}.drag"]
        assert entry > 0
        assert (
            abs(sim[name].booked_total("dissipated", "drag") - entry) <= 45 * 2 * sim[name].state.next_id * EPS * entry
        )
    young = sim["glitter"].age < 0.01
    assert (
        young.any()
        and sim["glitter"].booked("dissipated", "drag")[young].max() < sim["glitter"].booked("dissipated", "drag").max()
    )
    with pytest.raises(ga.UsageError, match=r"keep no share of \{dissipated: drag\}.*booked="):
        sim["shells"].booked("dissipated", "drag")


def test_one_particle_loses_what_is_booked():
    """A fall with linear drag. Position Verlet works gravity's energy out exactly, so the change of the energy is what is booked.

    Each step adds to the energy and to the share with a few roundings of the energy that moves.
    """
    ball = ga.ParticleSystem(
        position=[[0, 5, 0]], velocity=[[1, 0, 0]], mass=0.3, forces=[F.Gravity(), F.Drag(linear=0.2)],
        integrator="position_verlet", booked=[{"dissipated": "drag"}],
    )  # fmt: skip
    sim = ga.Simulation({"b": ball}, dt=0.01, precision="f64")
    before = sim.diagnostics().energy
    for _ in range(5):
        sim.step(20)
        lost = before - sim.diagnostics().energy
        assert sim["b"].booked("dissipated", "drag")[0] == pytest.approx(lost, abs=10 * 100 * EPS * before)
    # by hand: m g y turns into heat at the rate c v^2, v by v' = g - c v / m
    assert lost == pytest.approx(_heat(1.0), rel=1e-4)
    assert _heat(1.0, drag=0.201) != pytest.approx(_heat(1.0), rel=1e-3)


def _heat(seconds, mass=0.3, drag=0.2, g=9.81):
    """The integral of drag v^2, J, over v = (exp(-k t), (g / k) (1 - exp(-k t))), k = drag / mass, by 10^5 midpoints."""
    k, n = drag / mass, 100_000
    t = (np.arange(n) + 0.5) * seconds / n
    return float(drag * (np.exp(-2 * k * t) + (g / k * (1 - np.exp(-k * t))) ** 2).sum() * seconds / n)


def test_batches_of_steps_give_the_same_shares():
    one, many = (ga.Simulation(fountain(**DRAG)) for _ in range(2))
    one.step(60)
    for _ in range(60):
        many.step(1)
    assert one["s"].booked("dissipated", "drag").tobytes() == many["s"].booked("dissipated", "drag").tobytes()
    assert one["s"].booked_total("dissipated", "drag") == many["s"].booked_total("dissipated", "drag")


THREADS = """
import sys
import gen_art as ga
from tests.physics.test_booked import DRAG, fountain
sim = ga.Simulation(fountain(**DRAG), threads=int(sys.argv[1]))
sim.step(120)
linear = ga.render_frame(sim, (96, 54))
print(sim["s"].count, sim.digest(), sim["s"].booked("dissipated", "drag").tobytes().hex(), sim.ledger().dissipated, hash(linear.tobytes()))
"""


def test_one_thread_and_two_book_the_same_bytes():
    said = []
    for threads in ("1", "2"):
        env = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": "0"}
        run = subprocess.run([sys.executable, "-c", THREADS, threads], capture_output=True, text=True, env=env)
        assert run.returncode == 0, run.stderr
        said.append(run.stdout)
    assert said[0] == said[1] and int(said[0].split()[0]) > 2 * BLOCK


def test_a_snapshot_carries_shares_and_ledger_bit_for_bit(tmp_path):
    sim = ga.Simulation(fountain(**DRAG))
    sim.step(70)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    for steps in (0, 50):
        sim.step(steps)
        again.step(steps)
        assert again.digest() == sim.digest()
        assert again["s"].booked("dissipated", "drag").tobytes() == sim["s"].booked("dissipated", "drag").tobytes()
        assert again["s"].booked_total("dissipated", "drag") == sim["s"].booked_total("dissipated", "drag")
        assert again.ledger().as_dict() == sim.ledger().as_dict()
    assert sim["s"].booked_total("dissipated", "drag") > 0


def test_a_snapshot_of_a_script_carries_them_too(tmp_path):
    make, wanted = CASES["collider"]
    sim = ga.Simulation({"s": make(booked=[entry_of(one) for one in wanted])}, dt=DT, precision="f64")
    sim.step(60)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    sim.step(20)
    again.step(20)
    assert again.ledger().as_dict() == sim.ledger().as_dict()
    for one in wanted:
        assert again["s"].booked(*one.split()).tobytes() == sim["s"].booked(*one.split()).tobytes()


def test_a_ledger_that_begins_later_begins_with_nothing():
    make, _ = CASES["gravity and linear drag"]
    sim = ga.Simulation({"s": make(booked=["dissipated"])}, dt=DT, precision="f64")
    sim.step(10)
    sim.keep_ledger()
    assert not sim["s"].booked("dissipated").any() and sim["s"].booked_total("dissipated") == 0.0
    sim.step(10)
    assert sim["s"].booked_total("dissipated") == pytest.approx(sim.ledger().dissipated.total, rel=1e-12)


@pytest.mark.parametrize(
    "booked,sentence",
    [
        ([{"work": "drog"}], "no entry {work: drog}; did you mean 'drag'"),
        (
            [{"work": "gravity"}],
            "no entry {work: gravity}: the work of a conservative force is the change of potential energy; there are drag",
        ),
        ([{"wrk": "drag"}], "work or dissipated, not 'wrk'; did you mean 'work'"),
        ([{"work": ""}], "work needs the name of a force"),
        ([{"work": "drag\n"}], "work needs the name of a force"),
        (["work"], "an entry of the ledger is"),
        ([{"work": "drag", "dissipated": "drag"}], "an entry of the ledger is"),
        ("dissipated", "booked must be a list"),
        (3, "booked must be a list"),
    ],
)
def test_what_cannot_be_booked_is_a_sentence(booked, sentence):
    with pytest.raises(ga.UsageError) as error:
        cloud(forces=[F.Gravity(), F.Drag(0.1)], booked=booked)
    assert sentence in str(error.value)


def test_what_a_whole_body_loses_is_not_split():
    with pytest.raises(ga.UsageError, match="no force on this system takes energy"):
        cloud(forces=[F.Gravity()], booked=["dissipated"])
    springs = dict(pairs=[(0, 1)], stiffness=3.0, damping=0.1)
    for more, integrator in (({"method": "implicit"}, "semi_implicit_euler"), ({"tear": 0.5}, "leapfrog")):
        with pytest.raises(ga.UsageError, match="for bodies and bonds as a whole"):
            cloud(integrator, interactions=[I.Springs(**springs, **more)], booked=[{"dissipated": "springs"}])
    with pytest.raises(ga.UsageError, match=r"no entry \{work: springs\}; there is \{dissipated: springs\}"):
        cloud(forces=[F.Drag(0.1)], interactions=[I.Springs(**springs)], booked=[{"work": "springs"}])
    cloud(interactions=[I.Springs(**springs)], booked=[{"dissipated": "springs"}, "dissipated"])


def test_shares_that_are_not_finite_stop_no_step():
    """The overflow of a product in float32 is no error of the simulation; the picture's recipe refuses it."""
    make, _ = CASES["gravity and linear drag"]
    sim = ga.Simulation({"s": make(booked=["dissipated"])}, dt=DT)
    state = sim["s"].state
    for shares, total in (([np.inf, -np.inf], np.nan), ([1e308, 1e308], np.inf), ([1e308, -1e308], 0.0)):
        state.booked[0, :2] = shares
        assert np.array_equal(sim["s"].booked_total("dissipated"), total, equal_nan=True)


def test_adaptive_steps_say_that_they_keep_no_ledger():
    make, _ = CASES["gravity and linear drag"]
    sim = ga.Simulation({"s": make(booked=["dissipated"])}, dt=DT)
    with pytest.raises(ga.UsageError, match=r"adaptive steps keep no ledger, and system 's'.*dissipated"):
        ga.adaptive(sim, 0.1)
