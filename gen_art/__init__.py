"""Gen Art: particle systems in which real physics makes the picture."""

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.6.0"

if (
    TYPE_CHECKING
):  # what editors and type checkers read; at run time `__getattr__` below imports a name when it is first used
    from gen_art import colliders as colliders
    from gen_art import emitters as emitters
    from gen_art import forces as forces
    from gen_art import integrators as integrators
    from gen_art import interactions as interactions
    from gen_art.backend.runtime import ti as ti
    from gen_art.emitters.base import Emitter as Emitter
    from gen_art.emitters.base import Shape as Shape
    from gen_art.emitters.base import Velocity as Velocity
    from gen_art.emitters.base import emitter as emitter
    from gen_art.emitters.base import shape as shape
    from gen_art.emitters.base import velocity as velocity
    from gen_art.errors import AdviceWarning as AdviceWarning
    from gen_art.errors import DivergedError as DivergedError
    from gen_art.errors import GenArtError as GenArtError
    from gen_art.errors import PresetError as PresetError
    from gen_art.errors import UsageError as UsageError
    from gen_art.forces.base import Force as Force
    from gen_art.forces.base import force as force
    from gen_art.forces.medium import Medium as Medium
    from gen_art.interactions.base import interaction as interaction
    from gen_art.interactions.pair_law import PairLaw as PairLaw
    from gen_art.interactions.rigid.body import body as body
    from gen_art.interactions.spring_nets import chain as chain
    from gen_art.interactions.spring_nets import cloth as cloth
    from gen_art.interactions.spring_nets import rope as rope
    from gen_art.maths.elementary import cos as cos
    from gen_art.maths.elementary import exp as exp
    from gen_art.maths.elementary import log as log
    from gen_art.maths.elementary import power as power
    from gen_art.maths.elementary import sin as sin
    from gen_art.output.job import render as render
    from gen_art.output.notebook import play as play
    from gen_art.output.script_film import Film as Film
    from gen_art.output.script_film import develop as develop
    from gen_art.output.script_film import still as still
    from gen_art.preset.light import Light as Light
    from gen_art.preset.load import load_preset as load_preset
    from gen_art.preset.look import Look as Look
    from gen_art.preset.sky import Sky as Sky
    from gen_art.preset.surface import Ground as Ground
    from gen_art.preset.surface import SurfaceLook as SurfaceLook
    from gen_art.registry import param as param
    from gen_art.renderer.camera import Camera as Camera
    from gen_art.renderer.render_frame import render_frame as render_frame
    from gen_art.simulation import ParticleSystem as ParticleSystem
    from gen_art.simulation import Simulation as Simulation
    from gen_art.simulation.adaptive import adaptive as adaptive
    from gen_art.simulation.bodies import bodies as bodies
    from gen_art.simulation.diagnostics import Diagnostics as Diagnostics
    from gen_art.simulation.orbit import orbital_elements as orbital_elements

# public name -> module that holds it; "" : the name is a subpackage. Importing on first use keeps `gen-art --help` from
# waiting for the compiler. A test holds this table and the imports above together.
_NAMES = {
    "AdviceWarning": "gen_art.errors",
    "Camera": "gen_art.renderer.camera",
    "Diagnostics": "gen_art.simulation.diagnostics",
    "DivergedError": "gen_art.errors",
    "Emitter": "gen_art.emitters.base",
    "Film": "gen_art.output.script_film",
    "Force": "gen_art.forces.base",
    "GenArtError": "gen_art.errors",
    "Ground": "gen_art.preset.surface",
    "Light": "gen_art.preset.light",
    "Look": "gen_art.preset.look",
    "Medium": "gen_art.forces.medium",
    "PairLaw": "gen_art.interactions.pair_law",
    "ParticleSystem": "gen_art.simulation",
    "PresetError": "gen_art.errors",
    "Shape": "gen_art.emitters.base",
    "Simulation": "gen_art.simulation",
    "Sky": "gen_art.preset.sky",
    "SurfaceLook": "gen_art.preset.surface",
    "UsageError": "gen_art.errors",
    "Velocity": "gen_art.emitters.base",
    "adaptive": "gen_art.simulation.adaptive",
    "bodies": "gen_art.simulation.bodies",
    "body": "gen_art.interactions.rigid.body",
    "chain": "gen_art.interactions.spring_nets",
    "cloth": "gen_art.interactions.spring_nets",
    "colliders": "",
    "cos": "gen_art.maths.elementary",
    "develop": "gen_art.output.script_film",
    "emitter": "gen_art.emitters.base",
    "emitters": "",
    "exp": "gen_art.maths.elementary",
    "force": "gen_art.forces.base",
    "forces": "",
    "integrators": "",
    "interaction": "gen_art.interactions.base",
    "interactions": "",
    "load_preset": "gen_art.preset.load",
    "log": "gen_art.maths.elementary",
    "orbital_elements": "gen_art.simulation.orbit",
    "param": "gen_art.registry",
    "play": "gen_art.output.notebook",
    "power": "gen_art.maths.elementary",
    "render": "gen_art.output.job",
    "render_frame": "gen_art.renderer.render_frame",
    "rope": "gen_art.interactions.spring_nets",
    "shape": "gen_art.emitters.base",
    "sin": "gen_art.maths.elementary",
    "still": "gen_art.output.script_film",
    "ti": "gen_art.backend.runtime",
    "velocity": "gen_art.emitters.base",
}

__all__ = [
    "AdviceWarning", "Camera", "Diagnostics", "DivergedError", "Emitter", "Film", "Force", "GenArtError", "Ground",
    "Light", "Look", "Medium", "PairLaw", "ParticleSystem", "PresetError", "Shape", "Simulation", "Sky", "SurfaceLook",
    "UsageError", "Velocity", "__version__", "adaptive", "bodies", "body", "chain", "cloth", "colliders", "cos",
    "develop", "emitter", "emitters", "exp", "force", "forces", "integrators", "interaction", "interactions", "load_preset",
    "log", "orbital_elements", "param", "play", "power", "render", "render_frame", "rope", "shape", "sin", "still", "ti",
    "velocity",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _NAMES:
        raise AttributeError(f"gen_art has no '{name}'")
    module = _NAMES[name]
    value = getattr(importlib.import_module(module), name) if module else importlib.import_module(f"gen_art.{name}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
