"""Draw the images of the pieces of the course that fly, fall and dive: aeroplanes, balloons, parachutes, clouds, fields.

    .venv/bin/python docs/make_flight_images.py [NAMES]

Solids are signed distances, marched from a distant camera and lit by a sun and a sky; clouds are a fractal density, lit
through itself; fields are a map that repeats.
"""

import sys
from pathlib import Path

import numpy as np
from make_lake_images import fractal, noise, rise
from PIL import Image

FOLDER = Path(__file__).resolve().parent.parent / "presets" / "course"
FINER = 2


def unit(v):
    v = np.asarray(v, np.float32)
    return v / np.linalg.norm(v)


def length(*v):
    return np.sqrt(sum(x * x for x in v))


def ball(p, centre, radii):
    q, r = p - np.float32(centre), np.float32(radii)
    k = np.linalg.norm(q / r, axis=1)
    return k * (k - 1) / np.maximum(np.linalg.norm(q / r**2, axis=1), 1e-6)


def rod(p, a, b, ra, rb=None):
    a, b = np.float32(a), np.float32(b)
    t = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[:, None] * (b - a), axis=1) - (ra + (0 if rb is None else (rb - ra)) * t)


def box(p, centre, half, r=0.0):
    q = np.abs(p - np.float32(centre)) - np.float32(half) + r
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0) - r


def smooth(x, xs, rs):
    """The values at x of a smooth curve through (xs, rs), which rises and falls only where they do (Fritsch and Butland)."""
    xs, rs = np.asarray(xs, float), np.asarray(rs, float)
    step = np.diff(xs)
    rise_here = np.diff(rs) / step
    a, b = rise_here[:-1], rise_here[1:]
    slope = np.where(a * b > 0, 2 * a * b / np.where(a + b == 0, 1, a + b), 0)
    slope = np.concatenate([rise_here[:1], slope, rise_here[-1:]])
    k = np.clip(np.searchsorted(xs, x) - 1, 0, len(step) - 1)
    t = np.clip((x - xs[k]) / step[k], 0, 1)
    ends = rs[k] * (1 + 2 * t) * (1 - t) ** 2 + rs[k + 1] * (3 - 2 * t) * t**2
    return ends + step[k] * (slope[k] * t * (1 - t) ** 2 - slope[k + 1] * t**2 * (1 - t))


def hull(p, xs, rs, y=0.0, squash=1.0):
    """A body round about the x axis, whose radii at xs are rs."""
    r = smooth(p[:, 0], xs, rs)
    beyond = np.maximum(np.maximum(xs[0] - p[:, 0], p[:, 0] - xs[-1]), 0)
    return (
        0.75
        * length(np.maximum(length((p[:, 1] - y) / squash, p[:, 2]) - r, -r), beyond)
        * np.where((length((p[:, 1] - y) / squash, p[:, 2]) < r) & (beyond == 0), -1, 1)
    )


def wing(p, root, chord, tip, tip_chord, thick, along=2):
    """A wing from the leading edge `root` to the leading edge `tip`, along z (2) or y (1); +x is ahead."""
    root, tip = np.float32(root), np.float32(tip)
    across = 3 - along
    s = np.clip((p[:, along] - root[along]) / (tip[along] - root[along]), 0, 1)
    lead = root[0] + s * (tip[0] - root[0])
    c = chord + s * (tip_chord - chord)
    mid = root[across] + s * (tip[across] - root[across])
    u = (lead - p[:, 0]) / c  # 0 at the leading edge, 1 at the trailing edge
    v = np.clip(u, 0.0, 1.0)
    half = thick * c * (np.sqrt(v) * 1.48 - 0.63 * v - 1.75 * v**2 + 1.4 * v**3 - 0.5 * v**4) * 1.0 + 0.006 * c
    a = np.abs(p[:, across] - mid) - half
    b = np.maximum(-u, u - 1) * c
    lo, hi = sorted((root[along], tip[along]))
    e = np.maximum(lo - p[:, along], p[:, along] - hi)
    q = np.stack([a, b, e], 1)
    return 0.7 * (np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0))


def view(yaw, pitch, roll=0.0):
    """The axes right, up and towards the camera: yaw about y, then pitch (from above if > 0)."""
    a, b, c = np.radians([yaw, pitch, roll])
    near = np.array([np.sin(a) * np.cos(b), np.sin(b), np.cos(a) * np.cos(b)])
    right = np.array([np.cos(a), 0, -np.sin(a)])
    up = np.cross(near, right)
    right, up = right * np.cos(c) + up * np.sin(c), up * np.cos(c) - right * np.sin(c)
    return np.float32([right, up, near])


