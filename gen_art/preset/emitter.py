"""Who is born, when, where and with what: `particle:` and `emitters:` of a system."""

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
    """Particles a second: a number, or a curve over simulated time."""
    if isinstance(value, (list, tuple, dict, Curve)):
        curve = Curve.of(value)
        _NOT_NEGATIVE.check(curve.minimum)
        return curve
    return _NOT_NEGATIVE.check(number(value))


def _times(value):
    """Simulated times in order, not negative; one number is one time."""
    times = value if isinstance(value, (list, tuple)) else [value]
    return tuple(sorted(_NOT_NEGATIVE.check(number(time)) for time in times))


_RATE = {"anyOf": [{"type": "number", "minimum": 0}, {"type": "string"}, {"type": "array", "items": {"type": "array"}}]}
_TIMES = {"anyOf": [{"type": "number", "minimum": 0}, {"type": "array"}, {"type": "string"}]}
Rate = Annotated[float | Curve, Parsed(_rate, _RATE)]
Times = Annotated[tuple[float, ...], Parsed(_times, _TIMES)]


class Attributes(Model):
    """What each particle is born with; ranges are drawn once a particle. Mass and density are alternatives."""

    radius: NotNegativeRange | None = about(None, "radius of the particle; 0.01 when left out", unit="m")
    mass: NotNegativeRange | None = about(None, "mass; 1 when neither mass nor density is given", unit="kg")
    density: PositiveRange | None = about(None, "mass = density 4/3 pi radius^3", unit="kg/m^3")
    charge: RangeValue | None = about(None, "electric charge; 0 when left out", unit="C")
    lifetime: PositiveRange | None = about(None, "simulated time it lives; without end when left out", unit="s")
    attributes: dict[str, RangeValue] = about({}, "further numbers of your own, each a row of the state")

    @model_validator(mode="after")
    def _one_mass(self):
        if self.mass is not None and self.density is not None:
            raise UsageError("mass and density are alternatives: give one of them")
        return self


class ParticleSpec(Attributes):
    """The particle of a system; its emitters may say otherwise for theirs."""


class EmitterOrbit(Model):
    """A circle that carries an emitter: radius (cos, sin)(2 pi t / period + phase) about its place, across `axis`."""

    radius: NotNegative = about(..., "radius of the circle", unit="m")
    period: Positive = about(..., "simulated time for a turn", unit="s")
    axis: Vector = about((0.0, 1.0, 0.0), "the turn is right-handed about it")
    phase: Number = about(0.0, "where on the circle it starts", unit="degrees")


class MotionSpec(Model):
    """A moving emitter: its place shifts by velocity t, and round an orbit."""

    velocity: Vector = about((0.0, 0.0, 0.0), "steady velocity of the emitter", unit="m/s")
    orbit: EmitterOrbit | None = about(None, "a circle on top of it")


class PulseSpec(Model):
    """Births come in puffs: those of each period gather about its beginning, the mean rate kept."""

    period: Positive = about(..., "simulated time from puff to puff", unit="s")
    depth: Annotated[float, Within(0, 0.99)] = about(0.5, "0 is steady; the peak is 1 / (1 - depth) times the mean")
    duty: Annotated[float, Within(0.01, 1)] = about(
        1.0, "the part of each period, about its beginning, that has births"
    )


