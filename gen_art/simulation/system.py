"""A ParticleSystem: a named group of particles with its forces, and the particles' state once a simulation has it."""

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gen_art import arguments
from gen_art.colliders.base import Collider
from gen_art.emitters.births import ActiveEmitter
from gen_art.errors import UsageError
from gen_art.forces.base import Force, loses_mass
from gen_art.forces.medium import Medium
from gen_art.integrators import scheme
from gen_art.integrators.schemes import charged
from gen_art.interactions import Interaction
from gen_art.interactions.ledger_labels import LedgerRow, check_entry, composition_of, ledger_rows
from gen_art.interactions.rigid.interaction import Rigid
from gen_art.kernel_methods import PARTICLE, attributes_read, is_own
from gen_art.particles.entries import LedgerEntry
from gen_art.particles.fixed import FIXED
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.rows import FIRST_ATTRIBUTE, LIFETIME, POSITION, VELOCITY
from gen_art.particles.storage import Particles
from gen_art.quantities import plain
from gen_art.registry import suggest
from gen_art.simulation.living_particles import LivingParticles

if TYPE_CHECKING:
    from gen_art.interactions.rigid.body_state import BodyState
    from gen_art.preset.look import Look
    from gen_art.simulation.simulation import Simulation

__all__ = ["ParticleSystem"]


