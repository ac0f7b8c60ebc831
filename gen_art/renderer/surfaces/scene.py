"""What lights a picture and what stands in it: the lamp and the sky, the ground, and the colliders that are drawn."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from gen_art.colliders.base import Collider
from gen_art.colliders.plane import Plane
from gen_art.preset.light import KeyLight
from gen_art.preset.surface import Ground, SurfaceLook, surface_look

__all__ = ["Scene"]


@dataclass(frozen=True)
class Scene:
    """What lights a picture and what stands in it.

    light : the lamp and the sky; a default one where surfaces are drawn without it
    ground : the floor, or None
    shadows : whether things shadow each other
    colliders : of all systems; those with a look are drawn
    """

    light: KeyLight | None = None
    ground: Ground | None = None
    shadows: bool = True
    colliders: tuple[Collider, ...] = ()

    @classmethod
    def of(cls, preset, systems: Iterable) -> "Scene":
        """The scene of a preset and its ParticleSystems; without a preset, of their colliders alone."""
        colliders = tuple(collider for system in systems for collider in system.colliders)
        if preset is None:
            return cls(colliders=colliders)
        return cls(preset.light, preset.ground, preset.shadows, colliders)

    @cached_property
    def surfaces(self) -> list[tuple[Collider, SurfaceLook]]:
        """(collider, look) of the ground and of each collider with a look."""
        found: list[tuple[Collider, SurfaceLook]] = []
        if self.ground is not None:
            found.append((Plane(point=(0.0, self.ground.height, 0.0)), self.ground))
        for collider in dict.fromkeys(self.colliders):  # systems may share colliders
            look = surface_look(collider.values["look"])
            if look is not None:
                found.append((collider, look))
        return found
