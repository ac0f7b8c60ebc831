"""Smoke lit by a lamp, through the smoke itself, and by a sky around it.

By default, in the light of a whole scene, light is followed through the smoke by multiple_scattering.py, and only what a lamp
sends to a particle itself comes from this file. Otherwise, for each lamp of irradiance 4 pi `intensity`, behind an optical
depth t, a particle scatters towards the camera

    intensity * sum over i < OCTAVES of w_i  4 pi p(cos, g 2^-i)  exp(-t 2^-i),        w_i ~ s^i,  sum of w_i = 1

with s = `scatter`: light that was scattered before penetrates deeper and has lost more of its direction. The same sum without
p, averaged over 14 directions, gives the light of the sky. No particle gets more than the unshadowed light, so smoke never
scatters more light than comes in.
Source: Wrenninge, Kulla, Lundqvist, Oz: the great and volumetric (SIGGRAPH Talks 2013), with weights that sum to 1; Henyey
and Greenstein, Diffuse radiation in the galaxy (1941); the directions: Lebedev's rule.

The one-letter names in kernels are in docs/glossary.md.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths import array_functions
from gen_art.maths.elementary import exp
from gen_art.particles.rows import POSITION
from gen_art.preset.look import Light
from gen_art.renderer.emissive_lighting import EmittedLight, scatter_emitted_light
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.multiple_scattering import albedo_on_nodes, light_scattered_many_times
from gen_art.renderer.projected_particles import LIT_ALBEDO, LIT_EXTINCTION, LIT_POSITION, LIT_RADIUS
from gen_art.renderer.smoke_density import DIRECTIONS, WEIGHTS, Smoke
from gen_art.renderer.sprite import ALPHA, BLUE, DEPTH, RED

__all__ = [
    "OCTAVES", "LitParticles", "add_scattered_light", "lamp_axes", "octaves", "phase_function", "scattered_light",
    "scattered_light_of_system", "smoke_key",
]  # fmt: skip

OCTAVES = 4
_ALL_LIT = np.ones(1, np.float32)
SKY = 48  # cells along the longest side of the grid on which the sky's light is summed
FORWARD, EYE, PARALLEL, KEY, OCTAVE = 0, 3, 6, 7, 10  # the kernel's numbers; OCTAVE: weights, then asymmetries

F1, F2, F64 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f64, 1)


class LampShares(Protocol):
    """Things other than smoke that shadow a lamp."""

    def lamp_shares(self, light: Lighting, smoke: Smoke) -> np.ndarray:
        """(nodes,) float32: the share of the lamp's light that reaches each node of a grid of smoke."""
        ...


@dataclass(frozen=True)
class LitParticles:
    """Particles that scatter light.

    positions : (n, 3)
    cross_sections : (n,) extinction, m^2
    radii : (n,) of the sprites
    albedos : (n, 3), NaN where it is not known; None is white
    """

    light: Lighting
    positions: np.ndarray
    cross_sections: np.ndarray
    radii: np.ndarray
    albedos: np.ndarray | None = None


def phase_function(cosine, asymmetry: float):
    """Henyey and Greenstein's phase function p, per steradian; its integral over the sphere is 1.

    cosine : of the angle between the light's directions before and after scattering
    asymmetry : g, the mean cosine, -1 (back) to 1 (forward)
    """
    g = asymmetry
    return (1.0 - g * g) / (4.0 * np.pi * np.maximum(1.0 + g * g - 2.0 * g * np.asarray(cosine), 1e-6) ** 1.5)


def octaves(scatter: float | None) -> np.ndarray:
    """(OCTAVES,) weights of light that was scattered 0, 1, ... times before; their sum is 1. None: all of it 0 times."""
    weights = float(scatter or 0.0) ** np.arange(OCTAVES)
    return weights / weights.sum()


def lamp_axes(direction) -> np.ndarray:
    """Rows: two directions across the light, then its direction."""
    forward = np.asarray(direction, dtype=np.float64)
    forward = forward / np.linalg.norm(forward)
    side = np.cross(forward, (0.0, 1.0, 0.0) if abs(forward[1]) < 0.9 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(side, forward), forward])


