"""The player of the studio: which change needs what, and pictures that are those of a film of the preset as it is now."""

import numpy as np
import pytest

from gen_art.errors import DivergedError, PresetError
from gen_art.output.playback import Playback
from gen_art.output.player import Player, Superseded
from gen_art.preset.load import load_preset
from gen_art.preset.reader import read_text
from tests.studio.piece import TEXT, THROUGH_TARGET, TRAILED

SIZE = (96, 54)


def preset(text=TEXT, **changes):
    return load_preset(
        read_text(text, "piece").plain(), overrides={key.replace("__", "."): value for key, value in changes.items()}
    )


def frame_of(piece, frame: int) -> np.ndarray:
    """The frame as a film has it: all frames from the first on are played."""
    playback = Playback(piece, SIZE, "f32", None)
    clock = piece.clock
    for k in range(frame + 1):
        linear, exposure = next(playback.pictures([clock.preroll_steps + k * clock.steps_per_frame]))
    return playback.developed(linear, exposure, frame)[..., :3]


@pytest.fixture
def player():
    player = Player()
    yield player
    player.close()


@pytest.mark.parametrize(
    ("changes", "need"),
    [
        ({"develop__exposure": 2.0}, "develop"),
        ({"develop__tone": "aces"}, "develop"),
        ({"develop__auto_exposure": 0.3}, "draw"),
        ({"camera__fov": 30}, "draw"),
        ({"knobs__glow": 5}, "draw"),
        ({"systems__drops__look__draw": "point"}, "draw"),
        ({"sky": {"color": "#102040"}}, "draw"),
        ({"clock__duration": 1}, "draw"),
        ({"knobs__push": 11}, "motion"),
        ({"seed": 6}, "motion"),
        ({"clock__step": "1/240"}, "motion"),
        ({"forces__drag": {"linear": 0.1}}, "motion"),
        ({"systems__drops__emitters__nozzle__rate": 500}, "motion"),
        ({}, "nothing"),
    ],
)
def test_what_a_change_needs(player, changes, need):
    player.change(preset())
    player.show(20, SIZE)
    after = preset(**changes)
    assert player.change(after) == need
    list(player.settle(20, SIZE))
    assert np.array_equal(player.show(20, SIZE).picture, frame_of(after, 20))


@pytest.mark.parametrize("text", [TEXT, TRAILED])
def test_any_order_of_frames_shows_the_film(player, text, monkeypatch):
    monkeypatch.setattr("gen_art.output.player.SNAPSHOT_PAUSE", 0.0)  # a snapshot at each turn
    piece = preset(text)
    player.change(piece)
    wanted = {k: frame_of(piece, k) for k in (0, 3, 4, 11, 30, 59)}
    for k in (11, 3, 4, 59, 30, 0, 59, 3):
        found = player.show(k, SIZE).picture.astype(int)
        # of a trail, light from more than 16 half-lives before is left out: 1.5e-5 of it, which may move a rounding
        assert np.abs(found - wanted[k]).max() <= (0 if text is TEXT else 1), k
    assert np.array_equal(player.show(999, SIZE).picture, player.show(59, SIZE).picture), "the last frame"


def test_another_size_is_the_same_moment(player):
    player.change(preset())
    player.show(20, SIZE)
    small = player.show(20, (48, 27)).picture
    assert small.shape == (27, 48, 3)
    assert np.array_equal(player.show(20, SIZE).picture, frame_of(preset(), 20))


def test_particles_go_on_while_a_knob_of_the_motion_turns(player):
    player.change(preset())
    before = player.show(20, SIZE)
    after = preset(knobs__push=13)
    assert before.is_exact and player.change(after) == "motion"
    carried = player.show(20, SIZE, with_history=False)
    assert not carried.is_exact and np.array_equal(carried.picture, before.picture), "the same particles"
    later = player.show(30, SIZE, with_history=False)
    assert not later.is_exact and not np.array_equal(later.picture, frame_of(preset(), 30)), "new drops are faster"
    parts = list(player.settle(30, SIZE))
    assert parts == sorted(parts) and parts[-1] == 1.0 and player.is_exact
    assert np.array_equal(player.show(30, SIZE).picture, frame_of(after, 30))


def test_births_go_on_by_the_new_rate_without_a_burst(player):
    player.change(preset())
    count = player.show(20, SIZE).particles
    player.change(preset(systems__drops__emitters__nozzle__rate=3000))
    assert player.show(20, SIZE, with_history=False).particles == count
    born = player.show(21, SIZE, with_history=False).particles - count
    assert 80 <= born <= 100, "3000 a second for a thirtieth of one, less those that die"


def test_a_force_that_is_added_or_a_ledger_entry_that_changes_is_no_bug(player):
    """With a ledger, of a look that goes by joules, other forces or entries start the motion anew; without one it goes on."""
    player.change(preset())
    player.show(20, SIZE)
    player.change(preset(forces__drag={"linear": 0.1}))
    assert not player.is_exact, "carried on"
    by = {"color": {"by": {"dissipated": "drag"}, "range": "0..0.001", "gradient": ["white", "blue"]}}
    booked = {"systems__drops__look__emission": by, "forces__drag": {"linear": 0.1}}
    for changes in (booked, {**booked, "forces__damping": 0.2}):
        piece = preset(**changes)
        assert player.change(piece) == "motion"
        list(player.settle(20, SIZE))
        assert np.array_equal(player.show(20, SIZE).picture, frame_of(piece, 20))


