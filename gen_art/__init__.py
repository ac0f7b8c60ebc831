"""Gen Art: particle systems in which real physics makes the picture."""

import importlib

__version__ = "0.3.0"

# public name -> module that holds it (or None: the name is a module of this package); loaded when first used, so that
# `gen-art --help` does not wait for the compiler
_NAMES = {
    "Camera": "gen_art.renderer.camera",
    "Diagnostics": "gen_art.simulation.diagnostics",
    "Emitter": "gen_art.emitters.base",
    "Force": "gen_art.forces.base",
    "GenArtError": "gen_art.errors",
    "Medium": "gen_art.forces.medium",
    "ParticleSystem": "gen_art.simulation.system",
    "PresetError": "gen_art.errors",
    "Shape": "gen_art.emitters.base",
    "Simulation": "gen_art.simulation.simulation",
    "UsageError": "gen_art.errors",
    "Velocity": "gen_art.emitters.base",
    "adaptive": "gen_art.simulation.adaptive",
    "colliders": None,
    "bodies": "gen_art.simulation.bodies",
    "body": "gen_art.interactions.rigid.body",
    "chain": "gen_art.interactions.spring_nets",
    "cloth": "gen_art.interactions.spring_nets",
    "cos": "gen_art.maths.elementary",
    "emitter": "gen_art.emitters.base",
    "emitters": None,
    "exp": "gen_art.maths.elementary",
    "force": "gen_art.forces.base",
    "forces": None,
    "integrators": None,
    "interactions": None,
    "load_preset": "gen_art.preset",
    "log": "gen_art.maths.elementary",
    "param": "gen_art.registry",
    "power": "gen_art.maths.elementary",
    "render": "gen_art.output.job",
    "render_frame": "gen_art.renderer.painter",
    "rope": "gen_art.interactions.spring_nets",
    "shape": "gen_art.emitters.base",
    "sin": "gen_art.maths.elementary",
    "ti": "gen_art.backend.runtime",
    "velocity": "gen_art.emitters.base",
}

__all__ = ["__version__", *_NAMES]


def __getattr__(name: str):
    if name not in _NAMES:
        raise AttributeError(f"gen_art has no '{name}'")
    module = _NAMES[name]
    value = importlib.import_module(f"gen_art.{name}" if module is None else module)
    value = value if module is None else getattr(value, name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(__all__)
