"""The free motion of rigid bodies: turning with their angular momentum, which stays.

The kinetic energy sum L_k^2 / 2 I_k is split into L^2 / 2 I_2, a turn about L, and one turn about each of the two other
principal axes. The composition is symmetric, so that three of them make order 4; it keeps L exactly, the energy in bounds,
and is exact where two moments are equal.
Sources: Touma & Wisdom (1994), AJ 107, 1189; Yoshida (1990), Phys. Lett. A 150, 262.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.rigid.body import AXLED, STATIC
from gen_art.maths.elementary import cos, sin

__all__ = ["ANGLE", "inverse_inertia", "plan", "turn_kernel"]

ANGLE = 0.02  # rad, the most that a part of a step turns: what is left of the energy error is round-off
_OUTER = 1 / (2 - 2 ** (1 / 3))


def inverse_inertia(inertia: np.ndarray, hold: np.ndarray, axle: np.ndarray) -> np.ndarray:
    """(b, 3, 3) in the bodies' frames, of what they may do: (b, 3) moments, how they are held (b,), their axles (b, 3)."""
    out = np.zeros((len(inertia), 3, 3))
    for k in range(3):
        out[:, k, k] = 1 / inertia[:, k]
    about = np.einsum("bi,bj->bij", axle, axle) / (inertia * axle * axle).sum(1)[:, None, None]
    out = np.where((hold == AXLED)[:, None, None], about, out)
    out[hold == STATIC] = 0.0
    return out


def plan(inertia: np.ndarray, hold: np.ndarray, axle: np.ndarray) -> np.ndarray:
    """(b, 6) for the kernel: the axis whose moment is nearer to the middle one, the other, their rates, 1 / middle moment,
    and 1 where all three are equal. For a body on an axle -1, 0, 0, 0, 1 / moment about it, 0; for one that is static -2."""
    out = np.zeros((len(inertia), 6))
    for row, moments, held, along in zip(out, inertia, hold, axle):
        low, middle, high = np.argsort(moments, kind="stable")
        one, two = (low, high) if moments[high] - moments[middle] > moments[middle] - moments[low] else (high, low)
        rates = [1 / moments[k] - 1 / moments[middle] for k in (one, two)]
        row[:] = (
            one,
            two,
            *rates,
            1 / moments[middle],
            1.0 if moments[high] - moments[low] <= 1e-12 * moments[high] else 0.0,
        )
        if held == AXLED:
            row[:] = -1, 0, 0, 0, 1 / (moments * along * along).sum(), 0
        if held == STATIC:
            row[0] = -2
    return out


@ti.func
def _product(p, q):
    """The turn q, then p, as a unit quaternion (w, x, y, z)."""
    u, v = ti.Vector([p[1], p[2], p[3]]), ti.Vector([q[1], q[2], q[3]])
    w = u.cross(v) + p[0] * v + q[0] * u
    both = ti.Vector([p[0] * q[0] - u.dot(v), w[0], w[1], w[2]])
    return both / both.norm()


@ti.func
def _rotation(v):
    angle = v.norm()
    s = 0.5 - angle * angle / 48.0
    if angle > 1e-4:
        s = sin(0.5 * angle) / angle
    return ti.Vector([cos(0.5 * angle), s * v[0], s * v[1], s * v[2]])


@ti.func
def _axis(q, k):
    """The body's own axis k in the world."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    a = ti.Vector([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)])
    if k == 1:
        a = ti.Vector([2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)])
    if k == 2:
        a = ti.Vector([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)])
    return a


@ti.func
def _about(q, L, k, time):
    """Turn about the body's own axis k by its part of L times `time`, which is over a moment of inertia."""
    a = _axis(q, k)
    return _product(_rotation(a * (a.dot(L) * time)), q)


@cache
def turn_kernel():
    """turn(q, L, P, axle, h, angle): attitudes q (b, 4) after h, s, under angular momentum L (b, 3); P of `plan`; axle (b, 3).

    A body that turns by more than `angle`, rad, does so in parts, whose number is the same as long as L is.
    """
    matrix = ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def turn(Q: matrix, A: matrix, P: matrix, axle: matrix, h: ti.f64, angle: ti.f64):
        ti.loop_config(block_dim=1)
        for b in range(Q.shape[0]):
            q = ti.Vector([Q[b, 0], Q[b, 1], Q[b, 2], Q[b, 3]])
            L = ti.Vector([A[b, 0], A[b, 1], A[b, 2]])
            along = ti.Vector([axle[b, 0], axle[b, 1], axle[b, 2]])
            ease = P[b, 4]
            if P[b, 0] == -1.0:
                own = along * 0.0
                for k in range(3):
                    own += _axis(q, k) * axle[b, k]
                q = _product(_rotation(own * (own.dot(L) * ease * h)), q)
            if P[b, 0] >= 0.0 and L.norm() > 0.0:
                one, two = ti.cast(P[b, 0], ti.i32), ti.cast(P[b, 1], ti.i32)
                fastest = ti.max(ease, ti.max(P[b, 2], P[b, 3]) + ease)
                parts = ti.cast(ti.ceil(L.norm() * fastest * ti.abs(h) / angle), ti.i32)
                rounds = 3
                if P[b, 5] > 0.0:
                    parts, rounds = 1, 1
                for part in range(parts):
                    for r in range(rounds):
                        share = h / parts
                        if rounds == 3:
                            share *= ti.select(r == 1, 1.0 - 2.0 * _OUTER, _OUTER)
                        q = _about(q, L, one, P[b, 2] * 0.5 * share)
                        q = _about(q, L, two, P[b, 3] * share)
                        q = _product(_rotation(L * (ease * share)), q)
                        q = _about(q, L, one, P[b, 2] * 0.5 * share)
            for k in ti.static(range(4)):
                Q[b, k] = q[k]

    return runtime.kernel(turn, "f64")
