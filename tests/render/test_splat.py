"""Splatting: every sprite gives its energy, wherever it lies."""

import hashlib

import numpy as np
import pytest

from gen_art.backend import runtime
from gen_art.preset.look import Look
from gen_art.renderer import direct_splat as direct_splat
from gen_art.renderer import painter as painter_module
from gen_art.renderer.camera import Camera
from gen_art.renderer.direct_splat import MIN_PARTICLES
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.painter import Painter
from gen_art.renderer.render_frame import render_frame
from gen_art.renderer.sprite import AREA, BLUE, KERNEL_VARIANCE, LEVEL_FOOTPRINT, RED, X, Y, profile_integral
from tests.render.particles import scene, state

SIZE = (400, 240)
PIXELS = Camera(position=(0, 0, 10), height=240.0)  # one world unit is one pixel


def paint(look: dict, position, velocity=None, *, size=SIZE, camera=PIXELS, shutter=1.0, time=1.0, **more):
    painter = Painter(size, camera, {"a": Look(**look)}, shutter)
    return np.array(painter.paint(scene(time, a=state(position, velocity, **more)), 0.0))


def light(picture) -> np.ndarray:
    return picture[..., :3].sum(axis=(0, 1), dtype=np.float64)


@pytest.fixture
def places():
    return np.random.default_rng(7).uniform(-40, 40, (40, 3)) * (1, 1, 0)


@pytest.mark.parametrize("radius", [0.01, 0.3, 0.8, 2.0, 6.0, 10.6, 10.7, 15, 21.3, 22, 43])
def test_a_disc_gives_its_energy_at_any_size_and_offset(places, radius):
    got = light(
        paint(
            {"draw": "disc", "radius": radius}, places, size=(800, 600), camera=Camera(position=(0, 0, 9), height=600.0)
        )
    )
    assert got == pytest.approx([len(places) * AREA * (1.5 * radius) ** 2] * 3, rel=1e-5)


@pytest.mark.parametrize("width", [0.1, 1.0, 3.0, 12.0, 30.0])
@pytest.mark.parametrize("tail, taper", [(1, 1), (0.1, 0.3)])
def test_a_streak_gives_its_energy_whatever_its_length(places, width, tail, taper):
    for speed in (0.01, 0.5, 3.0, 60.0):
        velocity = np.random.default_rng(3).normal(0, speed, places.shape)
        look = {"draw": "streak", "width": width, "tail": tail, "taper": taper}
        got = light(paint(look, places, velocity, size=(1200, 1000), camera=Camera(position=(0, 0, 9), height=1000.0)))
        assert got == pytest.approx([len(places) * AREA * (0.75 * width) ** 2] * 3, rel=1e-5)


def test_a_point_gives_a_reference_pixel_of_light_at_any_size(places):
    for rows in (120, 240, 720, 960):
        camera = Camera(position=(0, 0, 9), height=240.0)
        got = paint({"draw": "point"}, places, size=(2 * rows, rows), camera=camera).mean(axis=(0, 1), dtype=np.float64)
        assert got[:3] == pytest.approx([len(places) / (2 * 720**2)] * 3, rel=1e-5)


@pytest.mark.parametrize(
    "look", [{"draw": "disc", "radius": 1.0}, {"draw": "disc", "radius": 30.0}, {"draw": "streak", "width": 3.0}]
)
def test_the_frame_s_border_cuts_and_nothing_else(look):
    middle = light(paint(look, [[0, 0, 0]], [[4, 0, 0]]))
    corner = light(paint(look, [[-200, 120, 0]], [[4, 0, 0]]))
    assert 0.03 < corner[0] / middle[0] < 0.5
    assert light(paint(look, [[-900, 0, 0]], [[4, 0, 0]])) == pytest.approx([0, 0, 0])


