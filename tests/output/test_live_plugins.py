"""Plugins that are saved again: what is registered and what kernels are made of is what the file says now."""

import numpy as np
import pytest

import gen_art as ga
from gen_art import plugins
from gen_art.errors import OutputError, UsageError
from gen_art.forces.base import FORCES
from gen_art.output.live_plugins import LivePlugins

PUSH = '''
import gen_art as ga
from gen_art import ti
{above}
@ga.force("{name}")
class {cls}(ga.Force):
    """A push along x. a = {size} strength."""

    strength: float = ga.param(1.0, unit="m/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        return ti.Vector([{size} * q.strength, 0.0, 0.0])
'''


def text(size="1.0", name="test_push", cls="Push", above=""):
    return PUSH.format(size=size, name=name, cls=cls, above=above)


@pytest.fixture(autouse=True)
def _nothing_registered(monkeypatch):
    """Each test begins without the plugins of the one before."""
    monkeypatch.setattr(FORCES, "classes", dict(FORCES.classes))
    monkeypatch.setattr(plugins, "_loaded", {})


@pytest.fixture
def plugin(tmp_path):
    path = tmp_path / "push.py"
    path.write_text(text(), encoding="utf-8")
    return path


def acceleration(name="test_push") -> float:
    """Of the registered force, from one step: the kernel is compiled from the source that is kept of it."""
    system = ga.ParticleSystem(position=np.zeros((1, 3)), forces=[FORCES[name]()], integrator="semi_implicit_euler")
    sim = ga.Simulation({"s": system}, dt=0.5, precision="f64")
    sim.step(1)
    return float(sim["s"].velocity[0, 0] / 0.5)


def test_a_saved_plugin_replaces_its_class_and_its_kernel(plugin):
    """Also where lines moved, and where the text is that of before: neither the source nor the class of another text is used."""
    live = LivePlugins([plugin])
    (first,) = live.load()
    assert acceleration() == 1.0
    for size, above in (("3.0", ""), ("-2.0", "\n\nHALF = 0.5\n"), ("1.0", "")):
        plugin.write_text(text(size, above=above), encoding="utf-8")
        (second,) = live.load()
        assert second.name == "push.py" and (second.sha256 == first.sha256) == (size == "1.0")
        assert acceleration() == float(size)


def test_an_unchanged_plugin_keeps_its_class(plugin):
    live = LivePlugins([plugin])
    loaded, cls = live.load(), FORCES["test_push"]
    plugin.write_text(text(), encoding="utf-8")
    assert live.load() is loaded and FORCES["test_push"] is cls


def test_what_a_plugin_no_longer_registers_is_gone(plugin):
    live = LivePlugins([plugin])
    live.load()
    plugin.write_text(text("4.0", cls="Renamed"), encoding="utf-8")
    live.load()
    assert acceleration() == 4.0
    plugin.write_text(text("5.0", name="test_other"), encoding="utf-8")
    live.load()
    assert "test_push" not in FORCES and acceleration("test_other") == 5.0 and "gravity" in FORCES


def test_a_plugin_with_an_error_registers_nothing_until_it_is_mended(plugin):
    live = LivePlugins([plugin])
    live.load()
    for wrong in (text("2.0") + "\n1 / 0\n", text("2.0") + "\ndef (\n"):
        plugin.write_text(wrong, encoding="utf-8")
        for _ in range(2):  # the error stays while the text does
            with pytest.raises(UsageError, match=r"push\.py:\d+: (ZeroDivisionError|SyntaxError)"):
                live.load()
            assert "test_push" not in FORCES
    plugin.unlink()
    with pytest.raises(OutputError):
        live.load()
    plugin.write_text(text(), encoding="utf-8")
    live.load()
    assert acceleration() == 1.0


def test_the_source_that_ran_is_compiled_although_the_file_was_saved_since(plugin):
    """A kernel is made when it first runs; the file may then have other lines."""
    live = LivePlugins([plugin])
    live.load()
    plugin.write_text(text("7.0", above="\n# a line more\n"), encoding="utf-8")
    assert acceleration() == 1.0


def test_one_of_two_plugins(plugin, tmp_path):
    other = tmp_path / "other.py"
    other.write_text(text("6.0", name="test_other", cls="Other"), encoding="utf-8")
    live = LivePlugins([plugin, other])
    live.load()
    other.write_text(text("8.0", name="test_other", cls="Other"), encoding="utf-8")
    assert [p.name for p in live.load()] == ["push.py", "other.py"]
    assert (acceleration(), acceleration("test_other")) == (1.0, 8.0)
