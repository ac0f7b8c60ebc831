"""Where the time of a render goes."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["STAGES", "Stopwatch"]

STAGES = ("simulate", "draw", "develop", "encode")


class Stopwatch:
    """Adds up the seconds that each stage takes.

    seconds : by stage; what belongs to no stage, such as compiling the first kernels before a stage begins, is in none
    """

    def __init__(self):
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._begin = time.perf_counter()

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of the block."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - begin

    @property
    def total(self) -> float:
        """Seconds since it was made."""
        return time.perf_counter() - self._begin
