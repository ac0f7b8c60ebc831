"""From particles to sprites: where each is on the picture, how large, in what colour, with what light.

One kernel for all looks: what a preset says becomes tables (`Shading`), which are run-time data, so that changing any
number or colour compiles nothing.
"""

from dataclasses import dataclass

import numpy as np

from gen_art.elementary import exp
from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.look import Color, Look, Ramp
from gen_art.preset.values import Curve
from gen_art.registry import suggest
from gen_art.renderer.camera import View
from gen_art.renderer.colour import TABLE, blackbody, gradient_table, planck_luminance
from gen_art.renderer.film import Sprites
from gen_art.renderer.sprite import (
    ALPHA,
    AREA,
    BLUE,
    DEPTH,
    DX,
    DY,
    FIRST,
    GREEN,
    LAST,
    LEVEL,
    REACH,
    RED,
    SMALLEST,
    TAIL,
    TAPER,
    X,
    Y,
    coarsen,
    finish,
)  # fmt: skip
from gen_art.runtime import kernel, ti

__all__ = ["Shading", "add_sprites"]

REFERENCE_ROWS = 720.0  # a "pixel" of a preset is 1/720 of the picture's height
SOFT = 1.5  # a disc's reach over its radius

_BY = {
    "age": 0, "seconds": 1, "speed": 2, "energy": 3, "charge": 4, "mass": 5, "radius": 6, "id": 7, "random": 8,
    "distance": 9, "x": 10, "y": 11, "z": 12,
}  # fmt: skip
_ATTRIBUTE = 100
SIZE, INTENSITY, OPACITY, KELVIN, COLOR, ALBEDO = range(6)
RAMPS = 6

# run-time numbers of the kernel
(
    POSITION, _PY, _PZ, AXES, *_rest,
) = range(12)  # fmt: skip
SCALE, ORTHOGRAPHIC, NEAR, FAR, WIDTH, ROWS, TIME, SHUTTER = range(12, 20)
FOG_START, FOG_RATE, FOG_RED, FOG_GREEN, FOG_BLUE = range(20, 25)
KIND, SIZE_MODE, SIZE_VALUE, BLEND, CONSERVE, FALLOFF, TAIL_LIGHT, TAIL_WIDTH = range(25, 33)
STROBE_LO, STROBE_HI, DUTY, FILM_TIME, RAW, LIT, WEIGHT, EMITS = range(33, 41)
NUMBERS = 41

F64, U2, I1, L1, F2, F3 = (
    ti.types.ndarray(d, n) for d, n in ((ti.f64, 1), (ti.u32, 2), (ti.i32, 1), (ti.i64, 1), (ti.f32, 2), (ti.f32, 3))
)


def _channel(by: str, channels: dict[str, int]) -> float:
    if by in channels and (by not in _BY or channels[by] > 9):
        return float(_ATTRIBUTE + channels[by])
    if by in _BY:
        return float(_BY[by])
    raise UsageError(
        f"a look cannot go by '{by}'{suggest(by, [*_BY, *channels])}; known are {', '.join([*_BY, *channels])}"
    )


def _domain(ramp: Ramp) -> tuple[float, float]:
    """The values of the quantity at the two ends of the table."""
    first, last = ramp.curve.points[0][0], ramp.curve.points[-1][0]
    if ramp.range is not None:
        span = ramp.range.hi - ramp.range.lo
        return ramp.range.lo + first * span, ramp.range.lo + last * span
    return first, last


def _samples(curve: Curve) -> np.ndarray:
    xs, ys = zip(*curve.points)
    return np.interp(np.linspace(xs[0], xs[-1], TABLE), xs, ys)


