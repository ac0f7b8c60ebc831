import pytest

from gen_art.backend import runtime


@pytest.fixture(autouse=True, scope="session")
def taichi():
    runtime.init("cpu")
