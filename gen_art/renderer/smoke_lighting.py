"""A lamp that shines on smoke through the smoke itself, and a sky around it.

A particle scatters towards the camera, for each lamp of irradiance 4 pi `intensity` behind an optical depth t,

    intensity * sum over i < OCTAVES of w_i  4 pi p(cos, g 2^-i)  exp(-t 2^-i),        w_i ~ s^i,  sum of w_i = 1

with s = `scatter`: light that was scattered before goes deeper and has forgotten more of its direction. The same sum
without p, meant over 14 directions, takes in the sky. No particle gets more than the unshadowed light, so smoke never
gives off more than comes in.
Source: Wrenninge, Kulla, Lundqvist, Oz: the great and volumetric (SIGGRAPH Talks 2013), with weights that sum to 1; Henyey
and Greenstein, Diffuse radiation in the galaxy (1941); the directions: Lebedev's rule.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.maths.elementary import exp
from gen_art.particles.rows import POSITION
from gen_art.preset.look import KeyLight
from gen_art.renderer.colour import linear
from gen_art.renderer.emissive_lighting import EmittedLight, glow_on
from gen_art.renderer.smoke_density import DIRECTIONS, WEIGHTS, Smoke
from gen_art.renderer.sprite import BLUE, DEPTH, RED

__all__ = ["LitParticles", "OCTAVES", "add_light", "incoming_light", "octaves", "phase_function", "shine"]

OCTAVES = 4
SKY = 48  # cells along the longest side of the grid on which the sky's light is summed
FORWARD, EYE, PARALLEL, KEY, OCTAVE = 0, 3, 6, 7, 10  # the kernel's numbers; OCTAVE: weights, then asymmetries

F1, F2, F64 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.f64, 1)


@dataclass(frozen=True)
class LitParticles:
    """Particles that scatter light: positions (n, 3), extinction cross sections (n,), radii of the sprites (n,)."""

    light: KeyLight
    positions: np.ndarray
    sections: np.ndarray
    radii: np.ndarray


def phase_function(cosine, asymmetry: float):
    """Henyey and Greenstein's p per steradian; its integral over the sphere is 1. cosine: of the angle by which light turns."""
    g = asymmetry
    return (1.0 - g * g) / (4.0 * np.pi * np.maximum(1.0 + g * g - 2.0 * g * np.asarray(cosine), 1e-6) ** 1.5)


def octaves(scatter: float) -> np.ndarray:
    """(OCTAVES,) weights of light that was scattered before 0, 1, ... times; their sum is 1."""
    weights = float(scatter) ** np.arange(OCTAVES)
    return weights / weights.sum()


def _axes(direction) -> np.ndarray:
    """Rows: two across the light, then the way it goes."""
    forward = np.asarray(direction, dtype=np.float64)
    forward = forward / np.linalg.norm(forward)
    side = np.cross(forward, (0.0, 1.0, 0.0) if abs(forward[1]) < 0.9 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(side, forward), forward])


@ti.kernel
def _gather(
    X: F2, place: F2, n: ti.i32, depth: F1, d1: ti.i32, d2: ti.i32, sky: F2, s1: ti.i32, s2: ti.i32, coarse: ti.f32,
    Q: F64, out: F2,
):  # fmt: skip
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for i in range(block * 2048, ti.min((block + 1) * 2048, n)):
            t = 0.0
            rgb = ti.Vector([0.0, 0.0, 0.0])
            for table in ti.static(range(2)):
                size = coarse if ti.static(table) else 1.0
                x, y, z = place[i, 0] * size, place[i, 1] * size, place[i, 2] * size
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
                        t += w * depth[((j + a) * d1 + k + b) * d2 + m + c]
                    else:
                        at = ((j + a) * s1 + k + b) * s2 + m + c
                        for e in ti.static(range(3)):
                            rgb[e] += w * sky[at, e]
            cosine, square = 0.0, 0.0
            for e in ti.static(range(3)):
                way = ti.cast(Q[EYE + e], ti.f32)
                if Q[PARALLEL] < 0.5:
                    way = ti.cast(Q[EYE + e] - ti.cast(X[i, e], ti.f64), ti.f32)
                cosine += way * ti.cast(Q[FORWARD + e], ti.f32)
                square += way * way
            cosine /= ti.max(ti.sqrt(square), 1e-30)
            direct = 0.0
            for o in range(OCTAVES):
                g = ti.cast(Q[OCTAVE + OCTAVES + o], ti.f32)
                turn = ti.max(1.0 + g * g - 2.0 * g * cosine, 1e-6)
                p = (1.0 - g * g) / (turn * ti.sqrt(turn))
                direct += ti.cast(Q[OCTAVE + o], ti.f32) * p * exp(-t / ti.cast(1 << o, ti.f32))
            for e in ti.static(range(3)):
                out[i, e] = rgb[e] + direct * ti.cast(Q[KEY + e], ti.f32)


gather = kernel(_gather)


def _let_through(depth: np.ndarray, weights) -> np.ndarray:
    """Sum of weights[i] exp(-depth / 2^i)."""
    part = np.exp(depth * np.float32(-(0.5 ** (OCTAVES - 1))))
    total = np.float32(weights[-1]) * part
    for w in weights[-2::-1]:
        part = part * part
        total += np.float32(w) * part
    return total


