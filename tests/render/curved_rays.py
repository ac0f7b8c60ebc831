"""Rays through an Ellis wormhole, found in another way than the renderer's: as rays in a medium in flat space.

With l = rho - 1 / (4 rho), in units of a, the space dl^2 + (l^2 + 1) dOmega^2 is n(rho)^2 times flat space, n = 1 + 1 / (4 rho^2).
Light then follows d2X/dtau2 = grad(n^2) / 2, dX/dtau = n times a unit vector; rho = 1/2 is the throat, rho = 0 the other side's infinity.
"""

import numpy as np


def world(l, theta, phi, a=1.0):
    """(..., 3) world positions of points of the wormhole, whose axis is z."""
    across = np.sqrt(l * l + a * a) * np.sin(theta)
    return np.stack([across * np.cos(phi), across * np.sin(phi), l * np.cos(theta)], axis=-1)


def flat(l, theta, phi):
    """(..., 3) the same points in the flat space of the medium; l in units of a."""
    rho = 0.5 * (l + np.sqrt(l * l + 1.0)) if np.all(l > -2) else 0.5 / (np.sqrt(l * l + 1.0) - l)
    return rho[..., None] * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def frames(l, theta, phi):
    """Rows of unit vectors along l, theta and phi at one point: in the world and in the flat space of the medium."""
    h, q = 1e-6, np.array([l, theta, phi], float)
    rows = []
    for f in (world, flat):
        steps = [(f(*(q + h * e)[:, None]) - f(*(q - h * e)[:, None]))[0] for e in np.eye(3)]
        rows.append(np.stack([s / np.linalg.norm(s) for s in steps]))
    return rows


def _pull(x):
    r2 = np.sum(x * x, axis=-1, keepdims=True)
    return -(1.0 + 0.25 / r2) * 0.5 * x / (r2 * r2)


def index(x):
    return 1.0 + 0.25 / np.sum(x * x, axis=-1)


def trace(x, d, steps=4000, reach=0.004):
    """(steps + 1, n, 3) points of rays from x (n, 3) along unit vectors d, by Runge and Kutta's method of order 4.

    A step is `reach` of the distance to rho = 0 long.
    """
    p, points = d * index(x)[:, None], [x]
    for _ in range(steps):
        h = (reach * np.linalg.norm(x, axis=1) / np.linalg.norm(p, axis=1))[:, None]
        k1, m1 = p, _pull(x)
        k2, m2 = p + 0.5 * h * m1, _pull(x + 0.5 * h * k1)
        k3, m3 = p + 0.5 * h * m2, _pull(x + 0.5 * h * k2)
        k4, m4 = p + h * m3, _pull(x + h * k3)
        x, p = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), p + h / 6 * (m1 + 2 * m2 + 2 * m3 + m4)
        points.append(x)
    return np.array(points)


def miss(points, target):
    """(proper distance at which a ray (m, 3) passes a target (3,), direction of the ray there)."""
    a, b = points[:-1], points[1:]
    along = b - a
    t = np.clip(np.sum((target - a) * along, axis=1) / np.sum(along * along, axis=1), 0.0, 1.0)
    distance = np.linalg.norm(a + along * t[:, None] - target, axis=1)
    k = int(np.argmin(distance))
    return distance[k] * index(target), along[k] / np.linalg.norm(along[k])


def at_plane(points, target, normal):
    """The point at which a ray (m, 3) goes through the plane through `target` with this normal, nearest to the target."""
    side = (points - target) @ normal
    crossings = np.flatnonzero((side[:-1] <= 0.0) & (side[1:] > 0.0))
    t = side[crossings] / (side[crossings] - side[crossings + 1])
    found = points[crossings] + (points[crossings + 1] - points[crossings]) * t[:, None]
    return found[np.argmin(np.linalg.norm(found - target, axis=1))]
