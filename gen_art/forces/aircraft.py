"""An aeroplane as a point with wings: lift, drag and thrust, with control inputs over time."""

import math

from gen_art.backend.runtime import ti
from gen_art.errors import UsageError
from gen_art.forces.base import force
from gen_art.forces.controls import Controlled
from gen_art.forces.steering import Lever, Stick
from gen_art.maths.elementary import cos, sin
from gen_art.registry import param


@force("aircraft")
class Aircraft(Controlled):
    """An aeroplane in co-ordinated flight: a point with wings, an engine, and a pilot's recorded inputs.

    F = 1/2 density w^2 area (C_L n - C_D w / abs(w)) + throttle max_thrust w / abs(w),  w = v - u(x, t)
    C_L = lift_slope angle_of_attack, limited to its value at `stall`
    C_D = drag_coefficient + C_L^2 / (pi efficiency aspect_ratio)
    n perpendicular to w, upwards in the vertical plane of w, rotated about w by `bank`

    angle_of_attack : degrees in YAML and in the file (radians in Python), from zero lift
    bank : degrees in YAML and in the file (radians in Python), positive to the right
    throttle : 0 to 1
    max_thrust : N
    area : m^2, of the wings
    lift_slope : 1/rad
    up : (3,), away from the ground
    controls : a .csv file with the columns time (s) and any of angle_of_attack, bank, throttle, which replace the parameters
    density : kg/m^3; the medium's when left out
    `trim` finds the inputs of level flight. In vertical flight the bank is undefined, and the aeroplane has no lift.
    Use the `rk4` integrator.
    Source: Anderson, Introduction to Flight, chapter 6; McCormick.
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
    steering = {
        "angle_of_attack": Stick(less=("ArrowUp", "w"), more=("ArrowDown", "s"), low=-5.0, high=14.0, seconds=0.4),
        "bank": Stick(less=("ArrowLeft", "a"), more=("ArrowRight", "d"), low=-60.0, high=60.0, seconds=0.7),
        "throttle": Lever(less=("f", "PageDown"), more=("r", "PageUp"), rate=0.6),
    }
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
        forward = w / speed
        up = q.up / q.up.norm()
        lift_up = up - forward * up.dot(forward)
        lift_up /= ti.max(lift_up.norm(), 1e-12)
        bank = self.recorded(1, t, q)
        lift_direction = lift_up * cos(bank) + forward.cross(lift_up) * sin(bank)
        angle = ti.min(ti.max(self.recorded(0, t, q), -q.stall), q.stall)
        lift = q.lift_slope * angle
        drag = q.drag_coefficient + lift * lift / (3.141592653589793 * q.efficiency * q.aspect_ratio)
        pressure = 0.5 * q.density * speed * speed * q.area
        return lift_direction * (pressure * lift) + forward * (self.recorded(2, t, q) * q.max_thrust - pressure * drag)

    def trim(self, speed: float, mass: float, density: float, gravity: float = 9.81) -> tuple[float, float]:
        """(angle_of_attack in radians, throttle) that keep the aeroplane in level flight.

        C_L = m g / (1/2 density speed^2 area), thrust = drag
        speed : m/s
        mass : kg
        density : kg/m^3, of the air
        gravity : m/s^2
        Raises UsageError where the wings or the engine are too weak.
        """
        v = self.values
        pressure = 0.5 * density * speed**2 * v["area"]
        lift = mass * gravity / pressure
        angle = lift / v["lift_slope"]
        drag = v["drag_coefficient"] + lift**2 / (math.pi * v["efficiency"] * v["aspect_ratio"])
        if angle > v["stall"]:
            raise UsageError(
                f"at {speed:g} m/s the wings stall: level flight would need {math.degrees(angle):.1f} degrees"
            )
        throttle = pressure * drag / v["max_thrust"] if v["max_thrust"] else math.inf
        if throttle > 1:
            raise UsageError(
                f"at {speed:g} m/s level flight needs {pressure * drag:.4g} N, and the engine gives {v['max_thrust']:g} N"
            )
        return angle, throttle
