"""ga.develop, ga.still and ga.Film: pictures of simulations that a script advances itself."""

import av
import numpy as np
import pytest
from PIL import Image

import gen_art as ga
from gen_art.output import job
from gen_art.output.script_film import Film
from tests.output.piece import piece

SIZE = (96, 54)
CAMERA = ga.Camera(position=(0, 0, 6), target=(0, 0, 0), fov=40)


def orbiting(**more):
    """Two hundred particles that circle the y axis, one turn a second."""
    rng = np.random.default_rng(1)
    angle, radius = rng.uniform(0, 2 * np.pi, 200), rng.uniform(0.5, 2.0, 200)
    x = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(200)], axis=1)
    v = 2 * np.pi * np.stack([-x[:, 1], x[:, 0], np.zeros(200)], axis=1)
    stars = ga.ParticleSystem(
        position=x, velocity=v, forces=[ga.forces.CentralForce(center=(0, 0, 0), strength=4 * np.pi**2, exponent=1)], **more
    )  # fmt: skip
    return ga.Simulation({"stars": stars}, dt=1 / 240)


def frames(path) -> np.ndarray:
    with av.open(str(path)) as film:
        return np.stack([frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)])


def by_hand(preset, path) -> ga.Film:
    """The film of a preset, each of its frames added by this loop."""
    sim = ga.Simulation(preset)
    with ga.Film(path, size=SIZE, fps=preset.clock.fps) as film:
        for k in range(preset.clock.frames):
            if k:
                sim.step(preset.clock.steps_per_frame)
            film.add(sim)
    return film


def test_a_film_by_hand_is_the_film_of_the_preset(tmp_path):
    """Trails, streaks that bend, and the camera's path: picture by picture what `ga.render` makes of the same preset."""
    preset = piece(
        clock__preroll=0, camera__path=[{"time": 0, "position": [0, 0.3, 5]}, {"time": 0.5, "position": [1, 0.3, 4]}]
    )
    film = by_hand(preset, tmp_path / "hand.mkv")
    assert film.frames == preset.clock.frames
    job.render(preset, tmp_path / "job.mkv", size=SIZE)
    assert np.array_equal(frames(tmp_path / "hand.mkv"), frames(tmp_path / "job.mkv"))


