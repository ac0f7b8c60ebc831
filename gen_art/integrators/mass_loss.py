"""Particles that lose mass while they move: the rate is held over a step, so the mass is exact at every stage."""

from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.forces.base import term_acceleration, term_mass_rate
from gen_art.integrators.ledger_rows import add_entry
from gen_art.integrators.tile import WIDTH, repeats, view
from gen_art.particles.rows import MASS

__all__ = ["add_exhaust_entries", "find_mass_loss", "apply_mass_loss"]


@ti.func
def find_mass_loss(
    terms: ti.template(), L: ti.template(), X: ti.template(), S: ti.template(), K: ti.template(), Q: ti.template(), i
):
    """Each lane's loss of mass in kg/s over its own step, into L.w."""
    for j in range(WIDTH):
        L.w[j] = 0.0
        x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
        v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
        p = view(terms, S, K, i + j, x, v, L.age[j], None, S[MASS, i + j], (L.age[j], L.h[j]))
        for burner in ti.static(terms.mass_loss_terms):
            L.w[j] += term_mass_rate(burner[0], p, L.t[j], parameters(Q, burner[0], burner[1]))


@ti.func
def apply_mass_loss(L: ti.template(), S: ti.template(), i, n):
    """Take what burnt in the step off the particles' mass."""
    for j in range(WIDTH):
        if i + j < n:
            S[MASS, i + j] = S[MASS, i + j] - L.h[j] * L.w[j]


@ti.func
def add_exhaust_entries(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(),
    S: ti.template(), K: ti.template(), Q: ti.template(), i, n, tau, share,
):  # fmt: skip
    """Book what burns in a share of the step, at the state X: the exhaust leaves at v + u, u = -F / rate.

    Exhaust's rows: energy, mass, momentum; then angular momentum. The engine's own row is mended by what the exhaust takes of
    its work and impulse, so that it holds the energy it set free and no net impulse.
    """
    for j in range(WIDTH):
        if i + j < n and L.h[j] > 0.0:
            x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
            v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            m = S[MASS, i + j] - tau * L.h[j] * L.w[j]
            age, t = L.age[j] + tau * L.h[j], L.t[j] + tau * L.h[j]
            p = view(terms, S, K, i + j, x, v, age, None, m, (L.age[j], L.h[j]))
            for k, burner in ti.static(enumerate(terms.mass_loss_terms)):
                q = parameters(Q, burner[0], burner[1])
                rate = term_mass_rate(burner[0], p, t, q)
                if rate > 0.0:
                    u = term_acceleration(burner[0], p, t, q) * (-m / rate)
                    dm = rate * share * L.h[j]
                    gone = v + u
                    extra = dm * (0.5 * u.dot(u) + u.dot(v))
                    add_entry(B, b, burner[3], extra, 0.0, u * dm)
                    row = ti.static(terms.exhaust + 2 * k)
                    energy = 0.5 * dm * gone.dot(gone)
                    for force, offset, count, _ in ti.static(terms.potentials):
                        lighter = view(terms, S, K, i + j, x, v, age, None, m - dm, (L.age[j], L.h[j]))
                        for repeat in range(repeats(Q, count)):
                            at = parameters(Q, force, offset, repeat)
                            energy += force.potential(p, t, at) - force.potential(lighter, t, at)
                    add_entry(B, b, row, energy, dm, gone * dm)
                    add_entry(B, b, row + 1, 0.0, 0.0, x.cross(gone) * dm)
