"""The free rotation of rigid bodies at constant angular momentum L.

The kinetic energy sum L_k^2 / 2 I_k is split into L^2 / 2 I_2, which rotates the body about L, and one rotation about each of
the two other principal axes. The composition is symmetric, so that three of them have order 4. It keeps L exactly and the
energy bounded, and is exact where two moments are equal.
Sources: Touma & Wisdom (1994), AJ 107, 1189; Yoshida (1990), Phys. Lett. A 150, 262.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

import numpy as np

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions.rigid.body import AXLED, STATIC
from gen_art.interactions.rigid.small_matrices import dot
from gen_art.maths.elementary import cos, sin

__all__ = ["MAX_ANGLE", "inverse_inertia", "rotation_kernel", "splitting_table"]

MAX_ANGLE = 0.02  # rad, the largest rotation of one part of a step: the energy error is then round-off
_OUTER = 1 / (2 - 2 ** (1 / 3))  # the outer two of the three parts of a step of order 4

# columns of the splitting table; for bodies that are held, the first axis is one of the two values at the end
_FIRST_AXIS, _SECOND_AXIS = 0, 1  # principal axes
_FIRST_RATE, _SECOND_RATE = 2, 3  # 1/(kg m^2), 1 / their moments less 1 / the middle moment
_INVERSE_MOMENT = 4  # 1/(kg m^2), of the middle axis, or of the axle
_SPHERICAL = 5  # 1 where all moments are equal
_COLUMNS = 6
_ON_AXLE, _STATIC = -1.0, -2.0


def inverse_inertia(inertia: np.ndarray, constraint: np.ndarray, axle: np.ndarray) -> np.ndarray:
    """The inverse inertia (b, 3, 3) in the bodies' frames, 0 for rotations that a body's constraint forbids.

    inertia : (b, 3) kg m^2, principal moments
    constraint : (b,) FREE, PIVOTED, AXLED or STATIC
    axle : (b, 3)
    """
    out = np.zeros((len(inertia), 3, 3))
    for k in range(3):
        out[:, k, k] = 1 / inertia[:, k]
    about_axle = axle[:, :, None] * axle[:, None, :] / dot(inertia * axle, axle)[:, None, None]
    out = np.where((constraint == AXLED)[:, None, None], about_axle, out)
    out[constraint == STATIC] = 0.0
    return out


def splitting_table(inertia: np.ndarray, constraint: np.ndarray, axle: np.ndarray) -> np.ndarray:
    """How the kernel splits each body's rotation, (b, 6); arguments as of inverse_inertia.

    The first axis is the one whose moment is nearer to the middle moment.
    """
    table = np.zeros((len(inertia), _COLUMNS))
    for row, moments, kind, direction in zip(table, inertia, constraint, axle):
        low, middle, high = np.argsort(moments, kind="stable")
        first, second = (low, high) if moments[high] - moments[middle] > moments[middle] - moments[low] else (high, low)
        row[_FIRST_AXIS], row[_SECOND_AXIS] = first, second
        row[_FIRST_RATE] = 1 / moments[first] - 1 / moments[middle]
        row[_SECOND_RATE] = 1 / moments[second] - 1 / moments[middle]
        row[_INVERSE_MOMENT] = 1 / moments[middle]
        row[_SPHERICAL] = 1.0 if moments[high] - moments[low] <= 1e-12 * moments[high] else 0.0
        if kind == AXLED:
            row[:] = 0
            row[_FIRST_AXIS], row[_INVERSE_MOMENT] = _ON_AXLE, 1 / float(dot(moments * direction, direction))
        if kind == STATIC:
            row[_FIRST_AXIS] = _STATIC
    return table


@ti.func
def _product(p, q):
    """The rotation q followed by p, as a unit quaternion (w, x, y, z)."""
    u, v = ti.Vector([p[1], p[2], p[3]]), ti.Vector([q[1], q[2], q[3]])
    w = u.cross(v) + p[0] * v + q[0] * u
    result = ti.Vector([p[0] * q[0] - u.dot(v), w[0], w[1], w[2]])
    return result / result.norm()


@ti.func
def _rotation(v):
    """The unit quaternion of the rotation vector v, rad."""
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
def _rotate_about_axis(q, L, k, factor):
    """q rotated about the body's own axis k by the component of L along it times `factor`, s/(kg m^2)."""
    a = _axis(q, k)
    return _product(_rotation(a * (a.dot(L) * factor)), q)


@cache
def rotation_kernel():
    """rotate(Q, A, P, axle, h, max_angle): advance the attitudes Q by h, s.

    Q (b, 4): quaternions
    A (b, 3): angular momenta, kg m^2/s
    P (b, 6): the splitting table
    axle (b, 3): in the bodies' frames
    A body that rotates by more than `max_angle`, rad, does so in parts. Their number depends on the length of L alone, which
    is constant.
    """
    matrix = ti.types.ndarray(ti.f64, 2)

    @ti.kernel
    def rotate(Q: matrix, A: matrix, P: matrix, axle: matrix, h: ti.f64, max_angle: ti.f64):
        ti.loop_config(block_dim=1)
        for b in range(Q.shape[0]):
            q = ti.Vector([Q[b, 0], Q[b, 1], Q[b, 2], Q[b, 3]])
            L = ti.Vector([A[b, 0], A[b, 1], A[b, 2]])
            direction = ti.Vector([axle[b, 0], axle[b, 1], axle[b, 2]])
            inverse_moment = P[b, _INVERSE_MOMENT]
            if P[b, _FIRST_AXIS] == _ON_AXLE:
                world_axle = direction * 0.0
                for k in range(3):
                    world_axle += _axis(q, k) * axle[b, k]
                q = _product(_rotation(world_axle * (world_axle.dot(L) * inverse_moment * h)), q)
            if P[b, _FIRST_AXIS] >= 0.0 and L.norm() > 0.0:
                first, second = ti.cast(P[b, _FIRST_AXIS], ti.i32), ti.cast(P[b, _SECOND_AXIS], ti.i32)
                fastest = ti.max(inverse_moment, ti.max(P[b, _FIRST_RATE], P[b, _SECOND_RATE]) + inverse_moment)
                parts = ti.cast(ti.ceil(L.norm() * fastest * ti.abs(h) / max_angle), ti.i32)
                substeps = 3
                if P[b, _SPHERICAL] > 0.0:
                    parts, substeps = 1, 1
                for part in range(parts):
                    for r in range(substeps):
                        step = h / parts
                        if substeps == 3:
                            step *= ti.select(r == 1, 1.0 - 2.0 * _OUTER, _OUTER)
                        q = _rotate_about_axis(q, L, first, P[b, _FIRST_RATE] * 0.5 * step)
                        q = _rotate_about_axis(q, L, second, P[b, _SECOND_RATE] * step)
                        q = _product(_rotation(L * (inverse_moment * step)), q)
                        q = _rotate_about_axis(q, L, first, P[b, _FIRST_RATE] * 0.5 * step)
            for k in ti.static(range(4)):
                Q[b, k] = q[k]

    return runtime.kernel(rotate, "f64")
