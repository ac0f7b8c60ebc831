"""The Simulation: its systems, steps, ledger, diagnostics and snapshots."""

from gen_art.simulation.simulation import Simulation
from gen_art.simulation.system import ParticleSystem

__all__ = ["ParticleSystem", "Simulation"]
