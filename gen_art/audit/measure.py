"""What an audit measures: runs of one preset at several time steps, and how their errors fall."""

import math
from dataclasses import dataclass
from functools import reduce

import numpy as np

from gen_art.audit.gyration import largest_turn
from gen_art.particles.rows import CHARGE, MASS, POSITION, VELOCITY
from gen_art.simulation.diagnostics import Diagnostics, energy_of_pairs, sums
from gen_art.simulation.ledger import Ledger

__all__ = ["MOMENTS", "QUANTITIES", "ROUND_OFF", "RunHistory", "AuditRun", "Trend", "positions", "run", "scatter"]

ROUND_OFF = 2e-12  # relative; below it a float64 sum over many steps has no order to measure
TOLERANCE = 0.5  # how far below the expected order a measured one may fall
MOMENTS = 16  # of a run, at which its account is looked at: a residual that swings counts by its largest swing
SHOWN = 24  # particles of a system whose paths are kept
BOOKED = {"energy": ("work", "dissipated"), "momentum": ("impulse", None)}
QUANTITIES = ("energy", "momentum", "angular momentum", "mass", "charge")


@dataclass(frozen=True)
class Trend:
    """A relative error at dt, dt/2 and dt/4 (the last missing where it comes from differences), and its order.

    scatter : what the last value may come to by chance
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
        """The mean order from the first to the last; None where round-off leaves it without meaning."""
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
        """Whether chance alone keeps the last value from its order."""
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
    """A run from moment to moment, the start included: simulated seconds (m,); of all systems together, kinetic energy,
    potential energy and what the account says the energy should be, J (m,); momentum (m, 3), N s.

    paths : by system, (particles, m, 3) m, NaN where a particle is not alive
    """

    times: np.ndarray
    kinetic: np.ndarray
    potential: np.ndarray
    accounted: np.ndarray
    momentum: np.ndarray
    paths: dict[str, np.ndarray]


@dataclass(frozen=True)
class AuditRun:
    """What one run left.

    residuals : by (system, energy or momentum), the largest share of what moved that the account missed
    drifts : by (system, quantity), the largest change since the start, relative to the sum of its parts' sizes; both are
    None where there is nothing of it     last : by system, the energy residual at the end and the energy that moved, J
    places : by system, keys and positions (n, 3) at the end     history : the way there
    turns : by system, the largest angular frequency of a charge in its magnetic fields, 1/s
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


def run(preset, steps: int, dt: float, precision: str, threads, division: int = 1, moments: int = MOMENTS) -> AuditRun:
    """Run a preset with its ledger for `steps` steps of dt, each cut into `division`, and look at it at so many moments."""
    from gen_art.simulation import Simulation

    sim = Simulation(preset, dt=dt / division, precision=precision, threads=threads, ledger=True)
    start, before = sim.diagnostics(), {name: _sums(sim, name) for name in preset.systems}
    residuals: dict = {(name, quantity): None for name in preset.systems for quantity in BOOKED}
    drifts: dict = {(name, quantity): None for name in preset.systems for quantity in QUANTITIES}
    last = {}
    seen = [_look(sim, start, 0.0)]
    turns = {name: largest_turn(sim, name) for name in preset.systems}
    for moment in np.unique(np.linspace(0, steps, moments + 1).round().astype(int)[1:]):
        sim.step(int(moment) * division - sim.steps_done)
        books = sim.ledger()
        seen.append(_look(sim, sim.diagnostics(), books.residual))
        for name in preset.systems:
            turns[name] = max(turns[name], largest_turn(sim, name))
            now = _sums(sim, name)
            for quantity in QUANTITIES:
                (old, size), (new, grown) = before[name][quantity], now[quantity]
                _keep(drifts, (name, quantity), new - old, max(size, grown))
                if quantity in BOOKED:
                    passed, moved = _booked(books, name, quantity)
                    scale = max(size, grown, moved)
                    _keep(residuals, (name, quantity), new - old - passed, scale)
                    if quantity == "energy":
                        last[name] = (float(new - old - passed), scale)
    places = {name: (sim[name].keys, sim[name].position.astype(np.float64)) for name in preset.systems}
    return AuditRun(sim.ledger(), start, sim.diagnostics(), residuals, drifts, last, places, _history(seen), turns)


