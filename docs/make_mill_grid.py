"""Write the grid of distances of presets/course/mill.yaml, an overshot wheel, and print the boxes of which it is drawn.

.venv/bin/python docs/make_mill_grid.py

In section across the axle the wheel is a ring, the sole, with boards that lean back from it to the rim. It is the same along the
axle, so two layers are enough; the shrouds at the buckets' ends are no part of it.
"""

from pathlib import Path

import numpy as np

PLACE = Path(__file__).resolve().parent.parent / "presets" / "course" / "mill_wheel.npy"
BUCKETS, RIM, SOLE, LEAN, BOARD, WIDTH = 14, 0.85, 0.6, 21.0, 0.026, 0.96  # m, degrees; LEAN from the sole to the rim
HALF, CELLS = 0.9, 150  # 12 mm


def board(k):
    """The ends of a board, (x, y), m: clockwise, as the wheel turns, its outer end comes after the inner one."""
    a, b = np.radians(360 * k / BUCKETS + np.array([0, -LEAN]))
    return SOLE * np.array([np.sin(a), np.cos(a)]), RIM * np.array([np.sin(b), np.cos(b)])


def distances():
    x = np.linspace(-HALF, HALF, CELLS + 1)
    p = np.stack(np.meshgrid(x, x, indexing="ij"), -1)
    d = np.abs(np.hypot(p[..., 0], p[..., 1]) - SOLE) - 0.015
    for k in range(BUCKETS):
        a, b = board(k)
        along = np.clip((p - a) @ (b - a) / np.dot(b - a, b - a), 0, 1)
        d = np.minimum(d, np.linalg.norm(p - a - along[..., None] * (b - a), axis=-1) - BOARD / 2)
    return np.repeat(d[..., None], 2, axis=2).astype(np.float16)


def boxes():
    """Lines of YAML: boards, planks of the sole, shrouds, spokes, axle."""

    def line(size, at, turn):
        numbers = [", ".join(f"{round(v, 3) + 0.0:g}" for v in row) for row in (size, at)]
        return f"{{box: [{numbers[0]}], at: [{numbers[1]}], turn: [0, 0, {round(turn, 1) + 0.0:g}]}}"

    for k in range(BUCKETS):
        a, b = board(k)
        across = b - a
        yield line((np.hypot(*across), BOARD, WIDTH), (*(a + b) / 2, 0), np.degrees(np.arctan2(across[1], across[0])))
    half = np.pi / (2 * BUCKETS)
    for middle, deep, wide, places in ((SOLE, 0.03, WIDTH, (0,)), (0.731, 0.27, 0.04, (-0.5, 0.5))):
        for z in places:
            for k in range(2 * BUCKETS):
                a = (2 * k + 1) * half
                length = 2 * (middle + deep / 2) * np.tan(half)
                yield line((length, deep, wide), (middle * np.sin(a), middle * np.cos(a), z), -np.degrees(a))
    for z in (-0.5, 0.5):
        for k in range(4):
            yield line((1.22, 0.09, 0.07), (0, 0, z), 45 * k + 10)


if __name__ == "__main__":
    np.save(PLACE, distances())
    print(PLACE, PLACE.stat().st_size, "bytes")
    rows = list(boxes())
    for k in range(0, len(rows), 4):
        print("            " + ", ".join(rows[k : k + 4]) + ",")
