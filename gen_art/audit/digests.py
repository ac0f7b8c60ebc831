"""Digests of presets' states after a few steps, and where two processors' digests part."""

import platform
from collections.abc import Callable, Sequence
from typing import Any

from gen_art.backend import processor
from gen_art.errors import UsageError

__all__ = ["STEPS", "differences", "state_digests"]

STEPS = (0, 1, 16)  # births alone, one step, and as many as bring out most kinds of step
FORMAT = 1


def state_digests(
    presets: Sequence, *, steps: Sequence[int] = STEPS, precisions: Sequence[str] = ("f32", "f64"),
    threads: int | None = None, progress: Callable[[str], Any] = lambda name: None,
) -> dict:  # fmt: skip
    """The digests of each system of some presets, with the processor that they come from.

    presets : Presets
    steps : numbers of steps after which digests are taken, in order
    precisions : f32, f64 or both
    progress : called with the name of each preset before it runs
    Returns {"format", "processor", "system", "digests": {preset: {precision: {steps: {system: SHA-256}}}}}.
    """
    from gen_art.simulation import Simulation

    found: dict[str, dict] = {}
    for preset in presets:
        progress(preset.name)
        by_precision = found.setdefault(preset.name, {})
        for precision in precisions:
            sim = Simulation(preset, precision=precision, threads=threads, advice="none")
            moments = by_precision.setdefault(precision, {})
            for step in steps:
                sim.step(step - sim.steps_done)
                moments[str(step)] = {name: sim.digest(name) for name in sim.members}
    system = f"{platform.system()} {platform.machine()}"
    return {"format": FORMAT, "processor": processor.name(), "system": system, "digests": found}


def differences(ours: dict, theirs: dict) -> list[str]:
    """A sentence for each system whose digests differ in two results of `state_digests`, with the first step at which they do.

    Raises UsageError for a result of another format.
    """
    if not isinstance(theirs, dict) or theirs.get("format") != FORMAT or not isinstance(theirs.get("digests"), dict):
        raise UsageError("the file to compare with holds no digests; gen-art digests writes it")
    lines = []
    for preset in sorted(ours["digests"].keys() & theirs["digests"].keys()):
        for precision, moments in ours["digests"][preset].items():
            others = theirs["digests"][preset].get(precision, {})
            for system in sorted({name for moment in moments.values() for name in moment}):
                parted = [
                    step
                    for step, moment in moments.items()
                    if step in others and moment[system] != others[step].get(system)
                ]
                if parted:
                    lines.append(f"{preset} {precision}: {system} differs from step {parted[0]} on")
    return lines
