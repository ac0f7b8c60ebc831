"""Where bundles of rays cross triangles, without gaps between triangles that share an edge.

In a frame whose third axis z points along a bundle, ray D (two numbers) passes at depth z through (D_x c, D_y c), where c is z
for the rays of a perspective camera, 1 for parallel rays, and the radius of the cone at z for the points of a lamp's disc. A
corner p of a triangle then lies at p - D c_p beside the ray, and the edge from q to r passes it on the side

    E(D) = (q - D c_q) x (r - D c_r) = q x r + D_x (c_r q_y - c_q r_y) + D_y (c_q r_x - c_r q_x),

linear in D. The ray crosses the triangle where the three E have one sign or are 0; E / sum of E are the weights of the corners
opposite. For the same edge of the next triangle, from r to q, each product is the same and E changes its sign exactly, so a
ray that passes between two triangles would need an E that is both above and below 0: there are no gaps.
Source: Woop, Benthin, Wald, Watertight Ray/Triangle Intersection, JCGT 2013, in a form for bundles of rays.

The one-letter names in kernels are in docs/glossary.md.
"""

from gen_art.backend.runtime import ti

__all__ = ["corner", "depth_of", "edge_functions", "edges_at", "triangle_crossed"]


@ti.func
def corner(V: ti.template(), i, k):
    """The three numbers of row i of V from column k on."""
    return ti.Vector([V[i, k], V[i, k + 1], V[i, k + 2]])


@ti.func
def edge_functions(p, q, r, c):
    """(3, 3): row k holds E, and its changes with D_x and D_y, of the edge opposite to corner k.

    p, q, r : (3,) the corners, relative to the ray D = 0
    c : (3,) of the corners
    """
    return ti.Matrix(
        [
            [q[0] * r[1] - r[0] * q[1], c[2] * q[1] - c[1] * r[1], c[1] * r[0] - c[2] * q[0]],
            [r[0] * p[1] - p[0] * r[1], c[0] * r[1] - c[2] * p[1], c[2] * p[0] - c[0] * r[0]],
            [p[0] * q[1] - q[0] * p[1], c[1] * p[1] - c[0] * q[1], c[0] * q[0] - c[1] * p[0]],
        ]
    )


@ti.func
def edges_at(E: ti.template(), x, y):
    """(3,): the three E for the ray D = (x, y)."""
    return ti.Vector(
        [
            E[0, 0] + (E[0, 1] * x + E[0, 2] * y),
            E[1, 0] + (E[1, 1] * x + E[1, 2] * y),
            E[2, 0] + (E[2, 1] * x + E[2, 2] * y),
        ]
    )


@ti.func
def triangle_crossed(e):
    """Whether a ray whose edge functions are e crosses the triangle; one that is seen edge-on is not crossed."""
    return (e.min() >= 0.0 or e.max() <= 0.0) and e[0] + e[1] + e[2] != 0.0


@ti.func
def depth_of(e, p, q, r):
    """The depth z at which a ray whose edge functions are e crosses the plane of a triangle."""
    return (e[0] * p[2] + e[1] * q[2] + e[2] * r[2]) / (e[0] + e[1] + e[2])