@ti.kernel
def _scatter(
    X: F2, nodes: F2, n: ti.i32, depth: F1, d1: ti.i32, d2: ti.i32, sky: F2, s1: ti.i32, s2: ti.i32, coarse: ti.f32,
    reached: F1, Q: F64, out: F2,
):  # fmt: skip
    """The light that each of n particles scatters towards the camera: interpolated sky light plus the lamp's.

    X : (n, 3) positions
    nodes : (n, 3) the same in node coordinates of the smoke; times `coarse`, of the sky's grid
    depth : optical depth of the lamp's light at the nodes; d1, d2 : shape of its grid along the last two axes
    sky : (nodes, 3) sky light; s1, s2 : shape of its grid along the last two axes
    reached : share of the lamp's light that other things let through to the same nodes, or a single 1
    """
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for i in range(block * 2048, ti.min((block + 1) * 2048, n)):
            optical_depth, lamp = 0.0, 0.0
            rgb = ti.Vector([0.0, 0.0, 0.0])
            for table in ti.static(range(2)):  # 0: the lamp's optical depth, 1: the sky
                scale = coarse if ti.static(table) else 1.0
                x, y, z = nodes[i, 0] * scale, nodes[i, 1] * scale, nodes[i, 2] * scale
                j, k, m = ti.cast(x, ti.i32), ti.cast(y, ti.i32), ti.cast(z, ti.i32)
                fx, fy, fz = x - ti.cast(j, ti.f32), y - ti.cast(k, ti.f32), z - ti.cast(m, ti.f32)
                for corner in range(8):
                    a, b, c = corner >> 2, (corner >> 1) & 1, corner & 1
                    w = (
                        ti.select(a == 1, fx, 1.0 - fx)
                        * ti.select(b == 1, fy, 1.0 - fy)
                        * ti.select(c == 1, fz, 1.0 - fz)
                    )
                    if ti.static(table == 0):
                        optical_depth += w * depth[((j + a) * d1 + k + b) * d2 + m + c]
                    else:
                        node = ((j + a) * s1 + k + b) * s2 + m + c
                        if reached.shape[0] > 1:
                            lamp += w * reached[node]
                        for e in ti.static(range(3)):
                            rgb[e] += w * sky[node, e]
            cosine, length2 = 0.0, 0.0
            for e in ti.static(range(3)):
                direction = ti.cast(Q[EYE + e], ti.f32)
                if Q[PARALLEL] < 0.5:
                    direction = ti.cast(Q[EYE + e] - ti.cast(X[i, e], ti.f64), ti.f32)
                cosine += direction * ti.cast(Q[FORWARD + e], ti.f32)
                length2 += direction * direction
            cosine /= ti.max(ti.sqrt(length2), 1e-30)
            direct = 0.0
            for o in range(OCTAVES):
                g = ti.cast(Q[OCTAVE + OCTAVES + o], ti.f32)
                denominator = ti.max(1.0 + g * g - 2.0 * g * cosine, 1e-6)
                phase = (1.0 - g * g) / (denominator * ti.sqrt(denominator))
                direct += ti.cast(Q[OCTAVE + o], ti.f32) * phase * exp(-optical_depth / ti.cast(1 << o, ti.f32))
            if reached.shape[0] > 1:
                direct *= lamp
            for e in ti.static(range(3)):
                out[i, e] = rgb[e] + direct * ti.cast(Q[KEY + e], ti.f32)


_scatter_kernel = kernel(_scatter)


def _transmittance(depth: np.ndarray, weights) -> np.ndarray:
    """Sum of weights[i] exp(-depth / 2^i)."""
    octave = np.exp(depth * np.float32(-(0.5 ** (OCTAVES - 1))))
    total = np.float32(weights[-1]) * octave
    for w in weights[-2::-1]:
        octave = octave * octave
        total += np.float32(w) * octave
    return total


def _sky(light: Lighting, smoke: Smoke) -> np.ndarray:
    """(a, b, c, 3) the sky's light at each node of `smoke`, through the smoke from 14 sides."""
    sky = np.zeros((*smoke.extinction.shape, 3), np.float32)
    if not light.ambient.any():
        return sky
    weights = octaves(light.scatter)
    for direction, direction_weight in zip(DIRECTIONS, WEIGHTS):
        towards = -(direction / np.linalg.norm(direction)) @ smoke.axes
        transmittance = _transmittance(smoke.depth(direction), weights)
        sky += transmittance[..., None] * np.float32(direction_weight * light.radiance(towards))
    return sky


