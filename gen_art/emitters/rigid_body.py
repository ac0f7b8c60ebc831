"""Rigid bodies: initial conditions as the particles that represent them (`interactions: rigid`)."""

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from gen_art.emitters.base import Emitter, emitter
from gen_art.errors import UsageError
from gen_art.particles.fixed import FIXED
from gen_art.registry import param

if TYPE_CHECKING:
    from gen_art.interactions.rigid.group import Group

__all__ = ["RigidBody"]

MOST_BODIES, MOST_PARTICLES = 20_000, 2_000_000  # of an emitter
_GOLDEN = (5**0.5 - 1) / 2  # its multiples modulo 1 fill a range evenly, with neighbours far apart


@emitter("body")
class RigidBody(Emitter):
    """A rigid body, or a grid of equal bodies, as particles on its surface or along its edges that have its whole mass.

    mass = density volume (or density area, if hollow)
    centres at position + (i, j, k) pitch, 0 <= (i, j, k) < grid

    shape : {sphere: radius}, {capsule: [length of the straight part, radius]} along y, {box: [x, y, z]}, in m; or a list of
        these for a compound, each with optional `at` (m), `turn` (degrees) and `density` (relative to the others)
    velocity : m/s, of the centre of mass
    spin : rad/s, (3,)
    turn : rotation vector, axis times angle
    pivot : a point (3,) of the body that stays in place
    axle : (3,), the body can only rotate about this axis, through the pivot or, without one, the centre of mass
    static : the body never moves
    points : approximate number of particles of a body; six more, with radius 0, have mass inside it
    grain : m, radius of the particles
    Its particles have the attributes normal_x, normal_y, normal_z (outward), area (m^2, half the surface that a point
    represents), shade (0 to 1, how much it faces the lamp of `rigid`) and tint.
    """

    shape: object = param(doc="sphere, capsule, box, or a list of these")
    density: float = param(1000.0, unit="kg/m^3", min=1e-300)
    mass: float = param(None, unit="kg", min=1e-300, doc="of each body; default: from its density")
    hollow: bool = param(False, doc="the mass is on the surface; density is then in kg/m^2")
    position: tuple = param((0.0, 0.0, 0.0), unit="m")
    turn: tuple = param((0.0, 0.0, 0.0), unit="rad")
    velocity: tuple = param((0.0, 0.0, 0.0), unit="m/s")
    spin: tuple = param((0.0, 0.0, 0.0), unit="rad/s")
    pivot: tuple = param(None, unit="m", kind="vector")
    axle: tuple = param(None, kind="vector")
    static: bool = param(False)
    draw: str = param(
        "cloud", choices=("cloud", "wire"), doc="points over the surface, or along edges and great circles"
    )
    points: int = param(400, min=8, max=1_000_000)
    grain: float = param(None, unit="m", min=0, doc="default: three quarters of the points' spacing")
    tint: tuple = param(
        (0.0, 0.0), kind="range", doc="a number to colour by; a range is spread over the bodies of the grid"
    )
    grid: tuple = param((1.0, 1.0, 1.0), min=1, max=10_000, doc="how many along x, y and z")
    pitch: tuple = param((1.0, 1.0, 1.0), unit="m", doc="from one body of the grid to the next")

    declares = ("area", "normal_x", "normal_y", "normal_z", "shade", "tint")

    def prepare(self):
        from gen_art.interactions.rigid.body import body

        v = dict(self.values)
        low, _ = v.pop("tint")
        grid, pitch = [round(n) for n in v.pop("grid")], np.array(v.pop("pitch"))
        if any(n != g for n, g in zip(grid, self.values["grid"])):
            raise UsageError(f"grid must be three whole numbers, not {list(self.values['grid'])}")
        start, count = np.array(v.pop("position")), math.prod(grid)
        if count > MOST_BODIES:
            raise UsageError(f"a grid has at most {MOST_BODIES:,} bodies, not {count:,}")
        if count * v["points"] > MOST_PARTICLES:
            raise UsageError(
                f"{count:,} bodies of {v['points']:,} points are {count * v['points']:,} particles, and an emitter lays at "
                f"most {MOST_PARTICLES:,}: lower `points` or `grid`"
            )
        cells = [(i, j, k) for j in range(grid[1]) for k in range(grid[2]) for i in range(grid[0])]
        if v["pivot"] is not None and count > 1:
            raise UsageError("a pivot is for one body: leave out grid, or the pivot")
        first = body(position=start, tint=low, **v)
        self.births = count * len(first.local)
        if self.births > MOST_PARTICLES:
            raise UsageError(
                f"{count:,} bodies of these sizes are {self.births:,} particles, and an emitter lays at most "
                f"{MOST_PARTICLES:,}: lower `points` or `grid`"
            )
        self._first, self._cells, self._start, self._pitch = first, cells, start, pitch

    @cached_property
    def group(self) -> "Group":
        """The bodies as particles; made when they are asked for, as a preset is read several times before it is simulated."""
        from gen_art.interactions.rigid.body import moved
        from gen_art.interactions.rigid.group import Group

        low, high = self.values["tint"]
        return Group(
            moved(self._first, self._start + self._pitch * cell, low + (high - low) * (n * _GOLDEN % 1.0))
            if n
            else self._first
            for n, cell in enumerate(self._cells)
        )

    def sample(self, r, n):
        group = self.group
        born = {"position": group.position.T, "velocity": group.velocity.T, "mass": group.mass, "radius": group.radius}
        born["lifetime"] = np.where(group.fixed, FIXED, np.inf)
        return {**born, **group.attributes}
