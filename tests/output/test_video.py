"""Films: what each format holds, that its colours are right, that alpha survives, and that bytes repeat."""

import hashlib
import io
import subprocess
import sys
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image

from gen_art.errors import UsageError
from gen_art.output.formats import CODECS, PROFILES, find_format
from gen_art.output.probe import probe
from gen_art.output.read_recipe import read_recipe
from gen_art.output.segments import encoder_stream, open_film
from gen_art.output.video import film_writer
from gen_art.output.yuv import film_frame
from tests.output.delta_e import ciede2000, lab

RECIPE = {"format": 1, "preset": {"name": "ä"}, "numbers": [1.5, 2]}
KINDS = {  # a film's name and what is asked: codec, pixel format (ProRes 4444 is read with 12 bits), four letters
    "h264": ("a.mp4", {}, "h264", "yuv420p", "avc1"),
    "h264_10": ("a.mp4", {"bits": 10}, "h264", "yuv420p10le", "avc1"),
    "h264_mov": ("a.mov", {"codec": "h264"}, "h264", "yuv420p", "avc1"),
    "h265": ("a.mp4", {"codec": "h265"}, "hevc", "yuv420p", "hvc1"),
    "h265_10": ("a.mp4", {"codec": "h265", "bits": 10}, "hevc", "yuv420p10le", "hvc1"),
    "prores": ("a.mov", {}, "prores", "yuv444p12le", "ap4h"),
    "prores_alpha": ("a.mov", {"transparent": True}, "prores", "yuva444p12le", "ap4h"),
    "vp9": ("a.webm", {}, "vp9", "yuv420p", ""),
    "av1": ("a.mp4", {"codec": "av1"}, "av1", "yuv420p", "av01"),
    "av1_10": ("a.webm", {"codec": "av1", "bits": 10}, "av1", "yuv420p10le", ""),
    "ffv1": ("a.mkv", {}, "ffv1", "bgr0", ""),
    "ffv1_16": ("a.mkv", {"bits": 16}, "ffv1", "gbrp16le", ""),
    "ffv1_alpha": ("a.mkv", {"transparent": True}, "ffv1", "bgra", ""),
}


def write(path, film, pictures, fps=10, recipe=RECIPE):
    height, width = pictures[0].shape[:2]
    writer = film_writer(path, (width, height), fps, recipe, film)
    for picture in pictures:
        writer.add(picture)
    writer.close()
    return path


def moving(film, frames=45, size=(64, 48)):
    """A colour wedge that travels, a soft disc for alpha."""
    width, height = size
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    top = 255 if film.depth == 8 else 65535
    for k in range(frames):
        colours = [(x * 3 + 9 * k) % 256, y * 5 % 256, np.full_like(x, 40 + 2 * k)]
        if film.transparent:
            colours.append(np.clip(300 - 12 * np.hypot(x - width / 2, y - height / 2), 0, 255))
        yield (np.stack(colours, axis=2) / 255 * top).astype(np.uint8 if top == 255 else np.uint16)


@pytest.mark.parametrize("kind", KINDS)
def test_each_format_holds_what_it_says(tmp_path, kind):
    name, asked, codec, pixels, tag = KINDS[kind]
    film = find_format(name, **asked)
    path = write(tmp_path / name, film, list(moving(film)))
    found = probe(path)
    assert (found.codec, found.pixel_format, found.size) == (codec, pixels, (64, 48))
    assert found.tag.strip("\0") == tag
    tags = (1, 13, 0, 2) if codec == "ffv1" else (1, 1, 1, 1)
    assert (found.primaries, found.transfer, found.matrix, found.range) == tags
    assert (found.fps, found.frames, found.duration) == (10, 45, 4.5)
    with av.open(str(path)) as container:
        times = [float(frame.time) for frame in container.decode(video=0)]
    assert np.allclose(times, np.arange(45) / 10, atol=1e-9), "each frame at its time, from 0 on"
    assert read_recipe(path) == RECIPE
    assert [p.name for p in tmp_path.iterdir()] == [name], "the partial film is gone"
    if codec not in ("prores", "ffv1"):
        assert {0, 20, 40} <= set(found.keyframes), "closed segments of two seconds"


