"""The light of other particles on smoke: a fire under its own smoke, a burst in the smoke of the one before.

Particles that give off light are summed in coarse cells of the world, each at the centre of its light. A node of the smoke
at distance r from a cell of power P (radiance times area) and spread e (the root mean square distance of its light from
its centre) scatters

    P / (r^2 + e^2 + softness^2) * sum over i of w_i  4 pi p(cos, g 2^-i)  exp(-t 2^-i)  / (4 pi)

towards the camera, t being the optical depth between the two, in STEPS samples; a quarter of a grid cell squared is
added to the squares, as a node stands for a cell of smoke. Only light that the camera could see
counts: what is behind it is not drawn and shines on nothing.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp
from gen_art.preset.look import KeyLight
from gen_art.renderer.smoke_density import Smoke

__all__ = ["EmittedLight", "gathered", "glow_on"]

CELLS = 8  # cells of light along the longest side of what gives it off
STEPS = 10

F1, F2, F64 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f64, 1)


@dataclass(frozen=True)
class EmittedLight:
    """Light of others: positions (m, 3), power (m, 3) linear radiance times area."""

    positions: np.ndarray
    power: np.ndarray


def gathered(positions, power) -> np.ndarray:
    """(k, 7) float64: position, power and squared spread of the light in each cell that has any."""
    total = np.asarray(power, np.float64)
    weight = total.sum(axis=1)
    some = np.flatnonzero(weight > 0.0)
    if not len(some):
        return np.zeros((0, 7))
    x, total, weight = np.asarray(positions, np.float64)[some], total[some], weight[some]
    low, high = x.min(axis=0), x.max(axis=0)
    extent = max(float((high - low).max()), 1e-6 * (1.0 + float(np.abs(x).max())))
    cell = 2.0 ** np.ceil(np.log2(extent / CELLS))
    first = np.floor(low / cell)
    index = (np.floor(x / cell) - first).astype(np.int64)
    shape = (np.floor(high / cell) - first).astype(np.int64) + 1
    _, at = np.unique((index[:, 0] * shape[1] + index[:, 1]) * shape[2] + index[:, 2], return_inverse=True)
    all_of = np.bincount(at, weight)
    centre = np.stack([np.bincount(at, weight * x[:, c]) for c in range(3)], axis=1) / all_of[:, None]
    away = ((x - centre[at]) ** 2).sum(axis=1)
    sums = [np.bincount(at, total[:, c]) for c in range(3)]
    return np.column_stack([centre, *sums, np.bincount(at, weight * away) / all_of])


@ti.kernel
def _glow(
    dense: F1, d0: ti.i32, d1: ti.i32, d2: ti.i32, lights: F2, count: ti.i32, Q: F64, octaves: ti.i32, out: F2
):  # fmt: skip
    ti.loop_config(block_dim=1)
    for j in range(d0):
        for k in range(d1):
            for m in range(d2):
                rgb = ti.Vector([0.0, 0.0, 0.0])
                eye = ti.Vector([ti.cast(Q[e], ti.f32) for e in range(3)])
                node = ti.Vector([ti.cast(j, ti.f32), ti.cast(k, ti.f32), ti.cast(m, ti.f32)])
                seen = eye - node * ti.cast(1.0 - Q[3], ti.f32)
                seen = seen / ti.max(seen.norm(), 1e-30)
                lights_here = count
                if dense[(j * d1 + k) * d2 + m] == 0.0:  # no smoke within a cell: nothing reads this node
                    lights_here = 0
                for l in range(lights_here):
                    way = node - ti.Vector([lights[l, 0], lights[l, 1], lights[l, 2]])
                    r2 = way.dot(way)
                    t = 0.0
                    for s in range(STEPS):
                        back = (ti.cast(s, ti.f32) + 0.5) * (1.0 / STEPS)
                        a = ti.cast(node[0] - way[0] * back + 0.5, ti.i32)
                        b = ti.cast(node[1] - way[1] * back + 0.5, ti.i32)
                        c = ti.cast(node[2] - way[2] * back + 0.5, ti.i32)
                        inside = a >= 0 and b >= 0 and c >= 0 and a < d0 and b < d1 and c < d2
                        if inside:
                            t += dense[(a * d1 + b) * d2 + c]
                    r = ti.sqrt(r2)
                    t *= r * ti.cast(Q[4], ti.f32) * (1.0 / STEPS)
                    cosine = way.dot(seen) / ti.max(r, 1e-30)
                    sent = 0.0
                    for o in range(octaves):
                        g = ti.cast(Q[5 + octaves + o], ti.f32)
                        turn = ti.max(1.0 + g * g - 2.0 * g * cosine, 1e-6)
                        p = (1.0 - g * g) / (turn * ti.sqrt(turn))
                        sent += ti.cast(Q[5 + o], ti.f32) * p * exp(-t / ti.cast(1 << o, ti.f32))
                    sent /= r2 + lights[l, 6]
                    for e in ti.static(range(3)):
                        rgb[e] += sent * lights[l, 3 + e]
                for e in ti.static(range(3)):
                    out[(j * d1 + k) * d2 + m, e] = rgb[e]


glow = kernel(_glow)


def glow_on(
    few: Smoke, smoke: Smoke, source: EmittedLight, light: KeyLight, weights, eye, parallel: bool
) -> np.ndarray:
    """(a, b, c, 3) light that each node of `smoke` scatters towards the camera at `eye` (its direction if `parallel`),
    found on the nodes of `few`, the same or a coarser grid, and linear between them.
    """
    lights = gathered(source.positions, source.power)
    out = np.zeros((few.dense.size, 3), np.float32)
    if len(lights):
        octaves = len(weights)
        q = np.zeros(5 + 2 * octaves)
        q[:3] = -few.axes @ np.asarray(eye) if parallel else few.axes @ np.asarray(eye) / few.cell - few.corner
        q[3], q[4] = parallel, 1.0 / few.cell**2
        q[5:] = np.concatenate([weights, light.phase * 0.5 ** np.arange(octaves)])
        lights[:, :3] = lights[:, :3] @ few.axes.T / few.cell - few.corner
        lights[:, 3:6] *= light.glow_intensity / (4.0 * np.pi * few.cell**2)
        lights[:, 6] = (lights[:, 6] + light.glow_softness**2) / few.cell**2 + 0.25
        glow(few.dense.reshape(-1), *few.dense.shape, lights.astype(np.float32), len(lights), q, octaves, out)
    out = out.reshape(*few.dense.shape, 3)
    while out.shape[0] < smoke.dense.shape[0]:
        for axis in range(3):
            a = np.moveaxis(out, axis, 0)
            finer = np.empty((2 * len(a) - 1, *a.shape[1:]), np.float32)
            finer[::2], finer[1::2] = a, 0.5 * (a[:-1] + a[1:])
            out = np.moveaxis(finer, 0, axis)
    return np.ascontiguousarray(out)
