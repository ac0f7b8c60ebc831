"""The entries that ledger kernels write: a row of numbers for each force, interaction and collider, in float64."""

from gen_art.backend.runtime import ti

__all__ = ["LEDGER_COLUMNS", "add_entry"]

_WORK, _DISSIPATED, _IMPULSE, LEDGER_COLUMNS = 0, 1, 2, 5  # J, J, (3,) N s


@ti.func
def add_entry(B: ti.template(), b, row, work, dissipated, impulse):
    """Add to a row of block b."""
    at = row * LEDGER_COLUMNS
    B[b, at + _WORK] = B[b, at + _WORK] + ti.cast(work, ti.f64)
    B[b, at + _DISSIPATED] = B[b, at + _DISSIPATED] + ti.cast(dissipated, ti.f64)
    for c in ti.static(range(3)):
        B[b, at + _IMPULSE + c] = B[b, at + _IMPULSE + c] + ti.cast(impulse[c], ti.f64)
