"""The sprites of a ribbon's links: streaks where they are straight, pieces of streaks where they bend."""

from collections.abc import Callable

import numpy as np

from gen_art.renderer.framebuffer import FrameBuffer
from gen_art.renderer.lensing.lensed_view import LensedView
from gen_art.renderer.look_tables import TIME, LookTables
from gen_art.renderer.projected_particles import ProjectedParticles
from gen_art.renderer.ribbon_links import LIGHT, LINK_WIDTH, TAIL, TAPER, particles_of_link, pieces_of
from gen_art.renderer.ribbons import Links
from gen_art.renderer.shading import shade
from gen_art.renderer.sprite import HIDDEN, PIECE, STREAK
from gen_art.renderer.sprite_buffer import Sprites, streak_ends

__all__ = ["add_links"]

Numbers = Callable[[float, float, float], np.ndarray]


def add_links(
    sprites: Sprites, links: Links, projected: ProjectedParticles, tables: LookTables, numbers: Numbers,
    framebuffer: FrameBuffer, mirror: tuple | None, bent: LensedView,
) -> None:  # fmt: skip
    """Add the sprites of links, in bent space those of both images.

    projected : room for the particles; overwritten
    numbers : those of look_tables.kernel_numbers for (seconds of the streaks, factor of the light, factor of the width)
    mirror : (point, normal) of the plane behind which the view lies, or None
    """
    if len(bent.orders) > 1:
        _add_images(sprites, links, projected, tables, numbers, framebuffer, mirror, bent)
        return
    for kind, pieces in zip((STREAK, PIECE), pieces_of(links, numbers(0.0, 1.0, 1.0), mirror), strict=True):
        if pieces is not None:
            shade(projected, pieces.system, tables, pieces.numbers, pieces=pieces.rows)
            sprites.add(projected, kind, framebuffer, pieces.ends, HIDDEN)


def _add_images(
    sprites: Sprites, links: Links, projected: ProjectedParticles, tables: LookTables, numbers: Numbers,
    framebuffer: FrameBuffer, mirror: tuple | None, bent: LensedView,
) -> None:  # fmt: skip
    """Add straight streaks, link by link, for both images of each particle."""
    for k in range(len(links.drawn)):
        seconds, factors = float(links.times[k] - links.times[k + 1]), links.factors[:, k].tolist()
        mean = (
            0.25 * (1.0 + factors[TAIL]) * (1.0 + factors[TAPER])
        )  # of light and width, where those of the newer end are 1
        q = numbers(seconds, factors[LIGHT] * mean, factors[LINK_WIDTH])
        system = particles_of_link(links, k, q[TIME])
        for order in bent.orders:
            seen = bent.images(system, tables.look, order, q[TIME], seconds)
            shade(projected, system, tables, q, seen=seen)
            if mirror is not None:
                projected.hide_behind(system, *mirror)
            sprites.add(projected, STREAK, framebuffer, streak_ends(factors[TAIL], factors[TAPER]), HIDDEN)
