"""Sets of colliders as the bits of an i64. Colliders beyond the first MOST_BITS are in every set.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti

__all__ = ["ALL_COLLIDERS", "MOST_BITS", "every_caster", "holds", "with_collider"]

ALL_COLLIDERS = -1
MOST_BITS = 63


@ti.func
def every_caster():
    """(3,) as of tile_casters where nothing is known: all colliders may hide the lamp and the sky, and no solids are listed."""
    return ti.Vector([ti.i64(ALL_COLLIDERS), ti.i64(ALL_COLLIDERS), ti.i64(-1)])


@ti.func
def holds(colliders, k: ti.template()):
    """Whether a set holds collider k, a number that is known when the kernel is compiled."""
    result = True
    if ti.static(k < MOST_BITS):
        result = (colliders >> ti.cast(ti.static(k), ti.i64)) & ti.i64(1) == ti.i64(1)
    return result


@ti.func
def with_collider(colliders, k: ti.template()):
    """A set with collider k."""
    result = colliders
    if ti.static(k < MOST_BITS):
        result |= ti.i64(1) << ti.cast(ti.static(k), ti.i64)
    return result
