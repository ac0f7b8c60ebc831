"""Light that other particles emit onto smoke: a fire below its own smoke, a burst inside the smoke of the one before.

The emitting particles are clustered in coarse cells of the world, each with its light's centre. A node of the smoke at
distance r from a cell of power P (radiance times area) and spread e (the root mean square distance of the cell's light from
its centre) scatters

    P / (r^2 + e^2 + softness^2) * sum over i of w_i  4 pi p(cos, g 2^-i)  exp(-t 2^-i)  / (4 pi)

towards the camera, where t is the optical depth between the two, summed over SAMPLES samples. A quarter of a squared grid cell
is added to the squares, because a node stands for a cell of smoke. Only light that the camera could see counts: particles
behind the camera are not drawn and illuminate nothing.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass, field

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp
from gen_art.preset.look import Light
from gen_art.renderer.smoke_density import Smoke

__all__ = ["EmittedLight", "cluster_lights", "scatter_emitted_light"]

CELLS = 8  # cells along the longest side of the emitting particles
SAMPLES = 10  # of the optical depth between a light and a node
POWER, SPREAD2 = 3, 6  # columns of the clustered lights, after the position: power (3) and squared spread
PARALLEL, DEPTH_SCALE, OCTAVE = 3, 4, 5  # the kernel's numbers, after the eye; OCTAVE: weights, then asymmetries

F1, F2, F64 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f64, 1)


@dataclass(frozen=True)
class EmittedLight:
    """The light that other particles emit.

    positions : (m, 3)
    power : (m, 3) linear radiance times area
    areas : (m,) cross sections, which surfaces near by need; () elsewhere
    """

    positions: np.ndarray
    power: np.ndarray
    areas: np.ndarray = field(default_factory=lambda: np.zeros(0))


def cluster_lights(positions, power) -> np.ndarray:
    """(k, 7) float64: position, power and squared spread of the light in each cell that holds any."""
    total = np.asarray(power, np.float64)
    weight = total.sum(axis=1)
    lit = np.flatnonzero(weight > 0.0)
    if not len(lit):
        return np.zeros((0, 7))
    x, total, weight = np.asarray(positions, np.float64)[lit], total[lit], weight[lit]
    low, high = x.min(axis=0), x.max(axis=0)
    extent = max(float((high - low).max()), 1e-6 * (1.0 + float(np.abs(x).max())))
    cell = 2.0 ** np.ceil(np.log2(extent / CELLS))
    first = np.floor(low / cell)
    index = (np.floor(x / cell) - first).astype(np.int64)
    shape = (np.floor(high / cell) - first).astype(np.int64) + 1
    _, cell_of = np.unique((index[:, 0] * shape[1] + index[:, 1]) * shape[2] + index[:, 2], return_inverse=True)
    cell_weight = np.bincount(cell_of, weight)
    centre = np.stack([np.bincount(cell_of, weight * x[:, c]) for c in range(3)], axis=1) / cell_weight[:, None]
    distance2 = ((x - centre[cell_of]) ** 2).sum(axis=1)
    sums = [np.bincount(cell_of, total[:, c]) for c in range(3)]
    return np.column_stack([centre, *sums, np.bincount(cell_of, weight * distance2) / cell_weight])


@ti.kernel
def _scatter_emitted_light(
    extinction: F1, d0: ti.i32, d1: ti.i32, d2: ti.i32, lights: F2, count: ti.i32, Q: F64, octaves: ti.i32, out: F2
):  # fmt: skip
    """Each node's sum over the clustered lights, whose lengths are in cells.

    d0, d1, d2 : shape of the grid `extinction`
    Q : eye in cells, PARALLEL, DEPTH_SCALE (extinction to optical depth per cell), then OCTAVE
    """
    ti.loop_config(block_dim=1)
    for j in range(d0):
        for k in range(d1):
            for m in range(d2):
                rgb = ti.Vector([0.0, 0.0, 0.0])
                eye = ti.Vector([ti.cast(Q[e], ti.f32) for e in range(3)])
                node = ti.Vector([ti.cast(j, ti.f32), ti.cast(k, ti.f32), ti.cast(m, ti.f32)])
                to_camera = eye - node * ti.cast(1.0 - Q[PARALLEL], ti.f32)
                to_camera = to_camera / ti.max(to_camera.norm(), 1e-30)
                lights_here = count
                if extinction[(j * d1 + k) * d2 + m] == 0.0:  # no smoke near this node: its value is never read
                    lights_here = 0
                for l in range(lights_here):
                    offset = node - ti.Vector([lights[l, 0], lights[l, 1], lights[l, 2]])
                    distance2 = offset.dot(offset)
                    depth = 0.0
                    for s in range(SAMPLES):
                        fraction = (ti.cast(s, ti.f32) + 0.5) * (1.0 / SAMPLES)
                        a = ti.cast(node[0] - offset[0] * fraction + 0.5, ti.i32)
                        b = ti.cast(node[1] - offset[1] * fraction + 0.5, ti.i32)
                        c = ti.cast(node[2] - offset[2] * fraction + 0.5, ti.i32)
                        inside = a >= 0 and b >= 0 and c >= 0 and a < d0 and b < d1 and c < d2
                        if inside:
                            depth += extinction[(a * d1 + b) * d2 + c]
                    distance = ti.sqrt(distance2)
                    depth *= distance * ti.cast(Q[DEPTH_SCALE], ti.f32) * (1.0 / SAMPLES)
                    cosine = offset.dot(to_camera) / ti.max(distance, 1e-30)
                    scattered = 0.0
                    for o in range(octaves):
                        g = ti.cast(Q[OCTAVE + octaves + o], ti.f32)
                        denominator = ti.max(1.0 + g * g - 2.0 * g * cosine, 1e-6)
                        phase = (1.0 - g * g) / (denominator * ti.sqrt(denominator))
                        scattered += ti.cast(Q[OCTAVE + o], ti.f32) * phase * exp(-depth / ti.cast(1 << o, ti.f32))
                    scattered /= distance2 + lights[l, SPREAD2]
                    for e in ti.static(range(3)):
                        rgb[e] += scattered * lights[l, POWER + e]
                for e in ti.static(range(3)):
                    out[(j * d1 + k) * d2 + m, e] = rgb[e]


_scatter_kernel = kernel(_scatter_emitted_light)


def scatter_emitted_light(
    coarse: Smoke, smoke: Smoke, emitted: EmittedLight, light: Light, weights, eye, parallel: bool
) -> np.ndarray:
    """(a, b, c, 3) emitted light that each node of `smoke` scatters towards the camera.

    coarse : the same smoke or a coarser grid of it; the light is computed on its nodes and is linear between them
    weights : of the octaves, see smoke_lighting.octaves
    eye : (3,) position of the camera, or its direction if `parallel`
    """
    lights = cluster_lights(emitted.positions, emitted.power)
    out = np.zeros((coarse.extinction.size, 3), np.float32)
    if len(lights):
        octaves = len(weights)
        q = np.zeros(OCTAVE + 2 * octaves)
        axes = coarse.axes
        q[:3] = -axes @ np.asarray(eye) if parallel else axes @ np.asarray(eye) / coarse.cell - coarse.corner
        q[PARALLEL], q[DEPTH_SCALE] = parallel, 1.0 / coarse.cell**2
        q[OCTAVE:] = np.concatenate([weights, light.phase * 0.5 ** np.arange(octaves)])
        lights[:, :3] = lights[:, :3] @ axes.T / coarse.cell - coarse.corner
        lights[:, POWER : POWER + 3] *= light.glow_intensity / (4.0 * np.pi * coarse.cell**2)
        lights[:, SPREAD2] = (lights[:, SPREAD2] + light.glow_softness**2) / coarse.cell**2 + 0.25
        smoke_arguments = coarse.extinction.reshape(-1), *coarse.extinction.shape
        _scatter_kernel(*smoke_arguments, lights.astype(np.float32), len(lights), q, octaves, out)
    out = out.reshape(*coarse.extinction.shape, 3)
    while out.shape[0] < smoke.extinction.shape[0]:
        for axis in range(3):
            a = np.moveaxis(out, axis, 0)
            finer = np.empty((2 * len(a) - 1, *a.shape[1:]), np.float32)
            finer[::2], finer[1::2] = a, 0.5 * (a[:-1] + a[1:])
            out = np.moveaxis(finer, 0, axis)
    return np.ascontiguousarray(out)
