"""A rigid body: its shape, mass and start, and the particles that represent it.

The particles have the whole mass. Points on the surface, or along the edges, have a part of it; six carriers inside have the
rest and are placed so that mass, centre and all second moments are exactly those of the solid. Sums over particles are then
the body's momentum, angular momentum and energy. Carriers have the radius 0, so that sprites of the particles' size do not
show them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.interactions.rigid.quaternions import matrices, product, quaternion, rotation
from gen_art.interactions.rigid.shapes import Part, parts_of, plain_shape
from gen_art.interactions.rigid.small_matrices import apply, apply_transposed, compose, cross, norm, symmetric_eigen
from gen_art.quantities import plain

__all__ = ["AXLED", "FREE", "MOST_POINTS", "PIVOTED", "STATIC", "Body", "body", "motion_text", "moved"]

FREE, PIVOTED, AXLED, STATIC = range(4)
MOST_POINTS = 1_000_000
_CARRIERS = 6
_GRAIN = 3 / 4  # default radius of the particles, relative to their spacing
_KEPT_POINTS = 10_000  # of the largest bodies that are kept for whoever asks for the same one again
# of the arguments of `body`; the density of a hollow one is in kg/m^2
_UNITS = {
    "mass": "kg", "density": "kg/m^3", "position": "m", "turn": "rad", "velocity": "m/s", "spin": "rad/s", "pivot": "m",
    "grain": "m",
}  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class Body:
    """A body at its start. Its frame has the origin at the centre of mass, or at the pivot, and axes along principal axes.

    spec : the arguments of `body`, as plain values
    parts : its shapes, in its own frame
    constraint : FREE, PIVOTED, AXLED or STATIC
    mass : kg
    inertia : (3,) kg m^2, principal moments about the origin
    axle : (3,) unit vector, in its frame
    place : (3,) m, of the origin
    attitude : (4,) quaternion
    velocity : (3,) m/s, of the origin
    spin : (3,) rad/s
    local, masses, radii, normals, areas : of its particles: positions (n, 3) m, kg, m, (n, 3), m^2, in its frame
    tint : a number to colour it by
    offset : (3,) m, from the shape's origin to the centre of mass, in the world
    """

    spec: dict
    parts: list[Part]
    constraint: int
    mass: float
    inertia: np.ndarray
    axle: np.ndarray
    place: np.ndarray
    attitude: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    local: np.ndarray
    masses: np.ndarray
    radii: np.ndarray
    normals: np.ndarray
    areas: np.ndarray
    tint: float = 0.0
    name: str = ""
    offset: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def __repr__(self) -> str:
        held = {FREE: "", PIVOTED: ", on a pivot", AXLED: ", on an axle", STATIC: ", static"}[self.constraint]
        return (
            f"<Body '{self.name}': {motion_text(self.mass, self.place, self.velocity, self.spin)}{held}; "
            f"{len(self.masses):,} particles>"
        )

    @property
    def reach(self) -> float:
        """A distance, m, from the origin that no point of the body is beyond."""
        return max(float(norm(part.center)) + part.reach for part in self.parts)


def motion_text(mass: float, position, velocity, spin) -> str:
    """A body's mass, place, velocity and spin in words."""
    at, v, w = (f"({', '.join(f'{x:.4g}' for x in vector)})" for vector in (position, velocity, spin))
    return f"{mass:.4g} kg at {at} m, velocity {v} m/s, spin {w} rad/s"


def body(
    shape: Mapping[str, Any] | Sequence[Mapping[str, Any]], *, mass: float | None = None, density: float = 1000.0,
    hollow: bool = False, position: ArrayLike = (0, 0, 0), turn: ArrayLike = (0, 0, 0), velocity: ArrayLike = (0, 0, 0),
    spin: ArrayLike = (0, 0, 0), pivot: ArrayLike | None = None, axle: ArrayLike | None = None, static: bool = False,
    draw: str = "cloud", points: int = 400, grain: float | None = None, tint: float = 0.0, name: str = "body",
) -> Body:  # fmt: skip
    """A rigid body, to be combined with others by ga.bodies.

    shape : {"sphere": radius}, {"capsule": [length of the straight part, radius]} along y, {"box": [x, y, z]}, m; or a list of
        them, each with `at`, `turn` (degrees) and `density` relative to the others; parts should not overlap
    mass : kg; when left out, density times volume (or surface)
    density : kg/m^3; kg/m^2 if hollow
    hollow : the mass is on the surface
    position : m, of the shape's origin
    turn : rad, rotation vector
    velocity : m/s, of the centre of mass
    spin : rad/s
    pivot : (3,) m, a point that stays in place
    axle : (3,), the only axis it rotates about, through the pivot or the centre of mass
    static : it never moves
    draw : "cloud", points on the surface, or "wire", points along the edges
    points : approximate number of points
    grain : m, radius of the particles; three quarters of their spacing when left out
    tint : a number to colour it by
    Raises UsageError.
    """
    spec = _checked_spec(dict(locals()))
    make = _made if spec["points"] <= _KEPT_POINTS else _made.__wrapped__
    return make(_Spec(repr(spec), spec))


