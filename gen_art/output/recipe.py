"""The recipe of a picture or film: everything that is needed to make it again, as JSON inside the file.

It holds the resolved preset and seed, the version, what was rendered (time or frames, size, precision, quality), and the
name and sha256 of each plugin and file. It also holds the bytes of small files, but never those of plugins, which are code.
"""

import base64
import binascii
import hashlib
import json
import zlib
from importlib import metadata
from pathlib import Path, PurePosixPath

from gen_art.errors import OutputError, UsageError

__all__ = ["FORMAT", "KEY", "encode", "find_files", "make_recipe", "verify", "version"]

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


def sha256(path) -> str:
    """Hex digest of a file. Raises OutputError when it cannot be read."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise OutputError(f"cannot read {path}: {error.strerror or error}") from error


def make_recipe(preset, *, plugins=(), **job) -> dict:
    """The recipe of a picture or film of `preset`; `job` says what was rendered."""
    return {
        "format": FORMAT,
        "gen_art": version(),
        "name": preset.name,
        **job,
        "plugins": [{"name": p.name, "sha256": p.sha256} for p in plugins],
        "files": _file_entries(preset.files),
        "preset": preset.resolved(),
    }


def _file_entries(files) -> list[dict]:
    """Path and sha256 of each file, and its bytes (zlib, base64) if it is small."""
    entries: list[dict] = []
    room = LARGEST_FILES
    for file in files:
        entry = {"path": str(file), "sha256": sha256(file.place)}
        size = file.place.stat().st_size
        is_new = all(other["path"] != entry["path"] for other in entries)
        if is_new and size <= min(LARGEST_FILE, room):
            room -= size
            entry = {**entry, "data": base64.b64encode(zlib.compress(file.place.read_bytes(), 9)).decode("ascii")}
        entries.append(entry)
    return entries


def encode(recipe: dict) -> str:
    """One line of ASCII JSON."""
    return json.dumps(recipe, separators=(",", ":"), allow_nan=False)


_TYPES: dict[str, type | tuple[type, ...]] = {
    "gen_art": str, "name": str, "kind": str, "preset": dict, "size": list, "precision": str, "transparent": bool,
    "quality": str, "plugins": list, "files": list,
}  # fmt: skip


def verify(recipe: dict, plugins, other_version: bool = False) -> str | None:
    """Raise UsageError unless the recipe is complete and its version and plugins are the ones at hand.

    other_version : accept a picture of another version; the result is then a warning to show, otherwise None
    """
    _check_complete(recipe)
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
        if scratch is None or not all("data" in file or _is_repeated(files, k) for k, file in enumerate(files)):
            raise
    for file in files:
        if "data" in file:
            _unpack(file, scratch)
    return scratch


def _is_repeated(files: list[dict], k: int) -> bool:
    """Whether file k is also listed before k: a preset may name a file several times."""
    return any(file["sha256"] == files[k]["sha256"] and file["path"] == files[k]["path"] for file in files[:k])


def _unpack(file: dict, folder: Path) -> None:
    name = PurePosixPath(file["path"].replace("\\", "/"))
    if name.is_absolute() or ".." in name.parts or ":" in file["path"] or not name.parts:
        raise UsageError(f"the recipe is damaged: {file['path']!r} is not a path relative to a preset")
    try:
        data = zlib.decompressobj().decompress(base64.b64decode(file["data"], validate=True), LARGEST_FILE + 1)
    except (binascii.Error, zlib.error, ValueError):
        data = b""
    if hashlib.sha256(data).hexdigest() != file["sha256"]:
        raise UsageError(f"the recipe is damaged: the bytes of {file['path']} do not match its sha256")
    target = folder / name
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(data)


def _check_complete(recipe: dict) -> None:
    """Raise UsageError for a recipe with missing keys or values of the wrong type."""
    by_kind: dict[str, type | tuple[type, ...]]
    by_kind = {"frames": list} if recipe.get("kind") == "film" else {"time": (int, float)}
    wrong = [key for key, kind in {**_TYPES, **by_kind}.items() if not isinstance(recipe.get(key), kind)]
    for key, name in (("plugins", "name"), ("files", "path")):
        entries = recipe[key] if key not in wrong else []
        if not all(isinstance(entry, dict) and _are_texts(entry.get(name), entry.get("sha256")) for entry in entries):
            wrong.append(key)
    if "files" not in wrong and not all(_are_texts(file.get("data", "")) for file in recipe["files"]):
        wrong.append("files")
    if wrong:
        raise UsageError(f"the recipe is damaged: {', '.join(wrong)}")


def _are_texts(*values) -> bool:
    return all(isinstance(value, str) for value in values)


def _folder_of(files: list[dict], folders) -> Path:
    """The first folder that holds all files with their bytes."""
    problems = []
    for folder in folders:
        paths = [folder / file["path"] for file in files]
        if all(path.is_file() and sha256(path) == file["sha256"] for path, file in zip(paths, files)):
            return folder
        problems += [
            f"{path} is not the file that the picture was made with (sha256 {file['sha256'][:12]})"
            for path, file in zip(paths, files)
            if path.is_file() and sha256(path) != file["sha256"]
        ]
    if problems:
        raise UsageError(problems[0])
    names = ", ".join(file["path"] for file in files)
    raise UsageError(
        f"the picture was made with {names}, which is not in {' or '.join(str(folder.resolve()) for folder in folders)}: "
        "give --folder, the folder of its preset"
    )
