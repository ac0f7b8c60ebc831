"""Kernels are kept as machine code, under a key that changes with everything that their trace depends on."""

import importlib.util
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gen_art.backend import launch_patch, machine_code, runtime
from gen_art.backend.fingerprint import Unknown, fingerprint
from gen_art.backend.kernel_store import KernelStore

ROOT = Path(__file__).resolve().parents[1]
SOURCE = '''
"""A module of the package."""
from collections import namedtuple
from dataclasses import dataclass
from functools import cache, cached_property, partial
from operator import itemgetter
from pathlib import Path
import numpy as np
from gen_art.backend.runtime import ti
from gen_art.maths import elementary

FACTOR = 2.0
TABLE = np.array([1.0, 2.5])
CHOICES = {"one": 1, "two": 2}
BITCODE = Path(__file__).parent / "some.bc"
Pair = namedtuple("Pair", "left right")
pair = Pair(3, 4)
third = partial(pow, 5)
first = itemgetter("one")
numbers = ti.types.ndarray(ti.f32, 1)


class Numbered:
    def __init__(self, choice, number):
        self.choice, self.number = choice, number

    @property
    def fixed(self):
        return (type(self), self.choice)

    @ti.func
    def at(self, x):
        return x * 41


numbered = Numbered(43, 47)


def ti_helper(n):
    def nested(m):
        return m + 7
    return nested(n) + CHOICES["one"] + pair.left + third(2) + first(CHOICES)


@cache
def cached(n):
    return n * 11


@dataclass(frozen=True)
class Part:
    size: float = 0.5


class Base:
    exponent = 13

    @staticmethod
    def shift():
        return 17


class Law(Base):
    part = Part()

    def __init__(self, strength, names=("a",)):
        self.strength, self.names = strength, names

    @property
    def doubled(self):
        return self.strength * 19

    @cached_property
    def later(self):
        return 23

    @ti.func
    def of(self, x):
        return x * self.strength + ti.static(self.exponent + self.shift() + self.doubled + self.later) + self.part.size


@ti.func
def inner(x):
    return x * FACTOR + elementary.sin(x)


@ti.func
def outer(x, bias: ti.template() = 29):
    from gen_art.maths import blocks
    return inner(x) + TABLE[1] + bias + ti.static(ti_helper(1) + cached(2) + len(str(BITCODE)) * 0)


def make(law, count=31):
    @ti.kernel
    def go(x: numbers):
        for i in range(x.shape[0]):
            x[i] = outer(x[i]) + law.of(x[i]) + numbered.at(x[i]) + count
    return go


go = make(Law(37))
'''
CHANGES = [
    ("FACTOR = 2.0", "FACTOR = 2.5"),
    ("[1.0, 2.5]", "[1.0, 2.6]"),
    ('"one": 1', '"one": 3'),
    ("Pair(3, 4)", "Pair(3, 5)"),
    ("partial(pow, 5)", "partial(pow, 6)"),
    ('itemgetter("one")', 'itemgetter("two")'),
    ("ndarray(ti.f32, 1)", "ndarray(ti.f64, 1)"),
    ("m + 7", "m - 7"),
    ("n * 11", "n * 12"),
    ("size: float = 0.5", "size: float = 0.25"),
    ("exponent = 13", "exponent = 14"),
    ("return 17", "return 18"),
    ("self.strength * 19", "self.strength * 20"),
    ("return 23", "return 24"),
    ("x * self.strength", "x / self.strength"),
    ('names=("a",)', 'names=("b",)'),
    ("x * FACTOR", "x + FACTOR"),
    ("elementary.sin", "elementary.cos"),
    ("= 29", "= 30"),
    ("import blocks", "import uniform"),
    ("x * 41", "x * 42"),
    ("Numbered(43,", "Numbered(44,"),
    ("count=31", "count=32"),
    ("Law(37)", "Law(37.0)"),
    ("law.of(x[i]) +", "law.of(x[i]) -"),
]
HARMLESS = [
    ("Numbered(43, 47)", "Numbered(43, 48)"),
    ("", "\n# a comment\n"),
    ('"""A module of the package."""', '"""Other words."""'),
    ("def cached(n):", "def cached(n: int) -> int:"),
    ("class Base:", "class Unused:\n    exponent = 99\n\n\nclass Base:"),
]


