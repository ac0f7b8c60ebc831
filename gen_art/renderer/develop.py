"""From the film's linear light to a picture: exposure, bloom, vignette, tone map, background, grain, sRGB, dither.

The film is read twice: once by the first step of bloom, once by the kernel here, which works on tiles of WIDE pixels whose
values lie in local vectors: loops over them vectorise (no tables, no branches inside).
"""

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from gen_art.elementary import log, power
from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer.bloom import chain, flat
from gen_art.renderer.colour import gradient_table
from gen_art.renderer.resample import TILE, blend_weights
from gen_art.renderer.tone import GREY, matrices, rational
from gen_art.runtime import kernel, ti

__all__ = ["develop"]

_NIGHT = Gradient(((0.0, (0.004, 0.006, 0.016)), (0.6, (0.012, 0.018, 0.042)), (1.0, (0.035, 0.042, 0.075))))
WIDE = 32  # pixels of a tile
NEAR = WIDE // 4 + 4  # coarse pixels whose light reaches a tile

# run-time numbers
EXPOSURE, OWN, STRAY, VIGNETTE, GRAIN, DITHER, BACKGROUND, TOP, CONTRAST, DENSITY, VIBRANCY, WHITE = range(12)
LOW, HIGH, ABOVE, BELOW = 12, 13, 14, 18
BEFORE, AFTER, BLEND = 22, 31, 40
NUMBERS = 60

# sRGB's power branch, 1.055 x^(1/2.4) - 0.055 for x from 0.0031308 to 1, as a polynomial in x^(1/4): within 2e-6
_ENCODE = (-0.0594615168, 0.138698142, 1.36968298, -0.860760117, 0.665713904, -0.323057044, 0.069183654)

F1, F2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)


@ti.func
def _within(x, low, high):
    """x held in a range; what is no number becomes `low`."""
    y = ti.select(x > low, x, low)
    return ti.select(y < high, y, high)


@ti.func
def _encoded(x):
    """sRGB-encoded light, 0..1."""
    y = _within(x, 0.0, 1.0)
    s = ti.sqrt(ti.sqrt(y))
    e = s * _ENCODE[6] + _ENCODE[5]
    for k in ti.static(range(4, -1, -1)):
        e = e * s + _ENCODE[k]
    return ti.select(y > 0.0031308, e, y * 12.92)


@ti.func
def _hash(a):
    h = (a ^ (a >> ti.u32(16))) * ti.u32(0x7FEB352D)
    h = (h ^ (h >> ti.u32(15))) * ti.u32(0x846CA68B)
    return h ^ (h >> ti.u32(16))


class Steps(NamedTuple):
    """What a picture is developed with: only that is compiled, and loaded. Numbers are never in it."""

    strays: bool
    vignette: bool
    contrast: bool
    whole: str
    transparent: bool
    grain: bool
    deep: bool


