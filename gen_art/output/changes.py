"""What differs between two presets' plain data: a list of (path, value) that turns one into the other."""

from typing import Any

from gen_art.errors import UsageError

__all__ = ["apply_changes", "changes_between"]


def changes_between(before: Any, after: Any, path: tuple = ()) -> list[list]:
    """[[path, value], ...]: what to set in `before`, plain data, to have `after`; a path is a list of keys and indices.

    A mapping or list whose keys or length differ is set as a whole.
    """
    if isinstance(before, dict) and isinstance(after, dict) and before.keys() == after.keys():
        return [change for key in before for change in changes_between(before[key], after[key], (*path, key))]
    if isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        return [c for k, pair in enumerate(zip(before, after)) for c in changes_between(*pair, (*path, k))]
    same = before == after and type(before) is type(after)
    return [] if same else [[list(path), after]]


def apply_changes(data: dict, changes: list) -> dict:
    """The data with changes made, as a copy where they are. Raises UsageError for a path that is not in the data."""
    for path, value in changes:
        data = _set(data, path, value)
    return data


def _set(node: Any, path: list, value: Any) -> Any:
    if not path:
        return value
    key = path[0]
    inside = key in node if isinstance(node, dict) else isinstance(node, list) and key in range(len(node))
    if not inside:
        raise UsageError(
            f"the recipe is damaged: it changes {'.'.join(map(str, path))}, which the preset does not have"
        )
    copy = dict(node) if isinstance(node, dict) else list(node)
    copy[key] = _set(node[key], path[1:], value)
    return copy
