"""Builds the ParticleSystems of a Simulation from a Preset."""

import math
from typing import TYPE_CHECKING

from gen_art.emitters.births import ActiveEmitter, BirthEvent, BirthKind, EmitterMotion
from gen_art.emitters.schedule import Burst, Pulse, Rate, Schedule
from gen_art.forces.medium import Medium
from gen_art.simulation.system import ParticleSystem

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["system_of", "systems_of"]

_DEFAULTS = {"radius": (0.01, 0.01), "mass": (1.0, 1.0), "charge": (0.0, 0.0), "lifetime": (math.inf, math.inf)}


def systems_of(preset: "Preset") -> dict[str, ParticleSystem]:
    """A ParticleSystem for each system of a preset, in the preset's order."""
    return {name: system_of(preset, name) for name in preset.systems}


def system_of(preset: "Preset", name: str) -> ParticleSystem:
    """The ParticleSystem of one system of a preset."""
    spec = preset.systems[name]
    system = ParticleSystem(
        forces=[*(preset.forces if spec.inherit_forces else ()), *spec.forces],
        interactions=[interaction.fresh() for interaction in spec.interactions],
        colliders=[*(preset.colliders if spec.inherit_colliders else ()), *spec.colliders],
        integrator=spec.integrator,
        speed_of_light=spec.speed_of_light,
        exact_gyration=spec.exact_gyration,
        medium=_medium(spec.medium if spec.medium is not None else preset.medium),
        emitters=[_emission(key, emitter, spec.particle) for key, emitter in spec.emitters.items()],
        look=spec.look,
        booked=spec.ledger_entries,
    )
    if preset.domain is not None:
        system.enter(preset.domain.box)
    return system


def _medium(spec) -> Medium:
    return Medium(density=spec.density, field=spec.terms)


def _emission(name: str, spec, particle) -> ActiveEmitter:
    source = spec.source
    if source is not None:
        rate = float(spec.rate) if source.kind == "path" else 0.0
        event = BirthEvent(
            source.system, source.kind, tuple(source.tag), source.inherit == "velocity", source.balance == "pairs", rate
        )
        return ActiveEmitter(name, _kinds(name, spec, particle), event=event)
    motion = None
    if spec.motion is not None:
        orbit = spec.motion.orbit
        circle = {} if orbit is None else {
            "radius": orbit.radius, "period": orbit.period, "axis": orbit.axis, "phase": math.radians(orbit.phase),
        }  # fmt: skip
        motion = EmitterMotion(velocity=spec.motion.velocity, **circle)
    start = spec.start or 0.0
    if spec.rate is not None:
        rate = spec.rate if isinstance(spec.rate, (int, float)) else spec.rate.points
        pulse = None if spec.pulse is None else Pulse(spec.pulse.period, spec.pulse.depth, spec.pulse.duty)
        schedule: Schedule = Rate(rate, start, spec.stop, pulse)
    else:
        count = 1 if spec.count is None else round(spec.count.hi)
        schedule = Burst(spec.at if spec.at is not None else (start,), count)
    return ActiveEmitter(name, _kinds(name, spec, particle), schedule, motion=motion)


def _kinds(name: str, spec, particle) -> list[BirthKind]:
    if not spec.choose:
        return [_kind(name, spec, spec, particle)]
    return [_kind(f"{name}.{key}", choice, spec, particle) for key, choice in spec.choose.items()]


def _kind(name: str, spec, emitter, particle) -> BirthKind:
    """One kind of birth. A value comes from its spec, else from its emitter, its system's particle, or the default."""
    levels = [spec, emitter, particle] if spec is not emitter else [spec, particle]

    def first(key):
        return next((getattr(level, key) for level in levels if getattr(level, key, None) is not None), None)

    attributes = {}
    for key, default in _DEFAULTS.items():
        value = first(key)
        attributes[key] = default if value is None else (value.lo, value.hi)
    for level in levels:  # mass and density are alternatives: the first level that gives one of them decides
        if level.density is not None:
            attributes["density"] = (level.density.lo, level.density.hi)
            break
        if level.mass is not None:
            break
    for level in reversed(levels):
        attributes |= {key: (value.lo, value.hi) for key, value in level.attributes.items()}
    scripted = getattr(emitter, "scripted", None)
    for key in getattr(scripted, "declares", ()):
        attributes.setdefault(key, (0.0, 0.0))
    count = first("count")
    return BirthKind(
        name=name,
        tag=first("tag"),
        shape=first("shape"),
        velocity=first("velocity"),
        scripted=scripted,
        attributes=attributes,
        weight=getattr(spec, "weight", 1.0),
        count=(1, 1) if count is None else (round(count.lo), round(count.hi)),
    )
