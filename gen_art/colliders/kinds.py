"""Colliders of one kind as one loop: what differs between them are numbers, which kernels read at run time.

A kernel that wrote out every collider would grow with their number, and so would the time until it starts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from gen_art.backend.kernel_views import parameters, traced
from gen_art.colliders.base import Collider

__all__ = ["ColliderKind", "collider_kinds", "numbers_of"]


@dataclass(frozen=True)
class ColliderKind:
    """Colliders of one class and with the same choices that follow each other.

    collider : one of them, whose methods are traced
    count : their number
    first : index of the first collider
    first_surface : number of its first surface
    offset, stride : where its numbers are in Q, and how far from there to the next one's
    """

    collider: Collider
    count: int
    first: int
    first_surface: int
    offset: int
    stride: int


def collider_kinds(terms: Sequence[Any]) -> tuple[ColliderKind, ...]:
    """The kinds of the colliders of a composition, given their Terms in order."""
    kinds: list[ColliderKind] = []
    first = surface = 0
    for _, group in groupby(terms, key=lambda term: term.force.fixed):
        members = list(group)
        collider, offset = members[0].force, members[0].offset
        stride = members[1].offset - offset if len(members) > 1 else 0
        assert all(term.offset == offset + k * stride for k, term in enumerate(members))
        kinds.append(ColliderKind(collider, len(members), first, surface, offset, stride))
        first += len(members)
        surface += len(members) * collider.sides
    return tuple(kinds)


@traced
def numbers_of(Q, kind: ColliderKind, j):
    """The view `q` of collider j of a kind: its run-time numbers and its fixed choices."""
    return parameters(Q, kind.collider, kind.offset + j * kind.stride)
