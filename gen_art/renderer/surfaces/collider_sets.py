"""Sets of colliders as the bits of an i64: a scene has at most 31 surfaces.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti

__all__ = ["ALL_COLLIDERS", "every_caster", "holds", "with_collider"]

ALL_COLLIDERS = -1


@ti.func
def every_caster():
    """(3,) as of tile_casters where nothing is known: all colliders may hide the lamp and the sky, and no solids are listed."""
    return ti.Vector([ti.i64(ALL_COLLIDERS), ti.i64(ALL_COLLIDERS), ti.i64(-1)])


@ti.func
def holds(colliders, k):
    """Whether a set holds collider k."""
    return (colliders >> ti.cast(k, ti.i64)) & ti.i64(1) == ti.i64(1)


@ti.func
def with_collider(colliders, k):
    """A set with collider k."""
    return colliders | ti.i64(1) << ti.cast(k, ti.i64)
