"""Looks: sizes, colours by every quantity, tags, black bodies, strobes, fog; and that none of it compiles anything."""

import numpy as np
import pytest
from pydantic import ValidationError

from gen_art.backend import runtime
from gen_art.errors import UsageError
from gen_art.preset.camera import CameraSpec
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.colour import blackbody, linear, planck_luminance
from gen_art.renderer.painter import Painter
from gen_art.renderer.sprite import AREA
from tests.render.particles import scene, state

FLAT = Camera(position=(0, 0, 10), height=100.0)


def light(look, camera=FLAT, time=1.0, film_time=0.0, size=(200, 100), **particle):
    """The sum of light of one particle in the middle."""
    look = look if isinstance(look, Look) else Look(**look)
    picture = Painter(size, camera, {"a": look}).paint(
        scene(time, a=state(particle.pop("position", [[0.2, 0.3, 0]]), **particle)), film_time
    )
    return picture[..., :3].sum(axis=(0, 1), dtype=np.float64)


DISC = AREA * 1.5**2  # of radius 1 pixel, brightness 1


def test_sizes_in_the_world_in_pixels_and_of_the_particle():
    assert light({"draw": "disc", "radius": 2.0}) == pytest.approx([4 * DISC] * 3, rel=1e-5)
    assert light({"draw": "disc"}, radius=3.0) == pytest.approx([9 * DISC] * 3, rel=1e-5)
    assert light({"draw": "disc", "pixels": 72.0}) == pytest.approx([25 * DISC] * 3, rel=1e-5), "a pixel of 720 rows"
    assert light({"draw": "disc", "radius": 2.0, "size": [[0, 1], [1, 3]]}, life=2.0) == pytest.approx(
        [16 * DISC] * 3, rel=1e-4
    )


def test_brightness_is_kept_and_light_falls_as_distance_squared_in_perspective():
    look = {"draw": "disc", "radius": 0.5}
    near, far = (light(look, Camera(position=(0.2, 0.3, z), target=(0.2, 0.3, 0))) for z in (10, 20))
    assert near / far == pytest.approx([4] * 3, rel=1e-4)
    points = [
        light({"draw": "point", "falloff": f}, Camera(position=(0, 0, 10)), position=[[0, 0, -10]])
        for f in ("none", "inverse_square")
    ]
    assert points[0] / points[1] == pytest.approx([4] * 3, rel=1e-4)


@pytest.mark.parametrize(
    "by, particle, wanted",
    [
        ("age", {"life": 4.0}, 0.25),
        ("seconds", {"birth": 0.3}, 0.7),
        ("speed", {"velocity": [[0.36, 0.48, 0.0]]}, 0.6),
        ("energy", {"velocity": [[1.0, 0.0, 0.0]], "mass": 0.8}, 0.4),
        ("charge", {"charge": 0.3}, 0.3),
        ("mass", {"mass": 0.9}, 0.9),
        ("radius", {"radius": 0.5}, 0.5),
        ("distance", {"position": [[0.3, 0.4, 0.0]]}, 0.5),
        ("x", {"position": [[0.3, 0.4, 0.0]]}, 0.3),
        ("y", {"position": [[0.3, 0.4, 0.0]]}, 0.4),
        ("z", {"position": [[0.3, 0.4, 0.2]]}, 0.2),
        ("temperature", {"attributes": {"heat": 0.0, "temperature": 0.85}}, 0.85),
        ("id", {}, 0.0),
    ],
)
def test_intensity_and_colour_by_every_quantity(by, particle, wanted):
    ramp = {"draw": "disc", "pixels": 72, "emission": {"intensity": {"by": by, "curve": [[0, 0], [1, 1]]}}}
    assert light(ramp, **particle)[0] == pytest.approx(25 * DISC * wanted, rel=1e-4, abs=1e-6)
    color = {
        "draw": "disc",
        "pixels": 72,
        "emission": {"color": {"by": by, "range": "0..1", "gradient": [[0, "black"], [1, "white"]]}},
    }
    assert np.cbrt(light(color, **particle)[0] / (25 * DISC)) == pytest.approx(wanted, abs=0.005), (
        "OKLab's grey is a cube root"
    )


def test_a_quantity_that_is_not_there_is_refused():
    with pytest.raises(UsageError, match="cannot go by 'temprature'; did you mean 'temperature'"):
        light({"emission": {"intensity": {"by": "temprature"}}}, attributes={"temperature": 1.0})


@pytest.mark.parametrize("where", ["emission", "albedo", "both"])
def test_tags_choose_the_colours(where):
    """Of what is emitted and of what is scattered, each by its own rows. Mutants: the albedo's row 1 for all; rows of the emission for both."""
    color = {"by": "age", "gradient": "lime", "hot": ["red", "white"], "cold": "blue"}
    dark = {"by": "age", "cold": "black", "hot": "black", "gradient": "black"}
    look = {
        "emission": {"draw": "disc", "radius": 2.0, "emission": {"color": color}},
        "albedo": {"draw": "disc", "radius": 2.0, "blend": "alpha", "albedo": color, "emission": {"intensity": 0}},
        "both": {"draw": "disc", "radius": 2.0, "blend": "alpha", "albedo": color, "emission": {"color": dark}},
    }[where]
    for source, colour in enumerate(("red", "blue", "lime")):
        got = light(Look(**look), source=source, tags=("hot", "cold", None))
        assert got / got.max() == pytest.approx(linear(colour) / linear(colour).max(), abs=1e-4)


