"""The golden pictures: what this version draws is what was drawn before."""

import imageio.v3 as imageio
import pytest

from gen_art.preset.shipped import preset_names
from tests.golden import BLOCK_LIMIT, MEAN_LIMIT, PICTURES, differences, draw, path


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_are_as_before(name):
    """If a change is meant: `make golden`, look at out/golden.png, commit the new pictures."""
    mean, block = differences(imageio.imread(path(name)), draw(name))
    assert mean <= MEAN_LIMIT and block <= BLOCK_LIMIT, f"{name} changed: run make golden and look at out/golden.png"


def test_there_are_enough_of_them():
    assert len(PICTURES) >= 16 and set(preset_names()) <= set(PICTURES)
    assert sum(path(name).stat().st_size for name in PICTURES) < 400_000


@pytest.mark.parametrize(
    "name, change",
    [
        ("fire", {"develop.exposure": 1.0}),
        ("smoke", {"camera.fov": 39}),
        ("course/bouncing_balls", {"systems.lead.look.radius": 0.055}),
        ("course/penning_trap", {"forces.magnetic_field": [0, 12.5, 0]}),
    ],
)
def test_a_changed_picture_is_noticed(name, change):
    mean, block = differences(imageio.imread(path(name)), draw(name, change))
    assert mean > MEAN_LIMIT or block > BLOCK_LIMIT
