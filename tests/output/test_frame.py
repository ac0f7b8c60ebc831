"""`camera.frame`: measured on the pictures themselves, the subject fills its part of the frame over the film, with air at every side."""

import hashlib
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.commands.main import run
from gen_art.output import job
from gen_art.output.framing import framing_of
from gen_art.output.read_recipe import read_recipe
from gen_art.output.rerun import rerun
from gen_art.preset.camera import Fit, Frame
from gen_art.preset.load import load_preset
from gen_art.preset.thinning import MUTUAL, galaxies, independent_systems, thinned
from gen_art.renderer import fitting
from gen_art.renderer.camera import Camera
from gen_art.renderer.survey import ATTRACTING, Moment, survey


def piece(frame="auto", changes=None, **camera):
    """Thirty balls thrown up: they rise 3 m and fall 5 m below the hand, and spread."""
    data = {
        "name": "throw", "version": 1, "seed": 3, "clock": {"duration": 2, "fps": 10, "step": "1/100"},
        "forces": {"gravity": [0, -9.81, 0]},
        "systems": {
            "balls": {
                "particle": {"radius": 0.1, "lifetime": 10},
                "emitters": {"hand": {"count": 30, "velocity": {"cone": [0, 1, 0], "angle": 20, "speed": "7..9"}}},
                "look": {"draw": "sphere"},
            }
        },
        "camera": {"position": [0, 3, 40], "size": [320, 180], "frame": frame, **camera},
    }  # fmt: skip
    return load_preset(data, overrides=changes)


def digest(path) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def free_sides(paths) -> np.ndarray:
    """(4,) parts of the picture that stay free at the left, right, top and bottom over all the pictures."""
    lit = np.any([np.asarray(Image.open(path).convert("L")) > 40 for path in paths], axis=0)
    rows, columns = np.nonzero(lit)
    height, width = lit.shape
    return np.array(
        [columns.min() / width, 1 - (columns.max() + 1) / width, rows.min() / height, 1 - (rows.max() + 1) / height]
    )


CAMERAS = {
    "perspective": {},
    "wide angle, inside the throw": {"position": [0, 0, 1], "fov": 100},
    "orthographic": {"height": 0.5},
    "orbit": {"position": [3, 5, 10], "orbit": 90},
    "orthographic orbit": {"position": [3, 5, 10], "orbit": 90, "height": 30},
    "path": {"path": [{"time": 0, "position": [0, 0, 10]}, {"time": 2, "position": [10, 4, 0]}]},
    "upright": {"size": [180, 320]},
    "rolled": {"roll": 30, "position": [5, -8, 3]},
}


@pytest.mark.parametrize("name", CAMERAS)
def test_the_subject_fills_its_part_and_has_air_in_every_frame(tmp_path, name):
    left, right, top, bottom = free_sides(job.render(piece(**CAMERAS[name]), tmp_path / "a_##.png"))
    assert 0.55 <= max(1 - left - right, 1 - top - bottom) <= 0.75
    assert min(left, right, top, bottom) >= 0.1
    assert abs(left - right) < 0.06 and abs(top - bottom) < 0.06


@pytest.mark.parametrize("camera", ["perspective", "orbit"])
def test_also_in_the_frames_that_the_survey_does_not_see(tmp_path, camera):
    """A charge circles 0.97 times a second for 300 frames, of which the survey looks at some forty."""
    changes = {
        "clock.duration": 12, "clock.fps": 25, "forces": {"magnetic_field": [0, 0, 6.1]}, "camera.size": [160, 90],
        "systems.balls.particle": {"radius": 0.2, "lifetime": 20, "charge": 1, "mass": 1},
        "systems.balls.emitters.hand": {"count": 1, "velocity": [6, 0, 0]},
    }  # fmt: skip
    changes["systems.balls.integrator"] = "boris"
    preset = piece(changes=changes, **CAMERAS[camera])
    assert preset.clock.frames == 300
    left, right, top, bottom = free_sides(job.render(preset, tmp_path / "a_###.png"))
    assert 0.55 <= max(1 - left - right, 1 - top - bottom) <= 0.75
    assert min(left, right, top, bottom) >= 0.1


def test_threads_find_the_same_fit():
    script = (
        "import sys; from tests.output.test_frame import fitting, piece\n"
        "crowd = piece(changes={'systems.balls.emitters.hand.count': 50000})\n"
        "print(fitting.fit_of(crowd, (320, 180), threads=int(sys.argv[1])))"
    )
    root = Path(__file__).parents[2]
    said = [
        subprocess.run([sys.executable, "-c", script, n], check=True, cwd=root, capture_output=True).stdout
        for n in "12"
    ]
    assert said[0] == said[1] and b"Fit(" in said[0]


