"""Mutual gravity by direct summation."""

from gen_art.interactions.base import interaction
from gen_art.interactions.direct import DirectSum
from gen_art.registry import param

__all__ = ["SelfGravity"]


@interaction("self_gravity")
class SelfGravity(DirectSum):
    """Every particle attracts every other, softened after Plummer.

    a_i = G sum_j m_j (x_j - x_i) / s^3,  s^2 = abs(x_j - x_i)^2 + softening^2;  U = -G sum_{i<j} m_i m_j / s

    G : constant of gravitation in the preset's units, 6.6743e-11 m^3/kg/s^2 when left out     softening : m, >= 0
    method : "direct", every pair, or "auto", which is "direct" for now     theta, order : opening angle and order, for a tree
    sources : the name of another system, whose field then acts without reaction (booked in the ledger)
    Conservative and reciprocal, unless `sources` is given. Source: Dehnen & Read, Eur. Phys. J. Plus 126, 55 (2011).
    """

    G: float = param(6.67430e-11, min=0, doc="constant of gravitation; units.G of the preset when left out")
    softening: float = param(0.0, unit="m", min=0)
    method: str = param("direct", choices=("direct", "tree", "auto"))
    theta: float = param(0.7, min=0, max=1.5)
    order: int = param(1, min=0, max=4)
    sources: str = param(None, doc="another system that attracts this one, without reaction")

    @property
    def law(self):
        return self.values["G"], -2.0, self.values["softening"]
