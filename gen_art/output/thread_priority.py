"""Keeps the priority of the process's threads, which SVT-AV1 raises.

Run by root on Linux, it gives the thread that opens an encoder, and its own threads, a real-time priority. All that is started
later inherits it, and other programs hardly get a turn.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress

__all__ = ["kept_priority"]

_THREADS = "/proc/self/task"


@contextmanager
def kept_priority() -> Iterator[None]:
    """Give all threads of this process the scheduling policy back that the calling thread has before the block."""
    if not hasattr(os, "sched_getscheduler") or not os.path.isdir(_THREADS):
        yield
        return
    policy, priority = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        yield
    finally:
        for thread in map(int, os.listdir(_THREADS)):
            with suppress(OSError):  # it has ended, or nothing may be changed
                if os.sched_getscheduler(thread) != policy:
                    os.sched_setscheduler(thread, policy, priority)
