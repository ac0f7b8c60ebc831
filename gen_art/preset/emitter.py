"""The keys of `particle:` and `emitters:`: how many particles are born, when, where and with which properties."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import (
    CountRange,
    NotNegative,
    NotNegativeRange,
    Number,
    Parsed,
    Positive,
    PositiveRange,
    RangeValue,
    SizeRange,
    Vector,
    Within,
    Words,
)
from gen_art.preset.model import Model, about
from gen_art.preset.registered import One, class_schema, registry
from gen_art.preset.values import Curve, number, shown
from gen_art.registry import Bounds, suggest

__all__ = [
    "EVENTS",
    "Attributes",
    "Choice",
    "EmitterSpec",
    "FromEvent",
    "MotionSpec",
    "EmitterOrbit",
    "ParticleSpec",
    "PulseSpec",
    "Shape",
    "Velocity",
]

_NOT_NEGATIVE = Bounds(0)
EVENTS = ("birth", "death", "impact", "path")

Shape = Annotated[Any, One("shapes", bare="point")]
Velocity = Annotated[Any, One("velocities", bare="constant")]


def _rate(value):
    """Births per second: a number, or a curve over simulated time."""
    if isinstance(value, (list, tuple, dict, Curve)):
        curve = Curve.of(value)
        _NOT_NEGATIVE.check(curve.minimum)
        return curve
    return _NOT_NEGATIVE.check(number(value))


def _times(value):
    """Simulated times, not negative, in order; a number is a single time."""
    times = value if isinstance(value, (list, tuple)) else [value]
    return tuple(sorted(_NOT_NEGATIVE.check(number(time)) for time in times))


_RATE = {"anyOf": [{"type": "number", "minimum": 0}, {"type": "string"}, {"type": "array", "items": {"type": "array"}}]}
_TIMES = {"anyOf": [{"type": "number", "minimum": 0}, {"type": "array"}, {"type": "string"}]}
Rate = Annotated[float | Curve, Parsed(_rate, _RATE)]
Times = Annotated[tuple[float, ...], Parsed(_times, _TIMES)]


class Attributes(Model):
    """The properties of newborn particles; a value is drawn from a range for each particle. Give mass or density."""

    radius: SizeRange | None = about(None, "radius of the particle; 0.01 when left out", unit="m")
    mass: NotNegativeRange | None = about(None, "mass; 1 when neither mass nor density is given", unit="kg")
    density: PositiveRange | None = about(None, "mass = density 4/3 pi radius^3", unit="kg/m^3")
    charge: RangeValue | None = about(None, "electric charge; 0 when left out", unit="C")
    lifetime: PositiveRange | None = about(None, "lifetime in simulated time; unlimited when left out", unit="s")
    attributes: dict[str, RangeValue] = about({}, "further numbers by name, stored for each particle")

    @model_validator(mode="after")
    def _one_mass(self):
        if self.mass is not None and self.density is not None:
            raise UsageError("mass and density are alternatives: give one of them")
        return self


class ParticleSpec(Attributes):
    """The properties of a system's particles; an emitter may override them for the particles it emits."""


class EmitterOrbit(Model):
    """The emitter moves on a circle about its place: radius (cos, sin)(2 pi t / period + phase), perpendicular to `axis`."""

    radius: NotNegative = about(..., "radius of the circle", unit="m")
    period: Positive = about(..., "simulated time of one turn", unit="s")
    axis: Vector = about((0.0, 1.0, 0.0), "axis of the circle; the emitter turns right-handed about it")
    phase: Number = about(0.0, "angle at time 0", unit="degrees")


class MotionSpec(Model):
    """The motion of an emitter: a steady velocity, and a circle added to it."""

    velocity: Vector = about((0.0, 0.0, 0.0), "steady velocity of the emitter", unit="m/s")
    orbit: EmitterOrbit | None = about(None, "a circle that is added to the steady motion")


class PulseSpec(Model):
    """A periodic rate: in each period the births gather around its beginning; the mean rate stays the same."""

    period: Positive = about(..., "simulated time from pulse to pulse", unit="s")
    depth: Annotated[float, Within(0, 0.99)] = about(
        0.5, "0 is a steady rate; the peak is 1 / (1 - depth) times the mean"
    )
    duty: Annotated[float, Within(0.01, 1)] = about(
        1.0, "the part of each period, around its beginning, in which particles are born"
    )


class FromEvent(Model):
    """Births from events of another system: `shells.death`, `.birth`, `.impact` (on a collider with `action: emit`) or
    `.path` (along the paths of its living particles)."""

    event: str = about(..., "SYSTEM.death, SYSTEM.birth, SYSTEM.impact or SYSTEM.path")
    tag: Words = about((), "only events of particles from emitters (or choices) with one of these tags")
    inherit: Literal["velocity", "none"] = about("none", "`velocity` adds the parent's velocity")
    balance: Literal["pairs", "none"] = about(
        "none", "`pairs`: each pair of particles gets opposite velocities, so a burst has no momentum of its own"
    )

    short_form = {"type": "string", "description": "SYSTEM.death, SYSTEM.birth, SYSTEM.impact or SYSTEM.path"}

    @classmethod
    def from_short(cls, value):
        return {"event": value} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _event_exists(self):
        system, dot, event = self.event.rpartition(".")
        if not dot or not system or event not in EVENTS:
            near = suggest(event, EVENTS) if dot else ""
            raise UsageError(
                f"must be SYSTEM.birth, SYSTEM.death, SYSTEM.impact or SYSTEM.path, not {shown(self.event)}{near}"
            )
        return self

    @property
    def system(self) -> str:
        return self.event.rpartition(".")[0]

    @property
    def kind(self) -> str:
        return self.event.rpartition(".")[2]


