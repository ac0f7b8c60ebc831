"""The rows of solids from shaded particles: balls, and the shapes of bodies and threads."""

from dataclasses import dataclass

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import Shapes
from gen_art.preset.surface import Finish
from gen_art.renderer.projected_particles import LIT_ALBEDO, LIT_EXTINCTION, LIT_POSITION, LIT_RADIUS
from gen_art.renderer.sprite import ALPHA, BLUE, RED
from gen_art.renderer.surfaces.solids import (
    ALBEDO,
    AXES,
    BOUND,
    CENTER,
    EMITTED,
    HALF,
    IMAGE_PLACE,
    MATERIAL,
    RADIUS,
    SOLID_FLOATS,
)

__all__ = ["SolidSystem", "mean_areas", "pieces", "pixel_rectangles", "shapes_of", "solid_rows"]

_EVEN = (0.7548776662466927, 0.5698402909980532)  # whose multiples lie evenly in a square (Roberts, 2018)
_EXACT = 2.0**24  # pixels beyond which a rectangle of the picture is cut
_WHERE = {"body": "rigid bodies (interactions: {rigid: {}})", "thread": "springs (interactions: {springs: ...})"}


@dataclass(frozen=True)
class SolidSystem:
    """The solids of one system, as its particles are shaded.

    finish : how they reflect
    channels : (11, n) of ProjectedParticles
    columns : (n, 8) LIT_... of projected_particles.py
    shapes : of bodies or threads; balls if None
    glows : whether it lights the others
    edge : m, radius to which the edges of boxes are rounded
    velocities : (3, n) m/s, of the particles
    """

    finish: Finish
    channels: np.ndarray
    columns: np.ndarray
    velocities: np.ndarray
    shapes: Shapes | None = None
    glows: bool = False
    edge: float = 0.0


def shapes_of(name: str, draw: str, interactions, state) -> Shapes:
    """What `draw: body` or `draw: thread` shows of a system. Raises UsageError if it has no such thing."""
    wanted = "rigid" if draw == "body" else "springs"
    for interaction in interactions:
        if interaction.name == wanted:
            found = interaction.shapes(state)
            if found is not None:
                return found
    raise UsageError(f"systems.{name}.look: draw: {draw} shows {_WHERE[draw]}, and '{name}' has none")


def solid_rows(systems: list[SolidSystem], first_material: int, view) -> np.ndarray:
    """(n, SOLID_FLOATS) rows of all solids, those behind the camera too, which cast shadows.

    first_material : of the first system; the next has the next one
    """
    found = [np.zeros((0, SOLID_FLOATS), np.float32)]
    for k, system in enumerate(systems):
        shapes = system.shapes
        particle = np.arange(system.channels.shape[1]) if shapes is None else shapes.particle
        here = np.flatnonzero(system.columns[particle, LIT_EXTINCTION] > 0.0)
        particle = particle[here]
        area, columns = np.maximum(system.channels[ALPHA, particle], 1e-30), system.columns[particle]
        rows = np.zeros((len(here), SOLID_FLOATS), np.float32)
        rows[:, RADIUS] = columns[:, LIT_RADIUS]
        if shapes is None:
            rows[:, CENTER : CENTER + 3] = columns[:, LIT_POSITION].astype(np.float64) - view.position
            rows[:, AXES : AXES + 9] = np.eye(3, dtype=np.float32).ravel()  # of its image: a ball does not turn
        else:
            rows[:, CENTER : CENTER + 3] = shapes.center[here] - view.position
            rows[:, HALF : HALF + 3], rows[:, AXES : AXES + 9] = shapes.half[here], shapes.axes[here].reshape(-1, 9)
            own = np.isfinite(shapes.radius[here])
            rows[own, RADIUS] = shapes.radius[here][own]
            if system.edge > 0.0:
                rounded = np.where(
                    own & (rows[:, RADIUS] == 0.0), np.minimum(system.edge, shapes.half[here].min(axis=1)), 0.0
                )
                rows[:, HALF : HALF + 3] -= rounded[:, None]
                rows[:, RADIUS] += rounded
        half = rows[:, HALF : HALF + 3]
        rows[:, BOUND] = np.sqrt((half * half).sum(axis=1)) + rows[:, RADIUS]
        rows[:, ALBEDO : ALBEDO + 3] = columns[:, LIT_ALBEDO] / area[:, None]
        rows[:, EMITTED : EMITTED + 3] = (system.channels[RED : BLUE + 1, particle] / area).T
        rows[:, MATERIAL] = first_material + k
        rows[:, IMAGE_PLACE : IMAGE_PLACE + 2] = 0.5
        if system.finish.image is not None and system.finish.image.shifted:
            rows[:, IMAGE_PLACE : IMAGE_PLACE + 2] += np.mod(np.outer(particle + 1.0, _EVEN), 1.0)
        found.append(rows)
    return np.concatenate(found)