@dataclass(frozen=True)
class _Spec:
    """The checked arguments of `body`, as plain values; `text` tells them apart."""

    text: str
    values: dict = field(compare=False)


@lru_cache(128)
def _made(of: _Spec) -> Body:
    """The body of these arguments; a preset's emitter, its check and its interaction share one, so its arrays are read-only."""
    spec = of.values
    name, mass, density, tint, grain = (spec[key] for key in ("name", "mass", "density", "tint", "grain"))
    parts = parts_of(spec["shape"])
    weights = np.array([p.share * (p.area if spec["hollow"] else p.volume) for p in parts])
    total = float(mass) if mass is not None else density * float(weights.sum())
    if not (math.isfinite(total) and total > 0):
        raise UsageError(f"{name}: a body's mass must be above 0 kg, not {total:g}")
    centre, second = _moments(parts, weights / weights.sum(), spec["hollow"])
    x, n, area, spacing = _samples(parts, spec["draw"], int(spec["points"]))
    x, masses = _with_carriers(x - centre, total, second)
    zeros = np.zeros(_CARRIERS)
    radii = np.concatenate([np.full(len(n), spacing * _GRAIN if grain is None else float(grain)), zeros])
    n, area = np.concatenate([n, np.zeros((_CARRIERS, 3))]), np.concatenate([area, zeros])
    shape_attitude = rotation(np.asarray(spec["turn"], float))
    R = matrices(shape_attitude)
    offset = apply(R, centre)
    at = np.asarray(spec["position"], float) + offset
    origin = at if spec["pivot"] is None or spec["static"] else np.asarray(spec["pivot"], float)
    lever = apply_transposed(
        R, at - origin
    )  # from the origin of the body's frame to the centre, along the shape's axes
    second = second + np.outer(lever, lever)
    inertia, axes = _principal(total * (np.trace(second) * np.eye(3) - second))

    def to_body_frame(p):
        """Positions p relative to the centre of mass, in the shape's axes, in the body's frame."""
        return apply_transposed(axes, p + lever)

    body_parts = [
        Part(p.kind, p.half, p.radius, to_body_frame(p.center - centre), compose(axes.T, p.axes), p.share)
        for p in parts
    ]
    attitude = product(shape_attitude, quaternion(axes))
    v, w = np.asarray(spec["velocity"], float), np.asarray(spec["spin"], float)
    constraint = _constraint(spec)
    direction = _axle_direction(name, constraint, spec["axle"], v, w)
    body_axle = apply_transposed(matrices(attitude), direction)
    one = Body(
        spec, body_parts, constraint, total, inertia, body_axle, origin, attitude, v, w, to_body_frame(x), masses, radii,
        apply_transposed(axes, n), area, float(tint), name, offset,
    )  # fmt: skip
    for array in (each for each in vars(one).values() if isinstance(each, np.ndarray)):
        array.flags.writeable = False
    return one


def _constraint(spec: dict) -> int:
    if spec["static"]:
        return STATIC
    if spec["axle"] is not None:
        return AXLED
    return FREE if spec["pivot"] is None else PIVOTED


def moved(one: Body, position: np.ndarray, tint: float) -> Body:
    """The same body, which must have no pivot, at another position (3,) m and with another tint."""
    spec = {**one.spec, "position": position.tolist(), "tint": float(tint)}
    return replace(one, spec=spec, place=position + one.offset, tint=float(tint))


def _checked_spec(given: dict) -> dict:
    """The arguments of `body` as plain values. Raises UsageError for one that is not of its kind."""
    name = arguments.text("name", given["name"])
    units = _UNITS | ({"density": "kg/m^2"} if arguments.flag(f"{name}: hollow", given["hollow"]) else {})
    given = {**given, "shape": plain_shape(given["shape"])}
    spec = {key: _plain(plain(value, units.get(key, ""), f"{name}: {key}")) for key, value in given.items()}
    for key in ("position", "turn", "velocity", "spin", "pivot", "axle"):
        if spec[key] is not None or key not in ("pivot", "axle"):
            arguments.vector(f"{name}: {key}", spec[key])
    arguments.number(f"{name}: density", spec["density"], units["density"], above=0.0)
    arguments.number(f"{name}: tint", spec["tint"])
    for key, unit in (("mass", "kg"), ("grain", "m")):
        if spec[key] is not None:
            arguments.number(f"{name}: {key}", spec[key], unit, **({"above": 0.0} if key == "mass" else {"low": 0.0}))
    arguments.flag(f"{name}: static", spec["static"])
    arguments.whole(f"{name}: points", spec["points"], 8, MOST_POINTS)
    return spec


