"""Lift and drag on panels: sails, blades, leaves."""

from gen_art.backend.runtime import ti
from gen_art.forces.base import Force, force
from gen_art.registry import param


@force("panel")
class Panel(Force):
    """Lift and drag on a thin panel, by the angle between panel and flow.

    F = 1/2 density abs(w)^2 area (C_L l - C_D w / abs(w)),  w = v - u(x, t),  sin a = abs(w.n) / abs(w)
    C_L = lift sin a cos a,  C_D = drag sin^2 a + friction
    l perpendicular to w, in the plane of w and n, towards the side of the panel that faces away from the flow

    Needs particles with the attributes area, m^2, and normal_x, normal_y, normal_z, such as those of rigid bodies. Particles
    with a normal of 0 are not panels.
    lift : 2 for a plate in a fast flow; 2 pi for a thin aerofoil at small angles
    drag : 2 makes the force of both perpendicular to the plate
    friction : drag coefficient at any angle
    density : kg/m^3; the medium's when left out
    medium : a ga.Medium; the system's when left out
    A plain kick integrates it at order 1.
    Source: Hoerner, Fluid-Dynamic Drag (1965), chapter 3; Anderson, Fundamentals of Aerodynamics, section 4.7.
    """

    lift: float = param(2.0, min=0)
    drag: float = param(2.0, min=0)
    friction: float = param(0.02, min=0)
    density: float = param(None, unit="kg/m^3", min=0, doc="of the fluid; the medium's when left out")
    medium: object = param(None)
    depends_on_velocity = True
    reads_medium = True
    needs = ("area", "normal_x", "normal_y", "normal_z")

    @ti.func
    def force(self, p, t, q):
        w = p.velocity - p.flow
        n = ti.Vector([p.normal_x, p.normal_y, p.normal_z])
        speed = ti.max(w.norm(), 1e-30)
        direction = w / speed
        sine = direction.dot(n)
        # perpendicular to the flow, of length abs(cos a) sin a, away from the side that faces the flow
        lift = (direction * sine - n) * sine
        drag = direction * -(q.drag * sine * sine + q.friction * n.dot(n))
        return (lift * q.lift + drag) * (0.5 * q.density * speed * speed * p.area)
