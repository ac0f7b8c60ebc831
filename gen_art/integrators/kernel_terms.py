"""The forces, media and colliders of one system, laid out for the kernels: the terms, and the offsets of their numbers.

Two compositions of the same classes and fixed choices are equal, whatever their numbers, because kernels are cached by them.
"""

from typing import Any

import numpy as np

from gen_art.colliders.base import Collider
from gen_art.errors import UsageError
from gen_art.forces.base import Force, has_acceleration, loses_mass
from gen_art.forces.medium import Medium
from gen_art.particles.periodic_box import BOX_NUMBERS, PeriodicBox

__all__ = ["KernelTerms", "Term", "collider_names"]

_MAX_SURFACES = 31  # bits of the mask of surfaces that a particle rests on


def collider_names(colliders) -> dict[int, str]:
    """The name of each collider in the ledger, by id(): plane, plane_2, box ... Raises UsageError for what is no collider."""
    names: dict[int, str] = {}
    counts: dict[str, int] = {}
    for one in colliders:
        if not isinstance(one, Collider):
            raise UsageError(f"colliders must be such as ga.colliders.Plane(...), not {one!r}")
        if id(one) not in names:
            counts[one.name] = counts.get(one.name, 0) + 1
            names[id(one)] = one.name if counts[one.name] == 1 else f"{one.name}_{counts[one.name]}"
    return names


class Term:
    """One force or collider in a composition.

    force : the object whose methods are traced
    offset : of its numbers in the parameter array
    name : its label in the ledger
    medium : index of the medium it depends on, or -1
    ledger_row : its row in the ledger, or -1
    count_offset : where the number of its repeats is stored in the parameter array, or -1 if it is evaluated once
    """

    def __init__(self, force: Any, offset: int, name: str, medium: int = -1, ledger_row: int = -1):
        self.force, self.offset, self.name, self.medium, self.ledger_row = force, offset, name, medium, ledger_row
        self.count_offset = -1
        if force.repeat is not None:
            self.count_offset = offset + next(o for k, o, _ in force.layout() if k == force.repeat)


class KernelTerms:
    """Forces, media and colliders with their offsets in one run-time parameter array.

    labels : by id(), the names of the colliders where they are some of a system's; see collider_names
    box : the periodic box that the particles are in; its numbers are at box_offset
    """

    def __init__(
        self,
        forces=(),
        medium: Medium | None = None,
        colliders=(),
        labels: dict[int, str] | None = None,
        box: PeriodicBox | None = None,
    ):
        self._made_of = (forces, medium, colliders, labels)
        default = medium or Medium()
        self._numbers: list[float] = []
        self._tables: list[tuple[int, Any]] = []  # (offset, force)
        self.media: list[tuple[Term, ...]] = []
        self.terms: list[Term] = []
        known: list[Medium] = []
        names: dict[str, int] = {}
        for force in forces:
            if not isinstance(force, Force):
                raise UsageError(f"forces must be gen_art forces such as ga.forces.Gravity(...), not {force!r}")
            index = -1
            if force.provides("damping") or force.reads_medium:
                used = force.values.get("medium") or default
                if used not in known:
                    known.append(used)
                    self.media.append(tuple(self._place(term, used, term.name) for term in used.terms))
                index = known.index(used)
            base = force.name or type(force).__name__.lower()
            names[base] = names.get(base, 0) + 1
            name = base if names[base] == 1 else f"{base}_{names[base]}"
            used = force.values.get("medium") or default
            self.terms.append(self._place(force, used, name, index, len(self.terms)))
        labels = labels or collider_names(colliders)
        self.colliders = [self._place(one, default, labels[id(one)]) for one in colliders]
        if sum(t.force.sides for t in self.colliders) > _MAX_SURFACES:
            raise UsageError(
                f"a system can have {_MAX_SURFACES} surfaces to collide with (a box counts six): describe more as one sdf"
            )
        self.box, self.box_offset = box, len(self._numbers)
        if box is not None:
            self._numbers += [0.0] * BOX_NUMBERS
        self.fixed = (  # what kernels are compiled for
            tuple((t.force.fixed, t.medium) for t in self.terms),
            tuple(tuple(t.force.fixed for t in medium) for medium in self.media),
            tuple(t.force.fixed for t in self.colliders),
            box is not None,
        )

    def in_box(self, box: PeriodicBox) -> "KernelTerms":
        """The same terms in a periodic box."""
        return KernelTerms(*self._made_of, box)

    def _place(self, force: Any, medium: Medium, name: str, index: int = -1, row: int = -1) -> Term:
        """Append the numbers of a force or collider to the parameter array."""
        term = Term(force, len(self._numbers), name, index, row)
        self._numbers += force.bound_numbers(medium)
        if force.tabled:
            self._tables.append((len(self._numbers), force))
            self._numbers += [0.0, 0.0]  # the table's start; tables come last, so that no kernel depends on their sizes
        return term

    def numbers(self, dtype) -> np.ndarray:
        """The parameter array: all numbers in the order of the terms' offsets, then the tables."""
        head, start = list(self._numbers or [0.0]), len(self._numbers)
        tables = [force.table() for _, force in self._tables]
        for (offset, _), table in zip(self._tables, tables):
            head[offset : offset + 2] = divmod(start, 4096)  # in two parts, because float32 is exact only up to 2^24
            start += len(table)
        numbers = np.array(head, dtype)
        if self.box is not None:
            numbers[self.box_offset : self.box_offset + BOX_NUMBERS] = self.box.numbers(dtype)
        return np.concatenate([numbers, *(table.astype(dtype) for table in tables)])

    def place_tables(self, numbers: np.ndarray) -> None:
        """Write the tables of the forces once more into a parameter array; their lengths must be as before."""
        for offset, force in self._tables:
            high, low = numbers[offset : offset + 2].tolist()
            start, table = int(high) * 4096 + int(low), force.table()
            numbers[start : start + len(table)] = table

    @property
    def accelerations(self) -> list[Term]:
        return [t for t in self.terms if has_acceleration(t.force)]

    @property
    def magnetics(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("magnetic")]

    @property
    def dampings(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("damping")]

    @property
    def noises(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("noise")]

    @property
    def mass_loss_terms(self) -> list[Term]:
        return [t for t in self.terms if loses_mass(t.force)]

    @property
    def potentials(self) -> list[Term]:
        return [t for t in self.terms if t.force.provides("potential")]

    def __hash__(self):
        return hash(self.fixed)

    def __eq__(self, other):
        return isinstance(other, KernelTerms) and self.fixed == other.fixed
