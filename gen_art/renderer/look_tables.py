"""A look as tables and numbers for the shading kernel.

All of them are run-time data, so changing a number or a colour of a look compiles nothing.
"""

import math
from dataclasses import dataclass

import numpy as np

from gen_art.errors import UsageError
from gen_art.particles.entries import DISSIPATED, LedgerEntry
from gen_art.preset.colour_names import Gradient
from gen_art.preset.look import BY, Color, Look, Ramp, ledger_entry
from gen_art.preset.values import Curve
from gen_art.registry import suggest
from gen_art.renderer.camera import CameraView
from gen_art.renderer.colour import TABLE, blackbody, gradient_table, planck_luminance
from gen_art.renderer.sprite import AREA, FOOTPRINT_PER_RADIUS, KINDS
from gen_art.renderer.sprite_image import texels

__all__ = [
    "FIRST_ENTRY", "QUANTITIES", "RAMPS", "RANDOM", "LookTables", "domain", "kernel_numbers",
]  # fmt: skip

# quantities that a ramp may follow, in the order of BY; attributes come after them, one slot for each ramp
QUANTITIES = len(BY)
RANDOM = BY.index("random")
SIZE, INTENSITY, OPACITY, KELVIN, COLOR, ALBEDO = range(6)
RAMPS = 6
RAMP_SLOT, RAMP_LOW, RAMP_SCALE, RAMP_CHANNEL = range(4)  # columns of the ramps, see _ramp
FIRST_ENTRY = -2  # in RAMP_CHANNEL: the first entry of the ledger of which particles keep shares; the next is -3

# positions of the kernel's run-time numbers
(
    POSITION, _PY, _PZ, AXES, *_rest,
) = range(12)  # fmt: skip
SCALE, ORTHOGRAPHIC, NEAR, FAR, WIDTH, ROWS, TIME, SHUTTER = range(12, 20)
FOG_START, FOG_RATE, FOG_RED, FOG_GREEN, FOG_BLUE = range(20, 25)
KIND, SIZE_MODE, SIZE_VALUE, BLEND, CONSERVE, FALLOFF = range(25, 31)
STROBE_LO, STROBE_HI, DUTY, FILM_TIME, RAW, LIT, WEIGHT, EMITS = range(31, 39)
LENS, FOCUS, AREA_OF, RIBBON, SNAP = range(39, 44)
PIECES = 44  # 1 where the streaks are pieces of curved ones
MARGIN = 45  # how far outside the picture a sprite's middle may be, in footprints
OVERLAP, WIDEST = 46, 47  # of `spread`: radius over distance, 0 without it; largest factor on the radius
NUMBERS = 48


def domain(ramp: Ramp | Color) -> tuple[float, float]:
    """The values of the quantity at the two ends of the ramp's table."""
    if isinstance(ramp, Color):
        return (ramp.range.lo, ramp.range.hi) if ramp.range else (0.0, 1.0)
    first, last = ramp.curve.points[0][0], ramp.curve.points[-1][0]
    if ramp.range is not None:
        span = ramp.range.hi - ramp.range.lo
        return ramp.range.lo + first * span, ramp.range.lo + last * span
    return first, last


def _samples(curve: Curve) -> np.ndarray:
    xs, ys = zip(*curve.points)
    return np.interp(np.linspace(xs[0], xs[-1], TABLE), xs, ys)


def _ramp(
    k: int, by: str | LedgerEntry, low: float, high: float, channels: dict[str, int], entries: tuple[LedgerEntry, ...]
) -> tuple[float, float, float, float]:
    """One row of the ramps: slot of the quantity, low, 1 / span (0: a constant), and where its values are.

    These are the row of an attribute, FIRST_ENTRY minus the number of an entry of the ledger, or -1 for one of BY.
    Raises UsageError for a quantity that the system does not have.
    """
    scale = 1.0 / (high - low) if high > low else 0.0
    if isinstance(by, str) and by in channels and (by not in BY or channels[by] > 9):
        return QUANTITIES + k, low, scale, channels[by]
    if isinstance(by, str) and by in BY:
        return BY.index(by), low, scale, -1.0
    entry = ledger_entry(by)
    if entry in entries:
        return QUANTITIES + k, low, scale, FIRST_ENTRY - entries.index(entry)
    if entry is not None:
        raise UsageError(
            f"a look goes by {entry}, of which the particles keep no share: give the system this look, or `booked`"
        )
    known = [*BY, DISSIPATED.kind, "{work: FORCE}", "{dissipated: FORCE}", *channels]
    raise UsageError(f"a look cannot go by '{by}'{suggest(str(by), known)}; known are {', '.join(known)}")


