"""Streaks along curved paths: where the exact path lies, how much light is where on it, and when nothing changes."""

import math

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.curved_streaks import TOLERANCE, cut
from gen_art.renderer.look_tables import LookTables, kernel_numbers
from gen_art.renderer.painter import Painter
from gen_art.renderer.path_history import PathHistory
from gen_art.renderer.piece_rows import PIECE_HEAD, PIECE_LIGHT, PIECE_OLD
from gen_art.renderer.sprite import AREA, PIECE, STREAK
from tests.render.particles import scene, state

SIZE = (400, 240)
PIXELS = Camera(position=(0, 0, 10), height=240.0)  # one world unit is one pixel
RADIUS = 80.0


def circle(t, rate=4.0):
    """The place and the velocity on a circle of RADIUS about the middle."""
    c, s = math.cos(rate * t), math.sin(rate * t)
    return [[RADIUS * c, RADIUS * s, 0]], [[-RADIUS * rate * s, RADIUS * rate * c, 0]]


def parabola(t):
    """From rest at the left, 160 pixels in the first second: the speed grows evenly."""
    return [[160 * t * t - 80, 0.5, 0]], [[320 * t, 0, 0]]


def remember(painter, path, moments, shutter=1.0, now=1.0, **more):
    for k in range(moments):
        t = now - shutter * (moments - k) / moments
        painter.paths["a"].remember(state(*path(t), **more), t)


def paint(path, moments=8, *, size=SIZE, camera=PIXELS, shutter=1.0, **look):
    painter = Painter(size, camera, {"a": Look(draw="streak", **look)}, shutter)
    remember(painter, path, moments, shutter)
    return np.array(painter.paint(scene(1.0, a=state(*path(1.0))), 0.0), np.float64)


def pieces_of(path, moments, *, camera=PIXELS, shutter=1.0, tail=1.0, taper=1.0, birth=0.0):
    look = Look(draw="streak", width=2.0)
    painter = Painter(SIZE, camera, {"a": look}, shutter)
    remember(painter, path, moments, shutter, birth=birth)
    now = state(*path(1.0), birth=birth)
    numbers = kernel_numbers(LookTables.of(look, {}), camera.at(0.0), SIZE, 1.0, 0.0, shutter, False)
    return cut(now, painter.paths["a"].since(now, 1.0, 1.0 - shutter), numbers, tail, taper)


@pytest.mark.parametrize("moments, angle", [(8, 4.0), (8, 6.2), (5, 1.5), (1, 0.6)])
def test_the_pieces_of_a_circle_lie_on_it(moments, angle):
    """Ends within the error of the Hermite curve, R (a / moments)^4 / 384, and chords within TOLERANCE of that; no more pieces
    than the largest chords within the tolerance need, and one. Mutants: the sign of a velocity; a quadratic from the head."""
    found = pieces_of(lambda t: circle(t, angle), moments)
    head, old = found.rows[PIECE_HEAD : PIECE_HEAD + 2], found.rows[PIECE_OLD : PIECE_OLD + 2]
    n = found.ends.shape[1]
    hermite = RADIUS * (angle / moments) ** 4 / 384 + 1e-4
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        distance = np.hypot(*((1 - share) * head + share * old)[:, :n])
        assert np.abs(distance - RADIUS).max() < hermite + (4 * share * (1 - share)) * TOLERANCE * 1.02
    times = 1.0 - np.arange(n + 1) / n
    exact = RADIUS * np.array([np.cos(angle * times), np.sin(angle * times)])
    assert np.abs(np.column_stack([head[:, :n], old[:, n - 1]]) - exact).max() < 3 * hermite
    assert n <= math.ceil(1.1 * angle * math.sqrt(RADIUS / (8 * TOLERANCE))) + 1


