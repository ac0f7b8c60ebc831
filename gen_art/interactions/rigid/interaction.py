"""Rigid bodies that collide, slide, roll and stack."""

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import Interaction, interaction
from gen_art.registry import param

__all__ = ["Rigid"]


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
    Colliders of the system act on the shapes, with their own restitution and friction; their action must be to bounce.
    Torque-free rotation has order 4 and keeps L exactly; with leapfrog, contacts and constant forces have order 2. Impulses are
    exchanged at the speeds of the moment, so that a bounce never gains energy; it comes early by up to a step, but at the right
    time where a ball touches only one collider.
    Needs leapfrog, velocity_verlet or semi_implicit_euler. Contacts are dissipative; reciprocal except for bodies that are held.
    Sources: Catto (2005) for sequential impulses; Andersen (1983) for the velocities at the end of a step (RATTLE).
    """

    restitution: float = param(0.3, min=0, max=1)
    friction: tuple = param((0.5, 0.5), kind="range", min=0, doc="kinetic..static, if they differ")
    iterations: int = param(80, min=1, max=100_000)
    lamp: tuple = param((-0.5, 0.75, 0.45), doc="direction towards the lamp of `shade`")
    bodies: object = param(None, doc="arguments of ga.body, in Python; those that emitters lay when left out")

    implicit = True
    moves_particles = True
    conservative = False
    parts = ()

    def prepare(self):
        lamp = np.array(self.values["lamp"])
        if not lamp.any():
            raise UsageError("rigid: lamp must not be the zero vector")
        pair = self.values["friction"]
        self.values["friction"] = (min(pair), max(pair))
        self._colliders: list = []
        self._world = None

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

    def attach(self, system, dt):
        from gen_art.interactions.rigid.world import World

        if sum(one.moves_particles for one in system.interactions) > 1:
            raise UsageError(f"system '{system.name}' has two `rigid`: give it one")
        scheme = system.scheme
        drifts = sum(drift > 0 for _, _, drift in scheme.stages)
        if scheme.kind != "splitting" or scheme.first_drift or drifts != 1 or scheme.light:
            raise UsageError(
                f"rigid bodies move by leapfrog, velocity_verlet or semi_implicit_euler; give '{system.name}' one of them, "
                f"not {scheme.name}"
            )
        self._world = World(self._members(system), self._colliders, self.values, system, dt)
        return []

    def _members(self, system) -> list:
        """The bodies in the order of their particles. Raises UsageError for particles that belong to no body."""
        from gen_art.interactions.rigid.body import body

        if self.values["bodies"] is not None:
            return [body(**spec) for spec in self.values["bodies"]]
        state, found = system.state, []
        for emission in system.emitters:
            for k, kind in enumerate(emission.kinds):
                group = getattr(kind.scripted, "group", None)
                if group is None:
                    raise UsageError(
                        f"system '{system.name}' has rigid bodies: its emitter '{emission.name}' must lay such (body: ...); "
                        "give other particles a system of their own"
                    )
                slots = np.flatnonzero(state.source[: state.count] == emission.first_source + k)
                found.append((slots[0], emission.name, group))
        if not found:
            raise UsageError(
                f"system '{system.name}' has no rigid bodies: lay some by `body`, or by ga.bodies in Python"
            )
        from dataclasses import replace

        return [
            replace(one, name=f"{name} {k + 1}" if len(group.members) > 1 else name)
            for _, name, group in sorted(found, key=lambda f: f[0])
            for k, one in enumerate(group.members)
        ]

    @property
    def saved_arrays(self):
        return self._world.saved_arrays

    def restore_arrays(self, saved_arrays, time):
        self._world.restore_arrays(saved_arrays, time)

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
