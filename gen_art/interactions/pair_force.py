"""A power law of the distance between all pairs of particles."""

from gen_art.interactions.base import interaction
from gen_art.interactions.direct_sum import DirectSum
from gen_art.registry import param

__all__ = ["PairForce"]


@interaction("pair_force")
class PairForce(DirectSum):
    """All pairs of particles attract (strength > 0) or repel (< 0) by a power of their softened distance.

    a_i = -strength sum_j m_j s^(exponent - 1) (x_i - x_j),  s^2 = abs(x_i - x_j)^2 + softening^2
    U = strength sum_{i<j} m_i m_j s^(exponent + 1) / (exponent + 1), or m_i m_j strength ln s for exponent -1
    with per_charge: charges in place of both masses, and a_i divided by m_i

    strength : N m^-exponent / kg^2, or / C^2
    exponent : -6 to 6
    softening : m, >= 0
    sources : the name of another system, whose field then acts without reaction (recorded in the ledger)
    Conservative and reciprocal, unless `sources` is given. Source: Landau & Lifshitz, Mechanics, section 14.
    """

    strength: float = param(1.0)
    exponent: float = param(-2.0, min=-6, max=6)
    softening: float = param(0.0, unit="m", min=0)
    per_charge: bool = param(False, doc="between charges instead of masses")
    sources: str = param(None, doc="another system that acts on this one, without reaction")

    @property
    def law(self):
        return self.values["strength"], self.values["exponent"], self.values["softening"]

    @property
    def amount(self):
        return "charge" if self.values["per_charge"] else "mass"
