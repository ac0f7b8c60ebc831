"""Everything that making pictures of a preset refuses, found before a particle is born or a kernel compiled.

`validate`, a dry run and the render jobs all call `check_preset`, so that what `validate` accepts can be rendered.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from gen_art.errors import PresetError, UsageError
from gen_art.particles.storage import Particles
from gen_art.renderer.camera import Camera
from gen_art.renderer.look_tables import LookTables
from gen_art.renderer.painter import check_size
from gen_art.renderer.sprite_image import texels
from gen_art.simulation.coupled_systems import CoupledSystems
from gen_art.simulation.from_preset import system_of

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["check_preset"]

_MOMENTS = 200  # of the film at which the camera is tried, evenly spaced


def check_preset(preset: "Preset") -> None:
    """Raise PresetError for the first part of a preset from which no picture can be made."""
    members = {}
    for name, spec in preset.systems.items():
        with _place(preset, f"systems.{name}"):
            system = members[name] = system_of(preset, name)
            system.name = name
            for interaction in system.interactions:
                interaction.check(system)
        channels = Particles(np.float32, system.attribute_names, (), 16).channels
        for key, look in spec.all_looks.items():
            with _place(preset, f"systems.{name}.{key}"):
                LookTables.of(look, channels, system.entries)
                if look.picture is not None:
                    texels(look.picture.image.place)
    with _place(preset, "systems"):
        CoupledSystems.names(members)
    with _place(preset, "gallery.time"):
        preset.clock.step_at(preset.poster_time)
    if preset.camera is not None:
        with _place(preset, "camera"):
            camera = Camera.from_spec(preset.camera)
            film = np.linspace(0.0, preset.clock.duration, _MOMENTS).tolist() if camera.moves else []
            for time in {preset.poster_time, *film}:
                camera.at(time)
            supersample = preset.camera.supersample
            check_size(tuple(side * supersample for side in preset.camera.size), supersample)


@contextmanager
def _place(preset: "Preset", path: str) -> Iterator[None]:
    try:
        yield
    except PresetError:
        raise
    except UsageError as error:
        raise PresetError(f"{preset.name}: {path}: {error}") from None
