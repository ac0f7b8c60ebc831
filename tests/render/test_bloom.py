"""Bloom: halos keep the sum, are round, and mean the same at any size and place; tiny pictures stay within their memory."""

import os
import subprocess
import sys

import numpy as np
import pytest

from gen_art.preset.develop import DevelopSpec
from gen_art.renderer import resample
from gen_art.renderer.bloom import glare, level_weights
from gen_art.renderer.resample import PAD, level_taps, vector_taps
from gen_art.renderer.tone_map import develop

SHAPES = [(90, 160), (37, 61), (8, 8), (5, 3), (1, 1), (1, 50), (28, 48), (450, 33), (831, 65), (720, 1280)]


@pytest.mark.parametrize("shape", SHAPES)
def test_bloom_keeps_the_sum_at_any_size(shape):
    linear = np.random.default_rng(1).exponential(1.0, (*shape, 4)).astype(np.float32)
    linear[0, 0, :3] = 1000.0
    for radius in (0.0, 0.5, 1.0):
        assert glare(linear, radius)[..., :3].sum((0, 1), dtype=np.float64) == pytest.approx(
            linear[..., :3].sum((0, 1), dtype=np.float64), rel=1e-5
        )
    assert level_weights(shape[0], 0.5).sum() == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("shape", SHAPES)
def test_even_light_stays_even(shape):
    assert np.abs(glare(np.ones((*shape, 4), np.float32), 1.0)[..., :3] - 1.0).max() < 1e-5


