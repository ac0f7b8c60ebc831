"""Contacts between boxes, many pairs at once: the axis of least overlap, then one face clipped by the other, or two edges.

Sources: Gottschalk, Lin, Manocha (1996) for the separating axes; Sutherland & Hodgman (1974) for clipping.
"""

import numpy as np

from gen_art.interactions.rigid.small_matrices import apply, apply_transposed, compose, cross, dot, norm, transposed

__all__ = ["contacts_between_boxes"]

_EDGE_BIAS = 0.02  # relative to the smaller box: an edge axis is taken only if it overlaps by so much less than a face
_BORDER = 1e-4  # relative to a face: points nearer to its border than that are found once
_MAX_POINTS = 4  # contacts of one pair of faces
_FLIPPED = 3  # added to the axis in the number of a feature when the face belongs to the second box
_MAX_CANDIDATES = 32  # points of one pair of faces, before the choice
_EDGE_FEATURES = 256  # the number of the first feature that is a pair of edges
_SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def contacts_between_boxes(c1, A1, h1, c2, A2, h2, margin):
    """Contacts of m pairs of boxes whose gap is below `margin` (m,), m.

    c1, c2 : (m, 3) m, centres
    A1, A2 : (m, 3, 3), columns are the boxes' axes
    h1, h2 : (m, 3) m, half sizes
    Returns (pair (k,), point (k, 3), normal (k, 3) from the second to the first, gap (k,), feature (k,)), ordered by pair.
    """
    t = apply_transposed(A1, c2 - c1)
    C = compose(transposed(A1), A2)
    abs_C = np.abs(C)
    first = np.abs(t) - h1 - apply(abs_C, h2)
    t2 = apply_transposed(C, t)
    second = np.abs(t2) - h2 - apply_transposed(abs_C, h1)
    edges = _edge_separations(t, C, abs_C, h1, h2)
    faces = np.concatenate([first, second], 1)  # separations along the faces' normals, (m, 6)
    face, edge = faces.argmax(1), edges.argmax(1)
    rows = np.arange(len(t))
    largest = faces[rows, face]
    smaller = np.minimum(h1.min(1), h2.min(1))
    by_edges = edges[rows, edge] > largest + _EDGE_BIAS * smaller
    near = np.maximum(largest, edges.max(1, initial=-np.inf)) < margin
    found = []
    one, two = (c1, A1, h1), (c2, A2, h2)
    for flip in (False, True):
        k = np.flatnonzero(near & ~by_edges & ((face >= 3) == flip))
        if len(k):
            reference, other = (two, one) if flip else (one, two)
            found.append(
                _face_contacts(k, [a[k] for a in reference], [a[k] for a in other], face[k] % 3, margin[k], flip)
            )
    k = np.flatnonzero(near & by_edges)
    if len(k):
        found.append(_edge_contacts(k, [a[k] for a in one], [a[k] for a in two], edge[k], edges[k, edge[k]]))
    if not found:
        return np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, int)
    joined = [np.concatenate(parts) for parts in zip(*found)]
    order = np.lexsort((joined[4], joined[0]))
    return tuple(part[order] for part in joined)


def _edge_separations(t, C, abs_C, h1, h2):
    """Separations along the nine cross products of edges (m, 9), -inf where the edges are parallel."""
    separation = []
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            c, d = (j + 1) % 3, (j + 2) % 3
            length = np.sqrt(C[:, a, j] ** 2 + C[:, b, j] ** 2)
            off = t[:, b] * C[:, a, j] - t[:, a] * C[:, b, j]
            width = (
                h1[:, a] * abs_C[:, b, j]
                + h1[:, b] * abs_C[:, a, j]
                + h2[:, c] * abs_C[:, i, d]
                + h2[:, d] * abs_C[:, i, c]
            )
            separation.append(np.where(length > 1e-3, (np.abs(off) - width) / np.maximum(length, 1e-3), -np.inf))
    return np.stack(separation, 1)


def _column(a):
    return a[:, None]


def _pick(a, at):
    """Entry `at` (m,) along the last axis of a (m, ..., 3)."""
    where = at.reshape(-1, *[1] * (a.ndim - 1))
    return np.take_along_axis(a, np.broadcast_to(where, (*a.shape[:-1], 1)), -1)[..., 0]