def test_a_film_that_begins_empty():
    late = {"systems.balls.emitters.hand": {"rate": 40, "start": 0.8, "velocity": [0, 3, 0]}}
    assert fitting.fit_of(piece(changes=late), (320, 180)).factor > 0


def test_without_frame_it_does_not(tmp_path):
    """The mutant: the same cameras as they stand cut the subject or show it small."""
    for name in ("perspective", "orthographic", "orbit"):
        left, right, top, bottom = free_sides(job.render(piece(False, **CAMERAS[name]), tmp_path / f"{name}_##.png"))
        assert not (0.55 <= max(1 - left - right, 1 - top - bottom) <= 0.75 and min(left, right, top, bottom) >= 0.1)


@pytest.mark.parametrize("fill", [0.3, 0.8])
def test_fill(tmp_path, fill):
    *_, top, bottom = free_sides(job.render(piece(fill), tmp_path / "a_##.png"))
    assert 1 - top - bottom == pytest.approx(fill, abs=0.05)


def test_the_direction_of_view_stays():
    preset = piece(position=[3, 5, 10], orbit=90, roll=10)
    fit = fitting.fit_of(preset, (320, 180))
    for time in (0.0, 0.7, 2.0):
        plain, framed = Camera.from_spec(preset.camera).at(time), Camera.from_spec(preset.camera, fit).at(time)
        assert np.array_equal(plain.axes, framed.axes) and plain.fov == framed.fov
        target = plain.position + plain.distance * plain.axes[2] + fit.move
        assert np.allclose(framed.position + framed.distance * framed.axes[2], target)
        assert framed.distance == pytest.approx(fit.factor * plain.distance)


def test_near_far_fog_and_focus_keep_their_place_about_the_target():
    spec = piece(near=5, far=80, fog={"start": 30, "distance": 9}, lens={"radius": 0.1, "focus": 38}).camera
    plain, framed = Camera.from_spec(spec).at(0.0), Camera.from_spec(spec, Fit((1.0, 2.0, 3.0), 0.5)).at(0.0)
    back = framed.distance - plain.distance
    assert back == pytest.approx(-0.5 * plain.distance)
    assert framed.near == pytest.approx(1e-6 * framed.distance) and framed.far == pytest.approx(80 + back)
    assert framed.fog[0] == pytest.approx(30 + back) and framed.fog[1] == 9
    assert framed.lens[1] == pytest.approx(38 + back)


def test_a_still_is_the_frame_of_the_film_and_ranges_are_parts_of_it(tmp_path):
    for camera in ({}, {"height": 3}, {"orbit": 90}):
        film = job.render(piece(**camera), tmp_path / "all_##.png", overwrite=True)
        part = job.render(piece(**camera), tmp_path / "part_##.png", frames=range(7, 10), overwrite=True)
        assert [digest(p) for p in part] == [digest(p) for p in film[7:10]]
        (still,) = job.still(piece(**camera), tmp_path / "still.png", 0.7, overwrite=True)
        assert digest(still) == digest(film[7])


def test_rerun_takes_the_fit_of_the_recipe(tmp_path, monkeypatch):
    (path,) = job.still(piece(), tmp_path / "a.png", 0.7)
    fit = fitting.fit_of(piece(), (320, 180))
    assert read_recipe(path)["fit"] == {"move": list(fit.move), "factor": fit.factor}
    assert "fit" not in read_recipe(job.still(piece(False), tmp_path / "plain.png", 0.7)[0])
    monkeypatch.setattr(fitting, "survey", None)  # nothing may run ahead
    assert digest(rerun(path, tmp_path / "again.png")[0]) == digest(path)


def test_a_damaged_fit_is_a_sentence(tmp_path):
    from gen_art.output.recipe import check_complete

    recipe = read_recipe(job.still(piece(), tmp_path / "a.png", 0.7)[0])
    for fit in ({"move": [0, 0], "factor": 1.0}, {"move": [0.0, 0.0, 0.0], "factor": 0.0}, {"move": 1}, 7):
        with pytest.raises(ga.UsageError, match="damaged: fit"):
            check_complete({**recipe, "fit": fit})


def test_unused_it_costs_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(fitting, "survey", None)
    job.still(piece(False), tmp_path / "a.png", 0.0)
    with pytest.raises(TypeError):  # the mutant
        job.still(piece(), tmp_path / "b.png", 0.0)


