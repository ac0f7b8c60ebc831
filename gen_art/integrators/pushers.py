"""The relativistic pushers of charges: Boris, Vay, and Higuera and Cary; and the correction of their phase.

All advance u = gamma v, du/dt = a + v x omega, with omega = q B / m and a the electric and all other accelerations. They differ
in the gamma of the rotation. Boris conserves abs(u) in a magnetic field; Vay and Higuera-Cary also have the exact drift in
crossed fields. `exact` multiplies omega, and the part of a across it, by tan(z) / z with z = abs(omega) h / (2 gamma): the
angle of a step is then exact in uniform fields, and the drift stays exact. Higuera and Cary's gamma is that of the mean of u
before and after the kick, which the factor takes into account. In a uniform field, with theta = abs(omega) dt / gamma per step,
Boris's and Vay's circles are exact and their phase lags by theta^2 / 12; Higuera and Cary's circle is beta^2 theta^2 / 8 too
small and their phase lags by theta^2 (1 / 12 - beta^2 / 8); with `exact` the phase is exact and the circle theta^2 / 12 too
small.
Sources: Boris (1970); Vay (2008), Phys. Plasmas 15, 056701; Higuera & Cary (2017), Phys. Plasmas 24, 052104; Birdsall &
Langdon, Plasma Physics via Computer Simulation, section 4.3.
"""

from gen_art.backend.runtime import is_f64, ti
from gen_art.maths.elementary import cos, sin

__all__ = ["phase_corrected", "gamma_at", "relativistic"]


@ti.func
def gamma_of(u, light):
    return ti.sqrt(1.0 + u.dot(u) / (light * light))


@ti.func
def gamma_at(v, light):
    """gamma of a velocity; finite even for a velocity that is rounded to the speed of light."""
    return 1.0 / ti.sqrt(1.0 - ti.min(v.dot(v) / (light * light), ti.static(1.0 - 1e-14 if is_f64() else 1.0 - 1e-6)))


@ti.func
def phase_corrected(a, omega, h, gamma, gamma_ratio):
    """(a, omega) with the correction of the phase, for steps below 3 rad. gamma_ratio : the pusher's gamma over gamma."""
    strength = omega.norm()
    z = ti.min(0.5 * h * strength / gamma, 1.5)
    factor = ti.select(z > 1e-6, sin(z) / (cos(z) * ti.max(z, 1e-6)), 1.0)
    n = omega / ti.max(strength, ti.static(1e-290 if is_f64() else 1e-30))
    along = n * a.dot(n)
    factor *= gamma_ratio
    return along + (a - along) * factor, omega * factor


@ti.func
def rotated(u, t):
    """u after Boris's rotation by the vector t, whose length is tan(angle / 2)."""
    return u + (u + u.cross(t)).cross(t) * (2.0 / (1.0 + t.dot(t)))


@ti.func
def pusher_gamma(u, tau, light):
    """The gamma of the rotation in Vay's and Higuera and Cary's schemes, from u before it."""
    g2 = 1.0 + u.dot(u) / (light * light)
    tau2 = tau.dot(tau)
    along = u.dot(tau) / light
    sigma = g2 - tau2
    return ti.sqrt(0.5 * (sigma + ti.sqrt(sigma * sigma + 4.0 * (tau2 + along * along))))


@ti.func
def relativistic(terms: ti.template(), v, a, omega, h, light):
    """The velocity v after a kick over h, s."""
    g = gamma_at(v, light)
    u = v * g
    if ti.static(terms.exact):
        gamma_ratio = g * 0.0 + 1.0
        if ti.static(terms.pusher == "higuera_cary"):  # its gamma is that of the mean of u before and after the kick
            across = u.cross(omega).norm() / ti.max(omega.norm(), ti.static(1e-290 if is_f64() else 1e-30)) / light
            lost = across * sin(ti.min(0.5 * h * omega.norm() / g, 1.5))
            gamma_ratio = ti.sqrt(1.0 - lost * lost / (g * g))
        a, omega = phase_corrected(a, omega, h, g, gamma_ratio)
    half, tau = a * (0.5 * h), omega * (0.5 * h)
    if ti.static(terms.pusher == "vay"):
        u += 2.0 * half + v.cross(tau)
        t = tau / pusher_gamma(u, tau, light)
        u = (u + t * u.dot(t) + u.cross(t)) / (1.0 + t.dot(t))
    else:
        u += half
        gamma = gamma_of(u, light)
        if ti.static(terms.pusher == "higuera_cary"):
            gamma = pusher_gamma(u, tau, light)
        u = rotated(u, tau / gamma) + half
    return u / gamma_of(u, light)
