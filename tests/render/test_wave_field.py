"""The slopes of waves in the pixels of a picture, against the sines that they are made of."""

import numpy as np
import pytest

from gen_art.preset.surface import Waves
from gen_art.preset.values import Range
from gen_art.renderer.camera import Camera
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.surfaces import surface_pass
from gen_art.renderer.surfaces.lamp_shadows import ShadowBins
from gen_art.renderer.surfaces.scene_numbers import scene_numbers
from gen_art.renderer.surfaces.shadow_casters import NO_SKY
from gen_art.renderer.surfaces.water_waves import patch_rows, wave_rows
from gen_art.renderer.surfaces.wave_field import NO_FIELD, wave_field
from tests.render.test_surfaces import matte, picture

SIZE = (75, 50)  # not a whole number of vectors
CAMERAS = {
    "ahead": {"position": [0.5, 1.2, 3], "target": [0, 0.9, -4], "fov": 50},
    "rolled": {"position": [-2, 3, 3], "target": [0, 0.5, -1], "fov": 70, "up": [0.6, 1, 0.1]},
    "straight down": {"position": [1, 4, 0.5], "target": [1, 0, 0.5], "up": [0, 0, -1], "fov": 40},
    "from below": {"position": [1, -2, 2], "target": [0, 0.5, -1], "fov": 50},
    "without perspective": {"position": [0.5, 3, 3], "target": [0, 0.5, -1], "height": 4},
}
HEIGHT = 0.25
WAVES = {"slope": 0.08, "length": Range(0.05, 3.0), "direction": 40, "spread": 70, "patches": 0.4, "patch_size": 2.0}


def places(view, column, row):
    """((n, 2) x and z, (n,) whether it is met, (n,) how far the ray is from the middle one) where rays meet the level y = HEIGHT."""
    scale = view.scale(SIZE[1])
    offset = np.outer((column - SIZE[0] / 2) / scale, view.axes[0]) + np.outer(
        (SIZE[1] / 2 - row) / scale, view.axes[1]
    )
    start, way = view.position + 0 * offset, view.axes[2] + offset
    if view.height is not None:
        start, way = view.position + offset, view.axes[2] + 0 * offset
    with np.errstate(divide="ignore"):
        t = (HEIGHT - start[:, 1]) / way[:, 1]
    return (start + t[:, None] * way)[:, ::2], np.isfinite(t) & (t > 0), np.linalg.norm(way, axis=1)


def expected(view, rows, number):
    """(n, 3) of the pixels in float64, and whether the level is seen there: steps to the next pixel by differences of places."""
    row, column = (np.ravel(k) + 0.5 for k in np.indices(SIZE[::-1]))
    at, met, longer = places(view, column, row)
    steps = [
        (places(view, column + h[0], row - h[1])[0] - places(view, column - h[0], row + h[1])[0])
        / 2e-4
        * longer[:, None]
        for h in ((1e-4, 0.0), (0.0, 1e-4))
    ]
    with np.errstate(all="ignore"):
        narrow = sum((step @ rows[:, :2].T) ** 2 for step in steps) / 24.0
        left = np.where(narrow < 700, np.exp(-np.minimum(narrow, 700)), 0)
        sine = left * np.cos(at @ rows[:, :2].T + rows[:, 3])
    waves, patches = slice(0, number), slice(number, None)
    square, hidden = 0.5 * rows[:, 2] ** 2, (1.0 - left**2)
    factor = np.maximum(1.0 + sine[:, patches] @ rows[patches, 2], 0.0)
    shorter = hidden[:, waves] @ square[waves] * (factor**2 + hidden[:, patches] @ square[patches])
    return np.column_stack([factor * (sine[:, waves] @ rows[waves, k]) for k in (4, 5)] + [shorter]), met


@pytest.mark.parametrize("name", CAMERAS)
def test_a_pixel_has_the_slopes_of_its_place(name):
    """Mutants: the next row's place; sixteen columns on; steps without perspective; a lean of the axis left out in steps; the height of
    the level; the part of a sine that is left; the factor's
    square; the sign of the way for a camera below."""
    waves = Waves.model_validate(WAVES)
    rows = np.concatenate([wave_rows(waves, 0.7), patch_rows(waves)])
    view = Camera(**CAMERAS[name]).at()
    bins = ShadowBins.of(np.zeros((0, 3)), np.zeros(0), np.eye(3))
    numbers = scene_numbers(view, SIZE, 0.0, Lighting.of(None, None, of_scene=True), True, bins, NO_SKY, None)
    got = wave_field(numbers, rows, [HEIGHT], [[0, waves.number, len(rows) - waves.number]], SIZE)
    assert got.shape[:3] == (1, SIZE[1], 3) and got.shape[3] >= SIZE[0]
    want, met = expected(view, rows.astype(np.float64), waves.number)
    assert met.sum() > 800
    values = got[0, :, :, : SIZE[0]].transpose(0, 2, 1).reshape(-1, 3)
    # a pixel just above the horizon, through which a ray may meet the water, shows it as rough as it is far off
    calm = 0.5 * (rows[: waves.number, 2].astype(np.float64) ** 2).sum()
    last = np.flatnonzero(met.reshape(SIZE[::-1]).any(axis=1))[[0, -1]]
    for row in (last[0] - 1, last[1] + 1):
        if 0 <= row < SIZE[1] and view.height is None:
            assert got[0, row, 2, : SIZE[0]].min() > 0.9 * calm
    # a sine's part that is left is exact to 2e-4, its phase to a few units in the last place of the place's coordinates
    each = np.abs(rows[:, 2]).astype(np.float64)
    most = each[: waves.number].sum() * (1 + each[waves.number :].sum())
    assert np.abs(values - want)[met].max() < 1e-3 * most
    assert np.abs(want[met]).max() > 0.05 * most


@pytest.mark.parametrize("kind", ["open", "mirror", "flooded", "without perspective"])
def test_the_picture_is_that_of_waves_found_ray_by_ray(kind, monkeypatch):
    """Mutants: the slopes of the row above; those of the ground for the water that stands above it."""
    water = {
        "albedo": "#204050",
        "roughness": 0.1,
        "ior": 1.33,
        "waves": {"slope": 0.1, "length": "0.1..1.5", "patches": 0.4},
    }
    colliders = {"sphere": {"center": [0.3, 0.4, 0], "radius": 0.4, "look": matte("red")}}
    if kind == "flooded":
        higher = {**water, "waves": {"slope": 0.2, "length": "0.2..1"}}
        colliders["plane"] = {"point": [0, 0.2, 0], "normal": [0, 1, 0], "look": higher}
    camera = {"position": [0.6, 1.1, 3], "target": [0, 0.2, 0], "fov": 50}
    if kind == "without perspective":
        camera = {"position": [0, 2, 3], "target": [0, 0, 0], "height": 3}
    given = {
        "ground": {**water, "mirror": kind == "mirror"}, "colliders": colliders, "sky": {"sun": 40}, "camera": camera, "size": SIZE,
    }  # fmt: skip
    found = picture(**given)
    monkeypatch.setattr(surface_pass.SurfacePass, "_wave_field", lambda *_: NO_FIELD)
    one_by_one = picture(**given)
    apart = np.abs(found - one_by_one).max(axis=2)
    # where a pixel shows the water and something else, its rays find their slopes apart
    assert (apart > 1e-3 * one_by_one.max()).mean() < 0.05 and found.std() > 0.01
