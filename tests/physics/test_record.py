"""Records: what is kept while a simulation runs, when, and in which files."""

import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

import gen_art as ga
from gen_art.simulation.record_columns import DiskColumn
from tests.physics.test_births import BURST, preset
from tests.physics.test_changes import N, arrays, simulation

F, I = ga.forces, ga.interactions
WHAT = ["energy", "momentum", "s.position", "s.mass", "s.count", "s.energy"]


def galaxy(**more):
    return simulation(arrays(), interactions=[I.SelfGravity(G=0.3, softening=0.2)], **more)


def test_values_are_those_of_the_moments():
    sim, other = galaxy(), galaxy()
    sim.step(3)
    other.step(3)
    record = sim.record(every=10, what=WHAT)
    sim.advance(0.125)  # 25 steps: moments at 3, 13 and 23
    assert isinstance(record, dict) and list(record) == ["time", *WHAT]
    assert record.time.tolist() == [3 * sim.dt, 13 * sim.dt, 23 * sim.dt]
    for k in range(3):
        d = other.diagnostics()
        assert record["energy"][k] == record["s.energy"][k] == d.energy
        assert np.array_equal(record["momentum"][k], d.momentum) and record["s.count"][k] == N
        assert np.array_equal(record["s.position"][k], other["s"].position)
        assert np.array_equal(record["s.mass"][k], other["s"].mass)
        other.step(10)
    sim.step(8)
    assert len(record.time) == 4 and record["s.position"].shape == (4, N, 3)  # it goes on
    with pytest.raises(ValueError, match="read-only"):
        record["energy"][0] = 1
    assert repr(record) == "<Record of time, energy, momentum, s.position, s.mass, s.count, s.energy; 4 moments>"


def test_recording_changes_no_bit():
    plain, recorded = simulation(arrays(), forces=[F.Spring()]), simulation(arrays(), forces=[F.Spring()])
    recorded.record(every=7, what=WHAT)
    for sim in (plain, recorded):
        sim.step(100)
    assert plain.digest() == recorded.digest()


def test_a_system_alone_and_all_of_them():
    one, two = (ga.ParticleSystem(**arrays(k), forces=[F.Gravity()]) for k in (1, 2))
    sim = ga.Simulation({"one": one, "t.wo": two}, dt=0.01, precision="f64")  # a name with a dot
    record = sim.record(
        every=5, what=["energy", "one.energy", "t.wo.energy", "one.velocity", "t.wo.momentum", "t.wo.age"]
    )
    sim.step(20)
    assert len(record.time) == 5 and np.allclose(
        record["energy"], record["one.energy"] + record["t.wo.energy"], rtol=1e-14
    )
    m, v = arrays(2)["mass"], arrays(2)["velocity"]
    assert np.allclose(record["t.wo.momentum"][0], m @ v) and not np.allclose(
        record["t.wo.momentum"][0], m @ arrays(1)["velocity"]
    )
    assert np.allclose(record["t.wo.age"][:, 0], record.time)
    assert set(record.ids) == {"one", "t.wo"}


def test_the_dead_are_nan_and_the_newborn_are_left_out():
    sim = ga.Simulation(preset(BURST, 0.01), precision="f64")
    record = sim.record(every=1, what=["shells.position", "shells.count"])  # a shell of the start, dead at 0.155 s
    sim.step(30)
    dead = np.isnan(record["shells.position"]).all(axis=(1, 2))
    assert record["shells.position"].shape == (31, 1, 3) and np.array_equal(dead, record.time >= 0.155)
    assert record["shells.count"].max() == 2 and record.ids["shells"].tolist() == [0]
    sim = galaxy()
    record = sim.record(every=1, what=["s.mass"])
    sim["s"].remove([3])
    sim["s"].add((0, 0, 0))
    sim.step(1)
    assert (
        np.isnan(record["s.mass"][1]).tolist() == [k == 3 for k in range(N)] and not np.isnan(record["s.mass"][0]).any()
    )


def test_it_ends_where_it_is_closed():
    sim = galaxy()
    with sim.record(every=1, what=["energy"]) as record:
        sim.step(4)
    sim.step(4)
    assert len(record["energy"]) == 5
    record.close()  # a second time does nothing


def test_steps_from_outside_are_recorded_too():
    """Adaptive steps move the particles themselves."""
    sim = simulation(arrays(), forces=[F.Spring()])
    record = sim.record(every=2, what=["energy"])
    ga.adaptive(sim, 10 * sim.dt)
    assert len(record.time) == 6


def same(record, loaded):
    assert set(loaded) == {*record, "s.ids"} and np.array_equal(loaded["s.ids"], np.arange(N))
    for name, array in record.items():
        assert np.array_equal(loaded[name], array) and loaded[name].dtype == array.dtype, name


