"""An aeroplane as a point with wings: lift, drag and thrust under control."""

import math

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import force
from gen_art.forces.controls import Controlled
from gen_art.maths.elementary import cos, sin
from gen_art.registry import param


@force("aircraft")
class Aircraft(Controlled):
    """An aeroplane in co-ordinated flight: a point with wings, an engine, and a pilot's recorded inputs.

    F = 1/2 density w^2 area (C_L n - C_D w / abs(w)) + throttle max_thrust w / abs(w),  w = v - u(x, t)
    C_L = lift_slope angle_of_attack, and no more than at `stall`,  C_D = drag_coefficient + C_L^2 / (pi efficiency aspect_ratio)
    n across w, upwards in the vertical plane of w, turned about w by `bank`

    angle_of_attack, bank : degrees in YAML and in the file (radians in Python); from zero lift, positive to the right
    throttle : 0 to 1     max_thrust : N     area : m^2, of the wings     lift_slope : 1/rad     up : (3,), away from the ground
    controls : a .csv file with the columns time (s) and any of angle_of_attack, bank, throttle: they take the place of the
    parameters. density : kg/m^3; the medium's when left out.  `trim` finds the inputs of level flight. Straight up or down
    it has no bank, and flies as a projectile. Use rk4. Sources: Anderson, Introduction to Flight, chapter 6; McCormick.
    """

    area: float = param(16.0, unit="m^2", min=0)
    lift_slope: float = param(5.0, unit="1/rad", min=0)
    drag_coefficient: float = param(0.03, min=0, doc="without lift")
    aspect_ratio: float = param(7.5, min=1e-6)
    efficiency: float = param(0.8, min=1e-6, max=1, doc="Oswald's, of the induced drag")
    stall: float = param(math.radians(15), unit="rad", min=0, max=math.pi / 2)
    max_thrust: float = param(2500.0, unit="N", min=0)
    angle_of_attack: float = param(math.radians(5), unit="rad", min=-math.pi / 2, max=math.pi / 2)
    bank: float = param(0.0, unit="rad", min=-math.pi, max=math.pi)
    throttle: float = param(0.5, min=0, max=1)
    up: tuple = param((0.0, 1.0, 0.0), doc="away from the ground")
    medium: object = param(None)
    density: float = param(None, unit="kg/m^3", min=0, doc="of the air; the medium's when left out")
    inputs = ("angle_of_attack", "bank", "throttle")
    depends_on_velocity = True
    reads_medium = True

    def prepare(self):
        super().prepare()
        if not any(self.values["up"]):
            raise UsageError("Aircraft: up must not be the null vector")

    @ti.func
    def force(self, p, t, q):
        w = p.velocity - p.flow
        speed = ti.max(w.norm(), 1e-12)
        ahead = w / speed
        up = q.up / q.up.norm()
        above = up - ahead * up.dot(ahead)
        above /= ti.max(above.norm(), 1e-12)
        bank = self.recorded(1, t, q)
        across = above * cos(bank) + ahead.cross(above) * sin(bank)
        attack = ti.min(ti.max(self.recorded(0, t, q), -q.stall), q.stall)
        lift = q.lift_slope * attack
        drag = q.drag_coefficient + lift * lift / (3.141592653589793 * q.efficiency * q.aspect_ratio)
        pressure = 0.5 * q.density * speed * speed * q.area
        return across * (pressure * lift) + ahead * (self.recorded(2, t, q) * q.max_thrust - pressure * drag)

    def trim(self, speed: float, mass: float, density: float, gravity: float = 9.81) -> tuple[float, float]:
        """(angle_of_attack in radians, throttle) that keep `mass` (kg) level at `speed` (m/s) in air of `density` (kg/m^3).

        C_L = m g / (1/2 density speed^2 area), thrust = drag. Raises UsageError where the wings or the engine are too weak.
        """
        v = self.values
        pressure = 0.5 * density * speed**2 * v["area"]
        lift = mass * gravity / pressure
        attack = lift / v["lift_slope"]
        drag = v["drag_coefficient"] + lift**2 / (math.pi * v["efficiency"] * v["aspect_ratio"])
        if attack > v["stall"]:
            raise UsageError(
                f"at {speed:g} m/s the wings stall: level flight would need {math.degrees(attack):.1f} degrees"
            )
        throttle = pressure * drag / v["max_thrust"] if v["max_thrust"] else math.inf
        if throttle > 1:
            raise UsageError(
                f"at {speed:g} m/s level flight needs {pressure * drag:.4g} N, and the engine gives {v['max_thrust']:g} N"
            )
        return attack, throttle
