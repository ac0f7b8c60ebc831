"""Schedules: when particles are born, at exact times that do not depend on the time step.

The k-th birth of a rate happens when the integral of the rate reaches k + 1/2. Births at the same time (`at`, with a count) have
consecutive numbers. A schedule answers two questions: how many births lie at or before a time, and when each one is.
"""

import math
from bisect import bisect_left, bisect_right
from typing import NamedTuple

import numpy as np

from gen_art.errors import UsageError
from gen_art.maths.array_functions import sin

__all__ = ["Burst", "Pulse", "Rate", "Schedule"]


class Schedule:
    """The contract of a schedule.

    until(t) : how many births are at or before t
    times(first, last) : the times of births first .. last - 1, float64, in s
    """

    def until(self, t: float) -> int:
        raise NotImplementedError

    def times(self, first: int, last: int) -> np.ndarray:
        raise NotImplementedError


class Pulse(NamedTuple):
    """Puffs: the births of a steady rate, moved towards the start of their period.

    Their times are shifted by -depth sin(2 pi t / period) period / (2 pi). Then those within half a period of the period's start
    are compressed into the part `duty` of it; the rest of the period has no births.
    period : s
    depth : in [0, 1)
    duty : in (0, 1]
    """

    period: float
    depth: float = 0.0
    duty: float = 1.0

    def shifted(self, t):
        """The time of the birth that a steady rate would have at t."""
        start = self.period * np.round(t / self.period)
        return start + self.duty * (
            t - start - self.depth * sin(2 * np.pi * (t - start) / self.period) * (self.period / (2 * np.pi))
        )

    def steady(self, t: float) -> float:
        """About the last steady time that is shifted to t or before, by halving an interval; good to the spacing of floats.

        Its sine may differ in the last bit from that of `shifted`, so that it only says where to look.
        """
        low, width = t - self.period, 2.0 * self.period
        turn = 2.0 * math.pi / self.period
        for _ in range(56):
            width *= 0.5
            middle = low + width
            start = self.period * round(middle / self.period)
            since = middle - start
            if start + self.duty * (since - self.depth * math.sin(turn * since) / turn) <= t:
                low = middle
        return low


class Rate(Schedule):
    """A rate in 1/s, constant or piecewise linear in time.

    rate : a number, or points ((time, rate), ...); the rate is constant before the first and after the last point
    start, stop : s; births begin at `start` and end before `stop`
    pulse : concentrates the births and keeps the mean rate
    Raises UsageError for a negative or infinite rate.
    """

    def __init__(self, rate, start: float = 0.0, stop: float | None = None, pulse: Pulse | None = None):
        self._pulse = pulse
        points = [(start, float(rate))] if np.ndim(rate) == 0 else [(float(t), float(r)) for t, r in rate]
        if not all(np.isfinite(r) and r >= 0 for _, r in points):
            raise UsageError("a rate must be a finite number of at least 0 per second")
        t, r = np.array(points, np.float64).T
        if len(t) > 1:  # cut or extended so that it begins at `start`
            r_start = np.interp(start, t, r)
            later = t > start
            t, r = np.append(start, t[later]), np.append(r_start, r[later])
        self._times, self._rates = t, r
        self._integral = np.append(0.0, np.cumsum(0.5 * (r[1:] + r[:-1]) * np.diff(t)))
        self._is_constant = len(t) == 1 and bool(r[0] > 0)
        self._points = t.tolist(), r.tolist(), self._integral.tolist()
        self._total = None if stop is None else self._until(np.nextafter(stop, -np.inf))

    def _until(self, t: float) -> int:
        time = t
        if self._pulse:
            t = self._pulse.steady(t)
        starts, rates, integral = self._points
        if t < starts[0]:
            return 0
        k = bisect_right(starts, t) - 1
        s = t - starts[k]
        slope = 0.0
        if k + 1 < len(starts):
            slope = (rates[k + 1] - rates[k]) / (starts[k + 1] - starts[k])
        guess = math.floor(integral[k] + s * (rates[k] + 0.5 * slope * s) + 0.5)
        first = max(guess - 2, 0)
        # the births' own times decide, so that every dt gives the same count
        if self._pulse:
            return first + int(np.count_nonzero(self.times(first, guess + 3) <= time))
        return first + sum(self._time(number) <= time for number in range(first, guess + 3))

    def _time(self, number: int) -> float:
        """The time of one birth, as `times` gives it without pulses, in plain numbers: a tenth of the work for a few births."""
        starts, rates, integral = self._points
        target = number + 0.5
        if self._is_constant:
            return starts[0] + target / rates[0]
        k = max(0, min(bisect_left(integral, target) - 1, len(starts) - 1))
        remainder, rate, slope = target - integral[k], rates[k], 0.0
        if k + 1 < len(starts):
            slope = (rates[k + 1] - rate) / (starts[k + 1] - starts[k])
        root = math.sqrt(max(rate * rate + 2.0 * slope * remainder, 0.0))
        return starts[k] + 2.0 * remainder / (rate + root) if rate + root > 0 else math.inf

    def until(self, t):
        count = self._until(t)
        return count if self._total is None else min(count, self._total)

    def times(self, first, last):
        target = np.arange(first, last) + 0.5
        if self._is_constant:  # what the formulas below give, at a tenth of the time
            t = self._times[0] + target / self._rates[0]
            return t if self._pulse is None else self._pulse.shifted(t)
        k = np.minimum(np.searchsorted(self._integral, target, "left") - 1, len(self._times) - 1).clip(0)
        remainder, rate = target - self._integral[k], self._rates[k]
        next_k = np.minimum(k + 1, len(self._times) - 1)
        width = np.where(next_k > k, self._times[next_k] - self._times[k], 1.0)
        slope = np.where(next_k > k, (self._rates[next_k] - rate) / width, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(np.maximum(rate * rate + 2.0 * slope * remainder, 0.0))
            s = 2.0 * remainder / (rate + root)  # the numerically stable root of rate s + slope s^2 / 2 = remainder
        t = np.where(rate + root > 0, self._times[k] + s, np.inf)
        if self._pulse is None:
            return t
        return np.where(np.isfinite(t), self._pulse.shifted(np.where(np.isfinite(t), t, 0.0)), t)


class Burst(Schedule):
    """`count` births at each of the times `at`.

    at : s
    count : an integer, or one integer per time
    Raises UsageError for a negative count.
    """

    def __init__(self, at=(0.0,), count=1):
        self._burst_times = np.sort(np.atleast_1d(np.asarray(at, np.float64)))
        counts = np.broadcast_to(np.asarray(count, np.int64), self._burst_times.shape)
        if np.any(counts < 0):
            raise UsageError("a count must be at least 0")
        self._ends = np.cumsum(counts)
        self._moments = self._burst_times.tolist()

    def until(self, t):
        k = bisect_right(self._moments, t)
        return int(self._ends[k - 1]) if k else 0

    def times(self, first, last):
        return self._burst_times[np.searchsorted(self._ends, np.arange(first, last), "right")]
