"""The step of step.py written without gen_art's kernels: in NumPy and as a plain Taichi kernel.

Gravity, linear and quadratic drag towards a medium of curl noise in octaves; drift-kick-drift with the drag in closed form.
"""

import numpy as np

F, U = np.float32, np.uint32
PRIMES = (0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D)
NEXT = 0x27D4EB2F
NORM = (2.0 * (20.0 / 7.0) * (181.0 / 231.0) ** 2) ** -0.5
MASK = 0xFFFFFFFF
ORDERS = ((0, 1, 2, 3, 4, 5, 6, 7), (0, 2, 4, 6, 1, 3, 5, 7), (0, 4, 1, 5, 2, 6, 3, 7))


def octave(noise: dict, k: int, t: float):
    """(amount, fineness, offset, seed, noise time) of octave k of a CurlNoise's values, at time t."""
    fineness = noise["lacunarity"] ** k / noise["scale"]
    seed = (noise["seed"] * 64 + k) * 0x165667B1 & MASK
    return (
        noise["strength"] * noise["gain"] ** k,
        fineness,
        17.31 * k + 0.5,
        seed,
        noise["speed"] * noise["scale"] * fineness * t,
    )


def fade(time: float, seed: int):
    """(blend, scale, epoch) of the noise at a noise time."""
    tick = np.floor(time)
    g = time - tick
    g = g * g * (3.0 - 2.0 * g)
    return F(g), F(NORM * (2.0 / 1023.0) / np.sqrt(g * g + (1.0 - g) ** 2)), (seed + int(tick) * NEXT) & MASK


def _hash(h):
    h = (h ^ (h >> U(15))) * U(0x2C1B3C6D)
    return h ^ (h >> U(12))


def _mix(a, b, w):
    return a + (b - a) * w


def numpy_noise(p, time: float, seed: int):
    """gen_art.maths.noise.curl_noise for positions (3, n), float32, in NumPy."""
    base = np.floor(p)
    f = p - base
    w = f * f * f * (f * (f * F(6) - F(15)) + F(10))
    dw = F(30) * f * f * (f * (f - F(2)) + F(1))
    g, scale, epoch = fade(time, seed)
    x0, y0, z0 = (base[c].astype(np.int32).view(U) * U(PRIMES[c]) for c in range(3))
    sides = [(x0, x0 + U(PRIMES[0])), (y0, y0 + U(PRIMES[1])), (z0, z0 + U(PRIMES[2]))]
    a = [[None] * 8 for _ in range(3)]
    for n in range(8):
        cell = (sides[0][n & 1] ^ sides[1][(n >> 1) & 1] ^ sides[2][n >> 2]) + U(epoch)
        old, new = _hash(cell), _hash(cell + U(NEXT))
        for c in range(3):
            low, high = (((h >> U(10 * c)) & U(1023)).view(np.int32).astype(F) for h in (old, new))
            a[c][n] = _mix(low, high, g)

    def slopes(c, u, v, w):
        n = ORDERS[c]
        e00, e10, e01, e11 = (_mix(a[c][n[2 * k]], a[c][n[2 * k + 1]], u) for k in range(4))
        return _mix(e10 - e00, e11 - e01, w), _mix(e01 - e00, e11 - e10, v)

    dy0, dz0 = slopes(0, w[0], w[1], w[2])
    dz1, dx1 = slopes(1, w[1], w[2], w[0])
    dx2, dy2 = slopes(2, w[2], w[0], w[1])
    return np.stack([dy2 * dw[1] - dz1 * dw[2], dz0 * dw[2] - dx2 * dw[0], dx1 * dw[0] - dy0 * dw[1]]) * scale


def _relaxed(v, w, a, u, k1, k2, h):
    """Acceleration and drag over h, the quadratic rate held at velocity w."""
    d = w - u
    rate = k1 + k2 * np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    z = rate * F(h)
    share = np.where(z > 0, -np.expm1(-z) / np.where(z > 0, z, 1), 1).astype(F) * F(h)
    return v + share * (a + rate * (u - v))


