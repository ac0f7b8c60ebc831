"""How much memory this process can still allocate: the machine's, its control groups' and its own limits (Linux).

A control group (cgroup) limits a container or a job; groups are nested, and the tightest one counts.
"""

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

__all__ = ["available_memory", "installed_memory", "out_of_memory"]

_UNLIMITED = 2**60  # bytes; version 1 writes a number of this order for "no limit"
_UNKNOWN = 8e9  # bytes assumed where nothing is known
_NO_MEMORY = (
    "cannot allocate memory",
    "out of memory",
    "bad_alloc",
    "not enough memory",
    "memory allocation",
    "failed to map segment",
)


def available_memory(root: Path = Path("/")) -> float:
    """Bytes that this process can still allocate.

    root : the folder that holds proc/ and sys/
    """
    limits = [*_machine(root), *_groups(root), *_process(root)]
    return max(0.0, min(limits)) if limits else _UNKNOWN


def installed_memory() -> float:
    """Bytes of the machine's memory; 0 where that is not known."""
    with suppress(OSError, ValueError, AttributeError):
        return float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    return 0.0


def out_of_memory(error: BaseException) -> bool:
    """Whether an error of any library says that there is no memory."""
    words = str(error).lower()
    return isinstance(error, MemoryError) or any(sign in words for sign in _NO_MEMORY)


def _machine(root: Path) -> Iterator[float]:
    with suppress(OSError, ValueError, IndexError):
        for line in (root / "proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable"):
                yield float(line.split()[1]) * 1024
                return
    if total := installed_memory():
        yield total


def _groups(root: Path) -> Iterator[float]:
    """What each control group of this process has left, from its own up to the outermost."""
    with suppress(OSError):
        for line in (root / "proc/self/cgroup").read_text().splitlines():
            _, controllers, path = line.split(":", 2)
            if controllers == "":
                mount, limit, used = root / "sys/fs/cgroup", "memory.max", "memory.current"
            elif "memory" in controllers.split(","):
                mount, limit, used = root / "sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
            else:
                continue
            parts = Path(path.lstrip("/")).parts
            for depth in range(
                len(parts), -1, -1
            ):  # inside a container the path may be the host's: folders that exist count
                yield from _left(mount.joinpath(*parts[:depth]), limit, used)


def _left(group: Path, limit: str, used: str) -> Iterator[float]:
    with suppress(OSError, ValueError):
        most = float((group / limit).read_text())  # "max" is no number: no limit
        if most < _UNLIMITED:
            yield most - float((group / used).read_text()) + _reclaimable(group)


def _reclaimable(group: Path) -> float:
    """Bytes of files that the kernel keeps in memory for the group and drops when memory is needed."""
    with suppress(OSError, ValueError, IndexError):
        for line in (group / "memory.stat").read_text().splitlines():
            name, number = line.split()
            if name in ("inactive_file", "total_inactive_file"):
                return float(number)
    return 0.0


def _process(root: Path) -> Iterator[float]:
    """What `ulimit -v` and `ulimit -d` leave."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    with suppress(OSError, ValueError, IndexError):
        pages = (root / "proc/self/statm").read_text().split()
        page = os.sysconf("SC_PAGE_SIZE")
        for which, taken in ((resource.RLIMIT_AS, pages[0]), (resource.RLIMIT_DATA, pages[5])):
            limit = resource.getrlimit(which)[0]
            if limit != resource.RLIM_INFINITY:
                yield limit - float(taken) * page