class FromEvent(Model):
    """Fed by what happens in another system: `shells.death`, `.birth`, `.impact` (on a collider whose
    action is emit) or `.path` (along the way of the living)."""

    event: str = about(..., "SYSTEM.death, SYSTEM.birth, SYSTEM.impact or SYSTEM.path")
    tag: Words = about((), "only from particles of emitters (or choices) with one of these tags")
    inherit: Literal["velocity", "none"] = about("none", "whether the parent's velocity is added")
    balance: Literal["pairs", "none"] = about(
        "none", "pairs: velocities cancel two by two, the burst carries no momentum"
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
    """One of several kinds of burst; an event takes one of them, with a chance in proportion to its weight."""

    weight: Positive = about(1.0, "its share among the choices")
    count: CountRange | None = about(None, "particles for each event; the emitter's when left out")
    shape: Shape = about(None, "where, relative to the event; the emitter's when left out")
    velocity: Velocity = about(None, "the emitter's when left out", unit="m/s")
    tag: str | None = about(None, "a name that looks and other emitters refer to")


class EmitterSpec(Attributes):
    """Births: at a `rate`, `at` given times, a `count` at the start, or `from` events of another system.

    A scripted emitter stands here under its registered name: `spiral: {turns: 3}`.
    """

    rate: Rate | None = about(
        None, "births a simulated second, or a curve over time; `from: path`: for each parent", unit="1/s"
    )
    pulse: PulseSpec | None = about(None, "puffs of a rate")
    at: Times | None = about(None, "times of births", unit="s")
    count: CountRange | None = about(None, "births for each time or event; alone: all at `start`")
    start: NotNegative | None = about(None, "simulated time of the first births", unit="s")
    stop: NotNegative | None = about(None, "simulated time of the last births", unit="s")
    source: FromEvent | None = Field(None, alias="from", description="events of another system that feed it")
    shape: Shape = about(None, "where they are born; a point at the origin when left out", unit="m")
    velocity: Velocity = about(None, "at rest when left out", unit="m/s")
    motion: MotionSpec | None = about(None, "a moving emitter")
    tag: str | None = about(None, "a name that looks and other emitters refer to")
    choose: dict[str, Choice] = about({}, "kinds of burst, one of which each event takes")
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
        made = One("emitters", bare="").validate(named)
        births = getattr(made, "births", None)
        if births is not None:
            own = sorted({"rate", "at", "count", "start", "from", "choose", "shape", "velocity"} & set(plain))
            if own:
                raise UsageError(f"{made.name} lays its own particles at the start: leave out {own[0]}")
            plain = {**plain, "count": births}
        return {**plain, "scripted": made}

    @model_validator(mode="after")
    def _one_way(self):
        problem = _ways(self)
        if problem:
            raise UsageError(problem)
        return self

    @property
    def tags(self) -> tuple[str, ...]:
        """Every tag a particle of this emitter may carry."""
        return tuple(tag for tag in (self.tag, *(choice.tag for choice in self.choose.values())) if tag)

    @classmethod
    def describe(cls, properties):
        properties.pop("scripted", None)
        properties |= {name: class_schema(registry("emitters")[name]) for name in registry("emitters")}


def _ways(emitter: EmitterSpec) -> str:
    """What is wrong with the combination of rate, at, count, from, start and stop; empty when nothing is."""
    rate, at, count, source = emitter.rate, emitter.at, emitter.count, emitter.source
    choices = emitter.choose.values()
    counted = count is not None or (source is not None and choices and all(c.count is not None for c in choices))
    if source is None and any(c.count is not None for c in choices):
        return "a choice's count goes with from: births for each event"
    if source is None and count is not None and not count.constant:
        return "a range of counts goes with from: so many births for each event"
    if rate is not None and at is not None:
        return "rate and at are alternatives: give one of them"
    if rate is not None and count is not None:
        return "rate and count are alternatives: give one of them"
    if source is not None and at is not None:
        return "from and at are alternatives: events bring their own times"
    if source is not None and source.kind == "path" and rate is None:
        return "from a path needs a rate: births a second for each parent"
    if source is not None and isinstance(rate, Curve):
        return "from a path takes a steady rate, not a curve"
    if source is not None and source.kind != "path":
        if rate is not None:
            return f"from {source.system}.{source.kind} takes a count, not a rate"
        if not counted:
            return f"from {source.system}.{source.kind} needs a count: births for each event"
    if source is None and rate is None and at is None and not counted:
        return "needs one of rate, at, count or from: when are its particles born?"
    for key in ("start", "stop", "motion"):
        if source is not None and getattr(emitter, key) is not None:
            return f"{key} and from are alternatives: events bring their own times and places"
    if emitter.stop is not None and rate is None:
        return "stop goes with a rate"
    if emitter.pulse is not None and (rate is None or source is not None):
        return "pulse goes with a rate that events do not feed"
    if emitter.stop is not None and emitter.stop <= (emitter.start or 0.0):
        return f"stop must be later than start, not {emitter.stop:g}"
    return ""
