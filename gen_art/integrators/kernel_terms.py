"""The forces, medium and colliders of one system, laid out for the kernels: which terms there are, and where their numbers lie.

Two compositions of the same classes and fixed choices are equal, whatever their numbers: kernels are cached by them.
"""

import numpy as np

from gen_art.colliders.base import Collider
from gen_art.errors import UsageError
from gen_art.forces.base import Force, burns, pushes
from gen_art.forces.medium import Medium

__all__ = ["KernelTerms", "Term"]

_SURFACES = 31  # bits of a mask


class Term:
    """One force, or collider, in a composition: the object that is traced, and the offset of its numbers."""

    def __init__(self, force: Force, offset: int, name: str, medium: int = -1):
        self.force, self.offset, self.name, self.medium = force, offset, name, medium
        self.repeat = force.repeat

    def count_offset(self) -> int:
        """Where the number of repeats lies in the parameter array (-1: the term is taken once)."""
        if self.repeat is None:
            return -1
        return self.offset + next(o for k, o, _ in self.force.layout() if k == self.repeat)


class KernelTerms:
    """Forces, media and colliders with their offsets in one run-time parameter array."""

    def __init__(self, forces=(), medium: Medium | None = None, colliders=()):
        default = medium or Medium()
        self._numbers: list[float] = []
        self._tables: list[tuple[int, np.ndarray]] = []
        self.media: list[tuple[Term, ...]] = []
        self.terms: list[Term] = []
        known: list[Medium] = []
        names: dict[str, int] = {}
        for force in forces:
            if not isinstance(force, Force):
                raise UsageError(f"forces must be gen_art forces such as ga.forces.Gravity(...), not {force!r}")
            index = -1
            if force.provides("damping") or force.reads_medium:
                own = force.values.get("medium") or default
                if own not in known:
                    known.append(own)
                    self.media.append(tuple(self._place(term, own, term.name) for term in own.terms))
                index = known.index(own)
            base = force.name or type(force).__name__.lower()
            names[base] = names.get(base, 0) + 1
            name = base if names[base] == 1 else f"{base}_{names[base]}"
            self.terms.append(self._place(force, force.values.get("medium") or default, name, index))
        self.colliders = [self._wall(one, default, colliders) for one in colliders]
        if sum(t.force.sides for t in self.colliders) > _SURFACES:
            raise UsageError(
                f"a system can have {_SURFACES} surfaces to collide with (a box counts six): describe more as one sdf"
            )
        self.signature = (
            tuple((t.force.fixed, t.medium) for t in self.terms),
            tuple(tuple(t.force.fixed for t in medium) for medium in self.media),
            tuple(t.force.fixed for t in self.colliders),
        )

    def _place(self, force: Force, medium: Medium, name: str, index: int = -1) -> Term:
        term = Term(force, len(self._numbers), name, index)
        self._numbers += force.bound_numbers(medium)
        if force.tabled:
            self._tables.append((len(self._numbers), force.table()))
            self._numbers += [0.0, 0.0]  # where the table lies: tables stand last, so that their sizes are in no kernel
        return term

    def _wall(self, one, medium: Medium, colliders) -> Term:
        if not isinstance(one, Collider):
            raise UsageError(f"colliders must be such as ga.colliders.Plane(...), not {one!r}")
        same = [other for other in colliders if isinstance(other, Collider) and other.name == one.name]
        which = next(k for k, other in enumerate(same) if other is one)
        return self._place(one, medium, one.name if which == 0 else f"{one.name}_{which + 1}")

    def numbers(self, dtype) -> np.ndarray:
        """All run-time numbers, in the order of the terms' offsets, then the tables."""
        head, start = list(self._numbers or [0.0]), len(self._numbers)
        for place, table in self._tables:
            head[place : place + 2] = divmod(start, 4096)  # in two parts: float32 holds whole numbers up to 2^24
            start += len(table)
        return np.concatenate([np.array(head, dtype), *(table.astype(dtype) for _, table in self._tables)])

    @property
    def pushes(self) -> list[Term]:
        return [t for t in self.terms if pushes(t.force)]

    @property
    def magnetics(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("magnetic")]

    @property
    def dampings(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("damping")]

    @property
    def mass_loss_terms(self) -> list[Term]:
        return [t for t in self.terms if burns(t.force)]

    @property
    def potentials(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("potential")]

    def __hash__(self):
        return hash(self.signature)

    def __eq__(self, other):
        return isinstance(other, KernelTerms) and self.signature == other.signature
