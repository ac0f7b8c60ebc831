"""What cannot be seen as it is meant: a camera inside a solid, and shapes whose function is no distance."""

import numpy as np

from gen_art.colliders.sdf import SDF
from gen_art.errors import PresetError
from gen_art.renderer.surfaces.collider_rays import ColliderTerms, cast_by, collider_distances

__all__ = ["check_camera", "check_distances"]

_STEEPEST = 1.1  # change of a distance per length: 1, and what float32 and interpolation add
_FLATTEST = (
    0.2  # what it must reach near the surface: rays that step by the distance take at most five times as many steps
)
_PROBES = 2048  # points at which a shape's distance is tested, with one beside them along each axis
_NEAREST = 64  # of them, those closest to the surface, tell how flat it is there
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
    for collider, distance in zip(terms.colliders, depth):
        if cast_by(collider) and distance < 0.0:
            name, where = collider.name, ", ".join(f"{c:.4g}" for c in view.position)
            inside = "behind the plane" if name == "plane" else f"inside the {name}"
            raise PresetError(
                f"the camera at [{where}] is {inside}, {-distance:.3g} deep, and would not see it: move the camera, or leave "
                f"out the look of the {name}"
            )


def check_distances(terms: ColliderTerms, view, time: float) -> None:
    """Raise PresetError for an sdf that is no distance in what the camera sees.

    Where it changes by more than 1 per length, rays would pass through it; where it hardly changes, they would not reach it in
    the steps that they have. What is not a number is neither.
    """
    shapes = [k for k, one in enumerate(terms.colliders) if one.name == "sdf" or not one.convex]
    if not shapes:
        return
    even = np.outer(np.arange(_PROBES) + 0.5, _GOLDEN) % 1.0 - 0.5
    reach = 2.0 * view.distance
    points = view.position + view.axes[2] * view.distance + even * reach
    apart = 1e-3 * reach
    distance = collider_distances(terms, points, time).astype(np.float64)
    beside = [collider_distances(terms, points + axis * apart, time).astype(np.float64) for axis in np.eye(3)]
    for k in shapes:
        collider = terms.colliders[k]
        gradient = np.stack([each[:, k] - distance[:, k] for each in beside], axis=1)
        if not np.isfinite(gradient).all():
            where = _shown(points[int(np.argmin(np.isfinite(gradient).all(axis=1)))])
            raise PresetError(
                f"the {collider.name} is drawn by its distance, which is not a number near [{where}]: mend its function"
            )
        # along the gradient: at an edge, where the differences belong to several faces, a distance changes by no more than 1
        uphill = gradient / np.maximum(np.sqrt((gradient**2).sum(axis=1, keepdims=True)), 1e-300)
        slope = np.abs(collider_distances(terms, points + uphill * apart, time)[:, k] - distance[:, k]) / apart
        worst = int(np.argmax(slope))
        if slope[worst] > _STEEPEST:
            raise PresetError(
                f"the {collider.name} is drawn by its distance, which changes by {slope[worst]:.3g} per unit of length near "
                f"[{_shown(points[worst])}] and must not by more than 1: divide its function by that"
            )
        near = np.argsort(np.abs(distance[:, k]), kind="stable")[:_NEAREST]
        # beyond a grid its border's distances apply, which are flat: of a grid, its own slopes count
        steepest = collider.steepness if isinstance(collider, SDF) and collider.tabled else float(slope[near].max())
        if 0.0 < steepest < _FLATTEST:
            raise PresetError(
                f"the {collider.name} is drawn by its distance, which changes by {steepest:.2g} per unit of length at most "
                "near its surface, where a distance changes by 1: divide its function by that"
            )


def _shown(place) -> str:
    return ", ".join(f"{c:.4g}" for c in place)
