"""Images on what moves: on bodies along their own axes, on cloth along its threads.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.solids import CENTER, IMAGE_PLACE, along_axes, row_vector
from gen_art.renderer.surfaces.surface_axes import on_axes, pixel_steps
from gen_art.renderer.surfaces.surface_maps import PER_HEIGHT, PER_WIDTH, map_at

__all__ = ["has_image", "image_on_solid", "image_over"]


@ti.func
def has_image(M: ti.template(), m, column):
    """Whether a material has an image; `column` of its numbers in M."""
    return M[m, column + PER_WIDTH] > 0.0


@ti.func
def image_over(scene: ti.template(), m, column, albedo, at, right, down):
    """The albedo (3,) under a material's image: the image's colours, and the albedo where it is transparent.

    at : (2,) m, to the right and down on the image; right, down : (2,) from one pixel to the next
    """
    image = map_at(scene.images, scene.M, m, column, at, right, down)
    return albedo * (1.0 - image[3]) + ti.Vector([image[0], image[1], image[2]])


@ti.func
def image_on_solid(scene: ti.template(), i, m, image, ends, albedo, x, n, d, pixel):
    """The albedo (3,) of solid i at x (relative to the camera), where its unit normal is n, under its material's image.

    The image's middle lies at the middle of each side, moved by the solid's IMAGE_PLACE.
    image, ends : columns of the image's numbers in M, and of those of the image across the solid's first axis, if it has one
    """
    B, M = ti.static(scene.B, scene.M)
    east, south = pixel_steps(scene.N, n, d, pixel)
    facing, column = along_axes(B, i, n), image
    if has_image(M, m, ends) and abs(facing[0]) > ti.max(abs(facing[1]), abs(facing[2])):
        column = ends
    at = on_axes(facing, along_axes(B, i, x - row_vector(B, i, CENTER)))
    at[0] += B[i, IMAGE_PLACE] / M[m, column + PER_WIDTH]
    at[1] += B[i, IMAGE_PLACE + 1] / M[m, column + PER_HEIGHT]
    right, down = on_axes(facing, along_axes(B, i, east)), on_axes(facing, along_axes(B, i, south))
    return image_over(scene, m, column, albedo, at, right, down)
