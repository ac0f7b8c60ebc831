"""Light of a framebuffer of half the size, composited over or under that of the full size.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import INDEX_MASK, kernel, ti
from gen_art.renderer.picture_tiles import BIN

__all__ = ["composite"]

I1, PIXELS = ti.types.ndarray(ti.i32, 1), ti.types.ndarray(ti.types.vector(4, ti.f32), 1)


@ti.func
def _four(x):
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(4))])


@ti.func
def _blend(framebuffer: ti.template(), place, v, over):
    if over == 1:
        framebuffer[place] = framebuffer[place] * _four(1.0 - v[3]) + v
    else:
        u = framebuffer[place]
        framebuffer[place] = v * _four(1.0 - u[3]) + u


@ti.kernel
def _composite(
    coarse: PIXELS, cw: ti.i32, ch: ti.i32, cs: ti.i32, framebuffer: PIXELS, stride: ti.i32, across: ti.i32, changed: I1,
    n: ti.i32, over: ti.i32,
):  # fmt: skip
    """Composite `coarse` over (`over` = 1) or under the framebuffer, in the n bins listed in `changed`, with bilinear weights.

    cw, ch, cs : width, height and stride of `coarse`, in pixels
    """
    ti.loop_config(block_dim=1)
    for k in range(n):
        x0, y0 = (changed[k] % across) * BIN, (changed[k] // across) * BIN
        p, q, r = _four(0.5625), _four(0.1875), _four(0.0625)
        for y in range(y0, y0 + BIN):
            j = y >> 1
            near, far = ti.min(j, ch - 1) * cs, ti.min(ti.max(j - 1 + 2 * (y & 1), 0), ch - 1) * cs  # rows of `coarse`
            for i in range(x0 // 2, x0 // 2 + BIN // 2):
                at, left, right = ti.min(i, cw - 1), ti.min(ti.max(i - 1, 0), cw - 1), ti.min(i + 1, cw - 1)
                both = p * coarse[(near + at) & INDEX_MASK]
                a = both + q * (coarse[(near + left) & INDEX_MASK] + coarse[(far + at) & INDEX_MASK])
                b = both + q * (coarse[(near + right) & INDEX_MASK] + coarse[(far + at) & INDEX_MASK])
                a, b = a + r * coarse[(far + left) & INDEX_MASK], b + r * coarse[(far + right) & INDEX_MASK]
                place = (y * stride + 2 * i) & INDEX_MASK
                _blend(framebuffer, place, a, over)
                _blend(framebuffer, place + 1, b, over)


composite = kernel(_composite, vectors=True)
