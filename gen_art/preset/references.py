"""Checks across a whole preset: the systems, tags and attributes to which other parts refer must exist.

`references` works on plain data, so it finds problems even when another part of the file is wrong; values of the wrong type
are skipped.
"""

import keyword
from collections.abc import Iterator, Mapping
from typing import Any

from gen_art.errors import UsageError
from gen_art.forces.medium import Medium
from gen_art.interactions.ledger_labels import check_entry, composition_of, ledger_rows
from gen_art.preset.look import Color
from gen_art.registry import suggest

__all__ = ["references", "unbooked", "unbound"]

LONGEST_NAME = 100  # characters of a name that a preset defines
MOST_ATTRIBUTES = 64
RESERVED = (
    "position", "velocity", "mass", "charge", "radius", "age", "lifetime", "key", "id", "flow", "since", "step", "birth",
)  # fmt: skip
_COLOR_KEYS = tuple(Color.model_fields)
Problems = Iterator[tuple[tuple, str]]  # (path, problem)


def _mapping(value: Any) -> dict:
    return value if isinstance(value, dict) else {}


def _choices(word, words) -> str:
    """The end of a message about an unknown word: the nearest word, or all words."""
    return suggest(word, words) or ("; there are " + ", ".join(words) if words else "")


def references(data: dict) -> Problems:
    """(path, problem) of every reference to something that does not exist."""
    systems = _mapping(data.get("systems"))
    for name, system in systems.items():
        here = ("systems", name)
        yield from _name(here, name)
        system = _mapping(system)
        declared = _mapping(_mapping(system.get("particle")).get("attributes"))
        yield from _attributes((*here, "particle", "attributes"), declared)
        for emitter_name, emitter in _mapping(system.get("emitters")).items():
            there = (*here, "emitters", emitter_name)
            yield from _name(there, emitter_name)
            yield from _emitter(there, _mapping(emitter), systems, declared)
            yield from _impacts((*there, "from"), _mapping(emitter).get("from"), data, systems)
        for kind, interaction in _mapping(system.get("interactions")).items():
            yield from _sources((*here, "interactions", kind), interaction, systems)
        looks: dict[tuple, Any] = {("look",): system.get("look")}
        for key, look in _mapping(system.get("looks")).items():
            yield from _name((*here, "looks", key), key)
            looks["looks", key] = look
        for path, look in looks.items():
            yield from _colors((*here, *path), _mapping(look), tags_of(system))
            yield from _tags((*here, *path, "tag"), _mapping(look).get("tag"), name, system)
    frame = _mapping(_mapping(data.get("camera")).get("frame"))
    subject = frame.get("of")
    for name in [subject] if isinstance(subject, str) else subject if isinstance(subject, list) else []:
        if isinstance(name, str) and name not in systems:
            yield ("camera", "frame", "of"), f"there is no system '{name}'{_choices(name, systems)}"
        elif isinstance(name, str) and _mapping(systems[name]).get("look") is None:
            yield ("camera", "frame", "of"), f"'{name}' has no look, so it is not seen"
    follow = _mapping(data.get("camera")).get("follow")
    name = follow.get("system") if isinstance(follow, Mapping) else follow
    if isinstance(name, str) and name not in systems:
        where = ("camera", "follow", *(["system"] if isinstance(follow, Mapping) else []))
        yield where, f"there is no system '{name}'{_choices(name, systems)}"
    lights: list[tuple[tuple, Any]] = [(("light",), data.get("light"))]
    lights += [
        (("systems", n, "look", "light"), _mapping(_mapping(s).get("look")).get("light")) for n, s in systems.items()
    ]
    for here, light in lights:
        named = _mapping(light).get("glow")
        for name in [named] if isinstance(named, str) else named if isinstance(named, list) else []:
            if isinstance(name, str) and name not in systems:
                yield (*here, "glow"), f"there is no system '{name}'{_choices(name, systems)}"
            elif isinstance(name, str) and _mapping(systems[name]).get("look") is None:
                yield (*here, "glow"), f"'{name}' has no look, so it emits no light"
    labels = data.get("labels")
    for k, label in enumerate(labels if isinstance(labels, list) else []):
        followed = _mapping(label).get("follow")
        if isinstance(followed, str) and followed not in systems:
            yield ("labels", k, "follow"), f"there is no system '{followed}'{_choices(followed, systems)}"


def _name(here: tuple, name: str) -> Problems:
    if "." in name:
        yield here, "a name may not contain a dot: paths are written with dots"
    elif not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        yield here, f"a name may not be empty, have more than {LONGEST_NAME} characters or any that is not printable"


def _attributes(here: tuple, declared: dict) -> Problems:
    """Names of declared attributes are words of a kernel: p.name."""
    if len(declared) > MOST_ATTRIBUTES:
        yield here, f"a particle has at most {MOST_ATTRIBUTES} attributes of its own, not {len(declared)}"
    for name in declared:
        if name in RESERVED:
            yield (*here, name), f"a name may not be {name}: every particle has that already"
        elif not name.isidentifier() or keyword.iskeyword(name) or len(name) > LONGEST_NAME:
            yield (*here, name), "a name may not be other than letters, digits and _, because forces read it as p.name"


def tags_of(system: Any) -> list[str]:
    """Every tag of a system's emitters and of their choices."""
    tags: dict[str, None] = {}
    for emitter in _mapping(_mapping(system).get("emitters")).values():
        for tagged in (emitter, *_mapping(_mapping(emitter).get("choose")).values()):
            if isinstance(_mapping(tagged).get("tag"), str):
                tags[tagged["tag"]] = None
    return list(tags)


