"""Asking for memory ahead changes no result, harms at no address, and says nothing."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gen_art import prefetch

SCRIPT = """
import numpy as np
from gen_art import runtime
from gen_art.prefetch import prefetch
from gen_art.runtime import kernel, ti

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


def test_it_changes_nothing_harms_nowhere_and_prints_nothing(tmp_path):
    """In a process with a cold cache: LLVM would warn of what it links while it compiles."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    root = Path(__file__).resolve().parents[1]
    environment = {**os.environ, "PYTHONPATH": str(root), "GEN_ART_CACHE": str(tmp_path / "cache")}
    ran = subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True)
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")


@pytest.mark.skipif(not shutil.which("llvm-dis"), reason="needs LLVM's tools")
def test_the_bitcode_is_what_its_source_says():
    shown = subprocess.run(["llvm-dis", "-o", "-", str(prefetch._BITCODE)], capture_output=True, text=True, check=True)
    source = prefetch._BITCODE.with_suffix(".ll").read_text()

    def calls(text):
        return re.findall(r"call void @llvm\.prefetch\.\w+\(.*?(i32 \d, i32 \d, i32 \d)\)", text)

    layout = re.findall("target datalayout.*", source)
    assert re.findall("target datalayout.*", shown.stdout) == layout != []
    assert calls(shown.stdout) == calls(source) == ["i32 0, i32 2, i32 1"]
    assert "gen_art_prefetch(" in shown.stdout
