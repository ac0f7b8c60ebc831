"""A force's vectors and potential at given states, straight from its own functions, for comparison with NumPy."""

from functools import cache
from types import SimpleNamespace

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.forces.base import term_acceleration
from gen_art.forces.medium import Medium
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.particle_tile import TileTerms, view

FLOW = (0.3, -0.2, 0.1)  # the velocity of the medium, for forces that look at it


def states(n: int = 64, seed: int = 1) -> SimpleNamespace:
    """n particles about the origin with every attribute set."""
    r = np.random.default_rng(seed)
    return SimpleNamespace(
        position=r.normal(size=(3, n)), velocity=r.normal(size=(3, n)), mass=r.uniform(0.5, 2, n),
        charge=r.uniform(0.5, 2, n), radius=r.uniform(0.1, 0.3, n), age=r.uniform(0, 2, n), time=0.7,
        key=r.integers(0, 2**32, (2, n), dtype=np.uint32), flow=np.array(FLOW)[:, None],
        area=r.uniform(0.5, 2, n), normal_x=r.normal(size=n), normal_y=r.normal(size=n), normal_z=r.normal(size=n),
    )  # fmt: skip


def probe(force, p, precision="f64", medium=None):
    """(acceleration (3, n), magnetic (3, n), damping (2, n), potential (n,)) of one force at the states p."""
    dtype = np.float64 if precision == "f64" else np.float32
    composition = KernelTerms([force], medium or Medium())
    n = p.position.shape[1]
    needs = sorted(force.needs)
    S = np.zeros((10 + len(needs), n), dtype)
    for k, name in enumerate(needs):
        S[10 + k] = getattr(p, name)
    S[0:3], S[3:6], S[6], S[7], S[8], S[9] = p.position, p.velocity, p.mass, p.charge, p.radius, np.inf
    out = np.zeros((9, n), dtype)
    count = force.values[force.repeat] if force.repeat else 1
    assert composition.terms[0].offset == 0 or medium is not None
    _kernel(composition, precision)(S, p.key, p.age.astype(dtype), composition.numbers(dtype), p.time, out, count)
    return out[:3], out[3:6], out[6:8], out[8]


@cache
def _kernel(composition, precision):
    """One for each class and its choices: numbers are run-time data here as they are in the step."""
    real, force = runtime.DTYPES[precision], composition.terms[0].force
    terms = TileTerms(composition, tuple(sorted(force.needs)), 0, real)
    kinds = {k: force.provides(k) for k in ("acceleration", "force", "electric", "magnetic", "damping", "potential")}
    pushes = kinds["acceleration"] or kinds["force"] or kinds["electric"]

    @ti.kernel
    def kernel(
        S: ti.types.ndarray(real, 2), K: ti.types.ndarray(ti.u32, 2), A: ti.types.ndarray(real, 1),
        Q: ti.types.ndarray(real, 1), t: real, out: ti.types.ndarray(real, 2), count: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range(1):
            for i in range(S.shape[1]):
                for k in range(count):
                    x = ti.Vector([S[0, i], S[1, i], S[2, i]])
                    v = ti.Vector([S[3, i], S[4, i], S[5, i]])
                    q = parameters(Q, force, 0, k)
                    p = view(terms, S, K, i, x, v, A[i], ti.Vector(FLOW), None, (A[i], 0.1))
                    if ti.static(pushes):
                        a = term_acceleration(force, p, t, q)
                        for c in ti.static(range(3)):
                            out[c, i] = out[c, i] + a[c]
                    if ti.static(kinds["magnetic"]):
                        field = force.magnetic(p, t, q)
                        for c in ti.static(range(3)):
                            out[3 + c, i] = field[c]
                    if ti.static(kinds["damping"]):
                        rates = force.damping(p, t, q)
                        out[6, i], out[7, i] = rates[0], rates[1]
                    if ti.static(kinds["potential"]):
                        out[8, i] = force.potential(p, t, q)

    return runtime.kernel(kernel, precision)
