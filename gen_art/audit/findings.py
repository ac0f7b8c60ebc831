"""The audit: runs a thinned copy of a preset in float64 at dt, dt/2 and dt/4 and lists what does not close or converge.

The flags of the forces say what should be conserved (invariants.py); measure.py measures what was.
"""

import math
import warnings
from dataclasses import dataclass, replace

from gen_art.audit.advice import advice, advice_texts
from gen_art.audit.invariants import expected_order, forces_of, has_kinks, has_stiff_springs, invariants
from gen_art.audit.measure import MOMENTS, ROUND_OFF, AuditRun, Trend, kink_scatter, positions, run
from gen_art.errors import UsageError
from gen_art.integrators import scheme
from gen_art.preset.estimate import refuse_if_too_large
from gen_art.preset.thinning import thinned
from gen_art.simulation.advice import KNOWN_MAGNETIC_FIELDS, gyration_advice
from gen_art.simulation.diagnostics import Diagnostics
from gen_art.simulation.ledger import Ledger

__all__ = ["FILM_TIME", "PARTICLES", "Audit", "audit", "default_time", "span"]

# Film time of an audit when none is given, s. Half of it where bodies attract each other, because they soon scatter, and
# where stiff springs are solved, because that takes hundreds of kernel launches a step.
FILM_TIME = 2.0
PARTICLES = 600  # the most in a system at once, about; four times as many where they attract each other
DIVISIONS = (1, 2, 4)  # of dt
EXTRA_STEPS = (1, 2, 4, 6)  # further steps of the runs that measure how kinks scatter the error


@dataclass(frozen=True)
class Audit:
    """The findings: `text()` for people, `as_dict()` for programs.

    film_time : film time of the audit, s
    preroll, simulated : simulated time of the preroll, and in all, s
    dt : time step of the first run, s
    steps : number of its steps
    changes : the values that thinning changed, by path: (full, audited)
    integrators : by system
    unborn : systems in which no particle was born
    ledger : at dt
    start, end : diagnostics at dt
    energy, momentum : by system, the Trend of the ledger's residual relative to the largest amount that moved; None without
    mass
    positions : by system, the Trend of the median distance between the same particles of two runs (dt and dt/2, dt/2 and
    dt/4), and the number of particles
    float32 : by system, the difference of the energy residual from float64's at dt, relative
    invariants : by (system, quantity), the Trend of its change; None where there is none of the quantity
    booked : by (system, quantity) that is not conserved by itself, the reason; the ledger accounts for its change
    warnings : sentences
    problems : sentences; empty when everything closes
    runs : the measurements at dt, dt/2 and dt/4
    """

    name: str
    seed: int
    film_time: float
    preroll: float
    simulated: float
    dt: float
    steps: int
    changes: dict[str, tuple]
    integrators: dict[str, str]
    unborn: list[str]
    ledger: Ledger
    start: Diagnostics
    end: Diagnostics
    energy: dict[str, Trend | None]
    momentum: dict[str, Trend | None]
    positions: dict[str, tuple[Trend, int]]
    float32: dict[str, float]
    invariants: dict[tuple[str, str], Trend | None]
    booked: dict[tuple[str, str], str]
    warnings: list[str]
    problems: list[str]
    runs: list[AuditRun]

    def text(self) -> str:
        """The report in words, one screen or two."""
        from gen_art.audit.report_text import write

        return write(self)

    def as_dict(self) -> dict:
        """Plain numbers, lists and dicts for JSON: None for numbers that are not finite."""
        plain = lambda t: None if t is None else t.as_dict()  # noqa: E731
        return _finite({
            "preset": self.name, "seed": self.seed, "film_time": self.film_time, "preroll": self.preroll,
            "simulated": self.simulated, "dt": self.dt, "steps": self.steps,
            "changes": {path: {"full": a, "audited": b} for path, (a, b) in self.changes.items()},
            "integrators": self.integrators, "unborn": self.unborn, "ledger": self.ledger.as_dict(),
            "start": self.start.as_dict(), "end": self.end.as_dict(),
            "energy": {name: plain(t) for name, t in self.energy.items()},
            "momentum": {name: plain(t) for name, t in self.momentum.items()},
            "positions": {n: {**t.as_dict(), "particles": k} for n, (t, k) in self.positions.items()},
            "float32": self.float32,
            "invariants": [{"system": s, "quantity": q, "change": plain(t)} for (s, q), t in self.invariants.items()],
            "booked": [{"system": s, "quantity": q, "reason": reason} for (s, q), reason in self.booked.items()],
            "warnings": self.warnings, "problems": self.problems,
        })  # fmt: skip