@pytest.mark.parametrize("codec", [c for c in CODECS if c not in ("gif", "webp")])
def test_more_care_comes_closer(tmp_path, codec):
    """Profiles from preview to master: the decoded film differs less and less from the pictures; FFV1's not at all."""
    rng, errors = np.random.default_rng(3), []
    for profile in PROFILES:
        film = find_format(f"a{CODECS[codec].extensions[0]}", codec=codec, profile=profile)
        top = 255 if film.depth == 8 else 65535
        pictures = [np.clip(p + rng.normal(0, 0.05 * top, p.shape), 0, top).astype(p.dtype) for p in moving(film, 6)]
        path = write(tmp_path / f"{profile}{film.extension}", film, pictures)
        with av.open(str(path)) as container:
            decoded = [
                frame.to_ndarray(format="rgb48le" if top > 255 else "rgb24") for frame in container.decode(video=0)
            ]
        assert len(decoded) == 6
        errors.append(np.mean([np.abs(d.astype(float) - p[..., :3]).mean() / top for d, p in zip(decoded, pictures)]))
        rng = np.random.default_rng(3)
    if codec == "ffv1":
        assert errors == [0, 0, 0]
    else:
        assert errors[0] > errors[1] > errors[2]


def test_h264_s_profiles_differ_as_they_should(tmp_path):
    rng = np.random.default_rng(3)
    sizes = []
    for profile in PROFILES:
        film = find_format("a.mp4", profile=profile)
        noisy = [np.clip(p + rng.normal(0, 20, p.shape), 0, 255).astype(np.uint8) for p in moving(film, 12)]
        sizes.append(write(tmp_path / f"{profile}.mp4", film, noisy).stat().st_size)
    assert sizes[0] < sizes[1] < sizes[2]


@pytest.mark.parametrize("size", [(64, 48), (208, 144), (854, 48)])
def test_h264_repeats_at_any_width(size):
    """x264's macroblock tree does not, where the width is no multiple of 128: it is off there."""
    film = find_format("a.mp4")
    pictures = list(moving(film, 10, size))
    assert len({encoded(film, pictures) for _ in range(8)}) == 1
    assert "mbtree" not in film.options((1920, 1080)) and film.options(size)["mbtree"] == "0"


def test_h265_repeats_whatever_lay_in_memory():
    """With x265's weighted prediction one film in five is another."""
    film = find_format("a.mp4", codec="h265")
    pictures, before, films = list(moving(film, 12, (256, 64))), [], set()
    for k in range(40):
        before.append(np.random.default_rng(k).random(10_000 * (k % 7 + 1)))
        films.add(hashlib.sha256(encoded(film, pictures)).digest())
    assert len(films) == 1


_SMALL = """
import sys
sys.path.insert(0, {root!r})
from pathlib import Path
from gen_art.backend import runtime
from gen_art.output.formats import CODECS, find_format
from gen_art.output.probe import probe
from tests.output.test_video import moving, write
runtime.init("cpu")
for codec in CODECS.values():
    least, extension = codec.least, codec.extensions[0]
    sizes = [(least, least), (least, 3 * least), (90, least)]
    if codec.name == "h265":
        sizes += [(48, 28)] * 3
    for k, size in enumerate(sizes):
        film = find_format("a" + extension, codec=None if extension in (".gif", ".webp") else codec.name, size=size)
        path = write(Path(sys.argv[1], str(k) + "a" + extension), film, list(moving(film, 23, size)))
        assert extension in (".gif", ".webp") or (probe(path).size, probe(path).frames) == (size, 23), (codec.name, size)
"""


def test_the_least_sizes_encode(tmp_path):
    """In a process of its own: x265 wrote past the end of narrow rows, and SVT-AV1 hangs below its least size."""
    code = _SMALL.format(root=str(Path(__file__).parents[2]))
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "size, slices", [((1920, 1080), 4), ((7680, 4320), 16), ((8192, 8192), 64), ((16384, 16128), 256)]
)
def test_large_lossless_films_open(size, slices):
    """FFV1 takes at most 2^22 pixels a slice."""
    film = find_format("a.mkv")
    assert film.options(size)["slices"] == str(slices)
    container = open_film(io.BytesIO(), "matroska", None, {})
    encoder_stream(container, film, size, 10, film.options(size))
    container.start_encoding()


def encoded(film, pictures):
    """The packets of one segment."""
    height, width = pictures[0].shape[:2]
    container = open_film(io.BytesIO(), "matroska", None, {})
    stream = encoder_stream(container, film, (width, height), 10, film.options((width, height)))
    packets = []
    for k, picture in enumerate(pictures):
        frame = film_frame(picture, film.pixels, film.bits)
        frame.pts = k
        packets += stream.encode(frame)
    return b"".join(bytes(packet) for packet in packets + stream.encode(None))


