"""Whole vectors of sixteen floats, for kernels with `vectors=True`."""

from gen_art.backend.runtime import ti

__all__ = ["LANES", "all_lanes", "lane_numbers"]

LANES = 16


@ti.func
def all_lanes(x):
    """A vector with the same number in each lane."""
    return ti.Vector([ti.cast(x, ti.f32) for _ in ti.static(range(LANES))])


@ti.func
def lane_numbers():
    """0, 1, 2 ..., the number of each lane."""
    return ti.Vector([float(k) for k in ti.static(range(LANES))])
