"""Changes of a system's particles from outside, between steps: what `set`, `add` and `remove` of a ParticleSystem do.

All arguments are checked before anything changes.
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.maths.random import channel_of, derive
from gen_art.particles.fixed import fixed_lifetimes
from gen_art.particles.rows import LIFETIME, POSITION, VELOCITY
from gen_art.registry import suggest

if TYPE_CHECKING:
    from gen_art.simulation.system import ParticleSystem

__all__ = ["add_particles", "remove_particles", "set_particles"]

_VECTORS = {"position": POSITION, "velocity": VELOCITY}
_DEFAULTS = {
    "velocity": 0.0,
    "mass": 1.0,
    "charge": 0.0,
    "radius": 0.01,
}  # of an added particle, as of one of the start
_NOT_NEGATIVE = ("mass", "radius")
_UNITS = {"position": "m", "velocity": "m/s", "mass": "kg", "charge": "C", "radius": "m", "lifetime": "s"}


def set_particles(system: "ParticleSystem", given: Mapping[str, Any], attributes: Any, where: Any) -> None:
    """Give particles these values; those that are None stay as they are.

    where : ids, or one bool for each living particle; all living particles when None
    """
    _refuse_bodies(system)
    state = system.state
    slots = system.slots() if where is None else system.slots_of("where", where)
    values = _checked(system, {**given, **_checked_attributes(system, attributes)}, len(slots))
    if not values:
        raise UsageError("set changes nothing: give it position, velocity, mass, charge, radius or attributes")
    _check_limits(system, values, state.id[slots])
    if "velocity" in values:
        still = fixed_lifetimes(state.floats[LIFETIME, slots]) & values["velocity"].any(axis=0)
        if still.any():
            raise UsageError(
                f"fixed particles do not move: the velocity of particle {state.id[slots[still.argmax()]]} must be 0"
            )

    def act() -> None:
        for name, numbers in values.items():
            state.floats[_row(state, name), slots] = numbers

    system.change(act)


def add_particles(system: "ParticleSystem", given: Mapping[str, Any], attributes: Any, lifetime: Any) -> np.ndarray:
    """Add particles that are born now; returns their ids."""
    _refuse_bodies(system)
    state = system.state
    what = "numbers of the shape (n, 3), or one position of three numbers"
    x = arguments.array("position", given["position"], what, _UNITS["position"])
    if x.shape != (3,) and (x.ndim != 2 or x.shape[1] != 3):
        raise UsageError(f"position must have the shape (n, 3), or be one position of three numbers, not {x.shape}")
    count = 1 if x.ndim == 1 else len(x)
    ids = np.arange(state.next_id, state.next_id + count)
    defaults = {name: default if given[name] is None else given[name] for name, default in _DEFAULTS.items()}
    defaults["velocity"] = np.zeros(3) if given["velocity"] is None else given["velocity"]
    values = _checked(system, {"position": x, **defaults, **_checked_attributes(system, attributes)}, count)
    _check_limits(system, values, ids)
    lifetimes = np.full(count, np.inf) if lifetime is None else _numbers("lifetime", lifetime, count)
    if (lifetimes <= 0).any():
        raise UsageError("lifetime must be above 0 s")
    keys = derive(np.uint64(derive(system.key, channel_of("added"))), ids)
    source = next(k for k, origin in enumerate(state.sources) if origin.name == "added")
    state.reserve(count)

    def act() -> None:
        new = state.append(np.full(count, system.time), keys, np.full(count, source, np.int32))
        state.floats[LIFETIME, new] = lifetimes
        for name, numbers in values.items():
            state.floats[_row(state, name), new] = numbers
        state.may_die = state.may_die or lifetime is not None

    system.change(act)
    return ids


def remove_particles(system: "ParticleSystem", where: Any) -> None:
    """Remove particles at once, by id, or by one bool for each living particle."""
    _refuse_bodies(system)
    slots = system.slots_of("ids", where)
    system.change(lambda: system.state.remove(slots))


def _refuse_bodies(system: "ParticleSystem") -> None:
    for interaction in system.interactions:
        if interaction.moves_particles:
            raise UsageError(
                f"the particles of '{system.name}' are those of rigid bodies, and {interaction.name} moves them: they cannot be "
                "set, added or removed one by one"
            )


def _row(state, name: str):
    """The row or rows of the state array."""
    return _VECTORS.get(name) or state.channels[name]


def _checked_attributes(system: "ParticleSystem", given: Any) -> dict[str, Any]:
    """Values of declared attributes by name."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise UsageError(f"attributes must be a mapping of names to numbers, not {arguments.shown(given)}")
    known = system.state.attributes
    for name in given:
        if name not in known:
            hint = suggest(name, known) or ": declare it where the system is made"
            raise UsageError(f"system '{system.name}' has no attribute {arguments.shown(name)}{hint}")
    return dict(given)


def _numbers(name: str, given: Any, count: int) -> np.ndarray:
    """(n,) or (3, n) float64."""
    vector = name in _VECTORS
    what = (
        f"three numbers, or numbers of the shape ({count}, 3)"
        if vector
        else f"one number, or numbers of the shape ({count},)"
    )
    numbers = arguments.array(name, given, what, _UNITS.get(name, ""))
    if numbers.shape not in (((3,), (count, 3)) if vector else ((), (1,), (count,))):
        raise UsageError(f"{name} must be {what}, not {arguments.shown(numbers)}")
    return np.broadcast_to(numbers, (count, 3)).T if vector else np.broadcast_to(numbers, (count,))


def _checked(system: "ParticleSystem", given: Mapping[str, Any], count: int) -> dict[str, np.ndarray]:
    """The values that are given, (n,) or (3, n), in the precision of the state; positions are in the periodic box."""
    state = system.state
    values = {}
    for name, value in given.items():
        if value is None:
            continue
        with np.errstate(over="ignore"):
            numbers = _numbers(name, value, count).astype(state.floats.dtype)
        if not np.isfinite(numbers).all():
            raise UsageError(f"{name} holds numbers that {state.floats.dtype.name} does not hold: use precision f64")
        if name in _NOT_NEGATIVE and (numbers < 0).any():
            raise UsageError(f"{name} must not be negative")
        if name == "position" and state.box is not None:
            state.box.wrap(numbers)
        values[name] = numbers
    return values


def _check_limits(system: "ParticleSystem", values: Mapping[str, np.ndarray], ids: np.ndarray) -> None:
    """Raise UsageError for values that forces, interactions or the integrator do not allow; `ids` are those of the particles."""
    if not len(ids):
        return
    if "mass" in values:
        for force in system.forces:
            force.check_mass(float(values["mass"].min()))
        for interaction in system.interactions:
            interaction.check_masses(system, ids, values["mass"])
    if "radius" in values and system.box is not None:
        for interaction in system.interactions:
            if (problem := interaction.problem_in(system.box, float(values["radius"].max()))) is not None:
                raise UsageError(problem)
    light = system.scheme.light
    if light and "velocity" in values:
        speeds = np.sqrt((values["velocity"].astype(np.float64) ** 2).sum(axis=0))
        if (speeds >= light).any():
            raise UsageError(f"velocity must be below the speed of light, {light:g} m/s")
