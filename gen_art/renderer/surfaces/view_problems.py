"""What cannot be seen as it is meant: a camera inside a solid, and shapes whose function is no distance."""

import numpy as np

from gen_art.errors import PresetError
from gen_art.renderer.surfaces.collider_rays import ColliderTerms, cast_by, collider_distances

__all__ = ["check_camera", "check_distances"]

_STEEPEST = 1.1  # change of a distance per length: 1, and what float32 and interpolation add
_PROBES = 2048  # points at which a shape's distance is tested, and as many beside them
_GOLDEN = (
    0.6180339887498949,
    0.5545497331806323,
    0.8191725133961645,
)  # an even sequence along each axis, by irrational steps


def check_camera(terms: ColliderTerms, view, time: float) -> None:
    """Raise PresetError for a camera inside a solid that is drawn, or behind a plane."""
    if view.height is not None:  # an orthographic camera sees from afar
        return
    depth = collider_distances(terms, view.position[None], time)[0]
    for entry, distance in zip(terms.entries, depth):
        if cast_by(entry) and distance < 0.0:
            name, where = entry.collider.name, ", ".join(f"{c:.4g}" for c in view.position)
            inside = "behind the plane" if name == "plane" else f"inside the {name}"
            raise PresetError(
                f"the camera at [{where}] is {inside}, {-distance:.3g} deep, and would not see it: move the camera, or leave "
                f"out the look of the {name}"
            )


def check_distances(terms: ColliderTerms, view, time: float) -> None:
    """Raise PresetError for an sdf that changes by more than 1 per length in what the camera sees: rays would pass through it."""
    shapes = [k for k, entry in enumerate(terms.entries) if entry.collider.name == "sdf" or not entry.collider.convex]
    if not shapes:
        return
    even = np.outer(np.arange(_PROBES) + 0.5, _GOLDEN) % 1.0 - 0.5
    reach = 2.0 * view.distance
    points = view.position + view.axes[2] * view.distance + even * reach
    apart = 1e-3 * reach
    direction = np.eye(3)[np.arange(_PROBES) % 3] * apart
    distance, beside = (collider_distances(terms, x, time) for x in (points, points + direction))
    for k in shapes:
        slope = np.abs(beside[:, k] - distance[:, k]) / apart
        worst = int(np.argmax(slope))
        if not slope[worst] <= _STEEPEST:
            where = ", ".join(f"{c:.4g}" for c in points[worst])
            raise PresetError(
                f"the {terms.entries[k].collider.name} is drawn by its distance, which changes by {slope[worst]:.3g} per unit of "
                f"length near [{where}] and must not by more than 1: divide its function by that"
            )