@pytest.mark.parametrize("kind", ["h264", "h265_10", "prores_alpha", "vp9", "av1", "ffv1_16"])
def test_the_same_pictures_make_the_same_bytes(tmp_path, kind):
    name, asked, *_ = KINDS[kind]
    film = find_format(name, **asked)
    once, again = (write(tmp_path / f"{k}{name}", film, list(moving(film, 50))) for k in "ab")
    assert hashlib.sha256(once.read_bytes()).digest() == hashlib.sha256(again.read_bytes()).digest()


PATCHES = np.array(
    [(115, 82, 68), (194, 150, 130), (98, 122, 157), (87, 108, 67), (133, 128, 177), (103, 189, 170), (214, 126, 44), (80, 91, 166),
     (193, 90, 99), (94, 60, 108), (157, 188, 64), (224, 163, 46), (56, 61, 150), (70, 148, 73), (175, 54, 60), (231, 199, 31),
     (187, 86, 149), (8, 133, 161), (243, 243, 242), (160, 160, 160), (52, 52, 52), (255, 0, 0), (0, 0, 255), (0, 255, 0)]
)  # fmt: skip


def chart(depth):
    """24 colours of 16 x 16 pixels, most of them those of a colour checker."""
    big = np.repeat(np.repeat(PATCHES.reshape(4, 6, 3), 16, axis=0), 16, axis=1)
    return big.astype(np.uint8) if depth == 8 else (big * 257).astype(np.uint16)


@pytest.mark.parametrize("kind", [k for k in KINDS if "alpha" not in k])
def test_colours_survive(tmp_path, kind):
    name, asked, *_ = KINDS[kind]
    film = find_format(name, **asked)
    path = write(tmp_path / name, film, [chart(film.depth)] * 4)
    with av.open(str(path)) as container:
        decoded = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)][-1]
    middles = decoded.reshape(4, 16, 6, 16, 3)[:, 4:12, :, 4:12].mean(axis=(1, 3)).reshape(24, 3)
    error = ciede2000(lab(middles / 255), lab(PATCHES / 255))
    assert error.mean() < 1 and error.max() < 2.5, error.round(2)


@pytest.mark.parametrize(
    "one, two, difference",  # of the published test data
    [
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, -1.3802, -84.2814), (50, 0, -82.7485), 1.0000),
        ((50, 0, 0), (50, -1, 2), 2.3669),
        ((50, 2.49, -0.001), (50, -2.49, 0.0011), 7.2195),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
        ((50, 2.5, 0), (58, 24, 15), 19.4535),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
        ((22.7233, 20.0904, -46.6940), (23.0331, 14.9730, -42.5619), 2.0373),
        ((90.8027, -2.0831, 1.4410), (91.1528, -1.6435, 0.0447), 1.4441),
        ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_the_measure_of_difference(one, two, difference):
    assert ciede2000(one, two) == pytest.approx(difference, abs=1e-4)
    assert ciede2000(two, one) == pytest.approx(difference, abs=1e-4)


def planes(frame):
    kind = np.uint16 if "10" in frame.format.name else np.uint8
    return [np.frombuffer(p, kind).reshape(p.height, -1)[:, : p.width].astype(float) for p in frame.planes]


@pytest.mark.parametrize("pixels, bits", [("yuv420p", 8), ("yuv420p10le", 10), ("yuv444p10le", 10)])
def test_luma_and_colour_are_bt709_to_half_a_code(pixels, bits):
    colours = np.random.default_rng(0).integers(0, 256, (40, 3))
    top, kind = (1, np.uint8) if bits == 8 else (257, np.uint16)
    for r, g, b in colours:
        frame = film_frame(np.full((4, 4, 3), (r * top, g * top, b * top), kind), pixels, bits)
        y = 0.2126 * r + 0.7152 * g + 0.0722 * b
        want = [16 + 219 * y / 255, 128 + 224 * (b - y) / 1.8556 / 255, 128 + 224 * (r - y) / 1.5748 / 255]
        for plane, value in zip(planes(frame), want):
            assert np.abs(plane - value * 2 ** (bits - 8)).max() <= 0.51


def test_halved_colour_lies_on_even_columns_and_between_rows():
    ramp = np.linspace(0, 65535, 64).astype(np.uint16)
    across, down = np.zeros((8, 64, 3), np.uint16), np.zeros((64, 8, 3), np.uint16)
    across[..., 2], down[..., 2] = ramp, ramp[:, None]
    column = (planes(film_frame(across, "yuv420p10le", 10))[1][2] - 512) / 448 * 63
    row = (planes(film_frame(down, "yuv420p10le", 10))[1][:, 2] - 512) / 448 * 63
    assert np.abs(column - 2 * np.arange(32))[1:].max() < 0.1
    assert np.abs(row - 2 * np.arange(32) - 0.5).max() < 0.1


