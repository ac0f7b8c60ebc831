"""What the command line prints of advice, and what it does with numbers that are no longer finite."""

import json

import av

# w dt = 2.1, above leapfrog's limit of 2: each step multiplies the oscillation by 1.88, past float32 after some 140 steps
EXPLODES = """
version: 1
clock: {duration: 10, fps: 20, step: 1/80}
forces: {spring: {stiffness: 28224}}
systems:
  balls:
    integrator: leapfrog
    emitters: {all: {count: 5, shape: {sphere: 0.5}}}
    look: {draw: point}
camera: {size: [64, 36]}
"""


def test_a_film_of_numbers_that_are_not_finite_stops_and_keeps_its_frames(gen_art, tmp_path):
    (tmp_path / "explodes.yaml").write_text(EXPLODES, encoding="utf-8")
    result = gen_art("render", "explodes.yaml", "-o", "a.mp4")
    assert result.status == 3
    lines = result.err.splitlines()
    assert lines[0].startswith("gen-art: warning: system 'balls': w dt = 2.1 of the lightest particle under spring")
    assert any(
        line.startswith("gen-art: system 'balls': ") and "left the finite numbers by step" in line for line in lines
    )
    assert any("frames are kept in" in line for line in lines) and "Traceback" not in result.err
    assert not (tmp_path / "a.mp4").exists()
    with av.open(str(tmp_path / "a.partial.mp4")) as film:
        assert 10 <= sum(1 for _ in film.decode(video=0)) <= 45


def test_a_still_of_them_is_not_written(gen_art, tmp_path):
    (tmp_path / "explodes.yaml").write_text(EXPLODES, encoding="utf-8")
    result = gen_art("still", "explodes.yaml", "--time", "9", "-o", "a.png")
    assert result.status == 3 and "left the finite numbers" in result.err and not (tmp_path / "a.png").exists()
    assert gen_art("still", "explodes.yaml", "--time", "0.05", "-o", "a.png").status == 0


def test_a_warning_among_json_lines_is_one(gen_art, tmp_path):
    (tmp_path / "explodes.yaml").write_text(EXPLODES, encoding="utf-8")
    result = gen_art("still", "explodes.yaml", "--time", "0.05", "-o", "a.png", "--progress", "json")
    events = [json.loads(line) for line in result.err.splitlines()]
    assert events[0]["event"] == "warning" and "w dt = 2.1" in events[0]["text"]


def test_validate_prints_what_has_no_effect(gen_art, tmp_path):
    (tmp_path / "idle.yaml").write_text(
        EXPLODES.replace("spring: {stiffness: 28224}", "magnetic_field: [0, 0, 1]"), encoding="utf-8"
    )
    result = gen_art("validate", "idle.yaml")
    assert result.status == 0 and "idle.yaml: warning: systems.balls: magnetic_field has no effect" in result.err
