"""Loops of kernels are shared among threads: each piece is done once, whoever does it, and a caller never waits for itself."""

import ctypes
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from gen_art.backend import loop_sharing, runtime

if runtime.STOCK_TAICHI:
    pytest.skip("Taichi shares the loops", allow_module_level=True)

from gen_art.backend import machine_code

PATIENCE = 0.001  # s of work, many times what makes a caller wake others
LONG = 60.0  # s; longer than any of these tests needs on any machine

PIECE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32)
RUN = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p, PIECE)


@pytest.fixture(autouse=True)
def _machine_code():
    runtime.init()
    if not machine_code.available():
        pytest.skip("Taichi shares the loops")


@contextmanager
def team(workers: int):
    """With some workers of its own: a function (pieces, piece) that runs a loop, and one that says how many were shared."""
    code = machine_code.assemble(Path(loop_sharing.__file__).with_suffix(".ll").read_text())
    run, help_, stop, number, loops = machine_code.link(code, ["run", "help", "stop", "workers", "loops"])
    ctypes.c_int32.from_address(number).value = workers
    live = ctypes.CFUNCTYPE(None, ctypes.c_int32)(help_)
    threads = [threading.Thread(target=live, args=(k + 1,), daemon=True) for k in range(workers)]
    for thread in threads:
        thread.start()

    def loop(pieces, piece):
        RUN(run)(None, pieces, 0, None, piece if isinstance(piece, PIECE) else PIECE(lambda _, *which: piece(*which)))

    try:
        yield loop, lambda: ctypes.c_int32.from_address(loops).value
    finally:
        ctypes.CFUNCTYPE(None)(stop)()
        for thread in threads:
            thread.join(LONG)
            assert not thread.is_alive()


@pytest.mark.parametrize("workers", [0, 1, 3])
@pytest.mark.parametrize("pieces", [0, 1, 2, 300])
def test_each_piece_is_done_once(workers, pieces):
    done = []

    def piece(thread, k):
        if k == 0:
            time.sleep(PATIENCE)
        done.append((k, thread))

    with team(workers) as (loop, _):
        for _ in range(5):
            loop(pieces, piece)
            assert sorted(k for k, _ in done) == list(range(pieces))
            assert {thread for _, thread in done} <= set(range(workers + 1))
            done.clear()


def test_a_lone_piece_wakes_nobody():
    with team(1) as (loop, count):
        loop(1, lambda *_: time.sleep(PATIENCE))
        assert count() == 0


def test_short_loops_wake_nobody():
    """But for those during which the operating system takes the processor away."""
    nothing = ctypes.cast(ctypes.CDLL(None).labs, PIECE)
    with team(1) as (loop, count):
        for _ in range(1000):
            loop(3, nothing)
        assert count() < 100
        loop(3, lambda *_: time.sleep(PATIENCE))
        assert count() >= 1


def test_workers_help_with_a_long_loop():
    """Pieces that wait for each other: they end only if each is in a thread of its own."""
    together, threads = threading.Barrier(3), []

    def piece(thread, k):
        if k == 0:
            time.sleep(PATIENCE)
        else:
            together.wait(LONG)
            threads.append(thread)

    with team(2) as (loop, _):
        for _ in range(20):
            loop(4, piece)
            assert sorted(threads) == [0, 1, 2]
            threads.clear()


def test_the_caller_waits_for_the_last_piece():
    """Also for one that takes so long that the caller falls asleep."""
    begun, ended = threading.Event(), []

    def piece(thread, k):
        if thread == 0:
            time.sleep(PATIENCE)
            if k > 0:
                begun.wait(LONG)
        else:
            begun.set()
            time.sleep(200 * PATIENCE)
        ended.append((k, thread))

    with team(1) as (loop, _):
        for _ in range(3):
            loop(3, piece)
            assert sorted(k for k, _ in ended) == [0, 1, 2]
            assert {thread for _, thread in ended} == {0, 1}
            ended.clear()
            begun.clear()


