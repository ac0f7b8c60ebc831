"""What looks at a simulation between its steps: a record, or a film that a script makes."""

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from gen_art.simulation.simulation import Simulation

__all__ = ["Observer"]


class Observer(Protocol):
    """Called after each launch of steps; it never changes the simulation."""

    def steps_left(self, done: int) -> int:
        """The number of steps, at least 1, from step `done` to the next at which it wants to look."""

    def look(self, sim: "Simulation") -> None:
        """Look at the present state; called more often than at the wanted steps."""
