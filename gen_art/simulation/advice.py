"""Sentences about time steps and integrators that cannot carry the motion of a system, each with a better choice.

They follow from the numbers of its forces and particles, without a run. What only a run shows is in watch.py.
"""

import math
from collections.abc import Iterator

from gen_art.simulation.system import ParticleSystem

__all__ = ["KNOWN_MAGNETIC_FIELDS", "fastest_oscillation", "gyration_advice", "system_advice"]

_LARGEST_GYRATION = 0.1  # rad a step: the phase lags by its square / 12, a thousandth of a turn each turn
_EXACT_UP_TO = 3.0  # rad a step: the limit of exact_gyration
_LARGEST_TURN = 1.0  # rad a step of a driver or a collider
_STEEPEST = 1.05  # m a metre: the most that interpolating a true distance between grid points gives
KNOWN_MAGNETIC_FIELDS = ("magnetic_field", "magnetic_mirror")  # their strength is known before a run


def system_advice(system: ParticleSystem, dt: float) -> list[str]:
    """What cannot be right about a system that is advanced by steps of dt, s."""
    checks = (
        _kicked_rotation(system),
        _gyration(system, dt),
        _oscillations(system, dt),
        _colliders(system, dt),
        _sides(system),
    )
    return [sentence for check in checks for sentence in check]


def _kicked_rotation(system) -> Iterator[str]:
    """Schemes that treat the magnetic force as a plain kick."""
    used = system.scheme
    turning = ", ".join(dict.fromkeys(force.name for force in system.forces if force.provides("magnetic")))
    if not turning or used.pusher:
        return
    problem = (
        f"does not keep the speed under {turning}"
        if used.kind == "runge_kutta"
        else f"takes {turning}, which depends on the velocity, as a plain kick: order 1, and the speed grows"
    )
    yield f"{used.name} {problem}; boris turns the velocity exactly"


def _gyration(system, dt: float) -> Iterator[str]:
    """The gyration angle a step in uniform fields and at the middle of mirrors; an audit measures that of other fields."""
    fields = [force for force in system.forces if force.name in KNOWN_MAGNETIC_FIELDS]
    if system.scheme.pusher and system.largest_charge and 0 < system.least_mass < math.inf:
        strengths = [f.values["field"] if f.name == "magnetic_field" else (f.values["strength"],) for f in fields]
        w = system.largest_charge * sum(math.hypot(*strength) for strength in strengths) / system.least_mass
        yield from gyration_advice(w, dt, system.scheme.exact)


def gyration_advice(w: float, dt: float, exact: bool) -> Iterator[str]:
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


def fastest_oscillation(system) -> tuple[float, str]:
    """(w of the lightest particle under springs to a point and linear central forces, 1/s, the names of the forces)."""
    springs = [f for f in system.forces if f.name == "spring"]
    linear = [
        f
        for f in system.forces
        if f.name == "central_force" and f.values["exponent"] == 1 and not f.values.get("per_charge")
    ]
    w_squared = sum(f.values["strength"] for f in linear)
    w_squared += sum(f.values["stiffness"] for f in springs) / system.least_mass if system.least_mass > 0 else 0.0
    return math.sqrt(max(w_squared, 0.0)), ", ".join(dict.fromkeys(f.name for f in (*springs, *linear)))


def _oscillations(system, dt: float) -> Iterator[str]:
    """Oscillations and drivers that are too fast for the step."""
    w, names = fastest_oscillation(system)
    limit = system.scheme.stability_limit
    if w * dt > limit > 0:
        yield (
            f"w dt = {w * dt:.3g} of the lightest particle under {names} is above the stability limit of "
            f"{system.scheme.name}; use a step of at most {limit / w:.3g} s"
        )
    for force in system.forces:
        if force.name == "driver":
            driven = 2 * math.pi * abs(force.values["frequency"])  # rad/s
            if driven * dt > _LARGEST_TURN:
                yield (
                    f"driver turns by {driven * dt:.3g} rad a step, too much to follow; "
                    f"use a step of at most {0.3 / driven:.3g} s"
                )


def _colliders(system, dt: float) -> Iterator[str]:
    """Grids that are not signed distances, and surfaces that turn too far in a step."""
    for collider in system.colliders:
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


def _sides(system) -> Iterator[str]:
    """Noise in a periodic box: its lattice does not repeat with the box."""
    if system.box is None:
        return
    sizes = {force.name: force.feature_size for force in (*system.forces, *system.medium.terms)}
    for name, size in sizes.items():
        if size < math.inf:
            yield (
                f"{name} does not repeat with the periodic box, so it jumps where particles pass a side; keep the sides out of "
                f"the picture, or make the box many times its scale of {size:g} m, so that few particles pass them"
            )
