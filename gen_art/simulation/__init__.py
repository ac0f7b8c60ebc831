"""The Simulation and what belongs to it: systems, steps, ledger, diagnostics, snapshots."""

from gen_art.simulation.simulation import Simulation
from gen_art.simulation.system import ParticleSystem

__all__ = ["ParticleSystem", "Simulation"]
