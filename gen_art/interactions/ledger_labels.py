"""What the ledger of one system has rows of: forces, parts of interactions, colliders; and who may keep a share of them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from gen_art.colliders.base import Collider
from gen_art.errors import UsageError
from gen_art.forces.base import Force
from gen_art.forces.medium import Medium
from gen_art.integrators.kernel_terms import KernelTerms, collider_names
from gen_art.integrators.ledger_rows import DISSIPATED, WORK
from gen_art.interactions.base import Interaction
from gen_art.particles.entries import KINDS, LedgerEntry
from gen_art.registry import suggest

__all__ = ["LedgerRow", "check_entry", "composition_of", "ledger_rows", "shares_of"]


@dataclass(frozen=True)
class LedgerRow:
    """One row that the ledger kernel writes.

    label : the name of its force, without the system's name
    does_work : whether its work and what it dissipates are entries; those of a conservative force are not
    dissipates : whether minus its work is an entry of what is dissipated
    """

    label: str
    does_work: bool
    dissipates: bool = False

    def parts(self, kind: str) -> tuple[tuple[int, int], ...]:
        """The parts of the row, (WORK or DISSIPATED, sign), that make up its entry of this kind; () if it has none."""
        if self.dissipates:
            return ((WORK, -1),) if kind == "dissipated" else ()
        if not self.does_work:
            return ()
        return ((WORK if kind == "work" else DISSIPATED, 1),)


def composition_of(
    forces: Sequence[Force], medium: Medium, colliders: Sequence[Collider], interactions: Iterable[Interaction]
) -> KernelTerms:
    """The KernelTerms of a system. Its interactions take over the colliders that they handle themselves."""
    left, names = list(colliders), collider_names(colliders)
    for interaction in interactions:
        left = interaction.take_colliders(left, names)
    return KernelTerms(forces, medium, left, names)


def ledger_rows(composition: KernelTerms, interactions: Iterable[Interaction]) -> list[LedgerRow]:
    """The rows of a system's ledger in the order of the kernel: forces, parts of interactions, colliders."""
    rows = [LedgerRow(term.name, not term.force.conservative) for term in composition.terms]
    rows += [
        LedgerRow(
            part.label or interaction.name,
            not interaction.conservative or interaction.source_system is not None,
            part.dissipates,
        )
        for interaction in interactions
        for part in interaction.parts
    ]
    return rows + [LedgerRow(term.name, True) for term in composition.colliders]


def shares_of(rows: Sequence[LedgerRow], entries: Sequence[LedgerEntry]) -> tuple:
    """What is booked of each row for each particle: see gen_art.integrators.ledger_rows.LedgerArrays. () for no entries."""
    if not entries:
        return ()
    return tuple(
        tuple(
            (k, part, sign)
            for k, entry in enumerate(entries)
            if entry.name in ("", row.label)
            for part, sign in row.parts(entry.kind)
        )
        for row in rows
    )


def check_entry(entry: LedgerEntry, rows: Sequence[LedgerRow], interactions: Iterable[Interaction]) -> None:
    """Raise UsageError for an entry that the ledger does not have, or of which no particle has a share of its own."""
    whole = [one.name for one in interactions if one.implicit or one.breaks]
    if whole and entry.name in ("", *whole):
        named = "name another force: {dissipated: FORCE}" if not entry.name else "look at another force"
        raise UsageError(
            f"{entry} cannot be told particle by particle: the ledger books {whole[0]} for bodies and bonds as a whole; {named}"
        )
    known = list(dict.fromkeys(row.label for row in rows if row.parts(entry.kind)))
    if entry.name in known or (not entry.name and known):
        return
    if not known:
        raise UsageError(
            f"the ledger has no entry {entry}: no force on this system {_VERBS[entry.kind]} energy that it books"
        )
    hint = suggest(entry.name, known) or "; there are " + ", ".join(known)
    if any(row.label == entry.name for row in rows):
        other = LedgerEntry(next(kind for kind in KINDS if kind != entry.kind), entry.name)
        hint = ": the work of a conservative force is the change of potential energy; there are " + ", ".join(known)
        if any(row.label == entry.name and row.parts(other.kind) for row in rows):
            hint = f"; there is {other}"
    raise UsageError(f"the ledger has no entry {entry}{hint}")


_VERBS = {"work": "adds", "dissipated": "takes"}
