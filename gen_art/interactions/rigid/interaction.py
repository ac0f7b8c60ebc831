"""Rigid bodies that collide, slide, roll and stack."""

import inspect
import math
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from gen_art.arguments import instances, shown
from gen_art.errors import UsageError
from gen_art.interactions.base import Interaction, Shapes, interaction
from gen_art.particles.storage import Particles
from gen_art.registry import param

__all__ = ["Rigid"]


def _built(spec: dict) -> Any:
    from gen_art.interactions.rigid.body import body

    names = inspect.signature(body).parameters
    unknown = [str(key) for key in spec if key not in names]
    if unknown or "shape" not in spec:
        raise UsageError(
            f"a body needs a shape, and may have {', '.join(names)}" + (f"; not {unknown[0]}" if unknown else "")
        )
    return body(**spec)


def _numbered(name: str, group) -> list:
    """The bodies of an emitter with their names in messages."""
    several = len(group.members) > 1
    return [replace(one, name=f"{name} {k + 1}" if several else name) for k, one in enumerate(group.members)]


@interaction("rigid")
class Rigid(Interaction):
    """Rigid bodies that rotate with their full inertia and collide with each other and with colliders.

    m dV/dt = sum F_i,  dL/dt = sum r_i x F_i,  v_i = V + w x r_i,  w = I^-1 L  over the particles i of a body
    at a contact: w_n' = -restitution w_n, and 0 where gravity undoes the bounce within the step; F_t <= friction F_n

    restitution : speed after over speed before, between bodies
    friction : Coulomb's coefficient between bodies
    iterations : largest number of pairs of sweeps over the contacts in a half step
    lamp : the direction that the attribute `shade`, 0 to 1, is lit from
    bodies : those that the system's `body` emitters lay; in Python ga.bodies(...).system(...)
    joints : by name, one of
        {ball: [a, b], at: [x, y, z]}, a common point
        {hinge: [a, b], at, axis}, a common axis; {slider: [a, b], at, axis}, which moves along an axis without turning
        {weld: [a, b], at}, no motion; {distance: [a, b], at: [point of a, point of b]}, a constant distance
        a and b are names of bodies, or `world` for b; at, m, and axis are in world coordinates at the start
        `range: [low, high]` of a hinge in degrees, -180 to 180, of a slider in m, both from the start; of a distance in m
        `motor: {speed: rad/s, torque: N m}` of a hinge, `{speed: m/s, force: N}` of a slider, of a against b; without torque or
        force the speed is kept whatever it takes
    Joints are kept to rounding, g(x) = 0 at the end of each step, with impulses along dg/dx (RATTLE): symplectic, order 2.
    A bound of a range stops without a bounce. Joined bodies do not collide with each other.
    Colliders of the system act on the shapes, with their own restitution and friction; their action must be to bounce.
    Torque-free rotation has order 4 and keeps L exactly; with leapfrog, contacts and constant forces have order 2. Impulses are
    exchanged at the speeds of the moment, so that a bounce never gains energy; it comes early by up to a step, but at the right
    time where a ball touches only one collider.
    Needs leapfrog, velocity_verlet or semi_implicit_euler. Contacts are dissipative; reciprocal except for bodies that are held.
    Sources: Catto (2005) for sequential impulses; Andersen (1983) for joints and for the velocities at the
    end of a step (RATTLE).
    """

    restitution: float = param(0.3, min=0, max=1)
    friction: tuple = param((0.5, 0.5), kind="range", min=0, doc="kinetic..static, if they differ")
    iterations: int = param(80, min=1, max=100_000)
    lamp: tuple = param((-0.5, 0.75, 0.45), doc="direction towards the lamp of `shade`")
    joints: object = param(None, doc="by name; bodies are named as their emitters")
    bodies: object = param(None, doc="arguments of ga.body, in Python; those that emitters lay when left out")

    implicit = True
    moves_particles = True
    conservative = False
    parts = ()

    def prepare(self):
        lamp = np.array(self.values["lamp"])
        if not lamp.any():
            raise UsageError("rigid: lamp must not be the zero vector")
        joints = self.values["joints"]
        if joints is not None and not isinstance(joints, Mapping):
            raise UsageError(
                f"joints must be a mapping, such as {{elbow: {{ball: [a, b], at: [0, 1, 0]}}}}, not {shown(joints)}"
            )
        if joints is not None:
            from gen_art.interactions.rigid.joint import plain_joints

            self.values["joints"] = plain_joints(joints)
        bodies = self.values["bodies"]
        if bodies is not None:
            self._given = [_built(spec) for spec in instances("bodies", bodies, dict, "the arguments of ga.body")]
        pair = self.values["friction"]
        self.values["friction"] = (min(pair), max(pair))
        self._colliders: list = []
        self._world = None

    @property
    def at_rest(self) -> bool:
        return self._world is not None and self._world.at_rest

    def shapes(self, state: Particles) -> Shapes | None:
        return self._world.shapes() if self._world is not None else None

    def states(self) -> list | None:
        """The BodyState of each body, or None before a simulation has them."""
        from gen_art.interactions.rigid.body_state import body_states

        return body_states(self._world) if self._world is not None else None

    def take_colliders(self, colliders: list, names: dict) -> list:
        """Take over the system's colliders, which act on the bodies instead of their particles."""
        for one in colliders:
            if one.values["action"] != "bounce":
                raise UsageError(f"rigid bodies bounce off a {one.name}: its action cannot be {one.values['action']}")
            if one.rotates:
                raise UsageError(
                    f"rigid bodies need colliders that do not rotate: leave out the angular_velocity of the {one.name}"
                )
        self._colliders = list(colliders)
        return []

    def check(self, system):
        if sum(one.moves_particles for one in system.interactions) > 1:
            raise UsageError(f"system '{system.name}' has two `rigid`: give it one")
        scheme = system.scheme
        drifts = sum(drift > 0 for _, _, drift in scheme.stages)
        if scheme.kind != "splitting" or scheme.first_drift or drifts != 1 or scheme.light:
            raise UsageError(
                f"rigid bodies move by leapfrog, velocity_verlet or semi_implicit_euler; give '{system.name}' one of them, "
                f"not {scheme.name}"
            )
        if self.values["bodies"] is not None:
            return
        for emission in system.emitters:
            for kind in emission.kinds:
                if getattr(kind.scripted, "group", None) is None:
                    raise UsageError(
                        f"system '{system.name}' has rigid bodies: its emitter '{emission.name}' must lay such (body: ...); "
                        "give other particles a system of their own"
                    )
                if math.isfinite(kind.attributes["lifetime"][0]):
                    raise UsageError(f"rigid bodies do not die: leave out the lifetime of system '{system.name}'")
        if not system.emitters:
            raise UsageError(
                f"system '{system.name}' has no rigid bodies: lay some by `body`, or by ga.bodies in Python"
            )
        self._check_overlaps(system)

    def _check_overlaps(self, system) -> None:
        """Raise UsageError for bodies that overlap each other at the start, before they are laid; static ones may."""
        from gen_art.interactions.rigid.body import STATIC
        from gen_art.interactions.rigid.world import World

        members = [
            one
            for emission in sorted(system.emitters, key=lambda e: e.name)
            for kind in emission.kinds
            for one in _numbered(emission.name, kind.scripted.group)
        ]
        if not self.values["joints"] and all(one.constraint == STATIC for one in members):
            return
        empty = SimpleNamespace(name=system.name, state=Particles(np.float64, system.attribute_names, (), 1))
        contacts = World(
            members, [], self.values, empty, 0.0
        ).contacts  # distances to colliders need a kernel: `attach` has them
        contacts.detect(0.0)
        contacts.refuse_overlaps(system.name)

    def attach(self, system, dt):
        from gen_art.interactions.rigid.world import World

        self._world = World(self._members(system), self._colliders, self.values, system, dt)
        return []

    def _members(self, system) -> list:
        """The bodies in the order of their particles. Raises UsageError for particles that belong to no body."""
        if self.values["bodies"] is not None:
            return self._given
        state, found = system.state, []
        for emission in system.emitters:
            for k, kind in enumerate(emission.kinds):
                slots = np.flatnonzero(state.source[: state.count] == emission.first_source + k)
                found.append((slots[0], emission.name, kind.scripted.group))
        return [one for _, name, group in sorted(found, key=lambda f: f[0]) for one in _numbered(name, group)]

    @property
    def saved_arrays(self):
        return self._world.saved_arrays

    def restore_arrays(self, saved_arrays, time):
        self._world.restore_arrays(saved_arrays, time)

    def disturb(self, share, push):
        self._world.disturb(share, push)

    def solve(self, state, stage):
        self._world.solve(state, stage)

    def drift(self, state, stage):
        self._world.drift(state, stage)

    def collider_impulses(self):
        return self._world.collider_impulses

    def drift_displacement(self):
        return self._world.particle_displacement()

    def energy(self, state, slots, precision):
        return 0.0
