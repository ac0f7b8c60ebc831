"""From the film's linear light to a picture: exposure, bloom, vignette, background, tone map, grain, sRGB, dither."""

from functools import lru_cache

import numpy as np

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer.bloom import stray_light
from gen_art.renderer.colour import LUMINANCE, gradient_table
from gen_art.renderer.tone import HIGH, LOW, STEPS, STEPS_LOG, curve_table, encode_table, matrices
from gen_art.runtime import kernel, ti

__all__ = ["develop"]

_NIGHT = Gradient(((0.0, (0.004, 0.006, 0.016)), (0.6, (0.012, 0.018, 0.042)), (1.0, (0.035, 0.042, 0.075))))
_RED, _GREEN, _BLUE = (float(c) for c in LUMINANCE)
_FIRST = (127 + LOW) << STEPS_LOG  # the bits of 2^LOW, shifted as an index
_LAST = (HIGH - LOW) * STEPS

# run-time numbers
EXPOSURE, BLOOM, VIGNETTE, SATURATION, GRAIN, DITHER, NEUTRAL, TRANSPARENT, TOP = range(9)
BEFORE, AFTER = 9, 18
NUMBERS = 27

F1, F2, U1 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 1)


@ti.func
def _read(table: ti.template(), x):
    """The table's curve at x >= 0."""
    low = ti.static(2.0**LOW)
    y = ti.min(ti.max(x, low), ti.static(2.0**HIGH * 0.999))
    bits = ti.bit_cast(y, ti.i32)
    k = (bits >> (23 - STEPS_LOG)) - _FIRST
    f = ti.cast(bits & ((1 << (23 - STEPS_LOG)) - 1), ti.f32) * ti.static(1.0 / (1 << (23 - STEPS_LOG)))
    value = table[k] + (table[k + 1] - table[k]) * f
    return ti.select(x < low, value * (ti.max(x, 0.0) * ti.static(2.0**-LOW)), value)


@ti.func
def _hash(a):
    h = ti.cast(a, ti.u32)
    h = (h ^ (h >> ti.u32(16))) * ti.u32(0x7FEB352D)
    h = (h ^ (h >> ti.u32(15))) * ti.u32(0x846CA68B)
    return h ^ (h >> ti.u32(16))


@ti.func
def _turn(Q: ti.template(), at, v):
    return ti.Vector([Q[at + 3 * r] * v[0] + Q[at + 3 * r + 1] * v[1] + Q[at + 3 * r + 2] * v[2] for r in range(3)])


@ti.func
def _pbr_neutral(v):
    least = ti.min(v[0], ti.min(v[1], v[2]))
    c = v - ti.select(least < 0.08, least - 6.25 * least * least, 0.04)
    peak = ti.max(c[0], ti.max(c[1], c[2]))
    if peak > 0.76:
        top = 1.0 - 0.0576 / (peak - 0.52)
        g = 1.0 - 1.0 / (0.15 * (peak - top) + 1.0)
        c = c * (top / peak) * (1.0 - g) + top * g
    return c


