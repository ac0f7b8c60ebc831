"""Nothing comes without its formula, its page, its test and, for a preset, its picture."""

import importlib
import re
import sys
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pytest
from PIL import Image

from gen_art.integrators import INTEGRATORS
from gen_art.preset.registered import parameters, registry
from gen_art.preset.shipped import preset_names, presets_folder

ROOT = Path(__file__).resolve().parent.parent
KINDS = ("forces", "shapes", "velocities", "emitters", "interactions", "colliders")
STILL_LIMIT, LOOP_LIMIT = 600_000, 1_000_000


def built_in(kind: str) -> list[str]:
    return sorted(n for n in registry(kind) if registry(kind)[n].__module__.startswith("gen_art."))


CLASSES = [(kind, name) for kind in KINDS for name in built_in(kind)]
PAGE = (ROOT / "docs" / "forces.md").read_text(encoding="utf-8")
TESTS = "\n".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "tests" / "physics").glob("*.py")))


def _module(name: str):
    """A script of docs/, which also finds its neighbours there."""
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(ROOT / "docs"))


@pytest.fixture(scope="module")
def reference():
    return _module("make_reference")


@pytest.fixture(scope="module")
def thumbnails():
    return _module("make_thumbnails")


def test_there_is_something_to_check():
    assert len(CLASSES) > 25 and len(INTEGRATORS) >= 7
    assert {"smoke", "fire", "fireworks", "wormhole", "galaxy", "charged"} <= set(preset_names())


@pytest.mark.parametrize("kind,name", CLASSES)
def test_docstring_says_formula_and_units(kind, name):
    cls = registry(kind)[name]
    assert cls.__dict__.get("__doc__"), "the docstring is its own, not its parent's"
    summary, _, rest = cls.__doc__.strip().partition("\n\n")
    assert len(summary.split()) >= 2
    assert re.search(r"[=<]", rest), "a formula follows the first paragraph"
    explained = cls.__doc__ + " ".join(p.doc for p in cls.parameters.values())
    for key, parameter in parameters(cls).items():
        assert parameter.doc or parameter.unit or re.search(rf"\b{key}\b", explained), (
            f"{key} has neither unit nor meaning"
        )


@pytest.mark.parametrize("kind,name", CLASSES)
def test_documented(kind, name):
    assert re.search(rf"^### {name}$", PAGE, re.M), "run docs/make_reference.py"


@pytest.mark.parametrize("kind,name", CLASSES)
def test_tested(kind, name):
    """By its name in YAML, as a key or a parameter, or by its class."""
    cls = registry(kind)[name]
    assert re.search(rf"""["']{name}["']|\b{cls.__name__}\(""", TESTS), f"{name} has no test in tests/physics"


@pytest.mark.parametrize("name", INTEGRATORS)
def test_integrators(name):
    """A remark, a row in the page, a test, and stages that make a whole step of kicks, and of drifts."""
    scheme = INTEGRATORS[name]
    assert len(scheme.doc.split()) >= 2
    assert f"| `{name}` | {scheme.order} |" in PAGE, "run docs/make_reference.py"
    assert re.search(rf"""["']{name}["']""", TESTS)
    assert sum(kick for kick, _, _ in scheme.stages) == pytest.approx(1, abs=1e-12)
    if scheme.kind == "splitting":
        assert scheme.first_drift + sum(drift for _, _, drift in scheme.stages) == pytest.approx(1, abs=1e-12)


def test_the_pages_are_up_to_date(reference):
    for path, text in reference.pages().items():
        assert path.read_text(encoding="utf-8") == text, f"{path.name} is out of date: run docs/make_reference.py"


