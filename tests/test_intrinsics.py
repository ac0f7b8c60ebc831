"""Asking for memory ahead and packing change no result, harm at no address, and say nothing."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gen_art.backend import intrinsics, runtime
from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.direct_splat import discs, pixels, points
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.sprite import BLUE, FOOTPRINT, RED, X, Y

ROOT = Path(__file__).resolve().parents[1]
FOLDER = Path(intrinsics.__file__).parent
SCRIPT = """
import numpy as np
from gen_art.backend import runtime
from gen_art.backend.intrinsics import prefetch
from gen_art.backend.runtime import kernel, ti

@ti.kernel
def _sums(x: ti.types.ndarray(ti.f32, 1), memory: ti.i64):
    for side in range(2):
        for i in range(500):
            prefetch(memory + ti.cast(i, ti.i64) * 64)
            prefetch(ti.cast(i - 250, ti.i64) << 55)
            x[side * 500 + i] += 1.0

runtime.init(threads=2)
sums = kernel(_sums)
x = np.arange(1000, dtype=np.float32)
sums(x, x.ctypes.data)
sums(x, 0)
assert (x == np.arange(1000) + 2).all()
"""


def ran(script: str, folder: Path):
    """A process of its own, with a cold cache: LLVM would warn of what it links while it compiles."""
    path = folder / "script.py"
    path.write_text(script)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "GEN_ART_CACHE": str(folder / "cache")}
    return subprocess.run([sys.executable, str(path)], env=environment, capture_output=True, text=True)


def test_asking_changes_nothing_harms_nowhere_and_prints_nothing(tmp_path):
    done = ran(SCRIPT, tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.skipif(not intrinsics.HAS_PACK, reason="this processor cannot")
def test_packing_keeps_the_marked_in_order():
    @ti.kernel
    def _packed(marks: ti.i64, words: ti.i64, to: ti.i64, parts: ti.i32, counts: ti.types.ndarray(ti.i32, 1)):
        for turn in range(1):
            count = 3
            for part in range(parts):
                at = ti.cast(part, ti.i64) * 128
                intrinsics.pack(marks + at, words + at, to, count)
            counts[turn] = count

    rng = np.random.default_rng(0)
    marks, words = runtime.aligned((320,), np.int32), runtime.aligned((320,), np.int32)
    marks[:] = rng.integers(0, 3, 320) * rng.integers(-5, 5, 320)
    words[:] = rng.integers(-(2**31), 2**31, 320)
    list, counts = runtime.aligned((400,), np.int32), np.zeros(1, np.int32)
    list[:] = -7
    kernel(_packed)(marks.ctypes.data, words.ctypes.data, list.ctypes.data, 10, counts)
    wanted = words[marks != 0]
    assert counts[0] == 3 + len(wanted) and 100 < len(wanted) < 300
    assert (list[:3] == -7).all() and (list[3 : counts[0]] == wanted).all() and (list[counts[0] + 16 :] == -7).all()


DRAWN = """
from gen_art.backend import intrinsics
intrinsics.HAS_PACK = intrinsics.HAS_PREFETCH = intrinsics.HAS_LANES = False
from tests.test_intrinsics import drawn
from gen_art.backend import runtime
runtime.init(threads=2)
print(drawn())
"""


def drawn() -> str:
    """The digest of a framebuffer with points of both kinds and discs, many of them outside of it."""
    n, framebuffer = 50_001, FrameBuffer((301, 203))
    channels = runtime.aligned((11, 50_048), np.float32)
    rng = np.random.default_rng(1)
    channels[X], channels[Y] = rng.normal(150, 100, channels.shape[1]), rng.normal(100, 60, channels.shape[1])
    channels[RED : BLUE + 1] = rng.random((3, channels.shape[1]))
    pixels(channels, n, framebuffer)
    points(channels, n, framebuffer)
    channels[FOOTPRINT] = rng.uniform(0.5, 4.0, channels.shape[1])
    discs(channels, n, framebuffer)
    return hashlib.sha256(framebuffer.buffer.tobytes()).hexdigest()


def test_a_processor_without_them_draws_the_same(tmp_path):
    done = ran(DRAWN, tmp_path)
    assert (done.stdout.strip(), done.stderr) == (drawn(), "")


@pytest.mark.parametrize("name, functions", [("prefetch", 1), ("pack", 1), ("lanes", 4)])
def test_the_bitcode_is_what_its_source_says(name, functions):
    """Both are read by LLVM 15, that of Taichi, and shown as text."""
    import llvmlite.binding as llvm

    def shown(module) -> list[str]:
        return [line for line in str(module).splitlines() if not line.startswith(("; ModuleID", "source_filename"))]

    source = (FOLDER / f"{name}.ll").read_text(encoding="utf-8")
    bitcode = shown(llvm.parse_bitcode((FOLDER / f"{name}.bc").read_bytes()))
    assert shown(llvm.parse_assembly(source)) == bitcode
    assert sum("define void @gen_art_" in line for line in bitcode) == functions
    changed = (
        source.replace("i32 2, i32 1", "i32 3, i32 1")
        .replace("i64 %bits.wide", "i64 0")
        .replace("add i64 %marks, 64", "add i64 %marks, 32")
        .replace("add i64 %address, 32", "add i64 %address, 64")
    )
    assert shown(llvm.parse_assembly(changed)) != bitcode  # the mutant
