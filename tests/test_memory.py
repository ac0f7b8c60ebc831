"""The memory that is left: of the machine, of nested control groups of both versions, and what refuses when it is too little."""

import numpy as np
import pytest

from gen_art.backend.memory import available_memory, out_of_memory
from gen_art.errors import MemoryRefused
from gen_art.particles.storage import Particles

MIB = 2**20


@pytest.fixture
def machine(tmp_path):
    """A folder that looks like the root of a machine with 8 GiB free; returns a function that adds files to it."""

    def write(path: str, text: str):
        file = tmp_path / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return tmp_path

    write("proc/meminfo", "MemTotal: 16777216 kB\nMemAvailable: 8388608 kB\n")
    write("proc/self/cgroup", "")
    return write


def test_without_control_groups_the_machine_s_memory_counts(machine):
    assert available_memory(machine("proc/self/cgroup", "1:cpu:/\n")) == 8192 * MIB


@pytest.mark.parametrize(
    "inner, outer, left", [(512, 4096, 412), (4096, 512, 412), ("max", 512, 412), ("max", "max", 8192)]
)
def test_nested_groups_of_version_2(machine, inner, outer, left):
    """Of the group and of all groups around it, the tightest counts."""
    for folder, limit in (("job/step", inner), ("job", outer)):
        text = limit if limit == "max" else str(limit * MIB)
        machine(f"sys/fs/cgroup/{folder}/memory.max", f"{text}\n")
        machine(f"sys/fs/cgroup/{folder}/memory.current", f"{100 * MIB}\n")
    assert available_memory(machine("proc/self/cgroup", "0::/job/step\n")) == left * MIB


def test_a_group_of_version_1(machine):
    machine("sys/fs/cgroup/memory/box/memory.limit_in_bytes", f"{1024 * MIB}\n")
    machine("sys/fs/cgroup/memory/box/memory.usage_in_bytes", f"{600 * MIB}\n")
    machine("sys/fs/cgroup/memory/box/memory.stat", f"cache 1\ntotal_inactive_file {200 * MIB}\n")
    machine("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n")
    machine("sys/fs/cgroup/memory/memory.usage_in_bytes", "1\n")
    assert available_memory(machine("proc/self/cgroup", "3:cpu:/\n4:memory:/box\n")) == (1024 - 600 + 200) * MIB


def test_inside_a_container_the_group_s_path_may_be_the_host_s(machine):
    machine("sys/fs/cgroup/memory.max", f"{512 * MIB}\n")
    machine("sys/fs/cgroup/memory.current", f"{12 * MIB}\n")
    assert available_memory(machine("proc/self/cgroup", "0::/docker/4711\n")) == 500 * MIB


def test_a_limit_of_the_process(machine, monkeypatch):
    resource = pytest.importorskip("resource")
    monkeypatch.setattr(
        resource, "getrlimit", lambda which: (1024 * MIB, -1) if which == resource.RLIMIT_AS else (-1, -1)
    )
    monkeypatch.setattr("os.sysconf", lambda name: 4096)
    assert available_memory(machine("proc/self/statm", f"{200 * 256} 5 5 5 5 5 0\n")) == 824 * MIB


def test_births_that_do_not_fit_are_refused_while_the_simulation_runs(monkeypatch):
    """Impacts may cause any number of births: the storage asks before it grows."""
    particles = Particles(np.float32, (), (), 1024)
    monkeypatch.setattr("gen_art.particles.storage.available_memory", lambda: 10 * MIB)
    particles.reserve(20_000)
    with pytest.raises(MemoryRefused, match="1,000,000 particles in one system need"):
        particles.reserve(1_000_000)


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (MemoryError(), True),
        (RuntimeError("[host_memory_pool.cpp] Virtual memory allocation (1073741824 B) failed."), True),
        (OSError(12, "Cannot allocate memory"), True),
        (ImportError("x.so: failed to map segment from shared object"), True),
        (RuntimeError("another fault"), False),
    ],
)
def test_what_other_libraries_call_it(error, expected):
    assert out_of_memory(error) is expected
