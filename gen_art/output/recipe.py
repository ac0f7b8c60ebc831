"""A picture's recipe: all it takes to make it again, as JSON inside the file.

The resolved preset and seed, the version, what was rendered (time or frames, size, precision, quality), and sha256 of the
plugins and files it used.
"""

import hashlib
import json
from importlib import metadata
from pathlib import Path

from gen_art.errors import OutputError, UsageError

__all__ = ["FORMAT", "KEY", "encode", "make_recipe", "verify", "version"]

KEY = "gen-art"
FORMAT = 1


def version() -> str:
    """The installed version, or that of the source tree."""
    try:
        return metadata.version("gen-art")
    except metadata.PackageNotFoundError:
        import gen_art

        return getattr(gen_art, "__version__", "0")


def sha256(path) -> str:
    """Hex digest of a file; OutputError when it cannot be read."""
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
        "files": [{"path": str(file), "sha256": sha256(file.place)} for file in preset.files],
        "preset": preset.resolved(),
    }


def encode(recipe: dict) -> str:
    """One line of ASCII JSON."""
    return json.dumps(recipe, separators=(",", ":"), allow_nan=False)


_KINDS: dict[str, type | tuple[type, ...]] = {
    "gen_art": str, "name": str, "kind": str, "preset": dict, "size": list, "precision": str, "transparent": bool,
    "quality": str, "plugins": list, "files": list,
}  # fmt: skip


def verify(recipe: dict, plugins, folders=(Path(),)) -> Path:
    """The one of `folders` that holds the recipe's files; a file is named as it lies in its preset's folder.

    Raises UsageError unless version, plugins and files are those of the recipe.
    """
    _check_whole(recipe)
    if recipe["gen_art"] != version():
        raise UsageError(
            f"the picture was made by gen-art {recipe['gen_art']}; this is {version()}, whose pictures may differ"
        )
    given = {p.sha256: p for p in plugins}
    for plugin in recipe["plugins"]:
        if plugin["sha256"] not in given:
            same_name = [p for p in plugins if p.name == plugin["name"]]
            problem = "is another text than the one it was made with" if same_name else "is needed: give --plugin"
            raise UsageError(f"plugin {plugin['name']} (sha256 {plugin['sha256'][:12]}) {problem}")
    return _folder_of(recipe["files"], folders)


def _check_whole(recipe: dict) -> None:
    """UsageError for a recipe that this version never wrote."""
    own: dict[str, type | tuple[type, ...]]
    own = {"frames": list} if recipe.get("kind") == "film" else {"time": (int, float)}
    wrong = [key for key, kind in {**_KINDS, **own}.items() if not isinstance(recipe.get(key), kind)]
    for key, name in (("plugins", "name"), ("files", "path")):
        listed = recipe[key] if key not in wrong else []
        if not all(isinstance(one, dict) and _texts(one.get(name), one.get("sha256")) for one in listed):
            wrong.append(key)
    if wrong:
        raise UsageError(f"the recipe is damaged: {', '.join(wrong)}")


def _texts(*values) -> bool:
    return all(isinstance(value, str) for value in values)


def _folder_of(files: list[dict], folders) -> Path:
    other = []
    for folder in folders:
        there = [folder / file["path"] for file in files]
        if all(path.is_file() and sha256(path) == file["sha256"] for path, file in zip(there, files)):
            return folder
        other += [
            f"{path} is not the file that the picture was made with (sha256 {file['sha256'][:12]})"
            for path, file in zip(there, files)
            if path.is_file() and sha256(path) != file["sha256"]
        ]
    if other:
        raise UsageError(other[0])
    names = ", ".join(file["path"] for file in files)
    raise UsageError(
        f"the picture was made with {names}, which is not in {' or '.join(str(folder.resolve()) for folder in folders)}: "
        "give --folder, the folder of its preset"
    )
