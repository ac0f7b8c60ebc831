"""Forces between pairs of particles that a user writes: the base class, and the sums over all pairs or near ones."""

import math
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from gen_art.errors import UsageError
from gen_art.interactions.base import ForcePart, ForceRequest, Interaction
from gen_art.interactions.neighbour_grid import sort_into_grid
from gen_art.interactions.pair_law_check import check_reaction_and_potential
from gen_art.interactions.pair_law_kernels import BLOCK, NO_GRID, GridArrays, law_kernels
from gen_art.kernel_methods import PARTICLE, attributes_read, check_kernel_methods, is_own
from gen_art.particles.periodic_box import PeriodicBox
from gen_art.particles.rows import MASS, POSITION
from gen_art.particles.storage import Particles
from gen_art.registry import suggest

__all__ = ["PairLaw"]

_OF_NO_PAIR = {"flow", "since", "step"}  # what forces on single particles read, and pairs cannot
_OF_NO_POTENTIAL = {"age"}  # a potential has no time
_CELL = 1 + 1e-6  # width of a cell over the cutoff: round-off must not put a pair two cells apart


class PairLaw(Interaction):
    """A force between the particles of each pair, from the states of both.

    A subclass declares parameters by `name: float = ga.param(...)` and these @ti.func methods:

    pair(self, r, v, a, b, t, q) : (3,) N, the force on `a` by `b`
    potential(self, r, a, b, q) : J, of the pair; minus its gradient by r is the force

    r : (3,) m, from b to a; in a periodic box that of nearest images
    v : (3,) m/s, the velocity of a relative to b
    a, b : the particles (position, velocity, mass, charge, radius, age, lifetime, key, declared attributes)
    t : s
    q : the run-time parameters

    A parameter named `cutoff`, in m, limits the law to pairs that are nearer than it, which a grid of cells finds; without it,
    or where it is None, all pairs are summed. Let the force vanish there: a jump changes the energy at each crossing.
    A parameter named `sources`, of type str, names another system whose particles are then b, without reaction.

    Flags, which the ledger and `inspect` read:
    conservative : has a potential
    reciprocal : pair(-r, -v, b, a) is -pair(r, v, a, b), so that momentum is conserved; the default
    dissipative : the ledger counts minus its work as dissipated
    Raises UsageError for a subclass without `pair`, and when a simulation takes its system, for a law that is declared
    reciprocal and is not, or whose potential is not that of its force.
    """

    conservative: ClassVar[bool] = False
    dissipative: ClassVar[bool] = False
    periodic = True
    kernel_methods: ClassVar[tuple[str, ...]] = ("pair", "potential")

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        check_kernel_methods(cls, cls.kernel_methods)
        if not callable(getattr(cls, "pair", None)):
            raise UsageError(f"{cls.__name__} needs the method pair(self, r, v, a, b, t, q), the force on a by b in N")
        if cls.conservative and not callable(getattr(cls, "potential", None)):
            raise UsageError(f"{cls.__name__} is declared conservative: it needs a potential(self, r, a, b, q)")
        if cls.conservative and cls.dissipative:
            raise UsageError(f"{cls.__name__} is declared conservative and dissipative: a law is one of them")
        cls.parts = (ForcePart(dissipates=cls.dissipative),)

    @property
    def reach(self) -> float | None:
        """m, beyond which pairs do not act on each other; None if all do."""
        cutoff = self.values.get("cutoff")
        return None if cutoff is None or math.isinf(cutoff) else cutoff

    def prepare(self) -> None:
        if self.reach is not None and not self.reach > 0:
            raise UsageError(f"{type(self).__name__}: cutoff must be above 0 m, not {self.reach:g}")

    def problem_in(self, box: PeriodicBox, largest_radius: float) -> str | None:
        if self.reach is None:
            return None
        return box.problem_of_reach(f"the cutoff of {self.name}", self.reach)

    def check(self, system: Any) -> None:
        self.check_masses(system, np.zeros(1), np.array([system.least_mass]))
        if is_own(type(self)):
            return
        known = set(PARTICLE) - _OF_NO_PAIR
        for method in self.kernel_methods:
            allowed = known - (_OF_NO_POTENTIAL if method == "potential" else set())
            arguments = ("a",) if self.source_system else ("a", "b")
            for read in attributes_read(type(self), (method,), arguments, allowed):
                if read not in system.attribute_names:
                    hint = suggest(read, (*allowed, *system.attribute_names)) or ": declare it as an attribute"
                    raise UsageError(
                        f"{type(self).__name__}.{method} reads {read}, which its particles do not have{hint}"
                    )

    def check_masses(self, system: Any, ids: np.ndarray, masses: np.ndarray) -> None:
        if (masses <= 0).any():
            raise UsageError(
                f"{self.name} acts with a force, and a particle without mass has no acceleration: give it a mass"
            )

    def attach(self, system: Any, dt: float) -> list[str]:
        if self.source_system is None and not is_own(type(self)):
            check_reaction_and_potential(self, system.state, system.name, self.box)
        return []

    def accelerate(self, request: ForceRequest, out: np.ndarray) -> None:
        if (request.state.floats[MASS, : request.n] <= 0).any():
            self.check_masses(None, np.zeros(1), np.zeros(1))
        request = self._in_box(request)
        grid = self._grid(request.source_rows, request.sources.floats, request.m, request.precision)
        kernels = law_kernels(self, request.state.attributes, request.sources.attributes, request.precision)
        kernels.accelerate(
            request.rows, request.state.floats, request.state.birth, request.state.key, request.n,
            request.source_rows, request.sources.floats, request.sources.birth, request.sources.key, request.m,
            int(request.state is request.sources), request.time, self._numbers(out.dtype), *grid, out,
        )  # fmt: skip

    def energy(self, state: Particles, slots: np.ndarray, precision: str) -> float:
        if not self.conservative or self.source_system is not None or len(slots) < 2:
            return 0.0
        few = state if len(slots) == state.count else state.some(slots)
        rows, n = np.ascontiguousarray(few.floats[:, : len(slots)]), len(slots)
        grid = self._grid(rows, rows, n, precision)
        out = np.zeros(-(-n // BLOCK))
        kernels = law_kernels(self, state.attributes, state.attributes, precision)
        kernels.potential(rows, few.key, n, self._numbers(rows.dtype), *grid, out)
        return float(out.sum())

    def _in_box(self, request: ForceRequest) -> ForceRequest:
        """The request with its positions in the periodic box, if there is one: within a step they go on beyond the sides."""
        if self.box is None:
            return request
        rows = request.rows[:6].copy()
        self.box.wrap(rows[POSITION, : request.n])
        if request.source_rows is request.rows:
            return replace(request, rows=rows, source_rows=rows)
        source_rows = request.source_rows[:6].copy()
        self.box.wrap(source_rows[POSITION, : request.m])
        return replace(request, rows=rows, source_rows=source_rows)

    def _grid(self, rows: np.ndarray, floats: np.ndarray, n: int, precision: str) -> GridArrays:
        """The grid of the sources, and its numbers: cutoff, width of a cell and the frame of a periodic box."""
        if self.reach is None or n == 0:
            lengths = np.zeros(3) if self.box is None else self.box.lengths
            inverse = np.divide(1.0, lengths, out=np.zeros(3), where=lengths > 0)
            frame = np.concatenate([np.zeros(6), lengths, inverse])
            return GridArrays(NO_GRID, NO_GRID, NO_GRID, NO_GRID, np.array([0.0, 0.0, *frame], floats.dtype))
        grid = sort_into_grid(rows, floats, n, self.reach * _CELL, precision, self.box)
        numbers = np.array([self.reach, grid.size, *(grid.frame if len(grid.frame) else np.zeros(12))], floats.dtype)
        return GridArrays(grid.slots, grid.first, grid.low, grid.shape, numbers)

    def _numbers(self, dtype) -> np.ndarray:
        return np.array(self.numbers() or [0.0], dtype)
