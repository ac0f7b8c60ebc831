"""Forces on single particles, and the velocity fields of a medium."""

from gen_art.forces.base import FORCES, Force, force
from gen_art.forces.buoyancy import Buoyancy, ThermalLift
from gen_art.forces.central import CentralForce, Hernquist, PointGravity
from gen_art.forces.curl_noise import CurlNoise
from gen_art.forces.drag import Damping, Drag
from gen_art.forces.electromagnetic import ElectricField, MagneticField, MagneticMirror
from gen_art.forces.flows import Aperture, Vortex
from gen_art.forces.gravity import Gravity
from gen_art.forces.spring import Spring
from gen_art.forces.wind import Wind

__all__ = [
    "FORCES",
    "Aperture",
    "Buoyancy",
    "CentralForce",
    "CurlNoise",
    "Damping",
    "Drag",
    "ElectricField",
    "Force",
    "Gravity",
    "Hernquist",
    "MagneticField",
    "MagneticMirror",
    "PointGravity",
    "Spring",
    "ThermalLift",
    "Vortex",
    "Wind",
    "force",
]
