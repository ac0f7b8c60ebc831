"""A system may be drawn by several looks, each of which may draw the particles of some emitters alone."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.output.playback import Playback
from gen_art.preset.estimate import estimate
from gen_art.preset.load import load_preset
from gen_art.preset.schema import Preset

SIZE = (160, 90)


def preset(look=None, **looks) -> Preset:
    """A cloud of 300 particles with the tag `a` and 200 with the tag `b`, drawn by these looks."""
    ball = {"sphere": 1}
    system = {
        "emitters": {
            "first": {"count": 300, "tag": "a", "shape": ball, "velocity": ball},
            "second": {"count": 200, "tag": "b", "shape": ball, "velocity": ball},
        },
        "looks": looks,
    }
    return load_preset({
        "version": 1,
        "clock": {"duration": 1, "fps": 10, "step": 0.02},
        "camera": {"position": [0, 0, 4]},
        "systems": {"cloud": {**system, **({} if look is None else {"look": look})}},
    })  # fmt: skip


def picture(look=None, **looks) -> np.ndarray:
    """The light of the sixth frame."""
    return np.array(Playback(preset(look, **looks), SIZE, "f32", None).picture(25), np.float64)


RED, BLUE = {"emission": "red"}, {"draw": "disc", "radius": 0.05, "emission": "blue"}


def test_looks_with_tags_draw_each_particle_once():
    both = picture({**RED, "tag": "a"}, others={**RED, "tag": ["b"]})
    assert both.sum() > 0
    np.testing.assert_allclose(both, picture(RED), rtol=1e-6, atol=1e-9)


def test_a_look_with_a_tag_leaves_out_the_others():
    a, b = picture({**RED, "tag": "a"}), picture({**RED, "tag": "b"})
    assert 1.2 < a.sum() / b.sum() < 1.9  # 300 beside 200
    np.testing.assert_allclose(a + b, picture(RED), rtol=1e-6, atol=1e-9)


def test_further_looks_draw_the_particles_once_more():
    np.testing.assert_allclose(
        picture(RED, again=BLUE), picture(RED) + picture(BLUE), rtol=1e-5, atol=1e-7
    )  # float32 sums in another order


def test_a_system_without_a_look_may_have_further_ones():
    np.testing.assert_array_equal(picture(only=BLUE), picture(BLUE))


@pytest.mark.parametrize(
    "more",
    [
        {"trail": 0.2},
        {"draw": "streak", "width": 0.02, "length": 0.1},
        {"draw": "streak", "width": 0.02, "ribbon": 0.2},
        {"emission": {"intensity": {"by": "acceleration", "range": "0..1"}}},
        {"draw": "disc", "blend": "alpha", "radius": 0.05, "opacity": 1.0},
    ],
)
def test_what_needs_the_past_or_depth_works_in_a_further_look(more):
    np.testing.assert_array_equal(picture(thin={**RED, **more, "tag": "b"}), picture({**RED, **more, "tag": "b"}))


def test_render_frame_draws_further_looks():
    given = preset(RED, again={**BLUE, "tag": "b"})
    sim = ga.Simulation(given)
    sim.step(25)
    light = ga.render_frame(sim, size=SIZE)
    assert light[..., 2].sum() > 0
    assert light[..., 0].sum() > 0


def test_memory_counts_the_particles_that_a_look_draws():
    path = {**RED, "draw": "streak", "width": 0.02, "ribbon": 0.2}
    one = estimate(preset(RED)).working
    few = estimate(preset(RED, again={**path, "tag": "b"})).working
    all_again = estimate(preset(RED, again=path)).working
    assert one < few < all_again


@pytest.mark.parametrize(
    "looks, words",
    [
        ({"x": {"tag": "c"}}, "no emitter of 'cloud' has the tag 'c'"),
        ({"x.y": {}}, "may not contain a dot"),
        ({"x": {"draw": "thread", "tag": "a"}}, "leave out `tag`"),
        ({"x": {"emission": {"color": {"c": ["red", "blue"]}}}}, "neither a key nor a tag"),
        ({"x": {"side": "sideways"}}, "systems.cloud.looks.x.side"),
    ],
)
def test_wrong_looks_are_named_with_their_place(looks, words):
    with pytest.raises(PresetError, match=None) as caught:
        preset(RED, **looks)
    assert words in str(caught.value)