def test_a_pixel_takes_the_whole_light_of_what_lies_in_it():
    places = np.random.default_rng(5).uniform(-30, 30, (500, 3)) * (1, 1, 0)
    got = paint({"draw": "pixel"}, places)
    column, row = np.floor(places[:, 0]).astype(int) + SIZE[0] // 2, np.floor(-places[:, 1]).astype(int) + SIZE[1] // 2
    counts = np.zeros(SIZE[::-1])
    np.add.at(counts, (row, column), 1.0)
    assert np.allclose(got[..., 0], counts * got[..., 0].sum(dtype=np.float64) / len(places), rtol=1e-6)
    assert light(got) == pytest.approx(light(paint({"draw": "point"}, places)), rel=1e-5)


def test_a_streak_of_no_length_is_a_disc():
    place = [[3.3, -7.7, 0], [20.5, 9.1, 0]]
    disc = paint({"draw": "disc", "radius": 2.5}, place)
    streak = paint({"draw": "streak", "width": 5.0}, place, [[0, 0, 0], [0, 0, 0]])
    assert np.array_equal(disc, streak)
    short = paint({"draw": "streak", "width": 5.0}, place, [[0.02, 0.01, 0], [0.01, -0.02, 0]])
    assert np.abs(short - disc).max() < 0.03 * disc.max()


def test_a_streak_lies_between_where_the_particle_was_and_is():
    picture = paint({"draw": "streak", "width": 1.0, "tail": 0.0}, [[10.5, 0.5, 0]], [[30, 15, 0]])
    rows, columns = np.nonzero(picture[..., 0] > 0.01 * picture[..., 0].max())
    assert abs(columns.max() - 210) <= 2 and abs(columns.min() - 181) <= 4
    assert abs(rows.min() - 119) <= 2 and abs(rows.max() - 134) <= 3
    along = picture[..., 0].sum(axis=0)
    assert along[205:209].mean() > 4 * along[184:188].mean(), "the head must be brighter than the tail"


def test_streaks_agree_with_the_mean_of_many_discs():
    velocity, place = np.array([26.0, 11.0, 0.0]), np.array([5.2, 3.1, 0.0])
    streak = paint({"draw": "streak", "width": 4.0}, [place], [velocity])[..., 0]
    steps = (np.arange(400) + 0.5) / 400
    many = paint({"draw": "disc", "radius": 2.0}, place - steps[:, None] * velocity)[..., 0] / 400
    assert np.abs(streak - many).sum() < 0.06 * many.sum()


def test_discs_are_round():
    picture = paint({"draw": "disc", "radius": 12.0}, [[0, 0, 0]])[..., 0]
    y, x = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    r, angle = np.hypot(x - 200, y - 120), np.arctan2(y - 120, x - 200)
    ring = (r > 9.5) & (r < 10.5)
    octants = [picture[ring & (np.abs(angle - k * np.pi / 4) < 0.3)].mean() for k in range(-3, 4)]
    assert max(octants) / min(octants) < 1.06


def kernel_profile(t):
    """The kernel of sprite.py, of footprint 1."""
    s = np.minimum(t * t, 1)
    return (1 - 0.3125 * s) ** 8 * (1 - s) ** 2


def interpolation_error(footprint):
    """The largest error, of the kernel's peak, where it is sampled at every second pixel and interpolated by 3/4 and 1/4."""
    worst, coarse = 0.0, np.arange(-64, 64) * 2.0
    for centre in np.linspace(0, 2, 33):
        # the weights have a variance of 3/4 of a pixel squared
        samples = kernel_profile((coarse - centre) / np.sqrt(footprint**2 - 3 / 4 / KERNEL_VARIANCE))
        samples *= kernel_profile((coarse - centre) / footprint).sum() / samples.sum()
        right = 0.75 * samples + 0.25 * np.roll(samples, -1)
        left = 0.75 * samples + 0.25 * np.roll(samples, 1)
        for side, light in ((0.5, right), (-0.5, left)):
            worst = max(worst, np.abs(light - kernel_profile((coarse + side - centre) / footprint)).max())
    return worst