class Choice(Attributes):
    """One of several kinds of burst; each event chooses one, with a probability in proportion to its weight."""

    weight: Positive = about(1.0, "weight of this choice")
    count: CountRange | None = about(None, "particles for each event; the emitter's when left out")
    shape: Shape = about(None, "positions of birth relative to the event; the emitter's when left out")
    velocity: Velocity = about(None, "velocities at birth; the emitter's when left out", unit="m/s")
    tag: str | None = about(None, "a name by which looks and other emitters refer to these particles")


class EmitterSpec(Attributes):
    """Births: at a `rate`, `at` given times, a `count` at the start, or `from` events of another system.

    A scripted emitter is written here under its registered name: `spiral: {turns: 3}`.
    """

    rate: Rate | None = about(
        None, "births per simulated second, or a curve over time; with a `path` event for each parent", unit="1/s"
    )
    pulse: PulseSpec | None = about(None, "makes the rate periodic")
    at: Times | None = about(None, "simulated times of births", unit="s")
    count: CountRange | None = about(None, "births for each time or event; by itself, all are born at `start`")
    start: NotNegative | None = about(None, "simulated time of the first births", unit="s")
    stop: NotNegative | None = about(None, "simulated time of the last births", unit="s")
    source: FromEvent | None = Field(None, alias="from", description="events of another system that cause births")
    shape: Shape = about(None, "positions of birth; a point at the origin when left out", unit="m")
    velocity: Velocity = about(None, "velocities at birth; at rest when left out", unit="m/s")
    motion: MotionSpec | None = about(None, "motion of the emitter")
    tag: str | None = about(None, "a name by which looks and other emitters refer to these particles")
    choose: dict[str, Choice] = about({}, "kinds of burst, of which each event chooses one")
    scripted: Any = Field(None, exclude=True, description="a registered emitter of a plugin")

    @classmethod
    def known_keys(cls) -> list[str]:
        keys = (field.alias or name for name, field in cls.model_fields.items() if name != "scripted")
        return [*keys, *registry("emitters")]

    @model_validator(mode="before")
    @classmethod
    def _find_scripted(cls, value):
        if not isinstance(value, dict):
            return value
        named = {key: item for key, item in value.items() if key in registry("emitters")}
        plain = {key: item for key, item in value.items() if key not in named and key != "scripted"}
        if not named:
            return plain
        scripted = One("emitters", bare="").validate(named)
        births = getattr(scripted, "births", None)
        if births is not None:
            unused = sorted({"rate", "at", "count", "start", "from", "choose", "shape", "velocity"} & set(plain))
            if unused:
                raise UsageError(f"{scripted.name} makes its own particles at the start: leave out {unused[0]}")
            plain = {**plain, "count": births}
        return {**plain, "scripted": scripted}

    @model_validator(mode="after")
    def _consistent(self):
        problem = _find_conflict(self)
        if problem:
            raise UsageError(problem)
        return self

    @property
    def tags(self) -> tuple[str, ...]:
        """Every tag that a particle of this emitter may have."""
        return tuple(tag for tag in (self.tag, *(choice.tag for choice in self.choose.values())) if tag)

    @classmethod
    def describe(cls, properties):
        properties.pop("scripted", None)
        properties |= {name: class_schema(registry("emitters")[name]) for name in registry("emitters")}


def _find_conflict(emitter: EmitterSpec) -> str:
    """The problem with the combination of rate, at, count, from, start and stop; empty when there is none."""
    rate, at, count, source = emitter.rate, emitter.at, emitter.count, emitter.source
    choices = emitter.choose.values()
    counted = count is not None or (source is not None and choices and all(c.count is not None for c in choices))
    if source is None and any(c.count is not None for c in choices):
        return "the count of a choice needs from: it is the number of births for each event"
    if source is None and count is not None and not count.constant:
        return "a range of counts needs from: a number of births is drawn for each event"
    if rate is not None and at is not None:
        return "rate and at are alternatives: give one of them"
    if rate is not None and count is not None:
        return "rate and count are alternatives: give one of them"
    if source is not None and at is not None:
        return "from and at are alternatives: events bring their own times"
    if source is not None and source.kind == "path" and rate is None:
        return "from a path needs a rate: births per second for each parent"
    if source is not None and isinstance(rate, Curve):
        return "from a path needs a steady rate, not a curve"
    if source is not None and source.kind != "path":
        if rate is not None:
            return f"from {source.system}.{source.kind} needs a count, not a rate"
        if not counted:
            return f"from {source.system}.{source.kind} needs a count: births for each event"
    if source is None and rate is None and at is None and not counted:
        return "needs one of rate, at, count or from: when are its particles born?"
    for key in ("start", "stop", "motion"):
        if source is not None and getattr(emitter, key) is not None:
            return f"{key} and from are alternatives: events bring their own times and places"
    if emitter.stop is not None and rate is None:
        return "stop needs a rate"
    if emitter.pulse is not None and (rate is None or source is not None):
        return "pulse needs a rate, without from"
    if emitter.stop is not None and emitter.stop <= (emitter.start or 0.0):
        return f"stop must be later than start, not {emitter.stop:g}"
    return ""