def test_a_loop_of_two_long_pieces_is_shared_from_the_second_time_on():
    """The first time, nobody knows before the first piece has ended that the loop is a long one."""
    together, work = threading.Barrier(2), [lambda: time.sleep(PATIENCE)]
    piece = PIECE(lambda *_: work[0]())  # one and the same: what took long is known by its address and number of pieces
    with team(1) as (loop, count):
        loop(2, piece)
        assert count() == 0
        work[0] = lambda: (together.wait(LONG), time.sleep(PATIENCE))  # still a long one
        for k in range(3):
            loop(2, piece)
            assert count() == k + 1 and not together.broken


def test_a_second_caller_does_its_loop_alone():
    begun, ended, first, second = threading.Event(), threading.Event(), [], []

    def of_first(thread, k):
        if k == 0:
            time.sleep(PATIENCE)
        else:
            begun.set()
            assert ended.wait(LONG)
        first.append(k)

    def of_second(thread, k):
        time.sleep(PATIENCE)
        second.append((k, threading.get_ident()))

    with team(1) as (loop, _):
        caller = threading.Thread(target=loop, args=(9, of_first))
        caller.start()
        assert begun.wait(LONG)
        loop(5, of_second)
        ended.set()
        caller.join(LONG)
        assert not caller.is_alive()
    assert second == [(k, threading.get_ident()) for k in range(5)]
    assert sorted(first) == list(range(9))


KERNELS = """
import threading

import numpy as np

begun, ended = threading.Event(), threading.Event()
def older():
    begun.wait()
    halve(tiny_of_older)
    ended.set()
thread = threading.Thread(target=older, daemon=True)  # it is older than Taichi, which lets its thread round tiny numbers to 0
thread.start()

from gen_art.backend import loop_sharing, machine_code, runtime
from gen_art.backend.runtime import ti

runtime.init(threads=2)
place = loop_sharing.ctypes.c_void_p.from_address(machine_code.runtime_address() + loop_sharing._SHARES_OUT)
assert not loop_sharing._is_taichi(place.value), "Taichi shares the loops"

@ti.kernel
def add(x: ti.types.ndarray(ti.f32, 2)):
    ti.loop_config(block_dim=1)
    for k in range(x.shape[0]):
        for _ in range(40):
            for i in range(x.shape[1]):
                x[k, i] += 1.0

@ti.kernel
def halve_all(x: ti.types.ndarray(ti.f32, 2)):
    ti.loop_config(block_dim=1)
    for k in range(x.shape[0]):
        for i in range(x.shape[1]):
            x[k, i] *= 0.5

kernel, x = runtime.kernel(add), np.zeros((16, 500), np.float32)
for _ in range(2000):
    kernel(x)
assert (x == 80000).all(), "a piece was not done once"

halve = runtime.kernel(halve_all)
tiny_of_older, tiny = np.full((64, 20000), 1.5e-38, np.float32), np.full((64, 20000), 1.5e-38, np.float32)
begun.set()
assert ended.wait(60)
halve(tiny)
assert tiny.tobytes() == tiny_of_older.tobytes(), "threads round in different ways"
"""


def test_kernels_do_each_piece_once_and_round_alike_in_all_threads(tmp_path):
    script = tmp_path / "kernels.py"  # Taichi reads the source of kernels from a file
    script.write_text(KERNELS)
    subprocess.run([sys.executable, str(script)], check=True, timeout=10 * LONG)


FORK = """
import os, sys
import gen_art as ga
particles = ga.ParticleSystem(position=[[k, 0.0, 0.0] for k in range(20000)], forces=[ga.forces.Gravity()])
sim = ga.Simulation({"p": particles}, dt=0.01, threads=2)
twin = sim.copy()
twin.step(5)
sim.step(2)
child = os.fork()
if child == 0:
    sim.step(3)
    os._exit(0 if sim.digest() == twin.digest() else 1)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


def test_a_fork_runs_its_loops_alone():
    subprocess.run([sys.executable, "-c", FORK], check=True, timeout=10 * LONG)


def test_a_function_is_replaced_only_if_it_is_taichis():
    libc = ctypes.CDLL(None)
    assert not loop_sharing._is_taichi(None)
    assert not loop_sharing._is_taichi(ctypes.cast(libc.getpid, ctypes.c_void_p).value)
