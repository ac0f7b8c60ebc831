"""Particles that lose mass while they move. The rate is constant over a step, so that the mass is exact at every stage."""

from gen_art.backend.kernel_views import parameters
from gen_art.backend.runtime import ti
from gen_art.forces.base import term_acceleration, term_mass_rate
from gen_art.integrators.lanes import WIDTH, age_of, step_of, time_of
from gen_art.integrators.ledger_rows import add_entry
from gen_art.integrators.particle_tile import place, repeats, view
from gen_art.particles.rows import MASS

__all__ = ["add_exhaust_entries", "compute_mass_loss", "apply_mass_loss"]


@ti.func
def compute_mass_loss(
    terms: ti.template(), L: ti.template(), X: ti.template(), S: ti.template(), K: ti.template(), Q: ti.template(), i
):
    """Write each lane's loss of mass over its own step, kg/s, to L.w."""
    for j in range(WIDTH):
        L.w[j] = 0.0
        x = ti.Vector([X.x0[j], X.x1[j], X.x2[j]])
        v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
        p = view(terms, S, K, i + j, x, v, age_of(L, j), None, S[MASS, i + j], (age_of(L, j), step_of(L, j)))
        for engine in ti.static(terms.mass_loss_terms):
            L.w[j] += term_mass_rate(engine.force, p, time_of(L, j), parameters(Q, engine.force, engine.offset))


@ti.func
def apply_mass_loss(L: ti.template(), S: ti.template(), i, n):
    """Subtract the mass lost in the step from the particles' mass."""
    for j in range(WIDTH):
        if i + j < n:
            S[MASS, i + j] = S[MASS, i + j] - step_of(L, j) * L.w[j]


@ti.func
def add_exhaust_entries(
    terms: ti.template(), B: ti.template(), b, L: ti.template(), X: ti.template(),
    S: ti.template(), K: ti.template(), Q: ti.template(), i, n, tau, share,
):  # fmt: skip
    """Add to the ledger the mass lost in a share of the step, at the state X: exhaust leaves at v + u, u = -F / rate.

    The exhaust has two rows: energy, mass, momentum; then angular momentum. The engine's own row is corrected by the exhaust's
    part of its work and impulse, so that it contains the energy released and no net impulse.
    """
    for j in range(WIDTH):
        if i + j < n and step_of(L, j) > 0.0:
            x = place(terms, X, Q, j)
            v = ti.Vector([X.v0[j], X.v1[j], X.v2[j]])
            m = S[MASS, i + j] - tau * step_of(L, j) * L.w[j]
            age, t = age_of(L, j) + tau * step_of(L, j), time_of(L, j) + tau * step_of(L, j)
            p = view(terms, S, K, i + j, x, v, age, None, m, (age_of(L, j), step_of(L, j)))
            for k, engine in ti.static(enumerate(terms.mass_loss_terms)):
                q = parameters(Q, engine.force, engine.offset)
                rate = term_mass_rate(engine.force, p, t, q)
                if rate > 0.0:
                    u = term_acceleration(engine.force, p, t, q) * (-m / rate)
                    dm = rate * share * step_of(L, j)
                    exhaust_velocity = v + u
                    extra = dm * (0.5 * u.dot(u) + u.dot(v))
                    add_entry(B, b, i + j, engine.ledger_row, extra, 0.0, u * dm)
                    row = ti.static(terms.exhaust_row + 2 * k)
                    energy = 0.5 * dm * exhaust_velocity.dot(exhaust_velocity)
                    for term in ti.static(terms.potentials):
                        lighter = view(terms, S, K, i + j, x, v, age, None, m - dm, (age_of(L, j), step_of(L, j)))
                        for repeat in range(repeats(Q, term.count_offset)):
                            numbers = parameters(Q, term.force, term.offset, repeat)
                            energy += term.force.potential(p, t, numbers) - term.force.potential(lighter, t, numbers)
                    add_entry(B, b, i + j, row, energy, dm, exhaust_velocity * dm)
                    add_entry(B, b, i + j, row + 1, 0.0, 0.0, x.cross(exhaust_velocity) * dm)
