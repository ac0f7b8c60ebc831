"""What must fit across a whole preset: systems, tags and attributes that other parts refer to.

`references` works on plain data, so that it speaks even where another part of the file is wrong; what is no mapping is
skipped.
"""

from collections.abc import Iterator
from typing import Any

from gen_art.errors import UsageError
from gen_art.preset.look import Color
from gen_art.registry import suggest

__all__ = ["references", "unbound"]

_COLOR_KEYS = tuple(Color.model_fields)
Found = Iterator[tuple[tuple, str]]


def _mapping(value: Any) -> dict:
    return value if isinstance(value, dict) else {}


def _known(word, words) -> str:
    return suggest(word, words) or ("; there are " + ", ".join(words) if words else "")


def references(data: dict) -> Found:
    """(path, problem) of every reference that leads nowhere."""
    systems = _mapping(data.get("systems"))
    for name, system in systems.items():
        here = ("systems", name)
        if "." in name:
            yield here, "a name may not hold a dot: paths are written with dots"
        system = _mapping(system)
        declared = _mapping(_mapping(system.get("particle")).get("attributes"))
        for emitter_name, emitter in _mapping(system.get("emitters")).items():
            there = (*here, "emitters", emitter_name)
            if "." in emitter_name:
                yield there, "a name may not hold a dot: paths are written with dots"
            yield from _emitter(there, _mapping(emitter), systems, declared)
            yield from _impacts((*there, "from"), _mapping(emitter).get("from"), data, systems)
        for kind, interaction in _mapping(system.get("interactions")).items():
            yield from _sources((*here, "interactions", kind), interaction, systems)
        yield from _colors((*here, "look"), _mapping(system.get("look")), tags_of(system))


def tags_of(system: Any) -> list[str]:
    """Every tag that an emitter of a system, or one of its choices, gives."""
    tags: dict[str, None] = {}
    for emitter in _mapping(_mapping(system).get("emitters")).values():
        for one in (emitter, *_mapping(_mapping(emitter).get("choose")).values()):
            if isinstance(_mapping(one).get("tag"), str):
                tags[one["tag"]] = None
    return list(tags)


def _emitter(here: tuple, emitter: dict, systems: dict, declared: dict) -> Found:
    for owner, path in [(emitter, here)] + [
        (_mapping(choice), (*here, "choose", name)) for name, choice in _mapping(emitter.get("choose")).items()
    ]:
        for attribute in _mapping(owner.get("attributes")):
            if attribute not in declared:
                yield (
                    (*path, "attributes", attribute),
                    f"particle.attributes declares no '{attribute}'{_known(attribute, declared)}",
                )
    source = emitter.get("from")
    if source is None:
        return
    event = source if isinstance(source, str) else _mapping(source).get("event")
    if not isinstance(event, str) or "." not in event:
        return  # the schema says so
    feeding = event.rpartition(".")[0]
    if feeding not in systems:
        path = (*here, "from") if isinstance(source, str) else (*here, "from", "event")
        yield path, f"there is no system '{feeding}'{_known(feeding, systems)}"
        return
    tags = _mapping(source).get("tag")
    known = tags_of(systems[feeding])
    for tag in [tags] if isinstance(tags, str) else tags if isinstance(tags, list) else []:
        if isinstance(tag, str) and tag not in known:
            yield (*here, "from", "tag"), f"no emitter of '{feeding}' has the tag '{tag}'{_known(tag, known)}"


def _impacts(here: tuple, source: Any, data: dict, systems: dict) -> Found:
    """Impacts are told of by colliders that emit: without one, no particle would ever be born."""
    event = source if isinstance(source, str) else _mapping(source).get("event")
    feeding, _, kind = event.rpartition(".") if isinstance(event, str) else ("", "", "")
    if kind != "impact" or feeding not in systems:
        return
    system = _mapping(systems[feeding])
    walls = [system.get("colliders")]
    if system.get("inherit_colliders", True) is not False:
        walls.append(data.get("colliders"))
    for several in (one for kinds in walls for one in _mapping(kinds).values()):
        if any(_mapping(one).get("action") == "emit" for one in (several if isinstance(several, list) else [several])):
            return
    yield here, f"no collider of '{feeding}' has action: emit, so it has no impacts to tell of"


def unbound(preset) -> Found:
    """(path, problem) of every force of a Preset that needs what its medium does not give, such as a density."""
    for name, system in preset.systems.items():
        medium = system.medium or preset.medium
        shared = preset.forces if system.inherit_forces else ()
        for here, forces in ((("forces",), shared), (("systems", name, "forces"), system.forces)):
            for force in forces:
                try:
                    force.bound_numbers(medium)
                except UsageError as error:
                    yield (*here, force.name), str(error)


def _sources(here: tuple, interaction: Any, systems: dict) -> Found:
    for one in interaction if isinstance(interaction, list) else [interaction]:
        sources = _mapping(one).get("sources")
        for source in [sources] if isinstance(sources, str) else sources if isinstance(sources, list) else []:
            if isinstance(source, str) and source not in systems:
                yield (*here, "sources"), f"there is no system '{source}'{_known(source, systems)}"


def _colors(here: tuple, look: dict, tags: list[str]) -> Found:
    """A colour's other keys are tags of this system's emitters."""
    color = _mapping(look.get("emission")).get("color")
    for key in _mapping(color):
        if key not in _COLOR_KEYS and key not in tags:
            words = [*_COLOR_KEYS, *tags]
            yield (
                (*here, "emission", "color", key),
                f"is neither a key nor a tag of this system's emitters{_known(key, words)}",
            )
