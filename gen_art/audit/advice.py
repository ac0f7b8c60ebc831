"""What inspect and audit advise for a preset: what cannot be right (simulation/advice.py), and what could be better."""

import math
import warnings

from gen_art.audit.invariants import colliders_of, expected_order, forces_of
from gen_art.errors import AdviceWarning
from gen_art.integrators import scheme
from gen_art.interactions import Interaction
from gen_art.simulation.advice import fastest_oscillation, system_advice
from gen_art.simulation.from_preset import systems_of

__all__ = ["advice", "advice_texts", "step_advice"]


def advice(preset) -> list[str]:
    """Warnings about the systems of a preset that follow from its numbers, without running it."""
    sentences = []
    built = systems_of(preset)
    for name, system in preset.systems.items():
        used = scheme(system.integrator)
        found = system_advice(built[name], preset.clock.step)
        for check in (_velocity_dependent_forces, _explicit_euler, _lost_order, _unused_options):
            found += check(preset, name, system, used)
        found += _growing_oscillations(built[name], preset.clock.step)
        sentences += [f"system '{name}': {sentence}" for sentence in found]
    return sentences


def step_advice(preset) -> list[str]:
    """What springs and contacts say of the time step and of their particles at the start.

    The simulation is built if the preset has such interactions.
    """
    interactions = [i for system in preset.systems.values() for i in system.interactions]
    if not any(type(interaction).attach is not Interaction.attach for interaction in interactions):
        return []
    from gen_art.simulation import Simulation

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Simulation(preset, precision="f64")
    known = advice(preset)
    return [text for text in advice_texts(caught) if text not in known]


def advice_texts(caught) -> list[str]:
    """The texts of the AdviceWarnings among recorded warnings."""
    return [str(warning.message) for warning in caught if issubclass(warning.category, AdviceWarning)]


def _velocity_dependent_forces(preset, name, system, used):
    """Schemes that treat velocity-dependent forces as plain kicks; relativistic pushers without a speed of light."""
    velocity_dependent = ", ".join(
        dict.fromkeys(f.name for f in forces_of(preset, system) if f.depends_on_velocity and not f.provides("magnetic"))
    )
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


def _growing_oscillations(system, dt):
    """How fast explicit Euler lets an oscillation grow."""
    w, names = fastest_oscillation(system)
    if system.scheme.stability_limit == 0 and w * dt > 0.01:
        growth = math.hypot(1, w * dt) ** (6.283 / (w * dt)) - 1
        yield f"{system.scheme.name} lets an oscillation under {names} grow by {growth:.1%} a period; leapfrog keeps it"
