"""The systems of a picture that are drawn by surfaces: solids, cloth and liquids."""

from dataclasses import dataclass, field

from gen_art.particles.rows import POSITION, VELOCITY
from gen_art.preset.look import Look
from gen_art.preset.surface import Finish
from gen_art.renderer.drawn_particles import system_of
from gen_art.renderer.liquid.liquid_system import LiquidSystem
from gen_art.renderer.projected_particles import LIT_RADIUS, ProjectedParticles
from gen_art.renderer.surfaces.sheet_rows import SheetSystem, places_on_sheet, sheet_of
from gen_art.renderer.surfaces.solid_rows import SolidSystem, shapes_of
from gen_art.renderer.surfaces.strands import lay_strands

__all__ = ["SurfaceSystems"]


@dataclass
class SurfaceSystems:
    """Solids, cloth and liquids, as their particles are shaded, each in the order in which they were added."""

    solids: list[SolidSystem] = field(default_factory=list)
    sheets: list[SheetSystem] = field(default_factory=list)
    liquids: list[LiquidSystem] = field(default_factory=list)

    def add(self, sim, name: str, look: Look, system, projected: ProjectedParticles, glows: bool) -> None:
        """Add what a look draws by surfaces.

        system, projected : the particles that it draws, and these as they are shaded, lit
        glows : whether its own light falls on others
        """
        velocities = system.floats[VELOCITY, : projected.count]
        if look.is_liquid:
            self.liquids.append(LiquidSystem(look.liquid, look.liquid_finish, projected, velocities))
        elif look.draw == "cloth":
            self.sheets.append(_cloth(sim, name, look, system, projected, velocities))
        else:
            self.solids.append(_solids(sim, name, look, system, projected, velocities, glows))

    @property
    def finishes(self) -> list[Finish]:
        """Of the solids, then of the cloth."""
        return [*(system.finish for system in self.solids), *(system.look.finish for system in self.sheets)]

    def __bool__(self) -> bool:
        return bool(self.solids or self.sheets or self.liquids)


def _cloth(sim, name: str, look: Look, system, projected: ProjectedParticles, velocities) -> SheetSystem:
    member = sim.members[system_of(sim, name)]
    faces = sheet_of(name, member.interactions, system)
    places = None if look.finish.image is None else places_on_sheet(name, member.emitters, system)
    positions = system.floats[POSITION, : projected.count]
    return SheetSystem(look, projected.used, projected.lit[: projected.count], positions, faces, velocities, places)


def _solids(sim, name: str, look: Look, system, projected: ProjectedParticles, velocities, glows: bool) -> SolidSystem:
    columns, shapes = projected.lit[: projected.count], None
    if look.shapes:
        shapes = shapes_of(name, look.draw, sim.members[system_of(sim, name)].interactions, system)
        if look.strands:
            shapes = lay_strands(shapes, columns[shapes.particle, LIT_RADIUS], look.strands)
    return SolidSystem(look.finish, projected.used, columns, velocities, shapes, glows, look.edge)
