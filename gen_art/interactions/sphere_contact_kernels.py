"""The kernels of contacts: each sphere sums the forces of the spheres that it touches, in the order of the grid.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.neighbour_grid import (
    INVERSE_MASS_AT,
    POSITION_AT,
    RADIUS_AT,
    RECORD,
    VELOCITY_AT,
    cell_of,
    nearest_image,
    periodic_cell,
    place_in_grid,
    run_beyond,
    run_of,
)

__all__ = ["BLOCK", "RESULT", "contact_kernels", "overlap_kernel"]

BLOCK = 512  # spheres per task
_LIST = 32  # touching spheres that are listed at a time

# the parameters q: stiffness and damping over the reduced mass, friction, largest relaxation rate of sliding, rolling friction,
# and in a periodic box the frame of the grid
_STIFFNESS, _DAMPING, _FRICTION, _RATE, _ROLLING, _FRAME = range(6)
_LOSS, RESULT = 3, 6  # a sphere's entry in F: conservative acceleration, then the dissipative one


@ti.func
def vector_at(P: ti.template(), k):
    return ti.Vector([P[k], P[k + 1], P[k + 2]])


@ti.func
def cell(x, low: ti.template(), shape, size):
    """The grid's cell that contains x; y and z are periodic."""
    return ti.Vector([
        cell_of(x[0], size) - low[0], (cell_of(x[1], size) - low[1]) % shape[1], (cell_of(x[2], size) - low[2]) % shape[2]
    ])  # fmt: skip


@ti.func
def separation(x, P: ti.template(), record, q: ti.template(), periodic: ti.template()):
    """x minus the position of a record, in a periodic box of nearest images."""
    d = x - vector_at(P, record + POSITION_AT)
    if ti.static(periodic):
        d = nearest_image(d, q, _FRAME)
    return d


@ti.func
def run(first: ti.template(), shape, c, row, left, right, q: ti.template(), periodic: ti.template()):
    """Where the cells of one of the rows around the cell c begin and end; rows from 9 on lie beyond a periodic side."""
    r = row
    if ti.static(periodic):
        r = row % 9
    y, z = c[1] + r % 3 - 1, c[2] + r // 3 - 1
    begin, end = run_of(first, shape, c[0], y, z, left, right)
    if ti.static(periodic):
        begin_beyond, end_beyond = run_beyond(first, shape, c[0], y, z, left, right, q, _FRAME)
        begin, end = ti.select(row < 9, begin, begin_beyond), ti.select(row < 9, end, end_beyond)
    return begin, end


@ti.func
def squared_gap(at, side):
    """Square of the distance from a place in a cell (0 to 1) to the cell before it (side -1), itself (0) or the next (1)."""
    far = ti.select(side < 0, at, ti.select(side > 0, 1.0 - at, 0.0 * at))
    return far * far


@ti.func
def spin_of(S: ti.template(), row, i):
    return ti.Vector([S[row, i], S[row + 1, i], S[row + 2, i]])