def mean_areas(rows: np.ndarray) -> np.ndarray:
    """(n,) the mean area of the shadow of solids over all directions, a quarter of their surface (Cauchy).

    2 (ab + bc + ca) + pi r (a + b + c) + pi r^2, for a box of half extents a, b, c rounded by r
    """
    a, b, c = rows[:, HALF : HALF + 3].astype(np.float64).T
    r = rows[:, RADIUS].astype(np.float64)
    return 2.0 * (a * b + b * c + c * a) + np.pi * r * (a + b + c) + np.pi * r * r


def pieces(rows: np.ndarray, side: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(rows, centres, mean areas, radii) of solids, the long ones cut into pieces along their axes, at most `side` long.

    The first are the indices of the solids; the pieces of one have its mean area together. Centres are relative to the camera.
    """
    half = rows[:, HALF : HALF + 3].astype(np.float64)
    outer = half + rows[:, RADIUS, None]
    cut = (rows[:, BOUND, None] > 4.0 * side) & (half > 0.0)  # a ball is cut nowhere, a capsule along its axis
    numbers = np.ceil(np.where(cut, 2.0 * outer / side, 1.0)).astype(np.int64)
    counts = numbers.prod(axis=1)
    row = np.repeat(np.arange(len(rows)), counts)
    within = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    number = numbers[row]
    place = np.stack(
        [within // (number[:, 1] * number[:, 2]), within // number[:, 2] % number[:, 1], within % number[:, 2]], 1
    )
    along = outer[row] * ((2.0 * place + 1.0) / number - 1.0)
    axes = rows[row, AXES : AXES + 9].astype(np.float64).reshape(-1, 3, 3)
    centers = rows[row, CENTER : CENTER + 3] + (along[:, :, None] * axes).sum(axis=1)
    whole = counts[row] == 1
    radii = np.where(whole, rows[row, BOUND], np.sqrt(((outer[row] / number) ** 2).sum(axis=1)))
    return row, centers, mean_areas(rows)[row] / counts[row], radii


def pixel_rectangles(rows: np.ndarray, view, size) -> np.ndarray:
    """(n, 4) int32: first and last column and row of the pixels that solids may cover, clipped to the picture.

    The outline of the ball around a solid lies between the two tangents through the camera, along each axis.
    """
    if not len(rows):
        return np.zeros((0, 4), np.int32)
    local = rows[:, :3].astype(np.float64) @ view.axes.T
    radius, scale = rows[:, BOUND].astype(np.float64), view.scale(size[1])
    edges = np.zeros((len(rows), 2, 2))
    for axis, sign in ((0, 1.0), (1, -1.0)):
        x, z = sign * local[:, axis], local[:, 2]
        if view.height is not None:
            low, high = x - radius, x + radius
        else:
            square = z * z - radius * radius
            reach = radius * np.sqrt(np.maximum(x * x + square, 0.0))
            before = (square > 0.0) & (z > 0.0)
            safe = np.where(before, square, 1.0)
            low = np.where(before, (x * z - reach) / safe, -_EXACT)
            high = np.where(before, (x * z + reach) / safe, _EXACT)
        edges[:, axis, 0], edges[:, axis, 1] = low * scale + 0.5 * size[axis], high * scale + 0.5 * size[axis]
    limits = np.array(size)[None, :, None] - 1
    pixels = np.floor(np.clip(edges, -_EXACT, _EXACT)).astype(np.int64)
    outside = ((pixels[:, :, 1] < 0) | (pixels[:, :, 0] > limits[:, :, 0])).any(axis=1)
    if view.height is None:
        outside |= local[:, 2] + radius <= 0.0
    pixels = np.clip(pixels, 0, limits)
    pixels[outside] = (0, -1)
    return np.ascontiguousarray(pixels.reshape(-1, 4), np.int32)
