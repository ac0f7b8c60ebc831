"""Leaves out particles that are dead before a picture begins: the picture keeps its bits, and its steps cost less.

A particle that no other one feels, and that feels no other, moves alike whoever else there is. So births can be left out whose
particles die before the first step that a picture shows. The others keep their random numbers, times and ids.
"""

import math

from gen_art.simulation.simulation import Simulation

__all__ = ["leave_out_births"]

ROUNDING = 1e-6  # of a lifetime in float32, with room to spare


def leave_out_births(sim: Simulation, step: int) -> list[str]:
    """Leave out births of particles that are dead before `step` of a simulation that has not begun; returns the names of the
    systems that lack some.

    Systems keep all births that have interactions or exert forces, whose particles are born of events or are parents in them, or
    whose births are a Python class's, and all do in a simulation with a ledger.
    """
    if sim.keeps_ledger or sim.steps_done > 0:
        return []
    events = [(name, e.event) for name, system in sim.members.items() for e in system.emitters if e.event is not None]
    bound = {*sim.coupled_names, *(name for name, _ in events), *(event.system for _, event in events)}
    shortened = []
    for name, system in sim.members.items():
        kinds = [kind for emitter in system.emitters for kind in emitter.kinds]
        if name in bound or any(kind.scripted is not None for kind in kinds):
            continue
        longest = max((kind.attributes["lifetime"][1] for kind in kinds), default=math.inf)
        first = math.floor(step - longest * (1.0 + ROUNDING) / sim.dt) - 1 if math.isfinite(longest) else 0
        if first > 0 and (left_out := _leave_out(system, first * sim.dt)):
            system.state.next_id += left_out
            shortened.append(name)
    return shortened


def _leave_out(system, until: float) -> int:
    """Skip the scheduled births of a system up to this time; returns their number."""
    left_out = 0
    for emitter in system.emitters:
        done = max(emitter.done, emitter.schedule.until(until))
        left_out += done - emitter.done
        emitter.done = done
    return left_out
