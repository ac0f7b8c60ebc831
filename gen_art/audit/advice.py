"""Where a preset's integrator or step does not suit its laws: sentences, each with the better choice."""

import math
import warnings

from gen_art.audit.invariants import colliders_of, expected_order, forces_of
from gen_art.integrators import scheme
from gen_art.interactions import Interaction
from gen_art.simulation.from_preset import systems_of

__all__ = ["FORETOLD", "advice", "gyration_advice", "step_advice"]

_GYRATION = 0.1  # rad a step: the phase lags by its square / 12, a thousandth of a turn each turn
_EXACT = 3.0  # rad a step, up to which exact_gyration is exact
FORETOLD = ("magnetic_field", "magnetic_mirror")
_SAMPLED = 1.0  # rad a step of a driver or a collider
_STEEP = 1.05  # m a metre: what a true distance on a grid comes to between its points


def advice(preset) -> list[str]:
    """Sentences about the systems of a preset, read from its numbers alone."""
    found = []
    built = systems_of(preset)
    for name, system in preset.systems.items():
        used = scheme(system.integrator)
        for one in (_velocity, _explicit_euler, _lost_order, _walls, _unused):
            found += [f"{name}: {sentence}" for sentence in one(preset, name, system, used)]
        masses, charges = _masses_and_charges(built[name])
        found += [f"{name}: {s}" for s in _gyration(preset, system, used, min(masses, default=1.0), charges)]
        found += [f"{name}: {s}" for s in _oscillator(preset, system, used, min(masses, default=1.0))]
    return found


def step_advice(preset) -> list[str]:
    """What springs and contacts say of the step once their particles are born: builds the simulation, if there are any."""
    if not any(type(one).attach is not Interaction.attach for s in preset.systems.values() for one in s.interactions):
        return []
    from gen_art.simulation import Simulation

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        Simulation(preset, precision="f64")
    return [str(one.message) for one in told if issubclass(one.category, UserWarning)]


def _velocity(preset, name, system, used):
    """Forces that depend on the velocity, in plain kicks; pushers without what makes them differ."""
    forces = forces_of(preset, system)
    turning = ", ".join(dict.fromkeys(f.name for f in forces if f.provides("magnetic")))
    velocity_dependent = ", ".join(
        dict.fromkeys(f.name for f in forces if f.depends_on_velocity and not f.provides("magnetic"))
    )
    if turning and not used.pusher:
        what = (
            f"does not keep the speed under {turning}"
            if used.kind == "runge_kutta"
            else f"takes {turning}, which depends on the velocity, as a plain kick: order 1, and the speed grows"
        )
        yield f"{used.name} {what}; boris turns the velocity exactly"
    if velocity_dependent and used.kind == "splitting":
        yield (
            f"{used.name} takes {velocity_dependent}, which depends on the velocity, as a plain kick: order 1; "
            "rk2 has order 2, rk4 order 4"
        )
    if used.pusher not in ("", "boris") and system.speed_of_light is None:
        yield f"{used.name} without speed_of_light takes the same steps as boris; name boris, or give speed_of_light"


def _explicit_euler(preset, name, system, used):
    if used.kind != "runge_kutta" or used.order > 1:
        return
    forces = forces_of(preset, system)
    holding = [f.name for f in forces if f.conservative and f.provides("potential")]
    holding += [one.name for one in system.interactions if one.conservative]
    held = f" under {', '.join(dict.fromkeys(holding))}" if holding else ""
    better = "boris" if any(f.provides("magnetic") for f in forces) else "leapfrog"
    yield f"explicit euler gains energy{held}, step by step; {better} has order 2 at the same cost"


def _lost_order(preset, name, system, used):
    """A scheme of order 4 whose laws leave it less."""
    left = expected_order(preset, name)
    if used.order <= 2 or left >= used.order:
        return
    if colliders_of(preset, system):
        yield f"impacts inside a step are of order 2, so {used.name} has no more; leapfrog costs less"
    elif used.kind == "splitting" and any(
        f.provides("damping") and f.quadratic_damping for f in forces_of(preset, system)
    ):
        yield f"{used.name} has order {left} with quadratic drag; rk4 keeps its 4"