def test_an_npz_has_the_arrays_and_the_ids(tmp_path):
    sim = galaxy()
    record = sim.record(every=10, what=WHAT)
    sim.step(40)
    record.save(tmp_path / "h.npz")
    with np.load(tmp_path / "h.npz") as loaded:
        same(record, dict(loaded))
    sim.step(40)
    record.save(tmp_path / "h.npz")  # in its place
    with np.load(tmp_path / "h.npz") as loaded:
        assert len(loaded["time"]) == 9


def table(record):
    """The columns of a table by name, written out."""
    columns = {"time": record.time, "energy": record["energy"]}
    columns |= {f"momentum.{a}": record["momentum"][:, k] for k, a in enumerate("xyz")}
    columns |= {f"s.position.{i}.{a}": record["s.position"][:, i, k] for i in range(N) for k, a in enumerate("xyz")}
    columns |= {f"s.mass.{i}": record["s.mass"][:, i] for i in range(N)}
    return columns | {"s.count": record["s.count"], "s.energy": record["s.energy"]}


def test_a_table_has_a_column_for_each_number():
    pytest.importorskip("pandas")
    sim = galaxy()
    record = sim.record(every=10, what=WHAT)
    sim.step(40)
    frame = record.to_pandas()
    assert frame.index.name == "time" and np.array_equal(frame.index, record.time)
    for name, column in table(record).items():
        assert name == "time" or np.array_equal(frame[name], column), name
    assert len(frame.columns) == len(table(record)) - 1


def test_three_particles_are_no_vector():
    """(moments, 3) of one number for each of three particles, and of a vector, have other names."""
    pytest.importorskip("pandas")
    sim = simulation({key: value[:3] for key, value in arrays().items()})
    frame = sim.record(what=["s.mass", "s.momentum"]).to_pandas()
    assert list(frame.columns) == ["s.mass.0", "s.mass.1", "s.mass.2", "s.momentum.x", "s.momentum.y", "s.momentum.z"]


@pytest.mark.parametrize("to", [False, True])
def test_parquet(tmp_path, to):
    parquet = pytest.importorskip("pyarrow.parquet")
    sim = galaxy()
    record, kept = (
        sim.record(every=10, what=WHAT, to=tmp_path / "h.parquet" if to else None),
        sim.record(every=10, what=WHAT),
    )
    sim.step(40)
    record.close() if to else record.save(tmp_path / "h.parquet")
    read = parquet.read_table(tmp_path / "h.parquet")
    assert read.column_names == list(table(kept))
    for name, column in table(kept).items():
        assert np.array_equal(read[name].to_numpy(), column), name


@pytest.mark.parametrize("to", [False, True])
def test_zarr(tmp_path, to):
    zarr = pytest.importorskip("zarr")
    sim, path = galaxy(), tmp_path / "h.zarr"
    record, kept = sim.record(every=10, what=WHAT, to=path if to else None), sim.record(every=10, what=WHAT)
    sim.step(40)
    record.close() if to else record.save(path)
    same(kept, {name: array[:] for name, array in zarr.open_group(str(path), mode="r").arrays()})
    kept.save(path)  # in its place
    assert [one.name for one in tmp_path.iterdir()] == ["h.zarr"]


def test_a_record_to_a_file_holds_the_same_bytes_in_little_memory(tmp_path):
    r = np.random.default_rng(0)
    sim = ga.Simulation(
        {"s": ga.ParticleSystem(position=r.normal(size=(2000, 3)), velocity=(r.normal(size=(2000, 3))))}, dt=0.01
    )
    sim.step(1)
    tracemalloc.start()
    record = sim.record(every=1, what=["s.position", "energy"], to=tmp_path / "h.npz")
    sim.step(300)
    assert record["s.position"].shape == (301, 2000, 3) and record["energy"].shape == (301,)  # read while it runs
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    record.close()  # writes 16 MB at a time
    assert (tmp_path / "h.npz").stat().st_size > 300 * 2000 * 12 > 5 * peak
    assert [one.name for one in tmp_path.iterdir()] == ["h.npz"]  # no temporary file is left
    with np.load(tmp_path / "h.npz") as loaded:
        x, energy = loaded["s.position"], loaded["energy"]
    assert np.array_equal(x[-1], sim["s"].position) and energy[-1] == sim.diagnostics().energy
    with pytest.raises(ga.UsageError, match=r"this record is closed, and its values are in .*h\.npz"):
        record["energy"]


