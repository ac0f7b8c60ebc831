"""Vectors on a grid: from arrays, files and pictures, as a force and in a medium, without a compilation of their own."""

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.backend import runtime
from gen_art.output.recipe import make_recipe
from tests.physics.probe import probe, states

F = ga.forces
CORNERS = ((-3.0, -3.0, -3.0), (3.0, 3.0, 3.0))


def linear(size=(5, 4, 6)):
    """A field that is linear in x: the blend is exact."""
    matrix = np.array([[0.3, -1.0, 0.2], [0.7, 0.1, 0.4], [-0.2, 0.5, 0.9]])
    axes = [np.linspace(-3, 3, n) for n in size]
    return matrix, np.stack(np.meshgrid(*axes, indexing="ij"), -1) @ matrix.T


def test_a_linear_field_comes_out_exactly():
    matrix, grid = linear()
    p = states()
    p.position = np.clip(p.position, -2.9, 2.9)
    found = probe(F.VectorField(grid, CORNERS, 2.0), p)[0]
    assert np.abs(found - 2.0 * matrix @ p.position).max() <= 1e-13 * 10
    turned = probe(F.VectorField(grid[::-1], CORNERS, 2.0), p)[0]  # the mutant: the wrong end first
    assert np.abs(turned - 2.0 * matrix @ p.position).max() > 0.1


@pytest.mark.parametrize("outside", ["zero", "clamp"])
def test_outside(outside):
    _, grid = linear()
    p = states()
    p.position[:] = 0.0
    p.position[0] = np.linspace(3.001, 9.0, 64)
    found = probe(F.VectorField(grid, CORNERS, 1.0, outside), p)[0]
    p.position[0] = 3.0
    edge = probe(F.VectorField(grid, CORNERS), p)[0]
    assert np.allclose(found, edge * (outside == "clamp"), atol=1e-12)
    assert np.abs(edge).max() > 0.5


def test_a_size_of_one_is_the_same_all_along_that_axis():
    grid = np.random.default_rng(0).normal(size=(4, 5, 1, 3))
    p, q = states(), states()
    q.position[2] = -p.position[2]
    field = F.VectorField(grid, CORNERS, outside="clamp")
    assert np.array_equal(probe(field, p)[0], probe(field, q)[0])


def drift(grid, medium=True, seconds=1.0):
    field = F.VectorField(grid, CORNERS, outside="clamp")
    dust = ga.ParticleSystem(
        position=[[0.1, 0.2, 0.3]],
        forces=[F.Damping(1.0), F.Gravity((0, 0, 0))] if medium else [F.Gravity((0, 0, 0)), field],
        medium=ga.Medium(field=[F.Wind((0, 0, 0)), field]) if medium else None,
    )
    sim = ga.Simulation({"d": dust}, dt=0.01, precision="f64")
    sim.step(round(seconds / 0.01))
    return sim["d"].velocity[0]


def test_as_a_force_and_in_a_medium_and_other_data_compile_nothing():
    grid = np.zeros((4, 4, 4, 3)) + (1.0, -2.0, 0.5)
    assert np.allclose(drift(grid, medium=False), (1.0, -2.0, 0.5), atol=1e-12)
    assert np.allclose(drift(grid), np.array((1.0, -2.0, 0.5)) * (1 - np.exp(-1)), atol=1e-12)
    compiled = runtime.compilations()
    other = np.zeros((3, 7, 2, 3)) + (0.5, 0.25, 2.0)  # another size, too
    assert np.allclose(drift(other), np.array((0.5, 0.25, 2.0)) * (1 - np.exp(-1)), atol=1e-12)
    assert runtime.compilations() == compiled


def test_two_fields_keep_their_own_data():
    a, b = np.zeros((2, 3, 2, 3)) + (1.0, 0, 0), np.zeros((3, 2, 2, 3)) + (0, 2.0, 0)
    dust = ga.ParticleSystem(
        position=[[0, 0, 0]], forces=[F.VectorField(a, CORNERS), F.Gravity((0, 0, 3.0)), F.VectorField(b, CORNERS)]
    )
    sim = ga.Simulation({"d": dust}, dt=0.1)
    sim.step(5)
    assert np.allclose(sim["d"].velocity[0], (0.5, 1.0, 1.5), atol=1e-6)


def test_files_and_pictures(tmp_path):
    _, grid = linear()
    np.save(tmp_path / "flow.npy", grid)
    p = states()
    assert np.array_equal(
        probe(F.VectorField(tmp_path / "flow.npy", CORNERS), p)[0], probe(F.VectorField(grid, CORNERS), p)[0]
    )
    pixels = np.zeros((3, 2, 3), np.uint8) + 128
    pixels[0, 1] = (255, 1, 7)  # top right
    Image.fromarray(pixels).save(tmp_path / "flow.png")
    p.position[:] = np.array((3.0, 3.0, 1.7))[:, None]
    assert np.allclose(probe(F.VectorField(str(tmp_path / "flow.png"), CORNERS), p)[0].T, (1.0, -1.0, 0.0))
    p.position[:] = np.array((3.0, -3.0, 1.7))[:, None]
    assert np.allclose(probe(F.VectorField(str(tmp_path / "flow.png"), CORNERS), p)[0], 0.0)


PRESET = """version: 1
clock: {duration: 1, fps: 25, step: 0.01}
forces:
  vector_field: {field: FILE, bounds: [[-3, -3, -3], [3, 3, 3]], strength: 2}
medium: {vector_field: flow.npy}
systems:
  dust: {forces: {damping: 0.5}, emitters: {e: {count: 3}}}
"""


def test_in_a_preset_the_file_lies_in_its_folder_and_is_part_of_the_recipe(tmp_path):
    _, grid = linear()
    np.save(tmp_path / "flow.npy", grid)
    path = tmp_path / "piece.yaml"
    path.write_text(PRESET.replace("FILE", "flow.npy"))
    preset = ga.load_preset(str(path))
    assert [file["path"] for file in make_recipe(preset)["files"]] == ["flow.npy"]
    ga.Simulation(preset).step(2)
    for wrong, words in (
        ("../flow.npy", "own folder"),
        ("none.npy", "no such file"),
        ("piece.yaml", "neither a NumPy array"),
    ):
        path.write_text(PRESET.replace("FILE", wrong))
        with pytest.raises(ga.PresetError, match=words) as caught:
            ga.load_preset(str(path))
        assert "piece.yaml:4" in str(caught.value)


def test_wrong_grids_are_sentences(tmp_path):
    np.save(tmp_path / "flat.npy", np.zeros((4, 4, 3)))
    np.save(tmp_path / "text.npy", np.full((2, 2, 2, 3), "a"))
    (tmp_path / "broken.npy").write_bytes(b"\x93NUMPY")
    for given, words in (
        (tmp_path / "flat.npy", r"shape \(nx, ny, nz, 3\).*not \(4, 4, 3\)"),
        (tmp_path / "text.npy", "real numbers"),
        (tmp_path / "broken.npy", "is not a NumPy array"),
        (tmp_path / "none.npy", "no such file"),
        (np.full((2, 2, 2, 3), np.nan), "not finite"),
        (np.zeros((2, 2, 2, 2)), "shape"),
    ):
        with pytest.raises(ga.UsageError, match=words):
            F.VectorField(given)
    for bounds in ((1, 2), ((0, 0, 0), (1, 1, 0)), ((0, 0), (1, 1)), "big"):
        with pytest.raises(ga.UsageError, match="two corners"):
            F.VectorField(np.zeros((2, 2, 2, 3)), bounds)
