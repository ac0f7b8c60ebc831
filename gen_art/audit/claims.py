"""The claims of a preset's `expect:`: what each measures in a run, and its error."""

import math

import numpy as np

from gen_art.audit.findings import default_time, span
from gen_art.audit.measure import ROUND_OFF, gain_by_ledger
from gen_art.audit.observables import period
from gen_art.errors import UsageError
from gen_art.preset.expect import CONSERVED, Period, Value

__all__ = ["DISTURBANCE", "SumClaim", "QuantityClaim", "claims_of"]

DISTURBANCE = (
    0.05  # share of the velocities, or of masses and charges, that the mutant of a SumClaim loses in the whole run
)
_MATTER = ("mass", "charge")


class SumClaim:
    """A claim that sums over the particles stay, or follow the ledger. Its error is what is measured.

    quantity : of conserved_sums
    names : of the systems; together, or each by itself where the ledger is compared
    """

    def __init__(self, quantity: str, bound: float, of: str | None, names: list[str], with_ledger: bool):
        self.quantity, self.names, self.with_ledger = quantity.replace("_", " "), names, with_ledger
        self.bound = max(bound, ROUND_OFF)
        whose = f" of {of}" if of else ""
        amount = f"{bound:g} of its parts" if bound > ROUND_OFF else "round-off"
        what = "follows the ledger within" if with_ledger else "stays within"
        self.words = f"{self.quantity}{whose} {what} {amount}"
        self.changes: dict | None = None
        self.unmeasured = "the sums are not finite"
        self.disturbs = "matter" if quantity in _MATTER else "motion"
        share = f"{DISTURBANCE:.0%}"
        self.mutant_words = (
            f"masses and charges {share} less" if self.disturbs == "matter" else f"velocities disturbed by {share}"
        )

    def error(self, measured: float) -> float:
        return measured

    def gap(self, before: dict, now: dict, ledger) -> float:
        """The relative change since the start, or the largest relative residual of the ledger.

        before, now : conserved_sums by system
        """
        q = self.quantity
        if self.with_ledger:
            gaps = []
            for name in self.names:
                (old, old_size), (new, new_size) = before[name][q], now[name][q]
                gained, moved = gain_by_ledger(ledger, name, q)
                gaps.append(_relative(new - old - gained, max(old_size, new_size, moved)))
            return max(gaps)
        old, new = (sum(sums[name][q][0] for name in self.names) for sums in (before, now))
        size = max(sum(sums[name][q][1] for name in self.names) for sums in (before, now))
        return _relative(new - old, size)


class QuantityClaim:
    """A claim about a period, a value or a range.

    second : label of the preset's unit of simulated time
    """

    def __init__(self, spec, changes: dict, clock, second: str = "s"):
        self.spec, self.clock, self.changes = spec, clock, changes
        self.bound, over = getattr(spec, "within", 0.0), "" if spec.over == "mean" else f"{spec.over} "
        self.unmeasured = "no particle of it lives then"
        if isinstance(spec, Period):
            self.unmeasured = "the quantity passes its middle upwards less than twice; give a longer expect.time"
            self.words = f"period of {over}{spec.of} is {spec.is_:g} {second} within {spec.within:g} of it"
        elif isinstance(spec, Value):
            at = "at the end" if spec.at is None else f"at {spec.at:g} s"
            self.words = f"{over}{spec.of} is {spec.is_:g} {at} within {spec.within:g}{' of it' if spec.is_ else ''}"
        else:
            low = f" from {spec.source:g}" if spec.source is not None else ""
            self.words = f"{over}{spec.of} keeps{low}{f' to {spec.to:g}' if spec.to is not None else ''}"
        self.mutant_words = ", ".join(f"{path} = {value}" for path, value in changes.items())

    def film_time(self, times: np.ndarray) -> np.ndarray:
        return (times - self.clock.preroll) / self.clock.speed

    def measure(self, times: np.ndarray, values: np.ndarray) -> float:
        """The number to compare: of a range the value that is farthest out. Moments without particles do not count."""
        spec, living = self.spec, ~np.isnan(values)
        times, values = times[living], values[living]
        if not len(values):
            return math.nan
        if isinstance(spec, Period):
            return period(times, values)
        film = self.film_time(times)
        if isinstance(spec, Value):
            return float(values[-1] if spec.at is None else np.interp(spec.at, film, values))
        kept = values if spec.after is None else values[film >= spec.after - 1e-9]
        return float(kept[np.argmax([self.error(value) for value in kept])]) if len(kept) else math.nan

    def error(self, measured: float) -> float:
        spec = self.spec
        if isinstance(spec, (Period, Value)):
            return abs(measured - spec.is_) / (abs(spec.is_) or 1.0)
        low = -math.inf if spec.source is None else spec.source
        high = math.inf if spec.to is None else spec.to
        return max(low - measured, measured - high, 0.0) if math.isfinite(measured) else math.nan


def claims_of(preset) -> list:
    expect, names = preset.expect, list(preset.systems)
    claims: list = []
    for quantity in CONSERVED:
        for one in getattr(expect, quantity):
            claims.append(SumClaim(quantity, one.drift, one.of, [one.of] if one.of else names, False))
    for one in expect.ledger:
        for quantity, bound in (("energy", one.energy), ("momentum", one.momentum)):
            if bound is not None:
                claims.append(SumClaim(quantity, bound, one.of, [one.of] if one.of else names, True))
    for path, spec in expect.quantities:
        latest = max(getattr(spec, "at", None) or 0.0, getattr(spec, "after", None) or 0.0)
        reached = span(preset.clock, expect.time, default_time(preset))[0]
        if latest > reached:
            raise UsageError(
                f"expect.{path[0]} is about film time {latest:g} s, but the check ends at {reached:g} s: give a longer "
                "expect.time"
            )
        claims.append(QuantityClaim(spec, spec.mutant or expect.mutant, preset.clock, preset.units.time))
    return claims


def _relative(difference, scale: float) -> float:
    return float(np.abs(difference).max() / scale) if scale > 0 else 0.0