def solid(
    name,
    parts,
    paint,
    reach,
    axes,
    sun,
    size=512,
    centre=(0, 0, 0),
    sky=(0.50, 0.62, 0.80),
    below=(0.20, 0.21, 0.16),
    warm=(1.9, 1.75, 1.5),
    quality=88,
):
    """A WebP of a solid: `parts(p)` gives a list of distances, `paint(p, which, normal)` its albedo and its gloss."""
    n = size * FINER
    grid = (np.arange(n, dtype=np.float32) + 0.5) / n * 2 - 1
    u, v = np.meshgrid(grid * reach, -grid * reach)
    right, up, near = axes
    start = np.float32(centre) + u.reshape(-1, 1) * right + v.reshape(-1, 1) * up + near * 1.8 * reach
    t, alive, hit = np.zeros(n * n, np.float32), np.arange(n * n), np.zeros(n * n, bool)
    fine = 0.5 * reach / n

    def distance(p):
        return np.min(np.stack(parts(p)), axis=0)

    for _ in range(160):
        d = 0.8 * distance(start[alive] - t[alive, None] * near)
        t[alive] += d
        near_enough = d < fine
        hit[alive[near_enough]] = True
        alive = alive[~near_enough & (t[alive] < 3.6 * reach)]
        if len(alive) == 0:
            break
    at = np.flatnonzero(hit)
    p = start[at] - t[at, None] * near
    which = np.argmin(np.stack(parts(p)), axis=0)
    e = 2 * fine
    normal = np.stack([distance(p + e * d) - distance(p - e * d) for d in np.eye(3, dtype=np.float32)], 1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    sun = unit(sun)
    shadow, s = np.ones(len(p)), np.full(len(p), 6 * fine)
    for _ in range(110):
        d = distance(p + normal * 3 * fine + s[:, None] * sun)
        shadow = np.minimum(shadow, np.clip(0.5 + 20 * d / s, 0, 1))
        s = s + np.clip(0.7 * d, 0.0025 * reach, 0.2 * reach)
    open_sky = 1.0
    for h in (0.02, 0.06, 0.15):
        open_sky = open_sky - 0.5 * np.clip(h - distance(p + normal * h * reach) / reach, 0, h) / h * 0.55
    albedo, gloss = paint(p, which, normal)
    facing = np.maximum(normal @ sun, 0) * shadow
    up_share = (0.5 + 0.5 * normal[:, 1])[:, None]
    hemisphere = np.float32(sky) * up_share + np.float32(below) * (1 - up_share)
    light = albedo * (np.float32(warm) * facing[:, None] + hemisphere * np.clip(open_sky, 0, 1)[:, None])
    mirror = 2 * (normal @ near)[:, None] * normal - near
    seen = np.clip(0.5 + 2.2 * mirror[:, 1:2], 0, 1)
    fresnel = (0.04 + 0.96 * (1 - np.clip(normal @ near, 0, 1)) ** 5)[:, None] * gloss[:, None]
    light = light * (1 - fresnel) + fresnel * (np.float32(sky) * 1.15 * seen + np.float32(below) * (1 - seen))
    glint = np.exp(-(1 - np.clip(mirror @ sun, -1, 1)) * 420) * shadow
    light = light + (glint * gloss * 1.6)[:, None]
    out = np.zeros((n * n, 4), np.float32)
    out[at, :3], out[at, 3] = light, 1
    out = out.reshape(size, FINER, size, FINER, 4).mean(axis=(1, 3))
    write(name, out[..., :3] / np.maximum(out[..., 3:], 1e-6), out[..., 3], quality)


def write(name, light, alpha, quality=88):
    """Linear light and coverage; the light 1.5 becomes white."""
    colour = np.clip(light / 1.5, 0, 1) ** (1 / 2.2)
    pixels = np.concatenate([colour, np.clip(alpha, 0, 1)[..., None]], axis=2)
    Image.fromarray((pixels * 255 + 0.5).astype(np.uint8)).save(
        FOLDER / name, quality=quality, method=6, alpha_quality=90
    )


def jet():
    """Five trainers with swept wings in a steep turn to the left, seen from behind and below, each as it stands in its place."""

    def parts(p):
        q = p.copy()
        q[:, 2] = np.abs(q[:, 2])
        body = hull(p, [-5.6, -5.2, -3, 0, 2.2, 4.2, 5.2, 5.9], [0.36, 0.42, 0.58, 0.68, 0.64, 0.45, 0.25, 0.02])
        hood = ball(p, (2.3, 0.50, 0), (1.75, 0.56, 0.40))
        intake = ball(q, (0.5, -0.02, 0.66), (2.3, 0.46, 0.36))
        main = wing(q, (1.5, -0.34, 0.5), 3.1, (-1.6, -0.40, 4.9), 1.15, 0.05)
        fin = wing(p, (-2.9, 0.4, 0), 2.3, (-4.7, 2.75, 0), 0.95, 0.05, along=1)
        tail = wing(q, (-3.9, 0.15, 0.3), 1.45, (-5.0, -0.15, 2.4), 0.7, 0.05)
        pipe = np.maximum(hull(p, [-6.0, -5.5], [0.36, 0.38]), 0.26 - np.hypot(p[:, 1], p[:, 2]))
        keel = wing(p, (-3.7, -0.35, 0), 1.3, (-4.6, -0.95, 0), 0.7, 0.05, along=1)
        pods = ball(q, (-0.9, -0.62, 2.3), (1.5, 0.17, 0.17))  # smoke oil and lights
        return [body, hood, intake, main, fin, tail, pipe, keel, pods]

    def paint(p, which, normal):
        red, white, blue, glass = (
            np.float32(c) for c in ((0.58, 0.02, 0.025), (0.84, 0.84, 0.82), (0.02, 0.06, 0.28), (0.02, 0.03, 0.045))
        )
        albedo = np.broadcast_to(red, p.shape).copy()
        s, below = np.abs(p[:, 2]), normal[:, 1] < 0
        ahead = 1.5 - 0.705 * (s - 0.5) - p[:, 0]  # behind the wing's leading edge
        body, plane = (which == 0) | (which == 2), which == 3
        albedo[body & (np.abs(p[:, 1] + 0.05 - 0.03 * p[:, 0]) < 0.09) & (p[:, 0] > -4.5)] = white
        albedo[body & below & (s < 0.10 + 0.045 * (5.9 - p[:, 0]).clip(0, 5)) & (p[:, 1] < -0.2)] = white
        albedo[plane & below & (ahead > 0.45) & (ahead < 1.0)] = white
        albedo[plane & (s > 3.75) & (s < 4.15)] = white
        albedo[plane & (s >= 4.15)] = blue
        albedo[(which == 5) & (s > 1.75)] = white
        albedo[(which == 4) & (p[:, 1] > 1.4) & (p[:, 1] < 2.0)] = white
        albedo[((which == 4) & (p[:, 1] >= 2.0)) | (which == 7)] = blue
        hinge = plane & (np.abs(3.1 - 0.443 * (s - 0.5) - ahead - 0.62) < 0.035) & (s < 4.6)
        joint = plane & (np.abs(s - 2.55) < 0.03) & (ahead > 1.9)
        wheel = body & below & (np.abs(np.abs(p[:, 0] - 0.1) - 0.9) < 0.03) & (s > 0.25)
        albedo[hinge | joint | wheel] *= 0.3
        albedo[which == 1] = glass
        albedo[(which == 1) & ((np.abs(p[:, 0] - 2.1) < 0.06) | (np.abs(p[:, 0] - 3.2) < 0.06))] = 0.3 * red
        albedo[(which == 6) | ((which == 0) & (p[:, 0] < -5.35))] = 0.04
        albedo[(which == 2) & (p[:, 0] > 2.35)] = 0.03
        albedo[(np.abs(p[:, 0] % 1.1 - 0.55) < 0.02) & (which == 0)] *= 0.6
        return albedo, np.where(which == 1, 1.0, 0.45)

    light = {"sky": (0.30, 0.42, 0.62), "below": (0.16, 0.20, 0.24), "warm": (2.5, 2.2, 1.75), "size": 320}
    for letter, axes, sun in JETS:
        solid(f"display_jet_{letter}.webp", parts, paint, 6.4, view(*axes), sun, **light)


# how the camera and the sun of course/display_team stand to each jet at the time of its still
JETS = (
    ("a", (-88, -49, -92), (-0.65, -0.18, 0.74)),
    ("b", (-78, -58, -86), (-0.60, -0.24, 0.76)),
    ("c", (-99, -57, -104), (-0.61, -0.27, 0.75)),
    ("d", (-62, -66, -75), (-0.54, -0.29, 0.79)),
    ("e", (-117, -64, -124), (-0.56, -0.35, 0.75)),
)


def sailplane():
    """A sailplane with an 18 m span, seen from its left, ahead and above."""

    def parts(p):
        q = p.copy()
        q[:, 2] = np.abs(q[:, 2])
        xs = [-4.6, -3.0, -1.0, 0.2, 1.0, 1.8, 2.3, 2.55]
        body = hull(p, xs, [0.10, 0.13, 0.20, 0.36, 0.40, 0.34, 0.20, 0.02])
        hood = ball(p, (1.3, 0.20, 0), (1.0, 0.30, 0.30))
        inner = wing(q, (0.55, 0.22, 0.1), 0.95, (0.45, 0.5, 6.0), 0.70, 0.075)
        outer = wing(q, (0.45, 0.5, 6.0), 0.70, (0.15, 0.95, 9.0), 0.32, 0.07)
        tip = wing(q, (0.15, 0.95, 9.0), 0.30, (-0.15, 1.4, 9.22), 0.14, 0.07)
        fin = wing(p, (-3.7, 0.05, 0), 1.0, (-4.15, 1.35, 0), 0.62, 0.06, along=1)
        tail = wing(q, (-4.1, 1.38, 0), 0.62, (-4.25, 1.42, 1.45), 0.36, 0.06)
        return [body, hood, inner, outer, tip, fin, tail]

    def paint(p, which, normal):
        albedo = np.full(p.shape, 0.86, np.float32)
        albedo[which == 1] = (0.03, 0.05, 0.08)
        albedo[(which == 5) & (p[:, 1] > 0.75)] = (0.75, 0.10, 0.05)
        albedo[which == 4] = (0.75, 0.10, 0.05)
        albedo[(which == 0) & (p[:, 0] > 2.15)] = (0.75, 0.10, 0.05)
        return albedo, np.where(which == 1, 1.0, 0.8)

    solid("sailplane.webp", parts, paint, 9.3, view(38, 17, -8), (-0.3, 0.8, 0.6), size=1024)


def tourer():
    """A light low-winged aeroplane with one propeller, seen from behind and above."""

    def parts(p):
        q = p.copy()
        q[:, 2] = np.abs(q[:, 2])
        body = hull(p, [-3.9, -3.0, -1.2, 0.3, 1.6, 2.5, 2.75], [0.10, 0.20, 0.42, 0.60, 0.56, 0.42, 0.2], squash=1.05)
        hood = ball(p, (0.15, 0.50, 0), (1.35, 0.52, 0.50))
        main = wing(q, (1.35, -0.42, 0.3), 1.6, (1.1, -0.02, 5.0), 1.15, 0.07)
        fin = wing(p, (-2.7, 0.2, 0), 1.35, (-3.6, 1.55, 0), 0.7, 0.05, along=1)
        tail = wing(q, (-3.0, 0.12, 0.1), 1.0, (-3.2, 0.12, 1.75), 0.7, 0.05)
        disc = ball(p, (2.9, 0, 0), (0.03, 0.95, 0.09))
        legs = rod(q, (0.9, -0.4, 1.2), (0.8, -1.05, 1.25), 0.07)
        spats = ball(q, (0.8, -1.1, 1.25), (0.42, 0.22, 0.13))
        return [body, hood, main, fin, tail, disc, legs, spats]

    def paint(p, which, normal):
        white, red, glass = (
            np.float32((0.84, 0.83, 0.80)),
            np.float32((0.66, 0.05, 0.03)),
            np.float32((0.03, 0.05, 0.07)),
        )
        albedo = np.broadcast_to(white, p.shape).copy()
        s = np.abs(p[:, 2])
        albedo[(which == 2) & (s > 3.7)] = red
        albedo[(which == 2) & (s > 3.4) & (s < 3.55)] = red
        albedo[(which == 3) & (p[:, 1] > 0.8)] = red
        albedo[(which == 4) & (s > 1.2)] = red
        albedo[(which == 0) & (np.abs(p[:, 1] - 0.02) < 0.09)] = red
        albedo[which == 1] = glass
        albedo[(which == 1) & ((np.abs(p[:, 0] - 0.75) < 0.05) | (np.abs(p[:, 0] + 0.25) < 0.05) | (s < 0.03))] = (
            0.7 * white
        )
        hinge = (which == 2) & (s > 2.6) & (s < 4.7) & (np.abs(p[:, 0] - 0.32) < 0.02)
        albedo[hinge | (which == 5)] = 0.08
        return albedo, np.where(which == 1, 1.0, 0.6)

    solid("tourer.webp", parts, paint, 5.4, view(-90, 17), (-0.45, 0.75, -0.45), size=640)


def canopies():
    """Five round parachutes, each with a cut, a pose and a heading of its own; one that is reefed; and a jumper who falls."""
    legs, low, lines = 20, 6.2, 16
    holding = (((0.46, 1.66, 0.1), (0.24, 2.02, 0.03)),) * 2
    waving = (((0.46, 1.66, 0.1), (0.24, 2.02, 0.03)), ((0.58, 1.5, 0.12), (0.84, 1.86, 0.2)))
    pulling = (((0.44, 1.5, 0.16), (0.22, 1.74, 0.12)), ((0.48, 1.72, 0.06), (0.25, 2.1, 0.03)))
    standing = (((0.19, 0.5, 0.2), (0.17, 0.1, 0.02)),) * 2
    sitting = (((0.18, 0.72, 0.46), (0.16, 0.3, 0.56)), ((0.2, 0.74, 0.44), (0.18, 0.3, 0.44)))
    striding = (((0.2, 0.54, 0.34), (0.18, 0.12, 0.3)), ((0.18, 0.46, 0.02), (0.16, 0.12, -0.22)))
    apart = (((0.36, 0.52, 0.16), (0.44, 0.12, 0.02)), ((0.34, 0.52, 0.18), (0.38, 0.12, 0.0)))

    def person(p, arms=holding, stance=standing):
        """arms : the elbow and the hand on the left and on the right, m; stance : the knee and the ankle, likewise"""
        out = [
            ball(p, (0, 1.66, 0), (0.15, 0.17, 0.16)),
            box(p, (0, 1.2, 0), (0.22, 0.34, 0.16), 0.12),
            box(p, (0, 1.22, -0.2), (0.19, 0.28, 0.13), 0.08),
        ]
        for side, (elbow, hand), (knee, ankle) in zip((-1, 1), arms, stance, strict=True):
            mirror = np.float32([side, 1, 1])
            elbow, hand, knee, ankle = (np.float32(at) * mirror for at in (elbow, hand, knee, ankle))
            out += [
                rod(p, (0.24 * side, 1.45, 0), elbow, 0.085, 0.065),
                rod(p, elbow, hand, 0.062, 0.055),
                rod(p, (0.12 * side, 0.9, 0), knee, 0.125, 0.095),
                rod(p, knee, ankle, 0.09, 0.07),
                rod(p, ankle - (0, 0.04, 0.02), ankle + (0.02 * side, -0.1, 0.18), 0.085, 0.075),  # a boot
                rod(p, (0.17 * side, 1.4, 0.0), (0.2 * side, 2.3, 0), 0.03),  # a strap of the harness
            ]
        return out

    def falling(p):
        lifted = p + np.float32([0, 1.1, 0])
        arms = (((0.62, 1.62, 0.1), (0.72, 1.98, 0.1)),) * 2
        return person(lifted, arms, (((0.38, 0.5, 0), (0.42, 0.62, -0.4)),) * 2)

    def dress(colour):
        def paint(p, which, normal, first=0):
            albedo = np.empty(p.shape, np.float32)
            albedo[:] = colour
            head = which == first
            albedo[head] = (0.8, 0.8, 0.78)
            albedo[head & (p[:, 2] > 0.07) & (np.abs(p[:, 1] - 1.65) < 0.06)] = (0.03, 0.03, 0.04)  # goggles
            albedo[which == first + 2] = (0.05, 0.06, 0.08)
            if first:  # the harness, boots and gloves
                body, thigh = which == first + 1, (which == first + 5) | (which == first + 11)
                albedo[body & (np.abs(np.abs(p[:, 0]) - 0.14) < 0.03)] = 0.03
                albedo[body & (np.abs(p[:, 1] - 1.28) < 0.03)] = 0.03
                albedo[thigh & (np.abs(p[:, 1] - 0.78) < 0.035)] = 0.03
                for side in (0, 6):
                    albedo[(which == first + 7 + side) | (which == first + 8 + side)] = 0.03
            return albedo, np.full(len(p), 0.25)

        return paint

    solid("jumper_falling.webp", falling, dress((0.75, 0.12, 0.04)), 1.3, view(20, 25), (0.5, 0.7, 0.5), size=192)

    def gores(a, height, one, two):
        """Every second one, and a band."""
        other = (np.floor(a / (2 * np.pi) * legs) % 2 == 1) | ((height > 0.14) & (height < 0.30))
        return np.where(other[:, None], two, one)

    def bands(a, height, one, two):
        return np.where((np.floor(4.4 * np.arcsin(np.clip(height, 0, 1)) / 1.57) % 2 == 1)[:, None], two, one)

    def quarters(a, height, one, two):
        return np.where((np.floor(a / (2 * np.pi) * 4) % 2 == 1)[:, None], two, one)

    def spiral(a, height, one, two):
        turn = np.floor((a / (2 * np.pi) + 0.45 * height) * legs / 2)
        return np.where((turn % 2 == 1)[:, None], two, one)

    def crown(a, height, one, two):
        """Plain, with a top and a hem of the other colour."""
        return np.where(((height > 0.72) | (height < 0.12))[:, None], two, one)

    def parachute(name, cut, one, two, suit, arms, stance, axes, wide=4.4, high=3.0):
        def around(p):
            a = np.arctan2(p[:, 2], p[:, 0])
            return a, np.abs(np.sin(a * legs / 2))  # a gore bulges between its seams

        def near_cords(p):
            """The distance from the two cords between which p lies, seen from above."""
            at = np.arctan2(p[:, 2], p[:, 0]) / (2 * np.pi) * lines - 0.25
            out = np.full(len(p), 9.0, np.float32)
            for k in (np.floor(at), np.ceil(at)):
                b = 2 * np.pi * (k + 0.25) / lines
                top = np.stack([wide * np.cos(b), 0 * b + low + 0.08, wide * np.sin(b)], 1)
                low_end = np.stack([0.2 * np.sign(np.cos(b)), 0 * b + 2.3, 0 * b], 1)
                along = top - low_end
                t = np.clip(((p - low_end) * along).sum(axis=1) / (along * along).sum(axis=1), 0, 1)
                out = np.minimum(out, np.linalg.norm(p - low_end - t[:, None] * along, axis=1) - 0.012)
            return out

        def parts(p):
            _, g = around(p)
            r = length(p[:, 0], p[:, 2])
            bulge = 1 + 0.035 * g * np.clip(r / wide, 0, 1)
            q = np.stack([p[:, 0] / bulge, p[:, 1] - low, p[:, 2] / bulge], 1)
            shell = np.maximum(
                np.abs(ball(q, (0, 0, 0), (wide, high, wide))) - 0.03, -(q[:, 1] + 0.05 - 0.32 * (1 - g))
            )
            shell = np.maximum(shell, 0.28 - r)  # the vent
            cords, men = near_cords(p), np.repeat(length(*(p - np.float32((0, 1.15, 0))).T)[None] - 1.6, 15, axis=0)
            close = men[0] < 0.4  # elsewhere a ball around the jumper is exact enough
            men[:, close] = person(p[close], arms, stance)
            return [0.7 * shell, cords, *men]

        def paint(p, which, normal):
            a, g = around(p)
            albedo, gloss = dress(suit)(p, which, normal, 2)
            cloth = cut(a, (p[:, 1] - low) / high, np.float32(one), np.float32(two))
            cloth = cloth * (0.72 + 0.28 * rise(0.0, 0.25, g))[:, None]
            inside = normal[:, 1] < 0  # light that comes through the cloth
            cloth = np.where(inside[:, None], 1.5 * cloth, cloth)
            albedo[which == 0] = cloth[which == 0]
            albedo[which == 1] = 0.75
            return albedo, np.where(which == 0, 0.12, gloss)

        sun = (0.6, 0.6, 0.55)
        solid(f"{name}.webp", parts, paint, 5.0, axes, sun, centre=(0, 4.55, 0), below=(0.30, 0.30, 0.26))

    red, cream, blue = (0.72, 0.04, 0.05), (0.88, 0.86, 0.80), (0.04, 0.16, 0.55)
    yellow, teal, orange = (0.92, 0.60, 0.06), (0.03, 0.25, 0.26), (0.85, 0.26, 0.02)
    navy, violet, green = (0.02, 0.12, 0.42), (0.22, 0.05, 0.30), (0.05, 0.32, 0.09)
    parachute("canopy_a", crown, red, cream, blue, waving, striding, view(28, -15, 8))
    parachute("canopy_b", gores, navy, yellow, (0.75, 0.10, 0.05), pulling, apart, view(-24, -11, -6))
    parachute("canopy_c", spiral, orange, teal, yellow, holding, sitting, view(52, -13, -11))
    parachute("canopy_d", bands, cream, violet, (0.10, 0.10, 0.12), holding, striding, view(-50, -12, 9))
    parachute("canopy_e", quarters, green, cream, (0.62, 0.62, 0.6), waving, standing, view(10, -16, -9))
    parachute("reefed", gores, red, cream, blue, holding, standing, view(15, -14), wide=1.25, high=2.6)


def hot_air():
    """Hot-air balloons in four dresses, lit by a low sun from the left."""

    def parts(p):
        # the envelope narrows below to its mouth
        y = p[:, 1]
        r = np.interp(y, *PROFILE)
        a = np.arctan2(p[:, 2], p[:, 0])
        rr = length(p[:, 0], p[:, 2])
        bulge = 1 + 0.022 * np.abs(np.sin(a * 12)) * np.clip(r / 8, 0, 1)
        beyond = np.maximum(np.maximum(PROFILE[0][0] - y, y - PROFILE[0][-1]), 0)
        skin = 0.72 * np.where(beyond > 0, length(np.maximum(rr - r * bulge, 0), beyond), rr - r * bulge)
        basket = box(p, (0, -13.2, 0), (0.85, 0.65, 0.85), 0.12)
        rim = box(p, (0, -12.5, 0), (0.95, 0.1, 0.95), 0.1)
        burner = box(p, (0, -10.9, 0), (0.45, 0.16, 0.45), 0.1)
        cords = [rod(p, (0.8 * x, -12.6, 0.8 * z), (1.35 * x, -8.6, 1.35 * z), 0.05) for x in (-1, 1) for z in (-1, 1)]
        heads = [ball(p, (x, -12.0, z), (0.2, 0.36, 0.2)) for x, z in ((-0.4, 0.3), (0.35, 0.2), (0.0, -0.4))]
        return [skin, basket, rim, burner, np.min(np.stack(cords), axis=0), np.min(np.stack(heads), axis=0)]

    ys = np.linspace(-8.6, 8.4, 60)
    up = np.clip(ys / 8.4, 0, 1)
    down = np.clip(-ys / 8.6, 0, 1)
    PROFILE = (ys, np.where(ys > 0, 8.2 * np.sqrt(np.maximum(1 - up**2, 0)), 8.2 - 6.7 * down**1.55 - 0.1 * down))
    red, orange, gold, cream, navy, teal, violet, rose = (
        np.float32(c)
        for c in (
            (0.66, 0.03, 0.04),
            (0.86, 0.24, 0.02),
            (0.92, 0.60, 0.05),
            (0.88, 0.84, 0.74),
            (0.02, 0.06, 0.26),
            (0.02, 0.30, 0.33),
            (0.20, 0.05, 0.32),
            (0.72, 0.10, 0.24),
        )
    )

    def stripes(a, y):
        return np.array([red, gold, red, cream])[np.floor(a * 24).astype(int) % 4]

    def bands(a, y):
        return np.array([navy, teal, cream, gold, orange, red, navy])[
            np.clip(np.floor((y + 8.6) / 17 * 7 + 0.25 * (np.abs((a * 12) % 1 - 0.5) * 2)).astype(int), 0, 6)
        ]

    def spiral(a, y):
        return np.array([violet, rose, orange, gold])[np.floor(a * 8 + y * 0.28).astype(int) % 4]

    def checks(a, y):
        return np.array([cream, teal])[(np.floor(a * 24).astype(int) + np.floor(y / 2.1).astype(int)) % 2]

    for letter, dress in zip("abcd", (stripes, bands, spiral, checks), strict=True):

        def paint(p, which, normal, dress=dress):
            a = np.arctan2(p[:, 2], p[:, 0]) / (2 * np.pi) + 0.5
            albedo = np.full(p.shape, 0.06, np.float32)
            albedo[which == 0] = dress(a, p[:, 1])[which == 0]
            seam = np.abs(np.sin(a * 2 * np.pi * 12))
            albedo[which == 0] *= (0.8 + 0.2 * rise(0.0, 0.3, seam[which == 0]))[:, None]
            albedo[(which == 0) & (p[:, 1] < -8.0)] = 0.05
            weave = 0.75 + 0.25 * np.sign(np.sin(p[:, 1] * 40) * np.sin((p[:, 0] + p[:, 2]) * 30))
            albedo[which == 1] = (np.float32((0.32, 0.19, 0.09)) * weave[:, None])[which == 1]
            albedo[which == 2] = (0.10, 0.05, 0.03)
            albedo[which == 5] = (0.25, 0.12, 0.10)
            return albedo, np.where(which == 0, 0.22, 0.1)

        solid(
            f"hot_air_{letter}.webp",
            parts,
            paint,
            11.6,
            view(20, -6),
            (-0.75, 0.42, 0.5),
            size=512,
            centre=(0, -2.7, 0),
            warm=(2.1, 1.65, 1.1),
            sky=(0.48, 0.58, 0.80),
            below=(0.30, 0.27, 0.22),
        )


def transport():
    """A high-winged aeroplane with two propellers and an open side door, from its right side and a little from below."""

    def parts(p):
        q = p.copy()
        q[:, 2] = np.abs(q[:, 2])
        body = hull(p, [-8.0, -6.0, -3.0, 3.5, 5.2, 6.2, 6.6], [0.25, 0.55, 1.15, 1.2, 1.0, 0.6, 0.05], 0.0, 1.08)
        main = wing(q, (1.6, 1.25, 0.2), 2.4, (1.1, 1.5, 10.5), 1.3, 0.06)
        fin = wing(p, (-5.2, 0.6, 0), 2.6, (-6.9, 4.0, 0), 1.3, 0.05, along=1)
        tail = wing(q, (-6.0, 0.7, 0.1), 1.7, (-6.5, 0.8, 3.6), 1.0, 0.05)
        engine = ball(q, (1.3, 1.15, 3.0), (1.9, 0.48, 0.42))
        disc = np.maximum(np.abs(p[:, 0] - 3.15) - 0.02, length(q[:, 1] - 1.1, q[:, 2] - 3.0) - 1.45)
        gear = np.minimum(ball(q, (0.4, -1.1, 1.0), (1.3, 0.42, 0.42)), ball(p, (4.4, -1.05, 0), (0.35, 0.35, 0.2)))
        strut = rod(q, (0.9, -0.7, 1.0), (0.9, 1.35, 4.2), 0.07)
        return [body, main, fin, tail, engine, disc, gear, strut]

    def paint(p, which, normal):
        albedo = np.full(p.shape, 0.80, np.float32)
        albedo[(which == 0) & (p[:, 1] < -0.15) & (p[:, 1] > -0.5)] = (0.75, 0.22, 0.02)
        albedo[(which == 0) & (p[:, 1] <= -0.5)] = (0.10, 0.13, 0.22)
        albedo[(which == 2) & (p[:, 1] > 1.8)] = (0.75, 0.22, 0.02)
        albedo[(which == 2) & (p[:, 1] > 2.8)] = (0.10, 0.13, 0.22)
        albedo[which == 5] = 0.25
        for x in np.arange(-1.6, 3.6, 0.9):
            albedo[(which == 0) & (length(p[:, 0] - x, p[:, 1] - 0.35) < 0.22)] = 0.03
        albedo[(which == 0) & (p[:, 0] > 4.6) & (p[:, 0] < 5.5) & (p[:, 1] > 0.2)] = 0.03
        albedo[(which == 0) & (np.abs(p[:, 0] + 3.1) < 0.55) & (p[:, 1] > -0.75) & (p[:, 1] < 0.75)] = 0.02
        return albedo, np.where(which == 5, 0.0, 0.5)

    solid("transport.webp", parts, paint, 8.6, view(10, -9), (0.5, 0.7, 0.55), size=768, centre=(-0.6, 1.0, 0))


def submarine():
    """A small submarine from its right side: hull, tower with planes, rudders, a propeller. Water lights it from above."""

    def parts(p):
        q = p.copy()
        q[:, 2] = np.abs(q[:, 2])
        body = hull(
            p, [-4.3, -3.6, -2.4, -1, 2.2, 3.2, 3.8, 4.15, 4.25], [0.10, 0.24, 0.55, 0.74, 0.74, 0.64, 0.46, 0.22, 0.02]
        )
        deck = box(p, (0.1, 0.70, 0), (2.3, 0.08, 0.26), 0.05)
        s = np.clip((p[:, 1] - 0.6) / 1.0, 0, 1)
        tower = 0.8 * box(np.stack([p[:, 0] + 0.12 * s, p[:, 1], p[:, 2]], 1), (0.75, 1.1, 0), (0.72, 0.62, 0.22), 0.2)
        planes = wing(q, (1.25, 1.2, 0.15), 0.5, (1.15, 1.2, 0.95), 0.36, 0.07)
        mast = np.minimum(
            rod(p, (0.7, 1.6, 0), (0.7, 2.35, 0), 0.045), rod(p, (0.45, 1.6, 0.05), (0.45, 2.1, 0.05), 0.06)
        )
        mast = np.minimum(mast, box(p, (0.76, 2.36, 0), (0.12, 0.06, 0.06), 0.03))
        fins = np.minimum(
            wing(p, (-3.0, 0.15, 0), 0.75, (-3.4, 1.05, 0), 0.5, 0.07, along=1),
            wing(p, (-3.0, -0.15, 0), 0.75, (-3.4, -1.0, 0), 0.5, 0.07, along=1),
        )
        stern = wing(q, (-3.0, 0, 0.15), 0.75, (-3.4, 0, 1.05), 0.5, 0.07)
        screw = []
        for k in range(5):
            a = 2 * np.pi * k / 5 + 0.35
            c = np.float32([0, np.cos(a), np.sin(a)])
            r = p @ c
            w = p[:, 2] * c[1] - p[:, 1] * c[2]
            x = p[:, 0] + 4.45
            z = np.stack([x * 0.8 + w * 0.6, r - 0.38, w * 0.8 - x * 0.6], 1)
            screw.append(ball(z, (0, 0, 0), (0.04, 0.36, 0.15)))
        hub = rod(p, (-4.2, 0, 0), (-4.6, 0, 0), 0.11, 0.05)
        rail = np.minimum(
            rod(p, (1.7, 1.0, 0.2), (3.5, 0.72, 0.02), 0.014), rod(p, (1.9, 0.72, 0.2), (1.9, 0.98, 0.2), 0.014)
        )
        return [body, deck, tower, planes, mast, np.minimum(fins, stern), np.min(np.stack(screw), axis=0), hub, rail]

    def paint(p, which, normal):
        albedo = np.empty(p.shape, np.float32)
        albedo[:] = (0.92, 0.56, 0.03)
        low = (which == 0) & (p[:, 1] < -0.22)
        albedo[low] = (0.42, 0.05, 0.03)
        albedo[(which == 0) & (np.abs(p[:, 1] + 0.22) < 0.035)] = 0.85
        albedo[which == 1] = (0.10, 0.10, 0.10)
        albedo[(which == 4) | (which == 8)] = 0.12
        albedo[(which == 6) | (which == 7)] = (0.55, 0.32, 0.10)
        albedo[(which == 3) | (which == 5)] = (0.60, 0.07, 0.03)
        for x in (-0.7, 0.15, 1.0, 1.85):  # portholes
            r = length(p[:, 0] - x, p[:, 1] - 0.2)
            albedo[(which == 0) & (r < 0.17)] = 0.10
            albedo[(which == 0) & (r < 0.125)] = (2.6, 0.8, 0.16)
        for x in np.arange(-1.8, 3.0, 0.36):  # slots of the tanks
            albedo[(which == 0) & (np.abs(p[:, 0] - x) < 0.10) & (np.abs(p[:, 1] + 0.42) < 0.028)] = 0.03
        seam = (np.abs((p[:, 0] + 0.3) % 0.9 - 0.45) < 0.011) & (which == 0)
        albedo[seam] *= 0.65
        rust = 0.12 * fractal(p[:, 0] * 0.6, p[:, 1] * 2.0, 0.0, 2.0, 4, 0.6, 5)
        albedo *= np.clip(1 + rust, 0.6, 1.25)[:, None]
        return albedo, np.full(len(p), 0.35)

    solid(
        "submarine.webp",
        parts,
        paint,
        4.75,
        view(-16, 9),
        (0.12, 1.0, 0.38),
        size=1024,
        centre=(-0.15, 0.2, 0),
        sky=(0.42, 0.60, 0.62),
        below=(0.02, 0.10, 0.14),
        warm=(1.15, 1.15, 0.95),
    )


def cumulus(name, seed, size=512, wide=1.0):
    """A heap of cumulus with a flat base, lit from above left, as wide as the image."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(-1, 1, size, dtype=np.float32), np.linspace(1, -1, size, dtype=np.float32))
    balls = []
    for _ in range(70):  # towers are heaps of balls on a level base
        bx = np.clip(rng.normal(0, 0.36 * wide), -0.75, 0.75)
        top = 0.46 * np.exp(-((bx / 0.42) ** 2)) + 0.05
        r = rng.uniform(0.07, 0.24) * (0.5 + 0.5 * np.exp(-((bx / 0.5) ** 2)))
        by = -0.42 + r * 0.7 + rng.uniform(0, 1) ** 1.2 * top
        balls.append((bx, by, rng.normal(0, 0.2), r))
    depth = 40
    zs = np.linspace(0.7, -0.7, depth)

    def density(px, py, pz):
        f = np.full(px.shape, -9.0, np.float32)
        for bx, by, bz, r in balls:
            d = 1 - ((px - bx) ** 2 + (py - by) ** 2 + (pz - bz) ** 2) / (r * r)
            f = np.maximum(f, d)
        n = fractal(px * 1.0 + 0.6 * pz + 20, py + 0.8 * pz + 20, 0.0, 5.0, 5, 0.56, seed)
        n = n + 0.55 * fractal(pz * 1.0 - 0.5 * px + 30, py + 0.4 * px + 30, 0.0, 6.0, 4, 0.56, seed + 50)
        base = rise(-0.42, -0.36, py + 0.05 * n)
        return np.clip((f + 2.3 * n + 0.02) * 3.0, 0, 1) * base

    slices = np.stack([density(x, y, 0 * x + z) for z in zs])
    step = 1.4 / depth
    # the sun's light through the cloud: along a slope in the picture, from above left and ahead
    light = np.zeros_like(slices)
    above = np.zeros((depth, size), np.float32)
    for row in range(size):  # depth above this row along the light's way
        above = np.roll(above, 0, axis=0)
        shifted = np.empty_like(above)
        shifted[:, 1:], shifted[:, 0] = above[:, :-1] * 0.5 + above[:, 1:] * 0.5, 0
        forward = np.empty_like(shifted)
        forward[1:], forward[0] = shifted[:-1] * 0.06 + shifted[1:] * 0.94, shifted[0] * 0.94
        light[:, row] = forward
        above = forward + slices[:, row] * (2.0 / size) * 1.1
    extinction = 26.0
    clear, sunlit, shade = np.ones_like(x), np.zeros_like(x), np.zeros_like(x)
    for k in range(depth):
        a = 1 - np.exp(-slices[k] * step * extinction)
        tau = light[k] * extinction
        lit = 0.62 * np.exp(-0.55 * tau) + 0.38 * np.exp(-0.10 * tau)
        sunlit, shade, clear = sunlit + clear * a * lit, shade + clear * a, clear * (1 - a)
    alpha = 1 - clear
    sun_light = (sunlit / np.maximum(alpha, 1e-3))[..., None] * np.float32([1.42, 1.36, 1.26])
    sky_light = (0.24 + 0.10 * y)[..., None] * np.float32([0.78, 0.92, 1.15])
    edge = rise(1.0, 0.86, np.maximum(np.abs(x), np.abs(y)))
    write(name, sun_light + sky_light, alpha * edge, 80)


def ice_clouds(name, seed, size=640):
    """High ice clouds combed by the wind, in 70 degrees of the sky; the lower edge of the image is level with the eye."""
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, size, dtype=np.float32), np.linspace(1.4, 0, size, dtype=np.float32))
    y = np.maximum(y, 0.02)
    far, side = 1 / (y + 0.08), x / (y + 0.08)  # where the line of sight meets a level sheet
    a = 0.7
    u, v = 1.5 * (side * np.cos(a) + far * np.sin(a)), 1.5 * (far * np.cos(a) - side * np.sin(a))
    bend = 0.35 * fractal(u * 0.6 + 20, v * 0.6 + 20, 0.0, 1.0, 3, 0.5, seed)
    v = v + bend + 0.25 * np.sin(0.5 * u)
    comb = fractal(u * 0.35 + 40, v * 2.6 + 40, 0.0, 1.0, 6, 0.55, seed + 1)
    fine = fractal(u * 0.9 + 70, v * 9.0 + 70, 0.0, 1.0, 4, 0.55, seed + 2)
    where = fractal(u * 0.45 + 90, v * 0.6 + 90, 0.0, 1.0, 3, 0.5, seed + 3)
    veil = np.clip(0.08 + 1.2 * comb + 0.9 * fine, 0, 1) * rise(-0.25, 0.35, where)
    edge = rise(0.7, 0.42, np.abs(x)) * rise(1.4, 1.0, y) * rise(0.06, 0.3, y)
    write(name, np.broadcast_to(np.float32((1.3, 1.3, 1.3)), (*x.shape, 3)), 0.27 * veil * edge, 80)


def cirrus():
    ice_clouds("cirrus_a.webp", 1)
    ice_clouds("cirrus_b.webp", 5)


def parcels(rng, depth=8):
    """Rectangles (left, top, width, height) that tile the unit square, halved again and again at uneven places."""
    done, open_ = [], [(0.0, 0.0, 1.0, 1.0, 0)]
    while open_:
        left, top, wide, high, level = open_.pop()
        small = 0.06 + 0.045 * rng.random()
        if level >= depth or (max(wide, high) < 2 * small and rng.random() < 0.75) or min(wide, high) < 0.03:
            done.append((left, top, wide, high))
            continue
        at = rng.uniform(0.36, 0.64)
        if wide > high * rng.uniform(0.7, 1.5):
            open_ += [
                (left, top, wide * at, high, level + 1),
                (left + wide * at, top, wide * (1 - at), high, level + 1),
            ]
        else:
            open_ += [
                (left, top, wide, high * at, level + 1),
                (left, top + high * at, wide, high * (1 - at), level + 1),
            ]
    return np.array(done)


def fields(name="fields.webp", size=1024, samples=1):
    """A map of fields, meadows, hedges, woods and farms, which repeats; furrows and lanes of tractors run along the fields.

    samples : points along each side of a pixel of which the pixel is the mean; more than one also draw single crowns
    """
    rng = np.random.default_rng(12)
    size *= samples
    v, u = (np.mgrid[0:size, 0:size].astype(np.float32) + np.float32(0.5)) / size

    def bent(seed):
        return 0.07 * noise(u * 3, v * 3, seed, (3, 3)) + 0.024 * noise(u * 8, v * 8, seed + 2, (8, 8))

    x, y = (u + bent(1)) % 1, (v + bent(2)) % 1
    tiles = parcels(rng)
    which, border, along_x = np.zeros(x.shape, int), np.ones(x.shape), np.zeros(x.shape, bool)
    for k, (left, top, wide, high) in enumerate(tiles):
        inside = (x >= left) & (x < left + wide) & (y >= top) & (y < top + high)
        edge = np.minimum(np.minimum(x - left, left + wide - x), np.minimum(y - top, top + high - y))
        which[inside], border[inside], along_x[inside] = k, edge[inside], wide > high
    kinds = np.float32(
        [
            (0.14, 0.22, 0.05),
            (0.19, 0.26, 0.07),
            (0.45, 0.37, 0.14),
            (0.54, 0.46, 0.23),
            (0.26, 0.19, 0.12),
            (0.09, 0.15, 0.04),
            (0.60, 0.53, 0.09),
            (0.25, 0.31, 0.11),
        ]
    )
    kind = rng.choice(len(kinds), len(tiles), p=[0.24, 0.2, 0.12, 0.1, 0.08, 0.09, 0.03, 0.14])
    colour = kinds[kind[which]] * rng.uniform(0.82, 1.15, (len(tiles), 1))[which].astype(np.float32)
    across = np.where(along_x, y, x)
    rows = np.sin(across * 2 * np.pi * 170) * 0.06 + (np.abs((across * 48) % 1 - 0.5) < 0.05) * -0.14
    colour = colour * (1 + rows * (kind[which] != 5))[..., None]
    patch = sum(0.5**k * noise(u * 8 * 2**k, v * 8 * 2**k, 20 + k, (8 * 2**k, 8 * 2**k)) for k in range(6))
    colour = colour * (1 + 0.3 * patch)[..., None]
    grain = noise(u * 256, v * 256, 40, (256, 256)) + 0.7 * noise(u * 128, v * 128, 41, (128, 128))
    if samples > 1:
        grain += 0.8 * noise(u * 512, v * 512, 42, (512, 512))
    clumps = noise(u * 48, v * 48, 44, (48, 48))
    wood = (kind[which] == 5) & (border > 0.002 + 0.002 * grain)
    hedge = (border < 0.0016 + 0.0016 * np.clip(clumps, 0, 1) + 0.0008 * grain) & (clumps > -0.2)
    tree = (border < 0.006) & (noise(u * 90, v * 90, 45, (90, 90)) > 0.24)
    high_green = wood | hedge | tree
    down, right = 2 * size // 1024, 3 * size // 1024
    shade = np.roll(np.roll(high_green, down, 0), right, 1) & ~high_green  # the sun stands in the upper left
    colour = np.where(shade[..., None], colour * 0.55, colour)
    green = np.float32((0.06, 0.10, 0.028))
    colour = np.where(high_green[..., None], green * (1 + 0.9 * grain)[..., None], colour)
    for road, bend in ((np.abs(y - tiles[0][1]), 0), (np.abs(x - tiles[len(tiles) // 2][0]), 1)):
        colour = np.where((np.minimum(road, 1 - road) < 0.0017)[..., None], np.float32((0.50, 0.46, 0.38)), colour)
    for _ in range(26):  # farms: a few roofs side by side
        left, top, wide, high = tiles[rng.integers(len(tiles))]
        for _ in range(rng.integers(2, 5)):
            at = left + 0.012 + 0.014 * rng.random(), top + 0.012 + 0.014 * rng.random()
            half = rng.uniform(0.0018, 0.0045), rng.uniform(0.0014, 0.0024)
            roof = (np.abs(x - at[0]) < half[0]) & (np.abs(y - at[1]) < half[1])
            dark = (np.abs(x - at[0] - 0.002) < half[0]) & (np.abs(y - at[1] - 0.002) < half[1])
            tile_colour = np.float32((0.42, 0.16, 0.10) if rng.random() < 0.6 else (0.45, 0.44, 0.43))
            colour = np.where((dark & ~roof)[..., None], colour * 0.45, colour)
            colour = np.where(roof[..., None], tile_colour * np.where(y < at[1], 1.25, 0.75)[..., None], colour)
    colour = np.clip(colour, 0, 1).reshape(size // samples, samples, size // samples, samples, 3).mean(axis=(1, 3))
    pixels = colour ** (1 / 2.2)
    Image.fromarray((pixels * 255 + 0.5).astype(np.uint8)).save(FOLDER / name, quality=72, method=6)


def hanging():
    """Three jumpers who hang by the ankles, each in a pose and colours of its own, seen from the side of the chest."""
    for letter, shirt, trousers, shoes, hair, arms, knees in (
        ("a", (0.85, 0.45, 0.03), (0.04, 0.07, 0.19), (0.70, 0.70, 0.68), (0.06, 0.035, 0.02),
         (((0.44, -0.72, 0.02), (0.68, -0.86, 0.08)), ((0.44, -0.70, 0.02), (0.69, -0.80, 0.08))), (0.10, 0.10)),
        ("b", (0.72, 0.07, 0.05), (0.07, 0.07, 0.08), (0.10, 0.30, 0.60), (0.30, 0.16, 0.05),
         (((0.34, -0.86, 0.08), (0.40, -1.12, 0.16)), ((0.42, -0.60, 0.06), (0.66, -0.70, 0.14))), (0.13, 0.07)),
        ("c", (0.04, 0.36, 0.46), (0.26, 0.21, 0.14), (0.55, 0.08, 0.06), (0.015, 0.012, 0.012),
         (((0.27, -0.88, 0.06), (0.22, -1.16, 0.12)), ((0.28, -0.88, 0.06), (0.25, -1.15, 0.14))), (0.09, 0.12)),
    ):  # fmt: skip
        jumper(f"jumper_{letter}.webp", shirt, trousers, shoes, hair, arms, knees)


def jumper(name, shirt, trousers, shoes, hair, arms, knees):
    """arms : the elbow and the hand on the left and on the right, m; the hips are at 0, the ankles 0.8 m higher, in the middle"""

    def joined(a, b, k):
        h = np.maximum(k - np.abs(a - b), 0) / k
        return np.minimum(a, b) - h * h * k / 4

    def parts(p):
        flat = p * np.float32([1, 1, 1.45])  # the trunk is wider than it is deep
        trunk = rod(flat, (0, -0.1, 0), (0, -0.3, 0), 0.122, 0.152)
        trunk = 0.7 * joined(trunk, rod(flat, (-0.1, -0.44, 0), (0.1, -0.44, 0), 0.125), 0.1)
        head = joined(
            ball(p, (0, -0.76, 0.02), (0.085, 0.12, 0.105)), rod(p, (0, -0.5, 0), (0, -0.7, 0.01), 0.055), 0.03
        )
        cap = np.maximum(
            ball(p, (0, -0.785, -0.005), (0.105, 0.135, 0.12)), (p[:, 2] - 0.035) - 0.9 * (-0.76 - p[:, 1])
        )
        out = [trunk, head, cap, 0.7 * rod(flat, (-0.05, -0.03, 0), (0.05, -0.03, 0), 0.132)]
        for side, (elbow, hand), knee in zip((-1, 1), arms, knees, strict=True):
            ex, ey, ez = elbow
            hx, hy, hz = hand
            away = unit(np.float32(hand) - np.float32(elbow)) * np.float32([side, 1, 1])
            end = np.float32([hx * side, hy, hz])
            out += [
                joined(
                    rod(p, (0.19 * side, -0.46, 0), (ex * side, ey, ez), 0.062, 0.045),
                    ball(p, (0.18 * side, -0.45, 0), (0.075, 0.075, 0.075)),
                    0.04,
                ),
                rod(p, (ex * side, ey, ez), end, 0.043, 0.03),
                joined(
                    ball(p, end + 0.04 * away, (0.035, 0.04, 0.03)),
                    rod(p, end + 0.03 * away, end + 0.12 * away, 0.026, 0.015),
                    0.03,
                ),
                rod(p, (0.085 * side, 0.02, 0), (knee * side, 0.42, 0.07), 0.096, 0.066),
                joined(
                    rod(p, (knee * side, 0.42, 0.07), (0.055 * side, 0.8, 0), 0.06, 0.042),
                    ball(p, (0.08 * side, 0.56, 0.01), (0.055, 0.14, 0.06)),
                    0.05,
                ),
                joined(
                    rod(p, (0.055 * side, 0.86, -0.02), (0.06 * side, 0.9, 0.13), 0.05, 0.04),
                    rod(p, (0.055 * side, 0.8, 0), (0.055 * side, 0.87, 0), 0.05),
                    0.03,
                ),
            ]
        return [*out, rod(p, (0, 0.8, 0), (0, 0.95, 0), 0.03), rod(p, (-0.06, 0.76, 0), (0.06, 0.76, 0), 0.07)]

    def paint(p, which, normal):
        albedo = np.full(p.shape, 0.05, np.float32)
        for colour, those in (
            (shirt, (0, 4, 10)), ((0.62, 0.38, 0.26), (1, 5, 6, 11, 12)), (hair, (2,)), (trousers, (3, 7, 8, 13, 14)),
            (shoes, (9, 15)), ((0.85, 0.72, 0.30), (16,)), ((0.05, 0.05, 0.06), (17,)),
        ):  # fmt: skip
            albedo[np.isin(which, those)] = colour
        strap = (which == 0) & (np.abs(np.abs(p[:, 0]) - 0.09) < 0.022) & (p[:, 1] > -0.5)
        belt = (which == 3) & (np.abs(p[:, 1] + 0.06) < 0.03)
        albedo[strap | belt] = (0.03, 0.03, 0.035)
        return albedo, np.where(np.isin(which, (2, 9, 15)), 0.4, 0.15).astype(np.float32)

    solid(name, parts, paint, 2.05, view(25, -5), (-0.6, 0.8, 0.5), size=512, centre=(0, 0.85, 0))


def sea(name="sea_light.webp", size=768):
    """Water from below: bright towards the surface, with shafts of sunlight that fan out; far rocks in the haze."""
    v, u = (np.mgrid[0:size, 0:size] + 0.5) / size
    x, y = u * 2 - 1, 1 - v * 2  # y = 1 at the surface
    deep, middle, bright = (
        np.float32((0.004, 0.030, 0.055)),
        np.float32((0.012, 0.20, 0.27)),
        np.float32((0.30, 0.78, 0.78)),
    )
    t = ((y + 1) / 2)[..., None]
    light = deep + (middle - deep) * rise(0.05, 0.75, t) + (bright - middle) * rise(0.62, 1.0, t) ** 1.6
    a = (x + 0.25) / (2.3 - y)  # the shafts meet at a point above the picture
    shafts = (
        0.55 * noise(a * 60 + 40, 0 * a + 0.5, 5)
        + 0.35 * noise(a * 150 + 90, 0 * a + 1.5, 6)
        + 0.3 * noise(a * 22 + 20, 0 * a + 2.5, 7)
    )
    beam = np.clip(shafts + 0.12, 0, 1) * np.exp(-((x + 0.15) ** 2) / 0.5) * rise(-0.75, 0.9, y)
    light = light + beam[..., None] * np.float32((0.16, 0.42, 0.40)) * 1.5
    for far, tall, tone in ((41, 0.30, 0.55), (42, 0.20, 0.30)):
        top = -0.12 + tall * (0.5 + 0.9 * fractal(x * 1.0 + 7, 0 * x + far, 0.0, 2.2, 6, 0.5, far)) * (
            0.35 + 0.65 * rise(0.0, 0.9, np.abs(x + 0.1))
        )
        cover = rise(-0.004, 0.004, top - y)[..., None]
        light = light * (1 - cover) + cover * (light * tone)
    write(name, light, np.ones_like(x), 90)
    flow = [np.linspace(0, 1, 512, endpoint=False)] * 2
    gu, gv = np.meshgrid(*flow)
    w = 0.35 * noise(gu * 4, gv * 4, 8, (4, 4))
    ripples = np.sin(2 * np.pi * (gv * 14 + 2.2 * w + 0.4 * noise(gu * 8, gv * 8, 9, (8, 8))))
    grain = noise(gu * 64, gv * 64, 10, (64, 64)) + noise(gu * 128, gv * 128, 11, (128, 128))
    height = 0.5 + 0.30 * ripples + 0.12 * grain + 0.5 * w
    Image.fromarray((np.clip(height, 0, 1) * 255).astype(np.uint8)).save(FOLDER / "sea_sand.webp", quality=75, method=6)
    bend = [0.30 * noise(gu * 4, gv * 4, k, (4, 4)) for k in (12, 13)]
    net = np.zeros_like(gu)  # where the waves above gather the light
    for k, cells in ((14, 5), (15, 7)):
        cu, cv = (gu + 0.35 * bend[0] / cells * 4) * cells, (gv + 0.35 * bend[1] / cells * 4) * cells
        net = net + np.exp(-np.abs(noise(cu, cv, k, (cells, cells))) / 0.07)
    sand = np.float32((0.46, 0.44, 0.30)) * (0.62 + 0.75 * np.clip(net, 0, 1.6) ** 1.2 + 0.05 * grain)[..., None]
    sand = np.clip(sand, 0, 1) ** (1 / 2.2)
    Image.fromarray((sand * 255).astype(np.uint8)).save(FOLDER / "sea_floor.webp", quality=70, method=6)


def waterline(name="waterline.webp", size=1024, deep=0.65):
    """Where a pane stands half in water: the water's edge, which is not straight, and the tint below it.

    deep : how far down the tint goes, in halves of the image
    """
    v, u = (np.mgrid[0:size, 0:size] + 0.5) / size
    edge = np.zeros_like(u[0])
    for k, part in ((1.3, 6), (2.9, 3.5), (5.3, 2.2), (11, 1.0), (19, 0.5)):
        edge = edge + part * np.sin(2 * np.pi * k * u[0] + 2.4 * k)
    y = size / 2 - v * size - edge  # texels above the edge
    below = rise(-1.0, 1.0, -y)
    tint = below * (0.25 + 0.40 * np.exp(np.minimum(y, 0) / 9) + 0.14 * np.exp(np.minimum(y, 0) / 60))
    shine = np.exp(-(((y + 0.5) / 1.3) ** 2)) * (0.55 + 0.45 * np.sin(2 * np.pi * 3.7 * u + 1))
    dark = np.exp(-(((y + 4.5) / 3.0) ** 2)) * 0.5
    tint = tint * rise(-1.0, 1.0, deep * size / 2 + size / 2 - v * size)
    light = np.float32((0.12, 0.50, 0.62)) * (1 - dark[..., None]) + shine[..., None] * np.float32((0.8, 0.95, 1.0))
    write(name, light, np.clip(np.maximum(tint, 0.9 * shine), 0, 1), 90)


def gate():
    """A ring of cloth filled with gas, in red and white, through which aeroplanes fly."""

    def parts(p):
        across = np.hypot(p[:, 0], p[:, 1])
        seams = 0.018 * np.abs(np.cos(6 * np.arctan2(p[:, 1], p[:, 0])))
        return [0.9 * (np.hypot(across - 9.0, p[:, 2]) - 0.8 - seams)]

    def paint(p, which, normal):
        stripe = np.cos(6 * np.arctan2(p[:, 1], p[:, 0])) > 0
        albedo = np.where(stripe[:, None], np.float32((0.80, 0.06, 0.02)), np.float32((0.85, 0.84, 0.80)))
        return albedo, np.full(len(p), 0.7)

    solid("gate.webp", parts, paint, 9.95, view(0, 0), (-0.35, 0.8, 0.5), size=512)


def probe():
    """A space probe in two attitudes: gilt foil, a dish, two panels, in the orange light of a disc at the left above."""

    def parts(p):
        q = p.copy()
        q[:, 0] = np.abs(q[:, 0])
        foil = 0.02 * np.sin(17 * p[:, 0] + 5 * p[:, 1]) * np.sin(13 * p[:, 1] - 7 * p[:, 2]) * np.sin(15 * p[:, 2])
        body = 0.8 * (box(p, (0, 0, 0), (0.62, 0.8, 0.62), 0.08) - foil)
        dish = np.maximum(np.abs(ball(p, (0, 1.9, 0), (1.15, 1.15, 1.15))) - 0.03, p[:, 1] - 1.32)
        feed = rod(p, (0, 0.8, 0), (0, 1.75, 0), 0.05)
        arm = rod(q, (0.6, 0, 0), (1.3, 0, 0), 0.06)
        panel = box(q, (2.75, 0, 0), (1.45, 0.72, 0.03), 0.01)
        nozzle = rod(p, (0, -0.8, 0), (0, -1.1, 0), 0.14, 0.26)
        return [body, dish, feed, arm, panel, nozzle]

    def paint(p, which, normal):
        albedo = np.broadcast_to(np.float32((0.75, 0.42, 0.08)), p.shape).copy()
        albedo[which == 1] = (0.85, 0.85, 0.84)
        albedo[(which == 2) | (which == 3)] = 0.5
        cell = np.minimum(np.abs((p[:, 0] % 0.29) - 0.145), np.abs(((p[:, 1] + 0.72) % 0.36) - 0.18))
        albedo[which == 4] = np.where(cell[which == 4, None] < 0.125, (0.03, 0.07, 0.28), (0.42, 0.44, 0.5))
        albedo[which == 5] = (0.12, 0.12, 0.13)
        return albedo, np.where(which == 1, 0.3, 1.0)

    light = {"size": 256, "warm": (3.4, 2.1, 1.1), "sky": (0.10, 0.12, 0.18), "below": (0.03, 0.03, 0.05)}
    solid("probe.webp", parts, paint, 4.4, view(28, 24, -14), (-0.6, 0.62, 0.5), **light)
    solid("probe_b.webp", parts, paint, 4.4, view(-48, 34, 48), (-0.6, 0.62, 0.5), **light)


def farmland():
    """The map of `fields` with four times as much in it, for aeroplanes that fly low."""
    fields("farmland.webp", 2048, samples=2)


def clouds():
    cumulus("cumulus_a.webp", 3)
    cumulus("cumulus_b.webp", 11, wide=1.25)


ALL = {
    f.__name__: f
    for f in (
        jet,
        sailplane,
        tourer,
        canopies,
        hot_air,
        transport,
        submarine,
        hanging,
        sea,
        waterline,
        clouds,
        cirrus,
        fields,
        farmland,
        gate,
        probe,
    )
}

if __name__ == "__main__":
    for chosen in sys.argv[1:] or ALL:
        ALL[chosen]()
