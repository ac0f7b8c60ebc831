"""What a look says, as tables and numbers for the kernel that shades: run-time data, so that no change of a number or colour
compiles anything.
"""

import math
from dataclasses import dataclass

import numpy as np

from gen_art.errors import UsageError
from gen_art.preset.colour_names import Gradient
from gen_art.preset.look import BY, Color, Look, Ramp
from gen_art.preset.values import Curve
from gen_art.registry import suggest
from gen_art.renderer.camera import CameraView
from gen_art.renderer.colour import TABLE, blackbody, gradient_table, planck_luminance
from gen_art.renderer.sprite import AREA, KINDS
from gen_art.renderer.sprite_image import texels

__all__ = ["QUANTITIES", "RAMPS", "RANDOM", "SOFT", "LookTables", "numbers"]

QUANTITIES = len(BY)  # what a ramp may go by, in the order of BY; attributes follow, a place for each ramp
RANDOM = BY.index("random")
SIZE, INTENSITY, OPACITY, KELVIN, COLOR, ALBEDO = range(6)
RAMPS = 6

# run-time numbers of the kernel
(
    POSITION, _PY, _PZ, AXES, *_rest,
) = range(12)  # fmt: skip
SCALE, ORTHOGRAPHIC, NEAR, FAR, WIDTH, ROWS, TIME, SHUTTER = range(12, 20)
FOG_START, FOG_RATE, FOG_RED, FOG_GREEN, FOG_BLUE = range(20, 25)
KIND, SIZE_MODE, SIZE_VALUE, BLEND, CONSERVE, FALLOFF = range(25, 31)
STROBE_LO, STROBE_HI, DUTY, FILM_TIME, RAW, LIT, WEIGHT, EMITS = range(31, 39)
LENS, FOCUS, AREA_OF, RIBBON, SNAP = range(39, 44)
NUMBERS = 44
SOFT = 1.5  # a disc's reach over its radius


def _domain(ramp: Ramp) -> tuple[float, float]:
    """The values of the quantity at the two ends of the table."""
    first, last = ramp.curve.points[0][0], ramp.curve.points[-1][0]
    if ramp.range is not None:
        span = ramp.range.hi - ramp.range.lo
        return ramp.range.lo + first * span, ramp.range.lo + last * span
    return first, last


def _samples(curve: Curve) -> np.ndarray:
    xs, ys = zip(*curve.points)
    return np.interp(np.linspace(xs[0], xs[-1], TABLE), xs, ys)


def _ramp(k: int, by: str, low: float, high: float, channels: dict[str, int]) -> tuple[float, float, float, float]:
    """(place of the quantity, low, 1 / span, channel of an attribute or -1)"""
    scale = 1.0 / (high - low) if high > low else 0.0
    if by in channels and (by not in BY or channels[by] > 9):
        return QUANTITIES + k, low, scale, channels[by]
    if by in BY:
        return BY.index(by), low, scale, -1.0
    known = [*BY, *channels]
    raise UsageError(f"a look cannot go by '{by}'{suggest(by, known)}; known are {', '.join(known)}")


