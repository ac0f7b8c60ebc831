"""The recipe of a picture or film: everything that is needed to make it again, as JSON inside the file.

It holds the resolved preset and seed, the version, what was rendered (time or frames, size, precision, quality), how
`camera.frame` moved the camera, the verdict on the preset's `expect:`, and the name and sha256 of each plugin and file. It also
holds the bytes of small files, but never those of plugins, which are code. The recipe of a picture whose looks go by joules
holds the ledger's totals too.
"""

import base64
import binascii
import hashlib
import json
import zlib
from importlib import metadata
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from gen_art.errors import UsageError
from gen_art.files import below, sha256
from gen_art.preset.verdicts import verdict_of

__all__ = ["FORMAT", "KEY", "check_complete", "encode", "find_files", "make_recipe", "verify", "version"]

KEY = "gen-art"
FORMAT = 1
LARGEST_FILE = 16_000  # bytes of a file that is put into the recipe
LARGEST_FILES = 24_000  # bytes of all files in a recipe: EXIF holds 65,000 characters


def version() -> str:
    """The installed version, or the version of the source tree."""
    try:
        return metadata.version("gen-art")
    except metadata.PackageNotFoundError:
        import gen_art

        return getattr(gen_art, "__version__", "0")


def make_recipe(preset, *, plugins=(), fit=None, files=None, **job) -> dict:
    """The recipe of a picture or film of `preset`; `job` says what was rendered, `fit` is that of `camera.frame`.

    files : those that it needs; the preset's when None
    """
    verdict = verdict_of(preset, version())
    return {
        "format": FORMAT,
        "gen_art": version(),
        "name": preset.name,
        **job,
        **({"fit": {"move": list(fit.move), "factor": fit.factor}} if fit is not None else {}),
        **({"expect": verdict} if verdict is not None else {}),
        "plugins": [{"name": p.name, "sha256": p.sha256} for p in plugins],
        "files": _file_entries(preset.files if files is None else files),
        "preset": preset.resolved(),
    }


def _file_entries(files) -> list[dict]:
    """Path and sha256 of each file, and its bytes (zlib, base64) if it is small."""
    entries: list[dict] = []
    room = LARGEST_FILES
    for file in files:
        entry = {"path": str(file), "sha256": sha256(file.place)}
        size = file.place.stat().st_size
        if size <= min(LARGEST_FILE, room):
            room -= size
            entry = {**entry, "data": base64.b64encode(zlib.compress(file.place.read_bytes(), 9)).decode("ascii")}
        entries.append(entry)
    return entries


def encode(recipe: dict) -> str:
    """One line of ASCII JSON."""
    return json.dumps(recipe, separators=(",", ":"), allow_nan=False)


class _Entry(BaseModel):
    """A plugin, or a file with its bytes if it is small."""

    model_config = ConfigDict(strict=True)
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class _File(_Entry):
    path: str
    data: str = ""


class _Plugin(_Entry):
    name: str


class _Joules(BaseModel):
    """An entry of the ledger that a look of the picture goes by, at the picture's time."""

    model_config = ConfigDict(strict=True)
    system: str
    by: str | dict[str, str]
    total: Annotated[float, Field(allow_inf_nan=False)]
    unit: str


class _Fit(BaseModel):
    """How `camera.frame` moved the camera."""

    model_config = ConfigDict(strict=True)
    move: Annotated[list[Annotated[float, Field(allow_inf_nan=False)]], Field(min_length=3, max_length=3)]
    factor: Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Job(BaseModel):
    """What every recipe holds; further keys are ignored."""

    model_config = ConfigDict(strict=True)
    gen_art: str
    name: str
    preset: dict
    size: Annotated[list[Annotated[int, Field(ge=1, le=16384)]], Field(min_length=2, max_length=2)]
    precision: Literal["f32", "f64"]
    transparent: bool
    quality: Literal["draft", "preview", "final"]
    plugins: list[_Plugin]
    files: list[_File]
    bits: Literal[8, 10, 16, 32] | None = None
    joules: list[_Joules] = []
    fit: _Fit | None = None


class _Still(_Job):
    kind: Literal["still"]
    time: Annotated[float, Field(ge=0, allow_inf_nan=False)]


class _Cell(BaseModel):
    """A cell of a sheet: its words, and what it changes in the preset of the first cell."""

    model_config = ConfigDict(strict=True)
    label: str
    time: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    changes: list[Annotated[list, Field(min_length=2, max_length=2)]]

    @field_validator("changes")
    @classmethod
    def _paths(cls, changes: list[list]) -> list[list]:
        if not all(isinstance(path, list) and all(isinstance(k, (str, int)) for k in path) for path, _ in changes):
            raise ValueError("a change is a path and a value")
        return changes


