"""`gen-art audit` from the command line."""

import json

import pytest


def test_the_command_prints_both_forms(gen_art):
    words = gen_art("audit", "charged", "--set", "clock.preroll=0", "--time", "0.1")
    assert words.status == 0 and "ledger at dt" in words.out and "Everything closes." in words.out
    data = json.loads(gen_art("audit", "charged", "--set", "clock.preroll=0", "--time", "0.1", "--json").out)
    assert data["problems"] == [] and data["positions"]["ions"]["order"] == pytest.approx(2, abs=0.2)
    assert gen_art("audit", "charged", "--time", "77").status == 2
    assert gen_art("audit", "chargd").status in (2, 3)
