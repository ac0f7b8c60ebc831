"""The Preset: the validated description of what to render. Attributes are the YAML keys (`from` is `source` in Python)."""

import json
from pathlib import Path
from typing import Annotated, Any

from pydantic import PrivateAttr, model_validator

from gen_art.errors import UsageError
from gen_art.html_table import html_table
from gen_art.integrators.schemes import INTEGRATORS, charged, scheme
from gen_art.particles.entries import LedgerEntry
from gen_art.preset.axes import Axes
from gen_art.preset.black_hole import BlackHole
from gen_art.preset.camera import CameraSpec, Fit
from gen_art.preset.clock import Clock
from gen_art.preset.develop import DevelopSpec
from gen_art.preset.domain import Domain
from gen_art.preset.emitter import EmitterSpec, ParticleSpec
from gen_art.preset.expect import Expect
from gen_art.preset.fields import NotNegative, NotNegativeRange, Number, Parsed, Positive
from gen_art.preset.files import FOLDER, PresetFile
from gen_art.preset.knobs import Knob
from gen_art.preset.labels import Label
from gen_art.preset.light import Light
from gen_art.preset.look import Look
from gen_art.preset.model import Model, about
from gen_art.preset.registered import Many, class_schema, is_field, registry
from gen_art.preset.sky import Sky
from gen_art.preset.surface import Finish, GroundValue
from gen_art.preset.values import shown
from gen_art.preset.wormhole import Wormhole
from gen_art.registry import suggest

__all__ = ["VERSION", "MediumSpec", "Preset", "SystemSpec", "Units", "json_schema"]

VERSION = 1


def _version(value):
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise UsageError(f"must be {VERSION}, not {shown(value)}")
    if value > VERSION:
        raise UsageError(f"the preset has version {value}, but this gen-art reads version {VERSION}: update gen-art")
    return value


def _seed(value):
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**63:
        raise UsageError(f"must be a whole number from 0 to 2^63 - 1, not {shown(value)}")
    return value


def _integrator(value):
    if value not in list(INTEGRATORS):
        near = suggest(str(value), INTEGRATORS) or "; there are " + ", ".join(INTEGRATORS)
        raise UsageError(f"unknown integrator {shown(value)}{near}")
    return value


class Units(Model):
    """Labels of the units of all numbers, and the constant of gravitation in these units. SI when left out."""

    length: str = about("m", "label of lengths")
    time: str = about("s", "label of times")
    mass: str = about("kg", "label of masses")
    charge: str = about("C", "label of charges")
    velocity: str | None = about(None, "label of velocities; length/time when left out")
    # the value of CODATA 2018, m^3 kg^-1 s^-2
    G: Number = about(6.67430e-11, "constant of gravitation in these units")

    @property
    def energy(self) -> str:
        """Label of energies: J in SI, otherwise composed of the other labels."""
        if (self.length, self.time, self.mass, self.velocity) in (("m", "s", "kg", None), ("m", "s", "kg", "m/s")):
            return "J"
        return f"{self.mass} ({self.velocity})^2" if self.velocity else f"{self.mass} {self.length}^2/{self.time}^2"


class MediumSpec(Model):
    """The fluid in which the particles move: its density and its velocity, the sum of wind, curl_noise and other fields."""

    density: NotNegative = about(0.0, "density of the fluid", unit="kg/m^3")
    terms: Annotated[Any, Many("forces", is_field)] = about((), "velocity fields")

    @classmethod
    def known_keys(cls) -> list[str]:
        return ["density", *Many("forces", is_field).names()]

    @model_validator(mode="before")
    @classmethod
    def _find_terms(cls, value):
        if not isinstance(value, dict):
            return value
        fields = Many("forces", is_field).names()
        terms = {key: item for key, item in value.items() if key in fields}
        return {**({"density": value["density"]} if "density" in value else {}), "terms": terms}

    @classmethod
    def describe(cls, properties):
        properties.pop("terms", None)
        properties |= Many("forces", is_field).__get_pydantic_json_schema__(None, None)["properties"]


