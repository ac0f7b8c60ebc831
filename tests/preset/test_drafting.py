"""A draft has fewer particles, and shows as much light, hides as much, and moves alike."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.output import job
from gen_art.output.playback import Playback
from gen_art.output.read_recipe import read_recipe
from gen_art.output.rerun import rerun
from gen_art.preset.drafting import FEWEST, drafted
from gen_art.preset.estimate import estimate
from gen_art.preset.load import load_preset

MANY = 80_000


def cloud(look: dict, **changes):
    """Particles at rest in a box in the middle of the picture, before a sky of light 1."""
    data = {
        "version": 1, "seed": 4, "clock": {"duration": 1, "fps": 10, "step": "1/100"},
        "sky": {"gradient": ["#ffffff", "#ffffff"]},
        "systems": {"cloud": {
            "particle": {"radius": 0.02, "mass": 1, "lifetime": 100},
            "emitters": {"box": {"count": MANY, "shape": {"box": [2, 1, 1]}}},
            "look": look,
        }},
        "camera": {"position": [0, 0, 6], "target": [0, 0, 0], "size": [160, 90]},
        "develop": {"tone": "none", "bloom": 0},
    }  # fmt: skip
    return load_preset(data, overrides=changes)


def light(preset) -> np.ndarray:
    return next(Playback(preset, (80, 45), "f32", None).pictures([0]))[0][..., :3].astype(float).copy()


def shown(preset, without: np.ndarray) -> float:
    return float((light(preset) - without).sum())


BRIGHT = {"color": "white", "intensity": 0.01}


@pytest.mark.parametrize(
    "look",
    [
        {"draw": "disc", "radius": 0.03, "emission": BRIGHT},
        {"draw": "disc", "radius": 0.03},
        {"draw": "disc", "pixels": 2, "emission": {**BRIGHT, "intensity": [[0, 0.01], [1, 0]]}},
        {"draw": "point", "emission": BRIGHT},
        {"draw": "pixel", "emission": {"intensity": {"by": "random", "curve": [[0, 0], [1, 0.02]]}}},
        {"draw": "disc", "radius": 0.03, "blend": "alpha", "opacity": 1e-4, "albedo": "black"},
        {"draw": "disc", "radius": 0.03, "blend": "alpha", "opacity": 1e-4, "reference": 0.02, "albedo": "black"},
    ],
)
def test_a_draft_shows_as_much_light_and_hides_as_much(look):
    """The sums over the picture agree to what a part of random sizes and the rims of wider sprites leave open, 2%.

    Mutants: no compensation; discs as bright as they were; a wider disc with `reference` treated as one without; the emission
    that a look leaves out stays as it was; densities stay as they were.
    """
    full = cloud(look)
    few = drafted(full)
    empty = light(cloud(look, **{"systems.cloud.emitters.box.count": 0}))
    assert estimate(few).peak["cloud"] == MANY / (8 if look["draw"] == "disc" else 4)
    assert shown(few, empty) == pytest.approx(shown(full, empty), rel=0.02)
    assert abs(shown(full, empty)) > 1


def test_discs_beside_streaks_are_thinned_as_streaks():
    """Mutant: an eighth as soon as one look draws discs."""
    mixed = cloud({"draw": "disc"}, **{"systems.cloud.looks": {"paths": {"draw": "streak", "width": 0.02}}})
    assert estimate(drafted(mixed)).peak["cloud"] == MANY / 4


def test_a_draft_keeps_what_is_small_solid_or_moves_others():
    """Mutants: solid balls are thinned; bodies that pull others are thinned; a system below the limit is thinned."""
    dots = {"draw": "point"}
    small = cloud(dots, **{"systems.cloud.emitters.box.count": FEWEST})
    assert drafted(small) is small
    for look in ({"draw": "sphere", "blend": "opaque"}, {"draw": "sphere"}):
        balls = cloud(look)
        assert drafted(balls) is balls
    pulling = cloud(dots, **{"systems.cloud.interactions": {"self_gravity": {"softening": 0.1}}})
    assert drafted(pulling) is pulling
    sparse = drafted(cloud(dots, **{"systems.cloud.emitters.box.count": 2 * FEWEST}))
    assert sparse.systems["cloud"].emitters["box"].count.lo == FEWEST


@pytest.mark.parametrize("points, kept", [(8, 8), (20, 16), (80, 40)])
def test_ribbons_of_a_draft_show_the_same_paths_through_fewer_points(points, kept):
    """Circles in a magnetic field, of which ribbons show three quarters: the paths between points are curved.
    Mutants: all points are kept; a quarter of them."""
    ions = {
        "particle": {"radius": 0.01, "mass": 1, "charge": 1, "lifetime": 100},
        "integrator": "boris",
        "emitters": {"m": {"count": 3, "shape": {"line": [[-1, 0, 0], [1, 0, 0]]}, "velocity": [0, 1, 0]}},
        "look": {"draw": "streak", "width": 0.02, "ribbon": {"length": 1.6, "points": points}},
    }
    changes = {
        "systems.cloud.emitters.box.count": 0,
        "systems.ions": ions,
        "clock.preroll": 2,
        "forces": {"magnetic_field": {"field": [0, 0, 3]}},
    }
    full = cloud({"draw": "point"}, **changes)
    few = drafted(full)
    assert few.systems["ions"].look.ribbon.points == kept
    pictures = [next(Playback(each, (160, 90), "f32", None).pictures([200]))[0][..., 0].copy() for each in (full, few)]
    ends = 1 / points + 1 / kept  # the old ends differ by up to an interval
    assert np.abs(pictures[0] - pictures[1]).sum() < ends * (pictures[0] - pictures[0].min()).sum()


def test_particles_of_a_draft_move_as_those_of_the_film():
    full = load_preset("wormhole", overrides={"clock.preroll": 1, "clock.duration": "1/10"})
    few = drafted(full)
    assert few is not full
    states = []
    for each in (full, few):
        sim = ga.Simulation(each, advice="none")
        sim.step(24)
        states.append(sim.systems["dust"])
    assert states[1].count < 0.3 * states[0].count
    mean = [state.floats[:3, : state.count].mean(axis=1) for state in states]
    spread = states[0].floats[:3, : states[0].count].std(axis=1) / np.sqrt(states[1].count)
    assert (np.abs(mean[0] - mean[1]) < 5 * spread + 1e-6).all()


def test_a_galaxy_s_draft_has_fewer_and_heavier_bodies():
    galaxy = load_preset("galaxy", overrides={"clock.duration": "1/30", "clock.preroll": 0})
    few = drafted(galaxy)
    assert estimate(few).peak["bodies"] == 250_000
    mass = [ga.Simulation(each, advice="none")["bodies"].mass.sum(dtype=float) for each in (galaxy, few)]
    assert mass[1] == pytest.approx(mass[0], rel=1e-5)


def test_a_draft_has_the_film_s_camera_and_its_recipe_the_whole_preset(tmp_path):
    """Mutants: the camera of the thinned preset; a recipe of the thinned preset, which would be thinned again."""
    framed = cloud({"draw": "point"}, **{"camera.frame": "auto"})
    (path,) = job.still(framed, tmp_path / "draft.png", 0.1, quality="draft")
    recipe = read_recipe(path)
    assert recipe["preset"]["systems"]["cloud"]["emitters"]["box"]["count"] == MANY
    (full,) = job.still(framed, tmp_path / "final.png", 0.1)
    assert recipe["fit"] == read_recipe(full)["fit"]
    plan = job.plan_still(framed, tmp_path / "other.png", 0.1, precision="f32", quality="draft")
    assert plan.with_fit(framed, "f32", None) is not None and plan.drawn.fits == framed.fits
    (again,) = rerun(path, tmp_path / "again.png")
    assert again.read_bytes() == path.read_bytes()
    (frame,) = job.render(framed, tmp_path / "frame.png", frames=1, quality="draft")
    assert frame.read_bytes() == path.read_bytes()