@dataclass(frozen=True)
class Shading:
    """A look as tables: ramps (6, 3) by, low, 1 / span; curves (6, 256); colours (rows, 256, 4): row 0 is the black
    body, then albedo and emission by tag; `rows` is the emission's row for each source. All float32 but rows.
    """

    look: Look
    ramps: np.ndarray
    curves: np.ndarray
    colours: np.ndarray
    tags: tuple[str, ...]

    @classmethod
    def of(cls, look: Look, channels: dict[str, int]) -> "Shading":
        """The tables of a look for a system with these attribute rows. UsageError for a quantity it does not have."""
        emission = look.emission
        plain = Ramp()
        kelvin = emission.blackbody if emission and emission.blackbody else None
        color = emission.color if emission and emission.color else Color()
        table = [look.size, emission.intensity if emission else plain, look.opacity, kelvin or plain]
        ramps, curves = np.zeros((RAMPS, 3), np.float32), np.ones((RAMPS, TABLE), np.float32)
        for k, ramp in enumerate(table):
            low, high = _domain(ramp)
            ramps[k] = _channel(ramp.by, channels), low, 1.0 / (high - low) if high > low else 0.0
            curves[k] = _samples(ramp.curve)
        for k, spec in ((COLOR, color), (ALBEDO, look.albedo)):
            low, high = (spec.range.lo, spec.range.hi) if spec.range else (0.0, 1.0)
            ramps[k] = _channel(spec.by, channels), low, 1.0 / (high - low) if high > low else 0.0
        tags = tuple(color.tags)
        gradients: list[Gradient] = [look.albedo.gradient, color.gradient, *(color.tags[t] for t in tags)]
        colours = np.ones((1 + len(gradients), TABLE, 4), np.float32)
        if kelvin:
            temperatures = np.maximum(_samples(kelvin.curve), 100.0)
            relative = planck_luminance(temperatures) / planck_luminance(temperatures.max())
            colours[0, :, :3] = blackbody(temperatures) * (relative**emission.planck)[:, None]
        for row, gradient in enumerate(gradients):
            colours[1 + row, :, :3] = gradient_table(gradient)
        return cls(look, ramps, curves, colours, tags)

    def rows(self, sources) -> np.ndarray:
        """The table row of the emission's colour for each source (an object with a `tag`)."""
        known = {tag: 3 + k for k, tag in enumerate(self.tags)}
        return np.array([known.get(getattr(s, "tag", None), 2) for s in sources] or [2], dtype=np.int32)


@ti.func
def _unit(low, high, channel):
    """A number in 0..1 from a particle's key: PCG's output permutation over a mix of the words."""
    s = (low ^ ti.u32(channel)) * ti.u32(747796405) + ti.u32(2891336453)
    s = s ^ (high * ti.u32(277803737))
    s = s * ti.u32(747796405) + ti.u32(2891336453)
    w = ((s >> ((s >> ti.u32(28)) + ti.u32(4))) ^ s) * ti.u32(277803737)
    w = (w >> ti.u32(22)) ^ w
    return ti.cast(w >> ti.u32(8), ti.f32) * (1.0 / 16777216.0)


@ti.func
def _colour(table: ti.template(), row, u):
    place = u * (TABLE - 1.0)
    k = ti.min(ti.cast(place, ti.i32), TABLE - 2)
    f = place - ti.cast(k, ti.f32)
    return ti.Vector(
        [
            table[row, k, 0] + (table[row, k + 1, 0] - table[row, k, 0]) * f,
            table[row, k, 1] + (table[row, k + 1, 1] - table[row, k, 1]) * f,
            table[row, k, 2] + (table[row, k + 1, 2] - table[row, k, 2]) * f,
        ]
    )


@ti.func
def _clip(p, q, low, high):
    """Liang and Barsky's step: the part [low, high] of a segment with p * t <= q."""
    if p < 0.0:
        low = ti.max(low, q / p)
    elif p > 0.0:
        high = ti.min(high, q / p)
    elif q < 0.0:
        high = -1.0
    return low, high


