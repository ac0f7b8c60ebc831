"""Blades in the wind, presets and snapshots of rigid bodies, and the same bits on any number of threads."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.interactions.rigid.quaternions import matrices, product, rotation
from gen_art.particles.fixed import FIXED
from gen_art.particles.rows import LIFETIME
from tests.physics.bodies import inside, tower, world

# -- blades


def rotor(pitch, **others):
    """Three thin blades from r = 0.2 to 1.2 m about x, each turned about its own length by `pitch`, rad."""
    blades = []
    for k in range(3):
        about = rotation(np.array([2 * np.pi * k / 3, 0, 0]))
        q = product(about, rotation(np.array([0, pitch, 0])))
        turn = q[1:] / np.linalg.norm(q[1:]) * 2 * np.degrees(np.arctan2(np.linalg.norm(q[1:]), q[0]))
        at = matrices(about) @ [0, 0.7, 0]
        blades.append({"box": [0.002, 1.0, 0.12], "at": at.tolist(), "turn": turn.tolist()})
    return ga.body(blades, axle=(1, 0, 0), **others)


def thin_plate(w, n):
    """Force over 1/2 density area: Newton's plate, 2 sin a along the normal, and friction 0.02 along the stream."""
    speed = np.linalg.norm(w, axis=1)
    return -2 * n * ((w @ n) * speed)[:, None] - 0.02 * w * speed[:, None]


def test_panel_is_a_thin_plate():
    r = np.random.default_rng(5)
    v, n, area = r.normal(size=(40, 3)), r.normal(size=(40, 3)), r.uniform(0.1, 1, 40)
    n /= np.linalg.norm(n, axis=1)[:, None]
    names = dict(area=area, normal_x=n[:, 0], normal_y=n[:, 1], normal_z=n[:, 2])
    wind = np.array([1.0, 0.5, 0.0])

    def kick(**numbers):
        system = ga.ParticleSystem(
            position=np.zeros((40, 3)), velocity=v, mass=2.0, forces=[ga.forces.Panel(**numbers)], attributes=names,
            medium=ga.Medium(density=1.2, wind=wind), integrator="semi_implicit_euler",
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=1e-6, precision="f64")
        sim.step(1)
        return (sim["s"].velocity - v) / 1e-6 * 2.0 / (0.6 * area[:, None])

    expected = np.concatenate([thin_plate(v[k : k + 1] - wind, n[k]) for k in range(40)])
    assert np.abs(kick() - expected).max() < 1e-5
    lift = kick(drag=0.0, friction=0.0)
    w = v - wind
    speed = np.linalg.norm(w, axis=1)
    sine = (w * n).sum(1) / speed
    assert np.abs((lift * w).sum(1)).max() < 1e-5  # lift is across the stream
    assert np.linalg.norm(lift, axis=1) == pytest.approx(2 * np.abs(sine) * np.sqrt(1 - sine**2) * speed**2, rel=1e-5)
    with pytest.raises(ga.UsageError, match="needs particles with the attribute area"):
        ga.ParticleSystem(position=np.zeros((1, 3)), forces=[ga.forces.Panel(density=1.0)])
    with pytest.raises(ga.UsageError, match="panel needs the fluid's density"):
        ga.ParticleSystem(
            position=np.zeros((1, 3)), forces=[ga.forces.Panel()], attributes={k: np.ones(1) for k in names}
        )


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_rotor_runs_at_the_speed_of_its_blade_elements(precision):
    """Free-running: the torque of the elements, integrated along the blade, is zero. The edges, 2 mm, brake as panels too."""
    pitch, wind = np.radians(15), 8.0
    r = 0.2 + (np.arange(4000) + 0.5) / 4000
    n, edge = np.array([np.cos(pitch), 0, -np.sin(pitch)]), np.array([np.sin(pitch), 0, np.cos(pitch)])

    def torque(spin):
        w = np.stack([0 * r - wind, 0 * r, spin * r], 1)
        return ((0.12 * thin_plate(w, n) + 0.002 * thin_plate(w, edge))[:, 2] * r).sum()

    slow, fast = 0.0, -100.0
    for _ in range(60):
        slow, fast = ((slow + fast) / 2, fast) if torque((slow + fast) / 2) < 0 else (slow, (slow + fast) / 2)
    assert 3 < -slow * 1.2 / wind < 4  # tip speed ratio
    found = []
    for begin in (0.98, 1.02):
        one = rotor(pitch, mass=0.1, points=900, spin=(begin * slow, 0, 0))
        sim = world([one], [ga.forces.Panel()], precision=precision, medium=ga.Medium(density=1.2, wind=(wind, 0, 0)))
        sim.step(120)
        found.append(inside(sim).w[0, 0])
    assert found[0] == pytest.approx(found[1], rel=1e-3)  # from either side
    assert found[0] == pytest.approx(slow, rel=1e-2)


# -- bits, snapshots, presets