def _look(sim, now: Diagnostics, residual: float) -> tuple:
    places = {name: (sim[name].keys, sim[name].position.astype(np.float64)) for name in sim.systems}
    return now.time, now.kinetic_energy, now.potential_energy, now.energy - residual, now.momentum, places


def _history(seen: list[tuple]) -> RunHistory:
    times, kinetic, potential, accounted, momentum, places = zip(*seen)
    paths = {}
    for name in places[0]:
        keys = np.unique(np.concatenate([at[name][0] for at in places]))
        shown = keys[np.linspace(0, len(keys) - 1, min(SHOWN, len(keys))).astype(int)] if len(keys) else keys
        paths[name] = np.full((len(shown), len(times), 3), np.nan)
        for m, at in enumerate(places):
            _, mine, theirs = np.intersect1d(shown, at[name][0], return_indices=True)
            paths[name][mine, m] = at[name][1][theirs]
    return RunHistory(
        np.array(times), np.array(kinetic), np.array(potential), np.array(accounted), np.array(momentum), paths
    )


def _keep(largest: dict, key, difference, scale: float) -> None:
    if scale > 0:
        largest[key] = max(largest[key] or 0.0, float(np.abs(difference).max() / scale))


def _sums(sim, name: str) -> dict[str, tuple]:
    """Each conserved quantity of one system's living, with the sum of its parts' sizes to judge a change by."""
    slots = sim.living(name)
    part, pairs = sums(sim, name, slots), energy_of_pairs(sim, name, slots)
    floats = sim.systems[name].floats[:, slots].astype(np.float64)
    speed, light = np.linalg.norm(floats[VELOCITY], axis=0), sim[name].scheme.light
    carried = floats[MASS] * speed / (np.sqrt(1 - (speed / light) ** 2) if light else 1.0)
    return {
        "energy": (part[12:].sum() + pairs, np.abs(part[12:]).sum() + abs(pairs)),
        "momentum": (part[3:6], carried.sum()),
        "angular momentum": (part[6:9], (carried * np.linalg.norm(floats[POSITION], axis=0)).sum()),
        "mass": (part[1], floats[MASS].sum()),
        "charge": (part[2], np.abs(floats[CHARGE]).sum()),
    }


def _booked(books: Ledger, name: str, quantity: str) -> tuple:
    """What the account says that one system gained, and the largest entry."""
    of = lambda account: [amount for key, amount in account.items() if key.startswith(name + ".")]  # noqa: E731
    gains, losses = BOOKED[quantity]
    plus = of(getattr(books, gains)) + [getattr(passage, quantity) for passage in of(books.born)]
    minus = [getattr(passage, quantity) for passage in of(books.died)] + (of(getattr(books, losses)) if losses else [])
    moved = max((float(np.abs(entry).max()) for entry in plus + minus), default=0.0)
    return sum(plus) - sum(minus), moved


def scatter(runs: list[AuditRun], others: dict[float, AuditRun], name: str, first: float) -> float:
    """What positions at dt/2 may err by, by the luck of where in a step a kink falls, relative as in `positions`.

    others : runs of a few steps more over the same span, by their share of the steps. Kinks fall elsewhere in theirs: what
    they err by at dt is another draw. A smooth error changes by its order times the share; that of order 1, of twice
    `first` (the distance of dt from dt/2), is taken off. Of the largest distance an eighth is left at dt/2, as kinks err by
    dt^3; four times that, as the draws are few.
    """
    found = {share: positions([runs[0], one], name, 0) for share, one in others.items()}
    luck = [trend[0].values[0] - 2 * first * share for share, trend in found.items() if trend]
    return max([4 * one / 8 for one in luck], default=0.0) if luck and max(luck) > 0 else 0.0


def positions(runs: list[AuditRun], name: str, expected: int) -> tuple[Trend, int] | None:
    """The median distance between the same particles (by key) of neighbouring runs over the extent, and their number."""
    found = [one.places[name] for one in runs]
    common = reduce(np.intersect1d, [keys for keys, _ in found])
    if not len(common):
        return None
    x = []
    for keys, at in found:
        order = np.argsort(keys)
        x.append(at[order][np.searchsorted(keys[order], common)])
    extent = max(float(np.abs(x[-1]).max()), 1e-300)
    distances = [float(np.median(np.linalg.norm(a - b, axis=1))) / extent for a, b in zip(x, x[1:])]
    return Trend(tuple(distances), expected), len(common)