def module_of(source: str, folder: Path, name: str = "gen_art._sample"):
    """A module of the package with this source."""
    folder.mkdir(exist_ok=True)
    file = folder / "sample.py"
    file.write_text(source)
    os.utime(file, (1e9, 1e9))  # older than this process
    spec = importlib.util.spec_from_file_location(name, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules[name]
    return module


def digest(module) -> str:
    return fingerprint(module.go._primal.func).digest


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    return (tmp_path_factory.mktemp("folder") / str(n) for n in range(1000))


@pytest.fixture
def runs():
    runtime.init()
    if (sys.platform, platform.machine()) != ("linux", "x86_64"):
        pytest.skip("machine code is called on Linux with x86-64 only")
    assert machine_code.available()


@pytest.mark.parametrize(("old", "new"), CHANGES)
def test_the_digest_changes_with_all_that_a_kernel_reaches(folders, old, new):
    assert SOURCE.count(old) == 1
    before, after = module_of(SOURCE, next(folders)), module_of(SOURCE.replace(old, new), next(folders))
    assert digest(before) == digest(before)
    assert digest(before) != digest(after)


@pytest.mark.parametrize(("old", "new"), HARMLESS)
def test_the_digest_does_not_depend_on_what_a_kernel_does_not_reach(folders, old, new):
    changed = SOURCE.replace(old, new) if old else SOURCE + new
    assert digest(module_of(SOURCE, next(folders))) == digest(module_of(changed, next(folders)))


def test_the_digest_changes_with_replaced_functions_and_files(folders, monkeypatch):
    folder = next(folders)
    module = module_of(SOURCE, folder)
    found = {digest(module)}
    (folder / "some.bc").write_bytes(b"one")
    found.add(digest(module))
    (folder / "some.bc").write_bytes(b"two")
    found.add(digest(module))
    monkeypatch.setattr(module.elementary, "sin", module.elementary.cos)  # of another module
    found.add(digest(module))
    monkeypatch.setattr(module.Base, "shift", staticmethod(lambda: 18))
    with pytest.raises(Unknown):  # a function of this test
        digest(module)
    monkeypatch.undo()
    module.inner = module.elementary.exp
    found.add(digest(module))
    assert len(found) == 5


@pytest.mark.parametrize("value", [open, "lambda", object(), np.array([object()]), [sys.modules["gen_art"]]])
def test_what_has_no_digest_is_unknown(folders, value):
    module = module_of(SOURCE, next(folders))
    module.FACTOR = (lambda: 3) if isinstance(value, str) else value
    if value is open:  # of Python itself, so its name says what it is
        assert digest(module)
    else:
        with pytest.raises(Unknown):
            digest(module)


def test_the_key_changes_with_types_and_settings(folders):
    function = module_of(SOURCE, next(folders)).go._primal.func
    runtime.init()
    one = (np.ndarray, np.dtype("f4"), 1)
    keys = [
        launch_patch._key(function, types, settings)
        for types, settings in (
            ((one,), ("f32", False)),
            ((one,), ("f64", False)),
            ((one,), ("f32", True)),
            (((np.ndarray, np.dtype("f8"), 1),), ("f32", False)),
            (((np.ndarray, np.dtype("f4"), 2),), ("f32", False)),
        )
    ]
    assert len(set(keys)) == 5 and None not in keys


def test_a_source_that_was_edited_since_the_process_started_has_no_key(folders):
    folder = next(folders)
    function = module_of(SOURCE, folder).go._primal.func
    runtime.init()
    assert launch_patch._key(function, (), ())
    os.utime(folder / "sample.py")
    assert launch_patch._key(function, (), ()) is None


SMALL = """
from gen_art.backend.runtime import ti
numbers = ti.types.ndarray(ti.f64, 1)
@ti.func
def law(x):
    return x * 2.0
@ti.kernel
def go(x: numbers, a: ti.i32, b: ti.i64, c: ti.f32, d: ti.f64):
    for i in range(x.shape[0]):
        x[i] = law(x[i]) + 10.0 * a + 100.0 * ti.cast(b, ti.f64) + c + d
"""
ARGUMENTS = -3, 1 << 40, 0.25, 1e-3


def expected(x: np.ndarray) -> np.ndarray:
    a, b, c, d = ARGUMENTS
    return x * 2.0 + 10.0 * a + 100.0 * b + c + d


@pytest.fixture
def small(folders, tmp_path, monkeypatch, runs):
    """Makes a launch of the kernel of SMALL, as a new process would, with a store of its own; and the names that were traced."""
    monkeypatch.setitem(runtime._state, "store", KernelStore(tmp_path / "kept"))
    traced = []

    def make(source=SMALL):
        go = module_of(source, next(folders)).go
        inside = go._primal
        compile_it = inside.ensure_compiled
        inside.ensure_compiled = lambda *args: (traced.append(1), compile_it(*args))[1]
        return runtime.kernel(go, "f64")

    return make, traced, tmp_path / "kept"


def test_a_kernel_that_is_kept_is_not_traced(small):
    make, traced, kept = small
    x = np.arange(1000.0)
    for count in (1, 1):
        y = x.copy()
        launch = make()
        launch(y, *ARGUMENTS)
        assert np.array_equal(y, expected(x))
        launch(y, *ARGUMENTS)
        assert np.array_equal(y, expected(expected(x)))
        assert len(traced) == count and len(list(kept.iterdir())) == 1
    y = x.copy()
    make(SMALL.replace("x * 2.0", "x * 3.0"))(y, *ARGUMENTS)
    assert len(traced) == 2 and np.allclose(y - expected(x), x, rtol=1e-3)


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "other", "gone"])
def test_a_damaged_file_is_made_anew(small, damage):
    make, traced, kept = small
    x = np.arange(100.0)
    make()(x.copy(), *ARGUMENTS)
    (file,) = kept.iterdir()
    whole = file.read_bytes()
    flipped = whole[:-9] + bytes([whole[-9] ^ 1]) + whole[-8:]
    broken = {"cut": whole[:-1], "flipped": flipped, "empty": b"", "other": b'{"tasks": 3}\nabc', "gone": None}[damage]
    if broken is None:
        file.unlink()
    else:
        file.write_bytes(broken)
    y = x.copy()
    make()(y, *ARGUMENTS)
    assert np.array_equal(y, expected(x))
    assert len(traced) == 2 and file.read_bytes() == whole


