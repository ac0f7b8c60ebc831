"""What varies over the surface of a collider: images of its colour, light and relief, and puddles.

Images, reliefs and puddles are squares of texels with all their smaller versions (a mipmap), repeated along two axes of the
collider. A pixel's footprint is covered by a few samples along its longer side, each as wide as its shorter side.

The one-letter names in kernels are in docs/glossary.md.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gen_art.backend.runtime import ti
from gen_art.files import cached_by_file
from gen_art.maths.random import derive, uniform
from gen_art.pictures import read_picture
from gen_art.preset.surface import Puddles, SurfaceLook
from gen_art.renderer.colour import bytes_to_linear
from gen_art.renderer.mipmap import mipmap_chain
from gen_art.renderer.surfaces.water_waves import patch_rows, wave_rows

__all__ = ["NO_MAPS", "SurfaceMaps", "map_at", "puddle_texels"]

SIDE = 1024  # texels along a side of the largest version of an image
_PUDDLE_SIDE, _PUDDLE_PERIOD = 512, 16  # texels along a side of puddles, and the sizes of a puddle that it spans
_EDGE = 0.08  # the part of the range of heights over which a puddle's edge becomes dry
_MOST_SAMPLES = 16  # along the longer side of a footprint
_WORD = 2**64 - 1
# numbers of a map in a material's row: first texel, side, and 1 / the lengths of the repeated square, 0 for none
FIRST, MAP_SIDE, PER_WIDTH, PER_HEIGHT = range(4)
MAP_FLOATS = 4

F2 = ti.types.ndarray(ti.f32, 2)


class SurfaceMaps(NamedTuple):
    """The maps of the surfaces of a scene.

    texels : (n, 4) float32, linear premultiplied light of images; the wet part in the fourth number of puddles; of a relief the
        slopes to the right and down, and the sum of their squares
    waves : (m, 6) float32: the two wave numbers (1/m), the slope's amplitude, the phase at the picture's time, the amplitude's
        parts along the two axes; of a sea its
        waves, then what makes it uneven
    chains : the maps that `texels` joins
    """

    texels: np.ndarray
    waves: np.ndarray
    chains: tuple[np.ndarray, ...] = ()

    @classmethod
    def of(
        cls,
        looks,
        table: np.ndarray,
        columns: tuple[int, int, int, int, int],
        time: float,
        before: "SurfaceMaps | None" = None,
    ) -> "SurfaceMaps":
        """The maps of the looks of a scene; `table` gets where those of each material are.

        columns : of the numbers of the image, the puddles (of bodies, the image of their ends), the light, the relief and the
            waves (their first row, their number, and the number of rows after them that make them uneven)
        before : of the picture before, whose texels are kept where the maps are the same
        """
        chains: list[np.ndarray] = []
        waves: list[np.ndarray] = []
        for row, look in zip(table, looks):
            if look.image is not None:
                chain, ratio = image_texels(look.image.file.place)
                _note(row, columns[0], chains, chain, look.image.size, look.image.size * ratio)
                if look.image.ends is not None:  # of bodies, which have no puddles
                    chain, ratio = image_texels(look.image.ends.place)
                    _note(row, columns[1], chains, chain, look.image.size, look.image.size * ratio)
            if not isinstance(look, SurfaceLook):
                continue
            if look.puddles is not None:
                side = look.puddles.size * _PUDDLE_PERIOD
                _note(row, columns[1], chains, puddle_texels(look.puddles), side, side)
            if look.emission_image is not None:
                chain, ratio = image_texels(look.emission_image.file.place)
                _note(row, columns[2], chains, chain, look.emission_image.size, look.emission_image.size * ratio)
            if look.relief is not None:
                chain, height = relief_texels(look.relief.file.place, look.relief.size, look.relief.depth)
                _note(row, columns[3], chains, chain, look.relief.size, height)
            if look.waves is not None:
                uneven = patch_rows(look.waves)
                row[columns[4] : columns[4] + 3] = sum(map(len, waves)), look.waves.number, len(uneven)
                waves += [wave_rows(look.waves, time), uneven]
        before = before or NO_MAPS
        same = len(chains) == len(before.chains) and all(a is b for a, b in zip(chains, before.chains))
        texels = before.texels if same else np.concatenate(chains or [NO_MAPS.texels])
        return cls(texels, np.concatenate(waves) if waves else NO_MAPS.waves, tuple(chains))

    @property
    def any(self) -> bool:
        return self is not NO_MAPS and (len(self.texels) > 1 or len(self.waves) > 1)


NO_MAPS = SurfaceMaps(np.zeros((1, 4), np.float32), np.zeros((1, 6), np.float32))


def _note(row: np.ndarray, column: int, chains: list, chain: np.ndarray, width: float, height: float) -> None:
    side = round(math.sqrt((3 * len(chain) + 1) / 4))
    known = next((k for k, other in enumerate(chains) if other is chain), len(chains))
    row[column : column + MAP_FLOATS] = sum(map(len, chains[:known])), side, 1.0 / width, 1.0 / height
    if known == len(chains):
        chains.append(chain)


@cached_by_file(8)
def image_texels(place) -> tuple[np.ndarray, float]:
    """The chain of an image file, (n, 4), and its height over its width."""
    from PIL import Image

    pixels = read_picture(place, str(place), "RGBA")
    height, width = pixels.shape[:2]
    side = min(1 << max(round(math.log2(max(width, height))), 0), SIDE)
    light = np.concatenate([bytes_to_linear(pixels[..., :3]), pixels[..., 3:] / 255.0], axis=2)
    light[..., :3] *= light[..., 3:]
    resized = [
        np.asarray(Image.fromarray(light[..., c].astype(np.float32)).resize((side, side), Image.Resampling.BOX))
        for c in range(4)
    ]
    return mipmap_chain(np.stack(resized, axis=2)), height / width


@cached_by_file(8)
def relief_texels(place, size: float, depth: float) -> tuple[np.ndarray, float]:
    """The chain of the slopes of a relief, (n, 4) as in SurfaceMaps, and the height of its image in metres.

    The image's grey value, 0..1, times `depth` is how far the surface stands out.
    """
    from PIL import Image

    pixels = read_picture(place, str(place), "L")
    height, width = pixels.shape[:2]
    side = min(1 << max(round(math.log2(max(width, height))), 0), SIDE)
    values = np.asarray(
        Image.fromarray(pixels.reshape(height, width).astype(np.float32)).resize((side, side), Image.Resampling.BOX)
    )
    out = values.astype(np.float64) * (depth / 255.0)
    texels = np.zeros((side, side, 4))
    for axis, metres in ((1, size), (0, size * height / width)):
        step = metres / side
        texels[..., 1 - axis] = (np.roll(out, -1, axis) - np.roll(out, 1, axis)) / (2.0 * step)
    texels[..., 2] = texels[..., 0] ** 2 + texels[..., 1] ** 2
    return mipmap_chain(texels), size * height / width


@lru_cache(8)
def puddle_texels(puddles: Puddles) -> np.ndarray:
    """The chain of a repeated pattern of puddles, (n, 4): its fourth number is the wet part, as a mean `puddles.share`.

    The ground's height is a sum of bumps of half the size each time; water stands below the height that makes the share right.
    """
    height, bumps, amplitude = np.zeros((_PUDDLE_SIDE, _PUDDLE_SIDE)), _PUDDLE_PERIOD, 1.0
    while bumps <= _PUDDLE_SIDE // 4:
        key = derive(derive(np.uint64(puddles.seed & _WORD), bumps), np.arange(bumps * bumps))
        height += amplitude * _smooth_bumps(uniform(key, 0).reshape(bumps, bumps) - 0.5)
        bumps, amplitude = 2 * bumps, 0.45 * amplitude
    edge = _EDGE * float(np.ptp(height))
    low, high = float(height.min()) - edge, float(height.max()) + edge
    for _ in range(50):  # the level of the water by bisection
        level = 0.5 * (low + high)
        depth = np.clip((level - height) / edge + 0.5, 0.0, 1.0)
        wet = depth * depth * (3.0 - 2.0 * depth)
        low, high = (level, high) if wet.mean() < puddles.share else (low, level)
    texels = np.zeros((_PUDDLE_SIDE, _PUDDLE_SIDE, 4))
    texels[..., 3] = wet
    return mipmap_chain(texels)


def _smooth_bumps(values: np.ndarray) -> np.ndarray:
    """A repeated smooth surface through a square of values: bicubic (B-spline) at _PUDDLE_SIDE places a side."""
    n = len(values)
    at = (np.arange(_PUDDLE_SIDE) + 0.5) * n / _PUDDLE_SIDE
    first, t = np.floor(at).astype(int), at - np.floor(at)
    weights = ((1 - t) ** 3 / 6, (4 - 6 * t**2 + 3 * t**3) / 6, (1 + 3 * t + 3 * t**2 - 3 * t**3) / 6, t**3 / 6)
    matrix = np.zeros((_PUDDLE_SIDE, n))
    for k, weight in enumerate(weights):
        np.add.at(matrix, (np.arange(_PUDDLE_SIDE), (first + k - 1) % n), weight)
    rows = sum(
        matrix[:, k : k + 1] * values[k] for k in range(n)
    )  # no BLAS: its sums differ from processor to processor
    return sum(rows[:, k : k + 1] * matrix[:, k] for k in range(n))


@ti.func
def _texel(T: ti.template(), first, side, u, v):
    """(4,) of a square of texels at (u, v), in its sides, repeated; bilinear."""
    x, y = u * ti.cast(side, ti.f32) - 0.5, v * ti.cast(side, ti.f32) - 0.5
    i, j = ti.cast(ti.floor(x), ti.i32), ti.cast(ti.floor(y), ti.i32)
    fx, fy = x - ti.cast(i, ti.f32), y - ti.cast(j, ti.f32)
    result = ti.Vector([0.0, 0.0, 0.0, 0.0])
    for k in range(4):
        a, b = (i + k % 2) & (side - 1), (j + k // 2) & (side - 1)  # a power of two
        weight = ti.select(k % 2 == 1, fx, 1.0 - fx) * ti.select(k // 2 == 1, fy, 1.0 - fy)
        for c in ti.static(range(4)):
            result[c] += weight * T[first + b * side + a, c]
    return result


@ti.func
def map_at(T: ti.template(), M: ti.template(), m, column, place, east, south):
    """(4,) the mean of a material's map over a pixel; zeros where it has none.

    column : of the map's numbers in M; place : (2,) m, to the right and down; east, south : (2,) from one pixel to the next
    """
    result = ti.Vector([0.0, 0.0, 0.0, 0.0])
    if M[m, column + PER_WIDTH] > 0.0:
        scale = ti.Vector([M[m, column + PER_WIDTH], M[m, column + PER_HEIGHT]])
        at, along, across = place * scale, east * scale, south * scale
        if along.norm() < across.norm():
            along, across = across, along
        length = ti.max(along.norm(), 1e-9)
        width = abs(along[0] * across[1] - along[1] * across[0]) / length
        samples = ti.min(ti.max(ti.cast(ti.ceil(length / ti.max(width, 1e-9) - 0.5), ti.i32), 1), _MOST_SAMPLES)
        first, side = ti.cast(M[m, column + FIRST], ti.i32), ti.cast(M[m, column + MAP_SIDE], ti.i32)
        texels = ti.max(width, length / ti.cast(samples, ti.f32)) * ti.cast(side, ti.f32)
        while side > 1 and texels >= 2.0:
            first, side, texels = first + side * side, side // 2, 0.5 * texels
        finer = ti.min(ti.max(2.0 - texels, 0.0), 1.0)  # how much of the larger of two versions
        for k in range(samples):
            # whole repeats are taken off first, so that the texel is found exactly far away
            there = at + along * ((ti.cast(k, ti.f32) + 0.5) / ti.cast(samples, ti.f32) - 0.5)
            there -= ti.floor(there)
            sample = _texel(T, first, side, there[0], there[1])
            if side > 1 and finer < 1.0:
                coarse = _texel(T, first + side * side, side // 2, there[0], there[1])
                sample = sample * finer + coarse * (1.0 - finer)
            result += sample
        result /= ti.cast(samples, ti.f32)
    return result
