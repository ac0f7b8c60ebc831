"""The kernels of rigid bodies: momentum that forces gave the particles, impulses of contacts, positions of the particles.

Bodies are in float64 throughout, particles in the system's precision. Each sum runs in a fixed order.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.rigid import contact_columns as col
from gen_art.particles.rows import VX

__all__ = ["contact_kernel", "particle_kernels"]

_BLOCK = 512  # particles per task

# columns of T, the particles of all bodies in their bodies' frames
_MASS, _POSITION, _NORMAL = 0, 1, 4

# columns of G, the bodies' motion
_ORIGIN, _MATRIX, _VELOCITY, _SPIN = 0, 3, 12, 15

_matrix = ti.types.ndarray(ti.f64, 2)
_ints = ti.types.ndarray(ti.i32, 1)
_floats = ti.types.ndarray(ti.f64, 1)


@ti.func
def _vector(M: ti.template(), i, k: ti.template()):
    return ti.Vector([M[i, k], M[i, k + 1], M[i, k + 2]])


@ti.func
def _matrix3(M: ti.template(), i, k: ti.template()):
    return ti.Matrix(
        [
            [M[i, k], M[i, k + 1], M[i, k + 2]],
            [M[i, k + 3], M[i, k + 4], M[i, k + 5]],
            [M[i, k + 6], M[i, k + 7], M[i, k + 8]],
        ]
    )


@cache
def particle_kernels(precision: str):
    """(gather, put).

    gather(S, V, T, G, first, out)
        Writes to out (bodies, 6) the momentum, and the angular momentum about the body's origin, that the particles of each
        body gained since their velocities were V (3, n). Those of body b are first[b] to first[b + 1] - 1.
    put(S, T, G, owner, light, rows, moves)
        Writes the particles' velocities and, where `moves` is 1, their positions, normals and shades.
    T (n, 8): mass, position and normal in the body's frame, 0
    G (bodies, 18): origin, rotation matrix, velocity, spin
    owner (n,): the body of each particle
    light (3,): unit vector to the lamp
    rows (4,): rows of S that store the normal and the shade, or -1
    """
    real = runtime.DTYPES[precision]
    state = ti.types.ndarray(real, 2)

    @ti.kernel
    def gather(S: state, V: state, T: _matrix, G: _matrix, first: _ints, out: _matrix):
        ti.loop_config(block_dim=1)
        for b in range(out.shape[0]):
            p, L = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
            R = _matrix3(G, b, _MATRIX)
            for i in range(first[b], first[b + 1]):
                dv = ti.Vector([0.0, 0.0, 0.0])
                for c in ti.static(range(3)):
                    dv[c] = T[i, _MASS] * (ti.cast(S[VX + c, i], ti.f64) - ti.cast(V[c, i], ti.f64))
                p += dv
                L += (R @ _vector(T, i, _POSITION)).cross(dv)
            for c in ti.static(range(3)):
                out[b, c] = p[c]
                out[b, 3 + c] = L[c]

    @ti.kernel
    def put(S: state, T: _matrix, G: _matrix, owner: _ints, light: _floats, rows: _ints, moves: ti.i32):
        n = owner.shape[0]
        ti.loop_config(block_dim=1)
        for block in range((n + _BLOCK - 1) // _BLOCK):
            for i in range(block * _BLOCK, ti.min((block + 1) * _BLOCK, n)):
                b = owner[i]
                R = _matrix3(G, b, _MATRIX)
                arm = R @ _vector(T, i, _POSITION)
                v = _vector(G, b, _VELOCITY) + _vector(G, b, _SPIN).cross(arm)
                for c in ti.static(range(3)):
                    S[VX + c, i] = ti.cast(v[c], real)
                if moves == 1:
                    normal = R @ _vector(T, i, _NORMAL)
                    for c in ti.static(range(3)):
                        S[c, i] = ti.cast(G[b, _ORIGIN + c] + arm[c], real)
                        if rows[c] >= 0:
                            S[rows[c], i] = ti.cast(normal[c], real)
                    if rows[3] >= 0:
                        lit = 0.5 + 0.5 * (normal[0] * light[0] + normal[1] * light[1] + normal[2] * light[2])
                        S[rows[3], i] = ti.cast(lit, real)

    return runtime.kernel(gather, precision="f64"), runtime.kernel(put, precision="f64")


@cache
def contact_kernel():
    """solve(B, V, first, second, C, D, M, most, tolerance) -> pairs of sweeps taken. Sequential impulses.

    B (bodies + 1, col.BODY_COLUMNS): 1 / mass, inverse inertia in the world
    V (bodies + 1, col.VELOCITY_COLUMNS): velocity of the origin and spin; changed
    first, second (k,): the two bodies of each contact; colliders are the last body, whose B and V are 0
    C (k, col.CONTACT_COLUMNS): the contacts; the impulses in it are the first guess, and the result
    D (k, col.DIRECTION_COLUMNS) and M (k, col.SCRATCH_COLUMNS): scratch
    most: the largest number of pairs of sweeps
    tolerance: m/s; the sweeps end when no speed at a contact changes by more
    Each contact in turn gets the impulse along its normal that gives it its target speed, never below 0, and then across the
    normal the impulse that stops sliding, at most friction times the normal one. A pair of sweeps visits the contacts
    forwards and backwards; after it the whole change is extrapolated as in nonlinear conjugate gradients.
    Sources: Catto, Iterative Dynamics with Temporal Coherence (2005); Silcowitz, Niebe, Erleben (2010), Visual Computer 26.
    """

    @ti.func
    def speed(V: ti.template(), C: ti.template(), D: ti.template(), k, a, b, r: ti.template()):
        w = -C[k, col.SURFACE_SPEED + r]
        for c in ti.static(range(3)):
            w += C[k, col.FRAME + 3 * r + c] * (V[a, col.VELOCITY + c] - V[b, col.VELOCITY + c])
            w += (
                D[k, col.DIRECTION * r + col.LEVER_A + c] * V[a, col.SPIN + c]
                - D[k, col.DIRECTION * r + col.LEVER_B + c] * V[b, col.SPIN + c]
            )
        return w

    @ti.func
    def apply_impulse(
        B: ti.template(), V: ti.template(), C: ti.template(), D: ti.template(), k, a, b, r: ti.template(), size
    ):
        change_a, change_b = B[a, col.INVERSE_MASS] * size, B[b, col.INVERSE_MASS] * size
        for c in ti.static(range(3)):
            V[a, col.VELOCITY + c] = V[a, col.VELOCITY + c] + C[k, col.FRAME + 3 * r + c] * change_a
            V[b, col.VELOCITY + c] = V[b, col.VELOCITY + c] - C[k, col.FRAME + 3 * r + c] * change_b
            V[a, col.SPIN + c] = V[a, col.SPIN + c] + D[k, col.DIRECTION * r + col.SPIN_A + c] * size
            V[b, col.SPIN + c] = V[b, col.SPIN + c] - D[k, col.DIRECTION * r + col.SPIN_B + c] * size

    @ti.func
    def prepare(B: ti.template(), V: ti.template(), C: ti.template(), D: ti.template(), M: ti.template(), k, a, b):
        for r in ti.static(range(3)):
            n = _vector(C, k, col.FRAME + 3 * r)
            lever_a, lever_b = _vector(C, k, col.ARM_A).cross(n), _vector(C, k, col.ARM_B).cross(n)
            spin_a, spin_b = (
                _matrix3(B, a, col.INVERSE_INERTIA) @ lever_a,
                _matrix3(B, b, col.INVERSE_INERTIA) @ lever_b,
            )
            for c in ti.static(range(3)):
                D[k, col.DIRECTION * r + col.LEVER_A + c], D[k, col.DIRECTION * r + col.LEVER_B + c] = (
                    lever_a[c],
                    lever_b[c],
                )
                D[k, col.DIRECTION * r + col.SPIN_A + c], D[k, col.DIRECTION * r + col.SPIN_B + c] = (
                    spin_a[c],
                    spin_b[c],
                )
            M[k, col.EFFECTIVE_MASS + r] = 1.0 / ti.max(
                B[a, col.INVERSE_MASS] + B[b, col.INVERSE_MASS] + lever_a.dot(spin_a) + lever_b.dot(spin_b), 1e-300
            )
            apply_impulse(B, V, C, D, k, a, b, r, C[k, col.IMPULSE + r])
            M[k, col.PREVIOUS + r] = C[k, col.IMPULSE + r]
            M[k, col.STEP + r] = 0.0

    @ti.kernel
    def solve(
        B: _matrix, V: _matrix, first: _ints, second: _ints, C: _matrix, D: _matrix, M: _matrix,
        most: ti.i32, tolerance: ti.f64,
    ) -> ti.i32:  # fmt: skip
        pairs = 0
        ti.loop_config(serialize=True)
        for _ in range(1):
            n = first.shape[0]
            for k in range(n):
                prepare(B, V, C, D, M, k, first[k], second[k])
            change, last_size = 2.0 * tolerance, 1e300
            while pairs < most and change > tolerance:
                change = 0.0
                for visit in range(2 * n):
                    k = visit
                    if visit >= n:
                        k = 2 * n - 1 - visit
                    a, b = first[k], second[k]
                    old = _vector(C, k, col.IMPULSE)
                    new = ti.max(
                        old[0] + M[k, col.EFFECTIVE_MASS] * (C[k, col.TARGET_SPEED] - speed(V, C, D, k, a, b, 0)), 0.0
                    )
                    apply_impulse(B, V, C, D, k, a, b, 0, new - old[0])
                    x = old[1] - M[k, col.EFFECTIVE_MASS + 1] * speed(V, C, D, k, a, b, 1)
                    y = old[2] - M[k, col.EFFECTIVE_MASS + 2] * speed(V, C, D, k, a, b, 2)
                    size, bound = ti.sqrt(x * x + y * y), C[k, col.FRICTION] * new
                    if size > bound:
                        x, y = x * bound / size, y * bound / size
                    apply_impulse(B, V, C, D, k, a, b, 1, x - old[1])
                    apply_impulse(B, V, C, D, k, a, b, 2, y - old[2])
                    C[k, col.IMPULSE], C[k, col.IMPULSE + 1], C[k, col.IMPULSE + 2] = new, x, y
                    speed_change = ti.max(
                        ti.abs(new - old[0]) / M[k, col.EFFECTIVE_MASS],
                        ti.abs(x - old[1]) / M[k, col.EFFECTIVE_MASS + 1],
                    )
                    change = ti.max(change, ti.max(speed_change, ti.abs(y - old[2]) / M[k, col.EFFECTIVE_MASS + 2]))
                pairs += 1
                step_size = 0.0
                for k in range(n):
                    for r in ti.static(range(3)):
                        step_size += (C[k, col.IMPULSE + r] - M[k, col.PREVIOUS + r]) ** 2 / M[
                            k, col.EFFECTIVE_MASS + r
                        ]
                ratio = step_size / last_size
                last_size = ti.max(step_size, 1e-300)
                if ratio > 1.0 or change <= tolerance:
                    ratio = 0.0
                for k in range(n):
                    for r in ti.static(range(3)):
                        extra = M[k, col.STEP + r] * ratio
                        M[k, col.STEP + r] = extra + C[k, col.IMPULSE + r] - M[k, col.PREVIOUS + r]
                        C[k, col.IMPULSE + r] = C[k, col.IMPULSE + r] + extra
                        M[k, col.PREVIOUS + r] = C[k, col.IMPULSE + r]
                        apply_impulse(B, V, C, D, k, first[k], second[k], r, extra)
        return pairs

    return runtime.kernel(solve, "f64")
