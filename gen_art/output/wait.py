"""How long the simulation before the first picture takes: told once that is known, where it is long."""

import time
from collections.abc import Callable

__all__ = ["Wait"]

_LONG = 10.0  # s: shorter waits are not told
_SOON = 1.0  # s after which the rest is estimated, and between two estimates


class Wait:
    """Advances a simulation to its first picture, and tells what is left of the wait.

    tell : called with {"event": "wait", "steps", "of", "eta"}: steps done, steps in all, seconds left by the pace of the last
        second; never called if less than 10 s are left
    steps : the steps before the first picture
    """

    def __init__(self, tell: Callable[[dict], None], steps: int):
        self._tell, self._of, self._done = tell, steps, 0
        self._long = self._seemed_long = False

    def advance(self, step: Callable[[int], None], steps: int) -> None:
        """Call `step` with numbers of steps that are `steps` in all."""
        some = 1
        while steps > 0:
            some = min(some, steps)
            began = time.perf_counter()
            step(some)
            taken = time.perf_counter() - began
            first, self._done, steps = self._done == 0, self._done + some, steps - some
            left = taken / some * (self._of - self._done)
            if first:
                continue  # its time is that of births and of loading kernels, too
            # twice: a kernel may have been loaded meanwhile
            self._long, self._seemed_long = self._long or (self._seemed_long and left > _LONG), left > _LONG
            if self._long and taken > 0.5 * _SOON:
                self._tell({"event": "wait", "steps": self._done, "of": self._of, "eta": left})
            some = max(1, min(2 * some, round(some * _SOON / max(taken, 1e-9))))
