"""Births of particles: shapes, velocities, scripted emitters, schedules and events."""

from gen_art.emitters import galaxies, net_emitters, rigid_body, shapes, velocities
from gen_art.emitters.base import EMITTERS, SHAPES, VELOCITIES, Emitter, Shape, Velocity, emitter

__all__ = [
    "EMITTERS",
    "SHAPES",
    "VELOCITIES",
    "Emitter",
    "Shape",
    "Velocity",
    "emitter",
    "galaxies",
    "net_emitters",
    "rigid_body",
    "shapes",
    "velocities",
]
