"""Presets: the validated description of what to render, read from YAML or a mapping.

Submodules load on first use: `values` stands below the forces, `schema` above them.
"""

import importlib

__all__ = ["Curve", "Preset", "Range", "load_preset"]

_HOMES = {"Range": "values", "Curve": "values", "Preset": "schema", "load_preset": "load"}


def __getattr__(name):
    if name in _HOMES:
        return getattr(importlib.import_module(f"gen_art.preset.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'gen_art.preset' has no attribute '{name}'")