def test_a_film_does_not_depend_on_how_its_simulation_is_stepped(tmp_path):
    looks = {
        "stars": ga.Look(draw="streak", width=0.05, length=0.1, emission={"color": "gold"}, trail={"half_life": 0.1})
    }
    made = []
    for name, parts in (("one", 1), ("many", 8)):
        sim = orbiting()
        with Film(tmp_path / f"{name}.mkv", size=SIZE, speed=1.0, camera=CAMERA, looks=looks) as film:
            for _ in range(5):
                for _ in range(parts):
                    sim.step(8 // parts)
                film.add(sim)
        made.append(frames(tmp_path / f"{name}.mkv"))
    assert np.array_equal(*made)


def test_trails_are_whole_between_pictures(tmp_path):
    """A particle that moves by a quarter turn from picture to picture leaves light on its way, not only where it was shown."""
    x = np.array([[2.0, 0.0, 0.0]])
    light = {}
    for trail in (None, {"half_life": 1.0, "substeps": 8}):
        stars = ga.ParticleSystem(
            position=x, velocity=2 * np.pi * np.array([[0.0, 2.0, 0.0]]),
            forces=[ga.forces.CentralForce(center=(0, 0, 0), strength=4 * np.pi**2, exponent=1)],
        )  # fmt: skip
        sim = ga.Simulation({"stars": stars}, dt=1 / 240)
        look = ga.Look(draw="disc", radius=0.15, emission={"color": "white", "intensity": 8}, trail=trail)
        with ga.Film(
            tmp_path / "a.mkv", size=SIZE, fps=4, speed=1.0, camera=CAMERA, looks={"stars": look}, overwrite=True
        ) as film:
            for _ in range(2):
                sim.step(60)
                film.add(sim)
        picture = frames(tmp_path / "a.mkv")[-1].astype(int)
        light[trail is None] = picture[4:15, 24:37].max()  # halfway on the quarter through which it came
    assert light[True] < 10 and light[False] > 40


def test_the_speed_is_that_of_the_first_two_pictures(tmp_path):
    """Streaks of a film without `speed` are as long as with it, from the second picture on."""
    made = []
    for speed in (None, 0.5):
        sim = orbiting()
        look = ga.Look(draw="streak", width=0.1, emission={"color": "white"})
        with ga.Film(
            tmp_path / "a.mkv", size=SIZE, fps=30, speed=speed, camera=CAMERA, looks={"stars": look}, overwrite=True
        ) as film:
            for _ in range(3):
                film.add(sim)
                sim.step(4)
        made.append(frames(tmp_path / "a.mkv"))
    assert np.array_equal(made[0][2], made[1][2])
    with (
        pytest.raises(ga.UsageError, match="has not advanced"),
        ga.Film(tmp_path / "b.mkv", size=SIZE, camera=CAMERA) as film,
    ):
        film.add(sim)
        film.add(sim)


def test_a_still_of_a_simulation_and_of_a_preset(tmp_path):
    preset = piece()
    sim = ga.Simulation(preset)
    sim.advance_to_frame(4)
    path = ga.still(sim, tmp_path / "deep" / "sim.png", size=SIZE)
    assert path == tmp_path / "deep" / "sim.png" and Image.open(path).size == SIZE
    linear = ga.render_frame(sim, size=SIZE)
    developed = ga.develop(linear, spec=preset.develop)
    assert np.array_equal(np.asarray(Image.open(path)), developed)
    made = ga.still(preset, tmp_path / "preset.png", 0.2, size=SIZE)
    assert made.read_bytes() == job.still(preset, tmp_path / "job.png", 0.2, size=SIZE)[0].read_bytes()
    with pytest.raises(ga.GenArtError, match="exists already"):
        ga.still(sim, path, size=SIZE)


def test_looks_and_develop_of_a_still(tmp_path):
    sim = orbiting()
    plain = np.asarray(Image.open(ga.still(sim, tmp_path / "a.png", size=SIZE, camera=CAMERA)))
    red = ga.still(
        sim,
        tmp_path / "b.png",
        size=SIZE,
        camera=CAMERA,
        looks={"stars": {"draw": "disc", "radius": 0.2, "emission": {"color": "red"}}},
    )
    picture = np.asarray(Image.open(red)).astype(int)
    assert picture[..., 0].sum() > 3 * picture[..., 2].sum() and plain.astype(int)[..., 0].sum() == pytest.approx(
        plain.astype(int)[..., 2].sum(), rel=0.02
    )
    nothing = np.asarray(Image.open(ga.still(sim, tmp_path / "c.png", size=SIZE, camera=CAMERA, looks={"stars": None})))
    assert nothing.max() <= 1
    bright = np.asarray(
        Image.open(ga.still(sim, tmp_path / "d.png", size=SIZE, camera=CAMERA, develop={"exposure": 4}))
    )
    assert bright.astype(int).sum() > 1.3 * plain.astype(int).sum()


def test_develop():
    light = np.zeros((8, 16, 4), np.float32)
    light[..., :3] = 0.18
    light[..., 3] = 1.0
    assert ga.develop(light).dtype == np.uint8 and ga.develop(light).shape == (8, 16, 3)
    assert ga.develop(light, bits=16).dtype == np.uint16 and ga.develop(light, transparent=True).shape == (8, 16, 4)
    linear = ga.develop(light, tone="none", bloom=0, dither=False)
    assert np.all(np.abs(linear.astype(int) - round(255 * (1.055 * 0.18 ** (1 / 2.4) - 0.055))) <= 1)
    assert ga.develop(light, tone="none", exposure=1).mean() > 1.2 * linear.mean()
    assert np.array_equal(ga.develop(light.astype(np.float64)), ga.develop(light))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda light: ga.develop(light[..., :3]), r"\(height, width, 4\) of floats"),
        (lambda light: ga.develop(light.astype(int)), "of floats"),
        (lambda light: ga.develop(np.full_like(light, np.nan)), "must be finite"),
        (lambda light: ga.develop(light, tone="agxx"), "develop.tone"),
        (lambda light: ga.develop(light, expsure=1), "develop.expsure"),
        (lambda light: ga.develop(light, bits=12), "8 or 16 bits"),
        (lambda light: ga.develop(light, spec={"tone": "agx"}), "spec must be"),
        (lambda light: ga.still(orbiting(), "a.png", 1.0), "time: a simulation is drawn as it is now"),
        (lambda light: ga.still(orbiting(), "a.png", quality="draft"), "quality: a simulation is drawn"),
        (lambda light: ga.still("fire", "a.png", looks={}), "looks: a preset says this itself"),
        (lambda light: ga.still(orbiting(), "a.exr"), "an .exr is made of a preset"),
        (lambda light: ga.still(orbiting(), "a.png", looks={"star": None}), "no system 'star'; did you mean 'stars'"),
        (lambda light: ga.still(orbiting(), "a.png", looks={"stars": {"drow": 1}}), "looks.stars.drow"),
        (lambda light: ga.Film("a.avi"), "is not a film extension"),
        (lambda light: ga.Film("a.mp4", size=(95, 54)), "even"),
        (lambda light: ga.Film("a.mp4", fps=0), "fps"),
        (lambda light: ga.Film("a.mp4", speed=-1), "speed"),
    ],
)
def test_what_cannot_be_meant(call, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ga.UsageError, match=words):
        call(np.zeros((8, 16, 4), np.float32))
    assert not list(tmp_path.iterdir())


