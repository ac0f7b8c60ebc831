"""Warnings about integrators or time steps that do not suit a preset's forces, each with a better choice."""

import math
import warnings

from gen_art.audit.invariants import colliders_of, expected_order, forces_of
from gen_art.integrators import scheme
from gen_art.interactions import Interaction
from gen_art.simulation.from_preset import systems_of

__all__ = ["KNOWN_MAGNETIC_FIELDS", "advice", "gyration_advice", "step_advice"]

_LARGEST_GYRATION = 0.1  # rad a step: the phase lags by its square / 12, a thousandth of a turn each turn
_EXACT_UP_TO = 3.0  # rad a step: the limit of exact_gyration
_LARGEST_TURN = 1.0  # rad a step of a driver or a collider
_STEEPEST = 1.05  # m a metre: the most that interpolating a true distance between grid points gives
KNOWN_MAGNETIC_FIELDS = ("magnetic_field", "magnetic_mirror")  # their strength is known before a run


def advice(preset) -> list[str]:
    """Warnings about the systems of a preset that follow from its numbers, without running it."""
    sentences = []
    built = systems_of(preset)
    for name, system in preset.systems.items():
        used = scheme(system.integrator)
        for check in (_velocity_dependent_forces, _explicit_euler, _lost_order, _colliders, _unused_options):
            sentences += [f"{name}: {sentence}" for sentence in check(preset, name, system, used)]
        masses, charge = _masses_and_largest_charge(built[name])
        sentences += [f"{name}: {s}" for s in _gyration(preset, system, used, min(masses, default=1.0), charge)]
        sentences += [f"{name}: {s}" for s in _oscillations(preset, system, used, min(masses, default=1.0))]
    return sentences


def step_advice(preset) -> list[str]:
    """Warnings of springs and contacts about the time step.

    They need the particles, so the simulation is built if the preset has such interactions.
    """
    interactions = [i for system in preset.systems.values() for i in system.interactions]
    if not any(type(interaction).attach is not Interaction.attach for interaction in interactions):
        return []
    from gen_art.simulation import Simulation

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Simulation(preset, precision="f64")
    return [str(warning.message) for warning in caught if issubclass(warning.category, UserWarning)]


def _velocity_dependent_forces(preset, name, system, used):
    """Schemes that treat velocity-dependent forces as plain kicks; relativistic pushers without a speed of light."""
    forces = forces_of(preset, system)
    turning = ", ".join(dict.fromkeys(f.name for f in forces if f.provides("magnetic")))
    velocity_dependent = ", ".join(
        dict.fromkeys(f.name for f in forces if f.depends_on_velocity and not f.provides("magnetic"))
    )
    if turning and not used.pusher:
        problem = (
            f"does not keep the speed under {turning}"
            if used.kind == "runge_kutta"
            else f"takes {turning}, which depends on the velocity, as a plain kick: order 1, and the speed grows"
        )
        yield f"{used.name} {problem}; boris turns the velocity exactly"
    if velocity_dependent and used.kind == "splitting":
        yield (
            f"{used.name} takes {velocity_dependent}, which depends on the velocity, as a plain kick: order 1; "
            "rk2 has order 2, rk4 order 4"
        )
    if used.pusher not in ("", "boris") and system.speed_of_light is None:
        yield f"{used.name} without speed_of_light takes the same steps as boris; use boris, or set speed_of_light"


def _explicit_euler(preset, name, system, used):
    if used.kind != "runge_kutta" or used.order > 1:
        return
    forces = forces_of(preset, system)
    conservative = [f.name for f in forces if f.conservative and f.provides("potential")]
    conservative += [interaction.name for interaction in system.interactions if interaction.conservative]
    under = f" under {', '.join(dict.fromkeys(conservative))}" if conservative else ""
    better = "boris" if any(f.provides("magnetic") for f in forces) else "leapfrog"
    yield f"explicit euler gains energy{under} at every step; {better} has order 2 at the same cost"


def _lost_order(preset, name, system, used):
    """Schemes of order 4 whose order is reduced by the system's forces or colliders."""
    order = expected_order(preset, name)
    if used.order <= 2 or order >= used.order:
        return
    if colliders_of(preset, system):
        yield f"impacts inside a step are of order 2, so {used.name} has no more; leapfrog costs less"
    elif used.kind == "splitting" and any(
        f.provides("damping") and f.quadratic_damping for f in forces_of(preset, system)
    ):
        yield f"{used.name} has order {order} with quadratic drag; rk4 keeps order 4"


