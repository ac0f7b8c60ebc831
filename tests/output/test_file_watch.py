"""Waiting for files: what counts as a change, and that the system's messages, links and looks all lead to it."""

import os
import sys
import threading

import pytest
import watchfiles

from gen_art.errors import UsageError
from gen_art.files import cached_by_file, stamp
from gen_art.output import file_watch
from gen_art.output.dependencies import dependencies
from gen_art.output.file_watch import FileWatch
from gen_art.preset.load import load_preset
from gen_art.preset.shipped import course_names, find, preset_names
from tests.preset.piece import TEXT

TRIES = 300  # a tenth of a second each, after which a test gives up


@pytest.fixture
def preset(tmp_path):
    path = tmp_path / "piece.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def waited(watch, change):
    """What `wait` returns while another thread makes a change, again and again until it is seen.

    It begins when the watch has looked once, so that something must wake the watch for another look.
    """
    seen, looked, look = threading.Event(), threading.Event(), watch.changed

    def changed():
        found = look()
        looked.set()
        return found

    watch.changed = changed

    def work():
        looked.wait()
        for k in range(TRIES):
            change(k)
            if seen.wait(0.1):
                return
        watch.close()

    thread = threading.Thread(target=work)
    thread.start()
    try:
        return watch.wait()
    finally:
        seen.set()
        thread.join()


@pytest.fixture
def messages_alone(monkeypatch):
    """Only the system's messages wake a watch."""
    monkeypatch.setattr(file_watch, "_LOOK", 1e6)


def write(path):
    return lambda k: path.write_text(f"{TEXT}# {k}\n", encoding="utf-8")


def rename_to(path):
    def change(k):
        write(new := path.with_suffix(".new"))(k)
        os.replace(new, path)

    return change


@pytest.mark.parametrize("change", [write, rename_to])
def test_a_saved_file_wakes_the_watch(preset, messages_alone, change):
    with FileWatch() as watch:
        watch.follow({preset: stamp(preset)})
        assert waited(watch, change(preset)) == [preset]


def test_a_file_behind_a_link_wakes_the_watch(preset, tmp_path, messages_alone):
    link = tmp_path / "elsewhere" / "link.yaml"
    link.parent.mkdir()
    link.symlink_to(preset)
    with FileWatch() as watch:
        watch.follow({link: stamp(link)})
        assert waited(watch, write(preset)) == [link]


def test_other_files_of_the_folder_do_not_end_the_wait(preset, tmp_path):
    def change(k):
        (tmp_path / "other.yaml").write_text(str(k))
        if k == 3:
            write(preset)(k)

    with FileWatch() as watch:
        watch.follow({preset: stamp(preset)})
        assert waited(watch, change) == [preset]


def test_a_file_that_does_not_exist_yet_is_seen_when_it_comes(tmp_path):
    late = tmp_path / "pictures" / "spark.png"

    def change(k):
        late.parent.mkdir(exist_ok=True)
        write(late)(k)

    with FileWatch() as watch:
        watch.follow({late: stamp(late)})
        assert waited(watch, change) == [late]


def test_a_change_before_the_wait_is_not_missed(preset, messages_alone):
    with FileWatch() as watch:
        before = {preset: stamp(preset)}
        write(preset)(0)
        watch.follow(before)
        assert watch.wait() == [preset]


def test_a_file_that_is_deleted_and_put_back_is_one_change(preset, monkeypatch):
    """As some editors save. The sleep in which the file is missing puts it back."""

    def sleep(seconds):
        if not preset.exists():
            assert seconds == file_watch._GONE
            write(preset)(0)

    before = stamp(preset)
    preset.unlink()
    monkeypatch.setattr(file_watch.time, "sleep", sleep)
    with FileWatch() as watch:
        watch.follow({preset: before})
        assert watch.wait() == [preset] and preset.exists()


def test_a_deleted_file_is_a_change(preset):
    with FileWatch() as watch:
        watch.follow({preset: stamp(preset)})
        preset.unlink()
        assert watch.wait() == [preset] and watch.changed() == [preset]
        watch.follow({preset: None})
        assert watch.changed() == []
        assert waited(watch, write(preset)) == [preset]


def test_without_messages_changes_are_seen_all_the_same(preset, monkeypatch):
    def refuse(*folders, **options):
        raise OSError("no watches are left")

    monkeypatch.setattr(watchfiles, "watch", refuse)
    with FileWatch() as watch, pytest.warns(UserWarning, match="no watches are left.*once a second"):
        watch.follow({preset: stamp(preset)})
        assert waited(watch, lambda k: write(preset)(k) if k > 2 else None) == [preset]


def test_a_closed_watch_ends_the_wait_of_another_thread(preset):
    watch, found = FileWatch(), []
    watch.follow({preset: stamp(preset)})
    thread = threading.Thread(target=lambda: found.append(watch.wait()))
    thread.start()
    watch.close()
    thread.join()
    assert found == [[]]


def test_the_package_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "watchfiles", None)
    with pytest.raises(UsageError, match="pip install watchfiles"):
        FileWatch()


@pytest.mark.parametrize("name", [n for n in (*preset_names(), *course_names()) if load_preset(n).files])
def test_the_files_of_a_preset_are_among_its_dependencies(name):
    found = dependencies(find(name))
    assert {file.place for file in load_preset(name).files} | {find(name)} <= found.keys()
    assert all(found[file.place] == stamp(file.place) for file in load_preset(name).files)


def test_dependencies_of_a_preset_that_is_wrong(preset, tmp_path):
    """`drops.death` is no file, but could be one's name."""
    preset.write_text(
        TEXT + "wrong: [spark.png, 1..2, /etc/passwd.txt, ../up.png, 'map.npy']\nseeed: 1.5\n", encoding="utf-8"
    )
    plugin = tmp_path / "swirl.py"
    found = dependencies(preset, {"systems.drops.look": {"picture": {"image": "set.webp"}}}, [plugin])
    names = ("piece.yaml", "swirl.py", "spark.png", "map.npy", "set.webp", "drops.death")
    assert found == {tmp_path / name: stamp(tmp_path / name) for name in names}
    assert found[preset] is not None and found[plugin] is None
    preset.write_text("a: [", encoding="utf-8")
    assert dependencies(preset).keys() == {preset}


def test_a_file_is_read_again_once_it_is_saved(preset):
    read = []

    @cached_by_file(4)
    def text(path, times):
        read.append(times)
        return path.read_text(encoding="utf-8") * times

    assert text(preset, 1) == text(preset, 1) and text(preset, 2) == TEXT * 2 and read == [1, 2]
    write(preset)(5)
    assert text(preset, 1).endswith("# 5\n") and text(preset, 1) and read == [1, 2, 1]
