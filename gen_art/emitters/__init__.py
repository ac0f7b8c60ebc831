"""Births: shapes, velocities, scripted emitters, schedules and events."""

from gen_art.emitters import galaxies, nets, rigid, shapes, velocities
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
    "nets",
    "rigid",
    "shapes",
    "velocities",
]
