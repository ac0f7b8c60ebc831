"""The keys of `ground:` and of the `look:` of a collider: how a surface is drawn."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator

from gen_art.preset.fields import MOST_SIZE, ColourValue, Fraction, Light, Number, Within
from gen_art.preset.from_script import model_of
from gen_art.preset.model import Model, about

__all__ = ["Checker", "Finish", "Ground", "SurfaceLook", "ground_of", "surface_look"]

_FORMS = (Mapping, str, bool, list, tuple)  # what a script may give for a surface


class Checker(Model):
    """A checker of two colours, along two axes of the world. A number sets the `size`."""

    size: Annotated[float, Within(0, MOST_SIZE, open_low=True)] = about(1.0, "side of a square", unit="m")
    color: ColourValue = about("#303030", "albedo of every other square")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Checker, dict)) else {"size": value}


class Finish(Model):
    """How smooth a surface is: light is scattered evenly (Lambert) below a layer that reflects as Fresnel's formulas say.

    A number sets the `roughness`.
    """

    roughness: Fraction = about(
        0.7, "roughness of the reflecting layer: 0 is a mirror, 0.3 satin, 1 has no visible highlight"
    )
    ior: Annotated[float, Within(1, 5)] = about(
        1.5, "refractive index, which sets how much is reflected: 1 nothing, 1.33 water, 1.5 paint, 2.4 diamond"
    )
    metal: Fraction = about(0.0, "1 for a metal, which reflects its albedo's colour and scatters nothing")
    transmission: Fraction = about(
        0.0,
        "the part of what is not reflected that goes through and is refracted, instead of being scattered: 1 is clear glass",
    )
    attenuation_distance: Annotated[float, Within(0, MOST_SIZE, open_low=True)] | None = about(
        None, "the length inside after which the albedo's part of the light is left; when left out, all of it", unit="m"
    )
    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Finish, dict)) else {"roughness": value}


class SurfaceLook(Finish):
    """How a surface is drawn: what it scatters, reflects and emits. A colour sets the `albedo`; `true` takes all defaults."""

    albedo: ColourValue = about("#8c8c8c", "the part of the light that is scattered, by colour")
    checker: Checker | None = about(None, "a checker of the albedo and a second colour")
    mirror: bool = about(
        False,
        "whether it reflects the things of the scene and not the sky alone: for one `plane` or the `ground`; `roughness` "
        "blurs the reflection",
    )
    emission: ColourValue = about("black", "colour of the light that the surface emits")
    emission_intensity: Light = about(1.0, "brightness of that light")

    short_form = {"type": ["boolean", "string", "array"], "description": "true, or a colour: the albedo"}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        if value is True:
            return {}
        return value if isinstance(value, (SurfaceLook, dict)) else {"albedo": value}


class Ground(SurfaceLook):
    """A level floor without end. It is only seen; a `plane` under `colliders:` with a `look:` is one that particles also meet.

    A colour sets the `albedo`, `true` takes all defaults.
    """

    height: Number = about(0.0, "where it lies: y = height", unit="m")


def _ground(value):
    return None if value is False else value


GroundValue = Annotated[Ground | None, BeforeValidator(_ground)]


def surface_look(value: Any) -> SurfaceLook | None:
    """The look of a collider from what a script gives: a ga.SurfaceLook, a mapping of its keys, a colour, true or None.

    Raises UsageError for anything else.
    """
    return model_of(SurfaceLook, "look", value, _FORMS)


def ground_of(value: Any) -> Ground | None:
    """The ground from what a script gives: a ga.Ground, a mapping of its keys, a colour, true or None. Raises UsageError."""
    return model_of(Ground, "ground", value, _FORMS)
