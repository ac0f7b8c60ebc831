"""Forces on single particles, and the velocity fields of a medium."""

from gen_art.forces.aircraft import Aircraft
from gen_art.forces.attractor import Attractor
from gen_art.forces.base import FORCES, Force, force
from gen_art.forces.buoyancy import Buoyancy, ThermalLift
from gen_art.forces.central import CentralForce, Hernquist, PointGravity
from gen_art.forces.curl_noise import CurlNoise
from gen_art.forces.drag import Damping, Drag
from gen_art.forces.driver import Driver
from gen_art.forces.electric_sources import ElectricDipole, ElectricGrid, ElectricQuadrupole, ElectricWire
from gen_art.forces.electromagnetic import ElectricField, MagneticField, MagneticMirror
from gen_art.forces.flows import Aperture, Vortex
from gen_art.forces.gravity import Gravity, HeightGravity
from gen_art.forces.langevin import Langevin
from gen_art.forces.lift import Lift
from gen_art.forces.magnetic_sources import MagneticDipole, MagneticGrid, MagneticLoop, MagneticWire
from gen_art.forces.panel import Panel
from gen_art.forces.random_driver import RandomDriver
from gen_art.forces.spring import Hand, Spring
from gen_art.forces.submarine import Ballast, Propeller
from gen_art.forces.thrust import Thrust
from gen_art.forces.thruster import Thruster
from gen_art.forces.vector_field import VectorField
from gen_art.forces.wind import Wind

__all__ = [
    "FORCES",
    "Aircraft",
    "Aperture",
    "Attractor",
    "Ballast",
    "Buoyancy",
    "CentralForce",
    "CurlNoise",
    "Damping",
    "Drag",
    "Driver",
    "ElectricDipole",
    "ElectricField",
    "ElectricGrid",
    "ElectricQuadrupole",
    "ElectricWire",
    "Force",
    "Gravity",
    "Hand",
    "HeightGravity",
    "Hernquist",
    "Langevin",
    "Lift",
    "MagneticDipole",
    "MagneticField",
    "MagneticGrid",
    "MagneticLoop",
    "MagneticMirror",
    "MagneticWire",
    "Panel",
    "PointGravity",
    "Propeller",
    "RandomDriver",
    "Spring",
    "ThermalLift",
    "Thrust",
    "Thruster",
    "VectorField",
    "Vortex",
    "Wind",
    "force",
]
