"""Sums over the living particles: mass, charge, momentum, angular momentum, energy.

They are computed in float64, in fixed blocks and a fixed order, so they do not depend on the number of threads.

The one-letter names in kernels are in docs/glossary.md.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.html_table import html_table, vector_text
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.particle_tile import TileTerms, repeats, view
from gen_art.particles.rows import CHARGE, MASS, PX, PY, PZ, VX, VY, VZ

__all__ = ["Diagnostics", "diagnose", "energy_of_pairs", "sums"]

_BLOCK = 1024  # particles that one thread sums
# columns of `sums`
COUNT, TOTAL_MASS, TOTAL_CHARGE = 0, 1, 2
_P, _L, _MX = 3, 6, 9  # first columns of the vectors
MOMENTUM = slice(_P, _P + 3)
ANGULAR_MOMENTUM = slice(_L, _L + 3)
MASS_TIMES_POSITION = slice(_MX, _MX + 3)
KINETIC_ENERGY = 12
BASIC_COLUMNS = 13  # then a column for each potential
POTENTIALS = slice(BASIC_COLUMNS, None)
ENERGY = slice(KINETIC_ENERGY, None)


@dataclass(frozen=True)
class Diagnostics:
    """Sums over all living particles, in SI units unless the preset says otherwise; vectors are (3,) float64 arrays.

    time : simulated time, s
    count : number of living particles
    mass : kg
    charge : C
    momentum : N s; gamma m v with a speed of light
    angular_momentum : about the origin, N m s; in a periodic box it jumps where a particle is wrapped
    center_of_mass : m; NaN without mass; in a periodic box the mean of positions in it, which jumps where a particle is wrapped
    kinetic_energy : J; (gamma - 1) m c^2 with a speed of light
    potential_energy : of time-independent potentials, each pair counted once, J; in a periodic box pairs of nearest images
    """

    time: float
    count: int
    mass: float
    charge: float
    momentum: np.ndarray
    angular_momentum: np.ndarray
    center_of_mass: np.ndarray
    kinetic_energy: float
    potential_energy: float

    @property
    def energy(self) -> float:
        """Kinetic plus time-independent potential energy, each pair counted once."""
        return self.kinetic_energy + self.potential_energy

    def as_dict(self) -> dict:
        """Plain numbers and lists, the energy included."""
        plain = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(self).items()}
        return {**plain, "energy": self.energy}

    def _repr_html_(self) -> str:
        """What a notebook shows: each sum with its unit."""
        rows = [
            ("Particles", f"{self.count:,}", ""),
            ("Mass", f"{self.mass:.8g}", "kg"),
            ("Charge", f"{self.charge:.8g}", "C"),
            ("Momentum", vector_text(self.momentum), "N s"),
            ("Angular momentum", vector_text(self.angular_momentum), "N m s"),
            ("Centre of mass", vector_text(self.center_of_mass), "m"),
            ("Kinetic energy", f"{self.kinetic_energy:.8g}", "J"),
            ("Potential energy", f"{self.potential_energy:.8g}", "J"),
            ("Energy", f"{self.energy:.8g}", "J"),
        ]
        return html_table(f"Diagnostics at {self.time:g} s, in SI units unless the preset says otherwise", rows)


@cache
def _kernel(composition: KernelTerms, channels: tuple, precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, channels, 0, real)

    @ti.kernel
    def measure(
        S: matrix, birth: ti.types.ndarray(ti.f64, 1), K: ti.types.ndarray(ti.u32, 2), Q: vector, time: ti.f64,
        slots: ti.types.ndarray(ti.i32, 1), light: ti.f64, out: ti.types.ndarray(ti.f64, 2),
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range(out.shape[0]):
            for k in range(b * _BLOCK, ti.min((b + 1) * _BLOCK, slots.shape[0])):
                i = slots[k]
                x = ti.Vector([S[PX, i], S[PY, i], S[PZ, i]])
                v = ti.Vector([S[VX, i], S[VY, i], S[VZ, i]])
                X, V = ti.cast(x, ti.f64), ti.cast(v, ti.f64)
                m = ti.cast(S[MASS, i], ti.f64)
                kinetic = ti.cast(0.5, ti.f64) * V.dot(V)
                if light > 0.0:  # momentum gamma m v, kinetic energy (gamma - 1) m c^2
                    g = ti.cast(1.0, ti.f64) / ti.sqrt(ti.cast(1.0, ti.f64) - V.dot(V) / (light * light))
                    kinetic = V.dot(V) * g * g / (g + ti.cast(1.0, ti.f64))
                    V *= g
                L = X.cross(V) * m
                out[b, COUNT] = out[b, COUNT] + ti.cast(1.0, ti.f64)
                out[b, TOTAL_MASS] = out[b, TOTAL_MASS] + m
                out[b, TOTAL_CHARGE] = out[b, TOTAL_CHARGE] + ti.cast(S[CHARGE, i], ti.f64)
                for c in ti.static(range(3)):
                    out[b, _P + c] = out[b, _P + c] + m * V[c]
                    out[b, _L + c] = out[b, _L + c] + L[c]
                    out[b, _MX + c] = out[b, _MX + c] + m * X[c]
                out[b, KINETIC_ENERGY] = out[b, KINETIC_ENERGY] + m * kinetic
                age = ti.cast(time - birth[i], real)
                for j, term in ti.static(enumerate(terms.potentials)):
                    for repeat in range(repeats(Q, term.count_offset)):
                        p = view(terms, S, K, i, x, v, age)
                        q = parameters(Q, term.force, term.offset, repeat)
                        U = term.force.potential(p, ti.cast(time, real), q)
                        out[b, BASIC_COLUMNS + j] = out[b, BASIC_COLUMNS + j] + ti.cast(U, ti.f64)

    return runtime.kernel(measure, precision)


def sums(sim, name: str, slots: np.ndarray) -> np.ndarray:
    """The basic sums and the energy of each potential over some slots of one system: (13 + potentials,) float64."""
    system = sim.members[name]
    state = system.state
    width = BASIC_COLUMNS + len(system.composition.potentials)
    if not len(slots):
        return np.zeros(width)
    out = np.zeros((-(-len(slots) // _BLOCK), width))
    kernel = _kernel(system.composition, state.attributes, sim.precision)
    kernel(
        state.floats, state.birth, state.key, sim.stepper(name).numbers, sim.time, slots.astype(np.int32),
        system.scheme.light, out,
    )  # fmt: skip
    return out.sum(axis=0)


def energy_of_pairs(sim, name: str, slots: np.ndarray) -> float:
    """Potential energy of a system's mutual forces over some slots, J."""
    system = sim.members[name]
    state, total = system.state, 0.0
    for interaction in system.interactions:
        if interaction.source_system is None:
            total += interaction.energy(state, slots, sim.precision)
    return total


def diagnose(sim, names: Iterable[str] | None = None) -> Diagnostics:
    """The sums over every living particle of the systems with these names, or of all systems, now."""
    basic, potential = np.zeros(BASIC_COLUMNS), 0.0
    for name in sim.members if names is None else names:
        slots = sim.living(name)
        part = sums(sim, name, slots)
        basic += part[:BASIC_COLUMNS]
        potential += float(part[BASIC_COLUMNS:].sum()) + energy_of_pairs(sim, name, slots)
    mass = float(basic[TOTAL_MASS])
    center = basic[MASS_TIMES_POSITION] / mass if mass > 0 else np.full(3, np.nan)
    return Diagnostics(
        sim.time, int(basic[COUNT]), mass, float(basic[TOTAL_CHARGE]), basic[MOMENTUM].copy(),
        basic[ANGULAR_MOMENTUM].copy(), center, float(basic[KINETIC_ENERGY]), potential,
    )  # fmt: skip