def numpy_step(S, laws: dict, now: float, h: float, block: int) -> None:
    """One step of S (channels, n) float32 in place, `block` particles at a time (16384 stay in the cache)."""
    gravity = np.array(laws["gravity"], F)[:, None]
    t = now + 0.5 * h
    octaves = [octave(laws["noise"], k, t) for k in range(laws["noise"]["octaves"])]
    for start in range(0, S.shape[1], block):
        s = S[:, start : start + block]
        x, v = s[0:3], s[3:6]
        x += F(0.5 * h) * v
        u = np.zeros_like(x)
        for amount, fineness, offset, seed, time in octaves:
            u += F(amount) * numpy_noise(x * F(fineness) + F(offset), time, seed)
        k1, k2 = F(laws["linear"]) / s[6], F(laws["quadratic"]) / s[6]
        middle = _relaxed(v, v, gravity, u, k1, k2, 0.5 * h)
        v[:] = _relaxed(v, middle, gravity, u, k1, k2, h)
        x += F(0.5 * h) * v


def plain_kernel(composition, blocks: bool):
    """One particle an iteration, stored straight to the array; with `blocks`, 1024 of them a task."""
    from gen_art.backend import runtime
    from gen_art.backend.kernel_views import parameters
    from gen_art.backend.runtime import ti
    from gen_art.forces.base import term_acceleration
    from gen_art.integrators.particle_tile import TileTerms, repeats, view
    from gen_art.maths.elementary import phi

    terms = TileTerms(composition, (), 0, ti.f32)
    drag, place = terms.dampings[0].force, terms.dampings[0].offset
    matrix, vector = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f32, 1)

    @ti.func
    def relaxed(v, w, a, u, rates, h):
        rate = rates[0] + rates[1] * (w - u).norm()
        return v + h * phi(rate * h) * (a + rate * (u - v))

    @ti.func
    def advance(S: ti.template(), K: ti.template(), Q: ti.template(), i, now, h):
        v = ti.Vector([S[3, i], S[4, i], S[5, i]])
        x = ti.Vector([S[0, i], S[1, i], S[2, i]]) + 0.5 * h * v
        t = now + 0.5 * h
        p = view(terms, S, K, i, x, v, t)
        a, u = ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0])
        for term in ti.static(terms.accelerations):
            for k in range(repeats(Q, term.count_offset)):
                a += term_acceleration(term.force, p, t, parameters(Q, term.force, term.offset, k))
        for term in ti.static(terms.media[0]):
            for k in range(repeats(Q, term.count_offset)):
                u += term.force.acceleration(p, t, parameters(Q, term.force, term.offset, k))
        rates = drag.damping(p, t, parameters(Q, drag, place))
        middle = relaxed(v, v, a, u, rates, 0.5 * h)
        new = relaxed(v, middle, a, u, rates, h)
        S[0, i], S[1, i], S[2, i] = x[0] + 0.5 * h * new[0], x[1] + 0.5 * h * new[1], x[2] + 0.5 * h * new[2]
        S[3, i], S[4, i], S[5, i] = new[0], new[1], new[2]

    @ti.kernel
    def simple(S: matrix, K: ti.types.ndarray(ti.u32, 2), Q: vector, n: ti.i32, now: ti.f32, h: ti.f32):
        for i in range(n):
            advance(S, K, Q, i, now, h)

    @ti.kernel
    def blocked(S: matrix, K: ti.types.ndarray(ti.u32, 2), Q: vector, n: ti.i32, now: ti.f32, h: ti.f32):
        ti.loop_config(block_dim=1)
        for b in range((n + 1023) // 1024):
            for i in range(b * 1024, ti.min((b + 1) * 1024, n)):
                advance(S, K, Q, i, now, h)

    return runtime.kernel(blocked if blocks else simple, "f32")