def audit(preset, time=None, precision="f32", threads=None, particles=PARTICLES, moments=MOMENTS) -> Audit:
    """Run a preset with few particles at dt, dt/2 and dt/4 in float64 and check its ledger and its convergence.

    preset : a Preset, a name, a path or a mapping
    time : film time to run to, from the start of the preroll, s; when left out 2 s (1 s where bodies attract each other or
    stiff springs are solved) or the whole preset, whichever is shorter
    precision : "f32" also runs in float32 and gives its rounding error
    threads : None for all
    particles : the most particles in a system at once, about
    moments : number of moments at which a run is measured
    Raises PresetError, UsageError for a time that the preset does not reach or that falls between steps, MemoryRefused.
    """
    from gen_art.preset.load import load_preset
    from gen_art.preset.schema import Preset

    preset = preset if isinstance(preset, Preset) else load_preset(preset)
    clock = preset.clock
    if particles < 1:
        raise UsageError(f"particles must be at least 1, not {particles}")
    time, steps = span(clock, time, default_time(preset))
    few, changes = thinned(preset, steps * clock.step, particles)
    refuse_if_too_large(few, "f64", until=steps * clock.step)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        runs = [run(few, steps, clock.step, "f64", threads, DIVISIONS[0], moments)]
    run_warnings = advice_texts(caught)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        runs += [run(few, steps, clock.step, "f64", threads, n, moments) for n in DIVISIONS[1:]]
    orders = {name: expected_order(few, name) for name in few.systems}
    energy, momentum = (
        {n: _trend([r.residuals[n, q] for r in runs], orders[n]) for n in few.systems} for q in ("energy", "momentum")
    )
    # thermal noise is drawn once a step: other steps, other paths
    steady = [n for n, s in few.systems.items() if not any(f.provides("noise") for f in forces_of(few, s))]
    distances = {n: distance for n in steady if (distance := positions(runs, n, orders[n]))}
    scattered = [name for name, (trend, _) in distances.items() if not trend.good and has_kinks(few, name)]
    if scattered:
        others = {
            k / (steps + k): run(few, steps + k, clock.step * steps / (steps + k), "f64", threads, 1, 1)
            for k in EXTRA_STEPS
        }
        for name in scattered:
            trend, count = distances[name]
            distances[name] = replace(trend, scatter=kink_scatter(runs, others, name, trend.values[0])), count
    conserved: dict[tuple[str, str], Trend | None] = {}
    booked: dict[tuple[str, str], str] = {}
    for name, system in few.systems.items():
        quantities, reasons = invariants(few, system)
        conserved |= {(name, q): _trend([r.drifts[name, q] for r in runs], orders[name]) for q in quantities}
        booked |= {(name, quantity): reason for quantity, reason in reasons.items()}
    # the run repeats what follows from the numbers of the systems
    sentences = list(dict.fromkeys([*advice(few), *_gyration_warnings(few, runs[0].turns), *run_warnings]))
    first = runs[0]
    unborn = [
        n for n in few.systems if not any(k.startswith(n + ".") for k in first.ledger.born) and n not in distances
    ]
    return Audit(
        few.name, few.seed, time, clock.preroll, steps * clock.step, clock.step, steps, changes,
        {name: system.integrator for name, system in few.systems.items()}, unborn,
        first.ledger, first.start, first.end, energy, momentum, distances,
        _float32_errors(first, run(few, steps, clock.step, "f32", threads)) if precision == "f32" else {},
        conserved, booked, sentences, _problems(few, energy, momentum, distances, conserved, runs), runs,
    )  # fmt: skip


