"""The processor: its name, its vector instructions, and the cores that this process may use."""

import contextlib
import os
import platform
from functools import lru_cache
from itertools import takewhile

__all__ = ["cores", "flags", "lines", "name", "vectors"]

_AVX512 = {"avx512f", "avx512dq", "avx512bw", "avx512vl"}  # the parts that kernels use together


@lru_cache(1)
def lines() -> list[str]:
    """The lines of /proc/cpuinfo with the first processor's name and instruction sets ("flags"); none on other systems."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as rows:
        return [row for row in takewhile(str.strip, rows) if row.startswith(("model name", "flags"))]
    return []


def name() -> str:
    """The processor's name, or "unknown"."""
    names = [line.split(":", 1)[1].strip() for line in lines() if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine() or "unknown"


def flags() -> set[str]:
    """The names of the instruction sets, as Linux writes them; empty where they are not known."""
    return set("".join(lines()).split())


def vectors() -> list[str]:
    """The vector instructions that matter for speed: of AVX2, AVX-512 and NEON those that the processor has."""
    known = flags()
    found = [title for title, parts in (("AVX2", {"avx2"}), ("AVX-512", _AVX512)) if parts <= known]
    return [*found, "NEON"] if platform.machine() in ("arm64", "aarch64") else found


def cores() -> int:
    """The number of cores on which this process may run."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
