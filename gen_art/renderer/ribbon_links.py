"""The links of ribbons: the path of each particle between two moments, cut into streaks and pieces in one go for all links.

A link is the cubic Hermite curve through both positions with both velocities. Where its chord is within TOLERANCE pixels of it,
it is one straight streak, else pieces as in curved_streaks.py, which take equal times.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.particles.rows import POSITION, RADIUS, VELOCITY
from gen_art.particles.storage import PADDING
from gen_art.renderer.curved_streaks import (
    BLOCK,
    F2,
    F64,
    I1,
    MOST_PIECES,
    REAL3,
    TOLERANCE,
    hermite,
    on_picture,
    seen,
    seen_place,
)
from gen_art.renderer.look_tables import AXES, PIECES, TIME, WIDTH
from gen_art.renderer.look_tables import POSITION as CAMERA
from gen_art.renderer.look_tables import ROWS as PICTURE_ROWS
from gen_art.renderer.piece_rows import PIECE_HEAD, PIECE_LIGHT, PIECE_OLD, PIECE_ROWS, PIECE_WIDTH
from gen_art.renderer.ribbons import Links

__all__ = ["LinkPieces", "particles_of_link", "pieces_of"]

B2 = ti.types.ndarray(ti.u8, 2)
LIGHT, LINK_WIDTH, TAIL, TAPER = range(4)  # rows of Links.factors
_NOWHERE = np.array([0.0, 0.0, 0.0, 1.0])  # a plane that all is before: zero normal, distance 1


@ti.func
def _at_moment(M: ti.template(), k, i, Q: ti.template()):
    """Place and velocity of particle i at moment k, right of, above and ahead of the camera."""
    return seen_place(M[k, 0, i], M[k, 1, i], M[k, 2, i], Q), seen(M[k, 3, i], M[k, 4, i], M[k, 5, i], Q)


@ti.func
def _from_chord(p, a, d):
    """The distance of a point from the segment from a to d."""
    chord = d - a
    s = ti.min(ti.max((p - a).dot(chord) / ti.max(chord.norm_sqr(), 1e-30), 0.0), 1.0)
    return (p - a - chord * s).norm()


@ti.kernel
def _count(M: REAL3, drawn: B2, times: F64, Q: F64, straight: I1, bent: I1):
    """Whether each link is a straight streak, and else how many pieces it has: none outside the picture.

    M : (moments, 6, n) positions and velocities at `times`, newest first
    drawn : (links, n); straight, bent : (links n,)
    """
    n = drawn.shape[1]
    total = drawn.shape[0] * n
    ti.loop_config(block_dim=1)
    for block in range((total + BLOCK - 1) // BLOCK):
        half_width, half_height = 0.5 * ti.cast(Q[WIDTH], ti.f32), 0.5 * ti.cast(Q[PICTURE_ROWS], ti.f32)
        margin = ti.cast(Q[WIDTH] + Q[PICTURE_ROWS], ti.f32)
        for j in range(block * BLOCK, ti.min((block + 1) * BLOCK, total)):
            k, i = j // n, j % n
            straight[j], bent[j] = 0, 0
            if drawn[k, i] != 0:
                p0, v0 = _at_moment(M, k, i, Q)
                p1, v1 = _at_moment(M, k + 1, i, Q)
                span = ti.cast(times[k] - times[k + 1], ti.f32)
                a, d = on_picture(p0, Q), on_picture(p1, Q)
                b, c = on_picture(p0 - v0 * (span / 3.0), Q), on_picture(p1 + v1 * (span / 3.0), Q)
                # a cubic lies within three quarters of its control points' distances from its chord
                off = 0.75 * ti.max(_from_chord(b, a, d), _from_chord(c, a, d))
                straight[j] = 1
                if off > TOLERANCE:
                    straight[j] = 0
                    bend = ti.max((a - 2.0 * b + c).norm(), (b - 2.0 * c + d).norm())
                    # a piece errs by |x''| d^2 / 8, and x'' is at most 6 bend / span^2
                    wanted = ti.sqrt(6.0 * bend / (8.0 * TOLERANCE))
                    bent[j] = ti.cast(ti.ceil(ti.min(ti.max(wanted, 1.0), ti.cast(MOST_PIECES, ti.f32))), ti.i32)
                    low, high = ti.min(ti.min(a, b), ti.min(c, d)), ti.max(ti.max(a, b), ti.max(c, d))
                    if low[0] > half_width + margin or high[0] < -half_width - margin:
                        bent[j] = 0
                    if low[1] > half_height + margin or high[1] < -half_height - margin:
                        bent[j] = 0


@ti.kernel
def _cut(
    M: REAL3, times: F64, Q: F64, plane: F64, factors: F2, curved: ti.i32, n: ti.i32, counts: I1, starts: I1, owner: I1,
    pieces: F2, ends: F2,
):  # fmt: skip
    """Write the pieces of each link into the columns from starts[j], from its newer end on.

    plane : (4,) normal and distance; of each piece the part is drawn for which normal . place + distance is not negative
    factors : (4, links); curved : 0 if each link is its chord
    owner : the link of each piece
    ends : (2, pieces) brightness and width at the old end of each piece, divided by those at its head
    """
    total = counts.shape[0]
    ti.loop_config(block_dim=1)
    for block in range((total + BLOCK - 1) // BLOCK):
        normal = ti.Vector([ti.cast(plane[c], ti.f32) for c in range(3)])
        distance = ti.cast(plane[3], ti.f32)
        for j in range(block * BLOCK, ti.min((block + 1) * BLOCK, total)):
            if counts[j] > 0:
                k, i = j // n, j % n
                p0, v0 = _at_moment(M, k, i, Q)
                p1, v1 = _at_moment(M, k + 1, i, Q)
                span = ti.cast(times[k] - times[k + 1], ti.f32)
                tail, taper = factors[TAIL, k], factors[TAPER, k]
                place = p0
                for m in range(counts[j]):
                    s0 = ti.cast(m, ti.f32) / ti.cast(counts[j], ti.f32)
                    s1 = ti.cast(m + 1, ti.f32) / ti.cast(counts[j], ti.f32)
                    next = p1
                    if curved == 1:
                        next = hermite(p0, v0, p1, v1, span, span * s1)
                    above, old_above = normal.dot(place) + distance, normal.dot(next) + distance
                    first, last = 0.0, 1.0  # the part of the piece that is before the plane
                    if above < 0.0 or old_above < 0.0:
                        part = ti.min(ti.max(above / (above - old_above), 0.0), 1.0)
                        first, last = ti.select(above < 0.0, part, 0.0), ti.select(old_above < 0.0, part, 1.0)
                        if above < 0.0 and old_above < 0.0:
                            first, last = 0.0, 0.0
                    o = starts[j] + m
                    owner[o] = j
                    head, old = place + (next - place) * first, place + (next - place) * last
                    for c in ti.static(range(3)):
                        pieces[PIECE_HEAD + c, o], pieces[PIECE_OLD + c, o] = head[c], old[c]
                    bright, dark = 1.0 - (1.0 - tail) * s0, 1.0 - (1.0 - tail) * s1
                    wide, narrow = 1.0 - (1.0 - taper) * s0, 1.0 - (1.0 - taper) * s1
                    # its area is that of its width at the head
                    light = 0.5 * (bright + dark) * 0.5 * (wide + narrow) / ti.max(wide, 1e-9)
                    pieces[PIECE_LIGHT, o] = ti.select(last > first, light * factors[LIGHT, k], 0.0)
                    pieces[PIECE_WIDTH, o] = wide * factors[LINK_WIDTH, k]
                    ends[0, o], ends[1, o] = dark / ti.max(bright, 1e-9), narrow / ti.max(wide, 1e-9)
                    place = next


_count_kernel, _cut_kernel = kernel(_count), kernel(_cut)


@dataclass(frozen=True)
class LinkPieces:
    """Pieces of links, or straight links.

    system : what the shading kernel reads of a system, with a column for each
    rows : (8, pieces or more) float32, of piece_rows
    ends : (2, pieces) float32, brightness and width at the old end, divided by those at the head
    numbers : of look_tables.kernel_numbers, for these
    """

    system: SimpleNamespace
    rows: np.ndarray
    ends: np.ndarray
    numbers: np.ndarray


def pieces_of(links: Links, numbers: np.ndarray, plane) -> tuple[LinkPieces | None, LinkPieces | None]:
    """The straight links, and the pieces of those that bend; None where there are none.

    numbers : of look_tables.kernel_numbers, with the factors of the newest end
    plane : (point, normal) before which they are drawn, or None
    """
    count = links.drawn.size
    straight, bent = np.empty(count, np.int32), np.empty(count, np.int32)
    _count_kernel(links.motion, links.drawn.view(np.uint8), links.times, numbers, straight, bent)
    seen_plane = _NOWHERE if plane is None else _seen_plane(numbers, *plane)
    return _made(links, numbers, seen_plane, straight, 0), _made(links, numbers, seen_plane, bent, 1)


def _made(links: Links, numbers: np.ndarray, plane: np.ndarray, counts: np.ndarray, curved: int) -> LinkPieces | None:
    total = int(counts.sum(dtype=np.int64))
    if not total:
        return None
    starts = (np.cumsum(counts, dtype=np.int64) - counts).astype(np.int32)
    owner, rows = np.zeros(total + PADDING, np.int32), np.zeros((PIECE_ROWS, total + PADDING), np.float32)
    ends = np.ones((2, total), np.float32)
    n = links.drawn.shape[1]
    _cut_kernel(links.motion, links.times, numbers, plane, links.factors, curved, n, counts, starts, owner, rows, ends)
    of_pieces = np.array(numbers)
    of_pieces[PIECES] = 1.0
    return LinkPieces(_system(links, owner, total, numbers[TIME]), rows, ends, of_pieces)


def _system(links: Links, owner: np.ndarray, count: int, time: float) -> SimpleNamespace:
    """The particles of the links, each as it was at the link's newer end."""
    system = links.system
    k, i = np.divmod(owner, links.drawn.shape[1])
    floats = system.floats.take(i, axis=1)
    newer, older = links.motion[k, :3, i].T, links.motion[k + 1, :3, i].T
    floats[POSITION], floats[VELOCITY] = newer, (newer - older) / (links.times[k] - links.times[k + 1])
    # they are shaded at one time: births are moved instead
    birth = np.minimum(system.birth[i], links.times[k + 1]) + (time - links.times[k])
    return SimpleNamespace(
        floats=floats, birth=birth, key=system.key.take(i, axis=1), id=system.id[i], source=system.source[i],
        sources=system.sources, count=count, channels=system.channels, entries=system.entries,
        booked=system.booked.take(i, axis=1),
    )  # fmt: skip


def _seen_plane(numbers: np.ndarray, point, normal) -> np.ndarray:
    """(4,) normal and distance of a plane right of, above and ahead of the camera."""
    axes, camera = numbers[AXES : AXES + 9].reshape(3, 3), numbers[CAMERA : CAMERA + 3]
    normal = np.asarray(normal, np.float64)
    return np.array([*(axes @ normal), float(normal @ (camera - np.asarray(point, np.float64)))])


def particles_of_link(links: Links, k: int, time: float) -> SimpleNamespace:
    """The particles of link k as a system of streaks, for a shading at `time` that goes back over the link's time."""
    drawn = np.flatnonzero(links.drawn[k]).astype(np.int32)
    owner = np.zeros(len(drawn) + PADDING, np.int32)
    owner[: len(drawn)] = k * links.drawn.shape[1] + drawn
    system = _system(links, owner, len(drawn), time)
    system.floats[RADIUS] *= links.factors[LINK_WIDTH, k]
    return system