def _emitter(here: tuple, emitter: dict, systems: dict, declared: dict) -> Problems:
    for owner, path in [(emitter, here)] + [
        (_mapping(choice), (*here, "choose", name)) for name, choice in _mapping(emitter.get("choose")).items()
    ]:
        for attribute in _mapping(owner.get("attributes")):
            if attribute not in declared:
                yield (
                    (*path, "attributes", attribute),
                    f"particle.attributes declares no '{attribute}'{_choices(attribute, declared)}",
                )
    source = emitter.get("from")
    if source is None:
        return
    event = source if isinstance(source, str) else _mapping(source).get("event")
    if not isinstance(event, str) or "." not in event:
        return  # the schema reports it
    parent = event.rpartition(".")[0]
    if parent not in systems:
        path = (*here, "from") if isinstance(source, str) else (*here, "from", "event")
        yield path, f"there is no system '{parent}'{_choices(parent, systems)}"
        return
    yield from _tags((*here, "from", "tag"), _mapping(source).get("tag"), parent, systems[parent])


def _tags(here: tuple, tags: Any, name: str, system: Any) -> Problems:
    """Tags must be those of a system's emitters."""
    known = tags_of(system)
    for tag in [tags] if isinstance(tags, str) else tags if isinstance(tags, list) else []:
        if isinstance(tag, str) and tag not in known:
            yield here, f"no emitter of '{name}' has the tag '{tag}'{_choices(tag, known)}"


def _impacts(here: tuple, source: Any, data: dict, systems: dict) -> Problems:
    """Events of impacts need a collider with `action: emit`; without one, no particle would be born."""
    event = source if isinstance(source, str) else _mapping(source).get("event")
    parent, _, kind = event.rpartition(".") if isinstance(event, str) else ("", "", "")
    if kind != "impact" or parent not in systems:
        return
    system = _mapping(systems[parent])
    groups = [system.get("colliders")]
    if system.get("inherit_colliders", True) is not False:
        groups.append(data.get("colliders"))
    for entry in (entry for group in groups for entry in _mapping(group).values()):
        colliders = entry if isinstance(entry, list) else [entry]
        if any(_mapping(collider).get("action") == "emit" for collider in colliders):
            return
    yield here, f"no collider of '{parent}' has action: emit, so there are no events of impacts"


def unbound(preset) -> Problems:
    """(path, problem) of what a Preset's forces and interactions need and do not have, such as a density, or an open space."""
    for name, system in preset.systems.items():
        for interaction in system.interactions if preset.domain is not None else ():
            if (problem := interaction.problem_in(preset.domain.box, _largest_radius(system))) is not None:
                yield ("systems", name, "interactions", interaction.name), problem
    for name, system in preset.systems.items():
        medium = system.medium or preset.medium
        shared = preset.forces if system.inherit_forces else ()
        for here, forces in ((("forces",), shared), (("systems", name, "forces"), system.forces)):
            for force in forces:
                try:
                    force.bound_numbers(medium)
                except UsageError as error:
                    yield (*here, force.name), str(error)


def _largest_radius(system) -> float:
    """The largest radius, m, that the keys of a system give its particles; 0 where none gives any."""
    births = [birth for emitter in system.emitters.values() for birth in (emitter, *emitter.choose.values())]
    return max((keys.radius.hi for keys in (system.particle, *births) if keys.radius is not None), default=0.0)


def unbooked(preset) -> Problems:
    """(path, problem) of every `by` of a look that names an entry which the ledger of its system does not have."""
    for name, system in preset.systems.items():
        wanted = {
            (*key.split(".", 1), *path): entry
            for key, look in system.all_looks.items()
            for path, (entry, _) in look.ledger_ramps(system.particle.attributes).items()
        }
        if not wanted:
            continue
        forces = [*(preset.forces if system.inherit_forces else ()), *system.forces]
        colliders = [*(preset.colliders if system.inherit_colliders else ()), *system.colliders]
        medium = system.medium if system.medium is not None else preset.medium
        try:
            composition = composition_of(
                forces, Medium(density=medium.density, field=medium.terms), colliders, system.interactions
            )
        except UsageError:
            continue  # check_preset reports it
        rows = ledger_rows(composition, system.interactions)
        for path, entry in wanted.items():
            try:
                check_entry(entry, rows, system.interactions)
            except UsageError as error:
                yield ("systems", name, *path, "by", *([entry.kind] if entry.name else [])), str(error)


def _sources(here: tuple, interaction: Any, systems: dict) -> Problems:
    for entry in interaction if isinstance(interaction, list) else [interaction]:
        sources = _mapping(entry).get("sources")
        for source in [sources] if isinstance(sources, str) else sources if isinstance(sources, list) else []:
            if isinstance(source, str) and source not in systems:
                yield (*here, "sources"), f"there is no system '{source}'{_choices(source, systems)}"


def _colors(here: tuple, look: dict, tags: list[str]) -> Problems:
    """Keys of a colour that the schema does not know must be tags of this system's emitters."""
    color = _mapping(look.get("emission")).get("color")
    for key in _mapping(color):
        if key not in _COLOR_KEYS and key not in tags:
            words = [*_COLOR_KEYS, *tags]
            yield (
                (*here, "emission", "color", key),
                f"is neither a key nor a tag of this system's emitters{_choices(key, words)}",
            )