def test_ends_of_films(tmp_path):
    sim = orbiting()
    with pytest.raises(ga.UsageError, match="at least one picture"), ga.Film(tmp_path / "none.mkv", size=SIZE):
        pass
    assert not list(tmp_path.iterdir())
    with ga.Film(tmp_path / "a.mkv", size=SIZE, speed=1.0, camera=CAMERA) as film:
        film.add(sim)
        with pytest.raises(ga.UsageError, match="one simulation"):
            film.add(orbiting())
    with pytest.raises(ga.UsageError, match="is closed"):
        film.add(sim)
    assert not sim._observers, "it looks no more"
    with pytest.raises(ga.GenArtError, match="exists already"):
        ga.Film(tmp_path / "a.mkv", size=SIZE)
    with (
        pytest.raises(ZeroDivisionError) as caught,
        ga.Film(tmp_path / "b.mkv", size=SIZE, speed=1.0, camera=CAMERA) as film,
    ):
        for _ in range(80):
            film.add(sim)
            sim.step(1)
        raise ZeroDivisionError
    assert not (tmp_path / "b.mkv").exists()
    partial = tmp_path / "b.partial.mkv"
    assert partial.exists() == any("frames are kept" in note for note in getattr(caught.value, "__notes__", ()))


def test_a_film_by_hand_has_the_flashes_of_the_preset(tmp_path):
    """A mutant that forgets flashes, or takes them at every picture, fails."""
    look = {
        "draw": "sphere", "blend": "opaque", "radius": 0.2, "emission": "white", "flashes": {"every": 0.1, "number": 3, "tail": 0.5},
    }  # fmt: skip
    ball = {"emitters": {"one": {"count": 1, "shape": {"point": [-1, 0, 0]}, "velocity": [4, 0, 0]}}, "look": look}
    preset = ga.load_preset(
        {"version": 1, "clock": {"duration": 0.5, "fps": 30, "step": "1/120"}, "camera": {"position": [0, 0, 6]}, "light": {}, "systems": {"ball": ball}}
    )  # fmt: skip
    by_hand(preset, tmp_path / "hand.mkv")
    job.render(preset, tmp_path / "job.mkv", size=SIZE)
    pictures = frames(tmp_path / "hand.mkv")
    assert np.array_equal(pictures, frames(tmp_path / "job.mkv"))
    assert (pictures[-1] > 100).sum() > 1.5 * (pictures[0] > 100).sum() > 0


def test_flashes_of_a_film_without_a_speed_come_as_often_as_they_should(tmp_path):
    """Before a film knows its speed, too. A mutant that flashes at every step until then fails."""
    look = ga.Look(draw="sphere", blend="opaque", radius=0.2, flashes={"every": 0.1, "number": 8})
    made = []
    for name, speed in (("given", 1.0), ("measured", None)):
        ball = ga.ParticleSystem(position=np.array([[-1.0, 0.0, 0.0]]), velocity=np.array([[4.0, 0.0, 0.0]]))
        sim = ga.Simulation({"ball": ball}, dt=1 / 120)
        with ga.Film(
            tmp_path / f"{name}.mkv", size=SIZE, fps=30, speed=speed, camera=CAMERA, looks={"ball": look}, light={}
        ) as film:
            for _ in range(10):
                film.add(sim)
                sim.step(4)
        made.append(frames(tmp_path / f"{name}.mkv"))
    assert np.array_equal(*made)
