"""The medium that drag acts against: one velocity field u(x, t), the sum of named terms."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.forces.base import FORCES, Force
from gen_art.forces.curl_noise import CurlNoise
from gen_art.forces.wind import Wind

__all__ = ["Medium"]


class Medium:
    """A velocity field u(x, t), the sum of its terms, and the density of the fluid.

    density : kg/m^3, >= 0
    wind : (3,) m/s, or a Wind
    curl_noise : a CurlNoise, a mapping of its parameters, or a list of either
    vortices : a list of Vortex
    field : any force whose vectors are taken as velocities, or a list
    Raises UsageError for a term that is not a vector field.
    """

    def __init__(
        self,
        density: float = 0.0,
        wind: Force | Sequence[float] | None = None,
        curl_noise: Force | Mapping[str, Any] | Sequence[Force | Mapping[str, Any]] | None = None,
        vortices: Force | Iterable[Force] = (),
        field: Force | Iterable[Force] = (),
    ) -> None:
        self.density = arguments.number("a medium's density", density, "kg/m^3", low=0.0)
        terms: list[Force] = []
        if wind is not None:
            terms.append(wind if isinstance(wind, Force) else Wind(arguments.vector("wind", wind, "m/s")))
        if curl_noise is not None:
            noises: Any = curl_noise if isinstance(curl_noise, (list, tuple)) else [curl_noise]
            terms += [_noise(noise) for noise in noises]
        for name, extra in (("vortices", vortices), ("field", field)):
            given = [extra] if isinstance(extra, Force) else extra
            terms += arguments.instances(name, given, Force, "ga.forces.Vortex(...)")
        for term in terms:
            if not isinstance(term, Force) or not term.provides("acceleration"):
                raise UsageError(
                    f"{arguments.shown(term)} is not a vector field and cannot move a medium; fields: {', '.join(fields())}"
                )
        self.terms = tuple(terms)

    def __repr__(self):
        return f"Medium(density={self.density}, terms={self.terms!r})"


def _noise(given: Any) -> Force:
    if isinstance(given, Mapping):
        return CurlNoise(**{arguments.text("a parameter of curl_noise", key): value for key, value in given.items()})
    if not isinstance(given, Force):
        raise UsageError(
            f"curl_noise must be a ga.forces.CurlNoise, or a mapping of its parameters, not {arguments.shown(given)}"
        )
    return given


def fields() -> list[str]:
    """The names of the registered forces that can be terms of a medium."""
    return [name for name, cls in FORCES.classes.items() if callable(getattr(cls, "acceleration", None))]
