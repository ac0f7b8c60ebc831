"""What editors and type checkers see of `import gen_art as ga`."""

import ast
import dataclasses
import inspect
import re
import subprocess
import sys
import types
from pathlib import Path

import pytest

import gen_art as ga

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = """
import numpy as np
import gen_art as ga
from gen_art import ti


@ga.force("swirl_of_types")
class Swirl(ga.Force):
    \"\"\"A push around the y axis.\"\"\"

    strength: float = ga.param(1.0, unit="1/s^2")

    @ti.func
    def acceleration(self, p, t, q):
        return q.strength * ti.Vector([-p.position.z, 0.0, p.position.x])


stars = ga.ParticleSystem(
    position=[[1, 0, 0], [-1, 0, 0]],
    velocity=np.zeros((2, 3)),
    mass=[1, 1],
    forces=[ga.forces.Gravity((0, -9.81, 0)), Swirl(strength=2.0)],
    interactions=[ga.interactions.SelfGravity(G=1.0)],
    colliders=[ga.colliders.Plane(point=(0, -5, 0))],
    look=ga.Look(draw="point"),
)
sim = ga.Simulation({"stars": stars}, dt=1e-3, precision="f64", ledger=True)
sim.advance(0.01)
energy: float = sim.diagnostics().energy
momentum: np.ndarray = sim.diagnostics().momentum
residual: float = sim.ledger().residual
where: np.ndarray = sim["stars"].position
linear: np.ndarray = ga.render_frame(sim, size=(64, 36), camera=ga.Camera(position=(0, 0, 5)))
preset = ga.load_preset("fire", overrides={"seed": 3})
seconds: float = preset.clock.duration
again: ga.Simulation = ga.Simulation(preset)
names: list[str] = [path.name for path in ga.render(preset, "fire.mp4", frames=range(2), size=(64, 36))]
"""
WRONG = (
    SCRIPT.replace("dt=1e-3", 'dt="soon"')
    .replace("energy: float", "energy: str")
    .replace("advance(0.01)", "advanse(1)")
)


def checked(tool: list[str], text: str, folder: Path) -> tuple[int, str]:
    script = folder / "script.py"
    script.write_text(text)
    done = subprocess.run(
        [sys.executable, "-m", *tool, str(script)], capture_output=True, text=True, cwd=folder, env={**_environment()}
    )
    return done.returncode, done.stdout + done.stderr


def _environment() -> dict[str, str]:
    import os

    return {**os.environ, "MYPYPATH": str(ROOT), "PYTHONPATH": str(ROOT)}


@pytest.mark.parametrize(
    "tool",
    [["mypy", "--follow-imports=silent"], ["basedpyright", "--level", "error", "--pythonpath", sys.executable]],
    ids=lambda tool: tool[0],
)
def test_a_user_s_script_is_type_checked(tool, tmp_path):
    (tmp_path / "pyrightconfig.json").write_text(f'{{"typeCheckingMode": "standard", "extraPaths": ["{ROOT}"]}}')
    status, words = checked(tool, SCRIPT, tmp_path)
    assert status == 0, words
    status, words = checked(tool, WRONG, tmp_path)
    assert status == 1
    assert len(re.findall(r"error[: ]", words)) >= 3 and "advanse" in words, words


def test_the_imports_for_type_checkers_are_the_names():
    """The table of lazy names, `__all__` and the TYPE_CHECKING block hold the same."""
    tree = ast.parse((ROOT / "gen_art" / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {alias.asname: node.module for node in block.body for alias in node.names}
    assert set(imported) == set(ga._NAMES) == set(ga.__all__) - {"__version__"}
    for name, module in ga._NAMES.items():
        assert imported[name] == (module or "gen_art"), name
    assert (ROOT / "gen_art" / "py.typed").is_file()


def public_functions():
    for name in ga._NAMES:
        thing = getattr(ga, name)
        if isinstance(thing, type):
            for key, member in vars(thing).items():
                function = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
                generated = key == "__init__" and dataclasses.is_dataclass(thing)
                if (
                    isinstance(function, types.FunctionType)
                    and not generated
                    and (key == "__init__" or not key.startswith("_"))
                ):
                    yield f"{name}.{key}", function
        elif (
            isinstance(thing, types.FunctionType) and thing.__module__ != "gen_art.maths.elementary"
        ):  # kernels' functions
            yield name, thing


@pytest.mark.parametrize("name, function", public_functions(), ids=lambda x: x if isinstance(x, str) else "")
def test_public_functions_are_annotated(name, function):
    signature = inspect.signature(function)
    missing = [
        p.name for p in signature.parameters.values() if p.annotation is p.empty and p.name not in ("self", "cls")
    ]
    assert not missing and signature.return_annotation is not signature.empty, missing
