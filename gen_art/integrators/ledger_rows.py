"""What a booking kernel writes for the ledger: a row of numbers for each law, in float64."""

from gen_art.backend.runtime import ti

__all__ = ["LEDGER_COLUMNS", "add_entry"]

LEDGER_COLUMNS = 5  # work, dissipated, impulse x, y, z


@ti.func
def add_entry(B: ti.template(), b, row, work, dissipated, impulse):
    """Add to a row of the account of block b."""
    B[b, row * LEDGER_COLUMNS] = B[b, row * LEDGER_COLUMNS] + ti.cast(work, ti.f64)
    B[b, row * LEDGER_COLUMNS + 1] = B[b, row * LEDGER_COLUMNS + 1] + ti.cast(dissipated, ti.f64)
    for c in ti.static(range(3)):
        B[b, row * LEDGER_COLUMNS + 2 + c] = B[b, row * LEDGER_COLUMNS + 2 + c] + ti.cast(impulse[c], ti.f64)