@cache
def _developing(steps: Steps):
    """The kernel of these steps."""

    @ti.kernel
    def develop_steps(
        film: F1, stride: ti.i32, width: ti.i32, height: ti.i32, seen: ti.i32, coarse: F1, across: ti.i32, key: ti.i32,
        sky: F2, Q: F1, out: ti.types.ndarray(ti.i32, 1),
    ):  # fmt: skip
        """width : a multiple of 4, at least WIDE, of which `seen` pixels are the picture; stride and across in floats

        out : the picture's bytes, four at a time
        """
        ti.loop_config(block_dim=4)
        for i in range(height):
            T = ti.Vector([0.0] * (5 * WIDE))  # how much a tile's pixels take of each coarse one
            for k in range(5 * WIDE):
                T[k] = Q[BLEND + 5 * (k & 3) + (k >> 5)]
            dy = (ti.cast(i, ti.f32) + 0.5) / ti.cast(height, ti.f32) * 2.0 - 1.0
            across_one = 2.0 / ti.cast(seen, ti.f32)
            for t in range((width + WIDE - 1) // WIDE):
                at = ti.min(t * WIDE, width - WIDE)
                R, G, B = ti.Vector([0.0] * WIDE), ti.Vector([0.0] * WIDE), ti.Vector([0.0] * WIDE)
                A, E = ti.Vector([0.0] * WIDE), ti.Vector([1.0] * WIDE)
                # pixel by pixel, to a bound known at run time only: else LLVM makes gathers of it, half the kernel's time
                for k in range(ti.min(WIDE, width)):
                    o = i * stride + (at + k) * 4
                    R[k], G[k], B[k], A[k] = film[o] * Q[OWN], film[o + 1] * Q[OWN], film[o + 2] * Q[OWN], film[o + 3]
                for k in range(WIDE):
                    A[k] = _within(A[k], 0.0, 1.0)
                if ti.static(steps.strays):
                    C = ti.Vector([0.0] * (4 * NEAR))  # the coarse rows around, blended
                    o = (i >> 2) * across + at
                    b = BLEND + 5 * (i & 3)
                    for k in range(ti.min(4 * NEAR, 4 * width)):
                        v = 0.0
                        for e in ti.static(range(5)):
                            v += coarse[o + e * across + k] * Q[b + e]
                        C[k] = v * Q[STRAY]
                    for c, V in ti.static(((0, R), (1, G), (2, B))):
                        S = ti.Vector([0.0] * (4 * NEAR))  # each coarse pixel four times
                        for k in range(NEAR):
                            for p in ti.static(range(4)):
                                S[4 * k + p] = C[4 * k + c]
                        for k in range(WIDE):
                            v = V[k]
                            for e in ti.static(range(5)):
                                v += S[k + 4 * e] * T[e * WIDE + k]
                            V[k] = v
                if ti.static(steps.vignette):
                    for k in range(WIDE):
                        dx = (ti.cast(at + k, ti.f32) + 0.5) * across_one - 1.0
                        edge = 1.0 + Q[VIGNETTE] * 0.5 * (dx * dx + dy * dy)
                        E[k] = 1.0 / (edge * edge)
                for k in range(WIDE):
                    shine = E[k] * Q[EXPOSURE]
                    r, g, l = R[k] * shine, G[k] * shine, B[k] * shine
                    R[k] = Q[BEFORE] * r + Q[BEFORE + 1] * g + Q[BEFORE + 2] * l
                    G[k] = Q[BEFORE + 3] * r + Q[BEFORE + 4] * g + Q[BEFORE + 5] * l
                    B[k] = Q[BEFORE + 6] * r + Q[BEFORE + 7] * g + Q[BEFORE + 8] * l
                if ti.static(steps.contrast):
                    for j in range(WIDE):
                        R[j] = GREY * power(R[j] * (1.0 / GREY), Q[CONTRAST])
                        G[j] = GREY * power(G[j] * (1.0 / GREY), Q[CONTRAST])
                        B[j] = GREY * power(B[j] * (1.0 / GREY), Q[CONTRAST])
                if ti.static(steps.whole == "neutral"):
                    for j in range(WIDE):  # Khronos PBR Neutral
                        r, g, l = R[j], G[j], B[j]
                        least = ti.min(r, ti.min(g, l))
                        toe = ti.select(least < 0.08, least - 6.25 * least * least, 0.04)
                        peak = ti.max(r, ti.max(g, l)) - toe
                        high = ti.select(peak > 0.76, peak, 0.76)
                        top = 1.0 - 0.0576 / (high - 0.52)
                        keep = 1.0 / (0.15 * (high - top) + 1.0)
                        scale = top / high * keep
                        white = top * (1.0 - keep)
                        R[j] = (r - toe) * scale + white
                        G[j] = (g - toe) * scale + white
                        B[j] = (l - toe) * scale + white
                elif ti.static(steps.whole == "log"):
                    whole = 1.0 / log(1.0 + Q[DENSITY] * Q[WHITE])
                    for j in range(WIDE):  # log density
                        r, g, l = _within(R[j], 0.0, 1e12), _within(G[j], 0.0, 1e12), _within(B[j], 0.0, 1e12)
                        peak = ti.max(r, ti.max(g, ti.max(l, 1e-20)))
                        scale = log(1.0 + Q[DENSITY] * peak) * whole * Q[VIBRANCY] / peak
                        rest = whole * (1.0 - Q[VIBRANCY])
                        R[j] = r * scale + log(1.0 + Q[DENSITY] * r) * rest
                        G[j] = g * scale + log(1.0 + Q[DENSITY] * g) * rest
                        B[j] = l * scale + log(1.0 + Q[DENSITY] * l) * rest
                else:
                    for j in range(WIDE):  # N / D of each channel, by one division
                        n, d = ti.Vector([0.0] * 3), ti.Vector([0.0] * 3)
                        for c, V in ti.static(((0, R), (1, G), (2, B))):
                            x = _within(V[j], Q[LOW], Q[HIGH])
                            n[c] = ((Q[ABOVE + 3] * x + Q[ABOVE + 2]) * x + Q[ABOVE + 1]) * x + Q[ABOVE]
                            d[c] = ((Q[BELOW + 3] * x + Q[BELOW + 2]) * x + Q[BELOW + 1]) * x + Q[BELOW]
                        rg = d[0] * d[1]
                        one = 1.0 / (rg * d[2])
                        R[j] = n[0] * d[1] * d[2] * one
                        G[j] = n[1] * d[0] * d[2] * one
                        B[j] = n[2] * rg * one
                for j in range(WIDE):
                    r, g, l = R[j], G[j], B[j]
                    # the background is seen as it is written, dimmed by what shines over it
                    back = (1.0 - A[j]) * E[j] * Q[BACKGROUND]
                    for c, V in ti.static(((0, R), (1, G), (2, B))):
                        v = Q[AFTER + 3 * c] * r + Q[AFTER + 3 * c + 1] * g + Q[AFTER + 3 * c + 2] * l
                        V[j] = v + sky[i, c] * back * (1.0 - _within(v, 0.0, 1.0))
                if ti.static(steps.transparent):
                    for j in range(WIDE):
                        A[j] = _within(ti.max(A[j], ti.max(R[j], ti.max(G[j], B[j]))), 1e-6, 1.0)
                        R[j], G[j], B[j] = R[j] / A[j], G[j] / A[j], B[j] / A[j]
                N = ti.Vector([ti.u32(0)] * WIDE)
                for j in range(WIDE):
                    N[j] = _hash(ti.cast(i * 16384 + at + j, ti.u32) ^ _hash(ti.cast(key, ti.u32)))
                for j in range(WIDE):
                    R[j], G[j], B[j] = _encoded(R[j]), _encoded(G[j]), _encoded(B[j])
                if ti.static(steps.grain):
                    for j in range(WIDE):  # four bytes' mean: nearly normal, standard deviation 1
                        h = _hash(N[j])
                        two = (h & ti.u32(0xFF00FF)) + ((h >> ti.u32(8)) & ti.u32(0xFF00FF))
                        four = (two & ti.u32(0xFFFF)) + (two >> ti.u32(16))
                        g = (ti.cast(ti.cast(four, ti.i32), ti.f32) - 510.0) * (Q[GRAIN] * 4.0 / 147.8)
                        for V in ti.static((R, G, B)):
                            V[j] = _within(V[j] + g * V[j] * (1.0 - V[j]), 0.0, 1.0)
                low = 0.5 - 0.49951171875 * Q[DITHER]
                noise = Q[DITHER] / 1024.0
                for j in range(WIDE):
                    for c, V in ti.static(((0, R), (1, G), (2, B))):
                        n = ti.cast(ti.cast((N[j] >> ti.u32(10 * c)) & ti.u32(1023), ti.i32), ti.f32)
                        V[j] = V[j] * Q[TOP] + (n * noise + low)
                W = ti.Vector([0] * WIDE)
                if ti.static(not steps.deep):
                    for j in range(WIDE):
                        rgb = ti.cast(R[j], ti.i32) | (ti.cast(G[j], ti.i32) << 8) | (ti.cast(B[j], ti.i32) << 16)
                        W[j] = rgb | (ti.cast(A[j] * Q[TOP] + 0.5, ti.i32) << 24)
                    o = (i * width + at) >> 2
                    if ti.static(steps.transparent):
                        for j in range(WIDE):
                            out[4 * o + j] = W[j]
                    else:
                        X = ti.Vector([0] * WIDE)
                        for j in range(
                            WIDE - 1
                        ):  # a word of each pixel's end and the next one's start: three of four are used
                            X[j] = ((W[j] & 0xFFFFFF) >> ((j & 3) << 3)) | (W[j + 1] << (24 - ((j & 3) << 3)))
                        for j in range(ti.min(WIDE // 4, width)):
                            for k in ti.static(range(3)):
                                out[3 * (o + j) + k] = X[4 * j + k]
                else:
                    U = ti.Vector([0] * WIDE)
                    for j in range(WIDE):
                        W[j] = ti.cast(R[j], ti.i32) | (ti.cast(G[j], ti.i32) << 16)
                        U[j] = ti.cast(B[j], ti.i32) | (ti.cast(A[j] * Q[TOP] + 0.5, ti.i32) << 16)
                    if ti.static(steps.transparent):
                        for j in range(WIDE):
                            o = 2 * (i * width + at + j)
                            out[o], out[o + 1] = W[j], U[j]
                    else:
                        for j in range(WIDE // 2):
                            o = 3 * (((i * width + at) >> 1) + j)
                            a, b = W[2 * j], W[2 * j + 1]
                            u = U[2 * j] & 0xFFFF
                            out[o], out[o + 1] = a, u | (b << 16)
                            out[o + 2] = ((b >> 16) & 0xFFFF) | (U[2 * j + 1] << 16)

    return kernel(develop_steps)


_NOTHING = np.zeros(TILE, np.float32)
_PLAIN = DevelopSpec()


@lru_cache(8)
def _numbers(spec: DevelopSpec, bits: int, transparent: bool) -> np.ndarray:
    q = np.zeros(NUMBERS, np.float32)
    q[VIGNETTE], q[GRAIN], q[DITHER] = 2.0 ** (spec.vignette / 2) - 1.0, spec.grain, spec.dither and bits == 8
    q[BACKGROUND], q[TOP], q[CONTRAST] = not transparent, 2.0**bits - 1.0, spec.contrast
    q[DENSITY], q[VIBRANCY], q[WHITE] = spec.density, spec.vibrancy, spec.white
    q[LOW : BELOW + 4] = rational(spec.tone, spec.white)
    before, after = matrices(spec.tone, spec.saturation)
    q[BEFORE : BEFORE + 9], q[AFTER : AFTER + 9] = before.reshape(-1), after.reshape(-1)
    q[BLEND:] = blend_weights().reshape(-1)
    return q


@lru_cache(4)
def _sky(background, height: int) -> np.ndarray:
    gradient = _NIGHT if background == "night" else background
    return np.ascontiguousarray(gradient_table(gradient, max(height, 2))[:height].astype(np.float32))


def develop(
    film: np.ndarray, spec: DevelopSpec = _PLAIN, frame: int = 0, transparent: bool = False, bits: int = 8,
    exposure: float | None = None, out: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """A picture (height, width, 3 or, transparent, 4) of uint8 or uint16, sRGB, from linear premultiplied RGBA.

    film : (height, width, 4) float32      frame : seeds dither and grain      bits : 8 or 16
    exposure : stops on top of the spec's own (what a Meter found)      out : a picture to write into
    Transparent pictures have straight alpha: light over nothing is as opaque as it is bright.
    """
    if bits not in (8, 16):
        raise UsageError(f"a picture has 8 or 16 bits a channel, not {bits}")
    height, width = film.shape[:2]
    q = _numbers(spec, bits, transparent).copy()
    q[EXPOSURE], q[OWN] = 2.0 ** (spec.exposure + (exposure or 0.0)), 1.0
    strength, halo = spec.bloom.strength, chain(width, height) if spec.bloom.strength else None
    if halo and halo.scales[0] != 4:
        film, halo = halo.bloomed(np.asarray(film, np.float32), strength, spec.bloom.radius), None
    if width % 4:  # whole groups of four pixels: black beside the picture
        film = np.pad(np.asarray(film, np.float32), ((0, 0), (0, -width % 4), (0, 0)))
    light, stride = flat(film, WIDE)
    coarse, across = _NOTHING, 4
    if halo:
        own, picture = halo.spread(light, stride, spec.bloom.radius)
        q[OWN], q[STRAY], coarse, across = 1.0 + strength * (own - 1.0), strength, picture.floats, picture.stride
    channels = 4 if transparent else 3
    depth = np.uint8 if bits == 8 else np.uint16
    wide = max(film.shape[1], WIDE)
    picture = out
    if out is None or wide > width or not out.flags.c_contiguous:
        picture = np.empty((height, wide, channels), depth)
    words = picture.reshape(-1).view(np.int32)
    sky = _sky(spec.background, height)
    steps = Steps(
        halo is not None, spec.vignette > 0.0, spec.contrast != 1.0, spec.tone if spec.tone in ("neutral", "log") else "",
        transparent, spec.grain > 0.0, bits == 16,
    )  # fmt: skip
    _developing(steps)(light, stride, wide, height, width, coarse, across, int(frame), sky, q, words)
    if out is None:
        return np.ascontiguousarray(picture[:, :width])
    if picture is not out:
        out[:] = picture[:, :width]
    return out
