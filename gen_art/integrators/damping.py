"""Drag and damping in a kick, in closed form.

The exponential of a kick's length is the costly part. Where the damping is the same for all particles, it is computed once a
block for each stage (`stage_gains`), and again only for tiles in which a lane takes a part of the step (`find_gains`).

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.kernel_views import parameters, particle, traced
from gen_art.backend.runtime import impl, ti
from gen_art.integrators.lanes import WIDTH, age_of, step_of, time_of
from gen_art.integrators.particle_tile import flow_velocity, stage_view
from gen_art.integrators.schemes import KICK, STAGE
from gen_art.maths.elementary import phi

__all__ = ["accelerated", "damping_rate", "damping_rates", "find_gains", "stage_gains"]


@ti.func
def damping_rates(
    terms: ti.template(), L: ti.template(), x, v, S: ti.template(), K: ti.template(), Q: ti.template(), i, j, tau
):  # fmt: skip
    """The linear and the quadratic rate, 1/s and 1/m, of each damping in lane j at the place x with velocity v, a row each."""
    rates = ti.Matrix([[0.0, 0.0]] * ti.static(max(len(terms.dampings), 1)))
    for d, term in ti.static(enumerate(terms.dampings)):
        p = stage_view(terms, S, K, L, i, j, x, v, age_of(L, j) + tau * step_of(L, j))
        both = term.force.damping(p, time_of(L, j) + tau * step_of(L, j), parameters(Q, term.force, term.offset))
        rates[d, 0], rates[d, 1] = both[0], both[1]
    return rates


@ti.func
def damping_rate(terms: ti.template(), L: ti.template(), d: ti.template(), j, rates, w):
    """The rate, 1/s, of damping d at the velocity w."""
    k = rates[d, 0]
    if ti.static(terms.dampings[d].force.quadratic_damping):
        k += rates[d, 1] * (w - flow_velocity(terms, L, terms.dampings[d].medium, j)).norm()
    return k


@ti.func
def uniform_gain(terms: ti.template(), Q: ti.template(), h):
    """(1 - e^(-k h)) / k, s, with the sum k of all rates, which are the same for all particles."""
    rate = h * 0.0
    for term in ti.static(terms.dampings):
        rate += term.force.damping(particle(), h * 0.0, parameters(Q, term.force, term.offset))[0]
    return h * phi(rate * h)


@ti.func
def stage_gains(terms: ti.template(), F: ti.template(), Q: ti.template(), P: ti.template(), dt):
    """Write the gain of each stage's kick over a whole step dt to F."""
    if ti.static(terms.uniform_damping):
        for g in range((P.shape[0] - 1) // STAGE):
            F.gain[g] = uniform_gain(terms, Q, P[KICK + STAGE * g] * dt)


@ti.func
def find_gains(terms: ti.template(), L: ti.template(), F: ti.template(), Q: ti.template(), g, fraction):
    """Find each lane's gain in the kick of stage g, which takes a fraction of its step."""
    if ti.static(terms.uniform_damping):
        if ti.static(not terms.lifespans):
            _same_gain(L, F.gain[g])
        elif L.whole:
            for j in range(WIDTH):
                L.gain[j] = ti.select(L.h[j] == 0.0, 0.0, F.gain[g])
        else:
            for j in range(WIDTH):
                L.gain[j] = uniform_gain(terms, Q, fraction * L.h[j])


@traced
def _same_gain(L, gain):
    L.gain = impl.expr_init(gain)


@traced
def gain_of(L, j):
    """The gain of lane j that `find_gains` has found."""
    return impl.subscript(None, L.gain, j) if L.lifespans else L.gain


@ti.func
def damped(terms: ti.template(), L: ti.template(), j, rates, v, w, h):
    """The exact solution of dv/dt = a + sum k_i (u_i - v) over h, with constant k_i = rate_i + quadratic_i abs(w - u_i)."""
    rate = h * 0.0
    drive = ti.Vector([L.a0[j], L.a1[j], L.a2[j]])
    for d, term in ti.static(enumerate(terms.dampings)):
        k = damping_rate(terms, L, d, j, rates, w)
        rate += k
        if ti.static(len(terms.media[term.medium]) > 0):
            drive += k * flow_velocity(terms, L, term.medium, j)
    gain = h * 0.0
    if ti.static(terms.uniform_damping):
        gain = gain_of(L, j)
    else:
        gain = h * phi(rate * h)
    return v + gain * (drive - rate * v)


@ti.func
def accelerated(terms: ti.template(), L: ti.template(), j, rates, v, h):
    """v after acceleration and drag over h. The quadratic rate is that of the predicted middle: order 2, terminal speed exact."""
    result = v + h * ti.Vector([L.a0[j], L.a1[j], L.a2[j]])
    if ti.static(len(terms.dampings) > 0):
        middle = v
        if ti.static(terms.quadratic):
            middle = damped(terms, L, j, rates, v, v, 0.5 * h)
        result = damped(terms, L, j, rates, v, middle, h)
    return result
