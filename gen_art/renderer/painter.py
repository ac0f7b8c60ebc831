"""One picture of a simulation in linear light, and the pictures of a film with their trails."""

import numpy as np

from gen_art.errors import UsageError
from gen_art.particles.rows import LIFETIME, POSITION, VELOCITY
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera
from gen_art.renderer.direct_splat import FEW, discs, pixels, points
from gen_art.renderer.direct_splat import LARGEST as SCATTERED
from gen_art.renderer.framebuffer import FrameBuffer, Sprites, splat
from gen_art.renderer.look_tables import LookTables, numbers
from gen_art.renderer.ribbons import RibbonHistory
from gen_art.renderer.shading import Columns, shade
from gen_art.renderer.smoke_lighting import add_light
from gen_art.renderer.sprite import DISC, HIDDEN, KINDS, POINT, REACH, STREAK
from gen_art.renderer.supersample import box_averaged

__all__ = ["LARGEST", "Painter", "check_size", "living", "render_frame"]

LARGEST = 16384


def check_size(size, supersample: int = 1) -> tuple[int, int]:
    """(width, height) as whole numbers; UsageError outside 1..16384."""
    try:
        width, height = (int(v) for v in size)
        whole = (width, height) == tuple(size)
    except (TypeError, ValueError):
        whole = False
    if not whole or not (1 <= width <= LARGEST and 1 <= height <= LARGEST):
        if supersample > 1:
            raise UsageError(
                f"with supersample {supersample} the picture would be drawn {size[0]}x{size[1]}; {LARGEST} is the most"
            )
        raise UsageError(f"a picture's size is two whole numbers from 1 to {LARGEST}, not {size!r}")
    return width, height


def living(system, time: float) -> np.ndarray:
    """Slots of the particles that live at simulated time `time`, in order of id."""
    n = int(system.count)
    birth, life = system.birth[:n], np.asarray(system.floats[LIFETIME, :n], dtype=np.float64)
    return np.flatnonzero((birth <= time) & (birth + life > time))


