"""The step of step.py for numba: one particle an iteration over all cores, for information."""

import numba
import numpy as np
from _peers import NEXT, PRIMES, fade, octave

F, U, W = np.float32, np.uint32, np.uint64
PX, PY, PZ = (U(p) for p in PRIMES)
STEP, MIXER, BITS, ONE = U(NEXT), U(0x2C1B3C6D), U(1023), F(1)
inline = numba.njit(fastmath=True)


@inline
def hashed(h):
    h = U(U(h ^ (h >> U(15))) * MIXER)
    return U(h ^ (h >> U(12)))


@inline
def corner(cell, epoch, g):
    old, new = hashed(U(cell + epoch)), hashed(U(U(cell + epoch) + STEP))
    x, y, z = F(old & BITS), F((old >> U(10)) & BITS), F((old >> U(20)) & BITS)
    return (
        x + (F(new & BITS) - x) * g, y + (F((new >> U(10)) & BITS) - y) * g, z + (F((new >> U(20)) & BITS) - z) * g
    )  # fmt: skip


@inline
def slopes(a, b, c, d, e, f, g, h, u, v, w):
    e00, e10, e01, e11 = a + (b - a) * u, c + (d - c) * u, e + (f - e) * u, g + (h - g) * u
    p, q, r, s = e10 - e00, e11 - e01, e01 - e00, e11 - e10
    return p + (q - p) * w, r + (s - r) * v


@inline
def curl(x, y, z, g, scale, epoch):
    bx, by, bz = np.floor(x), np.floor(y), np.floor(z)
    fx, fy, fz = x - bx, y - by, z - bz
    u, v, w = (
        fx * fx * fx * (fx * (fx * F(6) - F(15)) + F(10)), fy * fy * fy * (fy * (fy * F(6) - F(15)) + F(10)),
        fz * fz * fz * (fz * (fz * F(6) - F(15)) + F(10)),
    )  # fmt: skip
    du = F(30) * fx * fx * (fx * (fx - F(2)) + ONE)
    dv = F(30) * fy * fy * (fy * (fy - F(2)) + ONE)
    dw = F(30) * fz * fz * (fz * (fz - F(2)) + ONE)
    x0, y0, z0 = U(U(np.int32(bx)) * PX), U(U(np.int32(by)) * PY), U(U(np.int32(bz)) * PZ)
    x1, y1, z1 = U(x0 + PX), U(y0 + PY), U(z0 + PZ)
    a, b = corner(U(x0 ^ y0 ^ z0), epoch, g), corner(U(x1 ^ y0 ^ z0), epoch, g)
    c, d = corner(U(x0 ^ y1 ^ z0), epoch, g), corner(U(x1 ^ y1 ^ z0), epoch, g)
    e, f = corner(U(x0 ^ y0 ^ z1), epoch, g), corner(U(x1 ^ y0 ^ z1), epoch, g)
    h, k = corner(U(x0 ^ y1 ^ z1), epoch, g), corner(U(x1 ^ y1 ^ z1), epoch, g)
    dy0, dz0 = slopes(a[0], b[0], c[0], d[0], e[0], f[0], h[0], k[0], u, v, w)
    dz1, dx1 = slopes(a[1], c[1], e[1], h[1], b[1], d[1], f[1], k[1], v, w, u)
    dx2, dy2 = slopes(a[2], e[2], b[2], f[2], c[2], h[2], d[2], k[2], w, u, v)
    return (dy2 * dv - dz1 * dw) * scale, (dz0 * dw - dx2 * du) * scale, (dx1 * du - dy0 * dv) * scale


@inline
def relaxed(vx, vy, vz, wx, wy, wz, ax, ay, az, ux, uy, uz, k1, k2, h):
    dx, dy, dz = wx - ux, wy - uy, wz - uz
    rate = k1 + k2 * np.sqrt(dx * dx + dy * dy + dz * dz)
    z = rate * h
    share = h * (-F(np.expm1(-z)) / z if z > F(0) else ONE)
    return (
        vx + share * (ax + rate * (ux - vx)),
        vy + share * (ay + rate * (uy - vy)),
        vz + share * (az + rate * (uz - vz)),
    )


