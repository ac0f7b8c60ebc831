"""All tests share one start of the runtime, and none sees the plugins that another file of tests loaded."""

import os

import pytest

from gen_art import plugins
from gen_art.backend import runtime
from gen_art.emitters.base import EMITTERS, SHAPES, VELOCITIES
from gen_art.forces.base import FORCES
from gen_art.interactions.base import INTERACTIONS
from tests import chromium


@pytest.fixture(scope="session", autouse=True)
def _runtime_of_the_process():
    """Two threads, whatever the machine has; one where tests run side by side, whose threads would wait for each other."""
    runtime.init(threads=1 if "PYTEST_XDIST_WORKER" in os.environ else 2)


@pytest.fixture(scope="module", autouse=True)
def _registries_as_they_were():
    kept = [FORCES.classes, SHAPES.classes, VELOCITIES.classes, EMITTERS.classes, INTERACTIONS.classes, plugins._loaded]
    before = [dict(one) for one in kept]
    yield
    for one, earlier in zip(kept, before):
        one.clear()
        one.update(earlier)


@pytest.fixture(scope="session")
def browser():
    """Chromium, one for the whole process: Playwright cannot be started twice in one."""
    if chromium.PATH is None:
        if os.environ.get("CI"):
            pytest.fail("no Chromium is installed: .ci/run installs it")
        pytest.skip("no Chromium is installed (Debian: apt install chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium.PATH, args=chromium.QUIET)
        yield started
        started.close()
