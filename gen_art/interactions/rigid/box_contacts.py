"""Where two boxes touch: the axis of least overlap, then one face clipped by the other, or two edges.

Many pairs at once. Source: Gottschalk, Lin, Manocha (1996), for the separating axes; Sutherland & Hodgman (1974), clipping.
"""

import numpy as np

from gen_art.interactions.rigid.quaternions import cross

__all__ = ["between_boxes"]

_PREFER = 0.02  # of the smaller box: how much less an edge must overlap than a face, to count
_STRICT = 1e-4  # of a face: corners nearer to its rim than that count once
_KEPT = 4  # points of a face, at most
_SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def between_boxes(c1, A1, h1, c2, A2, h2, reach):
    """Contacts of m pairs of boxes (centres (m, 3), axes (m, 3, 3), half sizes (m, 3)) whose gap is below `reach` (m,).

    Returns (pair (k,), point (k, 3), normal (k, 3) from the second to the first, gap (k,), feature (k,)), by pair.
    """
    t = np.einsum("mji,mj->mi", A1, c2 - c1)
    C = np.einsum("mji,mjk->mik", A1, A2)
    size = np.abs(C)
    first = np.abs(t) - h1 - np.einsum("mij,mj->mi", size, h2)
    along = np.einsum("mi,mij->mj", t, C)
    second = np.abs(along) - h2 - np.einsum("mij,mi->mj", size, h1)
    edges = _edge_axes(t, C, size, h1, h2)
    faces = np.concatenate([first, second], 1)
    face, edge = faces.argmax(1), edges.argmax(1)
    rows = np.arange(len(t))
    worst = faces[rows, face]
    small = np.minimum(h1.min(1), h2.min(1))
    crossed = edges[rows, edge] > worst + _PREFER * small
    near = np.maximum(worst, edges.max(1, initial=-np.inf)) < reach
    found = []
    for flip in (False, True):
        k = np.flatnonzero(near & ~crossed & ((face >= 3) == flip))
        if len(k):
            one, two = ((c2, A2, h2), (c1, A1, h1)) if flip else ((c1, A1, h1), (c2, A2, h2))
            found.append(_faces(k, [a[k] for a in one], [a[k] for a in two], face[k] % 3, reach[k], flip))
    k = np.flatnonzero(near & crossed)
    if len(k):
        found.append(_edges(k, [a[k] for a in (c1, A1, h1)], [a[k] for a in (c2, A2, h2)], edge[k], edges[k, edge[k]]))
    if not found:
        return np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, int)
    joined = [np.concatenate(parts) for parts in zip(*found)]
    order = np.lexsort((joined[4], joined[0]))
    return tuple(part[order] for part in joined)


def _edge_axes(t, C, size, h1, h2):
    """Separation along the nine products of edges (m, 9), -inf where they are parallel."""
    separation = []
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            c, d = (j + 1) % 3, (j + 2) % 3
            length = np.sqrt(C[:, a, j] ** 2 + C[:, b, j] ** 2)
            off = t[:, b] * C[:, a, j] - t[:, a] * C[:, b, j]
            width = (
                h1[:, a] * size[:, b, j]
                + h1[:, b] * size[:, a, j]
                + h2[:, c] * size[:, i, d]
                + h2[:, d] * size[:, i, c]
            )
            separation.append(np.where(length > 1e-3, (np.abs(off) - width) / np.maximum(length, 1e-3), -np.inf))
    return np.stack(separation, 1)


def _wide(a):
    return a[:, None]


def _pick(a, at):
    """Along the last axis of a (m, ..., 3), the entry `at` (m,)."""
    where = at.reshape(-1, *[1] * (a.ndim - 1))
    return np.take_along_axis(a, np.broadcast_to(where, (*a.shape[:-1], 1)), -1)[..., 0]


