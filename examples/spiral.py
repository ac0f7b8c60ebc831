"""An emitter of one's own: particles are born along a spiral, and drift up from it.

Use it from a preset:   gen-art render examples/swirl.yaml -o swirl.mp4 --plugin examples/swirl.py --plugin examples/spiral.py
"""

import gen_art as ga
from gen_art import ti


@ga.emitter("spiral")
class Spiral(ga.Emitter):
    """Births along an Archimedean spiral in the plane y = 0, thrown outwards.

    x = s radius (cos phi, 0, sin phi), phi = 2 pi turns s, s = sqrt(u) with u uniform; v = speed (cos phi, 0, sin phi)

    turns : from the middle to the edge     radius : m, > 0     speed : m/s, a range     spread : m, normal, across the line
    Sets the particle's own radius too: 1 + s times what is drawn from `grain` (m).
    """

    turns: float = ga.param(3.0, doc="turns from the middle to the edge")
    radius: float = ga.param(1.0, unit="m", min=1e-9)
    speed: tuple = ga.param((0.1, 0.2), unit="m/s", kind="range")
    spread: float = ga.param(0.02, unit="m", min=0)
    grain: tuple = ga.param((0.005, 0.01), unit="m", kind="range", min=0)

    @ti.func
    def birth(self, r, t, q):
        # every r.uniform(channel) is a function of the particle's key and the channel: any distinct whole numbers will do
        s = ti.sqrt(r.uniform(1))
        phi = 6.283185307179586 * q.turns * s
        outwards = ti.Vector([ga.cos(phi), 0.0, ga.sin(phi)])
        scatter = q.spread * ti.Vector([r.normal(2), r.normal(3), r.normal(4)])
        return {
            "position": outwards * (s * q.radius) + scatter,
            "velocity": outwards * r.range(q.speed, 5),
            "radius": (1.0 + s) * r.range(q.grain, 6),
        }
