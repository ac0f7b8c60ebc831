"""Values and files that no one writes by intention: each is refused by a sentence, before anything is made of it."""

import numpy as np
import pytest

from gen_art.errors import PresetError, UsageError
from gen_art.output.check import check_preset
from gen_art.preset.load import load_preset
from gen_art.preset.reader import read_text

from .piece import TEXT

PIECE = read_text(TEXT, "piece.yaml").plain()


def header(text: bytes) -> bytes:
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text


BROKEN = {
    "an archive": None,
    "cut off": b"\x93NUMPY\x01\x00\x10\x00{'descr': '<f8",
    "no end": header(b"((((((((((\n"),
    "a wrong shape": header(b"{'descr': '<f8', 'fortran_order': False, 'shape': -3, }\n"),
    "a shape of words": header(b"{'descr': '<f8', 'fortran_order': False, 'shape': ('a',), }\n"),
    "more than the file": header(b"{'descr': '<f8', 'fortran_order': False, 'shape': (999999, 99999, 9, 3), }\n"),
    "an unknown type": header(b"{'descr': [[], ], 'fortran_order': 3, 'shape': (3,) }\n"),
    "objects": header(b"{'descr': '|O', 'fortran_order': False, 'shape': (2, 2, 2, 3), }\n") + b"x" * 99,
    "no file of NumPy": b"PK\x03\x04",
    "nothing": b"",
}


@pytest.mark.parametrize("label", BROKEN)
@pytest.mark.parametrize(
    "law", [{"forces.vector_field": {"field": "a.npy"}}, {"colliders": {"sdf": {"function": "a.npy"}}}]
)
def test_broken_arrays(tmp_path, monkeypatch, label, law):
    monkeypatch.chdir(tmp_path)
    data = BROKEN[label]
    if data is None:
        np.savez("a.npz", a=np.ones(3))
        (tmp_path / "a.npz").rename("a.npy")
    else:
        (tmp_path / "a.npy").write_bytes(data)
    with pytest.raises(PresetError, match=r"a\.npy: is not a NumPy array"):
        load_preset(PIECE, overrides=law)


LAID = {"systems.drops.emitters": {"one": {"body": {"shape": {"sphere": 1}}}}}


def laid(kind: str, **parameters):
    return {"systems.drops.emitters": {"one": {kind: parameters}}}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"clock.duration": 1e308}, "inf frames, and may have 1,000,000 at most"),
        ({"clock.duration": 999_999}, "frames, and may have 1,000,000 at most: give a shorter duration"),
        ({"clock.fps": 1e308}, "frames, and may have"),
        ({"clock.preroll": 1e308}, "steps before frame 0"),
        ({"clock.step": 1e-10}, "steps a frame, and may have 1,000,000 at most: give a longer step"),
        ({"clock.duration": 30_000, "clock.step": "1/60000"}, "steps in all, and may have 1,000,000,000 at most"),
        ({"gallery.time": 1e30}, "1,000,000,000 at most are taken"),
        ({"forces.vector_field": {"field": "a\0.npy"}}, "characters, all of them printable"),
        ({"forces.vector_field": {"field": "x" * 5000}}, "at most 200 characters"),
        ({"systems": {**PIECE["systems"], "a\0b": {}}}, "not printable"),
        ({"systems.drops.particle.attributes": {"mass": 1}}, "every particle has that already"),
        ({"systems.drops.particle.attributes": {"a b": 1}}, "forces read it as p.name"),
        ({"systems.drops.particle.attributes": {f"a{k}": 1 for k in range(100)}}, "at most 64 attributes"),
        ({"systems.drops.interactions": {"springs": {"rest_length": "abc"}}}, "rest_length, without pairs, must be a finite"),
        ({"systems.drops.interactions": {"rigid": {"bodies": [{"a": 1}]}}}, "a body needs a shape"),
        ({"systems.drops.particle.radius": 1e19}, "radius: must be from 0 to 1e.18"),
        ({"systems.splash.look.emission.intensity": 1e19}, "intensity: must be from -1e.18 to 1e.18"),
        ({"camera.fov": 1e-30}, "fov: must be at least 1e-06"),
        (laid("body", shape={"box": [1e9, 0.2, 0.4]}), "sizes of a body must differ by a factor of 100,000 at most"),
        (laid("body", shape={"sphere": 1}, points=10_000_000), "points: must be from 8 to 1e.06"),
        (laid("body", shape={"sphere": 1}, grid=[100, 100, 100]), "a grid has at most 20,000 bodies, not 1,000,000"),
        (laid("body", shape={"sphere": 1}, points=100_000, grid=[10, 10, 1]), "an emitter lays at most 2,000,000"),
        (laid("cloth", columns=4096, rows=4096), "a cloth has at most 1,000,000 points"),
        ({"systems.splash.emitters.burst.count": 2**63}, "count: must be from 0 to 1e.14"),
        (laid("chain", count=10_000_000), "count: must be from 2 to 1e.06"),
    ],
    ids=lambda value: "" if isinstance(value, str) else next(iter(value)),
)  # fmt: skip
def test_values_that_nobody_means(change, words):
    with pytest.raises((PresetError, UsageError), match=words):
        check_preset(load_preset(PIECE, overrides=change))


@pytest.mark.parametrize(
    "text, words", [("0,1\n" * 100_002, "has more than 100,000 rows"), ("#" * 20_000_001, "larger than 20 MB")]
)
def test_long_tables(tmp_path, monkeypatch, text, words):
    """Refused by their size, before all of their numbers are made."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csv").write_text("time,thrust\n" + text)
    with pytest.raises(PresetError, match=words):
        load_preset(PIECE, overrides={"forces.aircraft": {"controls": "a.csv"}})