@dataclass(frozen=True)
class LookTables:
    """A look as tables: ramps (6, 4) as `_ramp` gives them; curves (6, 256); colours (rows, 256, 4): row 0 is the black
    body, then albedo and emission by tag. All float32.
    """

    look: Look
    ramps: np.ndarray
    curves: np.ndarray
    colours: np.ndarray
    tags: tuple[str, ...]

    @classmethod
    def of(cls, look: Look, channels: dict[str, int]) -> "LookTables":
        """The tables of a look for a system with these attribute rows. UsageError for a quantity it does not have."""
        emission = look.emission
        plain = Ramp()
        kelvin = emission.blackbody if emission and emission.blackbody else None
        color = emission.color if emission and emission.color else Color()
        table = [look.size, emission.intensity if emission else plain, look.opacity, kelvin or plain]
        ramps, curves = np.zeros((RAMPS, 4), np.float32), np.ones((RAMPS, TABLE), np.float32)
        for k, ramp in enumerate(table):
            ramps[k] = _ramp(k, ramp.by, *_domain(ramp), channels)
            curves[k] = _samples(ramp.curve)
        for k, spec in ((COLOR, color), (ALBEDO, look.albedo)):
            low, high = (spec.range.lo, spec.range.hi) if spec.range else (0.0, 1.0)
            ramps[k] = _ramp(k, spec.by, low, high, channels)
        tags = tuple(color.tags)
        gradients: list[Gradient] = [look.albedo.gradient, color.gradient, *(color.tags[t] for t in tags)]
        colours = np.ones((1 + len(gradients), TABLE, 4), np.float32)
        if kelvin:
            temperatures = np.maximum(_samples(kelvin.curve), 100.0)
            relative = planck_luminance(temperatures) / planck_luminance(temperatures.max())
            colours[0, :, :3] = blackbody(temperatures) * (relative**emission.planck)[:, None]
        for row, gradient in enumerate(gradients):
            colours[1 + row, :, :3] = gradient_table(gradient)
        for k, first, last in ((ALBEDO, 1, 2), (COLOR, 2, len(colours))):
            if (colours[first:last] == colours[first:last, :1]).all():
                ramps[k, 2] = 0.0
        return cls(look, ramps, curves, colours, tags)

    def rows(self, sources) -> np.ndarray:
        """The table row of the emission's colour for each source (an object with a `tag`)."""
        known = {tag: 3 + k for k, tag in enumerate(self.tags)}
        return np.array([known.get(getattr(s, "tag", None), 2) for s in sources] or [2], dtype=np.int32)


def numbers(
    shading: LookTables,
    view: CameraView,
    size,
    time: float,
    film_time: float,
    shutter: float,
    raw: bool,
    weight: float = 1.0,
    width: float = 1.0,
) -> np.ndarray:
    """The kernel's run-time numbers (float64). `weight` scales the light, `width` sizes; `raw` makes every particle's light 1."""
    look = shading.look
    q = np.zeros(NUMBERS)
    q[POSITION : POSITION + 3] = view.position
    q[AXES : AXES + 9] = view.axes.reshape(-1)
    q[SCALE], q[ORTHOGRAPHIC] = view.scale(size[1]), view.height is not None
    q[NEAR], q[FAR] = (-np.inf if view.height else view.near), view.far
    q[WIDTH], q[ROWS] = size
    q[TIME], q[FILM_TIME] = time, film_time
    q[SHUTTER] = shutter if look.length is None or look.ribbon is not None else look.length
    if view.fog:
        q[FOG_START], q[FOG_RATE] = view.fog[0], 1.0 / view.fog[1]
        q[FOG_RED : FOG_RED + 3] = view.fog[2]
    q[KIND] = KINDS[look.draw]
    q[AREA_OF] = {"sphere": math.pi, "picture": 4.0 * texels(look.picture.image.place)[1] if look.picture else 0.0}.get(
        look.draw, AREA * SOFT * SOFT
    )
    if look.pixels is not None:
        q[SIZE_MODE], q[SIZE_VALUE] = 2, 0.5 * look.pixels
    elif look.radius is not None or look.width is not None:
        q[SIZE_MODE], q[SIZE_VALUE] = 1, look.radius if look.radius is not None else 0.5 * look.width
    q[SIZE_VALUE] *= width
    q[RIBBON] = look.ribbon is not None
    q[BLEND] = ("add", "alpha", "opaque").index(look.blend)
    q[CONSERVE] = look.reference or 0.0
    q[FALLOFF] = view.distance**2 if look.falloff == "inverse_square" else 0.0
    emission = look.emission
    if emission and emission.strobe:
        q[STROBE_LO], q[STROBE_HI], q[DUTY] = emission.strobe.lo, max(emission.strobe.hi, 1e-12), emission.duty
    q[RAW], q[WEIGHT], q[LIT] = raw, weight, look.light is not None
    q[EMITS] = emission is not None or look.blend == "add"
    q[FOCUS] = 1.0
    lens = getattr(view, "lens", None)
    if lens is not None:
        q[LENS], q[FOCUS] = lens
    q[SNAP] = look.draw == "pixel" and lens is None
    return q
