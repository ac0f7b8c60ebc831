"""Streaks along curved paths: where a path bends, it is cut into straight pieces, each of which is drawn as a streak.

The pieces take equal times, so that light is even in time, and their chords stay within TOLERANCE pixels of the path: a piece
that takes the time d errs by |x''| d^2 / 8, with x'' the largest acceleration in the picture. Their shares of the streak's light
add up to 1. A streak that a straight one along its velocity matches within TOLERANCE at each moment is left as it is; one of a
single piece is straight too, but along its chord.

The one-letter names in kernels are in docs/glossary.md.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from gen_art.backend.runtime import kernel, ti
from gen_art.particles.rows import LIFETIME, PX, PY, PZ, VX, VY, VZ
from gen_art.particles.storage import PADDING
from gen_art.renderer.look_tables import AXES, NEAR, ORTHOGRAPHIC, PIECES, POSITION, ROWS, SCALE, SHUTTER, TIME, WIDTH
from gen_art.renderer.path_history import PastMotion
from gen_art.renderer.piece_rows import PIECE_HEAD, PIECE_LIGHT, PIECE_OLD, PIECE_ROWS, PIECE_WIDTH
from gen_art.renderer.sprite import PIECE, STREAK

__all__ = ["BLOCK", "MOST_PIECES", "Pieces", "TOLERANCE", "cut", "hermite", "on_picture", "seen", "seen_place"]

TOLERANCE = 0.25  # pixels
MOST_PIECES = 64  # of a streak
BLOCK = 2048  # particles per iteration of the parallel loop

I1, F1, F2, F64, B2 = (
    ti.types.ndarray(d, n) for d, n in ((ti.i32, 1), (ti.f32, 1), (ti.f32, 2), (ti.f64, 1), (ti.u8, 2))
)
REAL2, REAL3 = ti.types.ndarray(ndim=2), ti.types.ndarray(ndim=3)


@ti.func
def seen_place(x, y, z, Q: ti.template()):
    """A place right of, above and ahead of the camera."""
    p = ti.Vector([ti.cast(ti.cast(x, ti.f64) - Q[POSITION], ti.f32), ti.cast(ti.cast(y, ti.f64) - Q[POSITION + 1], ti.f32),
                   ti.cast(ti.cast(z, ti.f64) - Q[POSITION + 2], ti.f32)])  # fmt: skip
    return seen(p[0], p[1], p[2], Q)


@ti.func
def seen(x, y, z, Q: ti.template()):
    """A vector's parts right, up and ahead."""
    u, v, w = ti.cast(x, ti.f32), ti.cast(y, ti.f32), ti.cast(z, ti.f32)
    a = ti.Vector([ti.cast(Q[AXES + k], ti.f32) for k in range(9)])
    return ti.Vector([a[0] * u + a[1] * v + a[2] * w, a[3] * u + a[4] * v + a[5] * w, a[6] * u + a[7] * v + a[8] * w])


@ti.func
def on_picture(p, Q: ti.template()):
    """Pixels from the middle of the picture; what is nearer than the near plane is seen as if it were there."""
    scale = ti.cast(Q[SCALE], ti.f32)
    if Q[ORTHOGRAPHIC] < 0.5:
        scale /= ti.max(p[2], ti.max(ti.cast(Q[NEAR], ti.f32), 1e-30))
    return ti.Vector([p[0] * scale, -p[1] * scale])


@ti.func
def hermite(p0, v0, p1, v1, span, back):
    """The place `back` seconds before p0, on the path from p1, v1 to p0, v0, which takes `span` seconds."""
    s = back / span
    r = 1.0 - s
    return (
        p0 * (r * r * (1.0 + 2.0 * s))
        - v0 * (span * s * r * r)
        + p1 * (s * s * (3.0 - 2.0 * s))
        + v1 * (span * s * s * r)
    )


@ti.func
def _older(k, i, p0, v0, start, lapse, changed, birth, H: ti.template(), known: ti.template(), times: ti.template(),
           Q: ti.template()):  # fmt: skip
    """The path's next older moment: its place, its velocity and how long ago it was.

    Before the first moment that is known of a particle, its acceleration `changed` goes on.
    """
    end = lapse
    last = ti.min(k, times.shape[0] - 1)
    remembered = k == last and known[last, i] != 0 and times[last] >= birth
    if remembered:
        end = ti.cast(Q[TIME] - times[last], ti.f32)
    v1 = v0 - changed * (end - start)
    p1 = p0 - (v0 + v1) * (0.5 * (end - start))
    if remembered:
        p1 = seen_place(H[last, 0, i], H[last, 1, i], H[last, 2, i], Q)
        v1 = seen(H[last, 3, i], H[last, 4, i], H[last, 5, i], Q)
    return p1, v1, end


