"""Pictures of a simulation in linear light: single ones, and those of a film with their trails."""

import math
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from gen_art.arguments import shown
from gen_art.errors import PresetError, UsageError
from gen_art.particles.rows import POSITION
from gen_art.particles.storage import Particles
from gen_art.preset.disc_shape import Stretch
from gen_art.preset.look import Look
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.curved_streaks import Pieces, cut
from gen_art.renderer.direct_splat import MAX_FOOTPRINT, MIN_PARTICLES, discs, pixels, points
from gen_art.renderer.drawn_particles import particles_of, system_of
from gen_art.renderer.earlier_velocities import EarlierVelocities
from gen_art.renderer.elliptic_splat import ellipses_of_motion, ellipses_of_shapes
from gen_art.renderer.emissive_lighting import EmittedLight
from gen_art.renderer.emitted_light import emitted_light
from gen_art.renderer.flashes import FlashAlbum
from gen_art.renderer.following import followed, living
from gen_art.renderer.framebuffer import FrameBuffer, splat
from gen_art.renderer.legend import DrawnLegend, legend_of
from gen_art.renderer.lens_views import draw_through_lens
from gen_art.renderer.lensing.lensed_view import NO_LENS, BentSpace, LensedView
from gen_art.renderer.lighting import Lighting
from gen_art.renderer.liquid.lamp_map import lamp_map
from gen_art.renderer.liquid.liquid_pass import LiquidPass
from gen_art.renderer.liquid.liquid_system import hiding_particles
from gen_art.renderer.look_tables import SHUTTER, SIZE_MODE, SIZE_VALUE, TIME, LookTables, kernel_numbers
from gen_art.renderer.neighbour_shapes import neighbour_shapes
from gen_art.renderer.neighbour_sums import NeighbourSums
from gen_art.renderer.path_history import MOMENTS, PathHistory
from gen_art.renderer.projected_particles import ProjectedParticles
from gen_art.renderer.ribbon_sprites import add_links
from gen_art.renderer.ribbons import RibbonHistory
from gen_art.renderer.shading import shade
from gen_art.renderer.sky_background import draw_sky
from gen_art.renderer.smoke_lighting import add_scattered_light, lamp_axes, smoke_key
from gen_art.renderer.spacing import NO_SPACING, spacing
from gen_art.renderer.sprite import DISC, FOOTPRINT, HIDDEN, KINDS, POINT
from gen_art.renderer.sprite_buffer import Sprites, streak_ends
from gen_art.renderer.supersample import box_averaged
from gen_art.renderer.surface_systems import SurfaceSystems
from gen_art.renderer.surfaces.hidden_sprites import NOTHING_HIDES, SurfaceDepths, hide_small_sprites
from gen_art.renderer.surfaces.liquid_shadow import NO_LIQUID
from gen_art.renderer.surfaces.mirror_film import NO_MIRROR, MirrorFilm
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.shadow_casters import ShadowCasters
from gen_art.renderer.surfaces.surface_layers import SurfaceLayers
from gen_art.renderer.surfaces.surface_pass import SurfacePass

__all__ = ["MAX_SIDE", "Painter", "check_size", "living"]

MAX_SIDE = 16384


def check_size(size, supersample: int = 1) -> tuple[int, int]:
    """(width, height) as integers. Raises UsageError outside 1..16384."""
    try:
        width, height = (int(v) for v in size)
        integral = (width, height) == tuple(size)
    except (TypeError, ValueError, OverflowError):
        integral = False
    if not integral or not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
        if supersample > 1:
            raise UsageError(
                f"with supersample {supersample} the picture would be drawn {size[0]}x{size[1]}; {MAX_SIDE} is the most"
            )
        raise UsageError(f"a picture's size is two whole numbers from 1 to {MAX_SIDE}, not {shown(size)}")
    return width, height


@dataclass(frozen=True)
class _Shaded:
    """Systems whose particles are shaded.

    drawn : (system, channels) of each
    second : the second images of their particles in bent space, and `bent`, how it bends their light
    stretched : of the systems whose discs are stretched, their ellipses
    curved : of the systems whose streaks bend, the pieces of these
    hidden_by : what hides their sprites
    mirror : the mirror behind which the view lies, or None
    smoke, emitted : the light of smoke and of emitting particles
    """

    looks: dict[str, Look]
    drawn: dict[str, tuple]
    second: dict[str, ProjectedParticles]
    bent: LensedView
    stretched: dict[str, np.ndarray]
    curved: dict[str, Pieces]
    hidden_by: SurfaceDepths
    mirror: tuple | None
    smoke: dict
    emitted: EmittedLight | None


