"""Runs calls on other threads: pictures are compressed and written while the next one is computed."""

import contextlib
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

__all__ = ["background"]

_MOST_WORKERS = 8


@contextlib.contextmanager
def background() -> Iterator[Callable]:
    """Yield a function that runs a call on a pool of threads: one thread a processor, at least 2 and at most 8.

    At most two calls a thread are unfinished at once; a further call waits. Calls may finish in any order. The first error
    is raised by a later call, or at the end.
    """
    workers = max(2, min(_MOST_WORKERS, os.cpu_count() or 1))
    with ThreadPoolExecutor(workers, thread_name_prefix="gen-art-output") as pool:
        calls: list = []

        def submit(function, *args) -> None:
            while len(calls) >= 2 * workers:
                calls.pop(0).result()
            calls.append(pool.submit(function, *args))

        try:
            yield submit
            for call in calls:
                call.result()
        finally:
            for call in calls:
                call.cancel()