@pytest.mark.parametrize("radius", [7.0, 10.0, 15.0, 25.0, 60.0])
def test_large_discs_in_coarser_framebuffers_keep_their_shape(radius):
    """Mutants: footprints that are not shortened by the variance of the weights; 1/4 and 3/4 exchanged."""
    picture = paint(
        {"draw": "disc", "radius": radius},
        [[0.3, -0.2, 0]],
        size=(800, 480),
        camera=Camera(position=(0, 0, 9), height=480.0),
    )
    reach = 1.5 * np.hypot(radius, 1)  # a pixel and a half is the least reach
    x, y = (np.arange(800) + 0.5 - 400.3) / reach, (np.arange(480) + 0.5 - 240.2) / reach
    gx, gy = kernel_profile(x), kernel_profile(y)
    halved = [reach / 2**k for k in range(3) if reach / 2**k >= 0.85 * LEVEL_FOOTPRINT]
    bound = 2 * sum(map(interpolation_error, halved))  # both axes
    assert np.abs(picture[..., 0] * (reach / (1.5 * radius)) ** 2 - gy[:, None] * gx).max() < bound


def test_the_picture_at_twice_the_size_is_the_picture():
    rng = np.random.default_rng(2)
    place, look = rng.normal(0, 30, (300, 3)), {"draw": "disc", "radius": 5.0}
    one = paint(look, place)
    two = paint(look, place, size=(800, 480)).reshape(240, 2, 400, 2, 4).mean(axis=(1, 3))
    # the mean of 2 x 2 pixels widens a disc by 1.2% of its variance; every second pixel of the larger disc is interpolated
    assert np.abs(one - two).sum() < (0.012 + interpolation_error(15)) * two.sum()


def test_alpha_is_laid_back_to_front_and_ties_go_by_id():
    look = {
        "draw": "disc",
        "blend": "alpha",
        "radius": 8.0,
        "opacity": 50.0,
        "albedo": {"by": "id", "range": "0..1", "gradient": ["red", "blue"]},
    }
    near_is_second = paint(look, [[0, 0, 0], [0, 0, 2]])[120, 200]
    near_is_first = paint(look, [[0, 0, 2], [0, 0, 0]])[120, 200]
    tie = paint(look, [[0, 0, 0], [0, 0, 0]])[120, 200]
    assert near_is_second[2] > 5 * near_is_second[0], "the blue one is in front"
    assert near_is_first[0] > 3 * near_is_first[2], "the red one is in front"
    assert np.array_equal(tie, near_is_second), "of two at one depth the later is in front"
    assert near_is_second[3] == pytest.approx(1.0, abs=0.02)


def test_what_is_in_front_hides_light_and_what_is_behind_does_not():
    looks = {
        "smoke": Look(draw="disc", blend="alpha", radius=20.0, opacity=3.0, albedo="black"),
        "lamp": Look(draw="disc", radius=0.4),
    }

    def at(depth):
        systems = {"smoke": state([[0, 0, 0]]), "lamp": state([[0, 0, depth]])}
        return light(np.array(Painter(SIZE, PIXELS, looks).paint(scene(**systems), 0.0)))[0]

    assert at(-2) / at(2) == pytest.approx(np.exp(-3.0), rel=0.1)


def test_premultiplied_alpha_stays_within_bounds():
    rng = np.random.default_rng(5)
    picture = paint({"draw": "disc", "blend": "alpha", "radius": 9.0, "opacity": 0.4}, rng.normal(0, 20, (4000, 3)))
    assert picture.min() >= 0 and picture[..., 3].max() <= 1.0 + 1e-5
    assert np.all(picture[..., :3] <= picture[..., 3:] * (1 + 1e-4) + 1e-6), "white smoke is as bright as it covers"


def test_light_in_the_frame_is_the_mean_of_the_framebuffer():
    stars = scene(stars=state(np.random.default_rng(1).normal(0, 1, (500, 3))))
    far = Camera(position=(0, 0, 30), fov=60)
    for size in ((160, 90), (640, 360), (1280, 720)):
        assert render_frame(stars, size, far).mean(axis=(0, 1), dtype=np.float64) == pytest.approx(
            [500, 500, 500, 0], rel=1e-5
        )


def test_float64_storage_is_drawn_the_same():
    place = np.random.default_rng(1).normal(0, 20, (200, 3)).astype(np.float32)
    one, two = (paint({"draw": "disc", "radius": 2.0}, place, dtype=d) for d in (np.float32, np.float64))
    assert np.abs(one - two).max() < 1e-5


