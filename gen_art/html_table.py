"""Tables in HTML, by which a notebook shows an object."""

from collections.abc import Iterable, Sequence
from html import escape

__all__ = ["html_table", "vector_text"]

_LEFT = ' style="text-align: left"'  # notebooks put cells to the right


def html_table(caption: str, rows: Iterable[Sequence[object]], columns: Sequence[str] = ()) -> str:
    """A table in plain HTML without colours of its own: it is read on a light and on a dark page alike.

    caption : the line above the table
    rows : the cells of each row, shown as `str` has them; the first is the row's heading
    columns : the headings of the columns, if there are any
    """
    lines = [f"<table><caption{_LEFT}>{escape(caption)}</caption>"]
    if columns:
        headings = "".join(f'<th scope="col"{_LEFT}>{escape(name)}</th>' for name in columns)
        lines.append(f"<thead><tr>{headings}</tr></thead>")
    lines.append("<tbody>")
    for first, *others in rows:
        cells = "".join(f"<td{_LEFT}>{escape(str(cell))}</td>" for cell in others)
        lines.append(f'<tr><th scope="row"{_LEFT}>{escape(str(first))}</th>{cells}</tr>')
    lines.append("</tbody></table>")
    return "\n".join(lines)


def vector_text(vector: Iterable[float]) -> str:
    """A vector as text, six digits a component."""
    return f"({', '.join(f'{component:.6g}' for component in vector)})"
