"""Ropes laid of strands: each rod of a thread becomes several thinner ones, which wind round its axis.

The strands touch each other and the rope's radius r: of n strands each has the radius r_s = r sin(pi / n) / (1 + sin(pi / n)),
and its middle stands r - r_s from the axis. They go once round along LAY diameters of the rope, in the right hand's sense. The
direction from which the angle is measured is carried along the thread without turning about it.
"""

import math
from dataclasses import replace

import numpy as np

from gen_art.interactions.base import Shapes
from gen_art.interactions.links import capsules_along

__all__ = ["lay_strands"]

LAY = 3.5  # diameters of a rope in which a strand goes once round it


def lay_strands(rods: Shapes, radius: np.ndarray, number: int) -> Shapes:
    """The rods of `draw: thread` as ropes of `number` strands.

    rods : capsules; where one begins at the end of the one before it, both are of the same rope
    radius : (n,) m, of each rod
    """
    if not len(rods.center):
        return rods
    half = rods.half[:, 1:2] * rods.axes[:, 1]
    starts, ends = rods.center - half, rods.center + half
    length = 2.0 * rods.half[:, 1]
    same = np.zeros(len(length), bool)  # whether a rod goes on where the one before it ends
    gap = np.sqrt(((starts[1:] - ends[:-1]) ** 2).sum(axis=1))
    same[1:] = gap <= 1e-6 * np.maximum(length[1:], length[:-1])
    sine = math.sin(math.pi / number)
    share = sine / (1.0 + sine)
    found = []
    for rope in np.split(np.arange(len(length)), np.flatnonzero(~same)[1:]):
        nodes = np.concatenate([starts[rope[:1]], ends[rope]])
        across, beside = _frames(nodes, rods.axes[rope[0], 0])
        r = float(radius[rope].mean())
        turns = (
            np.arange(len(nodes)) * float(length[rope].mean()) / (2.0 * LAY * r) if r > 0.0 else np.zeros(len(nodes))
        )
        for k in range(number):
            angle = 2.0 * np.pi * (turns + k / number)[:, None]
            places = nodes + (1.0 - share) * r * (np.cos(angle) * across + np.sin(angle) * beside)
            pairs = np.stack([np.arange(len(rope)), np.arange(1, len(rope) + 1)], axis=1)
            strand = capsules_along(places.T, np.zeros((3, len(nodes))), pairs)
            found.append(
                replace(
                    strand,
                    particle=rods.particle[rope],
                    radius=share * radius[rope],
                    velocity=rods.velocity[rope],
                    spin=rods.spin[rope],
                )
            )
    return Shapes(*(np.concatenate([getattr(one, name) for one in found]) for name in Shapes.__dataclass_fields__))


def _frames(nodes: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) each: two unit vectors across a thread at each of its nodes, right-handed with its direction.

    first : the first of them, before it is made perpendicular
    """
    steps = np.diff(nodes, axis=0)
    steps /= np.maximum(np.sqrt((steps * steps).sum(axis=1)), 1e-300)[:, None]
    along = np.concatenate([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    along /= np.maximum(np.sqrt((along * along).sum(axis=1)), 1e-300)[:, None]
    across = np.empty_like(nodes)
    carried = first
    for k, t in enumerate(along):
        carried = carried - t * float(carried @ t)
        carried = carried / max(math.sqrt(float(carried @ carried)), 1e-300)
        across[k] = carried
    return across, np.cross(along, across)
