"""The optional extras of this package (`pip install 'gen-art[exr]'`), and which of them are installed.

What each extra needs is read from the package's metadata: that of the source checkout, or else of the installed package.
"""

import importlib.util
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from gen_art.errors import UsageError

__all__ = ["PURPOSES", "Extra", "check_installed", "extras"]

PURPOSES = {
    "exr": "pictures of linear light as .exr",
    "plots": "plots of gen-art audit",
    "histories": "records of a run as tables, .parquet and .zarr",
    "units": "numbers with a unit, of astropy or pint, in scripts",
    "studio": "gen-art studio and gen-art watch",
    "farm": "gen-art sweep on several processes or a cluster",
    "notebook": "a preset played with a slider in a notebook, by ga.play",
    "docs": "the documentation as a site, by make docs",
    "bench": "other programs that gen-art bench measures beside this one",
    "dev": "the tests and checks of the source checkout",
}
_PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"
_REQUIREMENT = re.compile(r"(?P<name>[\w.-]+)\s*(?:(?:>=|==)\s*(?P<version>[\w.]+))?")


@dataclass(frozen=True)
class Extra:
    """One extra.

    purpose : what it is for
    missing : the packages, as pip takes them, that are not installed or too old
    """

    name: str
    purpose: str
    missing: tuple[str, ...]

    @property
    def installed(self) -> bool:
        return not self.missing


def check_installed(what: str, *packages: str) -> None:
    """Raise UsageError that names what `what` needs, if one of these packages cannot be imported."""
    missing = [name for name in packages if importlib.util.find_spec(name) is None]
    if missing:
        verb = "is" if len(missing) == 1 else "are"
        names = " ".join(missing)
        raise UsageError(f"{what} needs {' and '.join(missing)}, which {verb} not installed: pip install {names}")


def extras() -> list[Extra]:
    """All extras, in the order of the metadata."""
    return [
        Extra(name, PURPOSES.get(name, ""), tuple(r for r in requirements if not _satisfied(r)))
        for name, requirements in _requirements().items()
    ]


def _requirements() -> dict[str, list[str]]:
    """extra -> its requirements: {"exr": ["OpenEXR>=3.3"]}."""
    project = tomllib.loads(_PROJECT.read_text(encoding="utf-8")).get("project", {}) if _PROJECT.is_file() else {}
    if project.get("name") == "gen-art":
        return project["optional-dependencies"]
    try:
        return _of_metadata(metadata.metadata("gen-art"))
    except metadata.PackageNotFoundError:
        return {}


def _of_metadata(installed: metadata.PackageMetadata) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {name: [] for name in installed.get_all("Provides-Extra") or ()}
    rows: Iterable[str] = installed.get_all("Requires-Dist") or ()
    for row in rows:
        requirement, _, condition = row.partition(";")
        if extra := re.search(r"""extra\s*==\s*['"]([\w.-]+)['"]""", condition):
            found.setdefault(extra[1], []).append(requirement.strip())
    return found


def _satisfied(requirement: str) -> bool:
    """Whether a package is installed in at least the version of `name>=version`."""
    wanted = _REQUIREMENT.match(requirement)
    assert wanted is not None, requirement
    try:
        installed = metadata.version(wanted["name"])
    except metadata.PackageNotFoundError:
        return False
    return _numbers(installed) >= _numbers(wanted["version"] or "0")


def _numbers(version: str) -> list[int]:
    """3.11.2 -> [3, 11, 2], up to the first part that is no number."""
    numbers = []
    for part in version.split("."):
        if not (leading := re.match(r"\d+", part)):
            break
        numbers.append(int(leading[0]))
        if leading[0] != part:
            break
    return numbers