PRESET = {
    "version": 1,
    "clock": {"duration": 1, "fps": 30, "step": "1/240"},
    "forces": {"gravity": [0, -9.81, 0]},
    "systems": {
        "blocks": {
            "integrator": "leapfrog",
            "interactions": {"rigid": {"restitution": 0.2, "friction": 0.4}},
            "colliders": {"plane": {"restitution": 0.2, "friction": "0.3..0.4"}},
            "emitters": {
                "wall": {
                    "body": {"shape": {"box": [0.2, 0.1, 0.1]}, "grid": [3, 2, 1], "pitch": [0.21, 0.101, 0.1],
                             "position": [0, 0.05, 0], "points": 60, "tint": "0..1"},
                },
                "ball": {"body": {"shape": {"sphere": 0.08}, "position": [-0.3, 0.1, 0.01], "velocity": [4, 0, 0], "points": 60}},
            },
            "look": {"draw": "sphere", "blend": "opaque", "emission": {"color": {"by": "tint", "range": "0..1", "gradient": "ice"},
                     "intensity": {"by": "shade", "range": "0..1", "curve": [[0, 0.1], [1, 1]]}}},
        }
    },
}  # fmt: skip


def test_a_preset_with_bodies_and_its_snapshot(tmp_path):
    """Laid by emitters in a grid; saved in the middle of a collision it goes on to the same bits."""
    preset = ga.load_preset(PRESET)
    sim = ga.Simulation(preset)
    blocks = sim["blocks"]
    assert blocks.interactions[0]._world.x.shape == (7, 3)
    assert sorted(np.unique(blocks.attribute("tint")).round(6)) == pytest.approx(
        [k * 0.6180339887 % 1 for k in (0, 5, 2, 4, 1, 3)]
    )
    assert 0.99 < np.linalg.norm([blocks.attribute(f"normal_{a}")[0] for a in "xyz"]) < 1.01
    assert blocks.attribute("shade").max() > 0.9
    sim.step(20)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    assert again.digest() == sim.digest()
    sim.step(20)
    again.step(20)
    assert again.digest() == sim.digest()
    assert np.abs(blocks.interactions[0]._world.v).max() > 0.1


def test_a_snapshot_of_bodies_made_in_python(tmp_path):
    sim = world(tower(3), floor=0.4, precision="f32")
    sim.step(5)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    sim.step(5)
    again.step(5)
    assert again.digest() == sim.digest()
    inside(again).L[0, 0] += 1e-9
    assert again.digest() != sim.digest()  # what particles do not hold is part of the state


SCRIPT = """
import sys
import gen_art as ga
r = [ga.body(s, position=(0.02 * k, 0.16 + 0.36 * k, 0.01 * k), points=700)
     for k, s in enumerate([{"box": [0.3, 0.3, 0.3]}, {"sphere": 0.15}, {"capsule": [0.2, 0.1]}, {"box": [0.4, 0.2, 0.3]}])]
system = ga.bodies(r).system(forces=[ga.forces.Gravity()], colliders=[ga.colliders.Plane(friction=0.4)], integrator="leapfrog")
sim = ga.Simulation({"b": system}, dt=1 / 240, threads=int(sys.argv[1]))
sim.step(40)
print(sim.digest())
"""


@pytest.mark.parametrize("threads", ["14", pytest.param("124", marks=pytest.mark.proof)])
def test_threads_do_not_change_bits(threads):
    import os
    import subprocess
    import sys
    from pathlib import Path

    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    runs = [subprocess.Popen([sys.executable, "-c", SCRIPT, n], stdout=subprocess.PIPE, env=env) for n in threads]
    digests = {run.communicate()[0] for run in runs}
    assert len(digests) == 1 and len(digests.pop()) > 60


def processors():
    """Environments that make OpenBLAS and NumPy compute as on processors with fewer features, by name; only this one's on others."""
    import platform

    out = {"this one": {}}
    if platform.machine() in ("x86_64", "AMD64"):
        found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
        wide = [feature for feature in found if "512" in feature or feature == "X86_V4"]
        if "X86_V3" in found or "AVX2" in found:
            out["without AVX-512"] = {"OPENBLAS_CORETYPE": "Haswell", "NPY_DISABLE_CPU_FEATURES": " ".join(wide)}
        out["without AVX"] = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": " ".join(found)}
    return out


CPU_SCRIPT = """
import sys
import numpy as np
import gen_art as ga
sim = ga.Simulation(ga.load_preset(sys.argv[1]), precision="f64")
sim.step(60)
a = np.random.default_rng(0).normal(size=(40, 40))
print(sim.digest(), hash((np.sin(a) @ np.exp(a)).tobytes()))
"""


