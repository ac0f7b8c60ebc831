"""Whether the potential of a user's force is the force's: minus its gradient against the force, where the particles are.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import has_acceleration, term_acceleration
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.particle_tile import TileTerms, repeats, view
from gen_art.kernel_methods import is_own
from gen_art.particles.rows import MASS, POSITION, PX, PY, PZ, VX, VY, VZ

__all__ = ["check_potentials"]

_POINTS = 24  # particles, at most
_STEP = 1e-5  # of the differences, relative to the coordinates
_TOLERANCE = 1e-3  # of the largest force


@cache
def _kernel(composition: KernelTerms, channels: tuple):
    matrix, real = ti.types.ndarray(ti.f64, 2), ti.f64
    terms = TileTerms(composition, channels, 0, real)

    @ti.kernel
    def measure(
        S: matrix, birth: ti.types.ndarray(ti.f64, 1), K: ti.types.ndarray(ti.u32, 2), Q: ti.types.ndarray(ti.f64, 1),
        time: ti.f64, out: matrix,
    ):  # fmt: skip
        ti.loop_config(serialize=True)
        for i in range(out.shape[1]):
            x, v = ti.Vector([S[PX, i], S[PY, i], S[PZ, i]]), ti.Vector([S[VX, i], S[VY, i], S[VZ, i]])
            p = view(terms, S, K, i, x, v, time - birth[i])
            F, U = x * 0.0, x[0] * 0.0
            for term in ti.static(terms.accelerations):
                for repeat in range(repeats(Q, term.count_offset)):
                    F += term_acceleration(term.force, p, time, parameters(Q, term.force, term.offset, repeat)) * p.mass
            for term in ti.static(terms.potentials):
                for repeat in range(repeats(Q, term.count_offset)):
                    U += term.force.potential(p, time, parameters(Q, term.force, term.offset, repeat))
            for c in ti.static(range(3)):
                out[c, i] = F[c]
            out[3, i] = U

    return runtime.kernel(measure, "f64")


def check_potentials(sim) -> None:
    """Compare the potentials of users' forces with central differences, where particles live.

    Raises UsageError that names the force and a place where the two differ by more than a thousandth of the largest force.
    """
    for name, system in sim.members.items():
        forces = [f for f in system.forces if not is_own(type(f)) and f.provides("potential") and has_acceleration(f)]
        living = sim.living(name)
        if not forces or not len(living):
            continue
        slots = living[np.unique(np.linspace(0, len(living) - 1, min(len(living), _POINTS)).astype(int))]
        for force in forces:
            _check(force, name, system, slots, sim.time)


def _check(force, name: str, system, slots: np.ndarray, time: float) -> None:
    state, n = system.state, len(slots)
    composition = KernelTerms([force], system.medium)
    S = np.repeat(state.floats[:, slots].astype(np.float64), 7, axis=1)
    # columns: each particle at its place, then displaced to both sides along each axis
    place = np.tile(np.arange(7), n)
    size = _STEP * np.maximum(np.abs(S[POSITION]).max(axis=0), 1e-3)
    for c in range(3):
        S[c] += size * ((place == 1 + 2 * c).astype(float) - (place == 2 + 2 * c))
    birth, keys = np.repeat(state.birth[slots], 7), np.repeat(state.key[:, slots], 7, axis=1)
    out = np.zeros((4, 7 * n))
    _kernel(composition, state.attributes)(
        S, birth, np.ascontiguousarray(keys), composition.numbers(np.float64), time, out
    )
    F, U = out[:3, ::7], out[3].reshape(n, 7)
    with np.errstate(all="ignore"):
        gradient = np.stack([U[:, 1 + 2 * c] - U[:, 2 + 2 * c] for c in range(3)]) / (2 * size[::7])
        difference = np.sqrt(((F + gradient) ** 2).sum(axis=0))
        # the differences of U lose digits
        noise = 8 * np.finfo(np.float64).eps * np.abs(U).max(axis=1) / size[::7]
        allowed = _TOLERANCE * max(
            float(np.sqrt((F**2).sum(0)).max()), float(np.sqrt((gradient**2).sum(0)).max()), 1e-300
        )
    wrong = np.flatnonzero(np.isfinite(difference) & (difference > allowed + noise) & (state.floats[MASS, slots] > 0))
    # a few places may lie on an edge, where the force jumps
    if len(wrong) > max(1, n // 4) or (len(wrong) and n == 1):
        k = wrong[0]

        def text(vector):
            return f"({', '.join(f'{float(c):.4g}' for c in vector)})"

        raise UsageError(
            f"{type(force).__name__}: its potential is not that of its force: at {text(S[POSITION, 7 * k])} m in '{name}' the "
            f"force is {text(F[:, k])} N and minus the potential's gradient {text(-gradient[:, k])} N; is a sign, a factor or "
            "p.mass missing?"
        )