@ti.kernel
def _count(
    S: REAL2, birth: F64, lifetime: REAL2, H: REAL3, known: B2, times: F64, n: ti.i32, Q: F64, counts: I1
):  # fmt: skip
    """The number of pieces of each streak; 0 where a straight one will do, -1 where none of the path is in the picture.

    H : (moments, 6, n) positions and velocities at `times`, newest first
    """
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        now = Q[TIME]
        half_width, half_height = 0.5 * ti.cast(Q[WIDTH], ti.f32), 0.5 * ti.cast(Q[ROWS], ti.f32)
        for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, n)):
            age = now - birth[i]
            lapse = ti.cast(ti.min(Q[SHUTTER], age), ti.f32)
            counts[i] = 0
            if age > 0.0 and age < ti.cast(lifetime[0, i], ti.f64) and lapse > 0.0:
                p0, v0 = seen_place(S[PX, i], S[PY, i], S[PZ, i], Q), seen(S[VX, i], S[VY, i], S[VZ, i], Q)
                head, head_velocity, changed = p0, v0, v0 * 0.0
                low = on_picture(p0, Q)
                high = low
                strongest, off, start = 0.0, 0.0, ti.cast(0.0, ti.f32)
                k = 0
                while start < lapse:
                    p1, v1, end = _older(k, i, p0, v0, start, lapse, changed, birth[i], H, known, times, Q)
                    span = ti.max(end - start, 1e-30)
                    a, d = on_picture(p0, Q), on_picture(p1, Q)
                    b, c = on_picture(p0 - v0 * (span / 3.0), Q), on_picture(p1 + v1 * (span / 3.0), Q)
                    bend = ti.max((a - 2.0 * b + c).norm(), (b - 2.0 * c + d).norm())
                    strongest = ti.max(strongest, 6.0 * bend / (span * span))
                    low, high = ti.min(low, ti.min(b, ti.min(c, d))), ti.max(high, ti.max(b, ti.max(c, d)))
                    back = ti.min(end, lapse)
                    place = on_picture(hermite(p0, v0, p1, v1, span, back - start), Q)
                    off = ti.max(off, (place - on_picture(head - head_velocity * back, Q)).norm())
                    changed = (v0 - v1) / span
                    p0, v0, start = p1, v1, end
                    k += 1
                pieces = 1
                # a piece errs by |x''| d^2 / 8; numbers that are not finite fail both comparisons
                wanted = lapse * ti.sqrt(strongest / (8.0 * TOLERANCE))
                if wanted > 1.0:
                    pieces = ti.cast(ti.ceil(ti.min(wanted, ti.cast(MOST_PIECES, ti.f32))), ti.i32)
                bent = off > TOLERANCE
                if bent:
                    counts[i] = pieces
                    margin = ti.cast(Q[WIDTH] + Q[ROWS], ti.f32)
                    if low[0] > half_width + margin or high[0] < -half_width - margin:
                        counts[i] = -1
                    if low[1] > half_height + margin or high[1] < -half_height - margin:
                        counts[i] = -1


@ti.func
def _share(s, tail):
    """The part of a streak's light that lies within the part s of its length, from its head."""
    return s * (1.0 - 0.5 * (1.0 - tail) * s) / (0.5 * (1.0 + tail))


