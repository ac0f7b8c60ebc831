"""Thins a preset: the same forces and looks, with births scaled down system by system."""

from collections.abc import Collection, Mapping
from typing import Any

from gen_art.preset.estimate import estimate
from gen_art.preset.load import load_preset
from gen_art.preset.values import Curve, Range

__all__ = ["counts_thinned_to", "galaxies", "independent_systems", "overrides_of", "thinned"]

MUTUAL = 4  # factor on the limit for systems that attract themselves


def thinned(preset, until: float, limit: int, systems: Collection[str] | None = None) -> tuple:
    """(thinned Preset, changes): at most about `limit` particles of a system at once up to simulated time `until`, s.

    Systems that attract themselves keep four times as many, because fewer would scatter each other and hide the order.
    Rates and counts of a system are scaled by one factor, parents before the children that their events feed. `changes`
    maps each changed path (as in `--set`) to (before, after). Without forces between particles each particle moves as in
    the full preset; bodies that attract each other are fewer. If they feel nothing else and share a mass, or take theirs from
    the system's `particle`, each is heavier by as much, so that together they attract as before; others attract less.

    systems : the names of those that may be thinned; all when None
    """
    most = {}
    for name in preset.systems if systems is None else systems:
        mutual = any(interaction.source_system is None for interaction in preset.systems[name].interactions)
        most[name] = limit * (MUTUAL if mutual else 1)
    _, changes = counts_thinned_to(preset, until, most)
    return (load_preset(preset, overrides=overrides_of(changes)) if changes else preset), changes


def overrides_of(changes: dict[str, tuple]) -> dict[str, Any]:
    """The overrides that make these changes."""
    return {path: after for path, (_, after) in changes.items()}


def counts_thinned_to(preset, until: float, most: Mapping[str, float]) -> tuple:
    """(a copy of the preset with fewer births, changes): of the systems that `most` names, at most so many particles at once.

    The changes are those of `thinned`. The copy has those of births alone, for an estimate; no simulation is made of it.
    """
    changes: dict[str, tuple] = {}
    full = estimate(preset, "f64", until).peak
    few, peaks = preset, full
    for name in _parents_first(preset):
        peak = peaks[name]
        if name not in most or not peak > most[name]:
            continue
        emitters = {}
        for label, emitter in few.systems[name].emitters.items():
            emitters[label], scaled = _scaled(emitter, most[name] / peak)
            changes |= {f"systems.{name}.emitters.{label}.{key}": pair for key, pair in scaled.items()}
        thin = few.systems[name].model_copy(update={"emitters": emitters})
        few = few.model_copy(update={"systems": {**few.systems, name: thin}})
        peaks = estimate(few, "f64", until).peak
    return few, changes | _heavier(few, {name: full[name] / max(peaks[name], 1) for name in peaks})


def independent_systems(preset) -> list[str]:
    """The systems whose particles move no other particle: fewer of them leave the motion of the rest as it is."""
    acting = {n for n, s in preset.systems.items() if any(each.source_system is None for each in s.interactions)}
    for system in preset.systems.values():
        acting |= {interaction.source_system for interaction in system.interactions} - {None}
    order = _parents_first(preset)
    for name in reversed(order):  # a parent whose children act on others keeps its number, on which theirs depends
        if name in acting:
            emitters = preset.systems[name].emitters.values()
            acting |= {emitter.source.system for emitter in emitters if emitter.source is not None}
    return [name for name in order if name not in acting]


def galaxies(preset) -> list[str]:
    """The systems whose particles attract each other and share a mass that the preset gives: fewer attract as much."""

    def is_galaxy(system) -> bool:
        shared = all(getattr(emitter.scripted, "shares_mass", False) for emitter in system.emitters.values())
        gravity = [each for each in system.interactions if each.source_system is None]
        return bool(gravity) and shared and all(each.name == "self_gravity" for each in gravity)

    return [name for name, system in preset.systems.items() if is_galaxy(system)]


def _heavier(few, ratios: dict[str, float]) -> dict[str, tuple]:
    """The masses with which fewer bodies that feel nothing but each other's gravity attract as much as all of them."""
    changes = {}
    for name, system in few.systems.items():
        acting = [each.name for each in system.interactions if each.source_system is None]
        own = [part.mass or part.density for e in system.emitters.values() for part in (e, *e.choose.values())]
        scripted = any(emitter.scripted is not None for emitter in system.emitters.values())
        mass, ratio = system.particle.mass, ratios[name]
        if mass is None or scripted or any(own) or acting != ["self_gravity"] or system.forces or ratio <= 1:
            continue
        before, after = (f"{mass.lo * k:.6g}..{mass.hi * k:.6g}" for k in (1, ratio))
        changes[f"systems.{name}.particle.mass"] = (before, after)
    return changes


def _parents_first(preset) -> list[str]:
    order: list[str] = []

    def visit(name: str, above: tuple) -> None:
        for emitter in preset.systems[name].emitters.values():
            parent = emitter.source.system if emitter.source else ""
            if parent in preset.systems and parent not in (*above, name):
                visit(parent, (*above, name))
        if name not in order:
            order.append(name)

    for name in preset.systems:
        visit(name, ())
    return order


def _scaled(emitter, factor: float) -> tuple:
    """(the emitter with this part of its births, what has changed: (before, after) by key)."""
    changes: dict[str, tuple] = {}
    if getattr(emitter.scripted, "births", None) is not None:  # a spring net or a rigid body cannot be thinned
        return emitter, changes
    unit = 2 if emitter.source is not None and emitter.source.balance == "pairs" else 1
    update: dict[str, Any] = {}
    if emitter.rate is not None:
        changes["rate"] = _plain(emitter.rate), (rate := _rate(emitter.rate, factor))
        update["rate"] = Curve.of(rate) if isinstance(rate, list) else rate
    if emitter.count is not None:
        changes["count"] = _plain(emitter.count), (count := _count(emitter.count, factor, unit))
        update["count"] = Range.of(count)
    for name, choice in emitter.choose.items():
        if choice.count is not None:
            changes[f"choose.{name}.count"] = _plain(choice.count), (count := _count(choice.count, factor, unit))
            thin = choice.model_copy(update={"count": Range.of(count)})
            update["choose"] = {**update.get("choose", emitter.choose), name: thin}
    changes = {key: (before, after) for key, (before, after) in changes.items() if before != after}
    return emitter.model_copy(update=update), changes


def _rate(rate, factor: float):
    if isinstance(rate, Curve):
        return [[float(t), float(f"{r * factor:.4g}")] for t, r in rate.points]
    return float(f"{rate * factor:.4g}")


def _count(count: Range, factor: float, unit: int):
    lo, hi = (max(unit, unit * round(end * factor / unit)) if end > 0 else 0 for end in (count.lo, count.hi))
    return lo if lo == hi else f"{lo}..{hi}"


def _plain(value):
    if isinstance(value, Curve):
        return [[float(t), float(r)] for t, r in value.points]
    if isinstance(value, Range):
        lo, hi = round(value.lo), round(value.hi)
        return lo if lo == hi else f"{lo}..{hi}"
    return float(value)
