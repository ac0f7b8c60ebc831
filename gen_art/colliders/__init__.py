"""Surfaces that particles bounce off, stick to, or are removed at."""

from gen_art.colliders.base import COLLIDERS, Collider, collider
from gen_art.colliders.box import Block, Box
from gen_art.colliders.capsule import Capsule
from gen_art.colliders.cylinder import Cylinder
from gen_art.colliders.plane import Plane
from gen_art.colliders.sdf import SDF
from gen_art.colliders.sphere import Sphere
from gen_art.colliders.torus import Torus

__all__ = [
    "COLLIDERS",
    "SDF",
    "Block",
    "Box",
    "Capsule",
    "Collider",
    "Cylinder",
    "Plane",
    "Sphere",
    "Torus",
    "collider",
]
