"""How fast are light steps, turbulence, magnetic fields, births and deaths beside numba, with one and sixteen steps a launch?"""

import numpy as np
from _bench import Bench, alternate

import gen_art as ga
from gen_art.backend import runtime
from gen_art.backend.runtime import aligned
from gen_art.maths.random import channel_of
from gen_art.preset import load_preset

bench = Bench("launches", __doc__)
F = np.float32
LIGHT, HEAVY, ROUNDS, BIRTH_ROUNDS = (20_000, 20_000, 1, 1) if bench.quick else (4_000_000, 1_000_000, 9, 63)
H, RATE, GRAVITY = 1e-3, 0.3, (0.0, -9.81, 0.0)
NOISE = {"strength": 2.0, "scale": 1.3, "speed": 0.7, "gain": 0.5, "lacunarity": 2.0, "seed": 5}
FIELD, MOMENT, SOFTENING = (0.0, 0.0, 2.0), (0.0, 0.0, 3e7), 0.1
bench.settings = {
    "particles": [LIGHT, HEAVY], "rounds": ROUNDS, "rounds with births": BIRTH_ROUNDS,
    "step": H, "gravity": GRAVITY, "damping": RATE, "noise": NOISE,
    "magnetic field": FIELD, "dipole": MOMENT, "softening": SOFTENING,
}  # fmt: skip
try:
    import _numba
except ImportError:
    _numba = None
    print("  numba is not installed and is left out")


def system(n: int, forces: list, integrator: str, **more) -> tuple[ga.Simulation, np.ndarray]:
    """A simulation of n particles at random, and a copy of their positions and velocities for a peer, (6, n)."""
    r = np.random.default_rng(0)
    start = {"position": r.uniform(-5, 5, (n, 3)), "velocity": r.normal(0, 2, (n, 3))}
    sim = ga.Simulation({"s": ga.ParticleSystem(**start, forces=forces, integrator=integrator, **more)}, dt=H)
    return sim, sim["s"]._state.floats[:6, :n].copy()


