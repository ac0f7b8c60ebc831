"""From the film's linear light to a picture: exposure, bloom, vignette, tone map, background, grain, sRGB, dither.

The film is read twice: once by the first step of bloom, once by the kernel (developing.py).
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import aligned
from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer import tone_map_kernel as kernel
from gen_art.renderer.bloom import chain, flat
from gen_art.renderer.colour import gradient_table
from gen_art.renderer.resample import blend_weights
from gen_art.renderer.tone_curves import matrices, rational
from gen_art.renderer.vector_maths import ROUND, WIDE, table

__all__ = ["develop"]

_NIGHT = Gradient(((0.0, (0.004, 0.006, 0.016)), (0.6, (0.012, 0.018, 0.042)), (1.0, (0.035, 0.042, 0.075))))
_NOTHING = aligned((2, 16), np.float32)
_SCRATCH = aligned((kernel.TASKS * kernel.SCRATCH, WIDE), np.float32)
_WEIGHTS, _BLEND = blend_weights().reshape(-1, 1), aligned((16, 16), np.float32)
_PLAIN = DevelopSpec()


@lru_cache(8)
def _numbers(spec: DevelopSpec, bits: int) -> tuple[np.ndarray, np.ndarray]:
    """The kernel's table, and the matrix before the curve, (9, 1), which is in it times the exposure."""
    q = table(kernel.NUMBERS)
    q[kernel.VIGNETTE], q[kernel.GRAIN] = 2.0 ** (spec.vignette / 2) - 1.0, spec.grain
    q[kernel.CODES], q[kernel.CONTRAST] = 2.0**bits - 1.0, spec.contrast
    q[kernel.TOP] = (2.0**bits - 1.0) * (1024 if bits == 8 else 1)
    # ten bits of noise from half a code below to less than half above, so that white stays white
    dithered = spec.dither and bits == 8
    q.view(np.uint32)[kernel.DITHER] = 1023 if dithered else 0
    q[kernel.ROUNDING] = ROUND + (512 if bits == 8 and not dithered else 0)
    q[kernel.DENSITY], q[kernel.VIBRANCY], q[kernel.WHITE] = spec.density, spec.vibrancy, spec.white
    q[kernel.LOW : kernel.BELOW + 4] = rational(spec.tone, spec.white)[:, None]
    before, after = (m.reshape(-1, 1) for m in matrices(spec.tone, spec.saturation))
    q[kernel.AFTER : kernel.AFTER + 9] = after
    return q, before


@lru_cache(4)
def _sky(background, height: int) -> tuple[np.ndarray, bool]:
    """Its light row by row, and whether there is any."""
    gradient = _NIGHT if background == "night" else background
    sky = np.ascontiguousarray(gradient_table(gradient, max(height, 2))[:height].astype(np.float32))
    return sky, bool(sky.any())


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
    q, before = _numbers(spec, bits)
    share = 1.0  # of its light that stays where it is
    strength, halo = spec.bloom.strength, chain(width, height) if spec.bloom.strength else None
    if halo and halo.scales[0] != 4:
        film, halo = halo.bloomed(np.asarray(film, np.float32), strength, spec.bloom.radius), None
    wide = width + -width % WIDE  # black beside the picture
    light, stride = flat(film)
    coarse, across = _NOTHING, 1
    if halo:
        own, picture = halo.spread(light, stride, spec.bloom.radius)
        share = max(1.0 + strength * (own - 1.0), 1e-6)
        np.multiply(_WEIGHTS, strength / share, out=_BLEND)
        coarse, across = picture.vectors, picture.stride // 4
    channels = 4 if transparent else 3
    depth = np.uint8 if bits == 8 else np.uint16
    picture = out
    if out is None or wide > width or not out.flags.c_contiguous or out.ctypes.data % 16:
        picture = aligned((height, wide, channels), depth)
    sky, lit = _sky(spec.background, height)
    np.multiply(before, share * 2.0 ** (spec.exposure + (exposure or 0.0)), out=q[kernel.BEFORE : kernel.BEFORE + 9])
    steps = kernel.ToneMapSteps(
        strays=halo is not None, vignette=spec.vignette > 0.0, background=lit and not transparent,
        contrast=spec.contrast != 1.0, tone=spec.tone if spec.tone in ("neutral", "log") else "", transparent=transparent,
        grain=spec.grain > 0.0, deep=bits == 16,
    )  # fmt: skip
    kernel.compiled(steps)(
        light, stride, wide, height, width, coarse, across, _BLEND, int(frame), sky, q, q.view(np.uint32), _SCRATCH,
        _SCRATCH.view(np.uint32), picture.reshape(-1).view(np.uint32).reshape(-1, 4),
    )  # fmt: skip
    if out is None:
        return np.ascontiguousarray(picture[:, :width])
    if picture is not out:
        out[:] = picture[:, :width]
    return out