def test_a_folder_that_cannot_be_written_keeps_nothing(small, monkeypatch, tmp_path):
    make, traced, _ = small
    (tmp_path / "file").write_text("")
    monkeypatch.setitem(runtime._state, "store", KernelStore(tmp_path / "file"))
    for count in (1, 2):
        x = np.arange(10.0)
        make()(x, *ARGUMENTS)
        assert np.array_equal(x, expected(np.arange(10.0))) and len(traced) == count
    runtime._state["store"]._has_written = True  # as one would that has written before
    runtime._state["store"].tidy()


def test_a_kernel_of_a_user_is_traced_but_its_machine_code_is_kept(small):
    make, traced, kept = small
    x = np.arange(10.0)
    for count in (1, 2):
        y = x.copy()
        make(SMALL + "law.__wrapped__.__module__ = 'mine'\n")(y, *ARGUMENTS)
        assert np.array_equal(y, expected(x))
        assert len(traced) == count and len(list(kept.iterdir())) == 1


@pytest.mark.parametrize("usable", [True, False])
def test_arrays_of_any_kind(small, usable, monkeypatch):
    """Whether kernels can be called as machine code here, or Taichi launches them."""
    make, _, _ = small
    monkeypatch.setattr(machine_code, "available", lambda: usable)
    launch = make()
    bound = launch.bound(y := np.arange(7.0), *ARGUMENTS)
    for _ in range(3):
        wanted = expected(y)
        bound()
        assert np.array_equal(y, wanted)
    for x in (np.arange(5.0), np.arange(0.0), np.arange(9.0).view(np.recarray), np.ones(3)):
        y, wanted = x.copy(), expected(np.array(x))
        launch(y, *ARGUMENTS)
        assert np.array_equal(np.asarray(y), wanted)
    with pytest.raises(ValueError, match="contiguous"):
        launch(np.ones((4, 2))[:, 0], *ARGUMENTS)