def test_the_dead_and_the_unborn_are_not_drawn():
    got = light(paint({"draw": "disc", "radius": 2.0}, [[0, 0, 0]] * 3, birth=[0.0, 1.5, 0.9], life=[0.5, 5.0, 5.0]))
    assert got[0] == pytest.approx(AREA * 9.0, rel=1e-5)


def test_positions_that_are_no_numbers_are_left_out():
    got = light(paint({"draw": "disc", "radius": 2.0}, [[np.nan, 0, 0], [np.inf, 0, 0], [0, 0, 0]]))
    assert got[0] == pytest.approx(AREA * 9.0, rel=1e-5)


def test_no_particles_make_a_black_picture():
    assert not paint({"draw": "point"}, np.zeros((0, 3))).any()


def test_the_kernel_s_integral():
    assert profile_integral() == pytest.approx(0.7923188656, abs=1e-8)


def test_a_picture_repeats(places):
    digests = {hashlib.sha256(paint({"draw": "disc", "radius": 4.0}, places)).hexdigest() for _ in range(3)}
    assert len(digests) == 1


@pytest.mark.parametrize(
    "look", [{"draw": "point"}, {"draw": "pixel"}, {"draw": "disc", "radius": 1.0}, {"draw": "disc", "radius": 2.6}]
)
def test_many_small_sprites_are_drawn_directly_to_the_same_picture(look, monkeypatch):
    """Drawn directly, or listed in bins; some sprites lie over the border or outside, and there are several sizes."""
    rng = np.random.default_rng(11)
    place = np.append(
        rng.uniform(-1, 1, (MIN_PARTICLES + 1001, 3)) * (205, 125, 0), [[np.nan, 0, 0], [1e9, 0, 0]], axis=0
    )
    look = {**look, "size": {"by": "random", "curve": [[0, 0.3], [1, 1.3]]}, "emission": {"color": [0.2, 0.5, 1.0]}}
    scattered = paint(look, place)
    monkeypatch.setattr(painter_module, "MIN_PARTICLES", 10**9)
    listed = paint(look, place)
    assert light(listed)[2] > 0
    assert light(scattered) == pytest.approx(light(listed), rel=1e-5)
    assert np.abs(scattered - listed).max() < 1e-5 * listed.max()


@pytest.mark.parametrize("draw", [direct_splat.pixels, direct_splat.points])
def test_only_the_first_n_particles_are_drawn(draw):
    """After a picture with more particles, those that remain in the arrays are not drawn."""
    channels, framebuffer = runtime.aligned((11, 2048), np.float32), FrameBuffer((64, 48))
    channels[[X, Y]], channels[RED : BLUE + 1] = 20.5, 1.0
    for n in (1, 31, 512, 513, 1000):
        framebuffer.clear()
        draw(channels, n, framebuffer)
        assert framebuffer.pixels[..., :3].sum((0, 1)).tolist() == [n, n, n]


@pytest.mark.parametrize("draw", [direct_splat.pixels, direct_splat.points])
def test_points_on_the_border_stay_in_their_row_and_write_nothing_behind_the_framebuffer(draw):
    """A framebuffer without padding, and minus zeros behind it: adding 0 to one would make it +0."""
    framebuffer = FrameBuffer((128, 128))
    assert framebuffer.buffer.size == 128 * 128 * 4
    memory = runtime.aligned(framebuffer.buffer.size + 4 * 4 * 128, np.float32)
    memory[:] = -0.0
    framebuffer.buffer = memory[: framebuffer.buffer.size]
    channels = runtime.aligned((11, 512), np.float32)
    channels[X], channels[Y] = 127.8, np.arange(512) / 4
    channels[RED : BLUE + 1] = 1.0
    draw(channels, 512, framebuffer)
    assert (framebuffer.pixels[:, -1, 0] > 2).all()
    assert not framebuffer.pixels[:, 0].any()
    assert np.signbit(memory[framebuffer.buffer.size :]).all()


