"""Writes docs/forces.md and the tables of docs/presets.md from the docstrings and parameters of the classes.

python docs/make_reference.py           writes both pages
python docs/make_reference.py --check   only says whether they are up to date (exit status 1 if not)
"""

import inspect
import math
import sys
import typing
from fractions import Fraction
from pathlib import Path

from gen_art.integrators import INTEGRATORS
from gen_art.preset import (
    axes,
    black_hole,
    camera,
    clock,
    develop,
    disc_shape,
    domain,
    emitter,
    expect,
    labels,
    light,
    liquid,
    look,
    schema,
    sky,
    surface,
    wormhole,
)
from gen_art.preset.registered import in_degrees, is_field, parameters, registry

FOLDER = Path(__file__).resolve().parent
BEGIN, END = "<!-- tables: made by docs/make_reference.py, not by hand -->", "<!-- end of the tables -->"

INTRODUCTION = """# Forces, shapes, velocities, emitters, interactions, colliders, integrators

`python docs/make_reference.py` makes this page from the docstrings and parameters of the classes.

- Each name is a key in YAML. In Python it is a class, `ga.forces.Gravity` for example, whose arguments are the parameters in
  the same order.
- The value of a key is a mapping of parameters, or the value of the first parameter alone: `gravity: [0, -9.81, 0]`.
- Units are SI, unless `units:` of the preset says otherwise. Angles are degrees in YAML and radians in Python.
- abs(w) is the length of a vector w.
"""

SECTIONS = (
    (
        "forces",
        "Forces",
        "Under `forces:` of the preset they act on every system; under `forces:` of a system, on that system. Those marked "
        "*field* may also stand under `medium:`. Their vector is then a velocity of the medium in m/s, towards which drag and "
        "damping accelerate particles.\n\n![what each force does to particles](images/forces.webp)",
    ),
    (
        "shapes",
        "Shapes",
        "Where particles are born: `shape:` of an emitter. Positions are relative to the emitter. A vector alone is a `point`."
        "\n\n![particles in each shape](images/shapes.webp)",
    ),
    (
        "velocities",
        "Velocities",
        "The velocity of particles at birth: `velocity:` of an emitter. The first parameter is the value of the name, and the "
        "others stand beside it: `velocity: {cone: [0, 1, 0], angle: 6, speed: 92..98}`. A vector alone is `constant`.",
    ),
    (
        "emitters",
        "Emitters",
        "They set position, velocity and more at once: the name stands in the emitter itself, instead of shape and velocity.",
    ),
    ("interactions", "Interactions", "Forces between particles: `interactions:` of a system."),
    (
        "colliders",
        "Colliders",
        "Surfaces that particles do not pass. Under `colliders:` of the preset they stop every system; under `colliders:` of a "
        "system, that system. A list of mappings makes several of a kind. A particle touches a surface where its distance is its "
        "radius. All take `restitution`, `friction` (kinetic..static), `action` and `velocity`.",
    ),
)

INTEGRATION = """## Integrators

`integrator:` of a system. K(a) is a kick over a fraction a of the time step dt: it changes velocities. D(b) is a drift over a
fraction b: x += b dt v. A kick solves constant acceleration and drag together, with the medium's velocity u held constant for the
time h = a dt of the kick:

```text
linear            v = u + g/k + (v0 - u - g/k) exp(-k h)        rate k (1/s), all other acceleration g
with a quadratic  w = w0 A exp(-A h) / (A + B abs(w0) (1 - exp(-A h))),  w = v - u, A = k, B the quadratic rate (1/m)
magnetic          Boris: half of the kick, a rotation about B that keeps the speed exactly, the other half
```

The Runge-Kutta schemes are given by their nodes (fractions of dt) and weights; their stages include drag.
[integrators.md](integrators.md) compares all schemes.
"""

