"""Parts of a preset or of a simulation that have no effect: one sentence for each."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Union

from gen_art.emitters.births import ActiveEmitter
from gen_art.forces.base import Force
from gen_art.forces.medium import Medium
from gen_art.simulation.from_preset import systems_of
from gen_art.simulation.system import ParticleSystem

if TYPE_CHECKING:
    from gen_art.preset.clock import Clock
    from gen_art.preset.schema import Preset

__all__ = ["silent_parts", "undrawn_systems"]


def silent_parts(
    given: Union["Preset", ParticleSystem, Mapping[str, ParticleSystem]],
    members: Mapping[str, ParticleSystem] | None = None,
) -> list[str]:
    """A sentence for each part that does nothing: a field without charges, a medium that no force reads, and the like.

    given : a preset, a system, or systems by name, which no simulation has taken yet
    members : the systems of the preset, if they are made already
    """
    if isinstance(given, ParticleSystem):
        return list(_of_system(f"system {given.name}".strip(), given, [given]))
    if isinstance(given, Mapping):
        of_systems = [_of_system(f"systems.{name}", one, list(given.values())) for name, one in given.items()]
        of_media = [_of_medium(f"systems.{name}.medium", one.medium, [one]) for name, one in given.items()]
        return [line for lines in (*of_systems, *of_media) for line in lines]
    members = systems_of(given) if members is None else members
    lines: list[str] = []
    for name, system in members.items():
        place = f"systems.{name}"
        lines += _of_system(place, system, list(members.values()))
        if not system.emitters:
            lines.append(f"{place} has no emitters: no particle is ever born. Give it one, or remove the system")
        for key, look in given.systems[name].all_looks.items():
            if look.side != "near" and given.wormhole is None:
                lines.append(
                    f"{place}.{key}.side has no effect, because there is no `wormhole`: give the preset one, or leave it out"
                )
            if look.flashes is not None and look.draw == "sphere" and given.light is None and given.sky is None:
                lines.append(
                    f"{place}.{key}.flashes has no effect, because balls are solid only in a light: give the preset a `light` or "
                    "a `sky`, or leave it out"
                )
        for emitter in system.emitters:
            lines += _of_emitter(f"{place}.emitters.{emitter.name}", emitter, given.clock)
        if given.systems[name].medium is not None:
            lines += _of_medium(f"{place}.medium", system.medium, [system])
    shared = [system for name, system in members.items() if given.systems[name].medium is None]
    if shared:
        lines += _of_medium("medium", shared[0].medium, shared)
    return lines


def undrawn_systems(preset: "Preset") -> list[str]:
    """A sentence for each system without a look that no other system uses: nothing of it is seen in a picture."""
    return [
        f"systems.{name} has no look, so it is not drawn: give it one, such as {{draw: point}}, or remove the system"
        for name, system in preset.systems.items()
        if not system.all_looks and not any(name in needed for needed in _needed(preset))
    ]


def _needed(preset: "Preset") -> Iterator[tuple[str, ...]]:
    """The systems that others use, which have an effect without being drawn."""
    for other in preset.systems.values():
        yield tuple(emitter.source.system for emitter in other.emitters.values() if emitter.source is not None)
        yield tuple(one.source_system for one in other.interactions if one.source_system is not None)
        yield from (look.light.glow for look in other.all_looks.values() if look.light is not None)


def _of_system(place: str, system: ParticleSystem, members: list[ParticleSystem]) -> Iterator[str]:
    """Forces on an attribute that is 0 for all particles; a force that several systems share needs it in one of them."""
    for law in (*system.forces, *system.interactions):
        for attribute in sorted(_reads(law)):
            others = [one for one in members if law in one.forces]
            if not any(one.may_have(attribute) for one in (system, *others)):
                yield (
                    f"{place}: {law.name} has no effect, because the {attribute} of every particle is 0: give the particles "
                    f"{'an' if attribute[0] in 'aeiou' else 'a'} {attribute}, or leave {law.name} out"
                )


def _reads(law) -> set[str]:
    """The attributes without which a force or an interaction is 0."""
    if isinstance(law, Force):
        fields = [name for name in ("electric", "magnetic") if law.provides(name)]
        others = [name for name in ("acceleration", "force", "damping") if law.provides(name)]
        return ({"charge"} if fields and not others else set()) | set(law.needs)
    if law.source_system is not None:  # the charges and masses are those of another system
        return set()
    return {"charge"} if law.name == "coulomb" else {"mass"} if law.name == "self_gravity" else set()


def _of_emitter(place: str, emitter: ActiveEmitter, clock: "Clock") -> Iterator[str]:
    if emitter.schedule is not None and not emitter.schedule.until(clock.simulated):
        yield (
            f"{place} gives no birth within the {clock.simulated:g} s that are simulated: give it a higher rate, a count, or an "
            "earlier start"
        )
    if emitter.event is not None and emitter.event.kind != "path" and not any(kind.count[1] for kind in emitter.kinds):
        yield f"{place} gives no birth, because its count is 0: raise it, or remove the emitter"
    if emitter.event is not None and emitter.event.kind == "path" and not emitter.event.rate:
        yield f"{place} gives no birth, because its rate is 0: raise it, or remove the emitter"
    for kind in emitter.kinds:
        longest = kind.attributes["lifetime"][1]
        if longest < clock.step:
            yield (
                f"{place}: a lifetime of {longest:g} s is shorter than the step of {clock.step:g} s, so its particles move and "
                "show for less than a step: give them a longer one, or the clock a shorter step"
            )
            break


def _of_medium(place: str, medium: Medium, readers: list[ParticleSystem]) -> Iterator[str]:
    if (medium.terms or medium.density) and not any(_reads_medium(law) for system in readers for law in system.forces):
        yield f"{place} has no effect, because no force reads it: add drag, damping, lift or buoyancy, or leave it out"


def _reads_medium(force: Force) -> bool:
    own_density = force.values.get("density") is not None
    return force.reads_medium or force.provides("damping") or ("density" in force.parameters and not own_density)