def _faces(pair, one, two, axis, reach, flip):
    """The face of box 1 along `axis` against the face of box 2 that looks at it."""
    (c1, A1, h1), (c2, A2, h2) = one, two
    m = len(pair)
    rows = np.arange(m)
    t = np.einsum("mji,mj->mi", A1, c2 - c1)
    C = np.einsum("mji,mjk->mik", A1, A2)
    way = np.where(t[rows, axis] < 0, -1.0, 1.0)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    tilt = C[rows, axis] * way[:, None]  # of the normal along the axes of box 2
    k = np.abs(tilt).argmax(1)
    p, q = (k + 1) % 3, (k + 2) % 3
    middle = t - (np.sign(tilt[rows, k]) * h2[rows, k])[:, None] * C[rows, :, k]
    ep, eq = C[rows, :, p] * h2[rows, p][:, None], C[rows, :, q] * h2[rows, q][:, None]
    quad = middle[:, None] + _SIGNS[:, :1] * ep[:, None] + _SIGNS[:, 1:] * eq[:, None]  # (m, 4, 3) in box 1's frame
    U, V, Z = _pick(quad, u), _pick(quad, v), _pick(quad, axis) * way[:, None]
    hu, hv, hz = (h1[rows, a] for a in (u, v, axis))
    # corners of face 2 over face 1
    points = [np.stack([U, V, Z], -1)]
    good = [(np.abs(U) <= _wide(hu) * (1 + _STRICT)) & (np.abs(V) <= _wide(hv) * (1 + _STRICT))]
    # edges of face 2 across the rim of face 1
    U2, V2, Z2 = (np.roll(a, -1, 1) for a in (U, V, Z))
    for side in (-1.0, 1.0):
        for a, a2, b, b2, ha, hb, swap in ((U, U2, V, V2, hu, hv, False), (V, V2, U, U2, hv, hu, True)):
            d = a2 - a
            s = (side * _wide(ha) - a) / np.where(np.abs(d) > 1e-12 * _wide(ha), d, np.inf)
            other = b + s * (b2 - b)
            rim = np.broadcast_to(side * _wide(ha), other.shape)
            points.append(np.stack([other, rim, Z + s * (Z2 - Z)] if swap else [rim, other, Z + s * (Z2 - Z)], -1))
            good.append((s > _STRICT) & (s < 1 - _STRICT) & (np.abs(other) < _wide(hb) * (1 - _STRICT)))
    # corners of face 1 under face 2
    pu, pv, qu, qv = (a[rows, b] for a in (ep, eq) for b in (u, v))
    det = pu * qv - pv * qu
    flat = np.abs(det) > 1e-9 * hu * hv
    det = np.where(flat, det, 1.0)
    X, Y = _SIGNS[:, 0] * _wide(hu), _SIGNS[:, 1] * _wide(hv)
    du, dv = X - _wide(middle[rows, u]), Y - _wide(middle[rows, v])
    a, b = (du * _wide(qv) - dv * _wide(qu)) / _wide(det), (dv * _wide(pu) - du * _wide(pv)) / _wide(det)
    zp, zq, zm = (_wide(e[rows, axis] * way) for e in (ep, eq, middle))
    points.append(np.stack([X, Y, zm + a * zp + b * zq], -1))
    good.append((np.abs(a) < 1 - _STRICT) & (np.abs(b) < 1 - _STRICT) & _wide(flat))
    P, ok = np.concatenate(points, 1), np.concatenate(good, 1)
    gap = P[..., 2] - _wide(hz)
    ok &= gap < _wide(reach)
    chosen = _chosen(P, gap, ok)
    row, which = np.nonzero(chosen)
    g = gap[row, which]
    place = np.zeros((len(row), 3))
    n = np.arange(len(row))
    place[n, u[row]], place[n, v[row]] = P[row, which, 0], P[row, which, 1]
    place[n, axis[row]] = way[row] * (hz[row] + 0.5 * g)
    point = c1[row] + np.einsum("mij,mj->mi", A1[row], place)
    normal = A1[row, :, axis[row]] * _wide(way[row]) * (1.0 if flip else -1.0)
    feature = which + 32 * (axis[row] + 3 * flip)
    return pair[row], point, normal, g, feature


def _chosen(P, gap, ok):
    """At most four points of each pair: the deepest, the farthest from it, and those that span most on either side."""
    m = len(P)
    rows = np.arange(m)
    many = ok.sum(1) > _KEPT
    take = ok & ~many[:, None]
    weight = 1 - 1e-6 * np.arange(P.shape[1])  # ties always go the same way
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


def _edges(pair, one, two, edge, gap):
    """One contact between two edges that cross."""
    (c1, A1, h1), (c2, A2, h2) = one, two
    rows = np.arange(len(pair))
    i, j = edge // 3, edge % 3
    a, b = A1[rows, :, i], A2[rows, :, j]
    n = cross(a, b)
    n *= (np.where(((c2 - c1) * n).sum(1) < 0, -1.0, 1.0) / np.sqrt((n * n).sum(1)))[:, None]  # from 1 to 2
    s1, s2 = np.sign(np.einsum("mi,mij->mj", n, A1)), np.sign(np.einsum("mi,mij->mj", n, A2))
    s1[rows, i], s2[rows, j] = 0.0, 0.0
    p = c1 + np.einsum("mij,mj->mi", A1, s1 * h1)
    q = c2 - np.einsum("mij,mj->mi", A2, s2 * h2)
    d, ab = q - p, (a * b).sum(1)
    det = np.maximum(1 - ab * ab, 1e-9)
    s = ((d * a).sum(1) - ab * (d * b).sum(1)) / det
    t = (ab * (d * a).sum(1) - (d * b).sum(1)) / det
    point = 0.5 * (p + s[:, None] * a + q + t[:, None] * b)
    return pair, point, -n, gap, 256 + edge