def _sky(light: KeyLight, smoke: Smoke) -> np.ndarray:
    """(a, b, c, 3) the sky's light at each node of `smoke`, through the smoke from 14 sides."""
    top, ground = (linear(c) for c in (light.ambient, light.ambient if light.ground is None else light.ground))
    table = np.zeros((*smoke.dense.shape, 3), np.float32)
    if light.ambient_intensity == 0.0:
        return table
    weights = octaves(light.scatter)
    for way, part in zip(DIRECTIONS, WEIGHTS):
        height = -(way / np.linalg.norm(way)) @ smoke.axes[:, 1]  # of where this light comes from
        colour = (0.5 + 0.5 * height) * top + (0.5 - 0.5 * height) * ground
        table += _let_through(smoke.depth(way), weights)[..., None] * np.float32(
            part * light.ambient_intensity * colour
        )
    return table


def _lamp(light: KeyLight, eye, parallel: bool) -> np.ndarray:
    q = np.zeros(OCTAVE + 2 * OCTAVES)
    q[FORWARD : FORWARD + 3] = np.asarray(light.direction) / np.linalg.norm(light.direction)
    q[EYE : EYE + 3] = -np.asarray(eye) if parallel else eye
    q[PARALLEL] = parallel
    q[KEY : KEY + 3] = linear(light.color) * light.intensity
    q[OCTAVE : OCTAVE + OCTAVES] = octaves(light.scatter)
    q[OCTAVE + OCTAVES :] = light.phase * 0.5 ** np.arange(OCTAVES)
    return q


def shine(systems: list[LitParticles], eye, parallel: bool = False, glows: list[EmittedLight] = ()) -> list[np.ndarray]:
    """For each system (n, 3) float32 linear light that its particles scatter towards the camera at `eye` (3,), before
    their albedo. All systems stand in each other's light.

    parallel : the camera is orthographic and `eye` the direction it looks in
    glows : for each system, the light of others that it gathers, or None
    """
    positions, radii = (np.concatenate([getattr(s, n) for s in systems]) for n in ("positions", "radii"))
    sections = np.concatenate([s.sections * np.float32(s.light.depth) for s in systems])
    grids: dict = {}
    results = []
    for number, system in enumerate(systems):
        light = system.light
        kind = (light.direction, light.resolution)
        if kind not in grids:
            smoke = Smoke.of(positions, sections, radii, _axes(light.direction), light.resolution)
            grids[kind] = (
                smoke,
                smoke.depth((0, 0, 1)).reshape(-1),
                smoke.coarse(1 if light.resolution <= 2 * SKY else 2),
            )
        q = _lamp(light, eye, parallel)
        out = np.zeros((len(system.positions), 3), np.float32)
        smoke, depth, coarse = grids[kind]
        sky = _sky(light, coarse)
        if number < len(glows) and glows[number] is not None:
            sky += glow_on(smoke.coarse(2), coarse, glows[number], light, octaves(light.scatter), eye, parallel)
        if len(out):
            gather(
                np.ascontiguousarray(system.positions, np.float32), smoke.places(system.positions), len(out), depth,
                smoke.dense.shape[1], smoke.dense.shape[2], sky.reshape(-1, 3), sky.shape[1], sky.shape[2],
                smoke.cell / coarse.cell, q, out,
            )  # fmt: skip
        results.append(out)
    return results


def incoming_light(light: KeyLight, positions, sections, eye, parallel: bool = False, radii=None) -> np.ndarray:
    """`shine` for one system whose sprites are points unless `radii` (n,) are given."""
    radii = np.zeros(len(positions), np.float32) if radii is None else radii
    return shine([LitParticles(light, positions, sections, radii)], eye, parallel)[0]


def add_light(lit: dict, drawn: dict, view, scale: float) -> None:
    """Add to the columns of lit systems what they scatter of all light, in place.

    lit : name -> (KeyLight, columns (11, n), (n, 8) position, extinction cross section, albedo times cover, radius)
    drawn : name -> (system, columns), all that is in the picture      scale : pixels per world unit or unit of slope
    """
    parallel = view.height is not None
    eye = view.axes[2] if parallel else view.position
    glows = [_glow_of(light, drawn, parallel, scale) for light, _, _ in lit.values()]
    systems = [LitParticles(light, a[:, :3], a[:, 3], a[:, 7]) for light, _, a in lit.values()]
    for (_, columns, a), light in zip(lit.values(), shine(systems, eye, parallel, glows)):
        columns[RED : BLUE + 1] += (a[:, 4:7] * light).T


def _glow_of(light: KeyLight, drawn: dict, parallel: bool, scale: float) -> EmittedLight | None:
    """What the systems named by `glow` give off, as their sprites show it: light over pixels turned into world units."""
    positions, power = [], []
    for name in light.glow:
        if name in drawn:
            system, columns = drawn[name]
            unit = (1.0 if parallel else columns[DEPTH]) / np.float32(scale)
            given = columns[RED : BLUE + 1] * (unit * unit)
            positions.append(system.floats[POSITION, : columns.shape[1]].T)
            power.append(np.where(np.isfinite(given), given, 0.0).T)
    return EmittedLight(np.concatenate(positions), np.concatenate(power)) if positions else None
