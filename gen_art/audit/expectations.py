"""`check`: whether what a preset's `expect:` says of its motion holds, and whether a wrong motion would be noticed.

A thinned copy runs in float64 at dt, dt/2 and dt/4, then once more at dt for each mutant, a version that is wrong on purpose:
one whose velocities are disturbed, for what is conserved and for the ledger, and those with the changes that `mutant:` names.
"""

import math
from dataclasses import dataclass

import numpy as np

from gen_art.audit.claims import DISTURBANCE, QuantityClaim, SumClaim, claims_of
from gen_art.audit.findings import default_time, span
from gen_art.audit.measure import conserved_sums
from gen_art.audit.observables import value_of
from gen_art.errors import DivergedError, PresetError, UsageError
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import CHARGE, LIFETIME, MASS, VELOCITY
from gen_art.preset.estimate import refuse_if_too_large
from gen_art.preset.load import load_preset
from gen_art.preset.thinning import thinned

__all__ = ["DIVISIONS", "Check", "Finding", "check"]

DIVISIONS = (1, 2, 4)  # of dt
MOMENTS = 16  # moments at which sums are compared, and the velocities of the mutant disturbed
SAMPLES = 2000  # most moments at which periods and bounds are sampled
_DIRECTION = np.array([0.36, 0.48, 0.80])  # in which the mutant is pushed: along no axis


def _plain(number: float) -> float | None:
    """Six digits of a number; None if it is not finite."""
    return float(f"{number:.6g}") if math.isfinite(number) else None


@dataclass(frozen=True)
class Finding:
    """What was found of one claim.

    claim : in words
    bound : the largest error that it allows
    measured : at dt, dt/2 and dt/4: the error itself, or the value that is compared
    errors : at dt, dt/2 and dt/4; NaN where nothing could be measured
    mutant : the mutant in words
    mutant_error : the error of the mutant at dt; infinite if it left the finite numbers
    unmeasured : why a measured value is NaN, where one is
    """

    claim: str
    bound: float
    measured: tuple[float, ...]
    errors: tuple[float, ...]
    mutant: str
    mutant_error: float
    unmeasured: str = ""

    @property
    def holds(self) -> bool:
        return all(error <= self.bound for error in self.errors)

    @property
    def can_fail(self) -> bool:
        """Whether the mutant breaks the claim."""
        return not self.mutant_error <= self.bound

    @property
    def good(self) -> bool:
        return self.holds and self.can_fail

    @property
    def verdict(self) -> str:
        if not self.holds:
            return "does not hold"
        return "holds" if self.can_fail else "cannot fail"

    def as_dict(self) -> dict:
        """Plain numbers; None for those that are not finite."""
        return {
            "claim": self.claim, "verdict": self.verdict, "bound": self.bound,
            "measured": [_plain(x) for x in self.measured], "errors": [_plain(x) for x in self.errors],
            "mutant": self.mutant, "mutant_error": _plain(self.mutant_error),
        }  # fmt: skip


@dataclass(frozen=True)
class Check:
    """The findings of `check`. `good` : every claim holds, and would fail if the motion were wrong."""

    name: str
    seed: int
    film_time: float
    dt: float
    steps: int
    changes: dict[str, tuple]
    findings: list[Finding]

    @property
    def good(self) -> bool:
        return all(finding.good for finding in self.findings)

    def text(self) -> str:
        """A line of the run, and two for each claim."""
        thin = f", thinned to few particles ({len(self.changes)} emitters)" if self.changes else ""
        lines = [
            f"{self.name}, seed {self.seed}: {self.film_time:g} s of film, {self.steps:,} steps of {self.dt:.6g} s in f64{thin}"
        ]
        for one in self.findings:
            measured = "  ".join(f"{value:.7g}" for value in one.measured)
            lines.append(f"  {one.verdict:14}{one.claim}")
            lines.append(f"  {'':14}at dt, dt/2, dt/4: {measured}; with {one.mutant}: error {one.mutant_error:.2g}")
            if any(map(math.isnan, one.measured)):
                lines.append(f"  {'':14}not measured: {one.unmeasured}")
        return "\n".join(lines)

    def as_dict(self) -> dict:
        """Plain numbers, lists and dicts for JSON and for recipes."""
        return {
            "verdict": "good" if self.good else "not good", "seed": self.seed, "film_time": self.film_time, "dt": self.dt,
            "steps": self.steps, "thinned": sorted(self.changes),
            "claims": [finding.as_dict() for finding in self.findings],
        }  # fmt: skip