def _face_contacts(pair, one, two, axis, margin, flip):
    """Contacts of the face of box 1 along `axis` with the face of box 2 that is turned towards it."""
    (c1, A1, h1), (c2, A2, h2) = one, two
    m = len(pair)
    rows = np.arange(m)
    t = apply_transposed(A1, c2 - c1)
    C = compose(transposed(A1), A2)
    sign = np.where(t[rows, axis] < 0, -1.0, 1.0)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    normal2 = C[rows, axis] * sign[:, None]  # the normal of face 1 in the axes of box 2
    k = np.abs(normal2).argmax(1)
    p, q = (k + 1) % 3, (k + 2) % 3
    middle = t - (np.sign(normal2[rows, k]) * h2[rows, k])[:, None] * C[rows, :, k]
    ep, eq = C[rows, :, p] * h2[rows, p][:, None], C[rows, :, q] * h2[rows, q][:, None]
    quad = middle[:, None] + _SIGNS[:, :1] * ep[:, None] + _SIGNS[:, 1:] * eq[:, None]  # (m, 4, 3) in box 1's frame
    U, V, Z = _pick(quad, u), _pick(quad, v), _pick(quad, axis) * sign[:, None]
    hu, hv, hz = (h1[rows, a] for a in (u, v, axis))
    # corners of face 2 over face 1
    points = [np.stack([U, V, Z], -1)]
    good = [(np.abs(U) <= _column(hu) * (1 + _BORDER)) & (np.abs(V) <= _column(hv) * (1 + _BORDER))]
    # edges of face 2 across the border of face 1
    U2, V2, Z2 = (np.roll(a, -1, 1) for a in (U, V, Z))
    for side in (-1.0, 1.0):
        for a, a2, b, b2, ha, hb, swap in ((U, U2, V, V2, hu, hv, False), (V, V2, U, U2, hv, hu, True)):
            d = a2 - a
            s = (side * _column(ha) - a) / np.where(np.abs(d) > 1e-12 * _column(ha), d, np.inf)
            other = b + s * (b2 - b)
            border = np.broadcast_to(side * _column(ha), other.shape)
            points.append(
                np.stack([other, border, Z + s * (Z2 - Z)] if swap else [border, other, Z + s * (Z2 - Z)], -1)
            )
            good.append((s > _BORDER) & (s < 1 - _BORDER) & (np.abs(other) < _column(hb) * (1 - _BORDER)))
    # corners of face 1 under face 2
    pu, pv, qu, qv = (a[rows, b] for a in (ep, eq) for b in (u, v))
    det = pu * qv - pv * qu
    regular = np.abs(det) > 1e-9 * hu * hv
    det = np.where(regular, det, 1.0)
    X, Y = _SIGNS[:, 0] * _column(hu), _SIGNS[:, 1] * _column(hv)
    du, dv = X - _column(middle[rows, u]), Y - _column(middle[rows, v])
    a, b = (du * _column(qv) - dv * _column(qu)) / _column(det), (dv * _column(pu) - du * _column(pv)) / _column(det)
    zp, zq, zm = (_column(e[rows, axis] * sign) for e in (ep, eq, middle))
    points.append(np.stack([X, Y, zm + a * zp + b * zq], -1))
    good.append((np.abs(a) < 1 - _BORDER) & (np.abs(b) < 1 - _BORDER) & _column(regular))
    P, ok = np.concatenate(points, 1), np.concatenate(good, 1)
    gap = P[..., 2] - _column(hz)
    ok &= gap < _column(margin)
    chosen = _choose_points(P, gap, ok)
    row, which = np.nonzero(chosen)
    g = gap[row, which]
    place = np.zeros((len(row), 3))
    n = np.arange(len(row))
    place[n, u[row]], place[n, v[row]] = P[row, which, 0], P[row, which, 1]
    place[n, axis[row]] = sign[row] * (hz[row] + 0.5 * g)
    point = c1[row] + apply(A1[row], place)
    normal = A1[row, :, axis[row]] * _column(sign[row]) * (1.0 if flip else -1.0)
    feature = which + _MAX_CANDIDATES * (axis[row] + _FLIPPED * flip)
    return pair[row], point, normal, g, feature


def _choose_points(P, gap, ok):
    """At most four points of each pair: the deepest, the farthest from it, and on either side the one of the largest triangle."""
    m = len(P)
    rows = np.arange(m)
    many = ok.sum(1) > _MAX_POINTS
    take = ok & ~many[:, None]
    weight = 1 - 1e-6 * np.arange(P.shape[1])  # decides between equal candidates, always in the same way
    flat = np.where(ok[..., None], P[..., :2], 0.0)
    width = np.maximum(np.abs(flat).max((1, 2)), 1e-300)
    flat /= width[:, None, None]
    a = np.where(ok, 1e-5 * np.abs(flat).sum(-1) * weight - gap / width[:, None], -np.inf).argmax(1)
    d = flat - flat[rows, a][:, None]
    b = np.where(ok, (d * d).sum(-1) * weight, -1.0).argmax(1)
    e = flat[rows, b] - flat[rows, a]
    area = e[:, None, 0] * d[..., 1] - e[:, None, 1] * d[..., 0]
    c = np.where(ok, area * weight, -np.inf).argmax(1)
    f = np.where(ok, -area * weight, -np.inf).argmax(1)
    for which in (a, b, c, f):
        take[rows[many], which[many]] = True
    return take & ok


def _edge_contacts(pair, one, two, edge, gap):
    """One contact between two crossing edges."""
    (c1, A1, h1), (c2, A2, h2) = one, two
    rows = np.arange(len(pair))
    i, j = edge // 3, edge % 3
    a, b = A1[rows, :, i], A2[rows, :, j]
    n = cross(a, b)
    n *= (np.where(dot(c2 - c1, n) < 0, -1.0, 1.0) / norm(n))[:, None]  # from 1 to 2
    s1, s2 = np.sign(apply_transposed(A1, n)), np.sign(apply_transposed(A2, n))
    s1[rows, i], s2[rows, j] = 0.0, 0.0
    p = c1 + apply(A1, s1 * h1)
    q = c2 - apply(A2, s2 * h2)
    d, ab = q - p, dot(a, b)
    det = np.maximum(1 - ab * ab, 1e-9)
    s = (dot(d, a) - ab * dot(d, b)) / det
    t = (ab * dot(d, a) - dot(d, b)) / det
    point = 0.5 * (p + s[:, None] * a + q + t[:, None] * b)
    return pair, point, -n, gap, _EDGE_FEATURES + edge