@ti.kernel
def _cut(
    S: REAL2, birth: F64, H: REAL3, known: B2, times: F64, n: ti.i32, Q: F64, counts: I1, starts: I1,
    tail: ti.f32, taper: ti.f32, owner: I1, pieces: F2, ends: F2,
):  # fmt: skip
    """Write the pieces of each streak, from the head on, into the columns from starts[i].

    owner : the particle of each piece
    ends : (2, pieces) brightness and width at the old end of each piece, divided by those at its head
    """
    ti.loop_config(block_dim=1)
    for block in range((n + BLOCK - 1) // BLOCK):
        now = Q[TIME]
        for i in range(block * BLOCK, ti.min((block + 1) * BLOCK, n)):
            if counts[i] > 0:
                lapse = ti.cast(ti.min(Q[SHUTTER], now - birth[i]), ti.f32)
                p0, v0 = seen_place(S[PX, i], S[PY, i], S[PZ, i], Q), seen(S[VX, i], S[VY, i], S[VZ, i], Q)
                p1, v1, changed, place = p0, v0, v0 * 0.0, p0
                start, end, k = ti.cast(0.0, ti.f32), ti.cast(0.0, ti.f32), 0
                for m in range(counts[i]):
                    s0 = ti.cast(m, ti.f32) / ti.cast(counts[i], ti.f32)
                    s1 = ti.cast(m + 1, ti.f32) / ti.cast(counts[i], ti.f32)
                    back = lapse * s1
                    while end < back:
                        p0, v0, start = p1, v1, end
                        p1, v1, end = _older(k, i, p0, v0, start, lapse, changed, birth[i], H, known, times, Q)
                        changed = (v0 - v1) / ti.max(end - start, 1e-30)
                        k += 1
                    next = hermite(p0, v0, p1, v1, ti.max(end - start, 1e-30), back - start)
                    o = starts[i] + m
                    owner[o] = i
                    for c in ti.static(range(3)):
                        pieces[PIECE_HEAD + c, o], pieces[PIECE_OLD + c, o] = place[c], next[c]
                    bright, dark = 1.0 - (1.0 - tail) * s0, 1.0 - (1.0 - tail) * s1
                    wide, narrow = 1.0 - (1.0 - taper) * s0, 1.0 - (1.0 - taper) * s1
                    pieces[PIECE_LIGHT, o] = _share(s1, tail) - _share(s0, tail)
                    pieces[PIECE_WIDTH, o] = wide
                    ends[0, o], ends[1, o] = dark / ti.max(bright, 1e-9), narrow / ti.max(wide, 1e-9)
                    place = next


_count_kernel, _cut_kernel = kernel(_count), kernel(_cut)


@dataclass(frozen=True)
class Pieces:
    """The pieces of the streaks of one system that bend.

    replaced : (n,) bool, the particles that are not drawn as straight streaks
    system : what the shading kernel reads of a system, with a column for each piece, that of its particle
    rows : (8, pieces or more) float32, of piece_rows
    kinds : (pieces,) int32, STREAK for the whole of a path, which needs no ends that join others; PIECE for a part of it
    ends : (2, pieces) float32, brightness and width at the old end, divided by those at the head
    numbers : of look_tables.kernel_numbers, for these pieces
    owner : (pieces,) the particle of each
    """

    replaced: np.ndarray
    system: SimpleNamespace
    rows: np.ndarray
    kinds: np.ndarray
    ends: np.ndarray
    numbers: np.ndarray
    owner: np.ndarray


def cut(system, past: PastMotion | None, numbers: np.ndarray, tail: float, taper: float) -> Pieces | None:
    """The pieces of those streaks of a system that bend, or None if all are straight.

    past : earlier motion; where none is known, streaks are straight
    numbers : of look_tables.kernel_numbers
    """
    n = int(system.count)
    if past is None or not n:
        return None
    known = past.known.view(np.uint8)
    counts, lifetime = np.empty(n, np.int32), system.floats[LIFETIME : LIFETIME + 1]
    _count_kernel(system.floats, system.birth, lifetime, past.motion, known, past.times, n, numbers, counts)
    replaced = counts != 0
    if not replaced.any():
        return None
    lengths = np.maximum(counts, 0)
    starts = np.cumsum(lengths, dtype=np.int64) - lengths
    total = int(lengths.sum(dtype=np.int64))
    owner, rows = np.zeros(total + PADDING, np.int32), np.zeros((PIECE_ROWS, total + PADDING), np.float32)
    ends = np.ones((2, max(total, 1)), np.float32)
    if total:
        _cut_kernel(
            system.floats, system.birth, past.motion, known, past.times, n, numbers, counts, starts.astype(np.int32),
            tail, taper, owner, rows, ends,
        )  # fmt: skip
    of_pieces = np.array(numbers)
    of_pieces[PIECES] = 1.0
    kinds = np.where(counts[owner[:total]] == 1, STREAK, PIECE).astype(np.int32)
    return Pieces(replaced, _owners(system, owner, total), rows, kinds, ends, of_pieces, owner[:total])


def _owners(system, owner: np.ndarray, count: int) -> SimpleNamespace:
    return SimpleNamespace(
        floats=system.floats.take(owner, axis=1), birth=system.birth[owner], key=system.key.take(owner, axis=1),
        id=system.id[owner], source=system.source[owner], sources=system.sources, count=count, channels=system.channels,
        entries=system.entries, booked=system.booked.take(owner, axis=1),
    )  # fmt: skip