DOCUMENTED = {  # class: heading of its table
    clock.Clock: "clock:",
    schema.Units: "units:",
    domain.Domain: "domain:",
    domain.Periodic: "periodic: of the domain",
    schema.SystemSpec: "systems.NAME:",
    emitter.EmitterSpec: "systems.NAME.emitters.NAME:",
    emitter.Attributes: "particle: of a system (an emitter and a choice may have the same keys)",
    emitter.FromEvent: "from: of an emitter",
    emitter.Choice: "choose.NAME: of an emitter",
    emitter.MotionSpec: "motion: of an emitter",
    emitter.EmitterOrbit: "orbit: of a motion",
    schema.Gallery: "gallery:",
    emitter.PulseSpec: "pulse: of an emitter",
    look.Look: "look: of a system",
    look.Emission: "emission: of a look",
    look.Ramp: "numbers of a look (they may follow a quantity)",
    look.Color: "colours of a look",
    look.Picture: "picture: of a look",
    light.Light: "light: of the preset, or of a look",
    surface.Ground: "ground:",
    surface.SurfaceLook: "look: of a collider",
    surface.Checker: "checker: of a surface",
    surface.SurfaceImage: "image: of a surface",
    surface.Relief: "relief: of a surface",
    surface.Puddles: "puddles: of a surface",
    surface.Waves: "waves: of a surface",
    surface.Finish: "finish: of a look",
    liquid.Liquid: "liquid: of a look",
    disc_shape.Stretch: "stretch: of a look",
    disc_shape.Spread: "spread: of a look",
    look.Trail: "trail: of a look",
    look.Flashes: "flashes: of a look",
    look.Ribbon: "ribbon: of a look",
    look.Legend: "legend: of a look",
    camera.CameraSpec: "camera:",
    camera.CameraKey: "path: of the camera, a list of",
    camera.CameraOrbit: "orbit: of the camera",
    camera.Follow: "follow: of the camera",
    camera.Frame: "frame: of the camera",
    camera.Shake: "shake: of the camera",
    camera.Lens: "lens: of the camera",
    camera.Fog: "fog: of the camera",
    sky.Sky: "sky:",
    sky.Sun: "sun: of the sky",
    sky.Stars: "stars: of the sky",
    sky.Band: "band: of the sky",
    sky.Softbox: "softboxes: of the sky, a list of",
    wormhole.Wormhole: "wormhole:",
    black_hole.BlackHole: "black_hole:",
    develop.DevelopSpec: "develop:",
    develop.Bloom: "bloom: of develop",
    develop.AutoExposure: "auto_exposure: of develop",
    labels.Label: "labels:, a list of",
    axes.Axes: "axes:",
    axes.Axis: "x:, y:, z: of axes",
    expect.Expect: "expect:",
    expect.Drift: "energy:, momentum:, angular_momentum:, mass:, charge: of expect (one or a list)",
    expect.LedgerGap: "ledger: of expect (one or a list)",
    expect.Quantity: "keys of a period, a value and a range of expect",
    expect.Period: "period: of expect (one or a list)",
    expect.Value: "value: of expect (one or a list)",
    expect.Range: "range: of expect (one or a list)",
}


def number(value: float) -> str:
    """A number with up to ten digits."""
    return f"{value:.10g}"


def cell(value) -> str:
    """A default as YAML writes it."""
    if value is None or value == () or value == {}:
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, (int, float)):
        return f"`{number(value)}`"
    if isinstance(value, (tuple, list)):
        return f"`[{', '.join(number(v) if isinstance(v, (int, float)) else str(v) for v in value)}]`"
    return f"`{value}`"


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(text.replace("|", "\\|") for text in line) + " |" for line in lines)


def limits(parameter) -> str:
    """The closed range of a parameter, in the unit YAML uses; empty where there is none."""
    if parameter.kind == "choice":
        return ", ".join(f"`{c}`" for c in parameter.choices)
    convert = math.degrees if in_degrees(parameter) else float
    low, high = convert(parameter.minimum), convert(parameter.maximum)
    if low == -math.inf and high == math.inf:
        return ""
    if high == math.inf:
        return "above 0" if 0 < low < 1e-6 else f"at least {number(low)}"
    return f"{number(low)} to {number(high)}"


def default(parameter) -> str:
    value = parameter.default
    if parameter.required:
        return "required"
    if parameter.kind == "range":
        low, high = value
        return f"`{number(low)}`" if low == high else f"`{number(low)}..{number(high)}`"
    if in_degrees(parameter) and value is not None:
        several = isinstance(value, tuple)
        turned = [round(math.degrees(part), 6) for part in (value if several else (value,))]
        value = tuple(turned) if several else turned[0]
    return cell(value)


def words(cls) -> str:
    """The docstring: its first paragraph as prose, the rest (formula, units, source) unchanged."""
    first, _, rest = inspect.cleandoc(cls.__doc__).partition("\n\n")
    prose = " ".join(first.split())
    return f"{prose}\n\n```text\n{rest.strip()}\n```" if rest.strip() else prose


def traits(kind: str, cls) -> str:
    if kind != "forces":
        return ""
    says = [(cls.conservative, "conservative"), (cls.dissipative, "dissipative"), (not cls.does_work, "does no work"),
            (is_field(cls), "field")]  # fmt: skip
    found = ", ".join(word for true, word in says if true)
    return f"*{found}*\n\n" if found else ""