class SystemSpec(Model):
    """A named group of particles with its forces and its look."""

    particle: ParticleSpec = about(ParticleSpec(), "properties of newborn particles")
    integrator: Annotated[str, Parsed(_integrator, {"enum": list(INTEGRATORS)})] = about(
        "velocity_verlet", "the integration scheme"
    )
    speed_of_light: Positive | None = about(
        None, "makes boris, vay and higuera_cary relativistic; Newtonian mechanics when left out", unit="m/s"
    )
    exact_gyration: bool = about(False, "charges turn by the exact angle in uniform fields, up to 3 rad a step")
    forces: Annotated[Any, Many("forces")] = about((), "forces on this system only")
    inherit_forces: bool = about(True, "whether the preset's shared forces also act on this system")
    medium: MediumSpec | None = about(None, "the medium of this system; the preset's when left out")
    interactions: Annotated[Any, Many("interactions")] = about((), "forces between particles")
    colliders: Annotated[Any, Many("colliders")] = about((), "colliders of this system only")
    inherit_colliders: bool = about(True, "whether the preset's shared colliders also act on this system")
    emitters: dict[str, EmitterSpec] = about({}, "the emitters of its particles")
    look: Look | None = about(None, "how the system is drawn; a system without a look is not drawn")
    looks: dict[str, Look] = about(
        {}, "further looks by name, each of which draws the particles once more, or those of its `tag` alone"
    )

    @property
    def all_looks(self) -> dict[str, Look]:
        """Its look, if it has one, and the further ones, by their keys: `look`, `looks.NAME`."""
        first = {} if self.look is None else {"look": self.look}
        return first | {f"looks.{name}": look for name, look in self.looks.items()}

    @property
    def ledger_entries(self) -> tuple[LedgerEntry, ...]:
        """The entries of the ledger that its looks go by."""
        found = (entry for look in self.all_looks.values() for entry in look.ledger_entries(self.particle.attributes))
        return tuple(dict.fromkeys(found))

    @model_validator(mode="after")
    def _charged(self):
        charged(
            scheme(self.integrator),
            self.forces,
            self.speed_of_light,
            self.exact_gyration,
            self.interactions,
            self.colliders,
        )
        return self


class Gallery(Model):
    """The moments that represent the preset in the gallery."""

    time: NotNegative | None = about(None, "film time of the still; the middle of the film when left out", unit="s")
    loop: NotNegativeRange | None = about(
        None, "start and end of the loop in film time, three to six seconds long: 2..6", unit="s"
    )


