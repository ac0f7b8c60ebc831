"""The table of rays' ends, by which lensed skies are drawn, against the closed forms in float64."""

import math

import numpy as np
import pytest

from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.lensing.ellis import ELLIS
from gen_art.renderer.lensing.ray_table import PER_OCTAVE, ray_at, ray_number, ray_table
from gen_art.renderer.lensing.schwarzschild import SCHWARZSCHILD

D1, F1, F2 = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.f32, 1), ti.types.ndarray(ti.f32, 2)


def _exact_kernel(bending):
    ray_end, sine = bending.ray_end, bending.sine

    @ti.kernel
    def exact(alpha_sine: D1, inward: D1, u: ti.f64, w: ti.f64, angle: D1, where: D1):
        for i in range(angle.shape[0]):
            angle[i], end = ray_end(alpha_sine[i] / sine(w), ti.cast(inward[i], ti.i32), u, w)
            where[i] = ti.cast(end, ti.f64)

    return kernel(exact, "f64")


@ti.kernel
def _read(ends: F2, edge: ti.f32, c: F1, s: F1, out: F2):
    for i in range(c.shape[0]):
        q, by_alpha = ray_number(c[i], s[i])
        angle, change = ray_at(ends, q - edge)
        out[i, 0], out[i, 1], out[i, 2] = q - edge, angle, change * by_alpha


read_kernel = kernel(_read)
EXACT = {bending: _exact_kernel(bending) for bending in (ELLIS, SCHWARZSCHILD)}


def exact(bending, alpha, u, w):
    angle, where = np.zeros(len(alpha)), np.zeros(len(alpha))
    EXACT[bending](np.sin(alpha), (alpha < math.pi / 2).astype(float), u, w, angle, where)
    return angle, where


def table_read(bending, alpha, u, w):
    """(q - edge, angle, its change by alpha) of rays at the angles alpha."""
    ends, edge = ray_table(bending, u, w)
    out = np.zeros((len(alpha), 3), np.float32)
    read_kernel(ends, edge, np.cos(alpha).astype(np.float32), np.sin(alpha).astype(np.float32), out)
    return out.T.astype(np.float64)


CAMERAS = [(ELLIS, w) for w in (1.0, 0.999, 0.7, 0.25, 0.02)] + [(SCHWARZSCHILD, w) for w in (0.66, 0.4, 0.1, 0.02)]
CASES = pytest.mark.parametrize(("bending", "w"), CAMERAS, ids=lambda v: "" if isinstance(v, float) else None)


def rays(bending, u, w):
    """Angles over the whole sphere, and near the edge down to 1e-3 of its distance from straight inwards."""
    edge = ray_table(bending, u, w)[1]
    half = np.concatenate([edge * (1.0 + sign * np.geomspace(1e-3, 0.9, 60)) for sign in (-1, 1)])
    return np.concatenate([np.linspace(1e-4, math.pi - 1e-4, 500), 2.0 * np.arctan(half)])


@CASES
def test_a_rays_end_is_that_of_the_closed_form(bending, w):
    """A straight line between entries is off by g / (8 PER_OCTAVE^2), g = 1 at most, and the smooth rest by less than twice that.

    q has the round-off of float32, some 2e-7, which g / |x| makes larger. Mutants that fail: 2 + half for 2 - half, x without its
    sign, an entry further on, the edge at twice the impact parameter.
    """
    u = math.sqrt(1.0 - w * w)
    alpha = rays(bending, u, w)
    angle, where = exact(bending, alpha, u, w)
    x, found, _change = table_read(bending, alpha, u, w)
    seen = where < 2
    assert seen.sum() > 200
    bound = 3.0 / (8 * PER_OCTAVE**2) + 4e-7 / np.abs(x)
    assert (np.abs(found - angle) / bound)[seen].max() < 1.0


@CASES
def test_rays_below_the_edge_are_those_that_do_not_come_back(bending, w):
    alpha = rays(bending, math.sqrt(1.0 - w * w), w)
    _angle, where = exact(bending, alpha, math.sqrt(1.0 - w * w), w)
    x = table_read(bending, alpha, math.sqrt(1.0 - w * w), w)[0]
    assert np.array_equal(x < 0.0, where > 0)


@CASES
def test_the_change_is_the_angles_derivative(bending, w):
    """By central differences of the closed form, to the change of the derivative over an entry: its second derivative is about g / x^2
    and an entry x / PER_OCTAVE wide. A mutant without the change of q by alpha fails."""
    u = math.sqrt(1.0 - w * w)
    alpha = rays(bending, u, w)
    x, _found, change = table_read(bending, alpha, u, w)
    plain = (np.abs(x) > 1e-3) & (alpha < 3.0) & (np.abs(alpha - math.pi / 2) > 1e-4)
    step = 1e-6
    (after, where), (before, _) = exact(bending, alpha + step, u, w), exact(bending, alpha - step, u, w)
    plain &= where < 2
    slope = (after - before) / (2 * step)
    assert np.abs(change)[plain] == pytest.approx(np.abs(slope[plain]), rel=3.0 / PER_OCTAVE, abs=3.0 / PER_OCTAVE)
