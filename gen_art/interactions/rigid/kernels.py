"""The kernels of rigid bodies: what forces gave their particles, the impulses of contacts, and their particles' places.

Bodies are in float64 throughout; particles in the system's precision. Each sum runs in a fixed order.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.particles.rows import VX

__all__ = ["NUMBERS", "contact_kernel", "particle_kernels"]

_BLOCK = 512  # particles a task
NUMBERS = 23  # of a contact: see contact_kernel

_matrix = ti.types.ndarray(ti.f64, 2)
_whole = ti.types.ndarray(ti.i32, 1)


@ti.func
def _three(M: ti.template(), i, k: ti.template()):
    return ti.Vector([M[i, k], M[i, k + 1], M[i, k + 2]])


@ti.func
def _square(M: ti.template(), i, k: ti.template()):
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

    gather(S, V, T, G, first, out): momentum and angular momentum about the origin, (bodies, 6), that the particles of each
    body gained since their velocities were V (3, n); T (n, 8): mass, place and normal in the body's frame, 0
    put(S, T, G, of, light, rows, moves): places where `moves`, velocities and normals of the particles of bodies
    G (bodies, 18): origin, matrix, velocity, spin; of (n,): their body; rows: where normal and shade are stored, or -1
    """
    real = runtime.DTYPES[precision]
    state = ti.types.ndarray(real, 2)

    @ti.kernel
    def gather(S: state, V: state, T: _matrix, G: _matrix, first: _whole, out: _matrix):
        ti.loop_config(block_dim=1)
        for b in range(out.shape[0]):
            p, L = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
            R = _square(G, b, 3)
            for i in range(first[b], first[b + 1]):
                dv = ti.Vector([0.0, 0.0, 0.0])
                for c in ti.static(range(3)):
                    dv[c] = T[i, 0] * (ti.cast(S[VX + c, i], ti.f64) - ti.cast(V[c, i], ti.f64))
                p += dv
                L += (R @ _three(T, i, 1)).cross(dv)
            for c in ti.static(range(3)):
                out[b, c] = p[c]
                out[b, 3 + c] = L[c]

    @ti.kernel
    def put(
        S: state, T: _matrix, G: _matrix, of: _whole, light: ti.types.ndarray(ti.f64, 1), rows: _whole, moves: ti.i32
    ):
        n = of.shape[0]
        ti.loop_config(block_dim=1)
        for block in range((n + _BLOCK - 1) // _BLOCK):
            for i in range(block * _BLOCK, ti.min((block + 1) * _BLOCK, n)):
                b = of[i]
                R = _square(G, b, 3)
                arm = R @ _three(T, i, 1)
                v = _three(G, b, 12) + _three(G, b, 15).cross(arm)
                for c in ti.static(range(3)):
                    S[VX + c, i] = ti.cast(v[c], real)
                if moves == 1:
                    normal = R @ _three(T, i, 4)
                    for c in ti.static(range(3)):
                        S[c, i] = ti.cast(G[b, c] + arm[c], real)
                        if rows[c] >= 0:
                            S[rows[c], i] = ti.cast(normal[c], real)
                    if rows[3] >= 0:
                        lit = 0.5 + 0.5 * (normal[0] * light[0] + normal[1] * light[1] + normal[2] * light[2])
                        S[rows[3], i] = ti.cast(lit, real)

    return runtime.kernel(gather, precision="f64"), runtime.kernel(put, precision="f64")


@cache
def contact_kernel():
    """solve(B, V, first, second, C, D, M, most, tolerance) -> sweeps taken. Sequential impulses, one contact after the other.

    B (bodies + 1, 10): 1/mass, inverse inertia in the world     V (bodies + 1, 6): velocity of the origin and spin; changed
    first, second (k,): bodies; walls are the last, whose B and V are 0
    C (k, NUMBERS): arms from the origins 0-5, normal 6-8, two tangents 9-14, aim 15 (least speed along the normal), friction
    16, impulses 17-19, which it starts from and leaves, speed of the wall along each 20-22
    D (k, 36) and M (k, 9) are for the kernel: levers r x n and what they turn, for each direction; masses felt, steps
    A contact takes the impulse along the normal that gives it the aim, never below 0; then across it what stops sliding,
    at most friction times that. Sweeps go to and fro; after each pair of them the whole step is lengthened as in conjugate
    gradients. They end when no speed at a contact changes by more than `tolerance`, m/s.
    Sources: Catto, Iterative Dynamics with Temporal Coherence (2005); Silcowitz, Niebe, Erleben (2010), Visual Computer 26.
    """

    @ti.func
    def speed(V: ti.template(), C: ti.template(), D: ti.template(), k, a, b, r: ti.template()):
        w = -C[k, 20 + r]
        for c in ti.static(range(3)):
            w += C[k, 6 + 3 * r + c] * (V[a, c] - V[b, c])
            w += D[k, 12 * r + c] * V[a, 3 + c] - D[k, 12 * r + 3 + c] * V[b, 3 + c]
        return w

    @ti.func
    def push(B: ti.template(), V: ti.template(), C: ti.template(), D: ti.template(), k, a, b, r: ti.template(), size):
        light, other = B[a, 0] * size, B[b, 0] * size
        for c in ti.static(range(3)):
            V[a, c] = V[a, c] + C[k, 6 + 3 * r + c] * light
            V[b, c] = V[b, c] - C[k, 6 + 3 * r + c] * other
            V[a, 3 + c] = V[a, 3 + c] + D[k, 12 * r + 6 + c] * size
            V[b, 3 + c] = V[b, 3 + c] - D[k, 12 * r + 9 + c] * size

    @ti.func
    def prepare(B: ti.template(), V: ti.template(), C: ti.template(), D: ti.template(), M: ti.template(), k, a, b):
        for r in ti.static(range(3)):
            n = _three(C, k, 6 + 3 * r)
            one, two = _three(C, k, 0).cross(n), _three(C, k, 3).cross(n)
            turn, back = _square(B, a, 1) @ one, _square(B, b, 1) @ two
            for c in ti.static(range(3)):
                D[k, 12 * r + c], D[k, 12 * r + 3 + c] = one[c], two[c]
                D[k, 12 * r + 6 + c], D[k, 12 * r + 9 + c] = turn[c], back[c]
            M[k, r] = 1.0 / ti.max(B[a, 0] + B[b, 0] + one.dot(turn) + two.dot(back), 1e-300)
            push(B, V, C, D, k, a, b, r, C[k, 17 + r])
            M[k, 3 + r] = C[k, 17 + r]
            M[k, 6 + r] = 0.0

    @ti.kernel
    def solve(
        B: _matrix, V: _matrix, first: _whole, second: _whole, C: _matrix, D: _matrix, M: _matrix,
        most: ti.i32, tolerance: ti.f64,
    ) -> ti.i32:  # fmt: skip
        taken = 0
        ti.loop_config(serialize=True)
        for _ in range(1):
            n = first.shape[0]
            for k in range(n):
                prepare(B, V, C, D, M, k, first[k], second[k])
            change, before = 2.0 * tolerance, 1e300
            while taken < most and change > tolerance:
                change = 0.0
                for s in range(2 * n):
                    k = s
                    if s >= n:
                        k = 2 * n - 1 - s
                    a, b = first[k], second[k]
                    old = _three(C, k, 17)
                    now = ti.max(old[0] + M[k, 0] * (C[k, 15] - speed(V, C, D, k, a, b, 0)), 0.0)
                    push(B, V, C, D, k, a, b, 0, now - old[0])
                    x = old[1] - M[k, 1] * speed(V, C, D, k, a, b, 1)
                    y = old[2] - M[k, 2] * speed(V, C, D, k, a, b, 2)
                    size, bound = ti.sqrt(x * x + y * y), C[k, 16] * now
                    if size > bound:
                        x, y = x * bound / size, y * bound / size
                    push(B, V, C, D, k, a, b, 1, x - old[1])
                    push(B, V, C, D, k, a, b, 2, y - old[2])
                    C[k, 17], C[k, 18], C[k, 19] = now, x, y
                    step = ti.max(ti.abs(now - old[0]) / M[k, 0], ti.abs(x - old[1]) / M[k, 1])
                    change = ti.max(change, ti.max(step, ti.abs(y - old[2]) / M[k, 2]))
                taken += 1
                steps = 0.0
                for k in range(n):
                    for r in ti.static(range(3)):
                        steps += (C[k, 17 + r] - M[k, 3 + r]) ** 2 / M[k, r]
                along = steps / before
                before = ti.max(steps, 1e-300)
                if along > 1.0 or change <= tolerance:
                    along = 0.0
                for k in range(n):
                    for r in ti.static(range(3)):
                        way = M[k, 6 + r] * along
                        M[k, 6 + r] = way + C[k, 17 + r] - M[k, 3 + r]
                        C[k, 17 + r] = C[k, 17 + r] + way
                        M[k, 3 + r] = C[k, 17 + r]
                        push(B, V, C, D, k, first[k], second[k], r, way)
        return taken

    return runtime.kernel(solve, "f64")
