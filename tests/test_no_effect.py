"""A part without effect gives one sentence; none of the shipped presets has such a part."""

import pytest

import gen_art as ga
from gen_art.preset.load import load_preset
from gen_art.preset.shipped import course_names, preset_names
from gen_art.simulation.no_effect import silent_parts, undrawn_systems

BASE = {
    "version": 1,
    "clock": {"duration": 1, "step": "1/60"},
    "systems": {"dots": {"emitters": {"jet": {"rate": 100}}, "look": {"draw": "point"}}},
}


@pytest.mark.parametrize("name", [*preset_names(), *course_names()])
def test_the_shipped_presets_have_none(name):
    preset = load_preset(name)
    assert silent_parts(preset) == undrawn_systems(preset) == []


CHANGES = {
    "an electric field": ({"forces.electric_field": [0, 1, 0]}, "systems.dots: electric_field has no effect, because the charge"),
    "a magnetic field": ({"forces.magnetic_field": [0, 1, 0]}, "systems.dots: magnetic_field has no effect"),
    "coulomb": ({"systems.dots.interactions": {"coulomb": {"softening": 0.1}}}, "systems.dots: coulomb has no effect"),
    "a medium": ({"medium": {"wind": [1, 0, 0]}}, "medium has no effect, because no force reads it"),
    "a medium of its own": ({"systems.dots.medium": {"density": 1.2}}, "systems.dots.medium has no effect"),
    "no look": ({"systems.dots.look": None}, "systems.dots has no look"),
    "no emitters": ({"systems.dots.emitters": {}}, "systems.dots has no emitters"),
    "a rate of 0": ({"systems.dots.emitters.jet.rate": 0}, "systems.dots.emitters.jet gives no birth within"),
    "a late start": ({"systems.dots.emitters.jet.start": 5}, "systems.dots.emitters.jet gives no birth within"),
    "a short life": ({"systems.dots.particle.lifetime": 0.001}, "a lifetime of 0.001 s is shorter than the step of"),
}  # fmt: skip


@pytest.mark.parametrize("label", CHANGES)
def test_each_part_without_effect_is_one_sentence(label):
    change, words = CHANGES[label]
    assert silent_parts(load_preset(BASE)) == []
    changed = load_preset(BASE, overrides=change)
    (line,) = [*silent_parts(changed), *undrawn_systems(changed)]
    assert words in line


def test_what_has_an_effect_gives_none():
    charged = {"forces.electric_field": [0, 1, 0], "systems.dots.particle.charge": "0..1"}
    blown = {"medium": {"wind": [1, 0, 0]}, "forces.drag": {"linear": 0.1}}
    fed = {
        "systems.dots.look": None,
        "systems.dots.particle.lifetime": 0.2,
        "systems.sparks": {"emitters": {"end": {"from": "dots.death", "count": 3}}, "look": {"draw": "point"}},
    }
    for change in (charged, blown, fed):
        assert silent_parts(load_preset(BASE, overrides=change)) == []


def test_a_force_that_systems_share_needs_charges_in_one_of_them():
    two = {
        "forces.electric_field": [0, 1, 0],
        "systems.ions": {"particle": {"charge": 1}, "emitters": {"jet": {"rate": 10}}, "look": {"draw": "point"}},
    }
    assert silent_parts(load_preset(BASE, overrides=two)) == []


def test_a_system_from_python():
    field = ga.forces.ElectricField((0.0, 1.0, 0.0))
    neutral = ga.ParticleSystem(position=[[0, 0, 0]], forces=[field])
    (line,) = silent_parts({"ions": neutral})
    assert line.startswith("systems.ions: electric_field has no effect")
    assert silent_parts(ga.ParticleSystem(position=[[0, 0, 0]], charge=1.0, forces=[field])) == []
