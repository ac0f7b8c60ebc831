"""Ribbons: all links are drawn together, each with the width, the light and the age that its place on the path has."""

import numpy as np
import pytest

from gen_art.output.playback import Playback
from gen_art.preset import load_preset
from gen_art.renderer import ribbons

SIZE = 480, 160
SCENE = """
version: 1
clock: {duration: 4, fps: 10, step: 1/200}
systems:
  bodies:
    particle: {mass: 1, lifetime: 4}
    integrator: leapfrog
    forces: {%s}
    emitters: {a: {count: %d, shape: %s, velocity: {constant: [%g, 0, 0]}}}
    look: {draw: streak, width: 0.06, ribbon: {length: 2, points: %d, taper: %g, tail: %g}%s}
camera: {height: 1, position: [0, 0, 5], target: [0, 0, 0]}
"""
ABOUT_THE_MIDDLE = "{point: [-1.3, 0, 0]}"


def picture(
    tmp_path, forces="", count=1, shape=ABOUT_THE_MIDDLE, speed=1.25, taper=1.0, tail=1.0, more="", points=40
) -> np.ndarray:
    """(height, width) red light after 2.1 s, when the ribbon goes back over all of its 2 s."""
    file = tmp_path / "ribbon.yaml"
    file.write_text(SCENE % (forces, count, shape, speed, points, taper, tail, more))
    return np.array(Playback(load_preset(str(file)), SIZE, "f32", None).picture(420), np.float64)[..., 0]


def along(light: np.ndarray) -> np.ndarray:
    """Light of the columns between the newer and the older end of a straight ribbon, by the seconds since it was there."""
    newest = 240 + 160 * (-1.3 + 1.25 * 2.1)  # pixels; 200 a second
    return np.interp(newest - 200 * SECONDS, np.arange(SIZE[0]) + 0.5, light.sum(0))


SECONDS = np.linspace(0.1, 1.5, 29)


@pytest.mark.parametrize("points", [4, 40])
@pytest.mark.parametrize(("taper", "tail"), [(1.0, 0.2), (0.3, 1.0), (0.4, 0.6)])
def test_width_and_light_fall_evenly_along_a_straight_ribbon(tmp_path, taper, tail, points):
    """Light falls evenly, width in steps of a link, so that the middle of a link is right. Mutants: the factors of light and
    width exchanged, at the newer or the older end; those of the first link for all; a straight link as bright as its head."""
    whole, falling = (
        along(picture(tmp_path, taper=one, tail=other, points=points)) for one, other in ((1, 1), (taper, tail))
    )
    newer = np.maximum(0.1, (np.ceil((SECONDS - 0.1) * points / 2) - 1) * 2 / points + 0.1) / 2  # of each place's link
    width = 1 - (1 - taper) * (newer + 0.5 / points)
    expected = (1 - (1 - tail) * SECONDS / 2) * width
    inside = np.abs((SECONDS - 0.1) * points / 2 % 1 - 0.5) < 0.4 if points == 4 else SECONDS > 0
    # a link of 40 falls by up to 0.8 / 40 within itself
    assert np.abs(falling / whole - expected)[inside].max() < 0.02


def test_a_link_is_as_old_as_its_newer_end_was(tmp_path):
    """A link is 0.05 s long. Mutants: the age that the particle has now; that at the older end."""
    fading = ", emission: {intensity: {by: seconds, curve: [[0, 0], [4, 4]]}}"
    whole, young = along(picture(tmp_path)), along(picture(tmp_path, more=fading))
    later = young / whole - (2.1 - SECONDS)
    assert 0.015 < later.mean() < 0.035 and np.abs(later - 0.025).max() < 0.04


@pytest.mark.parametrize("forces", ["", "spring: {center: [0, 0.2, 0], stiffness: 4}"], ids=["straight", "curved"])
def test_links_drawn_together_are_those_drawn_one_by_one(tmp_path, monkeypatch, forces):
    """Up to the order in which light is added. Mutants: the factors of the first links for all; an owner off by one; the first particle for all."""
    shape = "{box: {min: [-1.3, -0.3, -0.2], max: [-1.0, 0.3, 0.2]}}"
    pictures = []
    for links in 1, 30, 10**6:
        monkeypatch.setattr(ribbons, "LINKS", links)
        pictures.append(picture(tmp_path, forces, 9, shape, taper=0.3, tail=0.2))
    assert (pictures[0].sum(1) > 0.01 * pictures[0].sum(1).max()).sum() > 60, "nine ribbons, each of ten rows"
    for other in pictures[1:]:
        assert np.abs(other - pictures[0]).max() < 1e-4 * pictures[0].max()


def test_a_ribbon_ends_with_its_particle_s_life(tmp_path):
    """Also while the storage still holds the particle. Mutant: links are drawn of all particles that it holds."""
    file = tmp_path / "short.yaml"
    text = SCENE % ("", 1, ABOUT_THE_MIDDLE, 1.25, 40, 1.0, 1.0, "")
    lights = []
    for lifetime in (2.2, 2.05):
        file.write_text(text.replace("lifetime: 4", f"lifetime: {lifetime}"))
        playback = Playback(load_preset(str(file)), SIZE, "f32", None)
        lights.append(float(playback.picture(420).max()))
        assert playback.sim.systems["bodies"].count == 1
    assert lights[0] > 0.1 and lights[1] == 0


def test_a_picture_alone_has_the_ribbons_that_it_has_in_a_film():
    """With a long shutter, whose first moments need older positions than its last.
    Mutants: positions are remembered from a moment too late; those of the shutter's first moments are forgotten."""
    preset = load_preset({
        "version": 1, "seed": 2, "clock": {"duration": 3, "fps": 10, "step": "1/100"},
        "forces": {"magnetic_field": {"field": [0, 0, 5]}},
        "systems": {"ions": {
            "particle": {"radius": 0.01, "mass": 1, "charge": 1, "lifetime": 100},
            "integrator": "boris",
            "emitters": {"m": {"count": 4, "shape": {"line": [[-1, 0, 0], [1, 0, 0]]}, "velocity": [0, 2, 0]}},
            "look": {"draw": "streak", "width": 0.02, "ribbon": {"length": 0.4, "points": 10}},
        }},
        "camera": {"position": [0, 0, 4], "target": [0, 0.3, 0], "shutter": 360, "subframes": 10},
    })  # fmt: skip
    pictures = []
    for steps in ([200], [150, 200], list(range(0, 210, 10))):
        playback = Playback(preset, (96, 54), "f32", None)
        pictures.append([picture.copy() for picture, _ in playback.pictures(steps)][-1])
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    assert pictures[0].max() > 0
