"""Rays and cones of rays against tori, whose equation along a ray is a polynomial of degree four."""

from functools import cache

import numpy as np
import pytest

from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.colliders import Torus
from gen_art.colliders.kinds import numbers_of
from gen_art.output.playback import Playback
from gen_art.preset import load_preset
from gen_art.renderer.surfaces.collider_rays import ColliderTerms, first_hit
from gen_art.renderer.surfaces.collider_sets import ALL_COLLIDERS
from gen_art.renderer.surfaces.lamp_shadows import LAMP_POINTS, collider_shadow, lamp_disc, set_bits

F1, F2 = ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)
RING = {"center": (0.3, -0.2, 0.1), "radius": 0.8, "tube": 0.15, "axis": (1.0, 2.0, -0.5)}
TOLERANCE = 1e-5  # to which a hit is sought, m


@cache
def hits_kernel(terms):
    @ti.kernel
    def hits(Q: F1, O: F2, D: F2, out: F1):
        for i in range(out.shape[0]):
            o, d = ti.Vector([O[i, 0], O[i, 1], O[i, 2]]), ti.Vector([D[i, 0], D[i, 1], D[i, 2]])
            t, _, _ = first_hit(terms.kinds, Q, o, d, 0.0, 0.0, 1e9, TOLERANCE, 0.0, ti.i64(ALL_COLLIDERS))
            out[i] = t

    return runtime.kernel(hits)


def hits(terms, o, d):
    out = np.zeros(len(o), np.float32)
    hits_kernel(terms)(terms.numbers(), np.float32(o), np.float32(d), out)
    return out


def hits_by_roots(o, d, center, radius, tube, axis, least=0.0):
    """Where rays, (n, 3) origins and unit directions, first meet the torus beyond the distance `least`; inf for those that do not.

    The roots of (|p|^2 + R^2 - r^2)^2 = 4 R^2 (|p|^2 - (p n)^2) are the eigenvalues of the quartic's companion matrix.
    """
    n, p, d = np.array(axis) / np.linalg.norm(axis), np.array(o) - center, np.array(d)
    b, c = 2 * (p * d).sum(axis=1), (p * p).sum(axis=1)  # |p + t d|^2 = t^2 + b t + c
    u, v = d @ n, p @ n
    k = c + radius**2 - tube**2
    quartic = [2 * b, b * b + 2 * k, 2 * b * k, k * k]  # of t^3 to t^0, without those of the right side
    right = [0 * b, 1 - u * u, b - 2 * u * v, c - v * v]
    companion = np.zeros((len(p), 4, 4))
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    companion[:, 0] = np.stack([4 * radius**2 * y - x for x, y in zip(quartic, right)], axis=1)
    roots = np.linalg.eigvals(companion)
    return np.where((np.abs(roots.imag) < 1e-7) & (roots.real > least), roots.real, np.inf).min(axis=1)


def directions(rng, n):
    d = rng.normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def test_rays_meet_a_torus_where_its_equation_says():
    """Rays from near and from far, also within the plane of the circle and along the axis. Of a ray that grazes only the clear ones count."""
    rng, terms = np.random.default_rng(4), ColliderTerms([Torus(**RING)])
    n = np.array(RING["axis"]) / np.linalg.norm(RING["axis"])
    center = np.array(RING["center"])
    target = center + rng.uniform(-1, 1, (400, 3))
    d = directions(rng, 400)
    d[:100] -= np.outer(d[:100] @ n, n)  # along the plane of the circle, most of them beside it
    d[100:120] = n
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    o = target - d * rng.choice([0.0, 1.0, 30.0], (400, 1))
    outside = np.array([np.hypot(np.linalg.norm(p - n * (p @ n)) - 0.8, p @ n) - 0.15 for p in o - center]) > 0.01
    o, d = o[outside], d[outside]
    true = hits_by_roots(o, d, **RING)
    # a ray is clear if a tube that is wider or narrower by 1 mm moves the hit by less than 20 mm: its slope is at least 0.05
    clear = np.ones(len(o), bool)
    for tube in (0.149, 0.151):
        other = hits_by_roots(o, d, **{**RING, "tube": tube})
        with np.errstate(invalid="ignore"):
            clear &= (np.isinf(true) & np.isinf(other)) | (abs(other - true) < 0.02)
    found = hits(terms, o, d)
    assert clear.mean() > 0.95 and np.isfinite(true).sum() > 60 and (~np.isfinite(true)).sum() > 60
    assert np.array_equal(found[clear] < 1e8, np.isfinite(true[clear]))
    met = clear & np.isfinite(true)
    # the distance of a hit is 1e-5 m at most, that of a place 30 m away is exact to 4e-6 m in float32; a slope of 0.05 makes 20
    # times as much of both
    assert abs(found - true)[met].max() < 20 * (TOLERANCE + 4e-6)


