"""The keys of `ground:` and of the `look:` of a collider: how a surface is drawn."""

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import MOST_SIZE, Brightness, ColourValue, Fraction, Number, PositiveRange, Whole, Within
from gen_art.preset.files import ImageFile, PresetFile
from gen_art.preset.from_script import model_of
from gen_art.preset.model import Model, about
from gen_art.preset.values import Range

__all__ = [
    "Checker",
    "Finish",
    "Ground",
    "Puddles",
    "Relief",
    "SurfaceImage",
    "SurfaceLook",
    "TRACED_ROUGHNESS",
    "Waves",
    "ground_of",
    "surface_look",
]

TRACED_ROUGHNESS = 0.3  # up to which surfaces reflect each other
_FORMS = (Mapping, str, bool, list, tuple)  # what a script may give for a surface


class Checker(Model):
    """A checker of two colours, along two axes of the world. A number sets the `size`."""

    size: Annotated[float, Within(0, MOST_SIZE, open_low=True)] = about(1.0, "side of a square", unit="m")
    color: ColourValue = about("#303030", "albedo of every other square")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Checker, dict)) else {"size": value}


class SurfaceImage(Model):
    """An image on a surface, repeated. Its colours take the place of the albedo; where it is transparent, the albedo shows.

    It lies along the two axes of the collider that the surface faces least; on a floor its upper side points to -z. On a body it
    lies along the body's axes with its middle on the middle of each side, on a ball along x, y and z, and on cloth with its upper
    left corner on row 0, column 0. A file's name sets the `file`.
    """

    file: Annotated[PresetFile, ImageFile] = about(..., "image in the preset's folder or below")
    size: Annotated[float, Within(0, MOST_SIZE, open_low=True)] = about(1.0, "width of the image", unit="m")
    shifted: bool = about(False, "with `draw: body`, whether each body shows another part of the image")
    ends: Annotated[PresetFile, ImageFile] | None = about(
        None,
        "with `draw: body`, another image of the same width for the two sides across the body's x axis: the end grain of wood",
    )

    short_form = {"type": "string", "description": "the image's file"}

    @property
    def files(self) -> list[PresetFile]:
        """The images that it names."""
        return [self.file] if self.ends is None else [self.file, self.ends]

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (SurfaceImage, dict)) else {"file": value}


class Relief(Model):
    """Heights from the grey values of an image, repeated as an `image` is. They turn the light; the surface itself stays even.

    What is smaller than a pixel makes the surface rougher, and puddles level it.
    """

    file: Annotated[PresetFile, ImageFile] = about(..., "image in the preset's folder or below")
    size: Annotated[float, Within(0, MOST_SIZE, open_low=True)] = about(1.0, "width of the image", unit="m")
    depth: Annotated[float, Within(-MOST_SIZE, MOST_SIZE)] = about(
        0.01, "how far white stands out from black; below 0 it is a hollow", unit="m"
    )

    short_form = {"type": "string", "description": "the image's file"}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Relief, dict)) else {"file": value}


class Puddles(Model):
    """Water in the hollows of a floor: smooth, and the floor around it darker. A number sets the `share`."""

    share: Fraction = about(0.3, "the part of the floor under water")
    size: Annotated[float, Within(0, MOST_SIZE, open_low=True)] = about(1.0, "how far puddles are apart", unit="m")
    damp: Fraction = about(0.5, "how wet the floor between them is: 1 halves its albedo and its roughness")
    seed: Whole = about(0, "another number, other puddles")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Puddles, dict)) else {"share": value}


class Waves(Model):
    """Waves on the water of a `plane` or of the `ground`, which travel as on deep water. A number sets the `slope`.

    The surface itself stays flat: waves turn what it reflects, and where they are smaller than a pixel they make it rougher.
    """

    slope: Annotated[float, Within(0, 0.5)] = about(
        0.05, "root mean square of the slope: 0.02 is a calm lake, 0.1 a breeze, 0.2 a storm"
    )
    length: PositiveRange = about(Range(0.05, 2.0), "lengths of the waves", unit="m")
    direction: Number = about(0.0, "where they run: 0 to +x, 90 to +z", unit="degrees")
    spread: Annotated[float, Within(0, 180)] = about(90.0, "largest angle from that direction", unit="degrees")
    speed: Number = about(1.0, "factor on their speed")
    number: Annotated[int, Field(ge=8, le=256)] = about(
        32, "how many waves are summed: with more of them the water repeats itself less, and takes longer to draw"
    )
    patches: Fraction = about(
        0.0, "how uneven the water is: the standard deviation of the slope from place to place, in slopes"
    )
    patch_size: Annotated[float, Within(0, MOST_SIZE, open_low=True)] = about(
        10.0, "how far calm patches are apart", unit="m"
    )
    seed: Whole = about(0, "another number, other waves")

    short_form = {"type": ["number", "string"]}

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Waves, dict)) else {"slope": value}


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
    image: SurfaceImage | None = about(
        None, "an image instead of the albedo; of looks, for `draw: body` and `draw: cloth` alone"
    )

    short_form = {"type": ["number", "string"]}

    @property
    def files(self) -> list[PresetFile]:
        """The images that it names."""
        return [] if self.image is None else self.image.files

    @classmethod
    def from_short(cls, value: Any) -> Any:
        return value if isinstance(value, (Finish, dict)) else {"roughness": value}


class SurfaceLook(Finish):
    """How a surface is drawn: what it scatters, reflects and emits. A colour sets the `albedo`; `true` takes all defaults."""

    albedo: ColourValue = about("#8c8c8c", "the part of the light that is scattered, by colour")
    checker: Checker | None = about(None, "a checker of the albedo and a second colour")
    relief: Relief | None = about(None, "heights from an image: cobbles, bricks, bark")
    puddles: Puddles | None = about(None, "puddles of water: for a `plane` or the `ground`")
    waves: Waves | None = about(None, "waves on water: for a `plane` or the `ground`")
    mirror: bool = about(
        False,
        "whether it reflects the things of the scene and not the sky alone: for one `plane` or the `ground`; `roughness` "
        "blurs the reflection",
    )
    emission: ColourValue = about("black", "colour of the light that the surface emits")
    emission_intensity: Brightness = about(1.0, "brightness of that light")
    emission_image: SurfaceImage | None = about(
        None,
        "an image of that light, instead of `emission`: lit windows, a sign; `emission_intensity` is a factor on it",
    )

    short_form = {"type": ["boolean", "string", "array"], "description": "true, or a colour: the albedo"}

    @property
    def files(self) -> list[PresetFile]:
        """The images that it names."""
        return super().files + [named.file for named in (self.emission_image, self.relief) if named is not None]

    @model_validator(mode="after")
    def _without_ends(self):
        for key in ("image", "emission_image"):
            image = getattr(self, key)
            if image is not None and image.ends is not None:
                raise UsageError(f"`{key}.ends` is for the `finish` of a look with draw: body")
        return self

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
