"""What a Dask worker does for a sweep beside its tasks: it leaves Ctrl+C to the command, and keeps its compiled kernels."""

import signal
import sys
from concurrent.futures import TimeoutError as TooLate
from contextlib import suppress
from typing import Any

from distributed import WorkerPlugin

from gen_art.output.farm_logs import silence

__all__ = ["FarmWorker"]

_PATIENCE = 3.0  # seconds for which a worker that ends waits for its unit; Dask kills it after four


class FarmWorker(WorkerPlugin):
    """Set up when the worker joins a sweep, and torn down when it ends.

    own : the sweep has started this worker, in its terminal: it logs nothing, and leaves Ctrl+C to the command
    """

    name = "gen-art"
    idempotent = True

    def __init__(self, own: bool):
        self.own = own

    def setup(self, worker: Any) -> None:
        """A terminal sends Ctrl+C to all its processes; the command then closes its workers."""
        if self.own:
            silence()
            with suppress(ValueError):  # the worker does not run in the main thread of its process
                signal.signal(signal.SIGINT, signal.SIG_IGN)

    def teardown(self, worker: Any) -> None:
        """Store the compiled kernels, in the thread that ran them."""
        with suppress(TooLate, RuntimeError):
            worker.executors["default"].submit(_finish).result(_PATIENCE)


def _finish() -> None:
    if "gen_art.backend.runtime" in sys.modules:
        sys.modules["gen_art.backend.runtime"].finish()