@pytest.mark.parametrize("away", [0.0, 5000.0])
def test_a_cone_meets_a_torus_only_where_the_span_says(away):
    """Also from far away, where a place is known to 5e-4 m, and for a cone that opens faster than the ray is long."""
    rng = np.random.default_rng(5)
    terms = ColliderTerms([Torus(**RING)])
    (kind,) = terms.kinds

    @ti.kernel
    def spans(Q: F1, O: F2, D: F2, C: F2, T: F1, out: F2, gaps: F2):
        q = numbers_of(Q, kind, 0)
        for i in range(out.shape[0]):
            o, d = ti.Vector([O[i, 0], O[i, 1], O[i, 2]]), ti.Vector([D[i, 0], D[i, 1], D[i, 2]])
            span = kind.collider.ray_span(o, d, q, C[i, 0], C[i, 1])
            out[i, 0], out[i, 1] = span[0], span[1]
            for k in range(T.shape[0]):
                gaps[i, k] = kind.collider.distance(o + d * T[k], q, 0) - C[i, 0] - C[i, 1] * T[k]

    o = rng.uniform(-2, 2, (300, 3))
    d = np.array(RING["center"]) + 0.7 * directions(rng, 300) - o
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    d[:30] = np.float32(RING["axis"]) / np.float32(np.linalg.norm(RING["axis"]))
    o -= away * d
    cones = rng.choice([0.0, 0.02, 0.3], (300, 2)) if away == 0.0 else np.zeros((300, 2))
    if away == 0.0:
        cones[40:50, 1], cones[50:60, 1] = 1.0, 3.0
    along = np.linspace(away, away + 6, 400, dtype=np.float32)
    out, gaps = np.zeros((300, 2), np.float32), np.zeros((300, 400), np.float32)
    runtime.kernel(spans)(terms.numbers(), np.float32(o), np.float32(d), np.float32(cones), along, out, gaps)
    meets = gaps <= 0
    within = (along >= out[:, :1]) & (along <= out[:, 1:])
    assert meets.any(1).sum() > 60 and not (meets & ~within).any()
    rays = cones.max(1) == 0
    assert within[rays].mean() < 0.25  # and it is of use


@pytest.mark.parametrize("tube", [0.01, 0.15, 0.6, 0.79])
def test_a_ray_that_leaves_a_torus_has_a_clear_way(tube):
    """From all round it, in all directions whose slope is 0.1 or a little more: as long as said, and not ten times as long."""
    ring = {**RING, "tube": tube}
    terms = ColliderTerms([Torus(**ring)])
    (kind,) = terms.kinds

    @ti.kernel
    def ways(Q: F1, out: F1):
        for i in range(1):
            out[i] = kind.collider.clear_way(numbers_of(Q, kind, 0))

    way = np.zeros(1, np.float32)
    runtime.kernel(ways)(terms.numbers(), way)
    n, center = np.array(RING["axis"]) / np.linalg.norm(RING["axis"]), np.array(RING["center"])
    e = np.cross(n, [0, 0, 1.0])
    e /= np.linalg.norm(e)
    rng, met = np.random.default_rng(8), []
    for about in np.linspace(0, 2 * np.pi, 80):
        normal = np.cos(about) * e + np.sin(about) * n
        across = [np.cross(n, e), np.cross(normal, np.cross(n, e))]
        for way_round, slope in rng.uniform([0, 0.1], [2 * np.pi, 0.15], (30, 2)):
            flat = np.cos(way_round) * across[0] + np.sin(way_round) * across[1]
            d = slope * normal + np.sqrt(1 - slope**2) * flat
            met.append(hits_by_roots([center + 0.8 * e + tube * normal], [d], **ring, least=1e-4)[0])
    assert way[0] <= min(met) < 10 * way[0]


