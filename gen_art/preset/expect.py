"""The keys of `expect:`: what must hold of a preset's motion. `gen-art check` runs it and says whether it does."""

from typing import Annotated, Any

from pydantic import Field, model_validator

from gen_art.errors import UsageError
from gen_art.preset.fields import NotNegative, Number, Parsed, Positive
from gen_art.preset.model import Model, about, collected
from gen_art.preset.values import shown
from gen_art.registry import suggest

__all__ = [
    "CONSERVED", "OF_A_SYSTEM", "OF_PARTICLES", "STATISTICS", "Drift", "Expect", "LedgerGap", "Period", "Quantity", "Range",
    "Value", "unknown_quantities",
]  # fmt: skip

CONSERVED = ("energy", "momentum", "angular_momentum", "mass", "charge")
_AXES = ("x", "y", "z")
# by name, the unit
OF_PARTICLES = {
    **dict.fromkeys(_AXES, "m"), **dict.fromkeys((f"v{axis}" for axis in _AXES), "m/s"), "speed": "m/s", "distance": "m",
    "age": "s", "mass": "kg", "charge": "C", "radius": "m",
}  # fmt: skip
OF_A_SYSTEM = {
    "count": "", "kinetic_energy": "J", "potential_energy": "J", "energy": "J",
    **{f"momentum_{axis}": "N s" for axis in _AXES}, **{f"angular_momentum_{axis}": "N m s" for axis in _AXES},
}  # fmt: skip
STATISTICS = ("mean", "least", "largest", "rms")


def _quantity(value):
    if not isinstance(value, str) or value.count(".") not in (1, 2):
        raise UsageError(f"must be SYSTEM.QUANTITY or SYSTEM.EMITTER.QUANTITY, such as bob.x, not {shown(value)}")
    return value


def _statistic(value):
    if value not in STATISTICS:
        raise UsageError(f"must be one of {', '.join(STATISTICS)}; not {shown(value)}{suggest(str(value), STATISTICS)}")
    return value


def _changes(value):
    if not isinstance(value, dict) or not value or not all(isinstance(path, str) for path in value):
        raise UsageError(
            f"must be changes of the preset by their path, such as {{systems.bob.integrator: euler}}, not {shown(value)}"
        )
    return dict(value)


Name = Annotated[str, Parsed(_quantity, {"type": "string", "pattern": r"^[^.]+(\.[^.]+){1,2}$"})]
Statistic = Annotated[str, Parsed(_statistic, {"enum": list(STATISTICS)})]
Changes = Annotated[Any, Parsed(_changes, {"type": "object", "minProperties": 1})]


class Drift(Model):
    """The largest change of a conserved quantity since the start, relative to the sum of its parts' absolute values."""

    drift: NotNegative = about(..., "the largest relative change; below 2e-12 it is round-off and taken as that")
    of: str | None = about(None, "the system; all systems together when left out")

    short_form = {"type": "number", "minimum": 0, "description": "the largest relative change"}

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, dict) else {"drift": value}


class LedgerGap(Model):
    """The largest residual of the ledger, relative to the largest amount that moved."""

    energy: NotNegative | None = about(None, "the largest relative residual of the energy")
    momentum: NotNegative | None = about(None, "the largest relative residual of the momentum")
    of: str | None = about(None, "the system; each system when left out")

    short_form = {
        "type": "number",
        "minimum": 0,
        "description": "the largest relative residual of energy and of momentum",
    }

    @classmethod
    def from_short(cls, value):
        return value if isinstance(value, dict) else {"energy": value, "momentum": value}

    @model_validator(mode="after")
    def _something(self):
        if self.energy is None and self.momentum is None:
            raise UsageError("needs energy, momentum or both")
        return self


class Quantity(Model):
    """A number that follows from the particles at a moment.

    `of` is SYSTEM.QUANTITY, or SYSTEM.EMITTER.QUANTITY for the particles of one emitter. Quantities of particles are x y z vx
    vy vz speed distance (from the origin) age mass charge radius and declared attributes; of a system count, kinetic_energy,
    potential_energy, energy, momentum_x y z, angular_momentum_x y z.
    """

    of: Name = about(..., "the quantity, such as bob.x")
    over: Statistic = about("mean", "what is taken over the particles: mean, least, largest or rms")
    mutant: Changes | None = about(None, "changes by path with which this must fail; those of `expect` when left out")


class Period(Quantity):
    """The mean time between two passages of a quantity upwards through the middle between its least and largest value."""

    is_: Positive = about(..., "the period, in simulated time", unit="s", alias="is")
    within: Positive = about(0.01, "the largest relative difference")


