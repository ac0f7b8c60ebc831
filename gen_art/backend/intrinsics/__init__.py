"""What processors can do and Taichi (1.7.4, which is pinned) has no words for: ask for memory ahead, pack what is marked.

Taichi links functions from LLVM's bitcode into kernels: each .bc file here is one, assembled from the .ll file beside it and
laid out for Linux on x86-64. Where one cannot run, a kernel does without it: no result depends on them. Kernels that were kept
know a function by its file and name: one that changes needs another name.
"""

import platform
from pathlib import Path

from gen_art.backend import processor
from gen_art.backend.kernel_views import traced
from gen_art.backend.runtime import STOCK_TAICHI, call_bitcode

__all__ = ["HAS_LANES", "HAS_PACK", "HAS_PREFETCH", "load_lanes", "pack", "prefetch", "store_lanes"]


_FOLDER = Path(__file__).parent
HAS_PREFETCH = not STOCK_TAICHI and (platform.system(), platform.machine()) == ("Linux", "x86_64")
HAS_LANES = HAS_PREFETCH
HAS_PACK = HAS_PREFETCH and "AVX-512" in processor.vectors() and "popcnt" in processor.flags()


@traced
def prefetch(address):
    """Ask for the 64 bytes around an address, a 64-bit whole number, if HAS_PREFETCH. Any address is allowed."""
    if HAS_PREFETCH:
        call_bitcode(_FOLDER / "prefetch.bc", "gen_art_prefetch", [address])


@traced
def pack(marks, words, to, count):
    """Write those of 32 words that are marked, one after the other, to word `count` of a list and on, and add to `count`.

    marks, words : addresses of 32 words each, at whole vectors; a mark other than 0 says that the word is meant
    to           : address of the list. Up to sixteen words behind the last may be written over
    count        : a variable of 32 bits. Read it after the loop that packs, not within

    Only where HAS_PACK.
    """
    call_bitcode(_FOLDER / "pack.bc", "gen_art_pack", [marks, words, to], [count])


@traced
def load_lanes(address, lanes, wide: bool):
    """Read a local vector of sixteen floats from an address, a 64-bit whole number, which need not be at a whole vector.

    wide : whether they are float64
    Read the vector in a later loop only, but read it: Taichi stops at one that is only loaded. Only where HAS_LANES.
    """
    call_bitcode(_FOLDER / "lanes.bc", "gen_art_load_f64" if wide else "gen_art_load_f32", [address], [lanes])


@traced
def store_lanes(address, lanes, wide: bool):
    """Write such a vector to an address. Only where HAS_LANES."""
    call_bitcode(_FOLDER / "lanes.bc", "gen_art_store_f64" if wide else "gen_art_store_f32", [address], [lanes])