def _scattered_often(light: Lighting, smoke: Smoke, systems, cross_sections, glow, reached) -> np.ndarray:
    """(a, b, c, 3) the sky's light, and all that smoke has scattered already, at each node of `smoke`.

    cross_sections : (n,) of the particles of all systems
    glow : (a, b, c, 3) the light of other particles that each node scatters, or None
    reached : (nodes,) share of the lamp's light that things let through, or a single 1
    """
    positions = np.concatenate([s.positions for s in systems])
    white = [np.ones((len(s.positions), 3)) if s.albedos is None else s.albedos for s in systems]
    albedo = albedo_on_nodes(
        smoke, positions, cross_sections.astype(np.float64), np.concatenate(white).astype(np.float64)
    )
    g = light.key.phase
    # what is scattered forwards goes on as if it were not scattered: the same part as in the equation of the other light
    depth = smoke.depth((0, 0, 1)).reshape(-1) * np.float32(1.0 - float(albedo.mean()) * g)
    direct = array_functions.exp(-depth.astype(np.float64))[:, None] * reached.reshape(-1, 1) * light.lamp
    if glow is not None:
        direct = direct + glow.reshape(-1, 3)
    return light_scattered_many_times(smoke, albedo, g, direct, light.radiance).reshape(*smoke.extinction.shape, 3)


def _kernel_numbers(light: Lighting, eye, parallel: bool) -> np.ndarray:
    q = np.zeros(OCTAVE + 2 * OCTAVES)
    q[FORWARD : FORWARD + 3] = light.direction
    q[EYE : EYE + 3] = -np.asarray(eye) if parallel else eye
    q[PARALLEL] = parallel
    q[KEY : KEY + 3] = light.lamp
    q[OCTAVE : OCTAVE + OCTAVES] = octaves(light.scatter)
    q[OCTAVE + OCTAVES :] = light.key.phase * 0.5 ** np.arange(OCTAVES)
    return q


def smoke_key(light: Lighting) -> tuple:
    """What the grid of smoke depends on of a light: systems whose lights agree in it share a grid."""
    return (*light.direction.tolist(), light.key.resolution)


def scattered_light(
    systems: list[LitParticles], eye, parallel: bool = False, emitted: Sequence[EmittedLight | None] = (),
    smoke_by_lamp: dict | None = None, casters: LampShares | None = None,
) -> list[np.ndarray]:  # fmt: skip
    """For each system, (n, 3) float32 linear light that its particles scatter towards the camera, before their albedo.

    All systems shadow each other.
    eye : (3,) position of the camera
    parallel : the camera is orthographic and `eye` is the direction it looks in
    emitted : for each system, the light of others that it scatters, or None
    smoke_by_lamp : is filled: smoke_key -> the smoke, its optical depth from the lamp, the smoke on a coarser grid
    casters : what else shadows the lamp
    """
    positions, radii = (np.concatenate([getattr(s, n) for s in systems]) for n in ("positions", "radii"))
    cross_sections = np.concatenate([s.cross_sections * np.float32(s.light.key.depth) for s in systems])
    smoke_by_lamp = {} if smoke_by_lamp is None else smoke_by_lamp
    results: list[np.ndarray] = []
    followed: dict[int, np.ndarray] = {}
    for index, system in enumerate(systems):
        light = system.light
        key = smoke_key(light)
        if key not in smoke_by_lamp:
            smoke = Smoke.of(positions, cross_sections, radii, lamp_axes(light.direction), light.key.resolution)
            smoke_by_lamp[key] = (
                smoke,
                smoke.depth((0, 0, 1)).reshape(-1),
                smoke.coarse(1 if light.key.resolution <= 2 * SKY else 2),
            )
        q = _kernel_numbers(light, eye, parallel)
        out = np.zeros((len(system.positions), 3), np.float32)
        smoke, depth, coarse = smoke_by_lamp[key]
        others = emitted[index] if index < len(emitted) else None
        weights = octaves(light.scatter)
        glow = None
        if others is not None:
            glow = scatter_emitted_light(smoke.coarse(2), coarse, others, light.key, weights, eye, parallel)
        if len(out):
            reached = _ALL_LIT if casters is None else casters.lamp_shares(light, coarse)
            if light.scatter is not None:
                sky = _sky(light, coarse)
            elif id(light) in followed:  # another system in the same light
                sky = followed[id(light)]
            else:
                sky = followed[id(light)] = _scattered_often(light, coarse, systems, cross_sections, glow, reached)
            if glow is not None:
                sky = sky + glow
            _scatter_kernel(
                np.ascontiguousarray(system.positions, np.float32), smoke.to_nodes(system.positions), len(out), depth,
                smoke.extinction.shape[1], smoke.extinction.shape[2], sky.reshape(-1, 3), sky.shape[1], sky.shape[2],
                smoke.cell / coarse.cell, reached, q, out,
            )  # fmt: skip
        results.append(out)
    return results


