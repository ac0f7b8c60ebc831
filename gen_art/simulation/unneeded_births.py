"""Leaves out particles that are dead before a picture begins: the picture keeps its bits, and its steps cost less.

A particle that no other one feels, and that feels no other, moves alike whoever else there is. So births can be left out whose
particles die before the first step that a picture shows. The others keep their random numbers and times, and their ids too where
births have a schedule; children of events are numbered as they come.
"""

import math

from gen_art.simulation.simulation import Simulation
from gen_art.simulation.system import ParticleSystem

__all__ = ["leave_out_births"]

ROUNDING = 1e-6  # of a lifetime in float32, with room to spare


def leave_out_births(sim: Simulation, step: int) -> list[str]:
    """Leave out births of particles that are dead before `step` of a simulation that has not begun, and so are all that their
    events make; returns the names of the systems that lack some.

    Systems keep all births that have interactions or exert forces, whose births are a Python class's, or whose particles are
    born of events and look different by `id`, which counts births; and all do in a simulation with a ledger.
    """
    if sim.keeps_ledger or sim.steps_done > 0:
        return []
    children: dict[str, list[str]] = {name: [] for name in sim.members}
    for name, system in sim.members.items():
        for emitter in system.emitters:
            if emitter.event is not None:
                children[emitter.event.system].append(name)

    def longest(name: str, above: tuple[str, ...]) -> float:
        """The longest time, s, from a birth to the last death among its descendants."""
        if name in above or name in sim.coupled_names or not _may_lack_births(sim, name):
            return math.inf
        kinds = [kind for emitter in sim.members[name].emitters for kind in emitter.kinds]
        own = max((kind.attributes["lifetime"][1] for kind in kinds), default=math.inf)
        return own + max((longest(child, (*above, name)) for child in children[name]), default=0.0)

    shortened = []
    for name, system in sim.members.items():
        lasts = longest(name, ())
        first = math.floor(step - lasts * (1.0 + ROUNDING) / sim.dt) - 1 if math.isfinite(lasts) else 0
        if first > 0 and _leave_out(system, first * sim.dt):
            shortened.append(name)
    return shortened


def _may_lack_births(sim: Simulation, name: str) -> bool:
    emitters = sim.members[name].emitters
    if any(kind.scripted is not None for emitter in emitters for kind in emitter.kinds):
        return False
    if all(emitter.event is None for emitter in emitters):
        return True
    looks = () if sim.preset is None else sim.preset.systems[name].all_looks.values()
    return sim.preset is not None and not any(look.goes_by("id") for look in looks)


def _leave_out(system: ParticleSystem, until: float) -> bool:
    """Leave out the births of a system up to this time; returns whether there may be any."""
    left_out = False
    for emitter in system.emitters:
        if emitter.schedule is None:
            emitter.begins, left_out = until, True
        else:
            done = max(emitter.done, emitter.schedule.until(until))
            system.state.next_id += done - emitter.done
            left_out |= done > emitter.done
            emitter.done = done
    return left_out
