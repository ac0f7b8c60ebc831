"""The measurements of an audit: runs of one preset at several time steps, and the order at which their errors fall."""

import math
from dataclasses import dataclass
from functools import reduce

import numpy as np

from gen_art.audit.gyration import largest_turn
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.rows import CHARGE, MASS, POSITION, VELOCITY
from gen_art.simulation.diagnostics import (
    ANGULAR_MOMENTUM,
    ENERGY,
    MOMENTUM,
    TOTAL_CHARGE,
    TOTAL_MASS,
    Diagnostics,
    energy_of_pairs,
    sums,
)
from gen_art.simulation.ledger import Ledger

__all__ = [
    "MOMENTS", "QUANTITIES", "ROUND_OFF", "AuditRun", "RunHistory", "Trend", "conserved_sums", "gain_by_ledger", "kink_scatter",
    "positions", "run",
]  # fmt: skip

ROUND_OFF = 2e-12  # relative; below it a float64 sum over many steps has no order to measure
TOLERANCE = 0.5  # how far below the expected order a measured one may be
MOMENTS = 16  # moments of a run at which its ledger is read; of an oscillating residual the largest value counts
SHOWN = 24  # particles of a system whose paths are kept
LEDGER_FIELDS = {"energy": ("work", "dissipated"), "momentum": ("impulse", None)}  # (gains, losses)
QUANTITIES = ("energy", "momentum", "angular momentum", "mass", "charge")


@dataclass(frozen=True)
class Trend:
    """A relative error at dt, dt/2 and dt/4, and the order at which it falls.

    values : the errors; errors that are differences of two runs are two only, at dt and dt/2
    expected : the expected order
    floor : round-off; below it there is no order
    scatter : the part of the last value that may be chance
    """

    values: tuple[float, ...]
    expected: int
    floor: float = ROUND_OFF
    scatter: float = 0.0

    @property
    def at_round_off(self) -> bool:
        return all(value <= self.floor for value in self.values)

    @property
    def order(self) -> float | None:
        """The mean order from the first value to the last; None where round-off hides it."""
        first, last = self.values[0], self.values[-1]
        if not math.isfinite(first + last):
            return math.nan
        if first <= self.floor:
            return None
        return math.log2(first / max(last, 1e-300)) / (len(self.values) - 1)

    @property
    def good(self) -> bool:
        last = self.values[-1]
        if not all(map(math.isfinite, self.values)):
            return False
        return last <= 2 * self.floor or self.has_its_order or self.is_scatter

    @property
    def has_its_order(self) -> bool:
        order = self.order
        return order is not None and order >= self.expected - TOLERANCE

    @property
    def is_scatter(self) -> bool:
        """Whether only chance keeps the last value above the expected order."""
        allowed = self.values[0] / 2 ** ((self.expected - TOLERANCE) * (len(self.values) - 1))
        return self.scatter > 0 and not self.has_its_order and self.values[-1] <= allowed + self.scatter

    def __str__(self) -> str:
        order = "without an order" if self.order is None else f"at order {self.order:.2f}"
        return f"{', '.join(f'{value:.1e}' for value in self.values)}, {order} where {self.expected} is expected"

    def as_dict(self) -> dict:
        """Plain numbers."""
        return {
            "values": list(self.values), "expected_order": self.expected, "order": self.order,
            "at_round_off": self.at_round_off, "scatter": self.scatter, "good": self.good,
        }  # fmt: skip


@dataclass(frozen=True)
class RunHistory:
    """A run at m moments, the start included, of all systems together.

    times : (m,) simulated time, s
    kinetic, potential : (m,) energy, J
    accounted : (m,) the energy that follows from the ledger, J
    momentum : (m, 3) N s
    paths : by system, (particles, m, 3) m, NaN where a particle is not alive or was wrapped in a periodic box
    """

    times: np.ndarray
    kinetic: np.ndarray
    potential: np.ndarray
    accounted: np.ndarray
    momentum: np.ndarray
    paths: dict[str, np.ndarray]


