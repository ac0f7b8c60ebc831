"""Light that strays in the lens: a chain of halved pictures, blurred by going down and up again, whose sum is kept.

In one dimension a fine pixel j = 2i gives 3/4 to coarse i and 1/4 to i - 1, j = 2i + 1 gives 3/4 to i and 1/4 to
i + 1 (beyond the border: to the last one). Up is the same weights divided by what each coarse pixel received. Both
hand on all the energy they get, for any size, so the picture's sum stays and nothing leaves at the border.
"""

from functools import cache

import numpy as np

from gen_art.runtime import kernel, ti

__all__ = ["levels", "stray_light"]

F1, F2, I2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i32, 2)


@cache
def _weights(n: int):
    """(down (m, 4) of fine 2i - 1 .. 2i + 2; up (n, 2); up's coarse indices (n, 2)) for n fine pixels."""
    m = (n + 1) // 2
    share = np.zeros((n, m))
    for j in range(n):
        i = j // 2
        share[j, i] += 0.75
        share[j, min(max(i + (1 if j % 2 else -1), 0), m - 1)] += 0.25
    received = share.sum(axis=0)
    down = np.zeros((m, 4), np.float32)
    up, index = np.zeros((n, 2), np.float32), np.zeros((n, 2), np.int32)
    for i in range(m):
        for k in range(4):
            if 0 <= 2 * i - 1 + k < n:
                down[i, k] = share[2 * i - 1 + k, i]
    for j in range(n):
        near = np.flatnonzero(share[j])
        for k, i in enumerate(near):
            up[j, k], index[j, k] = share[j, i] / received[i], i
        if len(near) == 1:
            index[j, 1] = near[0]
    return down, up, index


@ti.kernel
def _down(fine: F1, w: ti.i32, h: ti.i32, wx: F2, wy: F2, coarse: F1):
    ti.loop_config(block_dim=4)
    for i in range((h + 1) // 2):
        for j in range((w + 1) // 2):
            total = ti.Vector([0.0, 0.0, 0.0])
            for a in range(4):
                row = ti.min(ti.max(2 * i - 1 + a, 0), h - 1)
                for b in ti.static(range(4)):
                    o = (row * w + ti.min(ti.max(2 * j - 1 + b, 0), w - 1)) * 4
                    weight = wy[i, a] * wx[j, b]
                    total += ti.Vector([fine[o], fine[o + 1], fine[o + 2]]) * weight
            o = (i * ((w + 1) // 2) + j) * 4
            coarse[o], coarse[o + 1], coarse[o + 2] = total[0], total[1], total[2]


@ti.kernel
def _up(coarse: F1, w: ti.i32, h: ti.i32, wx: F2, ix: I2, wy: F2, iy: I2, own: ti.f32, fine: F1):
    """fine = own * fine + coarse spread out"""
    ti.loop_config(block_dim=4)
    for i in range(h):
        cw = (w + 1) // 2
        a, b = iy[i, 0] * cw, iy[i, 1] * cw
        for j in range(w):
            o = (i * w + j) * 4
            p, q = ix[j, 0], ix[j, 1]
            for c in ti.static(range(3)):
                left = coarse[(a + p) * 4 + c] * wy[i, 0] + coarse[(b + p) * 4 + c] * wy[i, 1]
                right = coarse[(a + q) * 4 + c] * wy[i, 0] + coarse[(b + q) * 4 + c] * wy[i, 1]
                fine[o + c] = own * fine[o + c] + (left * wx[j, 0] + right * wx[j, 1])


down, up = kernel(_down), kernel(_up)


NARROWEST, OCTAVES = 1 / 360, 7  # halos from a 360th of the picture's height, each twice as wide as the one before


def levels(height: int, radius: float) -> np.ndarray:
    """Weights of the picture itself and of its halvings; they sum to 1 and mean the same halos at any size.

    Halos narrower than a pixel fall to the picture itself; a width between two halvings is shared by them.
    """
    halos = (0.35 + 0.85 * radius) ** np.arange(OCTAVES, dtype=np.float64)
    halos /= halos.sum()
    depth = max(0, int(np.floor(np.log2(max(height, 1) / 2.0))))
    weights = np.zeros(depth + 1)
    for k, weight in enumerate(halos):
        place = min(max(np.log2(max(height, 1) * NARROWEST) + k, 0.0), float(depth))
        low = min(int(place), depth)
        weights[low] += weight * (1.0 - (place - low))
        weights[min(low + 1, depth)] += weight * (place - low)
    return np.trim_zeros(weights, "b").astype(np.float32)


def stray_light(film: np.ndarray, radius: float) -> np.ndarray:
    """The film's light spread over halos of all sizes: (height, width, 4) float32 whose first three channels keep their sums."""
    h, w = film.shape[:2]
    weights = levels(h, radius)
    chain, sizes = [film.reshape(-1)], [(w, h)]
    for _ in weights[1:]:
        fw, fh = sizes[-1]
        cw, ch = (fw + 1) // 2, (fh + 1) // 2
        coarse = np.zeros(cw * ch * 4, np.float32)
        down(chain[-1], fw, fh, _weights(fw)[0], _weights(fh)[0], coarse)
        chain.append(coarse)
        sizes.append((cw, ch))
    chain[0] = chain[0].copy()
    if len(weights) == 1:
        return chain[0].reshape(h, w, 4)
    chain[-1] *= weights[-1]
    for k in range(len(weights) - 2, -1, -1):
        fw, fh = sizes[k]
        _, ux, ix = _weights(fw)
        _, uy, iy = _weights(fh)
        up(chain[k + 1], fw, fh, ux, ix, uy, iy, float(weights[k]), chain[k])
    return chain[0].reshape(h, w, 4)