def _walls(preset, name, system, used):
    """Distances that are none, and surfaces that turn too far in a step."""
    dt = preset.clock.step
    for one in colliders_of(preset, system):
        steep = one.steepness if one.name == "sdf" else 0.0
        if steep > _STEEP:
            yield (
                f"sdf: the grid grows by up to {steep:.3g} m a metre, where a distance grows by 1: fast particles may pass "
                f"through its surface; divide it by {steep:.3g}, or check `min` and `max`"
            )
        turn = math.hypot(*one.values["angular_velocity"]) * dt
        if turn > _SAMPLED:
            yield (
                f"{one.name} turns by {turn:.3g} rad a step, too coarse to strike particles where it meets them; "
                f"a step of at most {dt * _SAMPLED / turn:.3g} s"
            )


def _unused(preset, name, system, used):
    """What is given and has no say."""
    for one in system.interactions:
        theta = type(one).parameters.get("theta")
        if theta is not None and one.values["method"] == "direct" and one.values["theta"] != theta.default:
            yield f"{one.name}: theta has no say with method: direct, which sums over every pair; method: tree uses it"


def _gyration(preset, system, used, lightest, charge):
    """The angle that uniform fields and the middle of mirrors turn a charge by; the other fields' shows in an audit."""
    fields = [f for f in forces_of(preset, system) if f.name in FORETOLD]
    if used.pusher and charge and lightest > 0:
        strengths = [f.values["field"] if f.name == "magnetic_field" else (f.values["strength"],) for f in fields]
        w = charge * sum(math.hypot(*strength) for strength in strengths) / lightest
        yield from gyration_advice(w, preset.clock.step, system.exact_gyration)


def gyration_advice(w: float, dt: float, exact: bool):
    """A sentence where charges turn by w dt, and so lag by more than a thousandth or so; w in 1/s."""
    if w * dt > _GYRATION and not (exact and w * dt < _EXACT):
        better = f"a step of at most {_GYRATION / w:.3g} s"
        if w * dt < _EXACT:
            better += ", or exact_gyration: true where the field varies little"
        lag = 1 - math.atan(w * dt / 2) / (w * dt / 2)
        yield f"charges turn by w dt = {w * dt:.3g} rad a step, and lag by {lag:.2%} of it; {better}"


def _oscillator(preset, system, used, lightest):
    """Springs to a point, linear central forces and drivers against the step."""
    dt, forces = preset.clock.step, forces_of(preset, system)
    springs = [f for f in forces if f.name == "spring"]
    linear = [
        f for f in forces if f.name == "central_force" and f.values["exponent"] == 1 and not f.values.get("per_charge")
    ]
    square = sum(f.values["strength"] for f in linear)
    square += sum(f.values["stiffness"] for f in springs) / lightest if lightest > 0 else 0.0
    if square > 0:
        w, limit = math.sqrt(square), used.stability_limit
        names = ", ".join(dict.fromkeys(f.name for f in (*springs, *linear)))
        if limit == 0 and w * dt > 0.01:
            yield (
                f"{used.name} lets an oscillation under {names} grow by {math.hypot(1, w * dt) ** (6.283 / (w * dt)) - 1:.1%} "
                "a period; leapfrog keeps it"
            )
        elif w * dt > limit > 0:
            yield (
                f"w dt = {w * dt:.3g} of the lightest particle under {names} is beyond what {used.name} is stable for; "
                f"a step of at most {limit / w:.3g} s"
            )
    for one in forces:
        if one.name == "driver" and (turn := 2 * math.pi * abs(one.values["frequency"]) * dt) > _SAMPLED:
            most = 2 * math.pi * abs(one.values["frequency"])
            yield f"driver turns by {turn:.3g} rad a step, too coarse to follow; a step of at most {0.3 / most:.3g} s"


def _masses_and_charges(system) -> tuple[list[float], float]:
    """The least mass of each kind of birth, kg, and the largest charge, C."""
    kinds = [kind.attributes for emission in system.emitters for kind in emission.kinds]
    masses = [
        k["density"][0] * 4 / 3 * math.pi * k["radius"][0] ** 3 if "density" in k else k["mass"][0] for k in kinds
    ]
    return masses, max((max(map(abs, k["charge"])) for k in kinds), default=0.0)