@dataclass(frozen=True)
class AuditRun:
    """The measurements of one run.

    ledger : at the end
    start, end : diagnostics
    residuals : by (system, energy or momentum), the largest residual of the ledger relative to the amount that moved; None
    where nothing moved
    drifts : by (system, quantity), the largest change since the start, relative to the sum of the absolute values of the
    particles' parts; None where that sum is 0
    last : by system, the energy residual at the end and the energy that moved, J
    places : by system, keys and positions (n, 3) at the end
    history : the run from moment to moment
    turns : by system, the largest angular frequency of a charge in its magnetic fields, 1/s
    box : the periodic box; None in open space
    """

    ledger: Ledger
    start: Diagnostics
    end: Diagnostics
    residuals: dict[tuple[str, str], float | None]
    drifts: dict[tuple[str, str], float | None]
    last: dict[str, tuple[float, float]]
    places: dict[str, tuple[np.ndarray, np.ndarray]]
    history: RunHistory
    turns: dict[str, float]
    box: PeriodicBox | None = None


def run(preset, steps: int, dt: float, precision: str, threads, division: int = 1, moments: int = MOMENTS) -> AuditRun:
    """Run a preset with its ledger for `steps` steps of dt, each cut into `division`, and measure it at `moments` moments."""
    from gen_art.simulation import Simulation

    sim = Simulation(preset, dt=dt / division, precision=precision, threads=threads, ledger=True)
    start, before = sim.diagnostics(), {name: conserved_sums(sim, name) for name in preset.systems}
    residuals: dict = {(name, quantity): None for name in preset.systems for quantity in LEDGER_FIELDS}
    drifts: dict = {(name, quantity): None for name in preset.systems for quantity in QUANTITIES}
    last = {}
    snapshots = [_snapshot(sim, start, 0.0)]
    turns = {name: largest_turn(sim, name) for name in preset.systems}
    for moment in np.unique(np.linspace(0, steps, moments + 1).round().astype(int)[1:]):
        sim.step(int(moment) * division - sim.steps_done)
        ledger = sim.ledger()
        snapshots.append(_snapshot(sim, sim.diagnostics(), ledger.residual))
        for name in preset.systems:
            turns[name] = max(turns[name], largest_turn(sim, name))
            now = conserved_sums(sim, name)
            for quantity in QUANTITIES:
                (old, old_size), (new, new_size) = before[name][quantity], now[quantity]
                _update_largest(drifts, (name, quantity), new - old, max(old_size, new_size))
                if quantity in LEDGER_FIELDS:
                    gained, moved = gain_by_ledger(ledger, name, quantity)
                    scale = max(old_size, new_size, moved)
                    _update_largest(residuals, (name, quantity), new - old - gained, scale)
                    if quantity == "energy":
                        last[name] = (float(new - old - gained), scale)
    places = {name: (sim[name].keys, sim[name].position.astype(np.float64)) for name in preset.systems}
    history = _history(snapshots, sim.box)
    return AuditRun(sim.ledger(), start, sim.diagnostics(), residuals, drifts, last, places, history, turns, sim.box)


def _snapshot(sim, now: Diagnostics, residual: float) -> tuple:
    """One moment of a RunHistory, with all keys and positions instead of paths."""
    places = {name: (sim[name].keys, sim[name].position.astype(np.float64)) for name in sim.systems}
    return now.time, now.kinetic_energy, now.potential_energy, now.energy - residual, now.momentum, places


def _history(snapshots: list[tuple], box: PeriodicBox | None) -> RunHistory:
    times, kinetic, potential, accounted, momentum, places = zip(*snapshots)
    paths = {}
    for name in places[0]:
        keys = np.unique(np.concatenate([at[name][0] for at in places]))
        shown = keys[np.linspace(0, len(keys) - 1, min(SHOWN, len(keys))).astype(int)] if len(keys) else keys
        paths[name] = np.full((len(shown), len(times), 3), np.nan)
        for m, at in enumerate(places):
            _, path_rows, place_rows = np.intersect1d(shown, at[name][0], return_indices=True)
            paths[name][path_rows, m] = at[name][1][place_rows]
        if box is not None:  # a path is broken where it was wrapped
            x = np.moveaxis(paths[name], 2, 0)
            jumped = box.jumps((x[:, :, 1:] - x[:, :, :-1]).reshape(3, -1)).reshape(len(shown), -1)
            paths[name][:, 1:][jumped] = np.nan
    return RunHistory(
        np.array(times), np.array(kinetic), np.array(potential), np.array(accounted), np.array(momentum), paths
    )