def test_a_path_of_one_piece_is_a_streak_along_its_chord():
    """An arc whose chord is within TOLERANCE of it, while its tangent leaves it four times as far. Mutants: a piece of a path,
    where it is cut or where it is drawn; a straight streak along the velocity."""
    angle = math.sqrt(8 * 0.8 * TOLERANCE / RADIUS)
    found = pieces_of(lambda t: circle(t, angle), 8, tail=0.2, taper=0.4)
    assert found.replaced.all() and found.kinds.tolist() == [STREAK]
    x, y = (found.rows[PIECE_HEAD + k, 0] - found.rows[PIECE_OLD + k, 0] for k in range(2))
    assert (x, y) == pytest.approx(RADIUS * np.array([math.cos(angle) - 1, math.sin(angle)]), abs=1e-3)
    assert found.ends[:, 0] == pytest.approx([0.2, 0.4])
    twice = pieces_of(lambda t: circle(t, 2 * angle), 8)
    assert twice.kinds.tolist() == [PIECE] * 2
    for turn, kinds in ((angle, {STREAK}), (2 * angle, {PIECE})):
        painter = Painter(SIZE, PIXELS, {"a": Look(draw="streak", width=2.0)}, 1.0)
        remember(painter, lambda t, turn=turn: circle(t, turn), 8)
        painter.paint(scene(1.0, a=state(*circle(1.0, turn))), 0.0)
        assert painter._sprites.kinds == kinds


def test_a_circle_s_light_lies_on_the_circle_evenly():
    """Mutants: no cut of the path (a straight streak); pieces of equal length of a path that is not."""
    picture = paint(circle, width=0.1)[..., 0]
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    x, y = columns + 0.5 - SIZE[0] / 2, SIZE[1] / 2 - rows - 0.5
    assert abs((np.hypot(x, y) * picture).sum() / picture.sum() - RADIUS) < TOLERANCE
    off = np.abs(np.hypot(x, y) - RADIUS)
    assert picture[off > 2.5].sum() < 1e-3 * picture.sum()
    back = np.mod(4.0 - np.arctan2(y, x), 2 * math.pi)
    shares = [picture[(back >= 0.5 * k) & (back < 0.5 * k + 0.5)].sum() / picture.sum() for k in range(1, 7)]
    # a piece's light is even to the width of a pixel over the 40 pixels of a sector
    assert shares == pytest.approx([0.125] * 6, rel=0.03)


@pytest.mark.parametrize("width", [0.1, 1.0, 6.0, 20.0])
@pytest.mark.parametrize("tail, taper", [(1, 1), (0.1, 0.3), (0, 0)])
def test_a_curved_streak_gives_its_energy(width, tail, taper):
    """Mutants: the pieces' shares without `tail`; the light of a piece times its narrower width."""
    got = paint(circle, width=width, tail=tail, taper=taper).sum(axis=(0, 1))
    assert got[:3] == pytest.approx([AREA * (0.75 * width) ** 2] * 3, rel=1e-5)


def test_it_tapers_and_fades_over_its_whole_length():
    found = pieces_of(circle, 8, tail=0.2, taper=0.5)
    n = found.ends.shape[1]
    assert np.prod(found.ends, axis=1) == pytest.approx([0.2, 0.5], rel=1e-5)
    light = found.rows[PIECE_LIGHT, :n]
    s = (np.arange(n) + 0.5) / n
    assert light == pytest.approx((1 - 0.8 * s) / 0.6 / n, rel=1e-4)


def test_it_is_the_mean_of_many_discs_in_time():
    """A particle that speeds up is dimmer where it is fast. The bound is that of a straight streak and discs."""
    streak = paint(parabola, width=4.0)[..., 0]
    times = (np.arange(800) + 0.5) / 800
    places = np.concatenate([parabola(t)[0] for t in times])
    discs = Painter(SIZE, PIXELS, {"a": Look(draw="disc", radius=2.0)}, 1.0)
    many = np.array(discs.paint(scene(1.0, a=state(places)), 0.0), np.float64)[..., 0] / 800
    assert np.abs(streak - many).sum() < 0.06 * many.sum()
    assert streak[:, 130].sum() > 1.9 * streak[:, 270].sum()  # speeds 160 sqrt(10 / 160) 2 and 160 sqrt(150 / 160) 2


def test_straight_streaks_keep_their_bytes():
    def straight(t):
        return [[-60 + 120 * t, 40 * t, 3 * t]], [[120, 40, 3]]

    assert np.array_equal(paint(straight, 8, width=3.0), paint(straight, 0, width=3.0))
    slow = paint(lambda t: circle(t, 0.07), 8, width=3.0)  # 5.6 pixels of path, 0.2 pixels off the tangent
    assert np.array_equal(slow, paint(lambda t: circle(t, 0.07), 0, width=3.0))