class Painter:
    """Draws the systems of a simulation into a film; keeps the tables and the trails between frames.

    looks : name -> Look or None (not drawn); a system without an entry gets white points of light 1
    size : (width, height)      shutter : simulated seconds the shutter is open
    supersample : the picture is drawn this many times as wide and high, and a pixel is the mean of what it was drawn as
    """

    def __init__(
        self, size, camera: Camera | None = None, looks: dict[str, Look | None] | None = None, shutter: float = 0.0,
        supersample: int = 1,
    ):  # fmt: skip
        self.times = supersample
        self.size = check_size(tuple(side * supersample for side in check_size(size)), supersample)
        self.camera, self.looks, self.shutter = camera, looks or {}, shutter
        self.film = FrameBuffer(self.size)
        self._sprites = Sprites()
        self._columns: dict[str, Columns] = {}
        self._trails: dict[str, FrameBuffer] = {}
        self._shadings: dict[str, LookTables] = {}
        self._plain = Look()
        self._before: dict[str, tuple] = {}
        self.histories = {
            n: RibbonHistory(k.ribbon) for n, k in self.looks.items() if k is not None and k.ribbon is not None
        }

    @property
    def trails(self) -> dict[str, Look]:
        """The looks that leave trails, by system."""
        return {name: look for name, look in self.looks.items() if look is not None and look.trail is not None}

    def paint(self, sim, film_time: float) -> np.ndarray:
        """The picture at film time `film_time` (s) of the simulation as it stands: (height, width, 4), a view that
        the next picture overwrites. Trails are laid under it as `expose_trails` left them.
        """
        self.film.clear()
        for trail in self._trails.values():
            self.film.buffer += trail.buffer
        self.draw(sim, film_time, self.film)
        return self.film.pixels if self.times == 1 else box_averaged(self.film, self.times)

    def draw(self, sim, film_time: float, film: FrameBuffer, recolour=None) -> None:
        """Draw all systems into a film of this painter's size; `recolour`(system, columns) may change what they show."""
        self._draw(sim, list(sim.systems), self.view(sim, film_time), film_time, self.shutter, 1.0, film, recolour)

    def view(self, sim, film_time: float):
        """The camera's view at a film time."""
        return (self.camera or self._framing(sim)).at(film_time)

    def expose_trails(self, sim, film_time: float, exposure: float, shutter: float) -> None:
        """Let the trails fade by `exposure` film seconds, then draw their systems once more.

        shutter : simulated seconds a streak covers. The light of one exposure is weighted so that a particle at rest
        builds up to its own brightness, whatever fps and substeps are.
        """
        for name, look in self.trails.items():
            trail = self._trails.get(name)
            if trail is None:
                trail = self._trails[name] = FrameBuffer(self.size)
            fade = 0.5 ** (exposure / look.trail.half_life)
            trail.buffer *= np.float32(fade)
            strength = (1.0 - fade) * look.trail.strength
            self._draw(sim, [name], self.view(sim, film_time), film_time, shutter, strength, trail)

    def _framing(self, sim) -> Camera:
        points = [s.floats[POSITION, living(s, sim.time)].T for s in sim.systems.values()]
        return Camera.framing(np.concatenate(points) if points else np.zeros((0, 3)), self.size[0] / self.size[1])

    def _shading(self, name: str, system) -> tuple[LookTables, bool]:
        raw = name not in self.looks
        if name not in self._shadings:
            self._shadings[name] = LookTables.of(self._plain if raw else self.looks[name], dict(system.channels))
        return self._shadings[name], raw

    def _draw(self, sim, names, view, film_time, shutter, weight, film: FrameBuffer, recolour=None) -> None:
        drawn: dict[str, tuple] = {}
        lit: dict[str, tuple] = {}
        sprites, looks = self._sprites, {}
        for name in names:
            if self.looks.get(name, self._plain) is not None:
                system, columns = sim.systems[name], self._columns.setdefault(name, Columns())
                shading, raw = self._shading(name, system)
                look = looks[name] = shading.look
                if look.ribbon is not None:
                    continue
                q = numbers(shading, view, self.size, sim.time, film_time, shutter, raw, weight)
                shade(columns, system, shading, q, self._acceleration(name, system, sim.time))
                drawn[name] = system, columns.used
                if look.light is not None and columns.count:
                    lit[name] = look.light, columns.used, columns.lit[: columns.count]
        if lit:
            add_light(lit, drawn, view, view.scale(self.size[1]))
        sprites.clear()
        sprites.layered = any(look.blend != "add" for look in looks.values()) and recolour is None
        for name, look in looks.items():
            if recolour is not None and name in drawn:
                recolour(*drawn[name])
            if look.ribbon is not None and recolour is None:
                self._add_ribbons(sim, name, view, film_time, weight, film)
            elif look.ribbon is None:
                self._add(look, self._columns[name], film)
        splat(sprites, film)

    def _add_ribbons(self, sim, name: str, view, film_time: float, weight: float, film: FrameBuffer) -> None:
        """List every segment of a system's ribbons; without a past there is none."""
        shading, columns = self._shadings[name], self._columns[name]
        for segment in self.histories[name].segments(sim.systems[name], sim.time):
            q = numbers(
                shading,
                view,
                self.size,
                segment.time,
                film_time,
                segment.lapse,
                False,
                weight * segment.light,
                segment.width,
            )
            shade(columns, segment.system, shading, q)
            self._sprites.add(columns, STREAK, film, segment.tail, segment.taper, HIDDEN)

    def remember_velocities(self, sim) -> None:
        """Keep the velocities of the systems that show their acceleration: it is taken from these to the next picture."""
        for name, look in self.looks.items():
            if look is not None and look.goes_by("acceleration"):
                system = sim.systems[name]
                n = int(system.count)
                self._before[name] = (
                    sim.time,
                    np.array(system.id[:n]),
                    np.array(system.floats[VELOCITY, :n], np.float64),
                )

    def _acceleration(self, name: str, system, time: float) -> np.ndarray | None:
        """(n,) m/s^2 since the velocities that are remembered; 0 for what was not there."""
        if name not in self._before or self._before[name][0] == time or not len(self._before[name][1]):
            return None
        then, ids, velocities = self._before[name]
        own = system.id[: int(system.count)]
        slot = np.minimum(np.searchsorted(ids, own), len(ids) - 1)
        change = system.floats[VELOCITY, : len(own)] - velocities[:, slot]
        return np.where(ids[slot] == own, np.linalg.norm(change, axis=0) / abs(time - then), 0.0).astype(np.float32)

    def _add(self, look: Look, columns: Columns, film: FrameBuffer) -> None:
        """Draw a system's small sprites, where they only add light; list the others."""
        sprites, kind, least = self._sprites, KINDS[look.draw], HIDDEN
        if look.picture is not None:
            sprites.add_pictures(columns, look.picture, film)
            return
        if not sprites.layered and kind in (POINT, DISC) and columns.count > FEW:
            largest = float(columns.used[REACH].max())
            least = SCATTERED if largest > 0.0 else 0.0
            dots = pixels if look.draw == "pixel" else points
            (discs if largest > 0.0 else dots)(columns.rows, columns.count, film)
            if largest <= least:
                return
        sprites.add(columns, kind, film, look.tail, look.taper, least)


def render_frame(sim, size=(1280, 720), camera: Camera | None = None) -> np.ndarray:
    """A picture of the simulation as it stands: (height, width, 4) float32, linear premultiplied RGBA.

    A channel's mean is the light inside the frame, at any size of one aspect ratio. Systems without a look are white
    points of light 1; without a camera it is the preset's, or one that frames the particles. Trails and ribbons, which
    need the past, are left out: `gen-art still` has them.
    """
    preset = getattr(sim, "preset", None)
    looks: dict[str, Look | None] = {}
    shutter, film_time = 0.0, float(sim.time)
    if preset is not None:
        looks = {name: system.look.model_copy(update={"trail": None}) if system.look else system.look
                 for name, system in preset.systems.items()}  # fmt: skip
        if camera is None and preset.camera is not None:
            camera = Camera.from_spec(preset.camera)
        clock = preset.clock
        film_time = (float(sim.time) - clock.preroll) / clock.speed
        shutter = (camera.shutter if camera else 180.0) / 360.0 * clock.speed / clock.fps
    return np.array(Painter(size, camera, looks, shutter).paint(sim, film_time))