def check(preset, threads=None) -> Check:
    """Run what the `expect:` of a preset says, and its mutants.

    preset : a Preset, a name, a path or a mapping
    threads : None for all
    Raises PresetError for a preset, or a mutant of it, that is wrong; UsageError for one that expects nothing, and for a time
    that it does not reach or that falls between steps; MemoryRefused; DivergedError.
    """
    from gen_art.preset.schema import Preset

    preset = preset if isinstance(preset, Preset) else load_preset(preset)
    expect = preset.expect
    if expect is None:
        raise UsageError(f"{preset.name} expects nothing: give it `expect:`, such as `expect: {{energy: 1e-4}}`")
    clock = preset.clock
    film_time, steps = span(clock, expect.time, default_time(preset))
    few, changes = thinned(preset, steps * clock.step, expect.particles)
    refuse_if_too_large(few, "f64", until=steps * clock.step)
    claims = claims_of(few)
    runs = [_run(few, claims, steps, division, threads) for division in DIVISIONS]
    wrong: dict[str, dict] = {}
    for claim in claims:
        if claim.mutant_words not in wrong:
            wrong[claim.mutant_words] = _run_mutant(few, claim, claims, steps, threads)
    findings = []
    for claim in claims:
        measured = tuple(run[claim] for run in runs)
        errors = tuple(claim.error(value) for value in measured)
        mutated = wrong[claim.mutant_words].get(claim)
        mutant_error = math.inf if mutated is None else claim.error(mutated)
        findings.append(
            Finding(claim.words, claim.bound, measured, errors, claim.mutant_words, mutant_error, claim.unmeasured)
        )
    return Check(few.name, few.seed, film_time, clock.step, steps, changes, findings)


def _run_mutant(preset, claim, claims: list, steps: int, threads) -> dict:
    """What the mutant of a claim gives for all claims; nothing if it left the finite numbers."""
    mutated = preset
    if claim.changes is not None:
        if any(path.split(".")[0] == "knobs" for path in claim.changes):
            raise UsageError(
                f"the mutant of {preset.name} changes a knob, and knobs are filled in before: change the places where it stands"
            )
        try:
            mutated = load_preset(preset, overrides=claim.changes)
        except PresetError as error:
            raise UsageError(f"the mutant of {preset.name} is no preset: {error}") from None
        except UsageError as error:
            raise UsageError(f"the mutant of {preset.name}: {error}") from None
        steps = round(steps * preset.clock.step / mutated.clock.step)
    try:
        return _run(mutated, claims, steps, 1, threads, "" if claim.changes is not None else claim.disturbs)
    except DivergedError:
        return {}


def _run(preset, claims: list, steps: int, division: int, threads, disturbs: str = "") -> dict:
    """By claim, the number that is measured in a run of `steps` steps, each cut into `division`.

    disturbs : motion or matter, which is then changed a little between the moments
    """
    from gen_art.simulation import Simulation

    books = any(isinstance(claim, SumClaim) and claim.with_ledger for claim in claims)
    sim = Simulation(
        preset, dt=preset.clock.step / division, precision="f64", threads=threads, ledger=books, advice="none"
    )
    kept = [claim for claim in claims if isinstance(claim, SumClaim)]
    followed = [claim for claim in claims if isinstance(claim, QuantityClaim)]
    systems = sorted({name for claim in kept for name in claim.names})
    before = {name: conserved_sums(sim, name) for name in systems}
    series: dict = {claim: [] for claim in followed}
    worst: dict = dict.fromkeys(kept, 0.0)
    times: list[float] = []

    def sample() -> None:
        times.append(sim.time)
        for claim in followed:
            series[claim].append(value_of(sim, claim.spec.of, claim.spec.over))

    sample()
    coarse = np.unique(np.linspace(0, steps, MOMENTS + 1).round().astype(int))
    fine = np.unique(np.linspace(0, steps, min(steps, SAMPLES) + 1).round().astype(int)) if followed else coarse
    coarse_steps = set(coarse.tolist())
    for moment in np.unique(np.concatenate([coarse, fine]))[1:].tolist():
        if disturbs and sim.steps_done // division in coarse_steps:
            _disturb(sim, disturbs, DISTURBANCE / MOMENTS)
        sim.step(moment * division - sim.steps_done)
        sample()
        if moment in coarse_steps and kept:
            now, ledger = {name: conserved_sums(sim, name) for name in systems}, sim.ledger() if books else None
            for claim in kept:
                worst[claim] = _larger(worst[claim], claim.gap(before, now, ledger))
    return worst | {claim: claim.measure(np.array(times), np.array(values)) for claim, values in series.items()}


def _larger(a: float, b: float) -> float:
    return math.nan if math.isnan(a) or math.isnan(b) else max(a, b)


def _disturb(sim, what: str, share: float) -> None:
    """Move every velocity a little towards one direction, or lessen every mass and charge."""
    for name, system in sim.members.items():
        living, rows = sim.living(name), system.state.floats
        if what == "matter":
            for row in (MASS, CHARGE):
                rows[row, living] *= 1 - share
            continue
        moving = living[~fixed_lifetimes(rows[LIFETIME, living])]
        if not len(moving):
            continue
        velocity = rows[VELOCITY, moving]
        push = np.sqrt((velocity**2).sum(0).mean()) * _DIRECTION
        rows[VELOCITY, moving] = (1 - share) * velocity + share * push[:, None]
        for interaction in system.interactions:
            interaction.disturb(share, push)
