"""YAML to plain data: positions, and everything that is refused while reading."""

import sys
from contextlib import contextmanager

import pytest

from gen_art.errors import OutputError, PresetError
from gen_art.preset.reader import MAX_BYTES, MAX_DEPTH, read_bytes, read_file, read_text, read_value

BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join(['*' + chr(97 + k)] * 10)}]\n" for k in range(9)
)
HOSTILE = {
    "alias bomb": (BOMB, "10,000 values"),
    "100,000 brackets": ("[" * 100_000, "levels deep"),
    "100,000 open mappings": ("a: {a: " + "{a: " * 100_000, "levels deep"),
    "100,000 dashes": ("- " * 100_000, "levels deep"),
    "an indented staircase": ("\n".join(" " * k + "a:" for k in range(900)), "levels deep"),
    "an alias inside itself": ("a: &a [*a]", "inside its own anchor"),
    "an alias without anchor": ("a: *b", "no anchor"),
    "many values": ("a: [" + "1, " * 100_000 + "1]", "10,000 values"),
    "two documents": ("a: 1\n---\nb: 2\n", "one document"),
    "nothing": ("", "is empty"),
    "a comment": ("# hello\n", "is empty"),
    "a word": ("hello", "mapping of keys"),
    "a list": ("- 1\n", "mapping of keys"),
    "a tab": ("a:\n\tb: 1\n", "not YAML"),
    "an open bracket": ("a: [1, 2\n", "not YAML"),
    "a control character": ("a: \x07\n", "character"),
    "a list as a key": ("? [a]\n: b\n", "a key must be a word"),
}


@contextmanager
def _calls():
    """Counts the calls of functions, in a list of one number: a measure of work that is the same on every machine."""
    count, before = [0], sys.getprofile()

    def note(_frame, event, _argument):
        count[0] += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        yield count
    finally:
        sys.setprofile(before)


@pytest.mark.parametrize("label", HOSTILE)
def test_hostile_text_is_refused_at_once(label):
    text, words = HOSTILE[label]
    with _calls() as calls, pytest.raises(PresetError, match=words) as caught:
        read_text(text, "bad.yaml")
    assert calls[0] < 10_000_000  # what an alias bomb writes out would need billions
    assert len(str(caught.value).splitlines()) <= 3


@pytest.mark.parametrize("data", [b"\x00\x01", b"\xff\xfe\x00", b"\x89PNG\r\n\x1a\n\x00", b"a: \x80"])
def test_binary_is_refused(data):
    with pytest.raises(PresetError, match="not a text file"):
        read_bytes(data, "bad.yaml")


@pytest.mark.parametrize("fill", [" x", "\n", " x\n", "# "])
def test_large_files(fill):
    """The work grows with the length, not with its square."""
    count = (MAX_BYTES - 10) // len(fill)
    work = []
    for repeats in (count // 16, count // 8):
        text = "a: >\n" + fill * repeats
        with _calls() as calls:
            read_bytes(text.encode(), "long.yaml")
        work.append(calls[0])
    assert work[1] < 2.2 * work[0] + 1000
    with pytest.raises(PresetError, match="larger than"):
        read_bytes(text.encode() + b"x" * MAX_BYTES, "long.yaml")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(OutputError, match="no such file"):
        read_file(tmp_path / "none.yaml")
    with pytest.raises(OutputError, match="is a folder"):
        read_file(tmp_path)


def test_every_problem_of_a_text_is_collected():
    source = read_text("a: !!python/object:os.system x\nb: {c: 1, c: 2}\nd: [.nan, -.inf]\ne: !foo {}\n", "bad.yaml")
    places = [(p.line, p.column, p.path) for p in source.problems]
    assert places == [(1, 4, ("a",)), (2, 11, ("b", "c")), (3, 5, ("d", 0)), (3, 11, ("d", 1)), (4, 4, ("e",))]
    assert "tags are not allowed" in source.problems[0].text
    assert "twice" in source.problems[1].text


def test_positions_and_caret():
    source = read_text("a:\n  b: [1, {c: 2}]\n", "f.yaml")
    assert (
        str(source.problem(("a", "b", 1, "c"), "wrong"))
        == "f.yaml:2:14: a.b[1].c: wrong\n      b: [1, {c: 2}]\n                 ^"
    )
    assert str(source.problem(("a", "b", 1, "c"), "wrong", at_key=True)).startswith("f.yaml:2:11: ")
    assert str(source.problem(("a", "b", 7), "wrong")).startswith("f.yaml:2:6: ")


def test_a_long_line_is_cut_around_the_caret():
    source = read_text("a: [" + "1, " * 400 + "x]\n", "f.yaml")
    _, line, caret = str(source.problem(("a", 400), "wrong")).splitlines()
    assert len(line) <= 104
    assert line[caret.index("^")] == "x"


@pytest.mark.parametrize(
    ("text", "value"),
    [("500", 500), ("1e12", 1e12), ("2..4", "2..4"), ("1/2", "1/2"), ("[1, 2]", [1, 2]), ("{a: 1}", {"a": 1}), ("yes", "yes"),
     ("true", True), ("", None), ("'1'", "1"), ("#ff0000", "#ff0000"), ("0x10", "0x10"), ("2024-01-01", "2024-01-01")],
)  # fmt: skip
def test_values(text, value):
    assert read_value(text, "--set") == value


def test_depth_within_the_bound_is_read():
    text = "a: " + "[" * (MAX_DEPTH - 2) + "1" + "]" * (MAX_DEPTH - 2)
    read_text(text, "deep.yaml")


def test_aliases_are_values():
    assert read_text("a: &x {b: 1}\nc: *x\n", "f.yaml").plain() == {"a": {"b": 1}, "c": {"b": 1}}
