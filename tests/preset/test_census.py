"""The census before a run against the simulation itself."""

import pytest

from gen_art.preset.estimate import estimate
from gen_art.preset.load import load_preset
from gen_art.preset.reader import read_text
from gen_art.renderer.surfaces.light_parts import MIRROR_PARTS, OWN_PARTS
from gen_art.renderer.surfaces.pixel_rays import SUBPIXELS
from gen_art.simulation import Simulation

from .piece import TEXT


def test_the_estimate_agrees_with_the_simulation():
    piece = load_preset(read_text(TEXT, "piece.yaml").plain(), overrides={"systems.drops.emitters.nozzle.rate": 1000})
    expected, sim = estimate(piece), Simulation(piece)
    peak = dict.fromkeys(piece.systems, 0)
    for _ in range(30):
        sim.step(round(piece.clock.simulated / piece.clock.step / 30))
        for name in peak:
            peak[name] = max(peak[name], sim[name].count)
    assert peak["drops"] > 1000
    for name in peak:
        assert expected.peak[name] == pytest.approx(peak[name], rel=0.1)


def test_an_estimate_is_of_the_time_it_is_asked_for():
    """Also where one of the same preset was made just before."""
    piece = load_preset(read_text(TEXT, "piece.yaml").plain(), overrides={"systems.drops.emitters.nozzle.rate": 1000})
    whole, time = estimate(piece), piece.clock.simulated
    half = estimate(piece, until=0.5 * time)
    assert half.born["drops"] == pytest.approx(0.5 * whole.born["drops"], rel=0.01)
    assert estimate(piece) == whole == estimate(load_preset(piece, overrides={"seed": 2}))


def test_the_estimate_counts_what_surfaces_need():
    """Of each pixel: the depths of surfaces, 4 float32, and their light in parts, where the camera rests and none shows others; a mirror's picture
    and its pyramid, 4 float32 times 1 + 1/4 + 1/16 + ..., how it is read, and the depths and parts of what it shows; with a lens the
    depths and the framebuffer once more, of at least 16 bytes each. Of two systems, only the one that glows."""
    depths, parts, read = 4 * SUBPIXELS, 4 * OWN_PARTS, 4 * MIRROR_PARTS

    def pixel(**keys):
        basis = {
            "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/60"},
            "systems": {"dot": {"emitters": {"one": {"count": 1}}, "look": {"draw": "point"}}}, "camera": {"fov": 30},
        }  # fmt: skip
        return estimate(load_preset({**basis, **keys})).pixel

    bare, ground = pixel(), pixel(ground="white")
    assert ground - bare == depths + parts
    mirrored = 16 * 4 / 3 + read + depths + parts
    assert pixel(ground={"mirror": True}) - ground == pytest.approx(mirrored, rel=0.02)
    assert pixel(camera={"lens": 0.1}) == bare and pixel(ground="white", camera={"lens": 0.1}) - ground >= 32
    assert pixel(ground="white", camera={"supersample": 2}) - pixel(camera={"supersample": 2}) == 4 * (depths + parts)
    collider = {"sphere": {"look": "white"}}
    assert pixel(colliders=collider) == ground and pixel(colliders={"sphere": {}}) == bare
    assert pixel(colliders={"sphere": {"look": "white"}}, ground="white") == ground
    smooth = {"sphere": {"look": {"roughness": 0.1}}}  # it shows the ground: light is not kept in parts
    assert pixel(colliders=smooth, ground="white") == ground - parts
    # a mirror is read from what it shows; a camera that moves, no light that flickers, leaves parts out
    assert pixel(ground={"mirror": True, "roughness": 0.1}) == pixel(ground={"mirror": True})
    assert pixel(colliders=collider, ground={"mirror": True, "roughness": 0.1}) == pixel(ground={"mirror": True})
    assert pixel(ground="white", camera={"orbit": 3}) == ground - parts
    wavy = pixel(ground={"mirror": True, "waves": {"slope": 0.1, "length": "0.4..7"}})
    assert wavy == pixel(ground={"mirror": True}) + 12 - read - 2 * parts  # 12 for their slopes
    assert pixel(ground="white", light={"direction": [0, -1, 0], "glow": ["dot"]}) == ground


def test_a_census_of_generations():
    """Each spark's death makes two: 1, 2, 4, 8 in turn, and each spark leaves a trail whose motes live for two steps."""
    basis = {
        "version": 1, "clock": {"duration": 3.5, "fps": 30, "step": "1/60"},
        "systems": {
            "sparks": {
                "particle": {"lifetime": 1.0},
                "emitters": {"first": {"count": 1}, "next": {"from": "sparks.death", "count": 2}},
                "look": {"draw": "point"},
            },
            "trail": {
                "particle": {"lifetime": 1 / 30}, "look": {"draw": "point"},
                "emitters": {"tail": {"from": "sparks.path", "rate": 100}},
            },
        },
    }  # fmt: skip
    expected = estimate(load_preset(basis))
    assert expected.born["sparks"] == pytest.approx(1 + 2 + 4 + 8, rel=1e-9)
    assert expected.peak["sparks"] == pytest.approx(
        4 + 8, rel=1e-9
    )  # the dead have their places until the slice has ended
    assert expected.born["trail"] == pytest.approx(100 * (1 + 2 + 4 + 0.5 * 8), rel=0.05)
    assert expected.peak["trail"] == pytest.approx(100 / 30 * 8, rel=0.1)
    endless = load_preset(
        basis, overrides={"systems.sparks.emitters.next.count": 10**9, "systems.sparks.particle.lifetime": 0.006}
    )
    assert not estimate(endless).memory < 1e300


def test_a_preset_without_emitters_holds_nothing():
    nothing = load_preset({"version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/60"}, "systems": {"a": {}}})
    assert estimate(nothing).particles == 0 and estimate(nothing).born == {"a": 0}
