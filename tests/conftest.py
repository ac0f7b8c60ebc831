"""All tests of a process share one start of the runtime: two threads, whatever the machine has."""

import pytest

from gen_art import runtime


@pytest.fixture(scope="session", autouse=True)
def _runtime_of_the_process():
    runtime.init(threads=2)
