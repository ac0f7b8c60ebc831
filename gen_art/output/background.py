"""Calls that run behind the main thread: pictures are compressed while the next one is computed."""

import contextlib
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

__all__ = ["background"]

_MOST = 8


@contextlib.contextmanager
def background() -> Iterator[Callable]:
    """Run calls on as many threads as there are processors (2 to 8), with as many more waiting; order does not matter.

    The first error is raised where a later call is made, or at the end.
    """
    workers = max(2, min(_MOST, os.cpu_count() or 1))
    with ThreadPoolExecutor(workers, thread_name_prefix="gen-art-output") as pool:
        waiting: list = []

        def submit(function, *args) -> None:
            while len(waiting) >= 2 * workers:
                waiting.pop(0).result()
            waiting.append(pool.submit(function, *args))

        try:
            yield submit
            for one in waiting:
                one.result()
        finally:
            for one in waiting:
                one.cancel()
