"""A ParticleSystem: a named group of particles with its forces, and, once it is part of a simulation, their state."""

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gen_art.colliders.base import Collider
from gen_art.emitters.births import ActiveEmitter
from gen_art.errors import UsageError
from gen_art.forces.base import Force, loses_mass
from gen_art.forces.medium import Medium
from gen_art.integrators import scheme
from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.integrators.schemes import charged
from gen_art.interactions import Interaction
from gen_art.particles.fixed import FIXED
from gen_art.particles.rows import FIRST_ATTRIBUTE, LIFETIME, POSITION, VELOCITY
from gen_art.particles.storage import Particles

if TYPE_CHECKING:
    from gen_art.preset.look import Look

__all__ = ["ParticleSystem"]


class ParticleSystem:
    """Particles given as arrays, or born of emitters, with the laws they follow.

    position, velocity : (n, 3), m and m/s     mass, charge, radius : (n,) or one number, kg, C, m (1, 0 and 0.01)
    forces : a list of ga.forces     interactions : a list of ga.interactions     integrator : a name of ga.integrators
    colliders : a list of ga.colliders
    medium : the ga.Medium that drag pulls towards     attributes : further (n,) numbers by name, seen by forces as p.name
    fixed : which particles stay where they are whatever pulls at them: indices, or (n,) bool
    emitters : ActiveEmitter objects (a preset makes them)
    look : how it is drawn: a ga.Look, or a mapping of its keys as in YAML; white points when left out
    speed_of_light : m/s, makes boris, vay and higuera_cary relativistic     exact_gyration : they turn by the exact angle in
    uniform fields, up to 3 rad a step
    Raises UsageError for arrays of the wrong shape or with numbers that are not finite, and for unknown laws.

    In a simulation: count, ids, keys, emitter, position, velocity, mass, charge, radius, age are read-only NumPy copies
    of the living in order of id; any declared attribute by `system.attribute(name)`.
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
    ) -> None:
        self.colliders = list(colliders)
        self.forces, self.interactions = list(forces), list(interactions)
        for one in self.interactions:
            if not isinstance(one, Interaction):
                raise UsageError(f"interactions must be such as ga.interactions.SelfGravity(...), not {one!r}")
        self.medium = medium or Medium()
        self.scheme = charged(
            scheme(integrator), self.forces, speed_of_light, exact_gyration, self.interactions, self.colliders
        )
        carriers = [one for one in self.interactions if one.moves_particles]
        for one in carriers:
            one.take_colliders(self.colliders)
            for force in self.forces:
                if loses_mass(force):
                    raise UsageError(
                        f"{force.name} takes mass, which a body of {one.name} keeps: push it with `propeller` instead"
                    )
        self.composition = KernelTerms(self.forces, self.medium, () if carriers else self.colliders)
        self.emitters: list[ActiveEmitter] = list(emitters)
        self.look = _checked_look(look)
        lightest = min(self._least_masses(mass), default=None)
        if lightest is not None:
            for force in self.forces:
                force.check_mass(lightest)
        self.name = ""
        self._initial = self._arrays(position, velocity, mass, charge, radius, dict(attributes or {}))
        if (
            self._initial
            and speed_of_light
            and (np.linalg.norm(self._initial["velocity"], axis=0) >= speed_of_light).any()
        ):
            raise UsageError(f"velocity must be below the speed of light, {speed_of_light:g} m/s")
        self._attributes = dict(attributes or {})
        self._fixed = self._which(fixed)
        for force in self.forces:
            missing = [name for name in force.needs if name not in self.attribute_names]
            if missing:
                raise UsageError(
                    f"{force.name} needs particles with the attribute {missing[0]}: declare it, or use rigid bodies"
                )
        self._state: Particles | None = None
        self._time = lambda: 0.0

    def _least_masses(self, mass) -> list[float]:
        """The least mass of the initial particles and of each kind of birth, kg; kinds given by density have any."""
        least = [] if mass is None or not np.size(mass) else [float(np.min(mass))]
        kinds = [kind for emission in self.emitters for kind in emission.kinds]
        return least + [kind.attributes["mass"][0] for kind in kinds if "density" not in kind.attributes]

    @staticmethod
    def _arrays(position, velocity, mass, charge, radius, attributes) -> dict[str, np.ndarray]:
        if position is None:
            return {}
        x = np.asarray(position, np.float64)
        if x.ndim != 2 or x.shape[1] != 3:
            raise UsageError(f"position must have the shape (n, 3), not {x.shape}")
        n = len(x)
        arrays = {"position": x.T}
        v = np.zeros((n, 3)) if velocity is None else np.asarray(velocity, np.float64)
        if v.shape != (n, 3):
            raise UsageError(f"velocity must have the shape ({n}, 3) of position, not {v.shape}")
        arrays["velocity"] = v.T
        for name, given, default in (
            ("mass", mass, 1.0),
            ("charge", charge, 0.0),
            ("radius", radius, 0.01),
            *((k, a, 0.0) for k, a in attributes.items()),
        ):
            try:
                arrays[name] = np.broadcast_to(np.asarray(default if given is None else given, np.float64), (n,))
            except ValueError:
                raise UsageError(f"{name} must be one number or have the shape ({n},), not {np.shape(given)}") from None
        for name, array in arrays.items():
            if not np.isfinite(array).all():
                raise UsageError(f"{name} holds numbers that are not finite")
        if (arrays["mass"] < 0).any():
            raise UsageError("mass must not be negative")
        return arrays

    def _which(self, fixed) -> np.ndarray:
        """Indices of the fixed particles, which must be at rest."""
        n = len(self._initial["mass"]) if self._initial else 0
        chosen = np.asarray([] if fixed is None else fixed)
        chosen = np.flatnonzero(chosen) if chosen.dtype == bool and chosen.shape == (n,) else chosen.astype(int)
        if chosen.ndim != 1 or (len(chosen) and not 0 <= chosen.min() <= chosen.max() < n):
            raise UsageError(f"fixed must be indices from 0 to {n - 1}, or {n} times true or false")
        if len(chosen) and self._initial["velocity"][:, chosen].any():
            raise UsageError("fixed particles do not move: their velocity must be 0")
        return chosen

    @property
    def reports_impacts(self) -> bool:
        """Whether impacts on one of its colliders feed births; `impact` is then the age at a particle's last one, s."""
        return any(one.values["action"] == "emit" for one in self.colliders)

    @property
    def attribute_names(self) -> tuple[str, ...]:
        """Declared attributes, in order of name: of the arrays, of the interactions and of every kind of birth."""
        names = set(self._attributes).union(*(one.attributes for one in self.interactions))
        for emission in self.emitters:
            for kind in emission.kinds:
                names |= set(kind.attributes) - {"mass", "charge", "radius", "lifetime", "density"}
        if self.reports_impacts:
            names.add("impact")
        return tuple(sorted(names))

    def allocate(self, name: str, dtype: type[np.floating], key: np.uint64, time: Callable[[], float]) -> None:
        """Become part of a simulation: allocate the state and give the initial particles their keys."""
        from gen_art.maths.random import channel_of, derive

        if self._state is not None:
            raise UsageError(f"system '{name}' is part of a simulation already: make another ParticleSystem")
        self.name, self._time = name, time
        sources = []
        names = self.attribute_names
        channels = {attribute: FIRST_ATTRIBUTE + k for k, attribute in enumerate(names)}
        if self._initial:
            sources.append(ParticleOrigin("initial"))
        self.emitters.sort(key=lambda e: e.name)
        for emission in self.emitters:
            emission.key = np.uint64(derive(key, channel_of(emission.name)))
            emission.first_source = len(sources)
            for kind in emission.kinds:
                kind.channels = channels
                sources.append(ParticleOrigin(emission.name, kind.tag, kind.name))
        count = len(self._initial["mass"]) if self._initial else 0
        self._state = state = Particles(dtype, names, tuple(sources), max(1024, count))
        if self._initial:
            keys = derive(derive(key, channel_of("initial")), np.arange(count))
            new = state.append(np.zeros(count), keys, np.zeros(count, np.int32))
            state.floats[POSITION, new] = self._initial["position"]
            state.floats[VELOCITY, new] = self._initial["velocity"]
            state.floats[LIFETIME, new] = np.inf
            state.floats[LIFETIME, self._fixed] = FIXED
            for name in ("mass", "charge", "radius", *self._attributes):
                state.floats[state.channels[name], new] = self._initial[name]
        self._initial = {}
        state.may_die = state.may_die or any(one.values["action"] == "kill" for one in self.colliders)

    @property
    def state(self) -> Particles:
        """The storage; UsageError until the system is part of a simulation."""
        if self._state is None:
            raise UsageError("this ParticleSystem is not part of a simulation yet")
        return self._state

    def births_until(self, time: float) -> int:
        """How many scheduled births lie between those made and `time`."""
        return sum(e.schedule.until(time) - e.done for e in self.emitters if e.schedule is not None)

    def _living(self):
        return np.flatnonzero(self.state.alive(self._time()))

    def _copy(self, array) -> np.ndarray:
        out = np.array(array)
        out.flags.writeable = False
        return out

    @property
    def count(self) -> int:
        """How many live now."""
        return len(self._living())

    @property
    def ids(self) -> np.ndarray:
        """(n,) int64, in rising order; never reused."""
        return self._copy(self.state.id[self._living()])

    @property
    def keys(self) -> np.ndarray:
        """(n,) uint64: each particle's random stream."""
        words = self.state.key[:, self._living()].astype(np.uint64)
        return self._copy((words[0] << np.uint64(32)) | words[1])

    @property
    def emitter(self) -> np.ndarray:
        """(n,) names of the emitters they came from ("initial" for particles given as arrays)."""
        names = np.array([s.name for s in self.state.sources] or [""])
        return self._copy(names[self.state.source[self._living()]])

    @property
    def position(self) -> np.ndarray:
        """(n, 3) m."""
        return self._copy(self.state.floats[POSITION, self._living()].T)

    @property
    def velocity(self) -> np.ndarray:
        """(n, 3) m/s, at the same time as the positions."""
        return self._copy(self.state.floats[VELOCITY, self._living()].T)

    def attribute(self, name: str) -> np.ndarray:
        """(n,) mass, charge, radius, lifetime or a declared attribute."""
        from gen_art.registry import suggest

        if name not in self.state.channels:
            raise UsageError(f"system '{self.name}' has no attribute '{name}'{suggest(name, self.state.channels)}")
        return self._copy(self.state.floats[self.state.channels[name], self._living()])

    @property
    def mass(self) -> np.ndarray:
        """(n,) kg."""
        return self.attribute("mass")

    @property
    def charge(self) -> np.ndarray:
        """(n,) C."""
        return self.attribute("charge")

    @property
    def radius(self) -> np.ndarray:
        """(n,) m."""
        return self.attribute("radius")

    @property
    def age(self) -> np.ndarray:
        """(n,) s since birth."""
        return self._copy(self._time() - self.state.birth[self._living()])


def _checked_look(look) -> "Look | None":
    from gen_art.preset.look import Look

    if look is None or isinstance(look, Look):
        return look
    if not isinstance(look, Mapping):
        raise UsageError(f"look must be a ga.Look or a mapping of its keys, such as {{'draw': 'disc'}}, not {look!r}")
    from pydantic import ValidationError

    from gen_art.preset.model import friendly
    from gen_art.preset.problems import dotted

    try:
        return Look.model_validate(dict(look))
    except ValidationError as error:
        problems = [f"{dotted(('look', *one['loc']))}: {friendly(one)}" for one in error.errors()]
        raise UsageError("; ".join(problems)) from None


class ParticleOrigin:
    """Where particles came from: the emitter's name, the kind's name and tag."""

    def __init__(self, name: str, tag: str | None = None, kind: str = ""):
        self.name, self.tag, self.kind = name, tag, kind