@ti.kernel
def _shade(
    S: ti.types.ndarray(ndim=2), birth: F64, key: U2, id: L1, source: I1, tag_rows: I1, n: ti.i32, base: ti.i32, P: F2, A: F2,
    ramps: F2, curves: F2, colours: F3, Q: F64,
):  # fmt: skip
    ti.loop_config(block_dim=1)
    for block in range((n + 2047) // 2048):
        for i in range(block * 2048, ti.min((block + 1) * 2048, n)):
            o = base + i
            P[o, FIRST], P[o, LAST], P[o, DEPTH], P[o, LEVEL] = 1.0, 0.0, 0.0, 0.0
            age = ti.cast(Q[TIME] - birth[i], ti.f32)
            life = ti.cast(S[9, i], ti.f32)
            local = ti.Vector([0.0, 0.0, 0.0])  # right, up, forward
            flow = ti.Vector([0.0, 0.0, 0.0])
            for c in ti.static(range(3)):
                x = ti.cast(ti.cast(S[c, i], ti.f64) - Q[POSITION + c], ti.f32)
                v = ti.cast(S[3 + c, i], ti.f32)
                for r in ti.static(range(3)):
                    local[r] += ti.cast(Q[AXES + 3 * r + c], ti.f32) * x
                    flow[r] += ti.cast(Q[AXES + 3 * r + c], ti.f32) * v
            near, far = ti.cast(Q[NEAR], ti.f32), ti.cast(Q[FAR], ti.f32)
            streak = Q[KIND] > 1.5
            lapse = ti.min(ti.cast(Q[SHUTTER], ti.f32), ti.max(age, 0.0))
            old = local - flow * lapse
            begins, ends = 0.0, 1.0  # the visible part of the segment from `local` (0) to `old` (1)
            if streak:
                begins, ends = _clip(local[2] - old[2], local[2] - near, begins, ends)
            elif local[2] < near:
                ends = -1.0
            alive = age >= 0.0 and age < life and local[2] < far
            if alive and ends > begins:
                head = local + (old - local) * begins
                scale = ti.cast(Q[SCALE], ti.f32)
                per = scale
                if Q[ORTHOGRAPHIC] < 0.5:
                    per = scale / head[2]
                width, rows = ti.cast(Q[WIDTH], ti.f32), ti.cast(Q[ROWS], ti.f32)
                px, py = 0.5 * width + head[0] * per, 0.5 * rows - head[1] * per
                dx, dy = 0.0, 0.0
                if streak:
                    back = local + (old - local) * ends
                    per_back = per
                    if Q[ORTHOGRAPHIC] < 0.5:
                        per_back = scale / back[2]
                    dx, dy = px - (0.5 * width + back[0] * per_back), py - (0.5 * rows - back[1] * per_back)
                    low, high = 0.0, 1.0
                    run = ti.Vector([dx, -dx, dy, -dy])
                    room = ti.Vector([px + width, 2.0 * width - px, py + rows, 2.0 * rows - py])
                    for e in range(4):
                        low, high = _clip(run[e], room[e], low, high)
                    if high > low:
                        px, py = px - dx * low, py - dy * low
                        dx, dy = dx * (high - low), dy * (high - low)
                        ends = begins + (ends - begins) * high
                        begins = begins + (ends - begins) * low / ti.max(high, 1e-30)
                    else:
                        ends = begins
                # every quantity a ramp may go by, then the six tables
                fraction = age / ti.max(life, 1e-30)
                speed2 = flow.dot(flow)
                mass = ti.cast(S[6, i], ti.f32)
                radius = ti.cast(S[8, i], ti.f32)
                u = ti.Vector([0.0] * RAMPS)
                for k in range(RAMPS):
                    by = ti.cast(ramps[k, 0], ti.i32)
                    q = fraction
                    if by >= _ATTRIBUTE:
                        q = ti.cast(S[by - _ATTRIBUTE, i], ti.f32)
                    elif by >= 10:
                        q = ti.cast(S[by - 10, i], ti.f32)
                    elif by == 1:
                        q = age
                    elif by == 2:
                        q = ti.sqrt(speed2)
                    elif by == 3:
                        q = 0.5 * mass * speed2
                    elif by == 4:
                        q = ti.cast(S[7, i], ti.f32)
                    elif by == 5:
                        q = mass
                    elif by == 6:
                        q = radius
                    elif by == 7:
                        q = ti.cast(id[i], ti.f32)
                    elif by == 8:
                        q = _unit(key[0, i], key[1, i], 11)
                    elif by == 9:
                        d2 = 0.0
                        for c in ti.static(range(3)):
                            d2 += ti.cast(S[c, i], ti.f32) * ti.cast(S[c, i], ti.f32)
                        q = ti.sqrt(d2)
                    u[k] = ti.min(ti.max((q - ramps[k, 1]) * ramps[k, 2], 0.0), 1.0)
                value = ti.Vector([0.0] * 3)
                for k in range(3):
                    place = u[k] * (TABLE - 1.0)
                    at = ti.min(ti.cast(place, ti.i32), TABLE - 2)
                    value[k] = curves[k, at] + (curves[k, at + 1] - curves[k, at]) * (place - ti.cast(at, ti.f32))
                # size in pixels, and the area its light is worth
                size = ti.cast(Q[SIZE_VALUE], ti.f32)
                if Q[SIZE_MODE] < 0.5:
                    size = radius
                pixel = rows / REFERENCE_ROWS
                half = size * value[SIZE] * ti.select(Q[SIZE_MODE] > 1.5, pixel, per)
                reach = half * SOFT
                area = AREA * reach * reach
                shown = ti.sqrt(reach * reach + SMALLEST * SMALLEST)
                if Q[KIND] < 0.5 and Q[SIZE_MODE] < 1.5:
                    shown = 0.0
                    area = pixel * pixel * value[SIZE] * value[SIZE]
                if Q[RAW] > 0.5:
                    area = width * rows
                light = value[INTENSITY] * ti.cast(Q[WEIGHT], ti.f32) * (ends - begins)
                if Q[FALLOFF] > 0.0 and Q[ORTHOGRAPHIC] < 0.5:
                    light *= ti.cast(Q[FALLOFF], ti.f32) / (head[2] * head[2])
                if Q[STROBE_HI] > 0.0:
                    f = Q[STROBE_LO] + (Q[STROBE_HI] - Q[STROBE_LO]) * ti.cast(_unit(key[0, i], key[1, i], 5), ti.f64)
                    turn = Q[FILM_TIME] * f + ti.cast(_unit(key[0, i], key[1, i], 6), ti.f64)
                    light *= ti.select(turn - ti.floor(turn) < Q[DUTY], 1.0, 0.0)
                rgb = ti.Vector([0.0, 0.0, 0.0])
                if Q[EMITS] > 0.5:
                    row = tag_rows[source[i]]
                    rgb = _colour(colours, row, u[COLOR]) * _colour(colours, 0, u[KELVIN]) * (light * area)
                cover = 0.0
                white = ti.Vector([0.0, 0.0, 0.0])
                depth = value[OPACITY]
                if Q[BLEND] > 0.5:
                    world = half / per
                    if Q[CONSERVE] > 0.0:
                        shrink = ti.cast(Q[CONSERVE], ti.f32) / ti.max(world, 1e-30)
                        depth *= shrink * shrink
                    white = _colour(colours, 1, u[ALBEDO])
                dense = ti.Vector(
                    [depth, ti.max(head[2] - ti.cast(Q[FOG_START], ti.f32), 0.0) * ti.cast(Q[FOG_RATE], ti.f32)]
                )
                for e in range(2):  # through the sprite, and through the fog in front of it
                    dense[e] = exp(-dense[e])
                if Q[BLEND] > 0.5:
                    cover = (1.0 - dense[0]) * area
                if Q[FOG_RATE] > 0.0:
                    clear = dense[1]
                    mist = ti.Vector([Q[FOG_RED], Q[FOG_GREEN], Q[FOG_BLUE]])
                    for c in ti.static(range(3)):
                        rgb[c] = rgb[c] * clear + cover * (1.0 - clear) * ti.cast(mist[c], ti.f32)
                    white *= clear
                if Q[LIT] > 0.5:
                    for c in ti.static(range(3)):
                        A[i, c] = ti.cast(S[c, i], ti.f32)
                        A[i, 4 + c] = white[c] * cover
                    A[i, 3] = depth * AREA * (half / per * SOFT) * (half / per * SOFT)
                    A[i, 7] = half / per
                else:
                    rgb += white * cover
                P[o, X], P[o, Y], P[o, REACH], P[o, DX], P[o, DY] = px, py, shown, dx, dy
                P[o, RED], P[o, GREEN], P[o, BLUE], P[o, ALPHA], P[o, DEPTH] = rgb[0], rgb[1], rgb[2], cover, head[2]
                P[o, TAIL], P[o, TAPER] = ti.cast(Q[TAIL_LIGHT], ti.f32), ti.cast(Q[TAIL_WIDTH], ti.f32)
                beyond = ti.max(shown, 1.0) * 1.5 + ti.max(abs(dx), abs(dy))
                seen = px > -beyond and px < width + beyond and py > -beyond and py < rows + beyond
                if seen and (cover > 0.0 or rgb[0] + rgb[1] + rgb[2] > 0.0 or Q[LIT] > 0.5):
                    level = 0
                    if Q[KIND] < 1.5:
                        level = coarsen(P, o, _unit(key[0, i], key[1, i], 21))
                    side = (1 << level) - 1
                    finish(
                        P, o, (ti.cast(Q[WIDTH], ti.i32) + side) >> level, (ti.cast(Q[ROWS], ti.i32) + side) >> level
                    )
            elif Q[LIT] > 0.5:
                A[i, 3] = 0.0


shade = kernel(_shade)


def numbers(
    shading: Shading, view: View, size, time: float, film_time: float, shutter: float, raw: bool, weight: float = 1.0
) -> np.ndarray:
    """The kernel's run-time numbers (float64). `weight` scales the light, `raw` makes every particle's light 1."""
    look = shading.look
    q = np.zeros(NUMBERS)
    q[POSITION : POSITION + 3] = view.position
    q[AXES : AXES + 9] = view.axes.reshape(-1)
    q[SCALE], q[ORTHOGRAPHIC] = view.scale(size[1]), view.height is not None
    q[NEAR], q[FAR] = (-np.inf if view.height else view.near), view.far
    q[WIDTH], q[ROWS] = size
    q[TIME], q[FILM_TIME] = time, film_time
    q[SHUTTER] = shutter if look.length is None else look.length
    if view.fog:
        q[FOG_START], q[FOG_RATE] = view.fog[0], 1.0 / view.fog[1]
        q[FOG_RED : FOG_RED + 3] = view.fog[2]
    q[KIND] = ("point", "disc", "streak").index(look.draw)
    if look.pixels is not None:
        q[SIZE_MODE], q[SIZE_VALUE] = 2, 0.5 * look.pixels
    elif look.radius is not None or look.width is not None:
        q[SIZE_MODE], q[SIZE_VALUE] = 1, look.radius if look.radius is not None else 0.5 * look.width
    q[BLEND] = look.blend == "alpha"
    q[CONSERVE] = look.reference or 0.0
    q[FALLOFF] = view.distance**2 if look.falloff == "inverse_square" else 0.0
    q[TAIL_LIGHT], q[TAIL_WIDTH] = look.tail, look.taper
    emission = look.emission
    if emission and emission.strobe:
        q[STROBE_LO], q[STROBE_HI], q[DUTY] = emission.strobe.lo, max(emission.strobe.hi, 1e-12), emission.duty
    q[RAW], q[WEIGHT], q[LIT] = raw, weight, look.light is not None
    q[EMITS] = emission is not None or look.blend == "add"
    return q


def add_sprites(sprites: Sprites, system, shading: Shading, q: np.ndarray) -> tuple[int, np.ndarray]:
    """Append a system's particles; gives the first row and, for a lit look, (n, 8) of position, extinction cross
    section, albedo times cover, whose light is still to be added, and radius.
    """
    n = int(system.count)
    first = sprites.reserve(n)
    auxiliary = np.zeros((n if q[LIT] else 1, 8), np.float32)
    if n:
        shade(
            system.floats, system.birth, system.key, system.id, system.source, shading.rows(system.sources), n, first,
            sprites.rows, auxiliary, shading.ramps, shading.curves, shading.colours, q,
        )  # fmt: skip
    sprites.layered |= shading.look.blend == "alpha"
    return first, auxiliary