def test_every_name_has_its_thumbnail(thumbnails, monkeypatch):
    """Each scene is a valid preset, and each sheet shows as many as there are names."""
    monkeypatch.chdir(presets_folder())
    for kind, names in thumbnails.names().items():
        sheet = thumbnails.sheets()[kind]
        for name in names:
            thumbnails.scene(sheet, name)
        assert "key" in sheet or set(sheet["names"]) == set(names)
        picture = imageio.imread(ROOT / "docs" / "images" / f"{kind}.webp")
        width, height = sheet.get("size", thumbnails.SIZE)
        rows = -(-len(names) // sheet["columns"])
        assert picture.shape[:2] == (rows * height, sheet["columns"] * width), "run docs/make_thumbnails.py"


def test_every_mapping_of_a_preset_has_its_table_and_every_key_its_words(reference):
    """`MediumSpec` and `Preset` are told in prose; `ParticleSpec` is `Attributes` by another name."""
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
    from gen_art.preset.model import Model

    modules = (
        axes, black_hole, camera, clock, develop, disc_shape, domain, emitter, expect, labels, light, liquid, look, schema, sky, surface,
        wormhole,
    )  # fmt: skip
    found = {
        c for m in modules for c in vars(m).values() if isinstance(c, type) and issubclass(c, Model) and c is not Model
    }
    assert found - {schema.MediumSpec, schema.Preset, emitter.ParticleSpec} == set(reference.DOCUMENTED)
    for cls in reference.DOCUMENTED:
        for name, field in cls.model_fields.items():
            assert field.exclude or field.description, f"{cls.__name__}.{name} has no description"


def test_every_palette_is_named():
    from gen_art.preset.palettes import PALETTES

    page = (ROOT / "docs" / "presets.md").read_text(encoding="utf-8")
    missing = [name for name in PALETTES if not re.search(rf"\b{name}\b", page)]
    assert not missing


def test_a_class_without_a_page_is_noticed(reference):
    assert reference.forces_page() == PAGE
    assert reference.entry("forces", "gravity") in PAGE
    assert reference.entry("forces", "gravity").replace("9.81", "9.82") not in PAGE


@pytest.mark.parametrize("page", ["quickstart.md", "presets.md", "looks.md"])
def test_presets_on_a_page_are_valid(page):
    from gen_art.preset.load import load_preset
    from gen_art.preset.reader import read_text

    found = re.findall(r"^```yaml\n(.*?)^```", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.M | re.S)
    assert found
    for text in found:
        load_preset(read_text(text, page).plain())


@pytest.mark.parametrize("name", preset_names())
def test_preset_begins_with_what_it_shows(name):
    first, second, third = (presets_folder() / f"{name}.yaml").read_text(encoding="utf-8").splitlines()[:3]
    assert first.startswith("# ") and len(first.split()) > 5
    assert second.startswith("# Physics: ")
    assert third.startswith("# Change first: ")
    assert f"[{name}](gallery/{name}.webp)" in (ROOT / "README.md").read_text(encoding="utf-8"), "the README's table"


@pytest.mark.parametrize("name", preset_names())
def test_picture(name):
    """A still of 1280x720 under 600 KB, and a loop 640 wide of three to six seconds under 1 MB, both with something on them."""
    still = ROOT / "gallery" / f"{name}.webp"
    assert still.is_file(), "run gen-art gallery"
    assert still.stat().st_size < STILL_LIMIT
    with Image.open(still) as picture:
        assert picture.size == (1280, 720)
        light = np.asarray(picture.convert("L"))
    assert light.max() > 150 and light.std() > 5
    loop = ROOT / "gallery" / f"{name}.mp4"
    assert loop.is_file() and loop.stat().st_size < LOOP_LIMIT
    import av

    with av.open(str(loop)) as film:
        stream = film.streams.video[0]
        assert stream.width == 640
        assert 3 <= stream.frames / stream.average_rate <= 6


def test_one_module_imports_taichi():
    """`runtime` and the patches it imports: so Taichi starts as `runtime` sets it, whichever module is imported first."""
    found = {
        path.name
        for path in (ROOT / "gen_art").rglob("*.py")
        if re.search(r"^\s*(from|import) taichi", path.read_text(encoding="utf-8"), re.M)
    }
    patches = {"tracing_patch.py", "real_function_patch.py", "launch_patch.py", "machine_code.py"}
    assert found == {"runtime.py", "compile_errors.py", *patches}
