"""Presets: the validated description of what to render, read from YAML or a mapping.

Submodules load on first use, because the forces import `values`, and `schema` imports the forces.
"""

import importlib

__all__ = ["Curve", "Preset", "Range", "load_preset"]

_MODULES = {"Range": "values", "Curve": "values", "Preset": "schema", "load_preset": "load"}


def __getattr__(name):
    if name in _MODULES:
        return getattr(importlib.import_module(f"gen_art.preset.{_MODULES[name]}"), name)
    raise AttributeError(f"module 'gen_art.preset' has no attribute '{name}'")
