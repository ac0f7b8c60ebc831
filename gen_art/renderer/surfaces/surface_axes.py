"""Where a place of a surface lies on a picture that is laid on the surface, and how far a pixel reaches there.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.scene_numbers import RIGHT, UP, vector_at

__all__ = ["on_axes", "pixel_steps"]


@ti.func
def on_axes(n, v):
    """(2,) the components of v to the right and down, as someone sees them who looks at a surface with the normal n.

    They lie along the two axes along which the surface extends most; of a level one, right is x and down is z.
    """
    result = ti.Vector([v[0], v[2]])
    if abs(n[0]) > abs(n[1]) and abs(n[0]) >= abs(n[2]):
        result = ti.Vector([ti.select(n[0] > 0.0, -v[2], v[2]), -v[1]])
    elif abs(n[2]) > abs(n[1]) and abs(n[2]) > abs(n[0]):
        result = ti.Vector([ti.select(n[2] > 0.0, v[0], -v[0]), -v[1]])
    return result


@ti.func
def pixel_steps(N: ti.template(), n, d, pixel):
    """((3,), (3,)) from one pixel to the next on a surface with the normal n: to the right, and up.

    Across the view, then along the ray's direction d back to the plane that touches the surface.
    pixel : side of a pixel there, in world units
    """
    slope = d.dot(n)
    slope = ti.select(abs(slope) < 1e-4, -1e-4, slope)
    side, up = vector_at(N, RIGHT) * pixel, vector_at(N, UP) * pixel
    return side - d * (side.dot(n) / slope), up - d * (up.dot(n) / slope)