@cache
def contact_kernels(precision: str, spins: bool, periodic: bool):
    """(accelerate, unsort, potential); `spins`: whether spheres rotate; `periodic`: whether they are in a periodic box."""
    real = runtime.DTYPES[precision]
    rows = 18 if periodic else 9
    matrix, ints, vector = ti.types.ndarray(real, 2), ti.types.ndarray(ti.i32, 1), ti.types.ndarray(real, 1)

    @ti.kernel
    def accelerate(
        P: vector, slots: ints, first: ints, low: ints, extent: ints, q: vector, size: real, S: matrix, spin: ti.i32,
        F: vector, angular: matrix, parts: ti.i32,
    ):  # fmt: skip
        """The accelerations of all spheres.

        P, slots, first, low, extent, size: the Grid
        q: parameters
        S: the state, with the spins from the row `spin` on
        F: (n RESULT,), accelerations in the grid's order
        angular: (3, n), angular accelerations, 1/s^2
        """
        n = slots.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            shape = ti.Vector([extent[0], extent[1], extent[2]])
            touching = ti.Vector([0] * (_LIST + 1))
            stiffness, damping, mu, rate, rolling = q[_STIFFNESS], q[_DAMPING], q[_FRICTION], q[_RATE], q[_ROLLING]
            for k in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                here = RECORD * k
                x, v = vector_at(P, here + POSITION_AT), vector_at(P, here + VELOCITY_AT)
                r, w = P[here + RADIUS_AT], P[here + INVERSE_MASS_AT]
                elastic, loss, torque = x * 0.0, x * 0.0, x * 0.0
                c = cell(x, low, shape, size)
                scaled = x / size
                if ti.static(periodic):
                    scaled = place_in_grid(x, q, _FRAME)
                    c = periodic_cell(scaled, low, shape, q, _FRAME)
                at = scaled - ti.floor(scaled)  # the position in its cell, 0 to 1: cells too far from it are skipped
                near = 1.001 + 1e-6 * ti.abs(scaled).sum()
                # touching spheres are listed first, without a branch, and then evaluated; repeated if the list was too short
                done, again = 0, 1
                while again > 0:
                    seen, kept = 0, 0
                    for row in range(rows):
                        r9 = row
                        if ti.static(periodic):
                            r9 = row % 9
                        across = squared_gap(at[1], r9 % 3 - 1) + squared_gap(at[2], r9 // 3 - 1)  # in cells
                        left = ti.cast(across + at[0] * at[0] < near, ti.i32)
                        right = ti.cast(across + (1.0 - at[0]) * (1.0 - at[0]) < near, ti.i32)
                        begin, end = run(first, shape, c, row, left, right, q, periodic)
                        end = ti.select(across < near, end, begin)
                        for j in range(begin, end):
                            d = separation(x, P, RECORD * j, q, periodic)
                            sum_radii = r + P[RECORD * j + RADIUS_AT]
                            hit = ti.cast((d.dot(d) < sum_radii * sum_radii) & (j != k), ti.i32)
                            touching[kept] = j
                            kept += hit * ti.cast((seen >= done) & (kept < _LIST), ti.i32)
                            seen += hit
                    done += kept
                    again = ti.cast(seen > done, ti.i32)
                    for h in range(kept):
                        o = RECORD * touching[h]
                        d = separation(x, P, o, q, periodic)
                        sum_radii = r + P[o + RADIUS_AT]
                        if w + P[o + INVERSE_MASS_AT] > 0.0:
                            distance = d.norm()
                            normal = d * (1.0 / ti.max(distance, 1e-30))
                            m = 1.0 / (w + P[o + INVERSE_MASS_AT])
                            f = m * stiffness * (sum_radii - distance)
                            elastic += f * normal
                            if parts > 1:
                                u = v - vector_at(P, o + VELOCITY_AT)
                                along = u.dot(normal)
                                g = -m * damping * along
                                slide = u - along * normal
                                stopping, arm, spin_a, spin_b = m * rate, distance / sum_radii, v * 0.0, v * 0.0
                                if ti.static(spins):
                                    # both arms end in the same point, so that angular momentum is kept
                                    spin_a, spin_b = spin_of(S, spin, slots[k]), spin_of(S, spin, slots[touching[h]])
                                    slide -= ((arm * r) * spin_a + (arm * P[o + RADIUS_AT]) * spin_b).cross(normal)
                                    # a rotating sphere has 2/7 of the effective mass against friction
                                    stopping *= 2.0 / 7.0
                                speed = slide.norm()
                                friction = ti.min(mu * ti.max(f + g, 0.0), stopping * speed)
                                tangential = slide * (friction / ti.max(speed, 1e-30))
                                loss += g * normal - tangential
                                if ti.static(spins):
                                    torque += (arm * r) * normal.cross(tangential)
                                    roll = spin_a - spin_b
                                    roll -= roll.dot(normal) * normal
                                    roll_speed = roll.norm()
                                    r2 = P[o + RADIUS_AT]
                                    inertia = 0.4 / (w / (r * r) + P[o + INVERSE_MASS_AT] / (r2 * r2))
                                    resistance = rolling * (r * r2 / sum_radii) * ti.max(f + g, 0.0)
                                    brake = ti.min(resistance, inertia * rate * roll_speed)
                                    torque -= roll * (brake / ti.max(roll_speed, 1e-30))
                i = slots[k]
                for a in ti.static(range(3)):
                    F[RESULT * k + a], F[RESULT * k + _LOSS + a] = elastic[a] * w, loss[a] * w
                if ti.static(spins):
                    for a in ti.static(range(3)):
                        angular[a, i] = torque[a] * (2.5 * w / ti.max(r * r, 1e-30))

    @ti.kernel
    def unsort(F: vector, rank: ints, out: matrix, rows: ti.i32):
        """out[:, i] = F at rank[i]. F is stored by sphere, so that each needs one access far away, not one for each number."""
        n = rank.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                for a in range(rows):
                    out[a, i] = F[RESULT * rank[i] + a]

    @ti.kernel
    def potential(
        P: vector, first: ints, low: ints, extent: ints, q: vector, size: real, out: ti.types.ndarray(ti.f64, 2)
    ):
        n = P.shape[0] // RECORD
        ti.loop_config(block_dim=1)
        for b in range(out.shape[0]):
            shape = ti.Vector([extent[0], extent[1], extent[2]])
            total = ti.f64(0.0)
            for k in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                here = RECORD * k
                x, r, w = vector_at(P, here + POSITION_AT), P[here + RADIUS_AT], P[here + INVERSE_MASS_AT]
                c = cell(x, low, shape, size)
                if ti.static(periodic):
                    c = periodic_cell(place_in_grid(x, q, _FRAME), low, shape, q, _FRAME)
                for row in range(rows):
                    begin, end = run(first, shape, c, row, 1, 1, q, periodic)
                    for j in range(begin, end):
                        d = separation(x, P, RECORD * j, q, periodic)
                        overlap = r + P[RECORD * j + RADIUS_AT] - d.norm()
                        if (overlap > 0.0) & (j != k) & (w + P[RECORD * j + INVERSE_MASS_AT] > 0.0):
                            inverse_mass = w + P[RECORD * j + INVERSE_MASS_AT]
                            total += ti.cast(0.25 * q[_STIFFNESS] * overlap * overlap / inverse_mass, ti.f64)
            out[b, 0] = total

    return tuple(runtime.kernel(f, precision) for f in (accelerate, unsort, potential))


@cache
def overlap_kernel(precision: str, periodic: bool):
    """measure(...): the deepest overlap, m, of each sphere with another it exerts a force on, and the slot of that sphere."""
    real = runtime.DTYPES[precision]
    ints, vector = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(real, 1)
    rows = 18 if periodic else 9

    @ti.kernel
    def measure(
        P: vector, slots: ints, first: ints, low: ints, extent: ints, q: vector, size: real, depth: vector, other: ints
    ):
        n = slots.shape[0]
        ti.loop_config(block_dim=1)
        for b in range((n + BLOCK - 1) // BLOCK):
            shape = ti.Vector([extent[0], extent[1], extent[2]])
            for k in range(b * BLOCK, ti.min((b + 1) * BLOCK, n)):
                here = RECORD * k
                x, r, w = vector_at(P, here + POSITION_AT), P[here + RADIUS_AT], P[here + INVERSE_MASS_AT]
                deepest, which = r * 0.0, k
                c = cell(x, low, shape, size)
                if ti.static(periodic):
                    c = periodic_cell(place_in_grid(x, q, _FRAME), low, shape, q, _FRAME)
                for row in range(rows):
                    begin, end = run(first, shape, c, row, 1, 1, q, periodic)
                    for j in range(begin, end):
                        d, sum_radii = separation(x, P, RECORD * j, q, periodic), r + P[RECORD * j + RADIUS_AT]
                        if (
                            (deepest < sum_radii)
                            & (d.dot(d) < (sum_radii - deepest) * (sum_radii - deepest))
                            & (j != k)
                            & (w + P[RECORD * j + INVERSE_MASS_AT] > 0.0)
                        ):
                            deepest, which = sum_radii - d.norm(), j
                depth[slots[k]], other[slots[k]] = deepest, slots[which]

    return runtime.kernel(measure, precision)