def test_size_and_quality_keep_the_camera_and_another_shape_of_the_picture_fits_anew():
    preset = piece()
    wide = fitting.fit_of(preset, (320, 180))
    assert fitting.fit_of(preset, (1280, 720)) == wide and len(preset.fits) == 1
    assert fitting.fit_of(preset, (180, 320)) != wide


def moment(points, radius=0.05, time=0.0, light=1.0) -> Moment:
    """Discs of these radii; `light` is the part of their area that is seen."""
    points = np.array(points, float)
    radius, nothing = np.broadcast_to(np.array(radius, float), len(points)), np.zeros(len(points))
    return Moment(time, points, radius, nothing, light * np.pi * radius**2, nothing)


def test_a_stray_particle_does_not_decide():
    cloud = np.random.default_rng(1).uniform(-1, 1, (200, 3))
    camera = Camera(position=(0, 0, 20))
    calm = fitting.fit_camera([moment(cloud)], camera, 16 / 9, Frame())
    stray = np.concatenate([cloud, [[500, 40, 0]]])
    assert fitting.fit_camera([moment(stray)], camera, 16 / 9, Frame()).factor == pytest.approx(calm.factor, rel=0.05)
    seen = fitting.fit_camera([moment(stray)], camera, 16 / 9, Frame(stray=0.0))
    assert seen.factor > 20 * calm.factor  # the mutant: all count
    large = fitting.fit_camera([moment(stray, [*[0.05] * 200, 1.0])], camera, 16 / 9, Frame())
    assert large.factor > 20 * calm.factor  # it is what is seen that counts


def test_a_moment_that_is_nearly_dark_does_not_decide():
    cloud = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    camera = Camera(position=(0, 0, 20))
    alone = fitting.fit_camera([moment(cloud)], camera, 1.0, Frame())
    ember = moment([[300, 0, 0]], time=1.0, light=1e-4)
    assert fitting.fit_camera([moment(cloud), ember], camera, 1.0, Frame()).factor == pytest.approx(
        alone.factor, rel=0.05
    )
    lamp = moment([[300, 0, 0]], time=1.0)
    assert fitting.fit_camera([moment(cloud), lamp], camera, 1.0, Frame()).factor > 20 * alone.factor


def test_particles_that_cover_each_other_count_as_what_is_seen_of_them():
    """A wall of 20,000 discs on each other, and a ring of 30 about it that is seen as well: the ring is in the picture."""
    rng = np.random.default_rng(2)
    wall = np.concatenate([rng.uniform(-1, 1, (20000, 2)), np.zeros((20000, 1))], axis=1)
    angle = np.linspace(0, 2 * np.pi, 30, endpoint=False)
    ring = 3 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    camera = Camera(position=(0, 0, 20))
    fit = fitting.fit_camera([moment(np.concatenate([wall, ring]), 0.1)], camera, 1.0, Frame())
    half_height = np.tan(np.radians(20)) * 20 * fit.factor
    assert 6.2 / (2 * half_height) == pytest.approx(0.65, abs=0.02)


def test_one_dot_is_centred_at_the_same_distance():
    one, nothing = np.ones(1), np.zeros(1)
    dot = Moment(0.0, np.array([[3.0, 1.0, 0.0]]), nothing, one, nothing, one)
    fit = fitting.fit_camera([dot], Camera(position=(0, 0, 20)), 1.0, Frame())
    assert fit == Fit((3.0, 1.0, 0.0), 1.0)


def test_a_size_that_is_not_found_says_so(monkeypatch):
    monkeypatch.setattr(fitting, "STEPS", 2)
    with pytest.warns(ga.AdviceWarning, match="no distance was found"):
        fitting.fit_of(piece(position=[0, 0, 4000]), (320, 180))


def test_a_search_that_runs_away_begins_again_outside_or_stays(monkeypatch):
    """A first search that ends nowhere leaves no trace in the fit. If no search finds a place, the camera stays where it is, and the
    advice does not name `frame`, which the camera has. Mutant: what was found is not looked at."""
    search, tried = fitting._search, []

    def lost(moments, views, aspect, frame, factor):
        tried.append(factor)
        return np.full(3, 1e40), 1e12, True

    def lost_once(*given):
        return search(*given) if tried else lost(*given)

    monkeypatch.setattr(fitting, "_search", lost_once)
    fit = fitting.fit_of(piece(position=[0, 0, 2]), (320, 180))
    assert np.isfinite(fit.move).all() and 1 < fit.factor < 1e3 and tried == [1.0]
    monkeypatch.setattr(fitting, "_search", lost)
    with pytest.warns(ga.AdviceWarning, match="no distance was found .* stays where it is"):
        framing = framing_of(piece(position=[0, 0, 2]), (320, 180))
    assert framing.fit == Fit() and framing.advice and not any("frame: auto" in sentence for sentence in framing.advice)