@ti.kernel
def _develop(
    film: F1, halo: F1, width: ti.i32, height: ti.i32, frame: ti.i32, sky: F2, curve: F1, encode: F1, Q: F1,
    channels: ti.i32, out: ti.types.ndarray(ndim=1),
):  # fmt: skip
    ti.loop_config(block_dim=4)
    for i in range(height):
        dy = (ti.cast(i, ti.f32) + 0.5) / ti.cast(height, ti.f32) * 2.0 - 1.0
        for j in range(width):
            o = (i * width + j) * 4
            dx = (ti.cast(j, ti.f32) + 0.5) / ti.cast(width, ti.f32) * 2.0 - 1.0
            light = ti.Vector([film[o], film[o + 1], film[o + 2]])
            if Q[BLOOM] > 0.0:
                light = light * (1.0 - Q[BLOOM]) + ti.Vector([halo[o], halo[o + 1], halo[o + 2]]) * Q[BLOOM]
            edge = 1.0 + Q[VIGNETTE] * 0.5 * (dx * dx + dy * dy)
            light = light * (Q[EXPOSURE] / (edge * edge))
            cover = ti.min(ti.max(film[o + 3], 0.0), 1.0)
            v = ti.Vector([0.0, 0.0, 0.0])
            if Q[NEUTRAL] > 0.5:
                v = _pbr_neutral(light)
            else:
                v = _turn(Q, BEFORE, light)
                v = ti.Vector([_read(curve, v[0]), _read(curve, v[1]), _read(curve, v[2])])
                v = _turn(Q, AFTER, v)
            grey = _RED * v[0] + _GREEN * v[1] + _BLUE * v[2]
            v = grey + (v - grey) * Q[SATURATION]
            if Q[TRANSPARENT] < 0.5:  # the background is seen as it is written, dimmed by what shines over it
                back = ti.Vector([sky[i, 0], sky[i, 1], sky[i, 2]]) * ((1.0 - cover) / (edge * edge))
                v += back * (1.0 - ti.min(ti.max(v, 0.0), 1.0))
            if Q[TRANSPARENT] > 0.5:
                cover = ti.min(ti.max(cover, ti.max(v[0], ti.max(v[1], v[2]))), 1.0)
                v = v / ti.max(cover, 1e-6)
            seed = _hash(i * 16384 + j + frame * 268435399)
            rough = 0.0
            if Q[GRAIN] > 0.0:  # the mean of four: nearly normal, standard deviation 1
                for k in range(4):
                    rough += ti.cast(_hash(seed + ti.u32(k + 17)) >> ti.u32(8), ti.f32) * (1.0 / 16777216.0) - 0.5
                rough *= 1.7320508 * Q[GRAIN]
            for c in ti.static(range(3)):
                e = _read(encode, v[c])
                e = ti.min(ti.max(e + rough * 4.0 * e * (1.0 - e), 0.0), 1.0) * Q[TOP]
                noise = ti.cast(_hash(seed + ti.u32(c)) >> ti.u32(8), ti.f32) * (1.0 / 16777216.0) - 0.5
                amount = Q[DITHER] * ti.min(1.0, ti.min(e, Q[TOP] - e) * 2.0)  # black stays black, white white
                out[(i * width + j) * channels + c] = ti.cast(ti.floor(e + 0.5 + noise * amount), ti.i32)
            if channels == 4:
                out[(i * width + j) * 4 + 3] = ti.cast(ti.floor(cover * Q[TOP] + 0.5), ti.i32)


@lru_cache(8)
def _tables(tone: str, contrast: float) -> tuple[np.ndarray, np.ndarray]:
    return curve_table(tone, contrast), encode_table()


def _sky(spec: DevelopSpec, height: int) -> np.ndarray:
    gradient = _NIGHT if spec.background == "night" else spec.background
    return np.ascontiguousarray(gradient_table(gradient, max(height, 2))[:height].astype(np.float32))


_PLAIN = DevelopSpec()


def develop(film: np.ndarray, spec: DevelopSpec = _PLAIN, frame: int = 0, transparent: bool = False, bits: int = 8):
    """A picture (height, width, 3 or, transparent, 4) of uint8 or uint16, sRGB, from linear premultiplied RGBA.

    film : (height, width, 4) float32      frame : seeds dither and grain      bits : 8 or 16
    Transparent pictures have straight alpha: light over nothing is as opaque as it is bright.
    """
    if bits not in (8, 16):
        raise UsageError(f"a picture has 8 or 16 bits a channel, not {bits}")
    film = np.ascontiguousarray(film, dtype=np.float32)
    height, width = film.shape[:2]
    halo = stray_light(film, spec.bloom.radius) if spec.bloom.strength else np.zeros((1, 1, 4), np.float32)
    before, after = matrices(spec.tone)
    q = np.zeros(NUMBERS, np.float32)
    q[EXPOSURE], q[BLOOM], q[VIGNETTE] = 2.0**spec.exposure, spec.bloom.strength, 2.0 ** (spec.vignette / 2) - 1.0
    q[SATURATION], q[GRAIN], q[DITHER] = spec.saturation, spec.grain, spec.dither and bits == 8
    q[NEUTRAL], q[TRANSPARENT], q[TOP] = spec.tone == "neutral", transparent, 2.0**bits - 1.0
    q[BEFORE : BEFORE + 9], q[AFTER : AFTER + 9] = before.reshape(-1), after.reshape(-1)
    channels = 4 if transparent else 3
    out = np.zeros(height * width * channels, np.uint8 if bits == 8 else np.uint16)
    curve, encode = _tables(spec.tone, spec.contrast)
    develop_kernel(
        film.reshape(-1),
        halo.reshape(-1),
        width,
        height,
        int(frame),
        _sky(spec, height),
        curve,
        encode,
        q,
        channels,
        out,
    )
    return out.reshape(height, width, channels)


develop_kernel = kernel(_develop)
