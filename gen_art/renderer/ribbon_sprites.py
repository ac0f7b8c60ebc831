"""The sprites of a ribbon's segment: streaks where it is straight, pieces of streaks where it bends."""

import numpy as np

from gen_art.renderer.curved_streaks import cut
from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.lensing.lensed_view import LensedView
from gen_art.renderer.look_tables import LookTables
from gen_art.renderer.projected_particles import ProjectedParticles
from gen_art.renderer.ribbons import Segment, cut_by_plane
from gen_art.renderer.shading import shade
from gen_art.renderer.sprite import HIDDEN, PIECE, STREAK
from gen_art.renderer.sprite_buffer import Sprites, streak_ends

__all__ = ["add_segment"]


def add_segment(
    sprites: Sprites, segment: Segment, projected: ProjectedParticles, tables: LookTables, q: np.ndarray,
    framebuffer: FrameBuffer, mirror: tuple | None, bent: LensedView,
) -> None:  # fmt: skip
    """Add a segment's sprites, in bent space those of both images.

    projected : room for the segment's particles; overwritten
    q : the numbers of look_tables.kernel_numbers for this segment
    mirror : (point, normal) of the plane behind which the view lies, or None
    """
    pieces = None
    if len(bent.orders) == 1:
        pieces = cut(segment.system, segment.past, q, segment.tail, segment.taper, segment.motion, along=True)
    if mirror is not None:
        cut_by_plane(segment, *mirror)
    for order in bent.orders:
        seen = bent.images(segment.system, tables.look, order, segment.time, segment.duration)
        shade(projected, segment.system, tables, q, seen=seen)
        if pieces is not None:
            projected.hide(pieces.replaced)
        sprites.add(projected, STREAK, framebuffer, streak_ends(segment.tail, segment.taper), HIDDEN)
    if pieces is not None:
        shade(projected, pieces.system, tables, pieces.numbers, pieces=pieces.rows)
        if mirror is not None:
            projected.hide_behind(pieces.system, *mirror)
        sprites.add(projected, PIECE, framebuffer, pieces.ends, HIDDEN)
