"""A lamp that shines on smoke through the smoke itself.

The sprites' extinction cross sections (m^2) are laid into a grid of cubic cells aligned with the light; optical depth is their
sum along it over the area of a cell. A particle sees the lamp through exp(-depth), and ambient light through the
mean of the depths before and behind it. NumPy sums in the order of the particles: the same bits on any number of threads.
The grid's cells and corners come in fixed steps, so that it does not crawl with the cloud's outline.
"""

import numpy as np

from gen_art.preset.look import KeyLight
from gen_art.renderer.colour import linear

__all__ = ["incoming_light", "optical_depth"]


def _axes(direction) -> np.ndarray:
    forward = np.asarray(direction, dtype=np.float64)
    forward = forward / np.linalg.norm(forward)
    side = np.cross(forward, (0.0, 1.0, 0.0) if abs(forward[1]) < 0.9 else (1.0, 0.0, 0.0))
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(side, forward), forward])


def _blur(grid: np.ndarray) -> np.ndarray:
    """The 1-2-1 mean along each axis; what would leave stays in the last cell."""
    for axis in range(3):
        padded = np.concatenate([grid.take([0], axis), grid, grid.take([-1], axis)], axis)
        n = grid.shape[axis]
        first, middle, last = (padded.take(range(k, k + n), axis) for k in range(3))
        grid = 0.25 * first + 0.5 * middle + 0.25 * last
    return grid


def optical_depth(positions, sections, direction, resolution: int = 96) -> tuple[np.ndarray, np.ndarray]:
    """Optical depth before and behind each particle along `direction`: two (n,) float32.

    positions (n, 3), sections (n,) extinction cross sections in the square of the same unit
    """
    n = len(positions)
    before = behind = np.zeros(n, np.float32)
    some = sections > 0
    if not some.any():
        return before, behind
    local = (np.asarray(positions, np.float64) @ _axes(direction).T).astype(np.float32)
    low, high = local[some].min(axis=0), local[some].max(axis=0)
    extent = max(float((high - low).max()), 1e-6 * (1.0 + float(np.abs(high).max())))
    cell = 2.0 ** (np.ceil(np.log2(extent / resolution) * 2.0) / 2.0)
    corner = np.floor(low / cell) - 1.0
    shape = (np.floor(high / cell) - corner).astype(int) + 3
    place = np.where(some[:, None], local / np.float32(cell) - corner.astype(np.float32), 1.0).astype(np.float32)
    index = place.astype(np.int32)
    part = place - index
    strides = (shape[1] * shape[2], shape[2], 1)
    flat = index[:, 0] * strides[0] + index[:, 1] * strides[1] + index[:, 2]
    corners = []
    for a in (0, 1):
        for b in (0, 1):
            ab = (part[:, 0] if a else 1 - part[:, 0]) * (part[:, 1] if b else 1 - part[:, 1])
            for c in (0, 1):
                offset = a * strides[0] + b * strides[1] + c
                corners.append((flat + offset, ab * (part[:, 2] if c else 1 - part[:, 2])))
    cells = int(np.prod(shape))
    grid = sum(np.bincount(at, weights=weight * sections, minlength=cells) for at, weight in corners)
    layers = _blur(grid.reshape(shape)) / cell**2
    total = np.cumsum(layers, axis=2)
    middle = (total - 0.5 * layers).astype(np.float32).reshape(-1)
    after = (total[:, :, -1:] - total + 0.5 * layers).astype(np.float32).reshape(-1)
    before, behind = (sum(table[at] * weight for at, weight in corners) for table in (middle, after))
    return before, behind


def incoming_light(light: KeyLight, positions, sections, eye, parallel: bool = False) -> np.ndarray:
    """(n, 3) float32 linear light that each particle scatters towards the camera at `eye` (3,).

    parallel : the camera is orthographic and `eye` the direction it looks in
    """
    before, behind = optical_depth(positions, sections * np.float32(light.depth), light.direction, light.resolution)
    direct = (1.0 - light.scatter) * np.exp(-before) + light.scatter * np.exp(-0.25 * before)
    if light.phase:
        forward = np.asarray(light.direction) / np.linalg.norm(light.direction)
        seen = -np.asarray(eye) if parallel else np.asarray(eye) - positions
        cosine = seen @ forward / np.maximum(np.linalg.norm(seen, axis=-1), 1e-30)
        g = light.phase
        direct = direct * ((1 - g * g) / np.maximum(1 + g * g - 2 * g * cosine, 1e-6) ** 1.5)
    soft = 0.5 * (np.exp(-0.5 * before) + np.exp(-0.5 * behind))
    key, ambient = linear(light.color) * light.intensity, linear(light.ambient) * light.ambient_intensity
    return (direct[:, None] * key + soft[:, None] * ambient).astype(np.float32)