def _update_largest(largest: dict, key, difference, scale: float) -> None:
    """Raise largest[key] to the largest component of abs(difference) / scale."""
    if scale > 0:
        largest[key] = max(largest[key] or 0.0, float(np.abs(difference).max() / scale))


def conserved_sums(sim, name: str) -> dict[str, tuple]:
    """By conserved quantity of one system's living particles: its value, and the sum of its parts' absolute values."""
    slots = sim.living(name)
    total, pairs = sums(sim, name, slots), energy_of_pairs(sim, name, slots)
    floats = sim.systems[name].floats[:, slots].astype(np.float64)
    speed, light = np.linalg.norm(floats[VELOCITY], axis=0), sim[name].scheme.light
    momentum = floats[MASS] * speed / (np.sqrt(1 - (speed / light) ** 2) if light else 1.0)
    return {
        "energy": (total[ENERGY].sum() + pairs, np.abs(total[ENERGY]).sum() + abs(pairs)),
        "momentum": (total[MOMENTUM], momentum.sum()),
        "angular momentum": (total[ANGULAR_MOMENTUM], (momentum * np.linalg.norm(floats[POSITION], axis=0)).sum()),
        "mass": (total[TOTAL_MASS], floats[MASS].sum()),
        "charge": (total[TOTAL_CHARGE], np.abs(floats[CHARGE]).sum()),
    }


def gain_by_ledger(ledger: Ledger, name: str, quantity: str) -> tuple:
    """(the gain of one system according to the ledger, the largest entry)."""
    entries = lambda column: [amount for key, amount in column.items() if key.startswith(name + ".")]  # noqa: E731
    gains, losses = LEDGER_FIELDS[quantity]
    plus = entries(getattr(ledger, gains)) + [getattr(transfer, quantity) for transfer in entries(ledger.born)]
    minus = [getattr(transfer, quantity) for transfer in entries(ledger.died)]
    minus += entries(getattr(ledger, losses)) if losses else []
    moved = max((float(np.abs(entry).max()) for entry in plus + minus), default=0.0)
    return sum(plus) - sum(minus), moved


def kink_scatter(runs: list[AuditRun], others: dict[float, AuditRun], name: str, first: float) -> float:
    """How much the position error at dt/2 may vary with where in a step a kink is crossed; relative, as in `positions`.

    others : runs of the same span in a few more steps, by the relative change of the step

    In the other runs kinks are crossed elsewhere in a step, so each is another sample of their error at dt. The smooth error
    also changes, by its order times the relative change of the step; for order 1 and the error 2 `first` (`first` is the
    distance of dt from dt/2) that change is subtracted. At dt/2 an eighth of the largest sample remains, because kinks err
    by dt^3; the result is four times that, because the samples are few.
    """
    distances = {share: positions([runs[0], other], name, 0) for share, other in others.items()}
    samples = [distance[0].values[0] - 2 * first * share for share, distance in distances.items() if distance]
    return max([4 * sample / 8 for sample in samples], default=0.0) if samples and max(samples) > 0 else 0.0


def positions(runs: list[AuditRun], name: str, expected: int) -> tuple[Trend, int] | None:
    """(Trend of the median distance between the same particles of successive runs, number of particles).

    Particles are matched by key; the distance is relative to the largest coordinate. None without common particles.
    """
    places = [audit_run.places[name] for audit_run in runs]
    common = reduce(np.intersect1d, [keys for keys, _ in places])
    if not len(common):
        return None
    x = []
    for keys, at in places:
        order = np.argsort(keys)
        x.append(at[order][np.searchsorted(keys[order], common)])
    extent = max(float(np.abs(x[-1]).max()), 1e-300)
    box = runs[0].box
    apart = [a - b if box is None else box.nearest((a - b).T).T for a, b in zip(x, x[1:])]
    distances = [float(np.median(np.linalg.norm(d, axis=1))) / extent for d in apart]
    return Trend(tuple(distances), expected), len(common)
