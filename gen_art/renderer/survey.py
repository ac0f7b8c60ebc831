"""A survey of a film: where what is seen lies at some forty moments, from a run of a copy with few particles.

The moments and the copy follow from the preset alone, never from the frames that somebody asks for.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gen_art.particles.rows import POSITION, VELOCITY
from gen_art.particles.storage import Particles
from gen_art.preset.estimate import estimate, refuse_if_too_large
from gen_art.preset.thinning import MUTUAL, galaxies, independent_systems, thinned
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.drawn_particles import particles_of, system_of
from gen_art.renderer.following import living
from gen_art.renderer.look_tables import (
    AREA_OF,
    KIND,
    LIT,
    RIBBON,
    SHUTTER,
    SIZE_MODE,
    STROBE_HI,
    LookTables,
    kernel_numbers,
)
from gen_art.renderer.projected_particles import LIT_RADIUS, ProjectedParticles
from gen_art.renderer.shading import REFERENCE_ROWS, shade
from gen_art.renderer.sprite import ALPHA, BLUE, DISC, GREEN, KINDS, POINT, RED, STREAK

if TYPE_CHECKING:
    from gen_art.preset.schema import Preset

__all__ = ["Moment", "survey"]

MOMENTS = 40  # frames of the film, besides the first, the last and the poster
PARTICLES = 10_000  # of a system at once, about; of systems that nothing else depends on
ATTRACTING = 4_000  # of a galaxy's bodies, whose attraction to all takes the time
GOLDEN = 0.6180339887498949  # multiples of it, less their whole parts, fall evenly and keep step with no period
HALF_LIVES = 4.0  # of a trail: what is older has a sixteenth of its light
LUMINANCE = (0.2126, 0.7152, 0.0722)


@dataclass(frozen=True)
class Moment:
    """What is seen at one moment; n points, of which a streak has two.

    time : film time, s; below 0 for what a trail or a ribbon still shows at frame 0
    points : (n, 3) world units
    radius, radius_pixels : (n,) world units, and pixels of a picture 720 high; a sprite has one or the other
    weight, weight_pixels : (n,) the area that a sprite covers or lights, less where it is faint, in square world units and in
        those pixels
    """

    time: float
    points: np.ndarray
    radius: np.ndarray
    radius_pixels: np.ndarray
    weight: np.ndarray
    weight_pixels: np.ndarray


def survey(preset: "Preset", precision: str = "f32", threads: int | None = None) -> list[Moment]:
    """The moments of a film, in order, of the systems that `camera.frame.of` names, or of all that have a look.

    It costs a run of the simulation with at most about 10,000 particles a system.

    Of a galaxy, whose bodies share its mass, 4,000 attract the rest. Other systems whose particles act on each other, or on
    those of another system, run with all their particles. Raises MemoryRefused where those do not fit, and what a simulation
    raises.
    """
    from gen_art.simulation import Simulation

    clock = preset.clock
    few, _ = thinned(preset, clock.simulated, PARTICLES, independent_systems(preset))
    few, _ = thinned(few, clock.simulated, ATTRACTING // MUTUAL, galaxies(preset))
    born, all_born = refuse_if_too_large(few, precision).born, estimate(preset, precision).born
    sim = Simulation(few, precision=precision, threads=threads, advice="none")
    camera = Camera.from_spec(few.camera) if few.camera is not None else Camera()
    frame = few.camera.frame if few.camera is not None else None
    subject = frame.of if frame is not None else None
    tables = {
        name: LookTables.of(
            look, dict(sim.systems[system_of(sim, name)].channels), sim.systems[system_of(sim, name)].entries
        )
        for name, look in few.looks.items()
        if look is not None and (subject is None or system_of(sim, name) in subject)
    }
    projected, moments, done = ProjectedParticles(), [], 0
    for step in _steps(few):
        if step > done:
            sim.step(step - done)
        done = step
        sim.check_finite()
        film_time = (step - clock.preroll_steps) * clock.step / clock.speed
        scale = _scale_at_target(camera, film_time)
        shutter = camera.shutter / 360.0 * clock.speed / clock.fps
        light = 2.0**few.develop.exposure
        parts = []
        for name, table in tables.items():
            particles, of = particles_of(sim, name, table.look), system_of(sim, name)
            columns = _seen(sim, particles, table, projected, scale, film_time, shutter, light, clock.speed)
            share = all_born[of] / max(born[of], 1.0) if few is not preset else 1.0  # each stands for so many
            parts.append([*columns[:3], *(share * column for column in columns[3:])])
        if parts:
            moments.append(Moment(film_time, *(np.concatenate(column) for column in zip(*parts))))
    return moments


def _steps(preset: "Preset") -> list[int]:
    """Numbers of steps at which the survey looks: frames of the film, the poster, and moments before that trails still show."""
    clock = preset.clock
    frames = {math.floor(clock.frames * (k * GOLDEN % 1.0)) for k in range(MOMENTS)} | {0, clock.frames - 1}
    steps = {clock.preroll_steps + k * clock.steps_per_frame for k in frames} | {clock.step_at(preset.poster_time)}
    looks = [look for look in preset.looks.values() if look is not None]
    afterglow = max((k.ribbon.length for k in looks if k.ribbon is not None), default=0.0)
    trails = [k.trail.half_life for k in looks if k.trail is not None]
    afterglow = max([afterglow, *(HALF_LIVES * half_life * clock.speed for half_life in trails)])
    earlier = min(clock.preroll_steps, math.floor(min(afterglow / clock.step, clock.preroll_steps)))
    return sorted(steps | {clock.preroll_steps - math.floor(earlier * share) for share in np.linspace(0.125, 1.0, 8)})


def _afterglow(look, speed: float, shutter: float) -> float:
    """Simulated time over which a particle's path is seen, s: a taper's and a trail's older half counts by its brightness."""
    if look.ribbon is not None:
        return 0.5 * look.ribbon.length
    if look.trail is not None:
        return min(look.trail.strength, 1.0) * look.trail.half_life * speed / math.log(2.0)
    return shutter if look.draw == "streak" else 0.0