def _gyration_warnings(preset, turns: dict[str, float]) -> list[str]:
    """Warnings about charges that turn too far in a step, in the fields whose strength only a run shows."""
    sentences = []
    for name, system in preset.systems.items():
        forces, used = forces_of(preset, system), scheme(system.integrator)
        if used.pusher and any(f.provides("magnetic") and f.name not in KNOWN_MAGNETIC_FIELDS for f in forces):
            advised = gyration_advice(turns[name], preset.clock.step, system.exact_gyration)
            sentences += [f"system '{name}': {sentence}" for sentence in advised]
    return sentences


def default_time(preset) -> float:
    """Film time that is audited when none is given, s."""
    mutual = any(i.source_system is None for system in preset.systems.values() for i in system.interactions)
    stiff = any(map(has_stiff_springs, preset.systems.values()))
    return FILM_TIME / 2 if mutual or stiff else FILM_TIME


def span(clock, time, default: float) -> tuple[float, int]:
    """(film time, steps from the start of the simulation) of an audit to film time `time`."""
    if time is None:
        time = min(default, (clock.frames - 1) / clock.fps)
    if not isinstance(time, (int, float)) or not math.isfinite(time) or time < 0:
        raise UsageError(f"time must be film time in seconds of at least 0, not {time!r}")
    if time > clock.duration:
        raise UsageError(f"film time {time:g} s lies beyond the preset, which lasts {clock.duration:g} s")
    exact = time * clock.speed / clock.step
    if abs(exact - round(exact)) > 1e-6 * max(1.0, exact):
        raise UsageError(
            f"film time {time:g} s falls between steps; the nearest is {round(exact) * clock.step / clock.speed:.9g} s"
        )
    steps = clock.preroll_steps + round(exact)
    if steps < 1:
        raise UsageError("film time 0 without a preroll holds no step to audit")
    return float(time), steps


def _finite(value):
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _trend(values: list, expected: int) -> Trend | None:
    return None if None in values else Trend(tuple(values), expected)


def _float32_errors(double: AuditRun, single: AuditRun) -> dict[str, float]:
    pairs = ((name, *double.last[name], single.last[name][0]) for name in double.last)
    return {name: abs(rounded - exact) / scale for name, exact, scale, rounded in pairs if scale > 0}


def _problems(preset, energy, momentum, distances, conserved, runs: list[AuditRun]) -> list[str]:
    """Sentences about everything that does not close, converge or hold."""
    problems = []
    for label, trends in (("energy", energy), ("momentum", momentum)):
        for name, trend in trends.items():
            if trend is not None and not trend.good:
                problems.append(f"{name}: the ledger of {label} does not close: {trend}")
    for name, (trend, _) in distances.items():
        if not trend.good:
            used = preset.systems[name].integrator
            problems.append(
                f"{name}: positions do not converge as {used} should: {trend}; is the step too long for the forces?"
            )
    for (name, quantity), trend in conserved.items():
        if trend is not None and not trend.good:
            problems.append(f"{name}: {quantity} should be conserved and is not: {trend}")
    for audit_run in runs:
        born, died = audit_run.ledger.born.total, audit_run.ledger.died.total
        for quantity in ("count", "mass", "charge"):
            start, end = getattr(audit_run.start, quantity), getattr(audit_run.end, quantity)
            gap = start + getattr(born, quantity) - getattr(died, quantity) - end
            if abs(gap) > ROUND_OFF * max(abs(start), abs(end), abs(getattr(born, quantity)), 1e-300):
                problems.append(f"births and deaths do not account for the {quantity}: {gap:.3g} is missing")
    return list(dict.fromkeys(problems))
