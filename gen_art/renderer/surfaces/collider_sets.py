"""Sets of colliders as the bits of an i64. Colliders beyond the first MOST_BITS are in every set.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti

__all__ = ["ALL_COLLIDERS", "every_collider", "holds", "with_collider"]

ALL_COLLIDERS = -1
_MOST_BITS = 63


@ti.func
def every_collider():
    """(2,) the sets of all colliders: those that may hide the lamp, and those that may hide the sky."""
    return ti.Vector([ti.i64(ALL_COLLIDERS), ti.i64(ALL_COLLIDERS)])


@ti.func
def holds(colliders, k: ti.template()):
    """Whether a set holds collider k, a number that is known when the kernel is compiled."""
    result = True
    if ti.static(k < _MOST_BITS):
        result = (colliders >> ti.cast(ti.static(k), ti.i64)) & ti.i64(1) == ti.i64(1)
    return result


@ti.func
def with_collider(colliders, k: ti.template()):
    """A set with collider k."""
    result = colliders
    if ti.static(k < _MOST_BITS):
        result |= ti.i64(1) << ti.cast(ti.static(k), ti.i64)
    return result
