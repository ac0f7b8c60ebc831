"""The entries that ledger kernels write: a row of numbers for each force, interaction and collider, in float64.

Beside them each particle's share of the entries that somebody asked for.
"""

from gen_art.backend.kernel_views import traced
from gen_art.backend.runtime import ti

__all__ = ["DISSIPATED", "LEDGER_COLUMNS", "WORK", "LedgerArrays", "add_entry", "ledger_arrays"]

WORK, DISSIPATED, _IMPULSE, LEDGER_COLUMNS = 0, 1, 2, 5  # J, J, (3,) N s


class LedgerArrays:
    """The arrays of a ledger kernel, while it is traced.

    B : (blocks, rows x LEDGER_COLUMNS) f64, the entries of each block
    W : (entries, capacity) f64, the booked joules of each particle; not read where no row has shares
    shares : for each row, what is booked of it: (entry in W, WORK or DISSIPATED, 1 or -1), ...; () where nothing is
    """

    _data_oriented = True

    def __init__(self, B, W, shares: tuple):
        self.B, self.W, self.shares = B, W, shares


@traced
def ledger_arrays(B, W, shares: tuple) -> LedgerArrays:
    return LedgerArrays(B, W, shares)


@traced
def _shares_of(E: LedgerArrays) -> list[tuple]:
    return [(row, *share) for row, shares in enumerate(E.shares) for share in shares]


@ti.func
def add_entry(E: ti.template(), b, slot, row, work, dissipated, impulse):
    """Add to a row of block b, and to the shares of the particle in a slot; no other lane writes to either."""
    at = row * LEDGER_COLUMNS
    E.B[b, at + WORK] = E.B[b, at + WORK] + ti.cast(work, ti.f64)
    E.B[b, at + DISSIPATED] = E.B[b, at + DISSIPATED] + ti.cast(dissipated, ti.f64)
    for c in ti.static(range(3)):
        E.B[b, at + _IMPULSE + c] = E.B[b, at + _IMPULSE + c] + ti.cast(impulse[c], ti.f64)
    for shared, entry, part, sign in ti.static(_shares_of(E)):
        if row == shared:
            if ti.static(part == WORK):
                E.W[entry, slot] = E.W[entry, slot] + ti.cast(work, ti.f64) * sign
            if ti.static(part == DISSIPATED):
                E.W[entry, slot] = E.W[entry, slot] + ti.cast(dissipated, ti.f64) * sign