def test_what_is_dark_does_not_count_and_a_dark_film_says_so():
    lamp = {
        "emitters": {"e": {"count": 20, "shape": {"sphere": {"center": [60, 0, 0], "radius": 1}}}},
        "look": {"draw": "disc", "radius": 0.3, "emission": {"intensity": 0.0}},
    }  # fmt: skip
    with_dark = piece(changes={"systems.dark": lamp})
    assert fitting.fit_of(with_dark, (320, 180)) == fitting.fit_of(piece(), (320, 180))
    lit = piece(changes={"systems.dark": {**lamp, "look": {"draw": "disc", "radius": 0.3}}})
    assert fitting.fit_of(lit, (320, 180)).factor > 3 * fitting.fit_of(piece(), (320, 180)).factor
    dark = piece(changes={"systems.balls.look": {"draw": "disc", "emission": {"intensity": 0.0}}})
    with pytest.warns(ga.AdviceWarning, match="nothing is seen"):
        assert fitting.fit_of(dark, (320, 180)) == Fit()


def test_the_subject_may_be_some_of_the_systems():
    floor = {
        "emitters": {"e": {"count": 500, "shape": {"box": {"min": [-30, -6, -30], "max": [30, -5.9, 30]}}}},
        "look": {"draw": "sphere", "radius": 0.5},
    }  # fmt: skip
    with_floor = {"systems.floor": floor, "camera.frame": {"of": "balls"}}
    assert fitting.fit_of(piece(changes=with_floor), (320, 180)) == fitting.fit_of(piece(), (320, 180))
    both = piece(changes={**with_floor, "camera.frame": {"of": ["balls", "floor"]}})
    assert fitting.fit_of(both, (320, 180)).factor > 2 * fitting.fit_of(piece(), (320, 180)).factor
    assert fitting.fit_of(both, (320, 180)) == fitting.fit_of(piece(changes={"systems.floor": floor}), (320, 180))


def test_the_survey_thins_only_what_moves_nothing_else():
    crowd = {"systems.balls.emitters.hand.count": 300000}
    (first, *_) = survey(piece(changes=crowd))
    assert 5000 < len(first.points) <= 10001
    assert independent_systems(piece()) == ["balls"]
    few = survey(piece(changes={"systems.balls.emitters.hand.count": 3000}))[0]
    assert first.weight.sum() == pytest.approx(100 * few.weight.sum(), rel=0.01)  # each stands for thirty
    pulling = piece(changes={"systems.balls.interactions": {"self_gravity": {"softening": 0.1}}})
    assert independent_systems(pulling) == []
    assert independent_systems(load_preset("fireworks"))