@dataclass(frozen=True)
class LookTables:
    """A look as tables, all float32.

    ramps : (6, 4), rows as `_ramp` gives them
    curves : (6, 256), the ramps' values over their domains
    colours : (rows, 256, 4); row 0 is the black body, row 1 the albedo, row 2 the emission, and one row for each tag follows
    tags, albedo_tags : those of the emission's colour, and those of the albedo, in the order of their rows
    """

    look: Look
    ramps: np.ndarray
    curves: np.ndarray
    colours: np.ndarray
    tags: tuple[str, ...]
    albedo_tags: tuple[str, ...] = ()

    @classmethod
    def of(cls, look: Look, channels: dict[str, int], entries: tuple[LedgerEntry, ...] = ()) -> "LookTables":
        """The tables of a look for a system with these attribute rows, whose particles keep their shares of these entries.

        Raises UsageError for a quantity that the system does not have.
        """
        emission = look.emission
        constant = Ramp()
        kelvin = emission.blackbody if emission and emission.blackbody else None
        color = emission.color if emission and emission.color else Color.model_validate({})
        scalar_ramps = [look.size, emission.intensity if emission else constant, look.opacity, kelvin or constant]
        ramps, curves = np.zeros((RAMPS, 4), np.float32), np.ones((RAMPS, TABLE), np.float32)
        for k, ramp in enumerate(scalar_ramps):
            ramps[k] = _ramp(k, ramp.by, *domain(ramp), channels, entries)
            curves[k] = _samples(ramp.curve)
        for k, spec in ((COLOR, color), (ALBEDO, look.albedo)):
            ramps[k] = _ramp(k, spec.by, *domain(spec), channels, entries)
        gradients: list[Gradient] = [
            look.albedo.gradient,
            color.gradient,
            *color.tags.values(),
            *look.albedo.tags.values(),
        ]
        colours = np.ones((1 + len(gradients), TABLE, 4), np.float32)
        if emission and kelvin:
            temperatures = np.maximum(_samples(kelvin.curve), 100.0)
            relative = planck_luminance(temperatures) / planck_luminance(temperatures.max())
            colours[0, :, :3] = blackbody(temperatures) * (relative**emission.planck)[:, None]
        for row, gradient in enumerate(gradients):
            colours[1 + row, :, :3] = gradient_table(gradient)
        of_albedo = 3 + len(color.tags)
        for k, rows in ((ALBEDO, np.r_[1, of_albedo : len(colours)]), (COLOR, np.r_[2:of_albedo])):
            if (colours[rows] == colours[rows, :1]).all():
                ramps[k, RAMP_SCALE] = 0.0
        return cls(look, ramps, curves, colours, tuple(color.tags), tuple(look.albedo.tags))

    def rows(self, sources) -> np.ndarray:
        """(2 n,) the rows of `colours` with the colours of each source (an object with a `tag`): its emission's, its albedo's."""
        tags = [str(getattr(source, "tag", None)) for source in sources] or [""]
        emission = {tag: 3 + k for k, tag in enumerate(self.tags)}
        albedo = {tag: 3 + len(self.tags) + k for k, tag in enumerate(self.albedo_tags)}
        return np.array([(emission.get(tag, 2), albedo.get(tag, 1)) for tag in tags], np.int32).ravel()


def kernel_numbers(
    shading: LookTables,
    view: CameraView,
    size,
    time: float,
    film_time: float,
    shutter: float,
    raw: bool,
    weight: float = 1.0,
    width: float = 1.0,
    lit: bool = False,
) -> np.ndarray:
    """The shading kernel's run-time numbers (float64).

    size : (width, height) of the picture in pixels
    time, film_time : simulated seconds and film seconds
    shutter : simulated seconds the shutter is open
    raw : makes every particle's light 1
    weight : factor of the light
    width : factor of the sizes
    lit : whether the light on the particles is added later
    """
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
    q[AREA_OF] = {
        "sphere": math.pi,
        "body": math.pi,
        "thread": math.pi,
        "cloth": math.pi,
        "surface": math.pi,
        "picture": 4.0 * texels(look.picture.image.place)[1] if look.picture else 0.0,
    }.get(look.draw, AREA * FOOTPRINT_PER_RADIUS * FOOTPRINT_PER_RADIUS)
    if look.pixels is not None:
        q[SIZE_MODE], q[SIZE_VALUE] = 2, 0.5 * look.pixels
    elif look.radius is not None or look.width is not None:
        q[SIZE_MODE], q[SIZE_VALUE] = 1, look.radius if look.radius is not None else 0.5 * (look.width or 0.0)
    q[SIZE_VALUE] *= width
    q[RIBBON] = look.ribbon is not None
    q[BLEND] = 2 if look.shapes or look.is_liquid else ("add", "alpha", "opaque").index(look.blend)
    q[CONSERVE] = look.reference or 0.0
    q[FALLOFF] = view.distance**2 if look.falloff == "inverse_square" else 0.0
    emission = look.emission
    if emission and emission.strobe:
        q[STROBE_LO], q[STROBE_HI], q[DUTY] = emission.strobe.lo, max(emission.strobe.hi, 1e-12), emission.duty
    q[RAW], q[WEIGHT], q[LIT] = raw, weight, lit
    q[EMITS] = emission is not None or (look.blend == "add" and not look.shapes and not look.is_liquid)
    q[FOCUS] = 1.0
    if look.spread is not None:
        q[OVERLAP], q[WIDEST] = look.spread.overlap, look.spread.most
    # an ellipse is up to most^(2/3) times as long as the disc, and its kernel a little wider
    q[MARGIN] = 1.5 if look.stretch is None else max(1.5, 1.1 * look.stretch.most ** (2 / 3))
    lens = getattr(view, "lens", None)
    if lens is not None:
        q[LENS], q[FOCUS] = lens
    q[SNAP] = look.draw == "pixel" and lens is None
    return q
