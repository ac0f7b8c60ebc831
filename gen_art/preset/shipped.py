"""The presets that come with the package, and the file that a PRESET on the command line names."""

import difflib
from pathlib import Path

from gen_art.errors import UsageError

__all__ = ["course_names", "find", "preset_names", "presets_folder", "starter"]


def presets_folder() -> Path:
    """The folder of the shipped presets: in the installed package, or beside it in a source checkout."""
    package = Path(__file__).resolve().parent.parent
    inside = package / "presets"
    return inside if inside.is_dir() else package.parent / "presets"


def preset_names() -> list[str]:
    """The names of the large presets."""
    return sorted(path.stem for path in presets_folder().glob("*.yaml"))


def course_names() -> list[str]:
    """The names of the small presets that show one law of physics each: course/NAME."""
    return sorted(f"course/{path.stem}" for path in (presets_folder() / "course").glob("*.yaml"))


def starter() -> Path:
    """The commented preset that `gen-art new` copies."""
    return Path(__file__).with_name("starter.yaml")


def find(name: str) -> Path:
    """The file of a shipped preset's name, or a path. Raises UsageError, with the nearest name, for other text."""
    shipped = presets_folder() / f"{name}.yaml"
    if name in preset_names() or name in course_names():
        return shipped
    path = Path(name)
    if path.suffix.lower() in (".yaml", ".yml") or len(path.parts) > 1 or path.exists():
        return path
    near = difflib.get_close_matches(name, [*preset_names(), *course_names()], n=1)
    raise UsageError(
        f"there is no preset '{name}'{f'; did you mean {near[0]!r}?' if near else ''} "
        "(`gen-art list` names them; a file of your own is given by its path)"
    )