def entry(kind: str, name: str) -> str:
    cls = registry(kind)[name]
    text = f"### {name}\n\n{traits(kind, cls)}{words(cls)}\n"
    rows = [
        (f"`{key}`", default(p), "degrees" if in_degrees(p) else p.unit, limits(p), p.doc)
        for key, p in parameters(cls).items()
    ]
    return text + ("\n" + table(("parameter", "default", "unit", "range", "meaning"), rows) + "\n" if rows else "")


def composition(scheme) -> str:
    """The kicks and drifts of one step of a scheme, or its nodes and weights."""

    def share(x: float) -> str:
        nice = Fraction(x).limit_denominator(12)
        return str(nice) if abs(nice - x) < 1e-12 else f"{x:.4f}"

    if scheme.kind == "runge_kutta":
        nodes = ", ".join(share(time) for _, time, _ in scheme.stages)
        weights = ", ".join(share(weight) for weight, _, _ in scheme.stages)
        return f"nodes {nodes}; weights {weights}"
    parts = [f"D({share(scheme.first_drift)})"] if scheme.first_drift else []
    for kick, _, drift in scheme.stages:
        parts += [f"K({share(kick)})"] + ([f"D({share(drift)})"] if drift else [])
    return " ".join(parts)


def built_in(kind: str) -> list[str]:
    """The names that come with the package, without those of loaded plugins."""
    return sorted(name for name in registry(kind) if registry(kind)[name].__module__.startswith("gen_art."))


def forces_page() -> str:
    parts = [INTRODUCTION]
    for kind, title, about in SECTIONS:
        parts.append(f"## {title}\n\n{about}\n")
        parts += [entry(kind, name) for name in built_in(kind)]
    rows = [(f"`{s.name}`", str(s.order), composition(s), s.doc) for s in INTEGRATORS.values()]
    parts.append(INTEGRATION + "\n" + table(("integrator", "order", "a step", "remarks"), rows) + "\n")
    return "\n".join(parts)


def choices(annotation) -> str:
    """The words that a Literal anywhere in the annotation allows."""
    if typing.get_origin(annotation) is typing.Literal:
        return ", ".join(f"`{word}`" for word in typing.get_args(annotation))
    return next((found for part in typing.get_args(annotation) if (found := choices(part))), "")


def field_default(field) -> str:
    if field.is_required():
        return "required"
    value = field.default
    if isinstance(value, look.Ramp) and value.constant:
        return cell(value.curve.points[0][1])
    if isinstance(value, (look.Color, develop.Bloom)):
        return cell(value.gradient.stops[0][1] if isinstance(value, look.Color) else value.strength)
    if hasattr(value, "stops"):
        return cell(value.stops[0][1])
    if hasattr(value, "points"):
        return cell(value.points[0][1])
    return cell(value) if not hasattr(type(value), "model_fields") else ""


def model(cls, where: str) -> str:
    rows = []
    own = [n for base in cls.__mro__[1:2] if base in (emitter.Attributes, expect.Quantity) for n in base.model_fields]
    for name, field in cls.model_fields.items():
        if field.exclude or name in own:
            continue
        meaning = field.description or ""
        allowed = choices(field.annotation)
        if all(word in meaning for word in allowed.split(", ")):
            allowed = ""
        words_of = ": ".join(text for text in (allowed, meaning) if text)
        rows.append((f"`{field.alias or name}`", field_default(field), words_of))
    entries = table(("key", "default", "meaning"), rows)
    return f"### {where}\n\n{inspect.cleandoc(cls.__doc__)}\n\n{entries}\n"


def preset_tables() -> str:
    return "\n".join(model(cls, where) for cls, where in DOCUMENTED.items())


def pages() -> dict[Path, str]:
    """The text that each page should have, by path."""
    presets = FOLDER / "presets.md"
    before, _, rest = presets.read_text(encoding="utf-8").partition(BEGIN)
    after = rest.partition(END)[2]
    return {
        FOLDER / "forces.md": forces_page(),
        presets: f"{before}{BEGIN}\n\n{preset_tables()}\n{END}{after}",
    }


def main() -> int:
    stale = [path for path, text in pages().items() if not path.exists() or path.read_text(encoding="utf-8") != text]
    for path in stale:
        print(f"{path.name} is out of date")
        if "--check" not in sys.argv:
            path.write_text(pages()[path], encoding="utf-8")
    return 1 if stale and "--check" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
