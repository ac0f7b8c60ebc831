"""Entries of the ledger of which each particle keeps its own share, in joules."""

from dataclasses import dataclass

from gen_art.arguments import shown
from gen_art.errors import UsageError
from gen_art.registry import suggest

__all__ = ["DISSIPATED", "KINDS", "LedgerEntry"]

KINDS = ("work", "dissipated")
LONGEST_NAME = 100


@dataclass(frozen=True)
class LedgerEntry:
    """An entry of one system's ledger.

    kind : "work" or "dissipated"
    name : as the ledger names the force, without the system's name; "" for all that is dissipated
    """

    kind: str
    name: str = ""

    @classmethod
    def of(cls, value) -> "LedgerEntry":
        """The entry that YAML writes `{work: drag}`, `{dissipated: drag}` or `dissipated`. Raises UsageError for another."""
        if isinstance(value, LedgerEntry):
            return value
        if value == "dissipated":
            return DISSIPATED
        if not isinstance(value, dict) or len(value) != 1:
            raise UsageError(
                f"an entry of the ledger is {{work: FORCE}}, {{dissipated: FORCE}} or dissipated, not {shown(value)}"
            )
        ((kind, name),) = value.items()
        if kind not in KINDS:
            raise UsageError(
                f"an entry of the ledger is of {' or '.join(KINDS)}, not {shown(kind)}{suggest(kind, KINDS)}"
            )
        if not isinstance(name, str) or not name.isprintable() or not 0 < len(name) <= LONGEST_NAME:
            raise UsageError(f"{kind} needs the name of a force, not {shown(name)}")
        return cls(kind, name)

    @property
    def plain(self) -> "str | dict[str, str]":
        """The entry as YAML writes it."""
        return {self.kind: self.name} if self.name else self.kind

    @property
    def title(self) -> str:
        """The entry in words: work of drag, dissipated by drag, dissipated."""
        if not self.name:
            return self.kind
        return f"{self.kind} {'of' if self.kind == 'work' else 'by'} {self.name}"

    def __str__(self) -> str:
        return f"{{{self.kind}: {self.name}}}" if self.name else self.kind


DISSIPATED = LedgerEntry("dissipated")
