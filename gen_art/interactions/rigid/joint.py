"""Joints between rigid bodies: what the user writes, checked, and the rows of equations that each joint is.

A row is a function of the places and attitudes of two bodies, which a joint keeps at 0 or between two bounds.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gen_art.arguments import shown
from gen_art.errors import UsageError
from gen_art.interactions.rigid.body import STATIC, Body
from gen_art.interactions.rigid.quaternions import matrices
from gen_art.interactions.rigid.small_matrices import apply_transposed, cross, norm
from gen_art.quantities import plain
from gen_art.registry import suggest

__all__ = ["ANGLE", "DISTANCE", "DOT", "POINT", "SLIDE", "WORLD", "Joint", "Row", "joints_of", "plain_joints"]

WORLD = "world"
POINT, SLIDE, DOT, DISTANCE, ANGLE = range(5)  # the kinds of rows
_KINDS = ("ball", "hinge", "slider", "distance", "weld")
_MOVING = {
    "hinge": ("torque", "N m"),
    "slider": ("force", "N"),
}  # the joints that can have a motor, and the key of its limit
_UNITS = {
    "hinge": {"range": "degrees", "speed": "rad/s"},
    "slider": {"range": "m", "speed": "m/s"},
    "distance": {"range": "m"},
}
_FAR = 10  # relative to a body's size: a joint farther from its centre is refused


@dataclass(frozen=True)
class Row:
    """One function of two bodies' places.

    kind : POINT, d . t with t fixed in the world, or SLIDE, with t fixed in the second body; DOT, s . t with s fixed in the
        first and t in the second body; DISTANCE, abs(d); ANGLE, from `origin` to s about t, both of the second body, rad
    s, t, origin : (3,), in the frames of the bodies that they are fixed in
    d is the vector from the second body's anchor to the first one's.
    """

    kind: int
    s: np.ndarray
    t: np.ndarray
    origin: np.ndarray


@dataclass(frozen=True)
class Joint:
    """A joint at its start.

    name, kind : text
    first, second : indices of the bodies; -1 is the world
    anchors : two of (3,) m, in the frames of the bodies
    held : the rows that are kept at 0
    length : m, of a distance at the start, which its row is less
    free : the row along which a motor and bounds act, or None
    bounds : (low, high) of the free row, m or rad, or None
    speed, limit : of the motor, m/s or rad/s, and N or N m; speed is None without a motor
    """

    name: str
    kind: str
    first: int
    second: int
    anchors: tuple[np.ndarray, np.ndarray]
    held: tuple[Row, ...]
    length: float
    free: Row | None
    bounds: tuple[float, float] | None
    speed: float | None
    limit: float


def plain_joints(specs: Mapping[str, Any]) -> dict[str, Any]:
    """The same joints with the quantities of astropy or pint as plain numbers. Raises UsageError."""
    return {name: _plain_joint(f"joint '{name}'", spec) for name, spec in specs.items()}


def _plain_joint(where: str, spec):
    if not isinstance(spec, dict):
        return spec
    kind = next((key for key in spec if key in _KINDS), "")
    units = {"at": "m", **_UNITS.get(kind, {}), **dict([_MOVING[kind]] if kind in _MOVING else [])}
    out = {}
    for key, value in spec.items():
        if key == "motor" and isinstance(value, dict):
            out[key] = {part: plain(one, units.get(part, ""), f"{where}: {part}") for part, one in value.items()}
        else:
            out[key] = plain(value, units.get(key, ""), f"{where}: {key}")
    return out


def joints_of(specs: Mapping[str, Any], members: list[Body]) -> list[Joint]:
    """The joints that `specs` describe, by name (see Rigid). Raises UsageError."""
    return [_joint(str(name), spec, members) for name, spec in specs.items()]


def _joint(name: str, spec, members: list[Body]) -> Joint:
    where = f"joint '{name}'"
    if not isinstance(spec, dict):
        raise UsageError(f"{where} must be a mapping, such as {{ball: [a, b], at: [0, 1, 0]}}, not {shown(spec)}")
    kinds = [key for key in spec if key in _KINDS]
    if len(kinds) != 1:
        known = [*_KINDS, "at", "axis", "range", "motor"]
        wrong = next((key for key in spec if key not in known), None)
        hint = f"; it has '{wrong}'{suggest(wrong, known)}" if wrong else ""
        raise UsageError(f"{where} must be one of {', '.join(_KINDS)}{hint}")
    kind = kinds[0]
    allowed = [
        kind,
        "at",
        *(("axis", "motor") if kind in _MOVING else ()),
        *(("range",) if kind not in ("ball", "weld") else ()),
    ]
    for key in spec:
        if key not in allowed:
            raise UsageError(f"{where}: a {kind} has no '{key}'{suggest(key, allowed)}")
    first, second = _bodies(where, spec[kind], members)
    points = _anchors(where, kind, spec.get("at"))
    for point in points:
        _refuse_far(where, point, [members[k] for k in (first, second) if k >= 0])
    frames = [_frame(members, k) for k in (first, second)]
    (x0, R0), (x1, R1) = frames
    anchors = apply_transposed(R0, points[0] - x0), apply_transposed(R1, points[1] - x1)
    inward = [lambda v, R=R: apply_transposed(R, v) for _, R in frames]
    axis = _vector(where, "axis", spec.get("axis", (0, 0, 1)))
    if not norm(axis) > 0:
        raise UsageError(f"{where}: axis must not be the zero vector")
    u = axis / norm(axis)
    helper = np.zeros(3)
    helper[np.abs(u).argmin()] = 1.0
    p = cross(u, helper) / norm(cross(u, helper))
    q = cross(u, p)
    none = np.zeros(3)
    points_held = tuple(Row(POINT, none, e, none) for e in np.eye(3))
    turns_held = tuple(Row(DOT, inward[0](s), inward[1](t), none) for s, t in ((u, p), (u, q), (p, q)))
    across = tuple(Row(SLIDE, none, inward[1](t), none) for t in (p, q))
    distance = Row(DISTANCE, none, none, none)
    held, free = {
        "ball": (points_held, None),
        "weld": (points_held + turns_held, None),
        "hinge": (points_held + turns_held[:2], Row(ANGLE, inward[0](p), inward[1](u), inward[1](p))),
        "slider": (across + turns_held, Row(SLIDE, none, inward[1](u), none)),
        "distance": (() if "range" in spec else (distance,), distance),
    }[kind]
    length = float(norm(points[0] - points[1]))
    if kind == "distance" and not length > 0:
        raise UsageError(f"{where}: the two points of `at` are the same: use a ball, which keeps them together")
    at_start = length if kind == "distance" else 0.0
    bounds = _bounds(where, kind, spec["range"], at_start) if "range" in spec else None
    speed, limit = _motor(where, kind, spec["motor"]) if "motor" in spec else (None, math.inf)
    if bounds is not None and speed is not None and math.isinf(limit):
        key = _MOVING[kind][0]
        raise UsageError(
            f"{where} has a motor and a range: give the motor a largest {key}, or it would push without end"
        )
    return Joint(name, kind, first, second, anchors, held, length, free, bounds, speed, limit)


def _bodies(where: str, pair, members: list[Body]) -> tuple[int, int]:
    """The indices of the two bodies; the world comes second."""
    if not isinstance(pair, (list, tuple)) or len(pair) != 2 or not all(isinstance(n, str) for n in pair):
        raise UsageError(
            f"{where} must name two bodies, or a body and {WORLD}, such as [arm, {WORLD}]; not {shown(pair)}"
        )
    names = [member.name for member in members]
    found = []
    for name in pair:
        if name != WORLD and name not in names:
            raise UsageError(f"{where}: there is no body '{name}'{suggest(name, [*names, WORLD])}")
        if names.count(name) > 1:
            raise UsageError(f"{where}: {names.count(name)} bodies are called '{name}': give each a name of its own")
        found.append(-1 if name == WORLD else names.index(name))
    if found[0] == found[1]:
        raise UsageError(f"{where} joins '{pair[0]}' to itself: name two bodies")
    if all(k < 0 or members[k].constraint == STATIC for k in found):
        raise UsageError(f"{where}: neither {pair[0]} nor {pair[1]} can move: leave the joint out")
    if found[0] < 0:
        raise UsageError(f"{where}: name the world second: [{pair[1]}, {WORLD}]")
    return found[0], found[1]


def _vector(where: str, what: str, value) -> np.ndarray:
    try:
        vector = np.asarray(value, float)
    except (TypeError, ValueError):
        vector = np.zeros(0)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise UsageError(f"{where}: {what} must be three numbers [x, y, z], not {shown(value)}")
    return vector


def _anchors(where: str, kind: str, at) -> tuple[np.ndarray, np.ndarray]:
    if kind == "distance":
        if not isinstance(at, (list, tuple)) or len(at) != 2:
            raise UsageError(f"{where} needs `at`, a point of each body at the start: [[x, y, z], [x, y, z]], m")
        return _vector(where, "at", at[0]), _vector(where, "at", at[1])
    if at is None:
        raise UsageError(f"{where} needs `at`, its place at the start: [x, y, z], m")
    point = _vector(where, "at", at)
    return point, point


def _refuse_far(where: str, point: np.ndarray, bodies: list[Body]) -> None:
    def gap(body: Body) -> float:
        return float(norm(point - body.place))

    if all(gap(body) > _FAR * body.reach for body in bodies):
        nearest = min(bodies, key=gap)
        raise UsageError(
            f"{where} is {gap(nearest):.3g} m from the body '{nearest.name}', which reaches {nearest.reach:.3g} m from its "
            "middle: `at` is in world coordinates"
        )


def _frame(members: list[Body], k: int) -> tuple[np.ndarray, np.ndarray]:
    return (np.zeros(3), np.eye(3)) if k < 0 else (members[k].place, matrices(members[k].attitude))


def _numbers(where: str, what: str, value, count: int) -> list[float]:
    try:
        numbers = [float(c) for c in value]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != count or any(math.isnan(c) for c in numbers):
        raise UsageError(f"{where}: {what} must be {count} numbers, not {shown(value)}")
    return numbers


def _bounds(where: str, kind: str, value, at_start: float) -> tuple[float, float]:
    low, high = _numbers(where, "range", value, 2)
    if low > high:
        raise UsageError(
            f"{where}: range must be [low, high], not [{low:g}, {high:g}]: the low bound is above the high one"
        )
    if kind == "hinge" and not -180 < low <= high < 180:
        raise UsageError(f"{where}: range must be between -180 and 180 degrees, not [{low:g}, {high:g}]")
    if kind == "distance" and low < 0:
        raise UsageError(f"{where}: a distance is at least 0 m, not {low:g}")
    if not low - 1e-9 <= at_start <= high + 1e-9:
        unit = "degrees" if kind == "hinge" else "m"
        raise UsageError(f"{where} starts at {at_start:g} {unit}, outside its range of {low:g} to {high:g}")
    if kind == "distance":
        return low - at_start, high - at_start
    scale = math.pi / 180 if kind == "hinge" else 1.0
    return low * scale, high * scale


def _motor(where: str, kind: str, value) -> tuple[float, float]:
    key, unit = _MOVING[kind]
    if not isinstance(value, dict) or "speed" not in value:
        raise UsageError(f"{where}: motor must be {{speed: ..., {key}: ...}}, not {shown(value)}")
    for other in value:
        if other not in ("speed", key):
            raise UsageError(f"{where}: a motor of a {kind} has no '{other}'{suggest(other, ['speed', key])}")
    try:
        speed, limit = float(value["speed"]), float(value.get(key, math.inf))
    except (TypeError, ValueError):
        speed = limit = math.nan
    if not math.isfinite(speed) or not limit >= 0:
        raise UsageError(
            f"{where}: the motor's speed must be a finite number and its {key} at least 0 {unit}, not {shown(value)}"
        )
    return speed, limit
