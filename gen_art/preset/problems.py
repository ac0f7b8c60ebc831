"""The problems of a preset with their places, shown as `file:line:column: path: problem`, the line and a caret."""

from collections.abc import Iterable
from dataclasses import dataclass

from gen_art.errors import PresetError

__all__ = ["Problem", "preset_error", "report", "dotted"]

_WIDTH = 100  # a longer source line is cut


@dataclass(frozen=True, slots=True)
class Problem:
    """One problem.

    path : keys and list indices
    text : the message
    file : name of the file
    line, column : counted from 1; 0 where there is no text
    source : the source line
    """

    path: tuple
    text: str
    file: str = ""
    line: int = 0
    column: int = 0
    source: str = ""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        head = ": ".join(part for part in (place, dotted(self.path), self.text) if part)
        if not self.line or not self.source.strip():
            return head
        line, column = self.source.rstrip("\r\n"), self.column - 1
        if len(line) > _WIDTH:
            start = max(0, min(column - _WIDTH // 2, len(line) - _WIDTH))
            line, column = line[start : start + _WIDTH], column - start
        line = "".join(c if c.isprintable() else " " for c in line)
        return f"{head}\n    {line}\n    {' ' * column}^"


def dotted(path: Iterable) -> str:
    """('systems', 'flame', 'at', 2) -> `systems.flame.at[2]`, as in `--set`."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text if len(text) <= 200 else text[:197] + "..."


def report(problems: list[Problem], limit: int | None = None) -> str:
    """The problems, one below the other; at most `limit` of them, then the number of the others."""
    shown = [str(problem) for problem in problems[:limit]]
    if limit is not None and len(problems) > limit:
        shown.append(f"... and {len(problems) - limit} more; `gen-art validate` lists them all")
    return "\n".join(shown)


def preset_error(problems: list[Problem]) -> PresetError:
    """The exception for these problems, which are its attribute `problems`."""
    error = PresetError(report(problems))
    error.problems = problems  # type: ignore[attr-defined]
    return error
