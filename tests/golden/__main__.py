"""Draws the golden pictures anew, and a sheet of old (left) beside new (right): `make golden`.

python -m tests.golden [NAME...]
"""

import sys
from pathlib import Path

import imageio.v3 as imageio
import numpy as np

from gen_art.backend import runtime
from tests.golden import PICTURES, SIZE, differences, draw, path


def main(names: list[str]) -> None:
    runtime.init()
    rows = []
    for name in names or PICTURES:
        new = draw(name)
        old = imageio.imread(path(name)) if path(name).exists() else np.zeros_like(new)
        mean, block = differences(old, new)
        print(f"{name:24} mean {mean:6.2f}, worst block {block:6.2f} codes")
        if mean or not path(name).exists():
            imageio.imwrite(path(name), new, plugin="pillow", compress_level=9, optimize=True)
        rows.append(np.concatenate([old, np.full((SIZE[1], 4, 3), 128, np.uint8), new], axis=1))
    sheet = Path("out/golden.png")
    sheet.parent.mkdir(exist_ok=True)
    if len(rows) % 2:
        rows.append(np.zeros_like(rows[0]))
    half = len(rows) // 2
    columns = [np.concatenate(part, axis=0) for part in (rows[:half], rows[half:])]
    gap = np.full((len(columns[0]), 12, 3), 128, np.uint8)
    imageio.imwrite(sheet, np.concatenate([columns[0], gap, columns[1]], axis=1).repeat(2, 0).repeat(2, 1))
    print(f"old and new side by side: {sheet}")


if __name__ == "__main__":
    main(sys.argv[1:])
