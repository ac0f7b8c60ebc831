"""What the flags of a system's forces imply: the conserved quantities and the order of convergence."""

from gen_art.forces.base import loses_mass
from gen_art.integrators import scheme

__all__ = ["colliders_of", "expected_order", "forces_of", "has_kinks", "has_stiff_springs", "invariants"]

# the highest order of any scheme, with:
_KINKED_FIELDS = {"curl_noise": 3}  # fields with kinks in their second derivatives
_QUADRATIC_DRAG = 3  # because its rate is taken at a predicted midpoint
_IMPACTS = 2  # because of the path inside a step
_BOUNDARY = "the periodic boundary"
# forces and fields that are the same everywhere: others jump at the sides of a periodic box, which are crossed within a step
_UNIFORM = (
    "damping", "drag", "driver", "electric_field", "gravity", "langevin", "lift", "magnetic_field", "panel", "thrust", "wind",
)  # fmt: skip
_JUMPS = 1
_BIRTHS_ALONG_PATHS = 3  # because children are born on a cubic through their parent's step


def forces_of(preset, system) -> tuple:
    """The forces on a system: the preset's shared ones, then its own."""
    return (*(preset.forces if system.inherit_forces else ()), *system.forces)


def colliders_of(preset, system) -> tuple:
    """The colliders of a system: the preset's shared ones, then its own."""
    return (*(preset.colliders if system.inherit_colliders else ()), *system.colliders)


def invariants(preset, system) -> tuple[list[str], dict[str, str]]:
    """(the quantities that a system should conserve, by every other quantity the reason that it changes).

    The ledger accounts for the quantities that change.
    """
    forces, interactions = forces_of(preset, system), system.interactions
    working = [force.name for force in forces if not force.conservative and force.does_work]
    working += [
        interaction.name
        for interaction in interactions
        if not interaction.conservative
        or interaction.source_system
        or interaction.implicit
        or any(part.dissipates for part in interaction.parts)
    ]
    external = [force.name for force in forces]
    external += [
        interaction.name for interaction in interactions if not interaction.reciprocal or interaction.source_system
    ]
    colliders = colliders_of(preset, system)
    working += [collider.name for collider in colliders if collider.takes_energy]
    external += [collider.name for collider in colliders]
    turning = list(external)
    if preset.domain is not None:
        turning.append(_BOUNDARY)
        if any(_potential_jumps(force, preset.domain.box) for force in forces):
            working.append(_BOUNDARY)
    changing = [name for name, emitter in system.emitters.items() if _has_births_or_deaths(system, emitter)]
    conserved, booked = [], {}
    for quantity, names, verb in (
        ("energy", working, "worked on by "),
        ("momentum", external, "pushed by "),
        ("angular momentum", turning, "turned by "),
        ("mass", [force.name for force in forces if loses_mass(force)], "burnt by "),
        ("charge", [], ""),
    ):
        if names:
            booked[quantity] = verb + ", ".join(dict.fromkeys(names))
        elif changing:
            booked[quantity] = "births and deaths (" + ", ".join(changing) + ")"
        else:
            conserved.append(quantity)
    return conserved, booked


def _potential_jumps(force, box) -> bool:
    """Whether the potential of a force changes where a particle is wrapped; that of a uniform field may be the same."""
    if not force.provides("potential"):
        return False
    if force.name not in _UNIFORM:
        return True
    return any(component for component, length in zip(force.values["field"], box.lengths) if length > 0)


def _has_births_or_deaths(system, emitter) -> bool:
    """Whether an emitter's particles are born or die after the start."""
    lifetime = emitter.lifetime or system.particle.lifetime
    at_once = emitter.count is not None and emitter.at is None and emitter.source is None and not emitter.start
    return lifetime is not None or not at_once


def has_stiff_springs(system) -> bool:
    """Whether springs are solved implicitly, with steps too long to follow their oscillations."""
    methods = [interaction.values.get("method") for interaction in system.interactions if interaction.implicit]
    return any(method in ("implicit", "xpbd") for method in methods)


def has_kinks(preset, name: str) -> bool:
    """Whether a system moves in a field with kinks. The error of a kink depends on where in a step it is crossed."""
    system = preset.systems[name]
    fields = (*forces_of(preset, system), *(system.medium or preset.medium).terms)
    return any(field.name in _KINKED_FIELDS for field in fields)


def expected_order(preset, name: str, seen: tuple = ()) -> int:
    """The order at which a system's positions should converge: the least of its scheme, its fields and its parents.

    seen : systems whose children are being followed
    """
    system = preset.systems[name]
    used = scheme(system.integrator)
    order = used.order
    velocity_dependent = [
        f for f in forces_of(preset, system) if f.depends_on_velocity and not (used.pusher and f.provides("magnetic"))
    ]
    if used.kind == "splitting" and velocity_dependent:
        order = 1
    if used.kind == "splitting" and any(
        f.provides("damping") and f.quadratic_damping for f in forces_of(preset, system)
    ):
        order = min(order, _QUADRATIC_DRAG)
    if colliders_of(preset, system) or any(interaction.name == "contacts" for interaction in system.interactions):
        order = min(order, _IMPACTS)
    fields = (*forces_of(preset, system), *(system.medium or preset.medium).terms)
    order = min([order, *(_KINKED_FIELDS.get(field.name, order) for field in fields)])
    if preset.domain is not None and any(field.name not in _UNIFORM for field in fields):
        order = min(order, _JUMPS)
    for emitter in system.emitters.values():
        if emitter.source is not None and emitter.source.system not in (*seen, name):
            order = min(order, expected_order(preset, emitter.source.system, (*seen, name)))
            order = min(order, _BIRTHS_ALONG_PATHS) if emitter.source.kind == "path" else order
    return order