class Preset(Model):
    """The validated description of a picture or film: systems, forces, medium, camera, development, seed and clock."""

    version: Annotated[int, Parsed(_version, {"const": VERSION})] = about(..., "version of the preset format")
    seed: Annotated[int, Parsed(_seed, {"type": "integer", "minimum": 0})] = about(
        0, "seed of all random numbers; another seed gives another variation of the preset"
    )
    units: Units = about(Units(), "units of the numbers")
    clock: Clock = about(..., "duration, frames and time step")
    domain: Domain | None = about(None, "the space of all systems; open without limits when left out")
    medium: MediumSpec = about(MediumSpec(), "the fluid in which the particles move")
    forces: Annotated[Any, Many("forces")] = about((), "forces that act on every system")
    colliders: Annotated[Any, Many("colliders")] = about((), "colliders of every system")
    systems: dict[str, SystemSpec] = about(..., "the particle systems by name", min_length=1)
    light: Light | None = about(None, "the light on everything that reflects light and has no light of its own")
    ground: GroundValue = about(None, "a level floor without end, which is only seen")
    shadows: bool = about(True, "whether things shadow each other and the ground, from the lamp and from the sky")
    sky: Sky | None = about(None, "what surrounds the scene; nothing when left out")
    wormhole: Wormhole | None = about(None, "a throat to another side, which bends light; none when left out")
    black_hole: BlackHole | None = about(None, "a horizon, and light bent round it; none when left out")
    camera: CameraSpec | None = about(None, "the camera; when left out, one that has all particles in its view")
    develop: DevelopSpec = about(DevelopSpec(), "how light becomes a picture")
    labels: tuple[Label, ...] = about((), "text in the finished picture")
    axes: Axes | None = about(None, "axes with numbers in the finished picture")
    gallery: Gallery = about(Gallery(), "the moments that represent the preset")
    expect: Expect | None = about(None, "what must hold of its motion; `gen-art check` runs it")
    _name: str = PrivateAttr("preset")
    _title: str = PrivateAttr("")
    _written: dict = PrivateAttr(default_factory=dict)
    _knobs: dict[str, Knob] = PrivateAttr(default_factory=dict)
    _folder: Path = PrivateAttr(Path())
    _verdict: dict | None = PrivateAttr(None)
    _fits: dict[tuple[int, int, str], Fit] = PrivateAttr(default_factory=dict)

    @model_validator(mode="after")
    def _bent(self):
        if self.bends is None:
            return self
        if self.wormhole is not None and self.black_hole is not None:
            raise UsageError("light is bent by a wormhole or by a black hole: leave out `wormhole` or `black_hole`")
        name = "wormhole" if self.black_hole is None else "black hole"
        if self.sky is not None and self.sky.sun is not None:
            raise UsageError(f"the sky of a {name} has no sun: give `sky` a gradient, a color, stars or a band")
        if self.camera is not None and self.camera.height is not None:
            raise UsageError(f"a {name} is seen by a perspective camera: give `fov` in place of `height`")
        if self.wormhole is not None and self.camera is not None and self.camera.follow is not None:
            raise UsageError("a camera that sees a wormhole goes by its own path: leave out `follow`")
        return self

    @property
    def bends(self) -> Wormhole | BlackHole | None:
        """What bends the light."""
        return self.wormhole if self.black_hole is None else self.black_hole

    @classmethod
    def known_keys(cls) -> list[str]:
        return [*cls.model_fields, "knobs"]

    @classmethod
    def describe(cls, properties):
        described = {
            "type": "object",
            "description": "a value with what a slider needs",
            "properties": {
                "value": {"description": "what `$name` stands for"},
                "range": {"type": "string", "description": "the values worth trying: 900..2200"},
                "unit": {"type": "string", "description": "the unit, as text: K"},
            },
            "required": ["value"],
        }
        properties["knobs"] = {
            "type": "object",
            "description": "named values; `$name` stands for one elsewhere",
            "additionalProperties": {"anyOf": [{"not": {"type": "object", "required": ["value"]}}, described]},
        }

    @property
    def name(self) -> str:
        """The preset's name, from its file."""
        return self._name

    @property
    def title(self) -> str:
        """The comment in the first line of its file, which says what is seen; "" where there is none."""
        return self._title

    def keep(self, name: str, title: str, written: dict, knobs: dict[str, Knob]) -> "Preset":
        """Store name, title, the folder that is being read, the plain data from which this was made, and the knobs filled in."""
        self._name, self._title, self._written, self._folder, self._knobs = name, title, written, FOLDER.get(), knobs
        return self

    @property
    def knobs(self) -> dict[str, Knob]:
        """The knobs of the file that it was loaded from; none in a preset that is loaded from plain data without them."""
        return self._knobs

    @property
    def verdict(self) -> dict | None:
        """The verdict on `expect` from the recipe of the picture that is made again; None otherwise."""
        return self._verdict

    def take_verdict(self, recipe: dict) -> "Preset":
        """Take over the verdict of a recipe."""
        self._verdict = recipe.get("expect")
        return self

    @property
    def fits(self) -> dict[tuple[int, int, str], Fit]:
        """The fits of its camera that are known, for `camera.frame`: see gen_art/renderer/fitting.py."""
        return self._fits

    def with_own_fits(self) -> "Preset":
        """The same preset, whose camera is fitted without a trace in this one."""
        same = self.model_copy()
        same._fits = {}
        return same

    @property
    def folder(self) -> Path:
        """The folder of the files that the preset names."""
        return self._folder

    @property
    def looks(self) -> dict[str, Look | None]:
        """The looks of all systems: SYSTEM is the look of a system, or None, and SYSTEM.NAME each of its further ones."""
        found: dict[str, Look | None] = {}
        for name, system in self.systems.items():
            found |= {name: system.look, **{f"{name}.{key}": look for key, look in system.looks.items()}}
        return found

    @property
    def files(self) -> list:
        """The files that the preset names, each once: of looks in the order of the systems, then of ground and laws."""
        looks = [look for look in self.looks.values() if look is not None]
        images = [look.picture.image for look in looks if look.picture is not None]
        laws = [*self.forces, *self.medium.terms, *self.colliders]
        for system in self.systems.values():
            fields = system.medium.terms if system.medium is not None else ()
            laws += [*system.forces, *fields, *system.colliders]
        surfaces = [self.ground, *(law.values.get("look") for law in laws)]
        surfaces += [look.finish for look in looks]
        maps = [file for look in surfaces if isinstance(look, Finish) for file in look.files]
        named = images + maps + [v for law in laws for v in law.values.values() if isinstance(v, PresetFile)]
        return list(dict.fromkeys(named))

    @property
    def poster_time(self) -> float:
        """Film time of the picture that represents the preset, s: `gallery.time`, else the frame nearest to the middle."""
        if self.gallery.time is not None:
            return self.gallery.time
        return round(self.clock.duration / 2 * self.clock.fps) / self.clock.fps

    def resolved(self) -> dict:
        """The preset as plain data with overrides and knobs filled in. Loading it gives an equal preset."""
        return json.loads(json.dumps(self._written))

    def __eq__(self, other) -> bool:
        return isinstance(other, Preset) and self._written == other._written

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<Preset {self._name!r}, seed {self.seed}, {self.clock.duration:g} s; {', '.join(self.systems)}>"

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """What a notebook shows: the film, the systems and the knobs."""
        clock, (width, height) = self.clock, (self.camera or CameraSpec()).size
        facts = [
            ("Film", f"{clock.duration:g} s, {clock.fps:g} frames a second"),
            ("Picture", f"{width} x {height} pixels"),
            ("Step", f"{clock.step:g} {self.units.time}"),
            ("Seed", self.seed),
            ("Systems", ", ".join(self.systems)),
        ]
        tables = [html_table(f"{self.name}: {self.title}" if self.title else self.name, facts)]
        if self.knobs:
            rows = [(name, knob.value_text, knob.range_text, knob.unit) for name, knob in self.knobs.items()]
            tables.append(html_table("Knobs", rows, ("Knob", "Value", "Range", "Unit")))
        return "\n".join(tables)


def json_schema() -> dict:
    """The JSON Schema of a preset for YAML editors, with the registered classes and their parameters."""
    schema = Preset.model_json_schema(by_alias=True)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Gen Art preset"
    return schema


def described(kind: str) -> dict[str, dict]:
    """Name -> JSON schema of every registered class of a kind."""
    return {name: class_schema(registry(kind)[name]) for name in sorted(registry(kind))}
