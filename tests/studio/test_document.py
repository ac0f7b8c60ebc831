"""The document of the studio: values and text in step, undo, problems at their lines, and the file."""

import pytest

from gen_art.errors import OutputError, UsageError
from gen_art.preset.load import load_preset
from gen_art.studio.document import LARGEST_TEXT, Document
from tests.studio.piece import TEXT


@pytest.fixture
def document(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return Document(str(path))


def test_a_value_is_known_at_once_and_the_text_takes_it_over(document):
    assert document.set({"knobs.push": 8}) == [] and document.preset.knobs["push"].value == 8
    assert document.text == TEXT and document.data["knobs"]["push"]["value"] == 8 and not document.is_saved
    assert document.settle()
    assert document.text == TEXT.replace("value: 9,", "value: 8,"), "all else as it was, comments too"
    assert not document.settle()


def test_many_values_of_one_drag_are_one_undo(document):
    for push in (10, 11, 12):
        document.set({"knobs.push": push})
    document.settle()
    assert document.undo() and document.text == TEXT and document.preset.knobs["push"].value == 9
    assert document.redo() and "value: 12," in document.text
    assert document.undo() and not document.state["undo"] and document.state["redo"]
    document.set({"seed": 8})
    document.settle()
    assert not document.state["redo"], "another way from here"


def test_undo_takes_back_what_the_text_has_not_taken_over(document):
    document.set({"knobs.push": 10})
    assert document.undo() and document.text == TEXT and document.preset.knobs["push"].value == 9


def test_a_wrong_value_is_refused_and_the_last_preset_stays(document):
    before = document.preset
    refused = document.set({"systems.drops.look.draw": "disk"})
    assert document.preset is before and "did you mean 'disc'" in refused[0]["text"] and document.problems == []
    assert document.set({"develop.exposure": 1.0}) == []
    document.settle()
    document.save()
    assert "draw: disc" in document.text and "exposure: 1.0" in document.text


def test_a_path_that_does_not_exist_is_a_sentence(document):
    refused = document.set({"systems.drips.look.draw": "disc"})
    assert "there is no 'drips' in systems; did you mean 'drops'" in refused[0]["text"]


def test_text_with_problems_names_their_lines_and_keeps_the_picture(document):
    before = document.preset
    assert not document.write(TEXT.replace("fov: 40", "fov: 400"))
    assert document.problems[0]["line"] == 19 and document.problems[0]["path"] == "camera.fov"
    assert not document.write(TEXT.replace("seed: 5", "seed: [5"))
    assert document.problems[0]["line"] and document.preset is before
    with pytest.raises(UsageError, match="problems"):
        document.save()
    assert not document.undo() and document.undo() and document.problems == []


def test_keys_are_added_and_removed(document):
    assert document.set({"develop.vignette": 0.5}) == []
    document.settle()
    assert "vignette: 0.5" in document.text
    assert document.remove("develop.vignette") and document.text == TEXT
    assert document.remove("systems.drops.look.size") and "# shrinks" not in document.text
    with pytest.raises(UsageError, match="is not in the preset"):
        document.remove("develop.nothing")
    assert not document.remove("systems") and document.problems


def test_saving_writes_the_text(document, tmp_path):
    document.set({"knobs.glow": 5})
    assert document.save() == tmp_path / "mine.yaml"
    assert (tmp_path / "mine.yaml").read_text(encoding="utf-8") == TEXT.replace("glow: 3", "glow: 5")
    assert document.is_saved and load_preset(tmp_path / "mine.yaml") == document.preset


def test_a_file_that_was_changed_elsewhere_is_read_again(document, tmp_path):
    (tmp_path / "mine.yaml").write_text(TEXT.replace("seed: 5", "seed: 6"), encoding="utf-8")
    assert document.reload() and document.preset.seed == 6 and document.is_saved
    assert document.undo() and document.preset.seed == 5 and not document.is_saved
    (tmp_path / "mine.yaml").unlink()
    with pytest.raises(OutputError, match=r"cannot read mine\.yaml"):
        document.reload()


def test_a_shipped_preset_is_not_saved():
    document = Document("fire")
    assert document.state["file"] is None
    with pytest.raises(UsageError, match="gen-art new mine --from fire"):
        document.save()


def test_a_text_of_megabytes_is_refused(document):
    with pytest.raises(UsageError, match="at most"):
        document.write("#" * (LARGEST_TEXT + 1))


def test_controls_wait_while_the_text_cannot_be_read(document):
    document.set({"knobs.push": 8})
    document.write("seed: [5")
    for use in (lambda: document.set({"seed": 3}), lambda: document.remove("seed")):
        with pytest.raises(UsageError, match="mend it before a control changes it"):
            use()
    assert document.undo() and document.text == TEXT, "the way back is open"
    assert document.set({"seed": 3}) == []


def test_a_redo_after_a_change_of_a_value_keeps_that_value(document):
    document.write(TEXT.replace("seed: 5", "seed: 6"))
    document.undo()
    document.set({"knobs.push": 8})
    document.redo()
    assert document.preset.knobs["push"].value == 8 and document.preset.seed == 5
    assert document.undo() and document.text == TEXT


def test_a_file_that_was_changed_elsewhere_is_not_overwritten_unseen(document, tmp_path):
    document.set({"knobs.push": 8})
    (tmp_path / "mine.yaml").write_text(TEXT.replace("seed: 5", "seed: 6"), encoding="utf-8")
    with pytest.raises(UsageError, match="was changed elsewhere"):
        document.save()
    document.reload()
    document.set({"knobs.push": 7})
    document.save()
    assert "seed: 6" in (tmp_path / "mine.yaml").read_text(encoding="utf-8")
