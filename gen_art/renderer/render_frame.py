"""Pictures of a simulation that a script advances: the painter with what the script says, and one picture in linear light."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art.arguments import shown
from gen_art.errors import UsageError
from gen_art.preset.from_script import model_of
from gen_art.preset.light import Light
from gen_art.preset.look import Look
from gen_art.preset.sky import Sky
from gen_art.preset.surface import Ground, ground_of
from gen_art.registry import suggest
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter, check_size
from gen_art.renderer.sky import SkyDome
from gen_art.renderer.surfaces.scene import Scene

if TYPE_CHECKING:
    from gen_art.simulation import Simulation

__all__ = ["film_time_of", "painter_of", "render_frame", "shutter_of"]


def painter_of(
    sim: "Simulation", size: tuple[int, int], camera: Camera | None = None,
    looks: "Mapping[str, Look | Mapping[str, Any] | None] | None" = None, sky: Sky | None = None,
    light: "Light | Mapping[str, Any] | None" = None,
    ground: "Ground | Mapping[str, Any] | str | bool | None" = None, transparent: bool = False,
) -> Painter:  # fmt: skip
    """The painter of a simulation's pictures, whose shutter is closed; the arguments are those of `render_frame`.

    looks : by system, in place of its own look; None leaves the system out
    transparent : leaves out the sky
    """
    if not hasattr(sim, "members"):
        raise UsageError(f"a picture is drawn of a ga.Simulation, not {shown(sim)}")
    if camera is not None and not isinstance(camera, Camera):
        raise UsageError(f"camera must be a ga.Camera, such as ga.Camera(position=(0, 0, 5)), not {shown(camera)}")
    if sky is not None and not isinstance(sky, Sky):
        raise UsageError(f"sky must be a ga.Sky, such as ga.Sky(sun=30), not {shown(sky)}")
    preset = sim.preset
    drawn: dict[str, Look | None] = {n: system.look for n, system in sim.members.items() if system.look is not None}
    if preset is not None:
        drawn = preset.looks
    drawn = {**drawn, **_given_looks(sim, drawn, looks)}
    if preset is not None:
        if camera is None and preset.camera is not None:
            from gen_art.renderer.fitting import fit_of  # which surveys a film with this module's `living`

            camera = Camera.from_spec(preset.camera, fit_of(preset, check_size(size), sim.precision))
        sky = preset.sky if sky is None else sky
    scene = Scene.of(preset, sim.members.values(), None if sky is None else SkyDome.of(sky))
    if light is not None:
        scene = replace(scene, light=model_of(Light, "light", light))
    if ground is not None:
        scene = replace(scene, ground=ground_of(ground))
    return Painter(size, camera, drawn, 0.0, scene=scene, transparent=transparent)


def _given_looks(sim: "Simulation", drawn: Mapping[str, Look | None], looks: Any) -> dict[str, Look | None]:
    if looks is None:
        return {}
    if not isinstance(looks, Mapping):
        raise UsageError(f"looks must be a mapping of systems to their looks, not {shown(looks)}")
    names = [*sim.members, *(name for name in drawn if name not in sim.members)]
    for name in looks:
        if name not in names:
            raise UsageError(
                f"looks: there is no system {shown(name)}{suggest(name, names)}; there are {', '.join(names)}"
            )
    return {name: model_of(Look, f"looks.{name}", look) for name, look in looks.items()}


def film_time_of(sim: "Simulation") -> float:
    """The film time of a simulation's state, s; its own time where it is of no preset."""
    if sim.preset is None:
        return float(sim.time)
    return (float(sim.time) - sim.preset.clock.preroll) / sim.preset.clock.speed


def shutter_of(sim: "Simulation", camera: Camera | None) -> float:
    """Simulated seconds for which the shutter is open in a film of the simulation's preset; 0 without one."""
    if sim.preset is None:
        return 0.0
    return (camera.shutter if camera else 180.0) / 360.0 * sim.preset.clock.speed / sim.preset.clock.fps


def render_frame(
    sim: "Simulation",
    size: tuple[int, int] = (1280, 720),
    camera: Camera | None = None,
    sky: Sky | None = None,
    light: "Light | Mapping[str, Any] | None" = None,
    ground: "Ground | Mapping[str, Any] | str | bool | None" = None,
    looks: "Mapping[str, Look | Mapping[str, Any] | None] | None" = None,
) -> np.ndarray:
    """A picture of the simulation's current state: (height, width, 4) float32, linear premultiplied RGBA.

    A channel's mean is the light inside the frame; it is the same at any size of one aspect ratio. A ParticleSystem is drawn
    by its `look`, and as white points of light 1 where it has none. Without a camera the preset's is used, or one that frames
    the particles. Trails and ribbons, which need earlier states, are left out: ga.Film and `gen-art still` draw them.

    sky : a ga.Sky; the preset's when None. With a sky, alpha is 1
    light, ground : a ga.Light and a ga.Ground, or mappings of their keys as in YAML; the preset's when None
    looks : by system, a ga.Look or a mapping of its keys in place of the system's own; None leaves the system out
    """
    painter = painter_of(sim, size, camera, looks, sky, light, ground)
    painter.looks = {name: look and look.model_copy(update={"trail": None}) for name, look in painter.looks.items()}
    painter.shutter = shutter_of(sim, painter.camera)
    return np.array(painter.paint(sim, film_time_of(sim)))
