"""The memory that drawing takes: of a pixel, of a particle, and whatever the size of both is.

Each figure was measured as the growth of a process's peak, with one preset of each kind at several sizes: benchmarks/memory.py
says how well they predict others.
"""

from gen_art.preset.camera import CameraSpec
from gen_art.preset.look import Look
from gen_art.preset.schema import Preset
from gen_art.preset.surface import TRACED_ROUGHNESS, surface_look

__all__ = ["fixed_bytes", "particle_bytes", "pixel_bytes"]

# of a particle
SHADED = 50  # in the picture
LIT = 36  # more, in a lit system
LISTED = 85  # more, drawn as a sprite
SORTED = 36  # more, sorted by depth
REMEMBERED = 32  # of a past position and velocity, for ribbons and streaks
PATH = 10  # most moments that a streak's path is remembered at
NEIGHBOURS = 260  # more, while distances to neighbours are found
SHAPED = 32  # more, while the shapes of neighbourhoods are found
COPIED = 70  # more, where a look draws the particles of some emitters alone
SOLID = 200  # as a ball, or the link of a thread: its row and those of the lists of it
WOVEN = 1400  # in a cloth: a corner and two triangles
LIQUID = 20  # in a liquid: what it is to the camera and to the lamp
GLOWING = 590  # of a system whose light falls on others: its row in the tree of lights
# of a cell of the density grid: eight arrays, for smoke that fills half of its cube
CELL = 4 * 4
# of a pixel: of the framebuffer; of the developed picture, its bloom and its file; the depths of surfaces, and their light in
# parts; what a mirror shows and its pyramid, and how it is read; the slopes of waves; the layers of a liquid, and what is seen
# through it; the mean of a lens's views, and what they hide
FRAMEBUFFER, PICTURE, DEPTHS, PARTS, MIRRORED, READ, WAVED, LAYERED, DEFOCUSED = 16, 10, 16, 28, 22, 56, 12, 44, 48
SURFACES = 45e6  # for the kernels of surfaces, and for the sky's light among them
LIQUIDS = 30e6  # for those of liquids, and for the shadow that they cast
PHOTONS = 10e6  # for light that glass gathers


def pixel_bytes(preset: Preset) -> float:
    """Bytes of a pixel while the picture is rendered."""
    camera = preset.camera or CameraSpec()
    trails = sum(look.trail is not None for look in _looks(preset))
    fading = any(look.flashes is not None and look.flashes.fades for look in _looks(preset))
    averaged = (camera.supersample > 1) + (camera.subframes > 1) + 2 * fading
    surfaces = 0
    if _shows_surfaces(preset):
        mirror = any(look.mirror for look in _surfaces(preset))
        waved = sum(look.waves is not None for look in _surfaces(preset))
        surfaces += DEPTHS + (MIRRORED + DEPTHS) * mirror + WAVED * waved
        if _in_parts(preset):
            surfaces += PARTS + (READ + PARTS) * mirror
    if any(look.is_liquid for look in _looks(preset)):
        surfaces += LAYERED
    if (
        surfaces and camera.lens is not None and camera.lens.radius > 0.0
    ):  # which are drawn once more, from all its places
        surfaces += FRAMEBUFFER + surfaces + DEFOCUSED
    return PICTURE + FRAMEBUFFER * averaged + camera.supersample**2 * (FRAMEBUFFER * (1 + trails) + surfaces)


def particle_bytes(preset: Preset, name: str, look: Look) -> float:
    """Bytes of a particle of a system while a look draws it."""
    copied = COPIED if look.tag else 0
    return copied + _drawn_bytes(preset, look, preset.light is not None and name in preset.light.glow)


