"""Verdicts of `gen-art check`, kept in verdicts.json beside the presets, from where they come into the recipe of each picture."""

import hashlib
import json
from pathlib import Path
from typing import Any

from gen_art.files import beside, sha256

__all__ = ["FILE", "keep", "key", "verdict_of"]

FILE = "verdicts.json"
NOT_CHECKED = {"verdict": "not checked"}
_LARGEST = 10_000_000  # bytes of FILE that are read
_ONLY_LOOKS = (
    "axes", "camera", "develop", "gallery", "ground", "labels", "light", "seed", "shadows", "sky",
)  # fmt: skip  # keys that change no motion; the seed is in the verdict


def key(preset, version: str) -> str:
    """A digest of all that the motion and the expectations of a preset depend on: its laws, its files, the version of gen-art."""
    data = {name: value for name, value in preset.resolved().items() if name not in _ONLY_LOOKS}
    data["systems"] = {
        name: {part: value for part, value in system.items() if part != "look"}
        for name, system in data["systems"].items()
    }
    for part in (data, *data["systems"].values()):
        if "colliders" in part:
            part["colliders"] = _without_looks(part["colliders"])
    files = [(str(file), sha256(file.place)) for file in preset.files]
    text = json.dumps([version, data, files], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _without_looks(colliders: dict | None) -> dict:
    """Colliders as plain data without their looks; several of a kind are a list."""

    def bare(value):
        if isinstance(value, list):
            return [bare(item) for item in value]
        return {k: v for k, v in value.items() if k != "look"} if isinstance(value, dict) else value

    return {name: bare(value) for name, value in (colliders or {}).items()}


def verdict_of(preset, version: str) -> dict[str, Any] | None:
    """What a picture's recipe says of the preset's `expect:`: its verdict, or that it was not checked; None without `expect`."""
    if preset.expect is None:
        return None
    if preset.verdict is not None:
        return preset.verdict
    here = key(preset, version)
    found = (verdict for verdict in _read(preset.folder).values() if verdict.get("key") == here)
    return next(({k: v for k, v in verdict.items() if k != "key"} for verdict in found), NOT_CHECKED)


def keep(preset, verdict: dict[str, Any], version: str) -> Path:
    """Put a verdict into FILE in the preset's folder, in place of an earlier one.

    Raises OutputError where it cannot be written.
    """
    path = preset.folder / FILE
    all_of_them = {**_read(preset.folder), preset.name: {**verdict, "gen_art": version, "key": key(preset, version)}}
    lines = [f"{json.dumps(name)}: {json.dumps(all_of_them[name])}" for name in sorted(all_of_them)]
    with beside(path) as temporary:
        temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    return path


def _read(folder: Path) -> dict[str, dict]:
    """The verdicts of a folder, by the preset's name; none from a file that is damaged or missing."""
    path = folder / FILE
    try:
        if not path.is_file() or path.stat().st_size > _LARGEST:
            return {}
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return {name: one for name, one in data.items() if isinstance(one, dict)} if isinstance(data, dict) else {}
