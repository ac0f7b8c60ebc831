"""Births of particles: shapes, velocities, scripted emitters, schedules and events."""

from gen_art.emitters import net_emitters, rigid_body, shapes, velocities
from gen_art.emitters.base import EMITTERS, SHAPES, VELOCITIES, Emitter, Shape, Velocity, emitter
from gen_art.emitters.discs import KuzminDisc
from gen_art.emitters.galaxies import ExponentialDisc, GalaxyHalo, HernquistSphere
from gen_art.emitters.gravitating_spheres import GravitatingSphere
from gen_art.emitters.kepler_rings import KeplerRings
from gen_art.emitters.placed import two_body_orbit

__all__ = [
    "EMITTERS",
    "SHAPES",
    "VELOCITIES",
    "Emitter",
    "ExponentialDisc",
    "GalaxyHalo",
    "GravitatingSphere",
    "HernquistSphere",
    "KeplerRings",
    "KuzminDisc",
    "Shape",
    "Velocity",
    "emitter",
    "net_emitters",
    "rigid_body",
    "shapes",
    "two_body_orbit",
    "velocities",
]