@pytest.mark.parametrize("birth", [0.55, 0.9])
def test_a_streak_begins_at_its_birth(birth):
    """Born between two moments, or after the last: even acceleration goes on to the birth. Mutant: moments before it count."""
    found = pieces_of(parabola, 4, birth=birth)
    if birth > 0.8:  # no moment is known after it
        assert found is None
        return
    n = found.ends.shape[1]
    assert found.rows[PIECE_OLD, n - 1] == pytest.approx(parabola(birth)[0][0][0], abs=1e-3)


@pytest.mark.parametrize("removed", [False, True])
@pytest.mark.parametrize("kept", [False, True])
def test_the_past_of_those_that_live_now(removed, kept):
    """Particles born between the moments, and with `removed` some gone since. Mutants: who is new has a known past; motion moved
    by one; the order of the moments; a moment at `start` left out."""
    history, rng = PathHistory(8), np.random.default_rng(0)
    motion = rng.normal(size=(4, 6, 12)).astype(np.float32)  # of ids 0 to 11, at four moments
    ids = [np.arange(k + 3) for k in range(4)]
    if removed:
        ids[2:] = [np.array([0, 2, 3, 4]), np.array([0, 3, 4, 5])]
    for k, own in enumerate(ids):
        moment = state(motion[k, :3, own], motion[k, 3:, own])
        moment.id[: len(own)] = own
        history.remember(moment, float(k))
    now = state(np.zeros((7, 3)))
    alive = np.array([0, 3, 4, 5, 7, 8, 9]) if removed else np.arange(7)
    now.id[:7] = alive
    if kept:
        found = [(t, np.array(m), np.array(k)) for t, m, k in history.before(now, 4.0) if t >= 1.0]
    else:
        past = history.since(now, 4.0, 1.0)
        found = list(zip(past.times, past.motion, past.known))
    assert [time for time, *_ in found] == [3.0, 2.0, 1.0]
    there = np.ones(7, bool)
    for (_, got, known), k in zip(found, (3, 2, 1)):
        there = there & np.isin(alive, ids[k])
        assert np.array_equal(known, there) and there.any()
        assert np.array_equal(got[:, there], motion[k][:, alive[there]])
        assert np.isfinite(got).all()


def test_a_periodic_box_does_not_break_a_streak():
    """Through the side of a box, as a particle without one. Mutant: positions that are not brought to the nearest image."""
    box = PeriodicBox((-60, -500, -500), (60, 500, 500), "x")

    def wrapped(t):
        position, velocity = parabola(t)
        return [[(position[0][0] + 60) % 120 - 60, 0.5, 0]], velocity

    painters = []
    for path, of in ((parabola, None), (wrapped, box)):
        painter = Painter(SIZE, PIXELS, {"a": Look(draw="streak", width=2.0)}, 0.5)
        for k in range(8):
            past = state(*path(0.5 + k / 16))
            past.box = of
            painter.paths["a"].remember(past, 0.5 + k / 16)
        now = state(*path(1.0))
        now.box = of
        painters.append(np.array(painter.paint(scene(1.0, a=now), 0.0)))
    free, periodic = painters
    assert np.allclose(np.roll(periodic, 120, axis=1), free, atol=2e-4 * free.max())


@pytest.mark.parametrize("camera", [Camera(position=(0, 0, 60), fov=60), Camera(position=(0, 0, 90), fov=20), PIXELS])
@pytest.mark.parametrize("size", [(1, 1), (7, 5), SIZE])
def test_any_path_gives_finite_light(camera, size):
    """Through the camera, behind it, with places that are no numbers; no particles, and one."""

    def helix(t):
        return [[20 * math.cos(9 * t), 20 * math.sin(9 * t), 120 * t], [math.nan, 0, 0], [1e30, 0, 0]], [
            [-180 * math.sin(9 * t), 180 * math.cos(9 * t), 120], [0, 0, 0], [1e30, 0, 0]]  # fmt: skip

    assert np.isfinite(paint(helix, 5, size=size, camera=camera, width=2.0)).all()
    none = Painter(size, camera, {"a": Look(draw="streak", width=2.0)}, 1.0)
    for t in (0.0, 0.5):
        none.paths["a"].remember(state(np.zeros((0, 3))), t)
    assert not none.paint(scene(1.0, a=state(np.zeros((0, 3)))), 0.0).any()