@pytest.mark.parametrize("preset", ["course/mill", "course/tumble", pytest.param("galaxy", marks=pytest.mark.proof)])
def test_the_processor_does_not_change_bits(preset):
    """Whatever kernels BLAS and NumPy choose: the digests are the same, while a product by BLAS of sines (the mutant) is not."""
    import os
    import subprocess
    import sys
    from pathlib import Path

    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), "PYTHONHASHSEED": "0"}
    out = {}
    for name, features in processors().items():
        run = subprocess.run(
            [sys.executable, "-c", CPU_SCRIPT, preset], capture_output=True, text=True, env={**env, **features}
        )
        assert run.returncode == 0, run.stderr
        out[name] = run.stdout.split()
    assert len({digest for digest, _ in out.values()}) == 1, out
    if len({mutant for _, mutant in out.values()}) == 1:
        pytest.skip("OpenBLAS and NumPy compute alike in all three environments here: nothing is proved")


def test_other_particles_need_a_system_of_their_own():
    preset = {**PRESET, "systems": {"blocks": {**PRESET["systems"]["blocks"], "emitters": {
        **PRESET["systems"]["blocks"]["emitters"], "dust": {"count": 5}}}}}  # fmt: skip
    with pytest.raises(ga.UsageError, match="give other particles a system of their own"):
        ga.Simulation(ga.load_preset(preset))


def test_an_audit_leaves_bodies_whole():
    from gen_art.preset.thinning import thinned

    piece = ga.load_preset(PRESET)
    few, changes = thinned(piece, 0.1, 10)
    assert not changes and few == piece


def test_static_bodies_take_no_steps():
    """They change no bit of what moves beside them, which is then moved by several steps a launch.

    Mutants: systems that rest are stepped; a system rests although one of its bodies is free, or a particle is not fixed.
    """
    cloud = {
        "integrator": "leapfrog",
        "particle": {"radius": 0.01, "mass": 1, "lifetime": 0.5},
        "emitters": {"source": {"rate": 500, "velocity": {"sphere": 3}}},
    }
    post = {"body": {"shape": {"box": [1, 1, 1]}, "static": True, "position": [5, 0, 0], "points": 60}}
    ball = {"body": {"shape": {"sphere": 0.5}, "position": [9, 0, 0], "points": 60}}
    scenery = {"integrator": "leapfrog", "interactions": {"rigid": {}}, "emitters": {"post": post}}
    digests, launches = [], []
    for systems in (
        {"cloud": cloud},
        {"cloud": cloud, "scenery": scenery},
        {"cloud": cloud, "scenery": {**scenery, "emitters": {"post": post, "ball": ball}}},
    ):
        preset = ga.load_preset(
            {
                "version": 1,
                "seed": 2,
                "clock": {"duration": 1, "fps": 25, "step": "1/100"},
                "forces": {"gravity": [0, -9.81, 0]},
                "systems": systems,
            }
        )
        sim = ga.Simulation(preset, advice="none")
        stepper, counts = sim.stepper("cloud"), []

        def counted(first, steps, *rest, run=stepper.run, counts=counts):
            counts.append(steps)
            run(first, steps, *rest)

        stepper.run = counted
        start = sim.systems["scenery"].floats[:6].copy() if "scenery" in systems else None
        sim.step(60)
        digests.append(sim.digest("cloud"))
        launches.append(max(counts))
        if len(systems) == 2:
            moved = bool((sim.systems["scenery"].floats[:6] != start).any())
            assert moved == ("ball" in systems["scenery"]["emitters"])
    assert digests[0] == digests[1] == digests[2]
    assert launches[0] == launches[1] > 1 and launches[2] == 1


def test_bodies_that_a_user_does_not_fix_are_stepped_as_before():
    """Particles of static bodies that are not fixed gain the speed of their forces, since the bodies do not reset it."""
    group = ga.bodies([ga.body({"box": [1, 1, 1]}, static=True, points=60)])
    system = ga.ParticleSystem(
        position=group.position, velocity=group.velocity, mass=group.mass, radius=group.radius,
        attributes=group.attributes, forces=[ga.forces.Gravity((0, -9.81, 0))], interactions=[group.rigid()],
        integrator="leapfrog",
    )  # fmt: skip
    sim = ga.Simulation({"box": system}, dt=0.01)
    sim.step(2)
    assert sim.systems["box"].floats[4, 0] != 0


def test_a_free_body_moves_although_its_particles_are_fixed():
    """Mutants: a system of fixed particles rests whatever acts in it; it rests if one of its bodies is static."""
    bodies = [
        ga.body({"box": [1, 1, 1]}, static=True, points=60),
        ga.body({"sphere": 0.5}, position=(9, 0, 0), velocity=(1, 0, 0)),
    ]
    sim = ga.Simulation({"box": ga.bodies(bodies).system()}, dt=0.01)
    state = sim.systems["box"]
    state.floats[LIFETIME, : state.count] = FIXED
    state.has_fixed = True
    before = state.floats[:3, : state.count].copy()
    sim.step(2)
    assert (state.floats[0, : state.count] != before[0]).any()
