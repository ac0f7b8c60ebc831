"""The rows of cloth from shaded particles: corners with smooth normals, triangles, and where they are listed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gen_art.errors import UsageError
from gen_art.maths.array_functions import median
from gen_art.preset.look import Look
from gen_art.renderer.colour import linear
from gen_art.renderer.projected_particles import LIT_ALBEDO, LIT_EXTINCTION
from gen_art.renderer.sprite import ALPHA, BLUE, RED
from gen_art.renderer.surfaces.cell_lists import cell_lists

__all__ = ["CORNER_FLOATS", "SheetSystem", "Sheets", "face_rectangles", "places_on_sheet", "sheet_of"]

# a corner's row: its place along the camera's axes, along the lamp's (two across, then towards it) and along the world's, each
# relative to the camera; normal, albedo, emission, place on the sheet at rest
VIEW, LAMP, PLACE, NORMAL, ALBEDO, EMITTED, ON_SHEET = 0, 3, 6, 9, 12, 15, 18
CORNER_FLOATS = 20
# a sheet's row: its material, translucency, whether its back has an albedo of its own, that albedo
SHEET_MATERIAL, TRANSLUCENCY, HAS_BACK, BACK, SHEET_FLOATS = 0, 1, 2, 3, 6
# numbers of the grid across the lamp's direction: least place, side of a cell, cells along both, place nearest to the lamp
GRID_CORNER, GRID_CELL, GRID_SHAPE, GRID_TOP, GRID_NUMBERS = 0, 2, 3, 5, 6
_CELLS = 1024  # most cells along a side of the grid
_EXACT = 2.0**24  # pixels beyond which a rectangle of the picture is cut
_SLACK = 0.05  # pixels by which a rectangle is larger than its triangle: float32 may find a ray just inside


def sheet_of(name: str, interactions, state) -> np.ndarray:
    """(k, 3) slots of the corners of what `draw: cloth` shows of a system. Raises UsageError if it has no cloth."""
    for interaction in interactions:
        found = interaction.sheet(state)
        if found is not None:
            return found
    raise UsageError(
        f"systems.{name}.look: draw: cloth shows the `cloth:` of an emitter that springs join (interactions: {{springs: ...}}), "
        f"and '{name}' has none"
    )


def places_on_sheet(name: str, emissions, state) -> np.ndarray:
    """(n, 2) m, to the right and down, where on the cloth of its emitter at rest each particle of a system lies.

    Raises UsageError if none of the emissions lays a cloth.
    """
    ids, source = state.id[: state.count].astype(np.int64), state.source[: state.count]
    places, known, first = np.zeros((state.count, 2)), False, 0
    for emission in emissions:
        for k, kind in enumerate(emission.kinds):
            net = getattr(kind.scripted, "net", None)
            if net is not None:
                mine = source == emission.first_source + k
                if len(net.place) and mine.any():
                    places[mine] = net.place[ids[mine] - first]
                    known = True
                first += len(net.position)
    if not known and state.count:
        raise UsageError(
            f"systems.{name}.look.finish.image: an image lies on the `cloth:` of an emitter, and '{name}' has none"
        )
    return places


@dataclass(frozen=True)
class SheetSystem:
    """The cloth of one system, as its particles are shaded.

    look : its finish, back and translucency
    channels : (11, n) of ProjectedParticles
    columns : (n, 8) LIT_... of projected_particles.py
    positions : (3, n) m, of the particles
    faces : (k, 3), particles at the corners of the triangles
    velocities : (3, n) m/s
    places : (n, 2) m, to the right and down on the sheet at rest, or None if its look has no image
    """

    look: Look
    channels: np.ndarray
    columns: np.ndarray
    positions: np.ndarray
    faces: np.ndarray
    velocities: np.ndarray
    places: np.ndarray | None = None

    @cached_property
    def seen(self) -> np.ndarray:
        """(m, 3), the triangles all of whose particles exist."""
        return self.faces[(self.columns[:, LIT_EXTINCTION] > 0.0)[self.faces].all(axis=1)]

    @cached_property
    def used(self) -> np.ndarray:
        """(k,), the particles at their corners."""
        return np.unique(self.seen)


@dataclass(frozen=True, eq=False)
class Sheets:
    """The triangles of all cloth.

    corners : (n, CORNER_FLOATS) float32
    faces : (m, 4) int32, three corners and the row of the sheet
    looks : (sheets, SHEET_FLOATS) float32
    grid : (GRID_NUMBERS,) float32, of the cells across the lamp's direction
    starts, listed : (cells + 1,) and (...) int32: the triangles of each cell
    centers, areas : (m, 3) m, in the world, and (m,) m^2
    """

    corners: np.ndarray
    faces: np.ndarray
    looks: np.ndarray
    grid: np.ndarray
    starts: np.ndarray
    listed: np.ndarray
    centers: np.ndarray
    areas: np.ndarray

    @classmethod
    def of(cls, systems: list[SheetSystem], first_material: int, view, axes) -> "Sheets":
        """The rows of all sheets, those behind the camera too, which cast shadows.

        first_material : of the first system; the next has the next one
        axes : (3, 3), rows: two directions across the lamp's rays, then the direction in which they travel
        """
        corners, faces, looks = [np.zeros((0, CORNER_FLOATS))], [np.zeros((0, 4), np.int64)], []
        first = 0
        for k, system in enumerate(systems):
            used = system.used
            triangles = np.searchsorted(used, system.seen).reshape(-1, 3)
            place = system.positions[:, used].T.astype(np.float64) - view.position
            rows = np.zeros((len(used), CORNER_FLOATS))
            rows[:, VIEW : VIEW + 3] = place @ view.axes.T
            rows[:, LAMP : LAMP + 3] = place @ (axes * [[1.0], [1.0], [-1.0]]).T
            rows[:, PLACE : PLACE + 3] = place
            rows[:, NORMAL : NORMAL + 3] = smooth_normals(place, triangles)
            area = np.maximum(system.channels[ALPHA, used], 1e-30)[:, None]
            rows[:, ALBEDO : ALBEDO + 3] = system.columns[used, LIT_ALBEDO] / area
            rows[:, EMITTED : EMITTED + 3] = system.channels[RED : BLUE + 1, used].T / area
            if system.places is not None:
                rows[:, ON_SHEET : ON_SHEET + 2] = system.places[used]
            corners.append(rows)
            faces.append(np.column_stack([triangles + first, np.full(len(triangles), k)]))
            looks.append(_look_row(system.look, first_material + k))
            first += len(used)
        table, listed = np.concatenate(corners), np.concatenate(faces)
        place = table[:, PLACE : PLACE + 3][listed[:, :3]]
        grid, starts, in_cells = _lamp_grid(table[:, LAMP : LAMP + 3][listed[:, :3]])
        areas = 0.5 * np.sqrt((_normals(place) ** 2).sum(axis=1))
        return cls(
            table.astype(np.float32), np.ascontiguousarray(listed, np.int32),
            np.array(looks, np.float32).reshape(-1, SHEET_FLOATS), grid, starts, in_cells,
            place.mean(axis=1) + view.position, areas,
        )  # fmt: skip

    @cached_property
    def any(self) -> bool:
        """Whether there is any triangle."""
        return len(self.faces) > 0


def _look_row(look: Look, material: int) -> np.ndarray:
    row = np.zeros(SHEET_FLOATS)
    row[SHEET_MATERIAL], row[TRANSLUCENCY] = material, look.translucency * (1.0 - look.finish.metal)
    if look.back is not None:
        row[HAS_BACK], row[BACK : BACK + 3] = 1.0, linear(look.back)
    return row


def _normals(triangles: np.ndarray) -> np.ndarray:
    """(m, 3) normals of (m, 3 corners, 3), twice as long as the areas are large."""
    a, b = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    return np.stack([a[:, k - 2] * b[:, k - 1] - a[:, k - 1] * b[:, k - 2] for k in range(3)], axis=1)


def smooth_normals(place: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(n, 3) unit normals of corners: the mean of the triangles around each, by their areas; 0 where they cancel.

    place : (n, 3) of the corners
    triangles : (m, 3) corners
    """
    normals = _normals(place[triangles])
    total = np.stack([np.bincount(triangles.ravel(), np.repeat(n, 3), len(place)) for n in normals.T], axis=1)
    length = np.sqrt((total * total).sum(axis=1))[:, None]
    return np.where(length > 0.0, total / np.where(length > 0.0, length, 1.0), 0.0)


