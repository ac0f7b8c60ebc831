"""The keys of `black_hole:`, which bends light."""

from gen_art.preset.fields import Size, Vector
from gen_art.preset.model import Model, about

__all__ = ["BlackHole"]


class BlackHole(Model):
    """A black hole, which bends the light of sprites, stars and sky by Schwarzschild's metric; a number sets the `radius`.

    Its shadow is a black ball of sqrt(27) / 2 = 2.6 radii, around which everything behind it is seen as a ring. It bends light
    alone: what pulls is a force such as `point_gravity`, and a collider with `action: kill` takes away what reaches the horizon.
    """

    center: Vector = about((0.0, 0.0, 0.0), "its middle")
    radius: Size = about(..., "radius of the horizon, 2 G M / c^2", unit="m")

    short_form = {"type": ["number", "string"], "description": "the radius"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, (BlackHole, dict)) else {"radius": value}
