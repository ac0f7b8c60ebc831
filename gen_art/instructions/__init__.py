"""What processors can do and Taichi (1.7.4, which is pinned) has no words for: ask for memory ahead, pack what is marked.

Taichi links functions from LLVM's bitcode into kernels: each .bc file here is one, assembled from the .ll file beside it and
laid out for Linux on x86-64. Where one cannot run, a kernel does without it: no result depends on them.
"""

import contextlib
import platform
from pathlib import Path

from taichi._lib import core
from taichi.lang.expr import make_expr_group

from gen_art.runtime import impl
from gen_art.tracing import traced

__all__ = ["PACKS", "PREFETCHES", "pack", "prefetch"]


def _features() -> set[str]:
    """What this processor says that it can do."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("flags"):
                return set(line.split())
    return set()


PREFETCHES = (platform.system(), platform.machine()) == ("Linux", "x86_64")
PACKS = PREFETCHES and {"avx512f", "avx512dq", "avx512bw", "avx512vl", "popcnt"} <= _features()


def _call(name: str, *variables) -> None:
    runtime = impl.get_runtime()
    runtime.compiling_callable.ast_builder().insert_external_func_call(
        0, "", str(Path(__file__).with_name(f"{name}.bc")), f"gen_art_{name}", make_expr_group(variables), make_expr_group([]),
        core.DebugInfo(runtime.get_current_src_info()),
    )  # fmt: skip


@traced
def prefetch(address):
    """Ask for the 64 bytes around an address, a 64-bit whole number, if PREFETCHES. No address is wrong."""
    if PREFETCHES:
        _call("prefetch", impl.expr_init(address))


@traced
def pack(marks, words, to, count):
    """Write those of 32 words that are marked, one after the other, to word `count` of a list and on, and add to `count`.

    marks, words : addresses of 32 words each, at whole vectors; a mark other than 0 says that the word is meant
    to           : address of the list. Up to sixteen words behind the last may be written over
    count        : a variable of 32 bits. Taichi does not see it change: read it after the loop that packs, not within

    Only if PACKS.
    """
    _call("pack", impl.expr_init(marks), impl.expr_init(words), impl.expr_init(to), count)
