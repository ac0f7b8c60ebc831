"""Sums over the living: mass, charge, momentum, angular momentum, energy. In float64, in fixed blocks and a fixed order."""

from dataclasses import asdict, dataclass
from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.tile import TileTerms, repeats, view
from gen_art.particles.rows import CHARGE, MASS, PX, PY, PZ, VX, VY, VZ

__all__ = ["Diagnostics", "diagnose", "energy_of_pairs", "sums"]

_BLOCK = 1024
_BASIC = (
    13  # count, mass, charge, momentum 3, angular momentum 3, mass x position 3, kinetic energy; then the potentials
)


@dataclass(frozen=True)
class Diagnostics:
    """The state in numbers, SI units unless the preset says otherwise; vectors are (3,) float64 arrays."""

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


@cache
def _kernel(composition: KernelTerms, channels: tuple, precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, channels, 0, real=real)

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
                out[b, 0] = out[b, 0] + ti.cast(1.0, ti.f64)
                out[b, 1] = out[b, 1] + m
                out[b, 2] = out[b, 2] + ti.cast(S[CHARGE, i], ti.f64)
                for c in ti.static(range(3)):
                    out[b, 3 + c] = out[b, 3 + c] + m * V[c]
                    out[b, 6 + c] = out[b, 6 + c] + L[c]
                    out[b, 9 + c] = out[b, 9 + c] + m * X[c]
                out[b, 12] = out[b, 12] + m * kinetic
                age = ti.cast(time - birth[i], real)
                for j, term in ti.static(enumerate(terms.potentials)):
                    for repeat in range(repeats(Q, term.count_offset)):
                        p = view(terms, S, K, i, x, v, age)
                        q = parameters(Q, term.force, term.offset, repeat)
                        U = term.force.potential(p, ti.cast(time, real), q)
                        out[b, _BASIC + j] = out[b, _BASIC + j] + ti.cast(U, ti.f64)

    return runtime.kernel(measure, precision)


def sums(sim, name: str, slots: np.ndarray) -> np.ndarray:
    """The basic sums and each potential's energy over some slots of one system: (13 + potentials,) float64."""
    system = sim.members[name]
    state = system.state
    width = _BASIC + len(system.composition.potentials)
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
    for one in system.interactions:
        if one.source_system is None:
            total += one.energy(state, slots, sim.precision)
    return total


def diagnose(sim) -> Diagnostics:
    """The sums over every living particle of every system, now."""
    basic, potential = np.zeros(_BASIC), 0.0
    for name in sim.members:
        slots = sim.living(name)
        part = sums(sim, name, slots)
        basic += part[:_BASIC]
        potential += float(part[_BASIC:].sum()) + energy_of_pairs(sim, name, slots)
    mass = float(basic[1])
    center = basic[9:12] / mass if mass > 0 else np.full(3, np.nan)
    return Diagnostics(
        sim.time, int(basic[0]), mass, float(basic[2]), basic[3:6].copy(), basic[6:9].copy(), center,
        float(basic[12]), potential,
    )  # fmt: skip
