"""The census before a run against the simulation itself."""

import pytest

from gen_art.preset.estimate import estimate
from gen_art.preset.load import load_preset
from gen_art.preset.reader import read_text
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
