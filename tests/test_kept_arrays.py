"""Arrays that are kept in the cache folder: the same bits, made once, and never those of other arguments or other code."""

import os

import numpy as np
import pytest

from gen_art.backend import kept_files, runtime
from gen_art.backend.kept_arrays import kept
from gen_art.backend.kept_files import KeptFiles


def waves(number: int, height: float) -> tuple[np.ndarray, ...]:
    return np.sin(np.arange(number) * height), np.full((2, 3), height, np.float32)


waves.__module__ = "gen_art.waves"  # only this package's code has a digest


class Counting(KeptFiles):
    """Counts what was made anew: all of it is written."""

    made = 0

    def write(self, key, content):
        self.made += 1
        super().write(key, content)


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.setitem(runtime._state, "kept", files := Counting(tmp_path / "arrays"))
    return files


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "arrays"


def alike(ones, others) -> bool:
    return all(a.dtype == b.dtype and np.array_equal(a, b) for a, b in zip(ones, others, strict=True))


def test_arrays_are_made_once_for_each_arguments(files, folder):
    """Mutants: the key leaves the arguments or the function out; the files are never read."""
    first, again = kept(waves)(5, 0.25), kept(waves)(5, 0.25)
    assert alike(first, again) and alike(first, (np.sin(np.arange(5) * 0.25), np.full((2, 3), 0.25, np.float32)))
    assert files.made == 1 and len(list(folder.iterdir())) == 1
    assert not alike(first, kept(waves)(5, np.nextafter(0.25, 1)))
    assert files.made == 2 and len(list(folder.iterdir())) == 2

    def waves_of_another_phase(number, height):
        return np.sin(np.arange(number) * height + 1.0), np.full((2, 3), height, np.float32)

    waves_of_another_phase.__module__, waves_of_another_phase.__qualname__ = waves.__module__, waves.__qualname__
    assert not alike(first, kept(waves_of_another_phase)(5, 0.25)) and files.made == 3


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "other", "gone"])
def test_a_damaged_file_is_made_anew(files, folder, damage):
    first = kept(waves)(7, 1.0)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    flipped = whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:]
    broken = {"cut": whole[:-1], "flipped": flipped, "empty": b"", "other": b"3\nabc", "gone": None}[damage]
    if broken is None:
        file.unlink()
    else:
        file.write_bytes(broken)
    assert alike(kept(waves)(7, 1.0), first)
    assert files.made == 2 and file.read_bytes() == whole


def test_a_file_of_another_kind_is_made_anew(files, folder):
    first = kept(waves)(7, 1.0)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    files.write(file.stem, b"whole, but no arrays")
    assert alike(kept(waves)(7, 1.0), first) and file.read_bytes() == whole


def test_what_cannot_be_kept_is_made_each_time(files, folder, tmp_path, monkeypatch):
    """A folder that cannot be written, code that has no digest, and a process in which Taichi has not started."""

    def of_a_user(number, height):
        return waves(number, height)

    for _ in range(2):
        assert alike(kept(of_a_user)(3, 1.0), waves(3, 1.0))
    (tmp_path / "file").write_text("")
    for nowhere in (Counting(tmp_path / "file"), None):
        monkeypatch.setitem(runtime._state, "kept", nowhere)
        for _ in range(2):
            assert alike(kept(waves)(3, 1.0), waves(3, 1.0))
    assert files.made == 0 and not folder.exists()


def test_the_folder_keeps_what_was_used_last(tmp_path, monkeypatch):
    monkeypatch.setattr(kept_files, "LIMIT", 4000)
    files = KeptFiles(tmp_path / "kept")
    for n in range(6):
        files.write(f"key{n}", b"x" * 900)
        os.utime(tmp_path / "kept" / f"key{n}.kept", (n, n))
    assert files.read("key0") == b"x" * 900  # used now
    KeptFiles(tmp_path / "kept").tidy()  # of a process that has written nothing
    assert len(list((tmp_path / "kept").iterdir())) == 6
    files.tidy()
    left = {file.stem for file in (tmp_path / "kept").iterdir()}
    assert "key0" in left and "key1" not in left and 1 <= len(left) <= 2
    assert files.read("key1") is None
