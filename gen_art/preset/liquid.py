"""The keys of `liquid:` in a look: what the surface of `draw: surface` is the surface of."""

from typing import Annotated, Any

from gen_art.preset.fields import ColourValue, Positive, Within
from gen_art.preset.model import Model, about

__all__ = ["Liquid"]


class Liquid(Model):
    """What `draw: surface` shows: a liquid that light passes through, or an opaque one. A colour sets the `color`.

    White light that has gone the length `distance` through the liquid has the colour `color`; after twice that length, its
    square (Beer and Lambert). What `scattering` turns aside comes back with the look's `albedo`, as from a matt surface.
    """

    clear: bool = about(
        True, "whether light passes through; an opaque liquid (mud, wax, steel) has the look's `albedo` and `finish`"
    )
    color: ColourValue = about("#e1f8fe", "what remains of white light after `distance`; pure water when left out")
    distance: Positive = about(1.0, "the length after which it is that colour", unit="m")
    scattering: Positive | None = about(
        None, "mean length that light goes before it is scattered, as in milk; it is not when left out", unit="m"
    )
    smoothing: Annotated[float, Within(0, 100)] = about(
        4.0, "radius over which the surface is smoothed, in radii of the particles; 0 shows every particle"
    )

    short_form = {"type": ["string", "array"], "description": "a colour: what remains of white light after 1 m"}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Liquid, dict)) else {"color": value}
