"""A kick: the change of a tile's velocities by acceleration, drag and magnetic force, with the sums of `accumulate`.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.integrators.damping import accelerated, damping_rates
from gen_art.integrators.lanes import WIDTH, step_of
from gen_art.integrators.particle_tile import place, specific_charge
from gen_art.integrators.pushers import phase_corrected, relativistic
from gen_art.integrators.thermal_noise import add_noise

__all__ = ["kick"]


@ti.func
def rotated(v, omega, h):
    """v rotated about omega by the angle 2 atan(abs(omega) h / 2): Boris's rotation, which keeps abs(v)."""
    t = omega * (0.5 * h)
    s = t * (2.0 / (1.0 + t.dot(t)))
    return v + (v + v.cross(t)).cross(s)


@ti.func
def kick(
    terms: ti.template(), L: ti.template(), X: ti.template(), S: ti.template(), K: ti.template(), Q: ti.template(), i,
    fraction, light, step, tau,
):  # fmt: skip
    """Advance the tile's velocities by a fraction of each lane's step, with the sums of `accumulate` in L.

    light : speed of light, m/s
    step, tau : number of the step, and the time of the kick in it, in steps
    """
    for j in range(WIDTH):
        v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
        h = fraction * step_of(L, j)
        rates = damping_rates(terms, L, place(terms, X, Q, j), v, S, K, Q, i, j, tau)
        if ti.static(terms.keeps_rates):
            for d in ti.static(range(len(terms.dampings))):
                L.at("k", d)[j], L.at("q", d)[j] = rates[d, 0], rates[d, 1]
        if ti.static(terms.relativistic):
            omega = v * 0.0
            if ti.static(len(terms.magnetics) > 0):
                omega = ti.Vector([L.b0[j], L.b1[j], L.b2[j]]) * specific_charge(terms, L, S, i, j)
            v = relativistic(terms, v, ti.Vector([L.a0[j], L.a1[j], L.a2[j]]), omega, h, light)
        elif ti.static(len(terms.magnetics) == 0):
            v = accelerated(terms, L, j, rates, v, h)
        else:
            omega = ti.Vector([L.b0[j], L.b1[j], L.b2[j]]) * specific_charge(terms, L, S, i, j)
            if ti.static(terms.pusher != ""):
                if ti.static(terms.exact):
                    a, corrected = phase_corrected(ti.Vector([L.a0[j], L.a1[j], L.a2[j]]), omega, h, 1.0, 1.0)
                    L.a0[j], L.a1[j], L.a2[j] = a[0], a[1], a[2]
                    omega = corrected
                v = accelerated(terms, L, j, rates, v, 0.5 * h)
                v = rotated(v, omega, h)
                v = accelerated(terms, L, j, rates, v, 0.5 * h)
            else:
                lorentz = v.cross(omega)
                L.a0[j] += lorentz[0]
                L.a1[j] += lorentz[1]
                L.a2[j] += lorentz[2]
                v = accelerated(terms, L, j, rates, v, h)
        X.v0[j], X.v1[j], X.v2[j] = v[0], v[1], v[2]
    if ti.static(len(terms.noises) > 0):
        add_noise(terms, L, X, K, i, fraction, ti.cast(step, ti.u32), tau)