def test_developing_keeps_the_sum_of_bloomed_light():
    """For a tall picture the tone map kernel does the last step of bloom: its light adds up too."""
    for shape in ((300, 64), (900, 64), (901, 63)):
        linear = np.zeros((*shape, 4), np.float32)
        linear[shape[0] // 3, 20, :3] = 300.0
        linear[-1, -1, :3] = 50.0
        picture = develop(linear, DevelopSpec(tone="none", bloom=0.5, exposure=-4), bits=16) / 65535
        light = np.where(picture <= 0.04045, picture / 12.92, ((picture + 0.055) / 1.055) ** 2.4) * 16
        seen = glare(linear, 0.5) * 0.5 + linear * 0.5
        assert np.abs(light - np.minimum(seen[..., :3], 16.0)).max() < 3e-3 * 16
        dim = seen[..., 0] < 16
        assert light[dim].sum() == pytest.approx(seen[dim][..., :3].sum(dtype=np.float64), rel=0.02)


@pytest.mark.parametrize(("length", "scale", "border"), [(1920, 4, 0), (1280, 2, 0), (480, 2, PAD), (240, 0, PAD)])
def test_most_windows_of_a_row_share_their_vectors(length, scale, border):
    """Going down by a scale, and up (0): all but those at a row's ends, or it would take twice as long."""
    ((_, down, up),) = level_taps(length if scale else 2 * length, [scale or 2])
    taps = (down if scale else up).bordered()
    weights_start = vector_taps(taps, border, -(-(length + 8) // 16) * 4, -(-len(taps.first) // 16) * 4).weights_start[
        : len(taps.first) // 4
    ]
    assert (weights_start >= 0).mean() > 0.95


def test_a_halo_made_before_taichi_runs_has_room(monkeypatch):
    monkeypatch.setattr(resample, "threads", lambda: 0)
    assert len(resample.ring_buffer(16, 4, 10**6)) > 0


def halo(rows: int, k: int, radius: float) -> np.ndarray:
    """A square of light 1 in a picture of k x `rows` rows, as light a pixel of `rows` rows."""
    width = rows * 16 // 9
    linear = np.zeros((rows * k, width * k, 4), np.float32)
    linear[rows // 2 * k : (rows // 2 + 1) * k, width // 2 * k : (width // 2 + 1) * k, :3] = 1.0 / k**2
    return glare(linear, radius)[..., 0].reshape(rows, k, width, k).sum(axis=(1, 3))


@pytest.mark.parametrize(("rows", "k", "bound"), [(180, 4, 0.35), (270, 2, 0.2), (360, 2, 0.15), (540, 2, 0.03)])
def test_bloom_looks_the_same_at_any_size(rows, k, bound):
    """The sum of all differences, as a share of the light: at 180 rows three of the seven halos are within a pixel."""
    one, other = halo(rows, 1, 0.6), halo(rows, k, 0.6)
    assert np.abs(one - other).sum() < bound * one.sum()
    y, x = np.indices(one.shape)
    distance = np.hypot(y - rows // 2, x - one.shape[1] // 2)
    for share in (0.02, 0.05, 0.1, 0.2):
        within = distance < share * rows
        assert one[within].sum() == pytest.approx(other[within].sum(), abs=0.02), "as much light within a circle"


@pytest.mark.parametrize("rows", [200, 450, 820])
def test_halos_are_round_and_the_same_wherever_a_point_lies(rows):
    own, halos = level_weights(rows, 0.6)[0], []
    for dy, dx in ((0, 0), (1, 0), (0, 3), (2, 1), (3, 2), (4, 4)):
        linear = np.zeros((rows, 400, 4), np.float32)
        y, x = rows // 2 + dy, 200 + dx
        linear[y, x, :3] = 1.0
        light = glare(linear, 0.6)[..., 0]
        light[y, x] -= own
        halos.append(light[y - 60 : y + 61, x - 60 : x + 61])
    peak = halos[0].max()
    assert np.ptp(halos, axis=0).max() < 0.01 * peak
    assert max(np.abs(h - h.T).max() for h in halos) < 0.01 * peak
    ring = [halos[0][60 + dy, 60 + dx] for dy, dx in ((0, 25), (15, 20), (20, 15), (25, 0), (-7, 24))]
    assert np.ptp(ring) < 0.05 * np.mean(ring), "round"


CHECKED = """
import numpy as np
from gen_art.backend import runtime
from gen_art.backend.runtime import ti, kernel
runtime.init("cpu", 2)
from gen_art.preset.develop import DevelopSpec
from gen_art.renderer.tone_map import develop
for height, width in ((1, 1), (5, 3), (28, 48), (1, 50), (3, 21), (401, 7), (820, 5), (801, 33)):
    for transparent in (False, True):
        develop(np.ones((height, width, 4), np.float32), DevelopSpec(grain=0.1, vignette=1), transparent=transparent)

@ti.kernel
def beyond(a: ti.types.ndarray(ti.f32, 1)) -> ti.f32:
    return a[a.shape[0]]

try:
    kernel(beyond)(np.zeros(5, np.float32))
except ti.TaichiAssertionError:
    raise SystemExit(7)
"""


def test_nothing_is_read_or_written_beyond_an_array(tmp_path):
    """Taichi checks each index of each array when it debugs; the last kernel, which reads beyond, proves that it does."""
    script = tmp_path / "checked.py"  # a kernel's source is read from its file
    script.write_text(CHECKED)
    environment = dict(os.environ, TI_DEBUG="1", GEN_ART_CACHE=str(tmp_path), PYTHONPATH=os.pathsep.join(sys.path))
    done = subprocess.run(
        [sys.executable, str(script)], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    assert done.returncode == 7, done.stderr[-600:]


def test_nothing_is_written_beside_a_picture():
    for height, width in ((1, 1), (5, 3), (28, 48), (820, 5)):
        for channels, transparent in ((3, False), (4, True)):
            linear = np.full((height + 2, width + 40, 4), np.nan, np.float32)
            inner = linear[1:-1, 8 : 8 + width]
            inner[:] = 0.5
            kept = np.full(height * width * channels + 128, 77, np.uint8)
            out = kept[64:-64].reshape(height, width, channels)
            develop(inner, transparent=transparent, out=out)
            assert (kept[:64] == 77).all() and (kept[-64:] == 77).all()
            assert np.ptp(out.astype(int), axis=(0, 1)).max() <= 1, "and nothing beside the picture is read"
            assert np.isnan(linear).sum() == linear.size - inner.size


def test_bloom_leaves_alpha_as_it_is():
    for height, width in ((60, 80), (30, 37), (820, 33)):
        linear = np.zeros((height, width, 4), np.float32)
        linear[..., 3] = np.random.default_rng(6).random((height, width))
        clear = develop(linear, DevelopSpec(bloom=0.5), transparent=True, bits=16)[..., 3] / 65535
        assert np.abs(clear - linear[..., 3]).max() < 2e-5