def test_what_is_not_seen_does_not_tint_what_is():
    picture = np.zeros((4, 4, 4), np.uint8)
    picture[:, ::2] = (255, 0, 0, 255)
    picture[:, 1::2, 2] = 255  # blue, invisible
    _, _, cr, alpha = planes(film_frame(picture, "yuva420p", 8))
    assert np.abs(cr - (128 + 224 * (1 - 0.2126) / 1.5748)).max() < 1
    assert np.array_equal(alpha, picture[..., 3])


def alpha_of(path, codec=None):
    """Alpha of the last frame, on 0..1."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        if codec is None:
            frames = list(container.decode(stream))
        else:  # FFmpeg's own VP9 decoder leaves alpha out
            decoder = av.CodecContext.create(codec, "r")
            frames = [f for packet in container.demux(stream) for f in decoder.decode(packet)]
    plane = frames[-1].planes[3]
    kind, top = (np.uint16, 4095) if "12" in frames[-1].format.name else (np.uint8, 255)
    values = np.frombuffer(plane, kind).reshape(plane.height, -1)[:, : plane.width]
    return values / top


@pytest.mark.parametrize("name, decoder, most", [("a.mov", None, 0.004), ("a.webm", "libvpx-vp9", 0.03)])
def test_alpha_survives_prores_and_vp9(tmp_path, name, decoder, most):
    film = find_format(name, transparent=True)
    pictures = list(moving(film, 8))
    path = write(tmp_path / name, film, pictures)
    want = pictures[-1][..., 3] / (255 if film.depth == 8 else 65535)
    assert np.abs(alpha_of(path, decoder) - want).max() < most
    assert 0.2 < want.mean() < 0.9


@pytest.mark.parametrize("bits, transparent", [(8, False), (8, True), (16, False), (16, True)])
def test_ffv1_gives_back_every_bit(tmp_path, bits, transparent):
    film = find_format("a.mkv", bits=bits, transparent=transparent)
    rng = np.random.default_rng(2)
    top, kind = (256, np.uint8) if bits == 8 else (65536, np.uint16)
    pictures = [rng.integers(0, top, (9, 13, 4 if transparent else 3)).astype(kind) for _ in range(7)]
    path = write(tmp_path / "a.mkv", film, pictures)
    for picture, decoded in zip(pictures, exact(path)):
        assert np.array_equal(picture, decoded)


def exact(path):
    """A lossless film's frames as (height, width, channels), without any conversion."""
    with av.open(str(path)) as container:
        for frame in container.decode(video=0):
            if frame.format.name.startswith("gbr"):
                parts = [np.frombuffer(p, np.uint16).reshape(p.height, -1)[:, : p.width] for p in frame.planes]
                yield np.stack([parts[k] for k in (2, 0, 1, 3)[: len(parts)]], axis=2)
            else:
                plane = frame.planes[0]
                packed = np.frombuffer(plane, np.uint8).reshape(plane.height, -1)[:, : plane.width * 4]
                packed = packed.reshape(plane.height, plane.width, 4)
                yield packed[..., (2, 1, 0, 3) if frame.format.name == "bgra" else (2, 1, 0)]


def durations(path):
    with Image.open(path) as film:
        for k in range(film.n_frames):
            film.seek(k)
            film.load()
            yield film.info["duration"]


@pytest.mark.parametrize("name, fps, unit", [("a.gif", 30, 10), ("a.gif", 24, 10), ("a.webp", 30, 1)])
def test_gif_and_webp_play_all_frames_in_time(tmp_path, name, fps, unit):
    film = find_format(name)
    path = write(tmp_path / name, film, list(moving(film, 26)), fps)
    shown = np.cumsum(list(durations(path)))
    assert np.abs(shown - np.arange(1, 27) * 1000 / fps).max() <= unit / 2 + 0.5
    assert read_recipe(path) == RECIPE
    assert [p.name for p in tmp_path.iterdir()] == [name]


