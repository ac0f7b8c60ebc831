"""What a system's laws promise, read from the flags of its forces: what is conserved, and the order."""

from gen_art.forces.base import loses_mass
from gen_art.integrators import scheme

__all__ = ["colliders_of", "expected_order", "forces_of", "has_kinks", "has_stiff_springs", "invariants"]

_SMOOTH = {"curl_noise": 3}  # the order that a field with kinks in its second derivatives leaves to any scheme
_PREDICTED = 3  # quadratic drag takes its rate at a predicted middle
_IMPACTS = 2  # of the path inside a step
_ALONG_PATHS = 3  # children along a path stand on a cubic through their parent's step


def forces_of(preset, system) -> tuple:
    """The forces on a system: the preset's shared ones, then its own."""
    return (*(preset.forces if system.inherit_forces else ()), *system.forces)


def colliders_of(preset, system) -> tuple:
    """The colliders in the way of a system: the preset's shared ones, then its own."""
    return (*(preset.colliders if system.inherit_colliders else ()), *system.colliders)


def invariants(preset, system) -> tuple[list[str], dict[str, str]]:
    """What a system should conserve, and for what it does not, why: the ledger books the difference."""
    forces, interactions = forces_of(preset, system), system.interactions
    working = [force.name for force in forces if not force.conservative and force.does_work]
    working += [
        one.name
        for one in interactions
        if not one.conservative or one.source_system or one.implicit or len(one.parts) > 1
    ]
    outer = [force.name for force in forces]
    outer += [one.name for one in interactions if not one.reciprocal or one.source_system]
    walls = colliders_of(preset, system)
    working += [one.name for one in walls if one.takes_energy]
    outer += [one.name for one in walls]
    mortal = [name for name, emitter in system.emitters.items() if _goes_on(system, emitter)]
    holds, booked = [], {}
    for quantity, reasons, why in (
        ("energy", working, "worked on by "),
        ("momentum", outer, "pushed by "),
        ("angular momentum", outer, "turned by "),
        ("mass", [force.name for force in forces if loses_mass(force)], "burnt by "),
        ("charge", [], ""),
    ):
        if reasons:
            booked[quantity] = why + ", ".join(dict.fromkeys(reasons))
        elif mortal:
            booked[quantity] = "births and deaths (" + ", ".join(mortal) + ")"
        else:
            holds.append(quantity)
    return holds, booked


def _goes_on(system, emitter) -> bool:
    """Whether an emitter's particles come or go after the start."""
    lifetime = emitter.lifetime or system.particle.lifetime
    at_once = emitter.count is not None and emitter.at is None and emitter.source is None and not emitter.start
    return lifetime is not None or not at_once


def has_stiff_springs(system) -> bool:
    """Whether springs are solved by backward Euler, at steps that do not follow their swings."""
    return any(one.implicit and one.values.get("method") in ("implicit", "xpbd") for one in system.interactions)


def has_kinks(preset, name: str) -> bool:
    """Whether a system moves in a field with kinks: each that is met errs by its place in the step."""
    system = preset.systems[name]
    fields = (*forces_of(preset, system), *(system.medium or preset.medium).terms)
    return any(field.name in _SMOOTH for field in fields)


def expected_order(preset, name: str, seen: tuple = ()) -> int:
    """The order at which a system's positions should converge: its scheme's, its fields' and its parents' least."""
    system = preset.systems[name]
    used = scheme(system.integrator)
    order = used.order
    turned = [
        f for f in forces_of(preset, system) if f.depends_on_velocity and not (used.pusher and f.provides("magnetic"))
    ]
    if used.kind == "splitting" and turned:
        order = 1
    if used.kind == "splitting" and any(
        f.provides("damping") and f.quadratic_damping for f in forces_of(preset, system)
    ):
        order = min(order, _PREDICTED)
    if colliders_of(preset, system) or any(one.name == "contacts" for one in system.interactions):
        order = min(order, _IMPACTS)
    fields = (*forces_of(preset, system), *(system.medium or preset.medium).terms)
    order = min([order, *(_SMOOTH.get(field.name, order) for field in fields)])
    for emitter in system.emitters.values():
        if emitter.source is not None and emitter.source.system not in (*seen, name):
            order = min(order, expected_order(preset, emitter.source.system, (*seen, name)))
            order = min(order, _ALONG_PATHS) if emitter.source.kind == "path" else order
    return order
