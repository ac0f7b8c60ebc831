"""What a painter asks of a wormhole or a black hole: where particles are seen, and the skies that it bends."""

from gen_art.errors import UsageError
from gen_art.preset.black_hole import BlackHole
from gen_art.preset.look import Look
from gen_art.preset.wormhole import Wormhole
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.lensing.black_hole import Hole
from gen_art.renderer.lensing.lens import Lens
from gen_art.renderer.lensing.lensed_sky import draw_lensed_sky
from gen_art.renderer.lensing.particle_images import particle_images
from gen_art.renderer.lensing.throat import Throat
from gen_art.renderer.sky import SkyDome

__all__ = ["NO_LENS", "BentSpace", "LensedView"]


class LensedView:
    """Where particles are seen in one picture.

    lens : what bends its light, or None
    """

    def __init__(self, lens: Lens | None):
        self.lens = lens

    @property
    def orders(self) -> tuple[int, ...]:
        """The images of each particle that are drawn."""
        return (0,) if self.lens is None else (0, 1)

    def images(self, system, look: Look, order: int, time: float, shutter: float):
        """(6, capacity) positions and velocities as the camera sees them; None where nothing bends light."""
        if self.lens is None:
            return None
        lapse = shutter if look.length is None or look.ribbon is not None else look.length
        return particle_images(system, self.lens, look.side, order, time, lapse, look.draw == "streak")


NO_LENS = LensedView(None)


class BentSpace:
    """What bends the light of a painter's scene.

    source : a wormhole or a black hole
    name : of it, as messages say it
    camera : whose path may go through a wormhole
    near, far : the skies of both sides, or None; a black hole has one side
    """

    def __init__(
        self, source: Throat | Hole, name: str, camera: Camera | None, near: SkyDome | None, far: SkyDome | None
    ):
        self.source, self.name, self.camera, self.near, self.far = source, name, camera, near, far

    @classmethod
    def of(
        cls, spec: Wormhole | BlackHole | None, camera: Camera | None, near: SkyDome | None, transparent: bool
    ) -> "BentSpace | None":
        """What a preset's `wormhole:` or `black_hole:` bends, or None. A transparent picture has no skies.

        Raises UsageError for a sun.
        """
        if spec is None:
            return None
        name = "wormhole" if isinstance(spec, Wormhole) else "black hole"
        if near is not None and near.sun_direction is not None:
            raise UsageError(f"the sky of a {name} has no sun: give `sky` a gradient, a color, stars or a band")
        near = None if transparent else near
        if isinstance(spec, BlackHole):
            return cls(Hole(spec), name, camera, near, None)
        far = None if transparent or spec.sky is None else SkyDome.of(spec.sky)
        return cls(Throat(spec), name, camera, near, far)

    def at(self, view: CameraView, film_time: float) -> LensedView:
        """Where particles are seen in the picture of a view."""
        return LensedView(self.source.lens(view, film_time, self.camera))

    def draw_sky(self, view: CameraView, film_time: float, framebuffer) -> None:
        """Draw the skies under what the framebuffer holds; with no sky at all it keeps its alpha."""
        if self.near is not None or self.far is not None:
            draw_lensed_sky(self.near, self.far, self.source.lens(view, film_time, self.camera), view, framebuffer)