class Value(Quantity):
    """The value of a quantity at one time."""

    is_: Number = about(..., "the value", alias="is")
    within: Positive = about(0.01, "the largest difference: relative to the value, or absolute if the value is 0")
    at: NotNegative | None = about(None, "film time; the end when left out", unit="s")


class Range(Quantity):
    """Bounds that a quantity keeps."""

    source: Number | None = about(None, "the least value", alias="from")
    to: Number | None = about(None, "the largest value")
    after: NotNegative | None = about(
        None, "film time from which on they hold; from the start of the preroll when left out", unit="s"
    )

    @model_validator(mode="after")
    def _ordered(self):
        if self.source is None and self.to is None:
            raise UsageError("needs from, to or both")
        if self.source is not None and self.to is not None and self.source > self.to:
            raise collected([(("to",), f"must be at least {self.source:g}, which is `from`, not {self.to:g}")])
        return self


def _one_or_more(value):
    return value if isinstance(value, (list, tuple)) else [value]


class _Several:
    """Annotation: one mapping, or a list of them."""

    def __get_pydantic_core_schema__(self, source, handler):
        from pydantic_core import core_schema

        return core_schema.no_info_before_validator_function(_one_or_more, handler(source))

    def __get_pydantic_json_schema__(self, schema, handler):
        many = handler(schema)
        return {"anyOf": [many["items"], many]}


class Expect(Model):
    """What must hold of the motion, in float64 at the time step, its half and its quarter."""

    time: Positive | None = about(
        None, "film time to run to; 2 s, or 1 s with mutual forces or stiff springs, when left out",
        unit="s",
    )  # fmt: skip
    particles: Annotated[int, Field(ge=1, le=1_000_000)] = about(
        600, "the most particles in a system at once, about; others are thinned out"
    )
    energy: Annotated[list[Drift], _Several()] = about([], "drift of the energy")
    momentum: Annotated[list[Drift], _Several()] = about([], "drift of the momentum; 0 stands for round-off")
    angular_momentum: Annotated[list[Drift], _Several()] = about([], "drift of the angular momentum about the origin")
    mass: Annotated[list[Drift], _Several()] = about([], "drift of the mass")
    charge: Annotated[list[Drift], _Several()] = about([], "drift of the charge")
    ledger: Annotated[list[LedgerGap], _Several()] = about([], "residual of the ledger")
    period: Annotated[list[Period], _Several()] = about([], "periods")
    value: Annotated[list[Value], _Several()] = about([], "values at a time")
    range: Annotated[list[Range], _Several()] = about([], "bounds of quantities")
    mutant: Changes | None = about(
        None, "changes of the preset by path, with which each period, value and range must fail"
    )

    @property
    def quantities(self) -> list[tuple[tuple, Quantity]]:
        """(path, claim) of every period, value and range."""
        return [((key, k), one) for key in ("period", "value", "range") for k, one in enumerate(getattr(self, key))]

    @model_validator(mode="after")
    def _complete(self):
        if not any(getattr(self, key) for key in (*CONSERVED, "ledger", "period", "value", "range")):
            raise UsageError("expects nothing: give energy, momentum, ledger, period, value or range")
        bare = [path for path, one in self.quantities if one.mutant is None]
        if bare and self.mutant is None:
            raise collected(
                [(bare[0], "needs a mutant: changes of the preset with which it must fail, here or in `expect`")]
            )
        return self


def unknown_quantities(preset) -> list[tuple[tuple, str]]:
    """(path, problem) of each name in `expect` that the preset does not have."""
    expect, found = preset.expect, []
    if expect is None:
        return []
    for path, one in expect.quantities:
        found += [(("expect", *path, "of"), text) for text in _unknown(preset, one.of)]
    for key in (*CONSERVED, "ledger"):
        for k, one in enumerate(getattr(expect, key)):
            if one.of is not None and one.of not in preset.systems:
                found.append((("expect", key, k, "of"), f"no system '{one.of}'{suggest(one.of, preset.systems)}"))
    return found


def _unknown(preset, of: str) -> list[str]:
    system, *emitter, quantity = of.split(".")
    if system not in preset.systems:
        return [f"no system '{system}'{suggest(system, preset.systems)}"]
    spec = preset.systems[system]
    if emitter and emitter[0] not in spec.emitters:
        return [f"system '{system}' has no emitter '{emitter[0]}'{suggest(emitter[0], spec.emitters)}"]
    known = [*OF_PARTICLES, *spec.particle.attributes, *(() if emitter else OF_A_SYSTEM)]
    if quantity not in known:
        return [f"no quantity '{quantity}'{suggest(quantity, known) or '; there are ' + ', '.join(known)}"]
    return []