def _scale_at_target(camera: Camera, film_time: float) -> float:
    """Pixels per world unit at the camera's target, in a picture 720 pixels high."""
    view = camera.at(film_time)
    return view.scale(int(REFERENCE_ROWS)) / (1.0 if view.height else view.distance)


def _seen(
    sim,
    system: Particles,
    tables: LookTables,
    projected,
    scale: float,
    film_time: float,
    shutter: float,
    light: float,
    speed: float,
):
    """The columns of a Moment for one look: those of its particles that are alive, or every so many of them.

    A ribbon, a trail and a streak cover their length times their width.
    """
    look = tables.look
    rows = REFERENCE_ROWS
    view = CameraView(
        position=np.zeros(3), axes=np.eye(3), distance=1.0, fov=40.0, height=rows / scale, near=-math.inf, far=math.inf, fog=None,
    )  # fmt: skip
    numbers = kernel_numbers(tables, view, (rows, rows), sim.time, film_time, shutter, False)
    numbers[STROBE_HI] = numbers[RIBBON] = 0.0
    numbers[LIT] = 1.0  # the kernel then writes radii, also of what is off the picture
    if look.draw == "streak":
        numbers[KIND] = DISC
    shade(projected, system, tables, numbers)
    alive = living(system, sim.time)
    alive = alive[np.isfinite(system.floats[POSITION, alive]).all(axis=0)]
    every = -(-len(alive) // PARTICLES) or 1
    alive = alive[::every]
    channels = projected.used[:, alive].astype(np.float64)
    flux = sum(share * channels[c] for share, c in zip(LUMINANCE, (RED, GREEN, BLUE)))
    radius = projected.lit[alive, LIT_RADIUS].astype(np.float64)
    is_dot = KINDS[look.draw] == POINT and numbers[SIZE_MODE] < 2
    in_pixels = is_dot or numbers[SIZE_MODE] == 2
    if in_pixels:
        radius = np.ones_like(radius) if is_dot else radius * scale
    area = np.ones_like(radius) if is_dot else numbers[AREA_OF] * (radius if in_pixels else radius * scale) ** 2
    area = np.maximum(area, 1e-300)
    path = np.sqrt((system.floats[VELOCITY, alive].astype(np.float64) ** 2).sum(axis=0)) * scale
    path *= _afterglow(look, speed, numbers[SHUTTER]) / (2.0 * np.maximum(radius if in_pixels else radius * scale, 0.5))
    if look.draw == "streak" and look.ribbon is None:
        area *= 1.0 + path  # with the same light on all of it
        path[:] = 0.0
    weight = every * (1.0 + path) * (area * -np.expm1(-light * flux / area) + channels[ALPHA])
    alive, radius, weight = (column[weight > 0.0] for column in (alive, radius, weight))
    nothing = np.zeros_like(radius)
    points = system.floats[POSITION, alive].T.astype(np.float64)
    columns = (
        [points, nothing, radius, nothing, weight]
        if in_pixels
        else [points, radius, nothing, weight / scale**2, nothing]
    )
    if KINDS[look.draw] != STREAK:
        return columns
    lapse = np.clip(sim.time - system.birth[alive], 0.0, numbers[SHUTTER])
    tails = points - system.floats[VELOCITY, alive].T.astype(np.float64) * lapse[:, None]
    halves = [*columns[:3], *(0.5 * column for column in columns[3:])]
    return [np.concatenate(pair) for pair in zip(halves, [tails, *halves[1:]])]