@numba.njit(parallel=True, fastmath=True)
def _step(S, gravity, linear, quadratic, amounts, finenesses, offsets, blends, scales, epochs, h):
    half = F(0.5) * h
    ax, ay, az = gravity[0], gravity[1], gravity[2]
    for i in numba.prange(S.shape[1]):
        vx, vy, vz = S[3, i], S[4, i], S[5, i]
        x, y, z = S[0, i] + half * vx, S[1, i] + half * vy, S[2, i] + half * vz
        ux, uy, uz = F(0), F(0), F(0)
        for k in range(amounts.shape[0]):
            f, o = finenesses[k], offsets[k]
            p, q, r = curl(x * f + o, y * f + o, z * f + o, blends[k], scales[k], epochs[k])
            ux, uy, uz = ux + amounts[k] * p, uy + amounts[k] * q, uz + amounts[k] * r
        k1, k2 = linear / S[6, i], quadratic / S[6, i]
        mx, my, mz = relaxed(vx, vy, vz, vx, vy, vz, ax, ay, az, ux, uy, uz, k1, k2, half)
        vx, vy, vz = relaxed(vx, vy, vz, mx, my, mz, ax, ay, az, ux, uy, uz, k1, k2, h)
        S[0, i], S[1, i], S[2, i] = x + half * vx, y + half * vy, z + half * vz
        S[3, i], S[4, i], S[5, i] = vx, vy, vz


def numba_step(S, laws: dict, now: float, h: float) -> None:
    """One step of S (channels, n) float32 in place."""
    t = now + 0.5 * h
    octaves = [octave(laws["noise"], k, t) for k in range(laws["noise"]["octaves"])]
    amounts, finenesses, offsets, seeds, times = (np.array(c) for c in zip(*octaves))
    blends, scales, epochs = (np.array(c) for c in zip(*(fade(float(s), int(e)) for s, e in zip(times, seeds))))
    _step(
        S, np.array(laws["gravity"], F), F(laws["linear"]), F(laws["quadratic"]), amounts.astype(F), finenesses.astype(F),
        offsets.astype(F), blends.astype(F), scales.astype(F), epochs.astype(U), F(h),
    )  # fmt: skip


@numba.njit(parallel=True, fastmath=True)
def numba_pairs(x, m, softening2, out):
    """The sums of m d / s^3 over all pairs, s^2 = d^2 + softening2, for x (3, n) and out (3, n)."""
    n = x.shape[1]
    for i in numba.prange(n):
        ax, ay, az = F(0), F(0), F(0)
        for j in range(n):
            dx, dy, dz = x[0, j] - x[0, i], x[1, j] - x[1, i], x[2, j] - x[2, i]
            s2 = dx * dx + dy * dy + dz * dz + softening2
            w = m[j] / (s2 * np.sqrt(s2))
            ax, ay, az = ax + w * dx, ay + w * dy, az + w * dz
        out[0, i], out[1, i], out[2, i] = ax, ay, az


