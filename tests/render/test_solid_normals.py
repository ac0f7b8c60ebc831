"""The normals of rounded boxes, where round-off puts a point deeper than their radius."""

import numpy as np
import pytest

from gen_art.backend.runtime import ti
from gen_art.renderer.surfaces.solids import AXES, HALF, RADIUS, SOLID_FLOATS, solid_normal

F2 = ti.types.ndarray(dtype=ti.f32, ndim=2)


@ti.kernel
def _normals(B: F2, X: F2, N: F2):
    for k in range(X.shape[0]):
        n = solid_normal(B, 0, ti.Vector([X[k, 0], X[k, 1], X[k, 2]]))
        for c in ti.static(range(3)):
            N[k, c] = n[c]


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_point_below_the_rounding_has_its_face_s_normal(axis):
    """Just above and just below the faces of the box within the rounding. Mutant: the rounding's normal alone, which is no number."""
    box = np.zeros((1, SOLID_FLOATS), np.float32)
    half = np.array([1.0, 2.0, 3.0], np.float32)
    box[0, RADIUS], box[0, HALF : HALF + 3], box[0, AXES : AXES + 9] = 0.001, half, np.eye(3).ravel()
    away = np.zeros((4, 3), np.float32)
    away[:, axis] = [1, -1, 1, -1]
    points = away * (half[axis] + np.float32([0.0005, 0.0005, -1e-4, -1e-4])[:, None])
    found = np.zeros((4, 3), np.float32)
    _normals(box, points, found)
    assert found == pytest.approx(away, abs=1e-6)
