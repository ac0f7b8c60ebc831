"""The particles that a look draws: those of its system, or of some of its emitters."""

from gen_art.particles.storage import Particles
from gen_art.preset.look import Look

__all__ = ["particles_of", "system_of"]


def system_of(sim, name: str) -> str:
    """The system of a look, which is called SYSTEM, or SYSTEM.NAME if it is one of the further looks."""
    return name if name in sim.systems else name.rpartition(".")[0]


def particles_of(sim, name: str, look: Look | None) -> Particles:
    """The particles that the look of this name draws; all of its system without a look."""
    state = sim.systems[system_of(sim, name)]
    return state.with_tags(look.tag) if look is not None and look.tag else state