def test_systems_of_other_names_start_anew(player):
    player.change(preset())
    player.show(20, SIZE)
    data = preset().resolved()
    data["systems"]["sparks"] = data["systems"].pop("drops")
    renamed = load_preset(data)
    assert player.change(renamed) == "motion" and player.is_exact
    assert np.array_equal(player.show(20, SIZE).picture, frame_of(renamed, 20))


def test_a_preset_of_which_no_picture_can_be_made_leaves_the_one_before(player):
    player.change(preset())
    before = player.show(5, SIZE).picture
    with pytest.raises(PresetError, match="camera"):
        player.change(preset(THROUGH_TARGET))
    assert np.array_equal(player.show(5, SIZE).picture, before)


def test_what_is_not_wanted_any_more_is_left(monkeypatch):
    monkeypatch.setattr("gen_art.output.player.SLICE", 0.0)
    asked = []

    def superseded():
        asked.append(True)
        return len(asked) > 1

    player = Player(superseded=superseded)
    player.change(preset(clock__preroll=20))
    with pytest.raises(Superseded):
        player.show(0, SIZE)
    assert 0 < player.sim.steps_done < 2400, "what was computed is kept"
    player.close()


def test_snapshots_are_thinned(player, monkeypatch):
    monkeypatch.setattr("gen_art.output.player.SNAPSHOT_PAUSE", 0.0)
    monkeypatch.setattr("gen_art.output.player.WRITTEN", 0.0)
    monkeypatch.setattr("gen_art.output.player.MOST_SNAPSHOTS", 400_000)
    player.change(preset())
    for k in range(0, 60, 2):
        player.show(k, SIZE)
    files = list(player._snapshots.values())
    assert 2 < len(files) < 30 and sum(path.stat().st_size for path in files) < 400_000
    assert min(player._snapshots) < 80 and max(player._snapshots) > 250, "from the first to the last"


def test_surfaces_that_rest_keep_their_light_and_others_are_drawn_anew(player):
    """A floor and a ball: after a change of a look, of the floor, of the lamp and of the camera the picture is the film's."""
    standing = TEXT.replace("forces:\n", "ground: {albedo: '#808080'}\nlight: {direction: [-1, -2, -1]}\nforces:\n", 1)
    for changes in (
        {}, {"knobs__glow": 5}, {"ground__albedo": "#c04020"}, {"ground__height": 0.5}, {"light__intensity": 2}, {"camera__fov": 50},
        {"knobs__push": 12}, {"shadows": False},
    ):  # fmt: skip
        piece = preset(standing, **changes)
        player.change(piece)
        list(player.settle(20, SIZE))
        assert np.array_equal(player.show(20, SIZE).picture, frame_of(piece, 20)), changes


def test_colliders_of_the_preset_stand_there_once_after_a_change_of_the_camera(player):
    floor = TEXT.replace("forces:\n", "colliders:\n  plane: {look: {albedo: '#808080', mirror: true}}\nforces:\n", 1)
    for changes in ({}, {"camera__fov": 50}, {"knobs__glow": 5}):
        piece = preset(floor, **changes)
        player.change(piece)
        assert np.array_equal(player.show(20, SIZE).picture, frame_of(piece, 20)), changes


def test_a_framed_camera_is_fitted_anew(player):
    framed = TEXT.replace("fov: 40,", "fov: 40, frame: auto,")
    for changes in ({}, {"camera__fov": 20}, {"knobs__push": 12}, {"systems__drops__look__draw": "point"}):
        piece = preset(framed, **changes)
        player.change(piece)
        player.show(20, SIZE, with_history=False)
        list(player.settle(20, SIZE))
        assert np.array_equal(player.show(20, SIZE).picture, frame_of(preset(framed, **changes), 20)), changes
        assert piece.fits == {}, "the caller's preset stays as it was"


def test_a_jump_forwards_can_be_left_and_what_follows_is_exact(monkeypatch):
    monkeypatch.setattr("gen_art.output.player.SLICE", 0.0)
    wanted = [False]
    player = Player(superseded=lambda: wanted[0])
    player.change(preset())
    player.show(3, SIZE)
    player.change(preset(knobs__push=12))
    player.show(4, SIZE, with_history=False)
    wanted[0] = True
    with pytest.raises(Superseded):
        player.show(2, SIZE)  # back: the motion starts anew
    wanted[0] = False
    found = player.show(40, SIZE)
    assert found.is_exact and np.array_equal(found.picture, frame_of(preset(knobs__push=12), 40))
    player.close()


def test_particles_without_end_are_left_behind(player):
    """A value with which the numbers leave the finite ones, and then one with which they do not."""
    player.change(preset())
    player.show(5, SIZE)
    player.change(preset(forces__gravity=[0, -3e38, 0]))
    with pytest.raises(DivergedError):
        player.show(59, SIZE, with_history=False)
    player.change(preset())
    assert np.array_equal(player.show(20, SIZE).picture, frame_of(preset(), 20))
