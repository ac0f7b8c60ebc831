"""The gyration frequency of charged particles in the magnetic fields at their positions.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.particle_tile import TileTerms, repeats, view
from gen_art.particles.rows import CHARGE, MASS, PX, PY, PZ, VELOCITY, VX, VY, VZ

__all__ = ["largest_turn"]


@cache
def _kernel(composition: KernelTerms, channels: tuple, precision: str):
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, channels, 0, real)

    @ti.kernel
    def measure(
        S: matrix, birth: ti.types.ndarray(ti.f64, 1), K: ti.types.ndarray(ti.u32, 2), Q: vector, time: ti.f64,
        slots: ti.types.ndarray(ti.i32, 1), out: vector,
    ):  # fmt: skip
        ti.loop_config(serialize=True)
        for k in range(slots.shape[0]):
            i = slots[k]
            x = ti.Vector([S[PX, i], S[PY, i], S[PZ, i]])
            v = ti.Vector([S[VX, i], S[VY, i], S[VZ, i]])
            p = view(terms, S, K, i, x, v, ti.cast(time - birth[i], real))
            B = x * 0.0
            for term in ti.static(terms.magnetics):
                for repeat in range(repeats(Q, term.count_offset)):
                    B += term.force.magnetic(p, ti.cast(time, real), parameters(Q, term.force, term.offset, repeat))
            out[k] = B.norm() * ti.abs(S[CHARGE, i]) / S[MASS, i]

    return runtime.kernel(measure, precision)


def largest_turn(sim, name: str) -> float:
    """The largest abs(q B) / (gamma m) of a system's living particles, 1/s; 0 without magnetic fields."""
    system, slots = sim[name], sim.living(name)
    if not system.composition.magnetics or not len(slots):
        return 0.0
    state = system.state
    out = np.zeros(len(slots), state.floats.dtype)
    kernel = _kernel(system.composition, state.attributes, sim.precision)
    kernel(
        state.floats, state.birth, state.key, sim.stepper(name).numbers, sim.time, slots.astype(np.int32), out
    )  # fmt: skip
    light = system.scheme.light
    speed = np.linalg.norm(state.floats[VELOCITY, slots], axis=0)
    gamma = 1 / np.sqrt(1 - (speed / light) ** 2) if light else 1.0
    return float((out / gamma).max())
