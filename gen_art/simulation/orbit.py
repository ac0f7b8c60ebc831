"""Orbital elements: the conic section that two bodies move along about each other."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gen_art import arguments
from gen_art.errors import UsageError

__all__ = ["OrbitalElements", "orbital_elements"]

_NO_ANGLE = 1e-12  # eccentricities and sines of inclinations below this are round-off of 0


@dataclass(frozen=True)
class OrbitalElements:
    """Elements of orbits: a number each, or (n,) arrays.

    semi_major_axis : m; negative for a hyperbola, infinite for a parabola
    eccentricity : 0 circle, below 1 ellipse, 1 parabola, above 1 hyperbola
    inclination : rad, 0 to pi, of the orbit's plane to the plane of reference
    node : rad, 0 to 2 pi, from the direction of reference to where the orbit rises through that plane
    argument_of_pericenter : rad, 0 to 2 pi, from the node to the pericentre, along the motion
    true_anomaly : rad, 0 to 2 pi, from the pericentre to the body
    period : s; infinite where the body does not return
    In the plane of reference the node is at the direction of reference; on a circle the pericentre is at the node.
    """

    semi_major_axis: np.ndarray
    eccentricity: np.ndarray
    inclination: np.ndarray
    node: np.ndarray
    argument_of_pericenter: np.ndarray
    true_anomaly: np.ndarray
    period: np.ndarray


def orbital_elements(
    position: ArrayLike,
    velocity: ArrayLike,
    GM: ArrayLike,
    *,
    axis: ArrayLike = (0.0, 0.0, 1.0),
    reference: ArrayLike = (1.0, 0.0, 0.0),
) -> OrbitalElements:
    """The elements of the orbits that these relative positions and velocities lie on.

    position, velocity : (3,) or (n, 3), m and m/s, relative to the other body
    GM : m^3/s^2, G times the sum of both masses; one number or (n,), above 0
    axis : normal of the plane of reference; the motion about it is prograde
    reference : the direction of reference in that plane; its part along the axis is left out
    Raises UsageError for bodies at the same place, for motion along a line, which has no plane, and for wrong shapes.
    Source: Murray & Dermott, Solar System Dynamics (1999), section 2.8.
    """
    r = arguments.array("position", position, "numbers of the shape (3,) or (n, 3)", "m")
    if r.ndim not in (1, 2) or r.shape[-1] != 3:
        raise UsageError(f"position must have the shape (3,) or (n, 3), not {r.shape}")
    v = arguments.array("velocity", velocity, f"numbers of the shape {r.shape}", "m/s")
    if v.shape != r.shape:
        raise UsageError(f"velocity must have the shape {r.shape} of position, not {v.shape}")
    mu = arguments.array("GM", GM, "one number, or one for each orbit", "m^3/s^2")
    if mu.shape not in ((), r.shape[:-1]) or (mu <= 0).any():
        raise UsageError("GM must be one number above 0, or one for each orbit")
    pole, toward = _frame(axis, reference)
    distance = _length(r)
    if (distance == 0).any():
        raise UsageError("two bodies at the same place have no orbit")
    h = np.cross(r, v)
    if (_length(h) <= _NO_ANGLE * distance * _length(v)).any():
        raise UsageError("a body that moves straight to or from the other has no plane of its orbit")
    square = (v * v).sum(-1)
    eccentricity = np.cross(v, h) / mu[..., None] - r / distance[..., None]  # a vector towards the pericentre
    e = _length(eccentricity)
    rising = np.cross(pole, h)
    inclined = _length(rising) > _NO_ANGLE * _length(h)
    node = np.where(inclined[..., None], rising, toward)
    pericenter = np.where((e > _NO_ANGLE)[..., None], eccentricity, node)
    with np.errstate(divide="ignore"):
        a = 1 / (2 / distance - square / mu)
    bound = np.isfinite(a) & (a > 0)
    period = np.where(bound, 2 * np.pi * np.sqrt(np.where(bound, a, 1.0) ** 3 / mu), np.inf)
    inclination = np.arctan2(_length(rising), (h * pole).sum(-1))
    angles = (inclination, _angle(toward, node, pole), _angle(node, pericenter, h), _angle(pericenter, r, h))
    return OrbitalElements(*(np.asarray(one)[()] for one in (a, e, *angles, period)))


def _frame(axis: ArrayLike, reference: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors along the axis and along the direction of reference across it."""
    pole, toward = np.array(arguments.vector("axis", axis)), np.array(arguments.vector("reference", reference))
    if not pole.any():
        raise UsageError("axis must not be the zero vector")
    pole /= _length(pole)
    across = toward - (toward @ pole) * pole
    if _length(across) <= _NO_ANGLE * _length(toward):
        raise UsageError("reference must not lie along the axis")
    return pole, across / _length(across)


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.sqrt((vectors * vectors).sum(-1))


def _angle(one: np.ndarray, other: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """rad, 0 to 2 pi: by how much `one` turns about the axis to lie along `other`."""
    sine = (np.cross(one, other) * axis).sum(-1) / _length(axis)
    angle = np.arctan2(sine, (one * other).sum(-1)) % (2 * np.pi)
    return np.where(angle == 2 * np.pi, 0.0, angle)
