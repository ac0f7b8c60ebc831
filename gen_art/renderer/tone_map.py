"""From linear light to a picture: exposure, bloom, vignette, tone map, background, grain, sRGB, dither.

The light is read twice: once by the first step of bloom, once by the kernel (tone_map_kernel.py).
"""

from functools import lru_cache

import numpy as np

from gen_art.backend.runtime import aligned
from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer import tone_map_kernel as kernel
from gen_art.renderer.bloom import as_vectors, bloom_pyramid
from gen_art.renderer.colour import gradient_table
from gen_art.renderer.resample import blend_weights
from gen_art.renderer.tone_curves import matrices, rational
from gen_art.renderer.vector_maths import ROUND, WIDE, constant_table

__all__ = ["develop"]

_NIGHT = Gradient(((0.0, (0.004, 0.006, 0.016)), (0.6, (0.012, 0.018, 0.042)), (1.0, (0.035, 0.042, 0.075))))
_NO_BLOOM = aligned((2, 16), np.float32)
_SCRATCH = aligned((kernel.TASKS * kernel.SCRATCH, WIDE), np.float32)
_WEIGHTS, _BLEND = blend_weights().reshape(-1, 1), aligned((16, 16), np.float32)
_DEFAULT = DevelopSpec()


@lru_cache(8)
def _kernel_numbers(spec: DevelopSpec, bits: int) -> tuple[np.ndarray, np.ndarray]:
    """The kernel's table without the matrix before the curve, and that matrix, (9, 1), which depends on the exposure too."""
    q = constant_table(kernel.NUMBERS)
    q[kernel.VIGNETTE], q[kernel.GRAIN] = 2.0 ** (spec.vignette / 2) - 1.0, spec.grain
    q[kernel.CODES], q[kernel.CONTRAST] = 2.0**bits - 1.0, spec.contrast
    q[kernel.TOP] = (2.0**bits - 1.0) * (1024 if bits == 8 else 1)
    # ten bits of noise, from half a code below to less than half a code above, so that white stays white
    dithered = spec.dither and bits == 8
    q.view(np.uint32)[kernel.DITHER] = 1023 if dithered else 0
    q[kernel.ROUNDING] = ROUND + (512 if bits == 8 and not dithered else 0)
    q[kernel.DENSITY], q[kernel.VIBRANCY], q[kernel.WHITE] = spec.density, spec.vibrancy, spec.white
    q[kernel.LOW : kernel.DENOMINATOR + 4] = rational(spec.tone, spec.white)[:, None]
    before, after = (m.reshape(-1, 1) for m in matrices(spec.tone, spec.saturation))
    q[kernel.AFTER : kernel.AFTER + 9] = after
    return q, before


@lru_cache(4)
def _background_rows(background, height: int) -> tuple[np.ndarray, bool]:
    """The background's light row by row, (height, 3), and whether there is any."""
    gradient = _NIGHT if background == "night" else background
    rows = np.ascontiguousarray(gradient_table(gradient, max(height, 2))[:height].astype(np.float32))
    return rows, bool(rows.any())


def develop(
    linear: np.ndarray, spec: DevelopSpec = _DEFAULT, frame: int = 0, transparent: bool = False, bits: int = 8,
    exposure: float | None = None, out: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """A picture (height, width, 3 or, transparent, 4) of uint8 or uint16, sRGB, from linear premultiplied RGBA.

    linear : (height, width, 4) float32
    frame : seed of dither and grain
    transparent : whether the picture has an alpha channel, which is straight; light over nothing is as opaque as it is bright
    bits : 8 or 16
    exposure : stops in addition to the spec's own (automatic exposure)
    out : a picture to write into
    Raises UsageError for other numbers of bits.
    """
    if bits not in (8, 16):
        raise UsageError(f"a picture has 8 or 16 bits a channel, not {bits}")
    height, width = linear.shape[:2]
    q, before = _kernel_numbers(spec, bits)
    remaining = 1.0  # share of the light that bloom does not scatter
    strength, pyramid = spec.bloom.strength, bloom_pyramid(width, height) if spec.bloom.strength else None
    if pyramid and pyramid.scales[0] != 4:
        linear, pyramid = pyramid.with_bloom(np.asarray(linear, np.float32), strength, spec.bloom.radius), None
    padded_width = width + -width % WIDE  # the pixels beyond the picture are black
    vectors, stride = as_vectors(linear)
    coarse: np.ndarray = _NO_BLOOM
    coarse_stride = 1
    if pyramid:
        unscattered, level = pyramid.scatter(vectors, stride, spec.bloom.radius)
        remaining = max(1.0 + strength * (unscattered - 1.0), 1e-6)
        np.multiply(_WEIGHTS, strength / remaining, out=_BLEND)
        coarse, coarse_stride = level.vectors, level.stride // 4
    channels = 4 if transparent else 3
    dtype = np.uint8 if bits == 8 else np.uint16
    if out is None or padded_width > width or not out.flags.c_contiguous or out.ctypes.data % 16:
        picture = aligned((height, padded_width, channels), dtype)
    else:
        picture = out
    background, has_background = _background_rows(spec.background, height)
    gain = remaining * 2.0 ** (spec.exposure + (exposure or 0.0))
    np.multiply(before, gain, out=q[kernel.BEFORE : kernel.BEFORE + 9])
    steps = kernel.ToneMapSteps(
        bloom=pyramid is not None, vignette=spec.vignette > 0.0, background=has_background and not transparent,
        contrast=spec.contrast != 1.0, tone=spec.tone if spec.tone in ("neutral", "log") else "", transparent=transparent,
        grain=spec.grain > 0.0, sixteen_bit=bits == 16,
    )  # fmt: skip
    kernel.tone_map_kernel(steps)(
        vectors, stride, padded_width, height, width, coarse, coarse_stride, _BLEND, int(frame), background,
        q, q.view(np.uint32), _SCRATCH, _SCRATCH.view(np.uint32), picture.reshape(-1).view(np.uint32).reshape(-1, 4),
    )  # fmt: skip
    if out is None:
        return np.ascontiguousarray(picture[:, :width])
    if picture is not out:
        out[:] = picture[:, :width]
    return out