def test_an_array_of_the_wrong_kind_is_refused(small):
    make, _, _ = small
    launch = make()
    launch(np.arange(3.0), *ARGUMENTS)
    with pytest.raises(Exception, match=r"ndim|dimension|ndarray|shape|index"):
        launch(np.float64(3.0), *ARGUMENTS)
    with pytest.raises((TypeError, RuntimeError)):
        launch(np.arange(3.0), 0.5, *ARGUMENTS[1:])


SCRIPT = """
import hashlib, json, sys
import gen_art as ga
from gen_art.backend import launch_patch
from taichi._lib import core
traced, keys = [], []
create, key = core.Program.create_kernel, launch_patch._key
core.Program.create_kernel = lambda self, body, name, mode: (traced.append(name), create(self, body, name, mode))[1]
launch_patch._key = lambda function, *rest: (keys.append(function.__name__), key(function, *rest))[1] or exit(function.__name__)
sim = ga.Simulation(ga.load_preset(sys.argv[1], overrides=json.loads(sys.argv[2])), threads=2)
sim.advance_to_frame(2)
picture = ga.render_frame(sim, size=(160, 90))
digest = hashlib.sha256(picture.tobytes() + sim.digest().encode()).hexdigest()
print(json.dumps({"traced": traced, "keys": keys, "digest": digest}))
"""


@pytest.mark.parametrize(
    "preset", ["course/obstacles", *(pytest.param(n, marks=pytest.mark.proof) for n in ("fire", "galaxy"))]
)
def test_a_second_process_traces_no_kernel_of_a_preset(tmp_path, runs, preset):
    env = {**os.environ, "PYTHONPATH": str(ROOT), "GEN_ART_CACHE": str(tmp_path)}
    found = []
    for change in {}, {}, {"seed": 123}:
        command = [sys.executable, "-c", SCRIPT, preset, json.dumps(change)]
        done = subprocess.run(command, capture_output=True, text=True, env=env, cwd=ROOT)
        assert done.returncode == 0, done.stderr
        found.append(json.loads(done.stdout.splitlines()[-1]))
    first, second, other = found
    assert first["digest"] == second["digest"] != other["digest"]
    assert first["keys"] == second["keys"]
    assert len(first["traced"]) >= 9
    for run in second, other:
        assert [name.partition("_c")[0] for name in run["traced"]] == ["touch"]  # which finds Taichi's runtime


@pytest.mark.parametrize("count", [5, 2 * launch_patch._KEPT_LAUNCHES])
def test_arrays_that_take_turns(small, count):
    """Fewer than are kept, and more."""
    make, _, _ = small
    kernel, rng = make(), np.random.default_rng(1)
    arrays = [rng.uniform(size=n) for n in range(1, count)]
    for _ in range(3):
        for array in arrays:
            wanted = expected(array)
            kernel(array, *ARGUMENTS)
            assert np.array_equal(array, wanted)


def test_a_fresh_array_in_the_place_of_a_freed_one(small):
    """Python gives it the number of the one that is gone, under which a launch is kept."""
    make, _, _ = small
    kernel, repeated, numbers = make(), 0, set()
    for n in range(1, 200):
        array = np.arange(float(n))
        repeated += id(array) in numbers
        numbers.add(id(array))
        wanted = expected(array)
        kernel(array, *ARGUMENTS)
        assert np.array_equal(array, wanted)
        del array
    assert repeated > 0
