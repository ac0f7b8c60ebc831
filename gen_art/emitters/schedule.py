"""When particles are born: exact times that do not depend on the time step.

The k-th birth of a rate happens when the integral of the rate reaches k + 1/2. Births that share a moment (`at`, with a
count) carry on the numbering. A schedule answers two questions: how many births lie at or before a time, and when each is.
"""

from typing import NamedTuple

import numpy as np

from gen_art.errors import UsageError

__all__ = ["Burst", "Pulse", "Rate", "Schedule"]


class Schedule:
    """`until(t)`: how many births at or before t. `times(first, last)`: the times of births first .. last - 1, in s."""

    def until(self, t: float) -> int:
        raise NotImplementedError

    def times(self, first: int, last: int) -> np.ndarray:
        raise NotImplementedError


class Pulse(NamedTuple):
    """Puffs: births of a steady rate, moved about the beginning of their period (s).

    Their times are shifted by -depth sin(2 pi t / period) period / (2 pi), depth in [0, 1), and what is then within half a
    period of the beginning is pressed into the part `duty`, in (0, 1]; the rest of the period has no births.
    """

    period: float
    depth: float = 0.0
    duty: float = 1.0

    def shifted(self, t):
        """When a birth comes that a steady rate would have at t."""
        beginning = self.period * np.round(t / self.period)
        return beginning + self.duty * (
            t - beginning - self.depth * np.sin(2 * np.pi * t / self.period) * (self.period / (2 * np.pi))
        )

    def steady(self, t: float) -> float:
        """The last steady time that is shifted to t or before, by bisection."""
        low, high = t - self.period, t + self.period
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.shifted(middle) <= t else (low, middle)
        return low


class Rate(Schedule):
    """A rate in 1/s, constant or piecewise linear in time: points ((time, rate), ...), held before the first and after the last.

    Births begin at `start` and end before `stop` (s). A `pulse` gathers them, the mean rate kept.
    Raises UsageError for a negative or infinite rate.
    """

    def __init__(self, rate, start: float = 0.0, stop: float | None = None, pulse: Pulse | None = None):
        self._pulse = pulse
        points = [(start, float(rate))] if np.ndim(rate) == 0 else [(float(t), float(r)) for t, r in rate]
        if not all(np.isfinite(r) and r >= 0 for _, r in points):
            raise UsageError("a rate must be a finite number of at least 0 per second")
        t, r = np.array(points, np.float64).T
        if len(t) > 1:  # cut or extend to begin at `start`
            r_start = np.interp(start, t, r)
            later = t > start
            t, r = np.append(start, t[later]), np.append(r_start, r[later])
        self._t, self._r = t, r
        self._sum = np.append(0.0, np.cumsum(0.5 * (r[1:] + r[:-1]) * np.diff(t)))
        self._last = None if stop is None else self._until(np.nextafter(stop, -np.inf))

    def _until(self, t: float) -> int:
        moment = t
        if self._pulse:
            t = self._pulse.steady(t)
        if t < self._t[0]:
            return 0
        k = int(np.searchsorted(self._t, t, "right")) - 1
        s = t - self._t[k]
        slope = (self._r[k + 1] - self._r[k]) / (self._t[k + 1] - self._t[k]) if k + 1 < len(self._t) else 0.0
        guess = int(np.floor(self._sum[k] + s * (self._r[k] + 0.5 * slope * s) + 0.5))
        near = np.arange(max(guess - 2, 0), guess + 3)  # the times themselves decide, so that every dt agrees
        return int(near[0] + np.count_nonzero(self.times(int(near[0]), int(near[-1]) + 1) <= moment))

    def until(self, t):
        count = self._until(t)
        return count if self._last is None else min(count, self._last)

    def times(self, first, last):
        target = np.arange(first, last) + 0.5
        k = np.minimum(np.searchsorted(self._sum, target, "left") - 1, len(self._t) - 1).clip(0)
        rest, rate = target - self._sum[k], self._r[k]
        following = np.minimum(k + 1, len(self._t) - 1)
        width = np.where(following > k, self._t[following] - self._t[k], 1.0)
        slope = np.where(following > k, (self._r[following] - rate) / width, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(rate * rate + 2.0 * slope * rest, 0.0))
            s = 2.0 * rest / (rate + root)  # the stable root of rate s + slope s^2 / 2 = rest
        t = np.where(rate + root > 0, self._t[k] + s, np.inf)
        return (
            t
            if self._pulse is None
            else np.where(np.isfinite(t), self._pulse.shifted(np.where(np.isfinite(t), t, 0.0)), t)
        )


class Burst(Schedule):
    """`count` births (a whole number, or one number per time) at each of the times `at`, in s."""

    def __init__(self, at=(0.0,), count=1):
        self._at = np.sort(np.atleast_1d(np.asarray(at, np.float64)))
        counts = np.broadcast_to(np.asarray(count, np.int64), self._at.shape)
        if np.any(counts < 0):
            raise UsageError("a count must be at least 0")
        self._ends = np.cumsum(counts)

    def until(self, t):
        k = int(np.searchsorted(self._at, t, "right"))
        return int(self._ends[k - 1]) if k else 0

    def times(self, first, last):
        return self._at[np.searchsorted(self._ends, np.arange(first, last), "right")]