RING = """
version: 1
clock: {duration: 1, fps: 10, step: 1/80}
systems:
  ring:
    particle: {mass: 1, lifetime: 0.35..0.6}
    integrator: leapfrog
    forces: {spring: {center: [0, 0, 0], stiffness: 120}}
    emitters: {all: {rate: 60, shape: {ball: 0.3}, velocity: {sphere: 8}}}
    look: {draw: streak, width: 0.06, tail: 0.3%s}
camera: {position: [0, 0, 6], target: [0, 0, 0], fov: 40, shutter: 300%s}
"""


@pytest.mark.parametrize(
    "look, camera", [("", ""), (", length: 0.3", ""), ("", ", subframes: 3"), (", trail: 0.1", "")],
    ids=["shutter", "length", "subframes", "trail"],
)  # fmt: skip
def test_a_still_is_the_frame_of_the_film(tmp_path, look, camera):
    """Whichever frames were drawn before; and the streaks do bend. Mutant: moments that count from the frame before."""
    (tmp_path / "ring.yaml").write_text(RING % (look, camera))
    preset = load_preset(str(tmp_path / "ring.yaml"))
    film, sparse = Playback(preset, (96, 54), "f32", None), Playback(preset, (96, 54), "f32", None)
    frames = {k: np.array(film.picture(8 * k)) for k in range(1, 8)}
    sparse.picture(8 * 3)
    assert np.array_equal(sparse.picture(8 * 7), frames[7])
    assert np.array_equal(Playback(preset, (96, 54), "f32", None).picture(8 * 5), frames[5])
    straight = Playback(preset, (96, 54), "f32", None)
    straight.painter.paths.clear()
    straight._path_steps = {}
    assert not np.array_equal(straight.picture(8 * 5), frames[5])


def test_pieces_join_evenly():
    """The brightness along the middle of a wide circle, whichever way it runs. Mutants: pieces cut off along the pixels' axes, and
    pieces with the slope of a streak of their own: 20% and 9% off."""
    picture = paint(lambda t: circle(t, 6.0), 8, width=10.0)[..., 0]
    angles = np.radians(np.arange(20, 320, 1.0))
    x, y = SIZE[0] / 2 + RADIUS * np.cos(angles) - 0.5, SIZE[1] / 2 - RADIUS * np.sin(angles) - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = x - i, y - j
    along = (1 - v) * ((1 - u) * picture[j, i] + u * picture[j, i + 1])
    along += v * ((1 - u) * picture[j + 1, i] + u * picture[j + 1, i + 1])
    # each chord is up to a quarter of a pixel off, where the profile, of footprint 7.5, has fallen by 1%
    assert np.abs(along / along.mean() - 1).max() < 0.02


SPIRAL = """
version: 1
clock: {duration: 2, fps: 10, step: 1/200}
systems:
  bodies:
    particle: {mass: 1}
    integrator: leapfrog
    forces: {spring: {center: [0, 0, 0], stiffness: 39.4784}}
    emitters: {a: {count: 1, shape: {point: [1, 0, 0]}, velocity: {constant: [0, 6.2832, 0]}}}
    look: {draw: streak, width: 0.05, ribbon: {length: 0.8, points: %d, taper: 1, tail: 1}}
camera: {height: 3, position: [0, 0, 5], target: [0, 0, 0]}
"""


def test_a_ribbon_of_few_points_is_round(tmp_path):
    """Eight points on 288 degrees: the light's distance from the circle of 120 pixels is that of a ribbon of eighty points.
    Mutant: chords, which leave the circle by 5.9 pixels."""
    found = []
    for points in (8, 80):
        (tmp_path / "spiral.yaml").write_text(SPIRAL % points)
        play = Playback(load_preset(str(tmp_path / "spiral.yaml")), (480, 360), "f32", None)
        picture = np.array(play.picture(199), np.float64)[..., 0]  # 0.795 s are remembered by both
        rows, columns = np.mgrid[:360, :480]
        distance = np.abs(np.hypot(columns + 0.5 - 240, 180 - rows - 0.5) - 120)
        found.append((picture.sum(), (distance * picture).sum() / picture.sum(), picture[distance > 6.5].sum()))
    few, many = found
    assert few[0] == pytest.approx(many[0], rel=2e-3), "a chord is shorter than its arc by a 24th of its angle squared"
    assert few[1] < many[1] + TOLERANCE and few[2] < 1e-3 * few[0]