def test_a_script_that_does_not_close_it_gets_its_file(tmp_path):
    script = (
        "import gen_art as ga\n"
        "sim = ga.Simulation({'s': ga.ParticleSystem(position=[[0, 0, 0]])}, dt=0.1)\n"
        "sim.record(every=2, what=['energy'], to='h.npz')\n"
        "sim.step(10)\n"
    )
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True, capture_output=True)
    with np.load(tmp_path / "h.npz") as loaded:
        assert len(loaded["energy"]) == 6


def test_a_full_disk_is_a_sentence_and_rows_stay_together(tmp_path, monkeypatch):
    sim = galaxy()
    record = sim.record(every=5, what=["energy", "s.position"], to=tmp_path / "h.npz")
    written, write = [], DiskColumn.write

    def fails(self, number, row):
        written.append(number)
        if len(written) == 2:  # after the time of this moment
            raise ga.GenArtError("cannot write it: No space left on device")
        write(self, number, row)

    monkeypatch.setattr(DiskColumn, "write", fails)
    with pytest.raises(ga.GenArtError, match="No space left"):
        sim.step(5)
    assert len(record.time) == len(record["energy"]) == 1
    sim.step(1)  # there is space again: the moment is written a step later
    record.close()
    with np.load(tmp_path / "h.npz") as loaded:
        assert {len(loaded[name]) for name in ("time", "energy", "s.position")} == {2}
        assert np.array_equal(loaded["s.position"][1], sim["s"].position) and loaded["time"][1] == 6 * sim.dt


def test_a_file_that_cannot_be_written_loses_nothing(tmp_path):
    sim = galaxy()
    record = sim.record(every=5, what=["energy"], to=tmp_path / "h.npz")
    sim.step(10)
    (tmp_path / "h.npz").mkdir()
    with pytest.raises(ga.GenArtError, match="a folder has this name"):
        record.close()
    record.save(tmp_path / "other.npz")
    with np.load(tmp_path / "other.npz") as loaded:
        assert len(loaded["energy"]) == 3


@pytest.mark.parametrize("options,words", [
    (dict(every=0), "every must be a whole number of at least 1"),
    (dict(every=1.5), "every must be a whole number"),
    (dict(what="energy"), "what must be a list of quantities"),
    (dict(what=[]), "what must name at least one quantity"),
    (dict(what=["energy", "energy"]), "what has energy twice"),
    (dict(what=["energi"]), "nothing can be recorded by the name 'energi'; did you mean 'energy'"),
    (dict(what=["wheel"]), "nothing can be recorded by the name 'wheel'; there are count, mass"),
    (dict(what=[3]), "a quantity to record must be text"),
    (dict(what=["t.position"]), "no system 't'"),
    (dict(what=["s.positon"]), "system 's' has no 'positon' to record; did you mean 'position'"),
    (dict(to="h.csv"), r"h\.csv: a record is saved as \.npz, \.parquet, \.zarr"),
    (dict(to="none/h.npz"), "there is no folder none"),
    (dict(to=3), "to must be the name of a file"),
])  # fmt: skip
def test_nonsense_is_a_sentence(options, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sim = galaxy()
    with pytest.raises(ga.GenArtError, match=words):
        sim.record(**options)
    assert not list(tmp_path.iterdir())
    sim.step(1)


def test_a_system_without_particles_has_none_to_record():
    sim = ga.Simulation(preset({"a": {"emitters": {"e": {"rate": 10, "start": 0.5}}}}))
    with pytest.raises(ga.UsageError, match="system 'a' has no particles yet whose position could be recorded"):
        sim.record(what=["a.position"])
    assert sim.record(what=["a.count"])["a.count"].tolist() == [0]


@pytest.mark.parametrize("package,call", [
    ("pandas", lambda record: record.to_pandas()), ("pyarrow", lambda record: record.save("h.parquet")),
    ("zarr", lambda record: record.save("h.zarr")), ("pyarrow", lambda record: galaxy().record(to="h.parquet")),
])  # fmt: skip
def test_a_missing_package_is_named_with_the_extra_that_brings_it(package, call, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ga.UsageError, match=rf"needs the package {package}, .* pip install 'gen-art\[histories\]'"):
        call(galaxy().record())
    assert not list(Path().iterdir())


def test_a_table_that_is_too_wide_is_refused_before_it_runs(tmp_path, monkeypatch):
    x = np.zeros((4000, 3))
    sim = ga.Simulation({"s": ga.ParticleSystem(position=x)}, dt=0.01)
    record = sim.record(what=["s.position"])
    for package in ("pandas", "pyarrow"):
        monkeypatch.setitem(sys.modules, package, np)  # whether or not it is there
    with pytest.raises(ga.UsageError, match="a table of this record has 12,001 columns"):
        record.to_pandas()
    with pytest.raises(ga.UsageError, match="10,000 are the most"):
        sim.record(what=["s.position"], to=tmp_path / "h.parquet")
    assert not list(tmp_path.iterdir())