def scattered_light_of_system(
    light: Light, positions, cross_sections, eye, parallel: bool = False, radii=None
) -> np.ndarray:
    """`scattered_light` for one system, whose sprites are points unless `radii` (n,) are given."""
    radii = np.zeros(len(positions), np.float32) if radii is None else radii
    return scattered_light([LitParticles(Lighting.of(light), positions, cross_sections, radii)], eye, parallel)[0]


def add_scattered_light(
    lit: dict, drawn: dict, view, scale: float, casters: LampShares | None = None, glow: EmittedLight | None = None
) -> dict:
    """Add the light that lit systems scatter to their channels, in place. Returns the smoke by lamp, see `scattered_light`.

    lit : name -> (Lighting, channels (11, n), (n, 8) columns LIT_... of projected_particles.py)
    drawn : name -> (system, channels) of everything in the picture
    scale : pixels per world unit, or per unit of slope
    casters : what else shadows the lamp
    glow : what the systems emit that the scene's light names; those that a look's own light names are in `drawn`
    """
    parallel = view.height is not None
    eye = view.axes[2] if parallel else view.position
    emitted = [
        glow if light.of_scene else _emitted_light(light.key, drawn, parallel, scale) for light, _, _ in lit.values()
    ]
    systems = [
        LitParticles(
            light, columns[:, LIT_POSITION], columns[:, LIT_EXTINCTION], columns[:, LIT_RADIUS],
            _albedos(channels, columns, view) if light.scatter is None else None,
        )
        for light, channels, columns in lit.values()
    ]  # fmt: skip
    smoke_by_lamp: dict = {}
    found = scattered_light(systems, eye, parallel, emitted, smoke_by_lamp, casters)
    for (_, channels, columns), light in zip(lit.values(), found):
        channels[RED : BLUE + 1] += (columns[:, LIT_ALBEDO] * light).T
    return smoke_by_lamp


def _albedos(channels, columns, view) -> np.ndarray:
    """(n, 3) albedo of particles, NaN of those that the picture does not cover: their columns hold its product with both."""
    covered = channels[ALPHA].astype(np.float64)
    if view.fog:
        start, distance = view.fog[:2]
        covered = covered * array_functions.exp(-np.maximum(channels[DEPTH].astype(np.float64) - start, 0.0) / distance)
    known = covered > 1e-12
    return np.where(known[:, None], columns[:, LIT_ALBEDO] / np.where(known, covered, 1.0)[:, None], np.nan)


def _emitted_light(light: Light, drawn: dict, parallel: bool, scale: float) -> EmittedLight | None:
    """The light of the systems named by the look's `glow`, as their sprites show it, or None.

    Light times area in pixels is converted to world units.
    """
    positions, power = [], []
    for name in light.glow:
        if name in drawn:
            system, channels = drawn[name]
            world_per_pixel = (1.0 if parallel else channels[DEPTH]) / np.float32(scale)
            light_power = channels[RED : BLUE + 1] * (world_per_pixel * world_per_pixel)
            positions.append(system.floats[POSITION, : channels.shape[1]].T)
            power.append(np.where(np.isfinite(light_power), light_power, 0.0).T)
    return EmittedLight(np.concatenate(positions), np.concatenate(power)) if positions else None