@pytest.mark.parametrize("tangent", [0.005, 0.1])
def test_a_torus_shades_what_is_behind_it_and_itself(tangent):
    terms, (n, center) = ColliderTerms([Torus(**RING)]), (np.array(RING["axis"]), np.array(RING["center"]))
    n = n / np.linalg.norm(n)
    e = np.cross(n, [0, 0, 1.0])
    e /= np.linalg.norm(e)
    f = np.cross(n, e)
    half_pixel, disc = 1e-3, lamp_disc()
    to_lamp = 0.97 * e + 0.1 * f + 0.07 * n
    to_lamp /= np.linalg.norm(to_lamp)
    side = np.cross(to_lamp, n)
    side /= np.linalg.norm(side)
    up = np.cross(side, to_lamp)
    rng = np.random.default_rng(6)
    around, about = rng.uniform(0, 2 * np.pi, (2, 500))
    out = np.cos(around)[:, None] * e + np.sin(around)[:, None] * f
    normal = np.cos(about)[:, None] * out + np.sin(about)[:, None] * n
    lit = normal @ to_lamp > tangent + 0.12
    x = (center + 0.8 * out + (0.15 + 0.5 * half_pixel) * normal)[lit]
    beyond = center + rng.uniform(-1, 1, (200, 1)) * side + rng.uniform(-0.25, 0.25, (200, 1)) * up - 2 * to_lamp
    x = np.concatenate([x, beyond])  # and places that it shades from afar

    @ti.kernel
    def shadows(Q: F1, X: F2, L: F2, D: F2, out: F1):
        to, across = ti.Vector([L[0, 0], L[0, 1], L[0, 2]]), ti.Vector([L[1, 0], L[1, 1], L[1, 2]])
        upwards = ti.Vector([L[2, 0], L[2, 1], L[2, 2]])
        for i in range(out.shape[0]):
            place = ti.Vector([X[i, 0], X[i, 1], X[i, 2]])
            hidden = collider_shadow(
                terms.kinds, Q, place, to, across, upwards, tangent, half_pixel, 0.0, 1e9, D, LAMP_POINTS,
                ti.i64(ALL_COLLIDERS),
            )  # fmt: skip
            out[i] = set_bits(hidden) / ti.cast(LAMP_POINTS, ti.f32)

    found = np.zeros(len(x), np.float32)
    runtime.kernel(shadows)(terms.numbers(), np.float32(x), np.float32([to_lamp, side, up]), np.float32(disc), found)
    true = np.zeros(len(x))
    for du, dv in disc:
        across = side * du + up * dv
        towards = to_lamp + across * tangent
        ray = np.broadcast_to(towards / np.linalg.norm(towards), x.shape)
        true += hits_by_roots(x + across * half_pixel, ray, **RING, least=10 * half_pixel) < np.inf
    true /= LAMP_POINTS
    assert (true > 0.9).sum() > 30 and (true < 0.1).sum() > 60
    # of the lamp's points, two whose rays graze the surface may count either way
    assert abs(found - true).max() <= 2 / LAMP_POINTS


def test_a_torus_is_whole_before_a_camera_without_perspective():
    """Its rays begin a hundred times as far away as the camera is. The ring's area is 4 pi R r."""
    ring = {"radius": 1.0, "tube": 0.2, "axis": [1, 2, 2], "look": {"albedo": "white", "roughness": 1}}
    towards = np.array([1, 2, 2]) / 3
    piece = load_preset(
        {
            "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/30"}, "systems": {"none": {}},
            "colliders": {"torus": ring}, "light": {"direction": (-towards).tolist()},
            "camera": {"position": (20 * towards).tolist(), "target": [0, 0, 0], "height": 3.0, "size": [96, 96]},
        }
    )  # fmt: skip
    (picture, _), *_ = Playback(piece, (96, 96), "f32", None).pictures([0])
    # coverage of a pixel is in quarters at least; their errors along a rim of 400 pixels go both ways
    assert picture[..., 3].mean() * 9.0 == pytest.approx(4 * np.pi * 0.2, rel=0.02)
