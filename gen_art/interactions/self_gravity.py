"""Mutual gravity."""

from gen_art.errors import UsageError
from gen_art.interactions.base import interaction
from gen_art.interactions.direct_sum import DirectSum
from gen_art.registry import param

__all__ = ["SelfGravity"]


@interaction("self_gravity")
class SelfGravity(DirectSum):
    """Every particle attracts every other, with Plummer softening.

    a_i = G sum_j m_j (x_j - x_i) / s^3,  s^2 = abs(x_j - x_i)^2 + softening^2;  U = -G sum_{i<j} m_i m_j / s

    G : constant of gravitation in the preset's units, 6.6743e-11 m^3/kg/s^2 when left out
    softening : m, >= 0
    method : "direct", all pairs; "tree", distant cells as a whole: forces to about 2 parts in a thousand, momentum to round-off;
        "auto", the tree beyond 14,000 particles
    theta : of the tree, 0.05 to 1: largest size of two cells, seen from each other, that act as a whole; smaller is more exact
    order : of the tree's expansions, 2 to 6
    levels : 0 for one step for all; k lets each particle halve its own step up to k times, until it lasts at most
        0.2 sqrt(softening / abs(a_i)). Then only those whose step ends are summed. It needs a softening, and leapfrog
    sources : the name of another system, whose field then acts without reaction (recorded in the ledger)
    Conservative and reciprocal, unless `sources` is given. The tree's forces are not an exact gradient: they conserve energy to
    their own accuracy.
    Source: Dehnen & Read, Eur. Phys. J. Plus 126, 55 (2011).
    """

    G: float = param(
        6.67430e-11, unit="m^3/(kg s^2)", min=0, doc="constant of gravitation; units.G of the preset when left out"
    )
    softening: float = param(0.0, unit="m", min=0)
    method: str = param("auto", choices=("auto", "direct", "tree"))
    theta: float = param(0.6, min=0.05, max=1, doc="opening of the tree; less is more exact")
    order: int = param(5, min=2, max=6, doc="of the tree's expansions; more is more exact")
    levels: int = param(0, min=0, max=10, doc="halvings of the step for particles that need shorter ones")
    sources: str = param(None, doc="another system that attracts this one, without reaction")

    def prepare(self):
        super().prepare()
        if self.values["levels"] and self.values["softening"] <= 0.0:
            raise UsageError("self_gravity: levels need a softening, which says how short the steps must be")

    @property
    def law(self):
        return self.values["G"], -2.0, self.values["softening"]