def test_a_gif_s_colours_serve_the_whole_film(tmp_path):
    """A colour that only the last frame has is in the palette."""
    film = find_format("a.gif")
    grey = np.repeat(np.linspace(0, 255, 64).astype(np.uint8)[None, :, None], 48, axis=0).repeat(3, axis=2)
    last = grey.copy()
    last[:, :, 1:] = 30
    path = write(tmp_path / "a.gif", film, [grey] * 30 + [last])
    with Image.open(path) as made:
        made.seek(15)
        assert np.abs(np.asarray(made.convert("RGB")).astype(int) - grey).mean() < 4
        made.seek(30)
        assert np.abs(np.asarray(made.convert("RGB")).astype(int) - last).mean() < 4


def test_animated_webp_keeps_alpha(tmp_path):
    film = find_format("a.webp", transparent=True)
    pictures = list(moving(film, 5))
    path = write(tmp_path / "a.webp", film, pictures)
    with Image.open(path) as made:
        made.seek(4)
        assert np.abs(np.asarray(made.convert("RGBA"))[..., 3].astype(int) - pictures[4][..., 3]).max() <= 2
    assert read_recipe(path) == RECIPE


@pytest.mark.parametrize("fps", [24, 29.97, 30, 60, 12.5, 1 / 3])
def test_frame_rates(tmp_path, fps):
    path = tmp_path / "a.mp4"
    writer = film_writer(path, (32, 32), fps)
    for k in range(6):
        writer.add(np.full((32, 32, 3), 40 * k, np.uint8))
    writer.close()
    found = probe(path)
    assert found.fps == pytest.approx(fps) and found.frames == 6 and found.duration == pytest.approx(6 / fps, rel=1e-6)


@pytest.mark.parametrize(
    "name, asked, words",
    [
        ("a.mp4", {"size": (641, 360)}, "640x360 and 642x360"),
        ("a.webm", {"size": (641, 361)}, "640x360 and 642x362"),
        ("a.mp4", {"size": (1, 2)}, r"H\.264 is at least 2x2 pixels, not 1x2"),
        ("a.mp4", {"codec": "h265", "size": (64, 14)}, r"H\.265 is at least 16x16"),
        ("a.mp4", {"codec": "h265", "size": (16384, 8706)}, "at most 142606336 pixels"),
        ("a.mp4", {"codec": "av1", "size": (30, 64)}, "AV1 is at least 32x32"),
        ("a.mp4", {"codec": "av1", "size": (8704, 16384)}, "AV1 is at most 16384x8704"),
        ("a.mkv", {"size": (2, 1)}, "FFV1 is at least 2x2"),
        ("a.mkv", {"size": (16384, 16384)}, "16384 pixels wide is at most 16128 high"),
        ("a.mov", {"codec": "h264", "size": (2, 3)}, "2x2 and 2x4"),
        ("a.webp", {"size": (16384, 2)}, "16383"),
        ("a.mp4", {"codec": "h256"}, "did you mean 'h265'"),
        ("a.mp4", {"codec": "divx"}, "h264, h265, prores, ffv1, vp9, av1"),
        ("a.mp4", {"codec": "prores"}, r"ProRes 4444 needs the extension \.mov; \.mp4 takes h264 or h265 or av1"),
        ("a.mov", {"codec": "ffv1"}, r"\.mkv"),
        ("a.gif", {"codec": "h264"}, r"\.gif takes no --codec"),
        ("a.mp4", {"profile": "best"}, "preview, web, master"),
        ("a.mp4", {"bits": 12}, "8 or 10 bits"),
        ("a.webm", {"bits": 10}, "VP9 has 8 bits"),
        ("a.mov", {"bits": 8}, "10 bits"),
        ("a.mp4", {"transparent": True}, r"H\.264 cannot be transparent; prores \(\.mov\)"),
        ("a.avi", {}, r"\.mp4 \.mov \.webm"),
    ],
)
def test_what_does_not_go_together_is_refused_with_what_does(name, asked, words):
    with pytest.raises(UsageError, match=words):
        find_format(name, **asked)


def test_odd_sizes_are_fine_where_colour_is_whole(tmp_path):
    for name in ("a.mov", "a.mkv", "a.gif"):
        film = find_format(name)
        assert probe(write(tmp_path / name, film, list(moving(film, 3, (33, 21))))).size == (33, 21), name
    film = find_format("a.webp")
    assert Image.open(write(tmp_path / "a.webp", film, list(moving(film, 3, (33, 21))))).size == (33, 21)


def test_a_table_of_formats_needs_no_encoder():
    code = "import sys, gen_art.output.target, gen_art.output.formats, gen_art.output.stills; assert 'av' not in sys.modules and 'OpenEXR' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=Path(__file__).parents[2])