def test_a_large_framebuffer_is_cleared_completely(monkeypatch):
    monkeypatch.setattr("gen_art.renderer.framebuffer.PARALLEL_CLEAR", 0)
    for size in ((1, 1), (33, 7), (640, 360)):
        framebuffer = FrameBuffer(size)
        framebuffer.buffer[:] = 1.0
        framebuffer.clear()
        assert not framebuffer.buffer.any()


def test_every_pixel_of_the_largest_framebuffer_has_an_index_of_its_own():
    """INDEX_MASK must leave it as it is."""
    assert 16384 * 16384 - 1 & runtime.INDEX_MASK == 16384 * 16384 - 1


def test_what_hides_is_sorted_by_the_whole_depth():
    """Two discs a millionth apart, among others far away, in either order."""
    look = {"draw": "disc", "blend": "alpha", "radius": 8.0, "opacity": 50.0}
    look["albedo"] = {"by": "id", "range": "0..1", "gradient": ["red", "blue"]}
    for first, second in ((0, 1e-5), (1e-5, 0)):
        middle = paint(look, [[0, 0, first], [0, 0, second], [80, 0, -2000], [80, 0, 9]])[120, 200]
        assert (middle[0] > middle[2]) == (first > second)


def test_a_sphere_hides_all_behind_it_and_gives_its_energy(places):
    looks = {
        "ball": Look(draw="sphere", blend="opaque", radius=9.0, albedo="white"),
        "lamp": Look(draw="disc", radius=2.0),
    }
    for depth, hidden in ((-2, True), (2, False)):
        systems = {"ball": state([[0.3, 0.2, 0]]), "lamp": state([[0, 0, depth]])}
        picture = np.array(Painter(SIZE, PIXELS, looks).paint(scene(**systems), 0.0))
        assert picture[120, 200, :3] == pytest.approx([1.0 if hidden else 2.0] * 3, rel=0.2)
    for radius in (0.7, 3.3, 20.0, 70.0):
        got = light(
            paint(
                {"draw": "sphere", "radius": radius},
                places,
                size=(900, 700),
                camera=Camera(position=(0, 0, 9), height=700.0),
            )
        )
        assert got == pytest.approx([len(places) * np.pi * radius**2] * 3, rel=1e-5)


@pytest.mark.parametrize("look", [
    {"draw": "point"}, {"draw": "disc", "radius": 0.02}, {"draw": "disc", "radius": 0.2}, {"draw": "streak", "width": 0.1},
    {"draw": "sphere", "radius": 0.2},
])  # fmt: skip
def test_a_lens_keeps_the_light_and_spreads_it_over_its_circle_of_confusion(look):
    """Radius of a point's circle: R |1/focus - 1/d| as a slope, rows / (2 tan(fov / 2)) pixels a unit of slope."""
    pixels = 600 / (2 * np.tan(np.radians(20)))
    for depth in (4.0, 8.0, 10.0, 16.0, 40.0):
        sharp, soft = (
            paint(
                look,
                [(0.013, 0.021, 10.0 - depth)],
                [(0.3, 0.1, 0)],
                size=(800, 600),
                camera=Camera(position=(0, 0, 10), fov=40, lens=lens),
            )
            for lens in (None, (0.3, 10.0))
        )
        assert light(soft) == pytest.approx(light(sharp), rel=1e-5)
        spread = _variance(soft) - _variance(sharp)
        circle = 0.3 * abs(1 / 10.0 - 1 / depth) * pixels
        assert spread == pytest.approx(circle**2 / 2, rel=0.02, abs=0.4), (
            f"an even disc of {circle:.1f} pixels, {depth} away"
        )


def _variance(picture) -> float:
    """Of the distance from the middle of the light, pixels squared."""
    weight = picture[..., 0].astype(np.float64)
    y, x = np.mgrid[: weight.shape[0], : weight.shape[1]]
    total = weight.sum()
    mx, my = (x * weight).sum() / total, (y * weight).sum() / total
    return float((((x - mx) ** 2 + (y - my) ** 2) * weight).sum() / total)