def _colliders(preset, name, system, used):
    """Grids that are not signed distances, and surfaces that turn too far in a step."""
    dt = preset.clock.step
    for collider in colliders_of(preset, system):
        steepness = collider.steepness if collider.name == "sdf" else 0.0
        if steepness > _STEEPEST:
            yield (
                f"sdf: the grid grows by up to {steepness:.3g} m a metre, where a distance grows by 1: fast particles may "
                f"pass through its surface; divide it by {steepness:.3g}, or check `min` and `max`"
            )
        turn = math.hypot(*collider.values["angular_velocity"]) * dt
        if turn > _LARGEST_TURN:
            yield (
                f"{collider.name} turns by {turn:.3g} rad a step, so particles are struck at the wrong place; "
                f"use a step of at most {dt * _LARGEST_TURN / turn:.3g} s"
            )


def _unused_options(preset, name, system, used):
    """Options that have no effect, with the reason."""
    for interaction in system.interactions:
        theta = type(interaction).parameters.get("theta")
        values = interaction.values
        if theta is not None and values["method"] == "direct" and values["theta"] != theta.default:
            yield (
                f"{interaction.name}: theta has no effect with method: direct, which sums over every pair; "
                "method: tree uses it"
            )


def _gyration(preset, system, used, lightest, charge):
    """The gyration angle a step in uniform fields and at the middle of mirrors; an audit measures that of other fields."""
    fields = [f for f in forces_of(preset, system) if f.name in KNOWN_MAGNETIC_FIELDS]
    if used.pusher and charge and lightest > 0:
        strengths = [f.values["field"] if f.name == "magnetic_field" else (f.values["strength"],) for f in fields]
        w = charge * sum(math.hypot(*strength) for strength in strengths) / lightest
        yield from gyration_advice(w, preset.clock.step, system.exact_gyration)


def gyration_advice(w: float, dt: float, exact: bool):
    """A warning if charges turn by more than 0.1 rad a step, so that their phase lags by more than about a thousandth.

    w : angular frequency of the gyration, 1/s
    exact : whether exact_gyration is on
    """
    if w * dt > _LARGEST_GYRATION and not (exact and w * dt < _EXACT_UP_TO):
        better = f"use a step of at most {_LARGEST_GYRATION / w:.3g} s"
        if w * dt < _EXACT_UP_TO:
            better += ", or exact_gyration: true where the field varies little"
        lag = 1 - math.atan(w * dt / 2) / (w * dt / 2)
        yield f"charges turn by w dt = {w * dt:.3g} rad a step, and lag by {lag:.2%} of it; {better}"


def _oscillations(preset, system, used, lightest):
    """Springs to a point, linear central forces and drivers that oscillate too fast for the step."""
    dt, forces = preset.clock.step, forces_of(preset, system)
    springs = [f for f in forces if f.name == "spring"]
    linear = [
        f for f in forces if f.name == "central_force" and f.values["exponent"] == 1 and not f.values.get("per_charge")
    ]
    w_squared = sum(f.values["strength"] for f in linear)
    w_squared += sum(f.values["stiffness"] for f in springs) / lightest if lightest > 0 else 0.0
    if w_squared > 0:
        w, limit = math.sqrt(w_squared), used.stability_limit
        names = ", ".join(dict.fromkeys(f.name for f in (*springs, *linear)))
        if limit == 0 and w * dt > 0.01:
            growth = math.hypot(1, w * dt) ** (6.283 / (w * dt)) - 1
            yield f"{used.name} lets an oscillation under {names} grow by {growth:.1%} a period; leapfrog keeps it"
        elif w * dt > limit > 0:
            yield (
                f"w dt = {w * dt:.3g} of the lightest particle under {names} is above the stability limit of {used.name}; "
                f"use a step of at most {limit / w:.3g} s"
            )
    for force in forces:
        if force.name == "driver":
            driven = 2 * math.pi * abs(force.values["frequency"])  # rad/s
            if driven * dt > _LARGEST_TURN:
                yield (
                    f"driver turns by {driven * dt:.3g} rad a step, too much to follow; "
                    f"use a step of at most {0.3 / driven:.3g} s"
                )


def _masses_and_largest_charge(system) -> tuple[list[float], float]:
    """The least mass of each kind of birth, kg, and the largest absolute charge, C."""
    kinds = [kind.attributes for emission in system.emitters for kind in emission.kinds]
    masses = [
        k["density"][0] * 4 / 3 * math.pi * k["radius"][0] ** 3 if "density" in k else k["mass"][0] for k in kinds
    ]
    return masses, max((max(map(abs, k["charge"])) for k in kinds), default=0.0)
