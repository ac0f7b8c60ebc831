"""Sprites: a point, a soft disc, a streak, a sphere or an image, each a row of float32, and the profiles that spread its light.

The weights of a sprite are divided by their sum over its whole footprint. So every sprite gives exactly its energy,
wherever its centre lies between pixels; only the frame's border cuts light off.

Kernel of a disc, per axis: g(t) = (1 - 0.3125 t^2)^8 (1 - t^2)^2, t = distance / footprint, where the footprint (the distance
at which the kernel becomes 0) is 3.3 standard deviations: a Gaussian that ends smoothly.
A streak is a disc swept along a segment. Along its longer axis its profile is the integral of the kernel between the two ends;
across that axis it is the kernel about the segment, with the covariance of the swept disc.
A piece is a part of a curved streak: the same, but cut off at right angles, so that neighbours add up where they join.
A sphere is an even disc of radius `footprint` whose rim falls to 0 over +-`edge`. What a lens makes of a point out of focus is
drawn in the same way.

Large discs are smooth, so they are drawn into framebuffers of a half, a quarter or an eighth of the size (`LEVEL`). Those are
composited over the full-size one with bilinear weights; the discs' footprint is shortened by what these weights add.

The one-letter names in kernels are in docs/glossary.md.
"""

import numpy as np

from gen_art.backend.runtime import ti

__all__ = ["AREA", "profile", "profile_integral", "rim_profile", "smooth_step", "streak_profile"]

# kinds of sprites
# COVERED_DISC: a disc of which surfaces hide a part
POINT, DISC, STREAK, SPHERE, PICTURE, PIECE, ELLIPSE, COVERED_DISC = range(8)
KINDS = {
    "pixel": POINT,
    "point": POINT,
    "disc": DISC,
    "streak": STREAK,
    "sphere": SPHERE,
    "body": SPHERE,  # for shading alone: these three are drawn as surfaces
    "thread": SPHERE,
    "cloth": SPHERE,
    "surface": SPHERE,
    "picture": PICTURE,
}  # keys: the look's `draw`
# Channels of a projected particle: position (pixels), footprint (pixels), EDGE, movement (pixels), light times area,
# coverage times area, depth. EDGE is the half width of an even disc's rim; for other sprites, minus a random number in 0..1.
X, Y, FOOTPRINT, EDGE, DX, DY, RED, GREEN, BLUE, ALPHA, DEPTH = range(11)
CHANNELS = 11
# A sprite is a row of the same numbers (its depth is kept elsewhere) and of six more. 64 bytes are one cache line.
# THICKNESS is a sprite's extent along the line of sight if surfaces hide a part of it, otherwise 0.
SLOPE, ACROSS, NORM, TAIL, TAPER, THICKNESS = range(10, 16)
SPRITE_FLOATS = 16
# image sprites use some of these for other values
AGE, RANDOM = DX, DY  # channels: seconds, and a number in 0..1
COSINE, SINE, FIRST_TEXEL, LEVEL_SIDE = DX, DY, SLOPE, ACROSS  # numbers of the row: rotation and mipmap level
# integers of a sprite: the pixels it covers (clipped to the frame; BOTTOM < TOP: none), its framebuffer, its kind
LEFT, RIGHT, TOP, BOTTOM, LEVEL, KIND = range(6)
SPRITE_INTS = 6
HIDDEN, OUTSIDE = -1.0, -1e9  # footprint of a hidden particle, and the x of what is off the picture
FOOTPRINT_PER_RADIUS = 1.5  # a disc's footprint divided by its radius
MIN_FOOTPRINT = 1.5  # pixels of footprint: a standard deviation of 0.45; a narrower kernel would alias
MIN_RIM = 0.75  # pixels: smallest half width of an even disc's rim
LEVEL_FOOTPRINT = 8.0  # pixels of footprint from which a disc is drawn at half the size; from twice that, a quarter
KERNEL_VARIANCE = 0.0903  # of the kernel of footprint 1
COARSE_VARIANCE = 3.0 / 16.0  # that the weights 3/4 and 1/4 add when a framebuffer is composited, in its pixels squared
MIN_STREAK_FOOTPRINT = 1.15  # MIN_FOOTPRINT for a streak, whose weights are integrals over pixels


def profile_integral() -> float:
    """The integral of g over -1..1."""
    integral = (np.poly1d([-0.3125, 0.0, 1.0]) ** 8 * np.poly1d([-1.0, 0.0, 1.0]) ** 2).integ()
    return float(integral(1.0) - integral(-1.0))


LENGTH = profile_integral()
AREA = LENGTH * LENGTH  # area under a disc of footprint 1 and height 1


@ti.func
def profile(t):
    """g(t), 0 outside -1..1."""
    s = ti.min(t * t, 1.0)
    a = 1.0 - 0.3125 * s
    a2 = a * a
    a4 = a2 * a2
    b = 1.0 - s
    return a4 * a4 * (b * b)


@ti.func
def smooth_step(t):
    """A smooth step from 0 at t = -1 to 1 at t = 1. Its slope is proportional to (1 - t^2)^4, close to the kernel."""
    u = ti.min(ti.max(t, -1.0), 1.0)
    s = u * u
    return 0.5 + u * (1.23046875 + s * (-1.640625 + s * (1.4765625 + s * (-0.703125 + s * 0.13671875))))


@ti.func
def streak_profile(a, span, footprint, tail):
    """A streak's brightness at distance `a` from its old end along the longer axis; span > 0 is its length there."""
    value = 0.0
    if span < footprint * 0.3333333:
        value = profile((a - 0.5 * span) / ti.sqrt(footprint * footprint + span * span / (12.0 * KERNEL_VARIANCE)))
    else:
        inverse = 1.0 / footprint
        value = ti.max(smooth_step(a * inverse) - smooth_step((a - span) * inverse), 0.0)
    return value * (tail + (1.0 - tail) * ti.min(ti.max(a / span, 0.0), 1.0))


@ti.func
def piece_weight(along, n, centre, half_width, below, slope, span, footprint, tail):
    """A piece's weight in a pixel: across it as a streak's, along it by the place of the pixel's foot on the segment.

    along : distance along the longer axis of the pixel's middle from the old end, positive towards the head
    n, centre : first coordinate of the pixel and that of the middle line, across
    below : the smooth step at n, which is returned for the next pixel with the weight
    """
    above = smooth_step((n + 1.0 - centre) / half_width)
    stretch = ti.sqrt(1.0 + slope * slope)
    foot = along * stretch + (n + 0.5 - centre) * slope / stretch
    return (above - below) * streak_profile(foot, span * stretch, footprint, tail), above


@ti.func
def piece_half_width(across, taper, head):
    """Half the width across at a part of the length: 0 at the old end, 1 at the head."""
    return ti.max(across * (taper + (1.0 - taper) * ti.min(ti.max(head, 0.0), 1.0)), MIN_STREAK_FOOTPRINT)


@ti.func
def rim_profile(distance, footprint, edge):
    """An even disc's weight at a distance from its centre: 1 inside, falling to 0 over footprint +- edge."""
    return 1.0 - smooth_step((distance - footprint) / edge)
