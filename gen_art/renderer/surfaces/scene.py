"""What lights a picture and what stands in it: the lamp and the sky, the ground, and the colliders that are drawn."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

from gen_art.colliders.base import Collider
from gen_art.colliders.plane import Plane
from gen_art.errors import UsageError
from gen_art.preset.black_hole import BlackHole
from gen_art.preset.light import Light
from gen_art.preset.surface import Ground, SurfaceLook, surface_look
from gen_art.preset.wormhole import Wormhole
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.sky import SkyDome

__all__ = ["Scene"]


@dataclass(frozen=True)
class Scene:
    """What lights a picture and what stands in it.

    light : the keys of `light:`; where surfaces are drawn without it and without a sky, a default one counts
    ground : the floor, or None
    shadows : whether things shadow each other
    colliders : of all systems; those with a look are drawn
    dome : the sky that surrounds it, or None
    bends : what bends its light, or None
    """

    light: Light | None = None
    ground: Ground | None = None
    shadows: bool = True
    colliders: tuple[Collider, ...] = ()
    dome: SkyDome | None = None
    bends: Wormhole | BlackHole | None = None

    @classmethod
    def of(
        cls, preset, systems: Iterable, dome: SkyDome | None = None, shared: Sequence[Collider] | None = None
    ) -> "Scene":
        """The scene of a preset and its ParticleSystems; without a preset, of their colliders alone.

        shared : the preset's colliders as the systems have them, where those were made of an equal preset before
        """
        colliders = tuple(collider for system in systems for collider in system.colliders)
        if preset is None:
            return cls(colliders=colliders, dome=dome)
        everything = (
            *(preset.colliders if shared is None else shared),
            *colliders,
        )  # those of the preset are there even if no system meets them
        return cls(preset.light, preset.ground, preset.shadows, everything, dome, preset.bends)

    @property
    def lit(self) -> bool:
        """Whether the scene has a light of its own, which smoke and balls then scatter."""
        return self.light is not None or self.dome is not None

    @cached_property
    def lighting(self) -> Lighting:
        """The light on all surfaces, and on smoke without a light of its own."""
        return Lighting.of(self.light, self.dome, of_scene=True)

    @property
    def glow(self) -> tuple[str, ...]:
        """The systems whose light falls on all surfaces, and on smoke without a light of its own."""
        return self.light.glow if self.light is not None else ()

    @cached_property
    def surfaces(self) -> list[tuple[Collider, SurfaceLook]]:
        """(collider, look) of the ground and of each collider with a look; those of one kind follow each other."""
        found: list[tuple[Collider, SurfaceLook]] = []
        if self.ground is not None:
            found.append((Plane(point=(0.0, self.ground.height, 0.0)), self.ground))
        for collider in dict.fromkeys(self.colliders):  # systems may share colliders
            look = surface_look(collider.values["look"])
            if look is not None:
                found.append((collider, look))
        kinds = list(dict.fromkeys(collider.fixed for collider, _ in found))
        found.sort(key=lambda surface: kinds.index(surface[0].fixed))
        _check_mirrors(found)
        _check_water(found)
        for collider, look in found:
            if look.transmission > 0.0 and (
                collider.sides > 1 or collider.values.get("inside") or isinstance(collider, Plane)
            ):
                raise UsageError(
                    f"light goes through a solid only, such as a ball or a block, and a {collider.name} here has no other side: "
                    "leave out `transmission`"
                )
        return found

    @cached_property
    def mirror(self) -> int:
        """The index of the surface that reflects the scene, or -1."""
        return next((k for k, (_, look) in enumerate(self.surfaces) if look.mirror), -1)


def _check_water(surfaces) -> None:
    """Raise UsageError for waves and puddles on what is not level."""
    for collider, look in surfaces:
        for key in ("waves", "puddles"):
            if getattr(look, key) is not None and not _is_level(collider):
                raise UsageError(
                    f"`{key}` are for the ground or for a plane that lies level and still, not for this {collider.name}: leave "
                    "them out"
                )


def _is_level(collider: Collider) -> bool:
    values = collider.values
    if not isinstance(collider, Plane) or collider.rotates or any(values["velocity"]):
        return False
    return values["normal"][1] > 0.0 and not (values["normal"][0] or values["normal"][2])


def _check_mirrors(surfaces) -> None:
    """Raise UsageError unless there is one mirror at most, a plane that stands still."""
    mirrors = [collider for collider, look in surfaces if look.mirror]
    if len(mirrors) > 1:
        raise UsageError(
            f"{len(mirrors)} surfaces have `mirror: true`, and a mirror that faces a mirror shows itself without end: leave one"
        )
    for collider in mirrors:
        if not isinstance(collider, Plane):
            raise UsageError(f"only a plane or the ground can be a mirror, not a {collider.name}: leave out `mirror`")
        if collider.moves:
            raise UsageError("a mirror must stand still: leave out the velocity of the plane, or its `mirror`")