class Painter:
    """Draws the systems of a simulation into a framebuffer. Keeps the tables and the trails between frames.

    looks : SYSTEM or SYSTEM.NAME -> Look, or None (not drawn); a system without an entry gets white points of light 1
    size : (width, height)
    shutter : simulated seconds the shutter is open
    supersample : the picture is drawn this many times as wide and as high; each pixel is the mean of the block drawn for it
    scene : its light, its sky, and what stands in it
    transparent : leaves out the sky behind everything, so that the picture keeps its alpha
    """

    def __init__(
        self, size, camera: Camera | None = None, looks: dict[str, Look | None] | None = None, shutter: float = 0.0,
        supersample: int = 1, scene: Scene | None = None, transparent: bool = False,
    ):  # fmt: skip
        self.supersample = supersample
        self.size = check_size(tuple(side * supersample for side in check_size(size)), supersample)
        self.camera, self.looks, self.shutter = camera, looks or {}, shutter
        self.scene = scene or Scene()
        self.sky = None if transparent else self.scene.dome
        self._bent = BentSpace.of(self.scene.bends, camera, self.sky, transparent)
        self.framebuffer = FrameBuffer(self.size)
        self._surfaces: SurfacePass | None = None
        self._liquids: LiquidPass | None = None
        self._film: MirrorFilm | None = None
        self._around: Painter | None = None
        self._behind: Painter | None = None  # which draws what the mirror shows
        self._sprites = Sprites()
        self._projected: dict[str, ProjectedParticles] = {}
        self._second_images: dict[str, ProjectedParticles] = {}
        self._trails: dict[str, FrameBuffer] = {}
        self._tables: dict[str, LookTables] = {}
        self._default_look = Look()
        self._earlier_velocities: dict[str, EarlierVelocities] = {}
        self.histories = {
            n: RibbonHistory(k.ribbon) for n, k in self.looks.items() if k is not None and k.ribbon is not None
        }
        self.paths = {
            n: PathHistory(MOMENTS + 2)
            for n, k in self.looks.items()
            if k is not None and k.draw == "streak" and k.ribbon is None
        }
        self._projected_pieces: dict[str, ProjectedParticles] = {}
        self.album = FlashAlbum(self.looks)

    @property
    def trails(self) -> dict[str, Look]:
        """The looks that leave trails, by system."""
        return {name: look for name, look in self.looks.items() if look is not None and look.trail is not None}

    def paint(self, sim, film_time: float) -> np.ndarray:
        """The picture of the simulation's current state at film time `film_time` (s): (height, width, 4), a view.

        The next picture overwrites the view, except where flashes fade. Trails lie between the surfaces and the sprites, as
        `expose_trails` left them.
        Raises PresetError for light that is not finite.
        """
        exposures = self.album.exposures(sim.time)
        try:
            if len(exposures) == 1:
                self.album.expose(1.0)
                return self._exposed(sim, film_time)
            whole = np.zeros((*self.shown_size[::-1], 4), np.float32)
            for least, weight in exposures:
                self.album.expose(least)
                whole += self._exposed(sim, film_time) * np.float32(weight)
            return whole
        finally:
            self.album.expose()

    def _exposed(self, sim, film_time: float) -> np.ndarray:
        """A picture with what the album shows of earlier flashes: a view, which the next picture overwrites."""
        view = self.view(sim, film_time)
        film = self._mirror_film(sim, view, film_time)
        self.framebuffer.clear()
        shaded = self._draw_surroundings(
            sim, self._names(sim), view, film_time, self.shutter, 1.0, self.framebuffer, trails=self._trails, film=film
        )
        if view.lens is not None and shaded.hidden_by is not NOTHING_HIDES:
            hidden_by = draw_through_lens(self, sim, view, film_time, shaded.smoke, shaded.emitted)
            shaded = replace(shaded, hidden_by=hidden_by)
            for trail in self._trails.values():
                self.framebuffer.buffer += trail.buffer
        self._draw_sprites(sim, shaded, view, film_time, 1.0, self.framebuffer)
        if self._bent is not None:
            self._bent.draw_sky(view, film_time, self.framebuffer)
        elif self.sky is not None:
            draw_sky(self.sky, view, self.framebuffer)
        pixels = self.framebuffer.pixels if self.supersample == 1 else box_averaged(self.framebuffer, self.supersample)
        if not math.isfinite(pixels.max()):  # light is never negative; a NaN anywhere is the largest, too
            raise PresetError(
                f"the picture at {film_time:g} s holds light that is not a finite number: a radius, a size, an intensity or a "
                "distance is too large for float32, whose largest number is 3.4e38; its square must fit too"
            )
        return pixels

    @property
    def shown_size(self) -> tuple[int, int]:
        """(width, height) of its pictures."""
        return self.size[0] // self.supersample, self.size[1] // self.supersample

    def keep_surfaces_of(self, before: "Painter") -> None:
        """Take over the light of surfaces that another painter of this size has drawn; what has changed is drawn anew."""
        if before.size == self.size and before._surfaces is not None:
            self._surfaces = before._surfaces
            self._surfaces.check_again()

    def with_margin(self, margin: int) -> "Painter":
        """A painter of pictures that have a margin of this many pixels around this one's, for draw_surfaces_alone."""
        size = (self.size[0] + 2 * margin, self.size[1] + 2 * margin)
        if self._around is None or self._around.size != size:
            self._around = Painter(size, None, self.looks, scene=self.scene, transparent=self.sky is None)
            self._around.album = self.album
        return self._around

    def draw_surfaces_alone(self, sim, view, film_time: float, smoke: dict, emitted) -> tuple[np.ndarray, np.ndarray]:
        """(picture, depths) of the surfaces from a view, both overwritten by the next picture.

        smoke, emitted : the light among them, which another view of the same moment has found
        """
        film = self._mirror_film(sim, view, film_time)
        self.framebuffer.clear()
        self._draw_surroundings(
            sim, self._surface_systems(sim), view, film_time, 0.0, 1.0, self.framebuffer, trails={}, film=film,
            given=(smoke, emitted),
        )  # fmt: skip
        assert self._surfaces is not None
        return self.framebuffer.pixels, self._surfaces.depths

    def _surface_systems(self, sim) -> list[str]:
        """The looks that are drawn by surfaces."""
        looks = {name: self.looks.get(name, self._default_look) for name in self._names(sim)}
        return [name for name, look in looks.items() if look is not None and self._is_surface(look)]

    def _mirror_film(self, sim, view, film_time: float) -> MirrorFilm:
        """What the scene's mirror shows; NO_MIRROR if it has none."""
        if self.scene.mirror < 0:
            return NO_MIRROR
        collider, look = self.scene.surfaces[self.scene.mirror]
        point, normal = collider.values["point"], collider.values["normal"]
        if self._film is None:
            # waves blur what they show, except in calm patches
            blurred = look.waves is not None and look.waves.patches == 0.0
            side = 2 if blurred and not any(length % 2 for length in self.size) else 1
            self._film, self._behind = MirrorFilm(self.size, side), self._painter_behind_mirror(side)
        assert self._behind is not None
        behind = view.mirrored(point, normal)
        pixels, depths = self._behind.paint_mirrored(sim, behind, film_time, self.shutter, (point, normal))
        self._film.take(
            pixels, look.roughness > 0.0 or look.waves is not None, depths if look.waves is not None else None
        )
        if look.roughness > 0.0 and look.waves is None and look.puddles is None:
            self._film.blur(view, point, normal, look.roughness)
        return self._film

    def _painter_behind_mirror(self, side: int) -> "Painter":
        """A painter of what the mirror shows, in pixels `side` times as wide; all but its surfaces are this one's own."""
        behind = copy(self)
        behind._surfaces = behind._liquids = None
        if side > 1:
            behind.size = (self.size[0] // side, self.size[1] // side)
            behind.framebuffer = FrameBuffer(behind.size)
        return behind

    def paint_mirrored(
        self, sim, view, film_time: float, shutter: float, mirror: tuple
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """(picture, depths of the surfaces or None) from a view behind a mirror (point, normal); overwritten by the next."""
        self.framebuffer.clear()
        names = [name for name in self._names(sim) if (self.looks.get(name) or self._default_look).mirrored]
        self._draw(sim, names, view, film_time, shutter, 1.0, self.framebuffer, trails={}, mirror=mirror)
        if self.sky is not None:
            # without the sun's disc: the lamp's own highlight stands for its reflection
            draw_sky(replace(self.sky, disc=np.zeros_like(self.sky.disc)), view, self.framebuffer)
        return self.framebuffer.pixels, None if self._surfaces is None else self._surfaces.depths[:, :, 0]

    @property
    def shows_surfaces(self) -> bool:
        """Whether anything but sprites may be in the pictures: colliders, balls, bodies, cloth or liquids."""
        looks = [look for look in self.looks.values() if look is not None]
        return bool(self.scene.surfaces) or any(self._is_surface(look) for look in looks)

    def draw_passes(self, sim, film_time: float, passes, layers: SurfaceLayers | None = None) -> list[np.ndarray]:
        """Draw the sprites of one moment several times over its surfaces, each time with other numbers for light.

        passes : functions (system, channels) -> None and (pixels) -> None that change what particles and surfaces show
        layers : of the surfaces, which are filled first, or None if there are none
        Returns (height, width, 4) float32 for each pass. Neither trails nor ribbons are in them; what
        flashes left is, if it is half opaque or more.
        """
        view, framebuffer = self.view(sim, film_time), FrameBuffer(self.size)
        names = [name for name in self._names(sim) if not self._has_ribbon(name)]
        shaded = self._draw_surroundings(
            sim, names, view, film_time, self.shutter, 1.0, framebuffer, trails={}, layers=layers
        )
        shaded = replace(shaded, second={})
        surfaces = framebuffer.buffer.copy()
        drawn = [*shaded.drawn.values()]
        drawn += [(pieces.system, self._projected_pieces[name].used) for name, pieces in shaded.curved.items()]
        shown = [channels.copy() for _, channels in drawn]
        results = []
        for recolour, background in passes:
            framebuffer.buffer[:] = surfaces
            background(framebuffer.pixels)
            for (system, channels), before in zip(drawn, shown):
                channels[:] = before
                recolour(system, channels)
            self._draw_sprites(sim, shaded, view, film_time, 1.0, framebuffer)
            pixels = framebuffer.pixels
            results.append(pixels.copy() if self.supersample == 1 else box_averaged(framebuffer, self.supersample))
        return results

    def _names(self, sim) -> list[str]:
        """The names of all looks: those of the systems, with or without a look of their own, and the further looks."""
        further = [name for name in self.looks if name not in sim.systems and system_of(sim, name) in sim.systems]
        return [*sim.systems, *further]

    def particles(self, sim, name: str) -> Particles:
        """The particles that the look of this name draws."""
        return particles_of(sim, name, self.looks.get(name))

    def _has_ribbon(self, name: str) -> bool:
        look = self.looks.get(name)
        return look is not None and look.ribbon is not None

    def view(self, sim, film_time: float, earlier: float = 0.0, seconds: float = 0.0) -> CameraView:
        """The camera's view at a film time.

        earlier, seconds : another view is that of so many film seconds before, which are `seconds` of the simulation. What the
            camera follows then was where its velocity says, and headed where it does now
        """
        camera = self.camera or self._framing(sim)
        view, follow = camera.at(film_time - earlier), camera.spec.follow
        if follow is not None and (subject := followed(sim, follow.system, follow.bank is not None)) is not None:
            heading = subject.heading if follow.turn else 0.0
            bank = subject.bank(follow.bank) if follow.bank is not None else 0.0
            view = view.carried(subject.before(seconds).position, heading, bank)
        return view.in_air(self.scene.dome)

    def remember_velocities(self, sim) -> None:
        """Keep the velocities of the systems whose look shows the acceleration, which is their change until the next picture."""
        for name, look in self.looks.items():
            if look is not None and look.goes_by("acceleration"):
                self._earlier_velocities[name] = EarlierVelocities.of(self.particles(sim, name), sim.time)

    def _acceleration(self, name: str, system, time: float) -> np.ndarray | None:
        """(n,) m/s^2 since the velocities that were remembered; None if there are none."""
        earlier = self._earlier_velocities.get(name)
        return None if earlier is None else earlier.acceleration(system, time)

    def expose_trails(self, sim, film_time: float, exposure: float, shutter: float) -> None:
        """Let the trails fade by `exposure` film seconds, then draw their systems into them once more.

        shutter : simulated seconds a streak covers
        The light of one exposure is weighted so that a particle at rest builds up to its own brightness, whatever fps and
        substeps are.
        """
        view = self.view(sim, film_time)
        hidden_by = self._surface_depths(sim, view, film_time) if self.trails and self.shows_surfaces else NOTHING_HIDES
        for name, look in self.trails.items():
            trail = self._trails.get(name)
            if trail is None:
                trail = self._trails[name] = FrameBuffer(self.size)
            assert look.trail is not None
            fade = 0.5 ** (exposure / look.trail.half_life)
            trail.buffer *= np.float32(fade)
            strength = (1.0 - fade) * look.trail.strength
            shaded = self._draw_surroundings(sim, [name], view, film_time, shutter, strength, trail)
            self._draw_sprites(sim, replace(shaded, hidden_by=hidden_by), view, film_time, strength, trail)

    def flash(self, sim, name: str, film_time: float) -> None:
        """Keep the solids of a look with flashes as they are now; without light, balls are none."""
        look = self.looks[name]
        if look is None or not self._is_surface(look):
            return
        system, projected, surfaces = self.particles(sim, name), ProjectedParticles(), SurfaceSystems()
        tables, raw = self._tables_of(name, system)
        view = replace(self.view(sim, film_time), fog=None, near=-math.inf, far=math.inf)
        q = kernel_numbers(tables, view, self.size, sim.time, film_time, 0.0, raw, 1.0, lit=True)
        shade(projected, system, tables, q, self._acceleration(name, system, sim.time))
        surfaces.add(sim, name, tables.look, system, projected, False)
        self.album.remember(name, surfaces.solids[0], sim.time)

    def _surface_depths(self, sim, view, film_time: float) -> SurfaceDepths:
        """What the surfaces of this moment hide; their light is not drawn."""
        return self._draw_surroundings(
            sim, self._surface_systems(sim), view, film_time, 0.0, 1.0, self.framebuffer, trails={}, given=({}, None),
            depths_only=True,
        ).hidden_by  # fmt: skip

    def _framing(self, sim) -> Camera:
        points = [s.floats[POSITION, living(s, sim.time)].T for s in sim.systems.values()]
        return Camera.framing(np.concatenate(points) if points else np.zeros((0, 3)), self.size[0] / self.size[1])

    def _tables_of(self, name: str, system) -> tuple[LookTables, bool]:
        raw = name not in self.looks
        if name not in self._tables:
            look = self.looks.get(name) or self._default_look
            self._tables[name] = LookTables.of(look, dict(system.channels), system.entries)
        return self._tables[name], raw

    def legends(self, sim) -> list[DrawnLegend]:
        """The legends of the simulation's current state, in the order of its systems."""
        unit = sim.preset.units.energy if sim.preset is not None else "J"
        found = []
        joules = sim.joules()
        for name in self._names(sim):
            system, totals = self.particles(sim, name), joules.get(system_of(sim, name), {})
            tables, _ = self._tables_of(name, system)
            found.append(legend_of(tables.look, tables, totals, unit, system.attributes))
        return [legend for legend in found if legend is not None]

    def _draw(self, sim, names, view, film_time, shutter, weight, framebuffer: FrameBuffer, **more) -> None:
        """Draw systems over what the framebuffer holds; `more` as for _draw_surroundings."""
        shaded = self._draw_surroundings(sim, names, view, film_time, shutter, weight, framebuffer, **more)
        self._draw_sprites(sim, shaded, view, film_time, weight, framebuffer)

    def _draw_surroundings(
        self, sim, names, view, film_time, shutter, weight, framebuffer: FrameBuffer,
        trails: dict[str, FrameBuffer] | None = None, film: MirrorFilm = NO_MIRROR, mirror=None,
        layers: SurfaceLayers | None = None, depths_only: bool = False, given: tuple | None = None,
    ) -> "_Shaded":  # fmt: skip
        """Shade the particles of systems; where `trails` are given, draw first the surfaces and then these trails.

        film : what the scene's mirror shows
        mirror : (point, normal) of the plane behind which the view lies as its mirror image, or None
        layers : of the surfaces, which are filled, or None
        depths_only : what the surfaces hide is found, and they are not drawn
        given : the light of smoke and of emitting particles, where it is known
        """
        drawn: dict[str, tuple] = {}
        stretched: dict[str, np.ndarray] = {}
        curved: dict[str, Pieces] = {}
        lit: dict[str, tuple] = {}
        surfaces = SurfaceSystems()
        looks, hidden_by = {}, NOTHING_HIDES
        bent = NO_LENS if self._bent is None else self._bent.at(view, film_time)
        second: dict[str, ProjectedParticles] = {}
        for name in names:
            if self.looks.get(name, self._default_look) is not None:
                system, projected = self.particles(sim, name), self._projected.setdefault(name, ProjectedParticles())
                tables, raw = self._tables_of(name, system)
                look = looks[name] = tables.look
                if look.ribbon is not None:
                    continue
                light, solid = self._light_on(look), self._is_solid(look)
                # solids are clipped by the rays that meet them, and fog is added where surfaces are drawn
                seen = replace(view, fog=None, near=-math.inf, far=math.inf) if solid else view
                if look.draw == "cloth":  # its colours alone are needed, and those of parallel rays exist everywhere
                    seen = replace(seen, height=1.0)
                seen = replace(view, fog=None) if look.is_liquid else seen
                q = kernel_numbers(
                    tables, seen, self.size, sim.time, film_time, shutter, raw, weight,
                    lit=solid or look.is_liquid or light is not None,
                )  # fmt: skip
                if look.draw == "cloth":
                    q[SIZE_MODE], q[SIZE_VALUE] = 1, 1.0
                acceleration = self._acceleration(name, system, sim.time)
                neighbours = _neighbours(look, system, sim.time)
                distances = NO_SPACING if look.spread is None else spacing(neighbours[look.spread.reach])
                seen_at = bent.images(system, look, 0, sim.time, shutter)
                shade(projected, system, tables, q, acceleration, seen_at, distances=distances)
                if bent is not NO_LENS and light is None:
                    second[name] = self._second_images.setdefault(name, ProjectedParticles())
                    seen_at = bent.images(system, look, 1, sim.time, shutter)
                    shade(second[name], system, tables, q, acceleration, seen_at, distances=distances)
                if mirror is not None and not solid and look.draw != "cloth":  # rays cut solids at the mirror
                    projected.hide_behind(system, *mirror)
                if name in self.paths and bent is NO_LENS:
                    pieces = self._bend(name, system, q, acceleration, mirror)
                    curved |= {} if pieces is None else {name: pieces}
                if look.stretch is not None:
                    stretched[name] = _ellipses(look.stretch, projected, system, neighbours, q)
                drawn[name] = system, projected.used
                if self._is_surface(look):
                    surfaces.add(sim, name, look, system, projected, name in self.scene.glow)
                    if name in self.album.flashes:
                        surfaces.solids += self.album.left(name, surfaces.solids[-1], sim.time)
                elif light is not None and not light.dark and projected.count:
                    lit[name] = light, projected.used, projected.lit[: projected.count]
        scene = self.scene  # the mirror too: it shadows what it shows, and rays from behind do not meet it
        if self._bent is not None and (surfaces or scene.surfaces):
            raise UsageError(
                f"a {self._bent.name} bends the light of sprites and of the sky, and not of surfaces: leave it out, or the "
                "`ground`, the `look` of colliders and what is drawn as balls, bodies, threads, cloth or liquid"
            )
        casters = None
        if trails is not None and (surfaces or scene.surfaces):
            casters = ShadowCasters.of(scene, surfaces.solids, surfaces.sheets, view, sim.time)
        shading = casters if scene.shadows else None
        smoke, emitted = given or ({}, None)
        if given is None:
            emitted = self._emitted_light(sim, view, film_time, weight) if lit or casters is not None else None
            smoke = add_scattered_light(lit, drawn, view, view.scale(self.size[1]), shading, emitted) if lit else {}
        if trails is not None:
            if casters is not None:
                if layers is not None:
                    layers.take_motion(surfaces.solids, surfaces.sheets)
                hidden_by = self._draw_surfaces(
                    scene, casters, surfaces, smoke, framebuffer, film, mirror, emitted, layers, depths_only
                )
            for trail in trails.values():
                framebuffer.buffer += trail.buffer
        return _Shaded(looks, drawn, second, bent, stretched, curved, hidden_by, mirror, smoke, emitted)

    def _draw_sprites(self, sim, shaded: "_Shaded", view, film_time, weight, framebuffer: FrameBuffer) -> None:
        """Draw the sprites and ribbons of systems that were shaded, over what the framebuffer holds."""
        sprites, looks = self._sprites, shaded.looks
        sprites.clear()
        sprites.hidden_by = shaded.hidden_by
        sprites.layered = any(look.blend != "add" and not self._is_surface(look) for look in looks.values())
        for name, look in looks.items():
            if look.ribbon is not None:
                self._add_ribbons(sim, name, view, film_time, weight, framebuffer, shaded)
            elif name in shaded.stretched:
                sprites.add_ellipses(self._projected[name], shaded.stretched[name], framebuffer)
            elif not self._is_surface(look):
                self._add_sprites(look, self._projected[name], view, framebuffer)
                if name in shaded.second:
                    self._add_sprites(look, shaded.second[name], view, framebuffer)
                if name in shaded.curved:
                    pieces = shaded.curved[name]
                    sprites.add(self._projected_pieces[name], pieces.kinds, framebuffer, pieces.ends, HIDDEN)
        splat(sprites, framebuffer)

    def _bend(self, name: str, system, q: np.ndarray, acceleration, mirror) -> Pieces | None:
        """Shade the pieces of those streaks that bend, and hide the straight ones in their place."""
        projected, look = self._projected[name], self._tables[name].look
        past = self.paths[name].since(system, q[TIME], q[TIME] - q[SHUTTER])
        pieces = cut(system, past, q, look.tail, look.taper)
        if pieces is not None:
            projected.hide(pieces.replaced)
            if acceleration is not None:
                acceleration = acceleration[pieces.owner]
            of_pieces = self._projected_pieces.setdefault(name, ProjectedParticles())
            shade(of_pieces, pieces.system, self._tables[name], pieces.numbers, acceleration, pieces=pieces.rows)
            if mirror is not None:
                of_pieces.hide_behind(pieces.system, *mirror)
        return pieces

    def _emitted_light(self, sim, view, film_time: float, weight: float) -> EmittedLight | None:
        """What the systems that the scene's light names by `glow` emit, or None."""
        found = []
        for name in self.scene.glow:
            if name not in sim.systems:
                raise UsageError(f"light.glow names '{name}', and there is no such system")
            if self.looks.get(name, self._default_look) is not None:
                system = self.particles(sim, name)
                found.append((system, self._tables_of(name, system)[0], self._acceleration(name, system, sim.time)))
        return emitted_light(found, view, self.size, sim.time, film_time, weight)

    def _light_on(self, look: Look) -> Lighting | None:
        """The light that a system of smoke scatters: its own, or the scene's."""
        if look.light is not None:
            return Lighting.of(look.light)
        return self.scene.lighting if self.scene.lit and look.blend == "alpha" else None

    def _is_solid(self, look: Look) -> bool:
        """Whether a system is drawn by surfaces in the scene's light: balls, bodies, threads or cloth."""
        return look.shapes or (self.scene.lit and look.draw == "sphere" and look.blend == "opaque")

    def _is_surface(self, look: Look) -> bool:
        """Whether a system is drawn by surfaces: as solids or as a liquid."""
        return look.is_liquid or self._is_solid(look)

    def _draw_surfaces(
        self, scene, casters, drawn: SurfaceSystems, smoke: dict, framebuffer, film: MirrorFilm, mirror, emitted, layers,
        depths_only: bool,
    ) -> SurfaceDepths:  # fmt: skip
        """Draw the surfaces into a clear framebuffer; returns what they hide."""
        if self._surfaces is None:
            self._surfaces = SurfacePass(self.size)
        surfaces, liquids, finishes = self._surfaces, drawn.liquids, drawn.finishes
        of_lamp = smoke.get(smoke_key(scene.lighting))
        shadow = NO_LIQUID
        # a clear liquid does not shadow itself
        receivers = scene.surfaces or finishes or not all(system.liquid.clear for system in liquids)
        if liquids and scene.shadows and receivers and not depths_only:
            shadow = lamp_map(liquids, lamp_axes(scene.lighting.direction))
        of_liquids = [liquid.finish for liquid in liquids]
        surfaces.draw(
            scene, casters, [*finishes, *of_liquids], of_lamp and of_lamp[:2], framebuffer, film, mirror, emitted, shadow,
            None if depths_only else hiding_particles(liquids), layers, not depths_only,
            self.camera is not None and not self.camera.moves,
        )  # fmt: skip
        if liquids:
            if self._liquids is None:
                self._liquids = LiquidPass(self.size)
            first = len(scene.surfaces) + len(finishes)
            if depths_only:
                self._liquids.find_depths(liquids, surfaces)
            else:
                self._liquids.draw(liquids, first, casters, surfaces, framebuffer, self.sky is not None, layers)
            surfaces.forget()  # liquids are drawn into its depths
        depths, tiles, view = surfaces.depths, surfaces.bounds, casters.view
        return SurfaceDepths.of(depths, tiles, 1.0 / view.scale(self.size[1]), view.height is not None)

    def forget_surfaces(self) -> None:
        """Trace the surfaces of the next picture anew, even if neither they nor the camera have moved."""
        if self._surfaces is not None:
            self._surfaces.forget()
        if self._behind is not None:
            self._behind.forget_surfaces()

    def _add_ribbons(self, sim, name: str, view, film_time, weight, framebuffer: FrameBuffer, shaded: _Shaded) -> None:
        """Add every link of a system's ribbons to the sprites; without earlier positions there are none."""
        tables, projected = self._tables[name], self._projected[name]

        def numbers(seconds: float, light: float, width: float) -> np.ndarray:
            return kernel_numbers(tables, view, self.size, sim.time, film_time, seconds, False, weight * light, width)

        for links in self.histories[name].links(self.particles(sim, name), sim.time):
            add_links(self._sprites, links, projected, tables, numbers, framebuffer, shaded.mirror, shaded.bent)

    def _add_sprites(
        self, look: Look, projected: ProjectedParticles, view: CameraView, framebuffer: FrameBuffer
    ) -> None:
        """Draw a system's small sprites directly where they only add light; add the others to the sprites."""
        sprites, kind, min_footprint = self._sprites, KINDS[look.draw], HIDDEN
        if look.picture is not None:
            sprites.add_images(projected, look.picture, view.roll, framebuffer)
            return
        if not sprites.layered and kind in (POINT, DISC) and projected.count > MIN_PARTICLES:
            largest = float(projected.used[FOOTPRINT].max())
            min_footprint = MAX_FOOTPRINT if largest > 0.0 else 0.0
            if sprites.hidden_by is not NOTHING_HIDES:
                hide_small_sprites(projected.channels, projected.count, sprites.hidden_by, MAX_FOOTPRINT)
            dots = pixels if look.draw == "pixel" else points
            (discs if largest > 0.0 else dots)(projected.channels, projected.count, framebuffer)
            if largest <= min_footprint:
                return
        sprites.add(projected, kind, framebuffer, streak_ends(look.tail, look.taper), min_footprint)


def _neighbours(look: Look, system, time: float) -> dict[float, NeighbourSums]:
    """The sums over neighbours that a look needs, by their reach."""
    of_stretch = None if look.stretch is None else look.stretch.reach
    of_spread = None if look.spread is None else look.spread.reach
    reaches = {reach for reach in (of_stretch, of_spread) if reach is not None}
    return {reach: NeighbourSums.of(system, time, reach, moments=reach == of_stretch) for reach in reaches}


def _ellipses(
    stretch: Stretch, projected: ProjectedParticles, system, neighbours: dict[float, NeighbourSums], q
) -> np.ndarray:
    """The ellipses of a system's discs."""
    if stretch.reach is not None:
        return ellipses_of_shapes(projected, q, neighbour_shapes(neighbours[stretch.reach], stretch.most))
    assert stretch.time is not None
    return ellipses_of_motion(projected, system, q, stretch.time, stretch.most)