def test_the_survey_thins_galaxies_and_grains_that_follow_them():
    """What bodies attract moves nothing itself; a fourth of a galaxy's bodies have four times the mass each, and attract as much.

    Mutants: systems with `sources` count as acting on others; bodies of a fixed mass are thinned too; the sources are thinned
    as grains are.
    """
    short = {"clock.duration": "1/30", "clock.preroll": 0, "camera.frame": "auto"}
    galaxy = load_preset("galaxy", overrides=short)
    assert independent_systems(galaxy) == ["far"] and galaxies(galaxy) == ["bodies"]
    (first, *_) = survey(galaxy)
    assert 3900 < len(first.points) <= 4000 + 420 + 10  # each emitter has a whole number of them
    grains = load_preset("course/galaxy_encounter", overrides=short)
    assert independent_systems(grains) == ["stars", "gas", "nurseries", "clouds", "young", "far"]
    few, _ = thinned(galaxy, galaxy.clock.simulated, ATTRACTING // MUTUAL, galaxies(galaxy))
    masses = [ga.Simulation(each)["bodies"].mass for each in (galaxy, few)]
    assert len(masses[0]) == 1_000_000 and len(masses[1]) == pytest.approx(4000, abs=10)
    assert masses[1].sum(dtype=float) == pytest.approx(masses[0].sum(dtype=float), rel=1e-5)
    heavy = {
        "systems.balls.interactions": {"self_gravity": {"softening": 0.1}},
        "systems.balls.emitters.hand.count": 9000,
    }
    assert galaxies(piece(changes=heavy)) == [] == independent_systems(piece(changes=heavy))
    assert len(survey(piece(changes={**heavy, "clock.duration": "1/10"}))[0].points) == 9000
    touching = {"systems.bodies.interactions": {"self_gravity": {"softening": 0.1}, "contacts": {}}}
    assert galaxies(load_preset("galaxy", overrides={**short, **touching})) == []


def test_a_streak_counts_with_its_whole_length():
    fast = {"draw": "streak", "width": 0.1, "length": 1.0}
    plain = fitting.fit_of(piece(changes={"systems.balls.look": {"draw": "disc", "radius": 0.05}}), (320, 180))
    late = {"clock.preroll": 1, "clock.duration": 0.3}
    short = fitting.fit_of(piece(changes={**late, "systems.balls.look": {"draw": "disc", "radius": 0.05}}), (320, 180))
    long = fitting.fit_of(piece(changes={**late, "systems.balls.look": fast}), (320, 180))
    assert long.factor > 1.2 * short.factor and plain.factor > short.factor


def test_shown_by_render_frame_too(tmp_path):
    preset = piece()
    sim = ga.Simulation(preset)
    sim.step(preset.clock.step_at(1.0))
    light = ga.render_frame(sim, (320, 180))[..., 1] > 0.2
    still = np.asarray(Image.open(job.still(preset, tmp_path / "a.png", 1.0)[0]).convert("L")) > 60
    assert (light == still).mean() > 0.99 and still.any()


def test_inspect_says_what_is_cut_and_what_is_small(tmp_path, capsys):
    def said(preset) -> str:
        (tmp_path / "a.json").write_text(json.dumps(preset.resolved()))
        assert run(["inspect", "--frame", str(tmp_path / "a.json")]) == 0
        return " ".join(capsys.readouterr().out.split())

    good = said(piece())
    assert "subject over the film: 65% of the height" in good and "nothing is cut" in good and "in the film" not in good
    assert "camera.frame: the target moves by" in good
    small = said(piece(False, position=[0, 0, 90]))
    assert (
        "in the film the subject takes 1" in small
        and "bring the camera nearer" in small
        and "of the subject's light" not in small
    )
    cut = said(piece(False, position=[0, 3, 9]))
    assert "of the subject's light is outside the frame at" in cut and "bring the camera nearer" not in cut
    assert "outside the frame" not in run_plain(tmp_path, capsys)


def run_plain(tmp_path, capsys) -> str:
    assert run(["inspect", str(tmp_path / "a.json")]) == 0
    return capsys.readouterr().out


def test_the_light_that_is_cut_is_that_of_the_particles_outside():
    """Half of a row of lamps lies beyond the left side."""
    row = {"clock.duration": 0.1, "forces": {}, "systems.balls.emitters.hand": {
        "count": 2000, "shape": {"line": {"start": [-2, 0, 0], "end": [2, 0, 0]}}}}  # fmt: skip
    preset = piece(False, changes=row, position=[2.0, 0, 10], target=[2.0, 0, 0], height=2.25)
    found = framing_of(preset, (320, 180))
    assert found.film.cut == pytest.approx(0.5, abs=0.03) and "outside the frame" in found.advice[0]
    assert found.film.width == pytest.approx(4.2 / 4.0, abs=0.05)


@pytest.mark.parametrize(
    "value,sentence",
    [
        ("maximal", ":9:20: camera.frame: must be auto, false or a number such as 0.65, not 'maximal'"),
        ("0.95", ":9:20: camera.frame: must be from 0.05 to 0.8, not 0.95"),
        ("{of: ball}", "camera.frame.of: there is no system 'ball'"),
        ("{fil: 0.5}", "camera.frame.fil: unknown key; did you mean 'fill'?"),
        ("{stray: 0.7}", ":9:28: camera.frame.stray: must be from 0 to 0.5, not 0.7"),
    ],
)
def test_validate_says_what_is_wrong_and_where(tmp_path, capsys, value, sentence):
    text = f"""\
# A.
# B.
# C.
version: 1
clock: {{duration: 1, fps: 10, step: 0.01}}
systems: {{a: {{emitters: {{e: {{rate: 100}}}}, look: {{}}}}}}
camera:
  position: [0, 0, 5]
  frame:           {value}
"""
    (tmp_path / "a.yaml").write_text(text)
    assert run(["validate", str(tmp_path / "a.yaml")]) != 0
    said = capsys.readouterr()
    assert sentence in said.out + said.err and "Traceback" not in said.err