def _plain(value):
    """The value as the plain numbers, strings and lists that a snapshot stores."""
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value


def _moments(parts: list[Part], shares: np.ndarray, hollow: bool) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (3,) and mean of x x^T about it (3, 3), m^2, of parts with these shares of the mass."""
    centers = np.array([p.center for p in parts])
    centre = (shares[:, None] * centers).sum(0)
    each = [p.moments(hollow) + np.outer(p.center - centre, p.center - centre) for p in parts]
    return centre, (shares[:, None, None] * np.array(each)).sum(0)


def _axle_direction(name: str, constraint: int, axle, v: np.ndarray, w: np.ndarray) -> np.ndarray:
    """The axle's unit vector (3,) in the world. Raises UsageError for motion that the constraint forbids."""
    direction = np.array([0.0, 1.0, 0.0]) if axle is None else np.asarray(axle, float)
    length = float(norm(direction))
    if length == 0:
        raise UsageError(f"{name}: axle must not be the zero vector")
    if constraint == AXLED and norm(cross(w, direction)) > 1e-9 * norm(w) * length:
        raise UsageError(f"{name}: spin must be along the axle")
    if constraint != FREE and v.any():
        raise UsageError(f"{name}: a body that is held has no velocity of its own: give it a spin")
    if constraint == STATIC and w.any():
        raise UsageError(f"{name}: a static body does not spin; give it an axle")
    return direction / length


def _principal(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Moments and a right-handed frame of principal axes; the shape's own axes where they are principal."""
    off = inertia - np.diag(np.diag(inertia))
    if np.abs(off).max() <= 1e-12 * np.trace(inertia):
        return np.diag(inertia).copy(), np.eye(3)
    return symmetric_eigen(inertia)


def _samples(parts: list[Part], draw: str, points: int):
    """Points, normals, areas and spacing. Areas are half the surface's, because the two faces of a thin plate are one panel."""
    if not isinstance(draw, str) or draw not in ("cloud", "wire"):
        raise UsageError(f"draw must be cloud or wire, not {arguments.shown(draw)}")
    if draw == "cloud":
        spacing = math.sqrt(sum(p.area for p in parts) / points)
    else:
        spacing = sum(p.wire_length() for p in parts) / points
    needed = sum(p.points(draw, spacing) for p in parts)
    if needed > MOST_POINTS:
        raise UsageError(
            f"a body of these sizes needs {needed:,} points, and has at most {MOST_POINTS:,}: lower `points`"
        )
    found = [p.surface(spacing) if draw == "cloud" else p.wires(spacing) for p in parts]
    centers, reaches = np.array([p.center for p in parts]), np.array([p.reach for p in parts])
    for k, (x, n, area) in enumerate(found):
        outside = np.ones(len(x), bool)
        near = norm(centers - centers[k]) < 1.001 * (reaches + reaches[k])  # the others hold none of its points
        for other in np.flatnonzero(near):
            if other != k:
                outside &= parts[other].distance(x) > -1e-9 * spacing
        found[k] = x[outside], n[outside], 0.5 * area[outside]
    x, n, area = (np.concatenate([f[k] for f in found]) for k in range(3))
    return x, n, area, spacing


def _with_carriers(x: np.ndarray, mass: float, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points (about the centre of mass) with six carriers, and masses whose mean of x x^T is exactly `second`."""
    mean, spread = x.mean(0), (x[:, :, None] * x[:, None, :]).sum(0) / len(x)
    least = symmetric_eigen(second)[0][0]
    share = 0.5
    for _ in range(
        100
    ):  # the smaller the share of the points, the closer the carriers' moments are to those of the solid
        centre = -share / (1 - share) * mean
        rest = (second - share * spread) / (1 - share) - np.outer(centre, centre)
        squares, axes = symmetric_eigen(rest)
        if squares[0] >= 0.25 * least:
            break
        share *= 0.5
    else:
        raise UsageError("the body is too flat: its moments of inertia cannot be told apart")
    arms = (axes * np.sqrt(3 * squares)).T
    masses = np.concatenate(
        [np.full(len(x), share * mass / len(x)), np.full(_CARRIERS, (1 - share) * mass / _CARRIERS)]
    )
    return np.concatenate([x, centre + arms, centre - arms]), masses