@numba.njit(parallel=True, fastmath=True)
def numba_light(S, g, k, h, steps):
    """Leapfrog steps of S (6, n) under gravity and damping, its blocks in the cache."""
    half = F(0.5) * h
    gain = -F(np.expm1(-k * half)) / k
    for b in numba.prange((S.shape[1] + 2047) // 2048):
        for _ in range(steps):
            for i in range(b * 2048, min((b + 1) * 2048, S.shape[1])):
                for c in range(3):
                    v = S[3 + c, i] + gain * (g[c] - k * S[3 + c, i])
                    S[c, i] += h * v
                    S[3 + c, i] = v + gain * (g[c] - k * v)


@numba.njit(parallel=True, fastmath=True)
def _turbulent(S, gravity, k, amounts, finenesses, offsets, blends, scales, epochs, h):
    half = F(0.5) * h
    gain = -F(np.expm1(-k * h)) / k
    for i in numba.prange(S.shape[1]):
        vx, vy, vz = S[3, i], S[4, i], S[5, i]
        x, y, z = S[0, i] + half * vx, S[1, i] + half * vy, S[2, i] + half * vz
        ax, ay, az = gravity[0], gravity[1], gravity[2]
        for o in range(amounts.shape[0]):
            f, shift = finenesses[o], offsets[o]
            p, q, r = curl(x * f + shift, y * f + shift, z * f + shift, blends[o], scales[o], epochs[o])
            ax, ay, az = ax + amounts[o] * p, ay + amounts[o] * q, az + amounts[o] * r
        vx, vy, vz = vx + gain * (ax - k * vx), vy + gain * (ay - k * vy), vz + gain * (az - k * vz)
        S[0, i], S[1, i], S[2, i] = x + half * vx, y + half * vy, z + half * vz
        S[3, i], S[4, i], S[5, i] = vx, vy, vz


def numba_turbulent(S, noise: dict, gravity: tuple, rate: float, now: float, h: float) -> None:
    """One drift-kick-drift step of S (6, n) under gravity, damping and curl noise."""
    t = now + 0.5 * h
    octaves = [octave(noise, k, t) for k in range(noise["octaves"])]
    amounts, finenesses, offsets, seeds, times = (np.array(c) for c in zip(*octaves))
    blends, scales, epochs = (np.array(c) for c in zip(*(fade(float(s), int(e)) for s, e in zip(times, seeds))))
    _turbulent(
        S, np.array(gravity, F), F(rate), amounts.astype(F), finenesses.astype(F), offsets.astype(F), blends.astype(F),
        scales.astype(F), epochs.astype(U), F(h),
    )  # fmt: skip


@numba.njit(parallel=True, fastmath=True)
def numba_boris(S, field, moment, softening2, ratio, h, steps):
    """Boris's steps of S (6, n) in a uniform field and that of a dipole; ratio : charge over mass, C/kg."""
    half = F(0.5) * h
    for b in numba.prange((S.shape[1] + 2047) // 2048):
        for _ in range(steps):
            for i in range(b * 2048, min((b + 1) * 2048, S.shape[1])):
                vx, vy, vz = S[3, i], S[4, i], S[5, i]
                x, y, z = S[0, i] + half * vx, S[1, i] + half * vy, S[2, i] + half * vz
                r2 = x * x + y * y + z * z
                s2 = r2 + softening2
                along = F(3) * (moment[0] * x + moment[1] * y + moment[2] * z)
                across, share = F(2) * softening2 - r2, F(1e-7) / (s2 * s2 * np.sqrt(s2))
                q = ratio * half
                tx = q * (field[0] + (along * x + across * moment[0]) * share)
                ty = q * (field[1] + (along * y + across * moment[1]) * share)
                tz = q * (field[2] + (along * z + across * moment[2]) * share)
                k = F(2) / (ONE + tx * tx + ty * ty + tz * tz)
                ux, uy, uz = vx + vy * tz - vz * ty, vy + vz * tx - vx * tz, vz + vx * ty - vy * tx
                vx, vy, vz = vx + k * (uy * tz - uz * ty), vy + k * (uz * tx - ux * tz), vz + k * (ux * ty - uy * tx)
                S[0, i], S[1, i], S[2, i] = x + half * vx, y + half * vy, z + half * vz
                S[3, i], S[4, i], S[5, i] = vx, vy, vz


@numba.njit(inline="always")
def mixed(z):
    z = (z ^ (z >> W(30))) * W(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> W(27))) * W(0x94D049BB133111EB)
    return z ^ (z >> W(31))


@numba.njit
def drawn(low, high, channel):
    """A number of Philox-2x32-10 in (0, 1), as a float32."""
    x, y, k = low, channel, high
    for _ in range(10):
        product = W(x) * W(0xD256D193)
        x, y = U(U(product >> W(32)) ^ k ^ y), U(product)
        k = U(k + U(0x9E3779B9))
    return F(np.float64(x) * 2.0**-32 + np.float64(y >> U(12)) * 2.0**-52 + 2.0**-53)


@numba.njit(parallel=True, fastmath=True)
def _give_birth(S, birth, life, n, key, first, count, rate, lives, channel, angle, speeds):
    tau = F(6.283185307179586)
    for i in numba.prange(count):
        slot, serial = n + i, W(first + i)
        inner = mixed(serial * W(0x9E3779B97F4A7C15) + W(0xD1B54A32D192ED03))
        own = mixed((key ^ inner) + W(0x9E3779B97F4A7C15))
        low, high = U(own & W(0xFFFFFFFF)), U(own >> W(32))
        birth[slot] = (first + i + 0.5) / rate
        life[slot] = lives[0] + (lives[1] - lives[0]) * drawn(low, high, channel)
        c = ONE - drawn(low, high, U(11)) * (ONE - F(np.cos(angle)))
        s, azimuth = F(np.sqrt(max(ONE - c * c, F(0)))), tau * drawn(low, high, U(12))
        speed = speeds[0] + (speeds[1] - speeds[0]) * drawn(low, high, U(13))
        S[0, slot], S[1, slot], S[2, slot] = F(0), F(0), F(0)
        # the frame about the axis (0, 1, 0): (0, 0, 1) and (1, 0, 0)
        S[3, slot], S[4, slot] = speed * s * F(np.sin(azimuth)), speed * c
        S[5, slot] = speed * s * F(np.cos(azimuth))


@numba.njit(parallel=True, fastmath=True)
def _step_the_living(S, birth, life, n, g, k, now, dt):
    for i in numba.prange(n):
        since = birth[i] - now
        h = F(max(min(since + np.float64(life[i]), dt) - max(since, 0.0), 0.0))
        gain = -F(np.expm1(-k * F(0.5) * h)) / k
        for c in range(3):
            v = S[3 + c, i] + gain * (g[c] - k * S[3 + c, i])
            S[c, i] += h * v
            S[3 + c, i] = v + gain * (g[c] - k * v)


@numba.njit(parallel=True)
def _remove_the_dead(S, birth, life, n, now):
    kept = np.empty(n, np.int32)
    m = 0
    for i in range(n):
        if birth[i] + np.float64(life[i]) > now:
            kept[m] = i
            m += 1
    for c in numba.prange(8):
        for j in range(m):
            if c < 6:
                S[c, j] = S[c, kept[j]]
            elif c == 6:
                birth[j] = birth[kept[j]]
            else:
                life[j] = life[kept[j]]
    return m


class NumbaFountain:
    """Particles that are born at a point, into a cone about (0, 1, 0), move under gravity and damping, and die.

    Births at their own times within a step, the living in the order of their births, the dead removed when there are many.
    key : of the emitter's random numbers
    """

    def __init__(self, room: int, key, rate: float, lives, channel: int, angle: float, speeds):
        self.S, self.birth, self.life = np.zeros((6, room), F), np.zeros(room), np.zeros(room, F)
        self.key, self.rate, self.lives, self.channel = W(key), rate, np.array(lives, F), U(channel)
        self.angle, self.speeds = F(angle), np.array(speeds, F)
        self.n, self.born, self.counted, self.steps = 0, 0, 0, 0

    def step(self, g, k, dt: float) -> None:
        now = self.steps * dt
        if self.born - self.counted > 0.3 * self.n:
            self.n, self.counted = _remove_the_dead(self.S, self.birth, self.life, self.n, now), self.born
        count = int(np.floor((now + dt) * self.rate + 0.5)) - self.born
        _give_birth(
            self.S, self.birth, self.life, self.n, self.key, self.born, count, self.rate, self.lives, self.channel, self.angle,
            self.speeds,
        )  # fmt: skip
        self.n, self.born = self.n + count, self.born + count
        _step_the_living(self.S, self.birth, self.life, self.n, g, k, now, dt)
        self.steps += 1