class _Sheet(_Job):
    kind: Literal["sheet"]
    cells: Annotated[list[Annotated[list[_Cell], Field(min_length=1)]], Field(min_length=1)]


class _Film(_Job):
    kind: Literal["film"]
    frames: Annotated[list[Annotated[int, Field(ge=0, lt=10**9)]], Field(min_length=3, max_length=3)]
    ending: str = ""
    codec: str | None = None
    profile: str | None = None
    max_rate: Annotated[int, Field(ge=0, lt=2**31)] = 0

    @field_validator("frames")
    @classmethod
    def _in_order(cls, frames: list[int]) -> list[int]:
        first, last, step = frames
        if step < 1 or last < first:
            raise ValueError("first, last and step name no frame")
        return frames


_JOBS: dict[str, type[_Job]] = {"film": _Film, "sheet": _Sheet, "still": _Still}


def check_complete(recipe: dict) -> None:
    """Raise UsageError for a recipe with missing keys or values of the wrong type."""
    try:
        _JOBS.get(str(recipe.get("kind")), _Still).model_validate(recipe)
    except ValidationError as error:
        wrong = dict.fromkeys(str(item["loc"][0]) for item in error.errors())
        raise UsageError(f"the recipe is damaged: {', '.join(wrong)}") from None


def verify(recipe: dict, plugins, other_version: bool = False) -> str | None:
    """Raise UsageError unless the recipe is complete and its version and plugins are the ones at hand.

    other_version : accept a picture of another version; the result is then a warning to show, otherwise None
    """
    check_complete(recipe)
    warning = None
    if recipe["gen_art"] != version():
        warning = f"the picture was made by gen-art {recipe['gen_art']}; this is {version()}, whose pictures may differ"
        if not other_version:
            raise UsageError(f"{warning}: --other-version makes it anyway")
    given = {p.sha256: p for p in plugins}
    for plugin in recipe["plugins"]:
        if plugin["sha256"] not in given:
            same_name = [p for p in plugins if p.name == plugin["name"]]
            problem = "differs from the one that the picture was made with" if same_name else "is needed: give --plugin"
            raise UsageError(f"plugin {plugin['name']} (sha256 {plugin['sha256'][:12]}) {problem}")
    return warning


def find_files(recipe: dict, folders, scratch: Path | None = None) -> Path:
    """The folder that holds the recipe's files: one of `folders`, or `scratch`, to which the recipe's copies are written.

    Raises UsageError when a file is neither in a folder nor in the recipe, or differs from the original.
    """
    files = recipe["files"]
    try:
        return _folder_of(files, folders)
    except UsageError:
        if scratch is None or not all(file.get("data") for file in files):
            raise
    for file in files:
        if "data" in file:
            _unpack(file, scratch)
    return scratch


def _unpack(file: dict, folder: Path) -> None:
    try:
        data = zlib.decompressobj().decompress(base64.b64decode(file["data"], validate=True), LARGEST_FILE + 1)
    except (binascii.Error, zlib.error, ValueError):
        data = b""
    if hashlib.sha256(data).hexdigest() != file["sha256"]:
        raise UsageError(f"the recipe is damaged: the bytes of {file['path']} do not match its sha256")
    target = below(folder, file["path"])
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)


def _folder_of(files: list[dict], folders) -> Path:
    """The first folder that holds all files with their bytes."""
    expected = {file["path"]: file["sha256"] for file in files}
    differs = None
    for folder in folders:
        found = {name: _digest(folder, name) for name in expected}
        if found == expected and all(file["sha256"] == expected[file["path"]] for file in files):
            return folder
        wrong = [name for name, digest in found.items() if digest not in (None, expected[name])]
        differs = differs or (folder / wrong[0], expected[wrong[0]]) if wrong else differs
    if differs:
        raise UsageError(f"{differs[0]} is not the file that the picture was made with (sha256 {differs[1][:12]})")
    names = ", ".join(file["path"] for file in files)
    raise UsageError(
        f"the picture was made with {names}, which is not in {' or '.join(str(folder.resolve()) for folder in folders)}: "
        "give --folder, the folder of its preset"
    )


def _digest(folder: Path, name: str) -> str | None:
    """The sha256 of a file in the folder or below it; None if there is none."""
    path = below(folder, name)
    return sha256(path) if path.is_file() else None
