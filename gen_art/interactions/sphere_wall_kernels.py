"""The kernels of contacts between spheres and colliders at rest.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.colliders.surface import collider_of, count
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.particle_tile import TileTerms
from gen_art.particles.rows import MASS, PX, PY, PZ, RADIUS, VX, VY, VZ

__all__ = ["BLOCK", "ELASTIC_ROW", "LOSS_ROW", "STIFFNESS", "WALL_NUMBERS", "wall_kernels"]

BLOCK = 512  # spheres per task

# a collider's numbers in W: stiffness and damping over the mass, friction, and the first rows of its parts in `out` (-1: none)
STIFFNESS, DAMPING, FRICTION, ELASTIC_ROW, LOSS_ROW, WALL_NUMBERS = range(6)


@cache
def wall_kernels(composition: KernelTerms, spins: bool, precision: str):
    """(accelerate, potential) for the colliders of a composition; `spins`: whether spheres rotate."""
    real = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(real, 2), ti.types.ndarray(real, 1)
    terms = TileTerms(composition, (), 0, real)

    @ti.kernel
    def accelerate(
        X: matrix, S: matrix, n: ti.i32, Q: vector, W: matrix, rate: real, rolling: real, spin: ti.i32, out: matrix,
        angular: matrix,
    ):  # fmt: skip
        """The accelerations of the first n spheres by each collider.

        X: positions and velocities; S: the state, with the spins from the row `spin` on
        W: (colliders, WALL_NUMBERS)
        rate: the largest relaxation rate of sliding and rolling, 1/s
        out: accelerations, m/s^2; angular: (3, n), angular accelerations, 1/s^2, are added to it
        """
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                for w in range(W.shape[0]):
                    for place in range(ELASTIC_ROW, WALL_NUMBERS):
                        row = ti.cast(W[w, place], ti.i32)
                        if row >= 0:
                            out[row, i], out[row + 1, i], out[row + 2, i] = 0.0, 0.0, 0.0
                x, v = ti.Vector([X[PX, i], X[PY, i], X[PZ, i]]), ti.Vector([X[VX, i], X[VY, i], X[VZ, i]])
                r = S[RADIUS, i]
                for s in range(count(terms.kinds)):
                    hit = terms.surface(Q, s, x, x[0] * 0.0, 1)
                    overlap = r - hit[3]
                    if overlap > 0.0:
                        w = collider_of(terms.kinds, s)
                        normal = ti.Vector([hit[0], hit[1], hit[2]])
                        push = W[w, STIFFNESS] * overlap
                        row = ti.cast(W[w, ELASTIC_ROW], ti.i32)
                        for c in ti.static(range(3)):
                            out[row + c, i] = out[row + c, i] + push * normal[c]
                        lossy = ti.cast(W[w, LOSS_ROW], ti.i32)
                        if lossy >= 0:
                            along = v.dot(normal)
                            brake = -W[w, DAMPING] * along
                            pressure = ti.max(push + brake, 0.0)
                            slide, stopping, turn = v - along * normal, rate, v * 0.0
                            if ti.static(spins):
                                turn = ti.Vector([S[spin, i], S[spin + 1, i], S[spin + 2, i]])
                                slide -= (hit[3] * turn).cross(normal)
                                stopping *= 2.0 / 7.0  # a sphere that rotates has 2/7 of its mass against friction
                            speed = slide.norm()
                            friction = ti.min(W[w, FRICTION] * pressure, stopping * speed)
                            tangential = slide * (friction / ti.max(speed, 1e-30))
                            loss = brake * normal - tangential
                            for c in ti.static(range(3)):
                                out[lossy + c, i] = out[lossy + c, i] + loss[c]
                            if ti.static(spins):
                                inertia = 0.4 * r * r  # over the mass
                                torque = hit[3] * normal.cross(tangential)
                                roll = turn - turn.dot(normal) * normal
                                roll_speed = roll.norm()
                                resistance = ti.min(rolling * r * pressure, inertia * rate * roll_speed)
                                torque -= roll * (resistance / ti.max(roll_speed, 1e-30))
                                for c in ti.static(range(3)):
                                    angular[c, i] = angular[c, i] + torque[c] / inertia

    @ti.kernel
    def potential(S: matrix, n: ti.i32, Q: vector, W: matrix, out: ti.types.ndarray(ti.f64, 1)):
        """The energy, J, of the contacts of each block of the first n spheres, added to `out`."""
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            total = ti.f64(0.0)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                x = ti.Vector([S[PX, i], S[PY, i], S[PZ, i]])
                for s in range(count(terms.kinds)):
                    overlap = S[RADIUS, i] - terms.surface(Q, s, x, x[0] * 0.0, 0)[3]
                    if overlap > 0.0:
                        stiffness = S[MASS, i] * W[collider_of(terms.kinds, s), STIFFNESS]
                        total += ti.cast(0.5 * stiffness * overlap * overlap, ti.f64)
            out[b] = total

    return runtime.kernel(accelerate, precision), runtime.kernel(potential, precision)
