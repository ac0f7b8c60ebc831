"""Discs, ellipses, streaks and their pieces drawn by whole vectors have the bits of those drawn pixel by pixel.

Mutants that were tried, each of which fails a test here: a streak's longer axis taken for the other; its brightness from the
other end; a row that begins one pixel later; the last row left out; an ellipse without its slope, or with coverage above 1; a
row's second four pixels given the weights of the first; hidden sprites drawn whole, or left out where a part is hidden.
"""

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.preset.load import load_preset
from gen_art.preset.look import Look
from gen_art.renderer import framebuffer, vector_splat
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.sprite import DISC, ELLIPSE, PIECE, STREAK
from tests.render.particles import scene, state

SIZE = (203, 117)  # neither whole bins nor whole tiles
PIXELS = Camera(position=(0, 0, 10), height=117.0)  # one world unit is one pixel
LOOKS = {
    "discs": {"draw": "disc", "size": {"by": "random", "curve": [[0, 0.2], [1, 3]]}},
    "ellipses": {"draw": "disc", "radius": 2.0, "stretch": {"time": 0.4, "most": 6}},
    "streaks": {"draw": "streak", "width": 1.5, "tail": 0.3, "taper": 0.4},
}


def picture(looks: dict, speed: float) -> np.ndarray:
    systems = {}
    for k, name in enumerate(looks):
        rng = np.random.default_rng(k)
        systems[name] = state(rng.uniform((-110, -65, -3), (110, 65, 3), (700, 3)), rng.normal(0, speed, (700, 3)))
    painter = Painter(SIZE, PIXELS, {name: Look(**look) for name, look in looks.items()}, 1.0)
    return np.array(painter.paint(scene(1.0, **systems), 0.0))


@pytest.fixture
def kernels(monkeypatch):
    """The kinds of the kernels that are asked for."""
    asked, original = [], vector_splat.draw_kernel

    def noted(kinds, surfaces_hide):
        asked.append((kinds, surfaces_hide))
        return original(kinds, surfaces_hide)

    monkeypatch.setattr(vector_splat, "draw_kernel", noted)
    return asked


@pytest.mark.parametrize("speed", [0.3, 12.0], ids=["slow", "fast"])
@pytest.mark.parametrize(
    "names, blend",
    [
        (["streaks"], "add"),  # which cannot hide
        *((names, blend) for names in (["ellipses"], ["discs", "ellipses"], [*LOOKS]) for blend in ("add", "alpha")),
    ],
)
def test_vectors_have_the_bits_of_pixels(names, blend, speed, kernels, monkeypatch):
    looks = {name: dict(LOOKS[name]) for name in names}
    for name in set(looks) - {"streaks"}:
        looks[name] |= {"blend": blend} | ({"opacity": 1.5} if blend == "alpha" else {})
    got = picture(looks, speed)
    drawn = frozenset().union(*(kinds for kinds, _ in kernels))
    assert ("streaks" in looks) == (STREAK in drawn) and ("ellipses" in looks) == (ELLIPSE in drawn)
    monkeypatch.setattr(framebuffer, "VECTOR_KINDS", frozenset())
    expected = picture(looks, speed)
    assert expected[..., :3].max() > 0.1
    assert np.array_equal(got, expected)


@pytest.mark.parametrize("width, smoke", [(0.6, False), (3.0, False), (12.0, False), (3.0, True)])
def test_pieces_of_curved_streaks_have_the_bits_of_pixels(width, smoke, kernels, monkeypatch):
    """Mutants: a piece's foot without the slope, or with that of the other direction; a row's weights from its lower edge."""
    rng = np.random.default_rng(1)
    middle, radius = rng.uniform((-110, -65), (110, 65), (300, 2)), rng.uniform(8, 40, 300)
    phase, rate = rng.uniform(0, 7, 300), rng.uniform(1.5, 4.0, 300) * rng.choice([-1, 1], 300)

    def moment(t):
        c, s = np.cos(phase + rate * t), np.sin(phase + rate * t)
        place = np.column_stack([middle[:, 0] + radius * c, middle[:, 1] + radius * s, 0 * c])
        return state(place, np.column_stack([-radius * rate * s, radius * rate * c, 0 * c]))

    looks = {"a": Look(draw="streak", width=width, tail=0.3, taper=0.4)}
    if smoke:  # which the streaks lie before and behind
        looks["b"] = Look(draw="disc", radius=4.0, blend="alpha", opacity=0.8)
    puffs = {"b": state(rng.uniform((-110, -65, -3), (110, 65, 3), (200, 3)))} if smoke else {}

    def paint():
        painter = Painter(SIZE, PIXELS, looks, 1.0)
        for k in range(6):
            painter.paths["a"].remember(moment(k / 6), k / 6)
        return np.array(painter.paint(scene(1.0, a=moment(1.0), **puffs), 0.0))

    got = paint()
    assert any(PIECE in kinds and (DISC in kinds) == smoke for kinds, _ in kernels)
    monkeypatch.setattr(framebuffer, "VECTOR_KINDS", frozenset())
    expected = paint()
    assert expected[..., :3].max() > 0.01
    assert np.array_equal(got, expected)


def test_what_a_solid_hides_of_a_sprite_is_what_it_hides_pixel_by_pixel(kernels, monkeypatch):
    """Each pixel differs by the rounding of two ways to blend some 50 sprites by shares."""
    particles = {"particle": {"radius": 0.05, "mass": 1, "lifetime": 100}, "inherit_colliders": False}
    cloud = {"count": 400, "shape": {"sphere": 0.8}, "velocity": {"sphere": 2}}
    looks = {
        "discs": {"draw": "disc", "radius": 0.1, "blend": "alpha", "opacity": 0.6},
        "ellipses": {"draw": "disc", "radius": 0.08, "stretch": {"time": 0.2, "most": 4}},
        "streaks": {"draw": "streak", "width": 0.05},
        "curved": {"draw": "streak", "width": 0.05},
    }
    forces = {"curved": {"forces": {"magnetic_field": [0, 0, 60]}, "integrator": "boris"}}
    particles["particle"]["charge"] = 1
    preset = load_preset(
        {
            "version": 1, "seed": 2, "clock": {"duration": 1, "fps": 10, "step": "1/100"},
            "light": {"direction": [0, -1, -0.5]},
            "colliders": {"sphere": {"center": [0, 0, 0], "radius": 0.5, "look": {"albedo": "#808080"}}},
            "systems": {
                name: {**particles, "emitters": {"e": cloud}, "look": look, **forces.get(name, {})} for name, look in looks.items()
            },
            "camera": {"position": [0, 0, 4], "target": [0, 0, 0], "fov": 30, "size": list(SIZE), "shutter": 120},
        }
    )  # fmt: skip

    def paint():
        return np.array(next(Playback(preset, SIZE, "f32", None).pictures([10]))[0])

    got = paint()
    assert any(hide and {ELLIPSE, STREAK, PIECE} <= kinds for kinds, hide in kernels)
    monkeypatch.setattr(framebuffer, "VECTOR_KINDS", frozenset())
    expected = paint()
    assert got == pytest.approx(expected, rel=50 * 2**-22, abs=1e-6)
    monkeypatch.setattr(framebuffer.tiled_splat, "draw_kernel", lambda *_: lambda *_: None)
    assert np.abs(expected - paint()).max() > 0.05, "the sprites are seen"