def bandwidth() -> float:
    """Bytes a second, read and written: a kernel that adds to 400 MB of vectors."""
    from gen_art.backend.runtime import ti

    vectors = ti.types.ndarray(ti.types.vector(16, ti.f32), 1)

    @ti.kernel
    def add(V: vectors, n: ti.i32):
        ti.loop_config(block_dim=1)
        for b in range(n // 1024):
            for i in range(b * 1024, (b + 1) * 1024):
                V[i] = V[i] + V[i]

    count = 2**14 if bench.quick else 3 * 2**21
    memory, run = aligned((count, 16), F), runtime.kernel(add, "f32", vectors=True)
    return 2 * memory.nbytes / alternate(ROUNDS, add=lambda: run(memory, count))["add"]


gravity, damping = ga.forces.Gravity(GRAVITY), ga.forces.Damping(RATE)
magnets = [ga.forces.MagneticField(FIELD), ga.forces.MagneticDipole(MOMENT, softening=SOFTENING)]


def turbulence(octaves: int) -> list:
    return [gravity, damping, ga.forces.CurlNoise(**NOISE, octaves=octaves)]


works = {  # name: particles, steps a launch, forces, integrator, peer, bound: ratio to numba
    "gravity, damping": (LIGHT, 1, [gravity, damping], "leapfrog", "light", 0.7),
    "gravity, damping, 16 steps": (LIGHT, 16, [gravity, damping], "leapfrog", "light", 3.0),
    "+ curl noise, 1 octave": (HEAVY, 1, turbulence(1), "position_verlet", "curl", 2.5),
    "+ curl noise, 3 octaves": (HEAVY, 1, turbulence(3), "position_verlet", "curl", 3.0),
    "Boris, field and dipole": (HEAVY, 1, magnets, "boris", "boris", 0.8),
    "Boris, 4 steps": (HEAVY, 4, magnets, "boris", "boris", 1.2),
    "Boris, 16 steps": (HEAVY, 16, magnets, "boris", "boris", 1.5),
}
runtime.init()
memory = bandwidth()
rows = [("", "gen_art, M/s", "numba, M/s", "ratio", "floor", "share of it", "differ by")]
for name, (n, steps, forces, integrator, peer, bound) in works.items():
    sim, S = system(n, forces, integrator, **({"charge": 0.7} if peer == "boris" else {}))
    things, apart = {"gen_art": lambda sim=sim, steps=steps: sim.step(steps)}, 0.0
    if _numba:
        first = [0]

        def other(S=S, steps=steps, peer=peer, forces=forces, first=first):
            if peer == "light":
                _numba.numba_light(S, np.array(GRAVITY, F), F(RATE), F(H), steps)
            elif peer == "boris":
                _numba.numba_boris(S, np.array(FIELD, F), np.array(MOMENT, F), F(SOFTENING**2), F(0.7), F(H), steps)
            else:
                octaves = forces[-1].values["octaves"]
                _numba.numba_turbulent(S, {**NOISE, "octaves": octaves}, GRAVITY, RATE, first[0] * H, H)
            first[0] += steps

        other()
        sim.step(steps)
        ours = sim["s"]._state.floats[:6, :n]
        apart = float(np.abs(S - ours).max() / np.abs(ours).max())
        assert apart < 1e-5, f"numba does not take the same steps: {apart:.1e} apart"
        things["numba"] = other
    rate = {one: n * steps / taken / 1e6 for one, taken in alternate(ROUNDS, **things).items()}
    floor = memory / 48 / 1e6 * steps  # six floats read and six written a launch
    ratio = rate["gen_art"] / rate["numba"] if _numba else float("nan")
    share = f"{rate['gen_art'] / floor:.2f}"
    row = (f"{rate['gen_art']:.0f}", f"{rate.get('numba', 0):.0f}", f"{ratio:.2f}", f"{floor:.0f} M/s", share)
    rows.append((name, *row, f"{apart:.0e}"))
    bench.figures[name] = {"million steps a second": rate, "floor by memory": floor, "differ by": apart}
    if _numba:
        bench.require(f"{name}: times as fast as numba", ratio, at_least=bound)

# a million alive: as many are born and die in a step as in a film with a lifetime of a second
n, life = (20_000, 60) if bench.quick else (1_000_000, 60)
fountain = {
    "particle": {"lifetime": f"{0.5 * life * H:g}..{1.5 * life * H:g}"}, "integrator": "leapfrog",
    "emitters": {"nozzle": {"rate": n / (life * H), "velocity": {"cone": [0, 1, 0], "angle": 10, "speed": "3..4"}}},
}  # fmt: skip
laws = {"gravity": list(GRAVITY), "damping": RATE}
clock = {"duration": 10, "fps": 1 / H, "step": H}
born = ga.Simulation(load_preset({"version": 1, "clock": clock, "forces": laws, "systems": {"s": fountain}}))
born.step(3 * life // 2)
kept, _ = system(born["s"].count, [gravity, damping], "leapfrog")
things, apart = {"births": lambda: born.step(1), "without": lambda: kept.step(1)}, ""
if _numba:
    lives, dt = (0.5 * life * H, 1.5 * life * H), born.dt
    key, channel = born["s"].emitters[0].key, channel_of("lifetime")
    peer = _numba.NumbaFountain(2 * n, key, n / (life * H), lives, channel, np.radians(10), (3, 4))
    for _ in range(born.steps_done):
        peer.step(np.array(GRAVITY, F), F(RATE), dt)
    alive = peer.birth[: peer.n] + peer.life[: peer.n].astype(float) > born.time
    ours = born["s"].position.T
    assert ours.shape[1] == alive.sum(), "numba has other particles"
    apart = float(np.abs(peer.S[:3, : peer.n][:, alive] - ours).max() / np.abs(ours).max())
    assert apart < 1e-5, f"numba does not take the same steps: {apart:.1e} apart"
    things["numba"] = lambda: peer.step(np.array(GRAVITY, F), F(RATE), dt)
taken = alternate(BIRTH_ROUNDS, **things)
rate = {one: n / taken[one] / 1e6 for one in things if one != "without"}
ratio = f"{rate['births'] / rate['numba']:.2f}" if _numba else ""
times = taken["births"] / taken["without"]
floor = memory / (48 + 12) / 1e6  # the lifespan too: eight bytes of birth and four of lifetime are read
share = f"{times:.2f}x the step without"
row = (f"{rate['births']:.0f}", f"{rate.get('numba', 0):.0f}", ratio, f"{floor:.0f} M/s", share)
rows.append(("births and deaths", *row, f"{apart:.0e}" if _numba else ""))
bench.figures["births and deaths"] = {
    "seconds a step": taken, "alive": born["s"].count, "floor by memory": floor, "differ by": apart
}  # fmt: skip
bench.require("a step with births over one without", times, at_most=1.25)
bench.table(rows)
bench.figures |= {"threads": runtime.threads(), "bytes a second": memory}
bench.finish()