def _lamp_grid(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(numbers, starts, listed) of a grid across the lamp's direction.

    triangles : (m, 3 corners, 3) in the lamp's frame
    """
    numbers = np.zeros(GRID_NUMBERS)
    if not len(triangles):
        return numbers.astype(np.float32), np.zeros(2, np.int32), np.zeros(1, np.int32)
    low, high = triangles[..., :2].min(axis=1), triangles[..., :2].max(axis=1)
    corner, extent = low.min(axis=0), float((high.max(axis=0) - low.min(axis=0)).max())
    cell = max(median((high - low).max(axis=1)), extent / _CELLS, 1e-9)
    numbers[GRID_CORNER : GRID_CORNER + 2], numbers[GRID_CELL] = corner, cell
    numbers[GRID_TOP] = triangles[..., 2].max()
    numbers = numbers.astype(np.float32).astype(np.float64)  # the cells are found with the kernel's numbers
    corner, cell = numbers[GRID_CORNER : GRID_CORNER + 2], numbers[GRID_CELL]
    shape = np.maximum(np.ceil((high.max(axis=0) - corner) / cell).astype(np.int64), 1)
    numbers[GRID_SHAPE : GRID_SHAPE + 2] = shape
    slack = 1e-3 * cell  # the kernel finds the cells of a point in float32
    first = np.clip(((low - slack - corner) / cell).astype(np.int64), 0, shape - 1)
    last = np.clip(((high + slack - corner) / cell).astype(np.int64), 0, shape - 1)
    return numbers.astype(np.float32), *cell_lists(first, last, (int(shape[0]), int(shape[1])))


def face_rectangles(sheets: Sheets, view, size) -> np.ndarray:
    """(m, 4) int32: first and last column and row of the pixels that triangles may cover, clipped to the picture."""
    if not sheets.any:
        return np.zeros((0, 4), np.int32)
    local = sheets.corners[:, VIEW : VIEW + 3].astype(np.float64)
    scale, before = np.full(len(local), view.scale(size[1])), np.ones(len(local), bool)
    if view.height is None:
        before = local[:, 2] > 1e-6 * view.distance
        scale /= np.where(before, local[:, 2], 1.0)
    pixels = np.stack([0.5 * size[0] + local[:, 0] * scale, 0.5 * size[1] - local[:, 1] * scale], axis=1)
    of_faces, ahead = pixels[sheets.faces[:, :3]], before[sheets.faces[:, :3]]
    low, high = of_faces.min(axis=1) - _SLACK, of_faces.max(axis=1) + _SLACK
    through = ahead.any(axis=1) & ~ahead.all(axis=1)  # these reach from before the camera to behind it
    low[through], high[through] = -_EXACT, _EXACT
    edges = np.floor(np.clip(np.stack([low, high], axis=2), -_EXACT, _EXACT)).astype(np.int64)
    limits = np.array(size)[None, :] - 1
    outside = ((edges[:, :, 1] < 0) | (edges[:, :, 0] > limits)).any(axis=1) | ~ahead.any(axis=1)
    edges = np.clip(edges, 0, limits[:, :, None])
    edges[outside] = (0, -1)
    return np.ascontiguousarray(edges.reshape(-1, 4), np.int32)
