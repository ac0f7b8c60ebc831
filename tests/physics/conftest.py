"""Physics tests run in one process, with one start of the runtime on two threads."""

import pytest

from gen_art.backend import runtime


@pytest.fixture(scope="session", autouse=True)
def _runtime():
    runtime.init(threads=2)