class ParticleSystem(LivingParticles):
    """Particles, given as arrays or born from emitters, with the forces on them.

    position : (n, 3), m
    velocity : (n, 3), m/s; at rest when left out
    mass : (n,) or one number, kg; 1 when left out
    charge : (n,) or one number, C; 0 when left out
    radius : (n,) or one number, m; 0.01 when left out
    forces : a list of ga.forces
    interactions : a list of ga.interactions
    colliders : a list of ga.colliders
    integrator : a name of ga.integrators
    speed_of_light : m/s, makes boris, vay and higuera_cary relativistic
    exact_gyration : makes them turn by the exact angle in uniform fields, up to 3 rad a step
    medium : the ga.Medium; drag acts towards its velocity
    attributes : further (n,) numbers by name, which forces read as p.name
    fixed : the particles that no force moves: indices, or (n,) bool
    emitters : ActiveEmitter objects (a preset makes them)
    look : how it is drawn: a ga.Look, or a mapping of its keys as in YAML; white points when left out
    booked : entries of the ledger of which each particle keeps its share, beside those that its look goes by: {"work": "drag"},
        {"dissipated": "drag"} or "dissipated"
    Raises UsageError for arrays of the wrong shape or with numbers that are not finite, and for unknown forces.

    In a simulation: count, ids, keys, emitter, position, velocity, mass, charge, radius, age are read-only NumPy copies of
    the living particles in the order of their ids; `system.attribute(name)` gives any declared attribute. `set`, `add` and
    `remove` change them between steps.
    """

    def __init__(
        self,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        mass: ArrayLike | None = None,
        charge: ArrayLike | None = None,
        radius: ArrayLike | None = None,
        *,
        forces: Iterable[Force] = (),
        interactions: Iterable[Interaction] = (),
        colliders: Iterable[Collider] = (),
        integrator: str = "leapfrog",
        speed_of_light: float | None = None,
        exact_gyration: bool = False,
        medium: Medium | None = None,
        attributes: Mapping[str, ArrayLike] | None = None,
        fixed: ArrayLike | None = None,
        emitters: Iterable[ActiveEmitter] = (),
        look: "Look | Mapping[str, Any] | None" = None,
        booked: "Iterable[LedgerEntry | str | dict[str, str]]" = (),
    ) -> None:
        super().__init__()
        self.colliders = arguments.instances("colliders", colliders, Collider, "ga.colliders.Plane(...)")
        self.forces = arguments.instances("forces", forces, Force, "ga.forces.Gravity(...)")
        self.interactions = arguments.instances(
            "interactions", interactions, Interaction, "ga.interactions.SelfGravity(...)"
        )
        if medium is not None and not isinstance(medium, Medium):
            raise UsageError(f"medium must be a ga.Medium, not {arguments.shown(medium)}")
        self.medium = medium or Medium()
        if speed_of_light is not None:
            speed_of_light = arguments.number("speed_of_light", speed_of_light, "m/s", above=0.0)
        exact_gyration = arguments.flag("exact_gyration", exact_gyration)
        attributes = _checked_attributes(attributes)
        self.scheme = charged(
            scheme(integrator), self.forces, speed_of_light, exact_gyration, self.interactions, self.colliders
        )
        self.composition = composition_of(self.forces, self.medium, self.colliders, self.interactions)
        for mover in (interaction for interaction in self.interactions if interaction.moves_particles):
            for force in self.forces:
                if loses_mass(force):
                    raise UsageError(
                        f"{force.name} takes mass, but the mass of a body of {mover.name} cannot change: "
                        "push it with `propeller` instead"
                    )
        self.box: PeriodicBox | None = None
        self.emitters: list[ActiveEmitter] = arguments.instances(
            "emitters", emitters, ActiveEmitter, "the emitters that a preset makes"
        )
        self.look = _checked_look(look)
        for one in self.colliders:
            if one.values["look"] is not None:
                _check_surface(one.values["look"])
        self._initial = self._checked_arrays(position, velocity, mass, charge, radius, attributes)
        self.least_mass, self.largest_charge, self.largest_radius = self._extremes()
        for force in self.forces:
            force.check_mass(self.least_mass)
        if self._initial and speed_of_light:
            speed = np.linalg.norm(self._initial["velocity"], axis=0)
            if (speed >= speed_of_light).any():
                raise UsageError(f"velocity must be below the speed of light, {speed_of_light:g} m/s")
        self._attributes = attributes
        self._fixed = self._fixed_indices(fixed)
        for force in self.forces:
            missing = [name for name in force.needs if name not in self.attribute_names]
            if missing:
                raise UsageError(
                    f"{force.name} needs particles with the attribute {missing[0]}: declare it, or use rigid bodies"
                )
            for read, method in attributes_read(
                type(force), () if is_own(type(force)) else force.kernel_methods
            ).items():
                if read not in self.attribute_names:
                    raise UsageError(
                        f"{type(force).__name__}.{method} reads p.{read}, which the particles do not have"
                        f"{suggest(read, (*PARTICLE, *self.attribute_names)) or ': declare it as an attribute'}"
                    )
        self.entries = self._checked_entries(booked)

    @property
    def acting(self) -> list[str]:
        """The names of its forces, those between particles last."""
        return [one.name or type(one).__name__ for one in (*self.forces, *self.interactions)]

    def __repr__(self) -> str:
        if self._state is None:
            count = len(self._initial["mass"]) if self._initial else 0
            name, end = "", "; not part of a simulation yet"
        else:
            count, name, end = self.count, f" '{self.name}'", ""
        with_forces = f", {', '.join(self.acting)}" if self.acting else ""
        return f"<ParticleSystem{name}: {count:,} particle{'' if count == 1 else 's'}{with_forces}, {self.scheme.name}{end}>"

    def enter(self, box: PeriodicBox) -> None:
        """Move into a periodic box, before a simulation takes the system.

        Raises UsageError for an interaction that does not act across its sides, or reaches too far for it, and for a system that
        a simulation has already.
        """
        if self._state is not None:
            raise UsageError(f"system '{self.name}' is already part of a simulation: make another ParticleSystem")
        for interaction in self.interactions:
            if (problem := interaction.problem_in(box, self.largest_radius)) is not None:
                raise UsageError(problem)
        self.box = box
        self.composition = self.composition.in_box(box)

    @property
    def ledger_rows(self) -> list[LedgerRow]:
        """The rows of its ledger, in the order of the ledger kernel."""
        return ledger_rows(self.composition, self.interactions)

    def _checked_entries(self, booked) -> tuple[LedgerEntry, ...]:
        """The entries of the ledger of which each particle keeps its share. Raises UsageError for one that does not exist."""
        if isinstance(booked, (str, Mapping, LedgerEntry)) or not isinstance(booked, Iterable):
            raise UsageError(f'booked must be a list such as [{{"work": "drag"}}], not {arguments.shown(booked)}')
        entries = [LedgerEntry.of(one) for one in booked]
        if self.look is not None:
            entries += self.look.ledger_entries(self.attribute_names)
        for entry in entries:
            check_entry(entry, self.ledger_rows, self.interactions)
        return tuple(dict.fromkeys(entries))

    def _extremes(self) -> tuple[float, float, float]:
        """(least mass, kg, inf without particles; largest absolute charge, C; largest radius, m) at the start and of births."""
        kinds = [kind.attributes for emission in self.emitters for kind in emission.kinds]
        masses = [
            k["density"][0] * 4 / 3 * np.pi * k["radius"][0] ** 3 if "density" in k else k["mass"][0] for k in kinds
        ]
        charges = [abs(c) for k in kinds for c in k["charge"]]
        radii = [k["radius"][1] for k in kinds]
        if self._initial:
            masses.append(self._initial["mass"].min(initial=np.inf))
            charges.append(np.abs(self._initial["charge"]).max(initial=0.0))
            radii.append(self._initial["radius"].max(initial=0.0))
        return float(min(masses, default=np.inf)), float(max(charges, default=0.0)), float(max(radii, default=0.0))

    def may_have(self, attribute: str) -> bool:
        """Whether a particle of the start or of a birth may have this attribute other than 0; True where that is not known."""
        given = len(self._initial["mass"]) if self._initial else 0
        if self._state is not None or not (given or self.emitters):  # the particles of a snapshot come later
            return True
        kinds = [kind for emission in self.emitters for kind in emission.kinds]
        if attribute in self._initial and self._initial[attribute].any():
            return True
        if any(kind.scripted is not None for kind in kinds):
            return True  # its class gives the attributes
        if attribute == "mass" and any("density" in kind.attributes for kind in kinds):
            return any(kind.attributes["radius"][1] > 0 for kind in kinds)
        return any(any(kind.attributes.get(attribute, (0.0, 0.0))) for kind in kinds)

    @staticmethod
    def _checked_arrays(position, velocity, mass, charge, radius, attributes) -> dict[str, np.ndarray]:
        """The initial particles' arrays by name, vectors as (3, n); empty without `position`."""
        if position is None:
            return {}
        x = arguments.array("position", position, "numbers of the shape (n, 3)", "m")
        if x.ndim != 2 or x.shape[1] != 3:
            raise UsageError(f"position must have the shape (n, 3), not {x.shape}")
        n = len(x)
        arrays = {"position": x.T}
        v = (
            np.zeros((n, 3))
            if velocity is None
            else arguments.array("velocity", velocity, f"numbers of the shape ({n}, 3)", "m/s")
        )
        if v.shape != (n, 3):
            raise UsageError(f"velocity must have the shape ({n}, 3) of position, not {v.shape}")
        arrays["velocity"] = v.T
        for name, given, default, unit in (
            ("mass", mass, 1.0, "kg"),
            ("charge", charge, 0.0, "C"),
            ("radius", radius, 0.01, "m"),
            *((k, a, 0.0, "") for k, a in attributes.items()),
        ):
            numbers = arguments.array(
                name, default if given is None else given, "one number, or one for each particle", unit
            )
            if numbers.shape not in ((), (1,), (n,)):
                raise UsageError(f"{name} must be one number or have the shape ({n},), not {numbers.shape}")
            arrays[name] = np.broadcast_to(numbers, (n,))
        for name in ("mass", "radius"):
            if (arrays[name] < 0).any():
                raise UsageError(f"{name} must not be negative")
        return arrays

    def _fixed_indices(self, fixed) -> np.ndarray:
        """Indices of the fixed particles. Raises UsageError unless they are at rest."""
        n = len(self._initial["mass"]) if self._initial else 0
        fixed = plain(fixed, "", "fixed")
        chosen = np.asarray([] if fixed is None else fixed) if _is_plain(fixed) else np.array(["?"])
        if chosen.size and chosen.dtype.kind not in "biu":
            raise UsageError(f"fixed must be indices of particles, or {n} booleans, not {arguments.shown(fixed)}")
        chosen = np.flatnonzero(chosen) if chosen.dtype == bool and chosen.shape == (n,) else chosen.astype(int)
        if chosen.ndim != 1 or (len(chosen) and not 0 <= chosen.min() <= chosen.max() < n):
            raise UsageError(f"fixed must be indices from 0 to {n - 1}, or {n} booleans")
        if len(chosen) and self._initial["velocity"][:, chosen].any():
            raise UsageError("fixed particles do not move: their velocity must be 0")
        return chosen

    @property
    def bodies(self) -> "list[BodyState]":
        """The rigid bodies as they are now, in their order: `system.bodies[0].position`.

        Raises UsageError for a system without rigid bodies, or that is not part of a simulation yet.
        """
        rigid = next((one for one in self.interactions if isinstance(one, Rigid)), None)
        if rigid is None:
            raise UsageError("the system has no rigid bodies: give it some by ga.bodies(...).system(...)")
        states = rigid.states()
        if states is None:
            raise UsageError("the system is not part of a simulation yet: make a ga.Simulation of it")
        return states

    @property
    def reports_impacts(self) -> bool:
        """Whether impacts on a collider feed births. Particles then have `impact`, the age at their last impact, s."""
        return any(collider.values["action"] == "emit" for collider in self.colliders)

    @property
    def attribute_names(self) -> tuple[str, ...]:
        """Declared attributes in the order of their names: of the arrays, the interactions and every kind of birth."""
        names = set(self._attributes).union(*(interaction.attributes for interaction in self.interactions))
        for emission in self.emitters:
            for kind in emission.kinds:
                names |= set(kind.attributes) - {"mass", "charge", "radius", "lifetime", "density"}
        if self.reports_impacts:
            names.add("impact")
        return tuple(sorted(names))

    def allocate(self, name: str, simulation: "Simulation", key: np.uint64) -> None:
        """Make the system part of a simulation: allocate the state and give the initial particles their keys.

        key : of all random streams of the system
        """
        from gen_art.maths.random import channel_of, derive

        if self._state is not None:
            raise UsageError(f"system '{name}' is already part of a simulation: make another ParticleSystem")
        self.name, self._simulation, self.key = name, simulation, key
        for interaction in self.interactions:
            interaction.box = self.box
        sources = []
        names = self.attribute_names
        channels = {attribute: FIRST_ATTRIBUTE + k for k, attribute in enumerate(names)}
        if self._initial or not self.emitters:
            sources.append(ParticleOrigin("initial"))
        self.emitters.sort(key=lambda e: e.name)
        for emission in self.emitters:
            emission.key = np.uint64(derive(key, channel_of(emission.name)))
            emission.first_source = len(sources)
            for kind in emission.kinds:
                kind.channels = channels
                sources.append(ParticleOrigin(emission.name, kind.tag, kind.name))
        sources.append(ParticleOrigin("added"))
        count = len(self._initial["mass"]) if self._initial else 0
        self._state = state = Particles(
            simulation.dtype, names, tuple(sources), max(1024, count), self.box, self.entries
        )
        if self._initial:
            keys = derive(derive(key, channel_of("initial")), np.arange(count))
            new = state.append(np.zeros(count), keys, np.zeros(count, np.int32))
            state.floats[POSITION, new] = self._initial["position"]
            state.floats[VELOCITY, new] = self._initial["velocity"]
            state.floats[LIFETIME, new] = np.inf
            state.floats[LIFETIME, self._fixed] = FIXED
            state.has_fixed = len(self._fixed) > 0
            for name in ("mass", "charge", "radius", *self._attributes):
                state.floats[state.channels[name], new] = self._initial[name]
            state.wrap(new)
        self._initial = {}
        state.may_die = state.may_die or any(collider.values["action"] == "kill" for collider in self.colliders)

    def without_particles(self) -> "ParticleSystem":
        """Another system with the same forces and emitters, which no simulation has and no particle was given to."""
        given = any(source.name == "initial" for source in self.state.sources)
        return ParticleSystem(
            position=np.zeros((0, 3)) if given else None,
            forces=self.forces,
            interactions=[interaction.fresh() for interaction in self.interactions],
            colliders=self.colliders,
            integrator=self.scheme.name,
            speed_of_light=self.scheme.light or None,
            exact_gyration=self.scheme.exact,
            medium=self.medium,
            attributes={name: np.zeros(0) for name in self.attribute_names},
            emitters=[emission.fresh() for emission in self.emitters],
            look=self.look,
            booked=self.entries,
        )

    def change(self, act: Callable[[], None]) -> None:
        """Let `act` change the particles from outside: see Simulation.change."""
        assert self._simulation is not None, "`state` has raised an error"
        self._simulation.change(self.name, act)

    def set(
        self,
        position: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        mass: ArrayLike | None = None,
        charge: ArrayLike | None = None,
        radius: ArrayLike | None = None,
        *,
        attributes: Mapping[str, ArrayLike] | None = None,
        where: ArrayLike | None = None,
    ) -> None:
        """Change living particles between steps; what is left out stays as it is.

        position, velocity : (n, 3) in the order of `where`, or one (3,) for all of them
        mass, charge, radius, attributes : (n,) or one number, as in the constructor
        where : the particles' ids, or one bool for each living particle; all living particles when left out
        The ledger books the change as `outside`. Raises UsageError, and changes nothing, for wrong shapes, numbers that are not
        finite, ids of no living particle, fixed particles with a velocity, and the particles of rigid bodies.
        """
        from gen_art.simulation.changes import set_particles

        given = {"position": position, "velocity": velocity, "mass": mass, "charge": charge, "radius": radius}
        set_particles(self, given, attributes, where)

    def add(
        self,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        mass: ArrayLike | None = None,
        charge: ArrayLike | None = None,
        radius: ArrayLike | None = None,
        *,
        attributes: Mapping[str, ArrayLike] | None = None,
        lifetime: ArrayLike | None = None,
    ) -> np.ndarray:
        """Add particles between steps; returns their ids, (n,) int64.

        position : (n, 3) m, or one (3,)
        lifetime : s from now; for ever when left out
        The others are as in the constructor, with its defaults. Their `emitter` is "added".
        The ledger books the change as `outside`. Raises UsageError as `set` does.
        """
        from gen_art.simulation.changes import add_particles

        given = {"position": position, "velocity": velocity, "mass": mass, "charge": charge, "radius": radius}
        return add_particles(self, given, attributes, lifetime)

    def remove(self, ids: ArrayLike) -> None:
        """Remove living particles between steps, by id, or by one bool for each living particle.

        The ledger books the change as `outside`, not as deaths, and no emitter takes it for a death. Raises UsageError as `set`
        does.
        """
        from gen_art.simulation.changes import remove_particles

        remove_particles(self, ids)

    def births_until(self, time: float) -> int:
        """The number of scheduled births up to `time`, s, that have not been made yet."""
        return sum(e.schedule.until(time) - e.done for e in self.emitters if e.schedule is not None)


def _checked_attributes(attributes) -> dict[str, Any]:
    if attributes is None:
        return {}
    if not isinstance(attributes, Mapping):
        raise UsageError(f"attributes must be a mapping of names to numbers, not {arguments.shown(attributes)}")
    return {arguments.text("the name of an attribute", name): values for name, values in attributes.items()}


def _is_plain(value) -> bool:
    """Whether NumPy makes an array of it."""
    try:
        np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return False
    return True


def _checked_look(look) -> "Look | None":
    from gen_art.preset.from_script import model_of
    from gen_art.preset.look import Look

    return model_of(Look, "look", look)


def _check_surface(look) -> None:
    from gen_art.preset.surface import surface_look

    surface_look(look)


class ParticleOrigin:
    """Where particles come from: the name of the emitter, and the name and tag of the kind of birth."""

    def __init__(self, name: str, tag: str | None = None, kind: str = ""):
        self.name, self.tag, self.kind = name, tag, kind
