"""Coulomb's law between the particles' charges."""

from gen_art.interactions.base import interaction
from gen_art.interactions.direct_sum import DirectSum
from gen_art.registry import param

__all__ = ["Coulomb"]


@interaction("coulomb")
class Coulomb(DirectSum):
    """Like charges repel, unlike charges attract, with Plummer softening.

    a_i = k q_i / m_i sum_j q_j (x_i - x_j) / s^3,  s^2 = abs(x_i - x_j)^2 + softening^2;  U = k sum_{i<j} q_i q_j / s

    k : N m^2/C^2, 1 / (4 pi epsilon_0) when left out
    softening : m, >= 0
    method : "direct", all pairs; "tree", distant cells as a whole: forces to about 2 parts in a thousand, momentum to round-off;
        "auto", the tree beyond 14,000 particles
    theta : of the tree, 0.05 to 1: largest size of two cells, seen from each other, that act as a whole; smaller is more exact
    order : of the tree's expansions, 2 to 6
    sources : the name of another system, whose field then acts without reaction (recorded in the ledger)
    Conservative and reciprocal, unless `sources` is given; magnetism and retardation are left out. Source: CODATA 2018.
    """

    k: float = param(8.9875517923e9, unit="N m^2/C^2")
    softening: float = param(0.0, unit="m", min=0)
    method: str = param("auto", choices=("auto", "direct", "tree"))
    theta: float = param(0.6, min=0.05, max=1, doc="opening of the tree; less is more exact")
    order: int = param(5, min=2, max=6, doc="of the tree's expansions; more is more exact")
    sources: str = param(None, doc="another system whose charges act on this one, without reaction")
    weight = "charge"

    @property
    def law(self):
        return -self.values["k"], -2.0, self.values["softening"]
