"""Block time steps: particles that need shorter steps take them, in powers of two, while the others wait.

A step dt has 2^levels parts of h = dt / 2^levels, in each of which all particles drift and the forces on single particles act.
An interaction gives a particle at level k, whose own step is dt / 2^k, half a kick at the beginning and half at the end of each
of its steps: the kernel's kick of h / 2 with the acceleration times 2^(levels - k). Its level is chosen at the end of each of its
steps, longer ones only where they begin together with all others of their length:

dt / 2^k <= 0.2 sqrt(softening / abs(a))

Source: Springel (2005), MNRAS 364, 1105, section 4; the schemes are those of Tuckerman, Berne & Martyna (1992), J. Chem. Phys.
97, 1990.
"""

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import ForceRequest, Interaction
from gen_art.simulation.stepper import Stepper

__all__ = ["BlockSteps", "check_blocks", "parts_of"]

_SHARE = 0.2  # of sqrt(softening / a) that a particle's step may last


def parts_of(systems) -> int:
    """The number of parts of a step of these systems: 1 where no interaction has levels."""
    return 2 ** max((levels_of(one) for system in systems for one in system.interactions), default=0)


def check_blocks(name: str, system) -> None:
    """Raise UsageError for a system whose steps cannot be divided."""
    if not system.scheme.is_leapfrog:
        raise UsageError(
            f"self_gravity's levels divide the steps of system '{name}', which needs the integrator leapfrog or "
            f"velocity_verlet for that, not {system.scheme.name}"
        )
    for one in system.interactions:
        if one.implicit or one.breaks or not one.smooth:
            raise UsageError(
                f"self_gravity's levels divide the steps of system '{name}', which {one.name} does not allow: leave out `levels`"
            )


def levels_of(one: Interaction) -> int:
    """How often an interaction may halve the step of a particle."""
    return one.values.get("levels", 0)


class BlockSteps:
    """The steps of coupled systems in parts.

    dt : s, the whole step
    parts : of a step; 1 where no interaction has levels
    Between steps it keeps the accelerations of all interactions at the particles' places.
    """

    def __init__(self, steppers: dict[str, Stepper], dt: float, precision: str):
        self._steppers, self._dt, self._precision = steppers, dt, precision
        self.parts = parts_of(stepper.system for stepper in steppers.values())
        self._found: dict[tuple[str, int], np.ndarray] = {}  # by system and interaction, (rows, n) m/s^2
        self._every: dict[tuple[str, int], np.ndarray] = {}  # (n,), parts in the step of each particle

    def step(self, first: int, known: bool) -> None:
        """Take one step.

        known : whether the accelerations at its start are those at the end of the last step
        """
        h = self._dt / self.parts
        everything = [(name, k) for name, stepper in self._steppers.items() for k in self._interactions(stepper)]
        for name, k in everything:
            if not known:
                self._find(name, k, None, h, first * self._dt)
            self._every[name, k] = self._wanted(name, k)
        for part in range(self.parts):
            now = first * self.parts + part
            self._kick_by(part, everything)
            for stepper in self._steppers.values():
                stepper.stage(now, h, 0, 1)
            ended = part + 1
            for name, k in everything:
                ending = ended % self._every[name, k] == 0
                self._find(name, k, None if ending.all() else np.flatnonzero(ending), h, (now + 1) * h)
            self._kick_by(ended, everything)
            for stepper in self._steppers.values():
                stepper.stage(now, h, 1, 2)
            for key in everything:
                every, together = self._every[key], ended & -ended  # the longest steps that begin here
                self._every[key] = np.where(ended % every == 0, np.minimum(self._wanted(*key), together), every)

    @staticmethod
    def _interactions(stepper: Stepper) -> range:
        return range(len(stepper.system.interactions) if stepper.system.state.count else 0)

    def _rows(self, name: str, k: int) -> slice:
        offsets = self._steppers[name].part_offsets
        return slice(3 * offsets[k], 3 * offsets[k + 1])

    def _wanted(self, name: str, k: int) -> np.ndarray:
        """(n,): how many parts the step of each particle should have, by its acceleration by one interaction."""
        one, found = self._steppers[name].system.interactions[k], self._found[name, k]
        levels = levels_of(one)
        if not levels:
            return np.full(found.shape[1], self.parts)
        squared = (found.astype(np.float64) ** 2).sum(axis=0)
        longest = _SHARE * np.sqrt(one.values["softening"] / np.sqrt(np.maximum(squared, 1e-300)))
        level = np.clip(np.ceil(np.log2(self._dt / longest)), 0, levels)
        return (self.parts >> level.astype(np.int64)).astype(np.int64)

    def _kick_by(self, part: int, everything: list[tuple[str, int]]) -> None:
        """Give the kernels the accelerations of those whose own step begins or ends before this part."""
        for name, k in everything:
            found, every = self._found[name, k], self._every[name, k]
            factor = np.where(part % every == 0, every, 0).astype(found.dtype)
            self._steppers[name].pair[self._rows(name, k), : found.shape[1]] = factor * found

    def _find(self, name: str, k: int, some: np.ndarray | None, h: float, time: float) -> None:
        """Compute the accelerations by one interaction at `time`, s, of all particles or of those in the slots `some`."""
        if some is not None and not len(some):
            return
        stepper = self._steppers[name]
        system, rows = stepper.system, self._rows(name, k)
        one, state = system.interactions[k], system.state
        other = self._steppers[one.source_system or name].system.state
        targets = state if some is None else state.some(some)
        request = ForceRequest(
            targets.floats, targets, targets.count, other.floats, other, other.count, h, self._dt, self._precision, time
        )  # fmt: skip
        if some is None:
            out = stepper.pair[rows]
            one.accelerate(request, out)
            self._found[name, k] = out[:, : state.count].copy()
        else:
            out = np.zeros((rows.stop - rows.start, targets.floats.shape[1]), state.floats.dtype)
            one.accelerate(request, out)
            self._found[name, k][:, some] = out[:, : len(some)]
