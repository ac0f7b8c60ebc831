"""What a painter asks of a wormhole: where particles are seen, and the skies of both sides."""

from gen_art.errors import UsageError
from gen_art.preset.look import Look
from gen_art.preset.wormhole import Wormhole
from gen_art.renderer.camera import Camera, CameraView
from gen_art.renderer.lensing.lensed_sky import draw_lensed_sky
from gen_art.renderer.lensing.particle_images import particle_images
from gen_art.renderer.lensing.throat import Lens, Throat
from gen_art.renderer.sky import SkyDome

__all__ = ["NO_LENS", "LensedView", "WormholeView"]


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


class WormholeView:
    """The wormhole of a painter's scene.

    camera : whose path may go through it
    near, far : the skies of both sides, or None
    """

    def __init__(self, spec: Wormhole, camera: Camera | None, near: SkyDome | None, far: SkyDome | None):
        self.throat, self.camera, self.near, self.far = Throat(spec), camera, near, far

    @classmethod
    def of(
        cls, spec: Wormhole | None, camera: Camera | None, near: SkyDome | None, transparent: bool
    ) -> "WormholeView | None":
        """The view of a preset's `wormhole:`, or None. A transparent picture has no skies. Raises UsageError for a sun."""
        if spec is None:
            return None
        if near is not None and near.sun_direction is not None:
            raise UsageError("the skies of a wormhole have no sun: give `sky` a gradient, a color, stars or a band")
        far = None if transparent or spec.sky is None else SkyDome.of(spec.sky)
        return cls(spec, camera, None if transparent else near, far)

    def at(self, view: CameraView, film_time: float) -> LensedView:
        """Where particles are seen in the picture of a view."""
        return LensedView(self.throat.lens(view, film_time, self.camera))

    def draw_sky(self, view: CameraView, film_time: float, framebuffer) -> None:
        """Draw both skies under what the framebuffer holds; with no sky at all it keeps its alpha."""
        if self.near is not None or self.far is not None:
            draw_lensed_sky(self.near, self.far, self.throat.lens(view, film_time, self.camera), view, framebuffer)
