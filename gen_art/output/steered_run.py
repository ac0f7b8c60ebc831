"""A run of a preset that somebody steers: each frame goes by what the hands did at the frame before.

The inputs are rounded as they are written, and move linearly from row to row as a force reads them from a file. The rows lie
half a frame after the frames, and the one after a frame is known when the frame begins. So the film of the recorded tables
has the very motion that was steered.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gen_art.errors import UsageError
from gen_art.forces.steering import Hands
from gen_art.output.input_tables import InputTable, input_tables, with_tables
from gen_art.output.playback import Playback
from gen_art.renderer.following import followed

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset
    from gen_art.renderer.camera import CameraView

__all__ = ["Device", "SteeredRun"]

ARROWS = {"ArrowLeft": (-1, 0), "ArrowRight": (1, 0), "ArrowUp": (0, -1), "ArrowDown": (0, 1)}
POINTER_SPEED = 0.6  # heights of the picture each second, by the arrow keys


@dataclass(frozen=True)
class Device:
    """What the page says of keyboard, mouse and gamepad.

    held : by key, how far it is pressed, 0 to 1
    pointer : (across, down) in the picture, 0 to 1, where the mouse has moved it since the last time; else None
    """

    held: Mapping[str, float]
    pointer: tuple[float, float] | None = None


class SteeredRun:
    """The frames of a preset, one after the other.

    size : (width, height) of the pictures
    precision, threads : as for Simulation
    Raises UsageError if the preset has nothing to steer.
    """

    def __init__(self, preset: "Preset", size: tuple[int, int], precision: str = "f32", threads: int | None = None):
        clock = preset.clock
        self.preset, self.frame, self.frames = preset, 0, clock.frames
        self.tables: list[InputTable] = input_tables(preset)
        if not self.tables:
            raise UsageError(
                "nothing in this preset can be steered: give a system one of the forces hand, attractor, thruster, aircraft, "
                "propeller or ballast"
            )
        self._distance = clock.steps_per_frame * clock.step
        for table in self.tables:
            table.begin((clock.preroll_steps + 0.5 * clock.steps_per_frame) * clock.step, self._distance)
        self._precision, self._threads = precision, threads
        self.playback = Playback(with_tables(preset, self.tables), size, precision, threads)
        self.sim = self.playback.sim
        self._pointer: tuple[float, float] | None = None
        taken = {
            key for table in self.tables for device in table.devices.values() for key in (*device.less, *device.more)
        }
        self._arrows_point = any(table.points for table in self.tables) and not taken & set(ARROWS)
        self.steered = next(
            name for name, spec in preset.systems.items()
            if any(force in (*preset.forces, *spec.forces) for force in self.tables[0].forces)
        )  # fmt: skip

    @property
    def is_done(self) -> bool:
        """Whether the last frame of the film is reached."""
        return self.frame >= self.frames - 1

    def resize(self, size: tuple[int, int]) -> None:
        """Draw in another size from now on; trails, ribbons and flashes begin anew."""
        self.playback = Playback(self.playback.preset, size, self._precision, self._threads, sim=self.sim)

    def advance(self, device: Device) -> None:
        """Go on to the next frame with what the hands do now."""
        hands, seconds = self._hands(device), 1.0 / self.preset.clock.fps
        for table in self.tables:
            table.extend(hands, seconds)
        for name, system in self.sim.members.items():
            system.composition.place_tables(self.sim.stepper(name).numbers)
        self.frame += 1

    def picture(self) -> np.ndarray:
        """(height, width, 3) uint8, of the present frame; the particles move to it."""
        clock = self.preset.clock
        linear, exposure = next(self.playback.pictures([clock.preroll_steps + self.frame * clock.steps_per_frame]))
        return self.playback.developed(linear, exposure, self.frame)[..., :3]

    def instruments(self) -> dict[str, Any]:
        """What a pilot reads: the inputs, and how what is steered moves on the average.

        speed and climb are in m/s, height in m, heading in degrees: 0 along x, growing to the right as seen from above.
        """
        inputs = [
            {
                "name": name, "value": value, "unit": table.kind.input_units()[name],
                "low": getattr(table.devices[name], "low", None), "high": getattr(table.devices[name], "high", None),
                "less": table.devices[name].less, "more": table.devices[name].more,
                "kind": type(table.devices[name]).__name__.lower(),
            }
            for table in self.tables
            for name, value in zip(table.rest, table.rows[-1][1:])
        ]  # fmt: skip
        found: dict[str, Any] = {"of": self.steered, "inputs": inputs}
        if (subject := followed(self.sim, self.steered)) is not None:
            found |= {
                "speed": float(np.linalg.norm(subject.velocity)), "height": float(subject.position[1]),
                "climb": float(subject.velocity[1]), "heading": math.degrees(subject.heading),
            }  # fmt: skip
        return found

    def _hands(self, device: Device) -> Hands:
        if device.pointer is not None:
            self._pointer = device.pointer
        width, height = self.playback.painter.shown_size
        if self._arrows_point:
            across, down = (
                sum(device.held.get(key, 0.0) * way[axis] for key, way in ARROWS.items()) for axis in (0, 1)
            )
            if across or down:
                u, v = self._pointer or (0.5, 0.5)
                far = POINTER_SPEED / self.preset.clock.fps
                u, v = u + across * far * height / width, v + down * far
                self._pointer = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
        point = None
        if self._pointer is not None:
            rest = next((table.rest for table in self.tables if table.points), {})
            anchor = np.array([rest.get(name, 0.0) for name in "xyz"])
            view = self.playback.painter.view(self.sim, self._film_time())
            point = _point_at(view, self._pointer, width / height, anchor)
        return Hands(device.held, point)

    def _film_time(self) -> float:
        return self.frame / self.preset.clock.fps


def _point_at(view: "CameraView", pointer, aspect: float, anchor: np.ndarray) -> tuple[float, float, float]:
    """The point that is seen at a place of the picture, in the plane through `anchor` that faces the camera."""
    right, up, forward = view.axes
    depth = float((anchor - view.position) @ forward)
    rows = view.height if view.height else 2.0 * math.tan(math.radians(view.fov) / 2) * max(depth, view.near)
    across, above = (pointer[0] - 0.5) * rows * aspect, (0.5 - pointer[1]) * rows
    x, y, z = (view.position + forward * depth + right * across + up * above).tolist()
    return x, y, z