def test_black_bodies_take_planck_s_fall_as_far_as_asked():
    def at(planck, fraction):
        return light(
            {"draw": "disc", "radius": 2, "emission": {"blackbody": [[0, 2000], [1, 1000]], "planck": planck}},
            life=1 / fraction,
        )

    assert at(0, 0.5) / (4 * DISC) == pytest.approx(blackbody(1500)[0], abs=2e-3)
    ratio = planck_luminance(1500)[0] / planck_luminance(2000)[0]
    assert at(1, 0.5)[0] / at(0, 0.5)[0] == pytest.approx(ratio, rel=0.02)


def test_one_temperature_has_its_colour():
    got = light({"draw": "disc", "radius": 2, "emission": {"blackbody": 1500}})
    assert got / (4 * DISC) == pytest.approx(blackbody(1500)[0], abs=2e-3)


def test_chance_gives_each_particle_a_number_of_its_own():
    """Numbers of 0..1 have the mean 1/2, and what is 1 below 1/4 and 0 above it the mean 1/4."""
    n = 2000
    for curve, mean in (([[0, 0], [1, 1]], 0.5), ([[0, 1], [0.25, 1], [0.2501, 0], [1, 0]], 0.25)):
        look = {"draw": "disc", "radius": 2, "emission": {"intensity": {"by": "random", "curve": curve}}}
        assert light(look, position=[[0.2, 0.3, 0]] * n)[0] / (4 * DISC * n) == pytest.approx(
            mean, abs=4 * 0.43 / n**0.5
        )


def test_what_covers_takes_its_colour_by_its_own_quantity():
    """Beside a light of one colour: black at rest, as white as it covers at 1 m/s."""
    albedo = {"by": "speed", "range": "0..1", "gradient": ["black", "white"]}
    look = {"draw": "disc", "radius": 2, "blend": "alpha", "opacity": 50.0, "albedo": albedo}
    rest, half, fast = (light(look, velocity=[[v, 0, 0]])[1] for v in (0.0, 0.5, 1.0))
    assert rest == pytest.approx(0, abs=1e-6) and fast == pytest.approx(4 * DISC, rel=0.05)
    assert half / fast == pytest.approx(0.125, abs=0.005)  # OKLab's grey is a cube root


def test_strobes_blink_at_their_rate_for_their_part_of_the_time():
    look = Look(draw="disc", radius=2.0, emission={"strobe": "5..5", "duty": 0.25})
    on = np.array([light(look, film_time=t)[0] > 0 for t in np.arange(400) / 400])
    assert on.mean() == pytest.approx(0.25, abs=0.01)
    assert np.count_nonzero(np.diff(on.astype(int)) == 1) in (4, 5)


def test_fog_dims_by_depth():
    spec = CameraSpec(fog={"distance": 5, "start": 8})
    clear, foggy = (light({"draw": "disc", "radius": 1.0}, Camera.from_spec(s)) for s in (CameraSpec(), spec))
    assert foggy / clear == pytest.approx([np.exp(-0.4)] * 3, rel=1e-3)


def test_opacity_keeps_its_cross_section_while_a_sprite_grows():
    def cover(radius):
        look = Look(draw="disc", blend="alpha", radius=radius, opacity=0.02, reference=2.0)
        painter = Painter((200, 100), FLAT, {"a": look})
        return painter.paint(scene(0.0, a=state([[0, 0, 0]])), 0.0)[..., 3].sum(dtype=np.float64)

    assert cover(8.0) == pytest.approx(cover(2.0), rel=0.01)


def test_changing_any_number_or_colour_compiles_nothing():
    look = {"draw": "disc", "radius": 2.0, "emission": {"color": ["red", "blue"], "intensity": 0.5}}
    light(look)
    before = runtime.compilations()
    light(
        {
            **look,
            "radius": 0.7,
            "emission": {
                "color": {"by": "speed", "range": "0..3", "gradient": "aurora"},
                "blackbody": 3000,
                "strobe": 3,
            },
        }
    )
    light({"draw": "point"})
    light({"draw": "streak", "width": 1.0, "tail": 0.3}, Camera(position=(0, 0, 4), fov=20))
    light({**look, "blend": "alpha", "opacity": 0.3}, size=(64, 48))
    assert runtime.compilations() == before


@pytest.mark.parametrize(
    "bad, where",
    [
        ({"draw": "dot"}, "draw"),
        ({"radius": -1}, "radius"),
        ({"radius": 1, "pixels": 2}, "one of"),
        ({"draw": "streak", "blend": "alpha"}, "alpha"),
        ({"light": {}}, "light"),
        ({"emission": {"color": {"by": "speed", "gradient": ["red", "blue"]}}}, "range"),
        ({"emission": {"color": ["red", "bleu"]}}, "did you mean 'blue'"),
        ({"emission": {"colour": "red"}}, "colour"),
        ({"emission": {"intensity": float("nan")}}, "finite"),
        ({"trail": 0}, "half_life"),
        ({"light": {"direction": [0, 0, 0]}, "draw": "disc", "blend": "alpha"}, "direction"),
    ],
)
def test_bad_looks_are_refused_with_words(bad, where):
    with pytest.raises(ValidationError, match=where):
        Look.model_validate(bad)


def test_looks_survive_being_written_down():
    look = Look.model_validate({
        "draw": "streak", "width": "1/4", "tail": 0.2, "trail": 0.5,
        "emission": {"color": {"by": "age", "clean": ["white", "crimson"], "tail": [[0, "#fff"], [0.5, [1, 0.5, 0]]]}, "strobe": "8..14"},
    })  # fmt: skip
    assert Look.model_validate(look.model_dump(mode="json")) == look
    for draw in ("cloth", "surface", "body"):
        look = Look.model_validate({"draw": draw})
        assert Look.model_validate(look.model_dump(mode="json")) == look
