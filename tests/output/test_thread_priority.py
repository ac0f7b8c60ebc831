"""Encoding leaves the priorities of threads as they were."""

import contextlib
import os

import numpy as np
import pytest

from gen_art.output.formats import find_format
from gen_art.output.video import film_writer

pytestmark = pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="policies of threads are read on Linux")


def test_an_av1_film_leaves_threads_at_their_priority(tmp_path):
    """The mutant: without kept_priority the caller is left with SCHED_FIFO where root runs the test."""
    path = tmp_path / "film.mkv"
    writer = film_writer(path, (64, 64), 30, None, find_format(path, codec="av1"))
    for _ in range(8):
        writer.add(np.zeros((64, 64, 3), np.uint8))
        assert os.sched_getscheduler(0) == os.SCHED_OTHER
    writer.close()
    schedulers = set()
    for thread in os.listdir("/proc/self/task"):
        with contextlib.suppress(ProcessLookupError):  # it has ended since
            schedulers.add(os.sched_getscheduler(int(thread)))
    assert schedulers == {os.SCHED_OTHER}