def _drawn_bytes(preset: Preset, look: Look, glows: bool) -> float:
    glowing = GLOWING if glows else 0
    if look.stretch is not None or look.spread is not None:
        by_neighbours = look.stretch is not None and look.stretch.by == "neighbours"
        shaped = NEIGHBOURS + SHAPED * by_neighbours if look.spread is not None or by_neighbours else 0
        more = (SORTED if look.blend != "add" else 0) + (LIT if _smoke_cells(preset, look) else 0)
        return glowing + SHADED + LISTED + shaped + more
    if look.ribbon is not None:
        return glowing + SHADED + look.ribbon.points * (REMEMBERED + LISTED)
    moments = 1 if look.flashes is None else 2 + look.flashes.number
    if look.draw == "body":  # the shapes are few, the particles are only shaded
        return glowing + moments * (SHADED + LIT)
    if _is_solid(preset, look):
        return glowing + moments * (SHADED + LIT + (WOVEN if look.draw == "cloth" else SOLID))
    if look.is_liquid:
        return glowing + SHADED + LIT + LIQUID
    if look.blend == "add":
        return glowing + SHADED + (0 if look.draw in ("point", "pixel") else LISTED) + _path(look, preset)
    return glowing + SHADED + LISTED + SORTED + (LIT if _smoke_cells(preset, look) else 0) + _path(look, preset)


def _path(look: Look, preset: Preset) -> float:
    """Bytes of a particle for the path of its streak: moments, once more while they are compared, and a piece of the streak."""
    if look.draw != "streak" or look.ribbon is not None:
        return 0.0
    camera, clock = preset.camera or CameraSpec(), preset.clock
    length = camera.shutter / 360.0 * clock.speed / clock.fps if look.length is None else look.length
    moments = min(PATH, length / clock.step + 2.0)
    return 2.0 * moments * REMEMBERED + SHADED + LISTED


def fixed_bytes(preset: Preset) -> float:
    """Bytes that drawing takes at any size of the picture, with any number of particles."""
    looks = _looks(preset)
    total = float(sum(CELL * _smoke_cells(preset, look) for look in looks))
    if _shows_surfaces(preset):
        total += SURFACES
    if any(look.is_liquid for look in looks):
        total += LIQUIDS
    if any(look.transmission > 0.0 for look in (*_surfaces(preset), *(look.finish for look in looks))):
        total += PHOTONS
    return total


def _looks(preset: Preset) -> list[Look]:
    return [look for look in preset.looks.values() if look is not None]


def _surfaces(preset: Preset) -> list:
    """The looks of the ground and of the colliders that are drawn."""
    colliders = [*preset.colliders, *(one for system in preset.systems.values() for one in system.colliders)]
    found = [surface_look(collider.values["look"]) for collider in colliders]
    return [look for look in (preset.ground, *found) if look is not None]


def _lit(preset: Preset) -> bool:
    return preset.light is not None or preset.sky is not None


def _is_solid(preset: Preset, look: Look) -> bool:
    return look.shapes or (_lit(preset) and look.draw == "sphere" and look.blend == "opaque")


def _shows_surfaces(preset: Preset) -> bool:
    """Whether anything but sprites may be in the picture."""
    return bool(_surfaces(preset)) or any(look.is_liquid or _is_solid(preset, look) for look in _looks(preset))


def _in_parts(preset: Preset) -> bool:
    """Whether the light of surfaces is kept in parts: where the camera rests, none shows others but as a mirror, and there are
    neither waves nor cloth nor liquids."""
    looks, shown = _looks(preset), _surfaces(preset)
    solids = [look.finish for look in looks if _is_solid(preset, look)]
    alone = len(shown) == 1 and not solids
    smooth = any(look.roughness <= TRACED_ROUGHNESS and not look.mirror for look in shown)
    smooth |= any(finish.roughness <= TRACED_ROUGHNESS for finish in solids)
    shows_others = any(one.transmission > 0.0 for one in (*shown, *solids)) or (smooth and not alone)
    moves = any(look.waves is not None for look in shown) or (preset.camera is not None and preset.camera.moves)
    return not (moves or shows_others or any(look.is_liquid or look.draw == "cloth" for look in looks))


def _smoke_cells(preset: Preset, look: Look) -> int:
    """The cells of the density grid of a system of smoke that light falls on, or 0."""
    if look.light is not None:
        return look.light.resolution**3
    is_smoke = look.blend == "alpha" and _lit(preset) and not _is_solid(preset, look) and not look.is_liquid
    return (preset.light.resolution if preset.light is not None else 96) ** 3 if is_smoke else 0
