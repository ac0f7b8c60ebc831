"""Ropes laid of strands: where the strands lie, how they wind, and that the thread's bends do not turn them."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.interactions.links import capsules_along
from gen_art.preset.look import Look
from gen_art.renderer.surfaces.strands import LAY, _frames, lay_strands

R = 0.02


def rods(nodes):
    nodes = np.asarray(nodes, float)
    pairs = np.stack([np.arange(len(nodes) - 1), np.arange(1, len(nodes))], axis=1)
    return capsules_along(nodes.T, np.zeros((3, len(nodes))), pairs)


def strands(found, number):
    """(number, rods + 1, 3): the nodes of each strand of one rope."""
    half = found.half[:, 1:2] * found.axes[:, 1]
    starts, ends = ((found.center + s * half).reshape(number, -1, 3) for s in (-1, 1))
    assert starts[:, 1:] == pytest.approx(ends[:, :-1], abs=1e-12)
    return np.concatenate([starts, ends[:, -1:]], axis=1)


@pytest.mark.parametrize("number", [2, 3, 4])
def test_strands_touch_each_other_and_the_ropes_radius(number):
    """Mutants: the share without the 1 in 1 + sin; strands in the axis."""
    nodes = np.arange(30)[:, None] * np.array([0.003, 0.004, 0.0])
    found = lay_strands(rods(nodes), np.full(29, R), number)
    places, thick = strands(found, number), found.radius[0]
    assert np.linalg.norm(places - nodes, axis=2) + thick == pytest.approx(R, rel=1e-9)
    assert np.linalg.norm(places - np.roll(places, 1, axis=0), axis=2) == pytest.approx(2 * thick, rel=1e-9)
    assert found.particle.tolist() == list(range(29)) * number


def test_a_strand_goes_once_round_in_the_right_hands_sense():
    """Mutants: the left hand's sense; a lay of radii instead of diameters."""
    nodes = np.linspace(0, LAY * 2 * R, 41)[:, None] * np.array([0.0, 0.0, 1.0])
    places = strands(lay_strands(rods(nodes), np.full(40, R), 3), 3)
    angle = np.unwrap(np.arctan2(places[:, :, 1], places[:, :, 0]), axis=1)
    assert angle - angle[:, :1] == pytest.approx(np.broadcast_to(np.linspace(0, 2 * np.pi, 41), (3, 41)), abs=1e-9)


def test_a_bend_does_not_turn_strands():
    """Along half a circle a strand stands where it would in a straight rope of the same length. Mutant: a new direction in each rod."""
    turn = np.linspace(0, np.pi, 201)
    bent = np.stack([np.cos(turn), 0 * turn, np.sin(turn)], axis=1)
    found = lay_strands(rods(bent), np.full(200, R), 3)
    places, way = strands(found, 3), R - found.radius[0]
    # the first direction across is y, the bend's normal, and so the second one, across the first and the way, points inwards
    length = np.arange(201) * 2 * np.sin(turn[1] / 2)
    angle = 2 * np.pi * (length / (LAY * 2 * R) + np.arange(3)[:, None] / 3)
    assert places[:, :, 1] == pytest.approx(way * np.cos(angle), abs=1e-9)
    # the first and the last direction are those of chords, half a step off
    tolerance = way * (turn[1] / 2) ** 2
    assert np.linalg.norm(places[:, :, ::2], axis=2) == pytest.approx(1 - way * np.sin(angle), abs=tolerance)


def test_the_direction_across_does_not_turn_about_the_thread():
    """Along a helix, where two directions that are each carried on by projection differ by less than the square of the thread's turn.

    a' = a - t (t.a), so a'.b = -(t.a) (t.b), and (t.a)^2 + (t.b)^2 is the squared sine of the turn. Mutant: the first direction
    projected at each node, which turns about the thread.
    """
    turn = np.linspace(0, 4 * np.pi, 401)
    nodes = np.stack([np.cos(turn), np.sin(turn), turn], axis=1)
    across, beside = _frames(nodes, np.array([0.0, 0.0, 1.0]))
    along = np.cross(across, beside)
    sine = np.linalg.norm(np.cross(along[1:], along[:-1]), axis=1).max()
    assert np.abs((across[1:] * beside[:-1]).sum(axis=1)).max() < sine**2
    assert (across * along).sum(axis=1) == pytest.approx(np.zeros(401), abs=1e-12)


def test_ropes_that_do_not_meet_are_laid_each_by_itself():
    """Mutant: rods that do not touch are one rope."""
    first = np.arange(11)[:, None] * np.array([0.01, 0.0, 0.0])
    second = first + [0.0, 1.0, 0.0]
    pairs = np.stack([np.arange(21), np.arange(1, 22)], axis=1)[np.arange(21) != 10]
    both = capsules_along(np.concatenate([first, second]).T, np.zeros((3, 22)), pairs)
    found, alone = lay_strands(both, np.full(20, R), 3), lay_strands(rods(first), np.full(10, R), 3)
    assert found.center[:30] == pytest.approx(alone.center)
    assert found.center[30:] - [0.0, 1.0, 0.0] == pytest.approx(alone.center)
    assert len(lay_strands(rods(first[:1]), np.zeros(0), 3).center) == 0


def test_strands_need_a_thread():
    with pytest.raises(ga.PresetError, match="`strands` needs draw: thread"):
        ga.load_preset({"version": 1, "systems": {"a": {"look": {"draw": "disc", "strands": 3}}}})
    assert Look(draw="thread", strands=2).strands == 2
