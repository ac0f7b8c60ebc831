"""What the pages of the tour, the recipes and docs/porting.md contain to be run: files, commands, scripts.

A block of code after "`name.yaml`:" or "`name.py`:" is that file. A Python block without a name is a script. Indented lines
that begin with gen-art are commands. All of a page happen in one folder, in this order.
"""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).resolve().parent
_NAMED = re.compile(r"`([\w.]+\.(?:yaml|py))`:\n\n```\w+\n(.*?)^```", re.M | re.S)
_SCRIPT = re.compile(r"^```python\n(.*?)^```", re.M | re.S)
_COMMAND = re.compile(r"^    gen-art (.*)$", re.M)


@dataclass
class Examples:
    """Of one page: its files by name, its commands as lists of words, its scripts."""

    files: dict[str, str]
    commands: list[list[str]]
    scripts: list[str]


def pages() -> list[Path]:
    """The pages whose examples are run."""
    return [*sorted((DOCS / "tour").glob("*.md")), *sorted((DOCS / "recipes").glob("*.md")), DOCS / "porting.md"]


def examples(page: Path) -> Examples:
    """What there is to be run on a page."""
    text = page.read_text(encoding="utf-8")
    files = dict(_NAMED.findall(text))
    scripts = [script for script in _SCRIPT.findall(text) if script not in files.values()]
    commands = [shlex.split(line.partition("  #")[0]) for line in _COMMAND.findall(text)]
    return Examples(files, commands, scripts)


def write_files(page: Path, folder: Path) -> None:
    """Writes the files of a page into a folder."""
    for name, text in examples(page).files.items():
        (folder / name).write_text(text, encoding="utf-8")
