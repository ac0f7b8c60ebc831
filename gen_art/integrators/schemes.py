"""The integrators, as data: what they compose and the order of the whole.

A splitting scheme is an initial drift and then stages of a kick followed by a drift, all fractions of dt; the kick is the
closed form of constant acceleration with drag (kernels.py). A Runge-Kutta scheme is explicit: each stage has a weight, the
fraction of dt that leads to the next stage's state, and its time.
Sources: Hairer, Lubich, Wanner, Geometric Numerical Integration; Yoshida (1990), Phys. Lett. A 150, 262; Boris (1970).
"""

import math
from dataclasses import dataclass, replace

from gen_art.errors import UsageError
from gen_art.registry import suggest

__all__ = ["INTEGRATORS", "Scheme", "charged", "stability_limit", "scheme"]


@dataclass(frozen=True)
class Scheme:
    """One integrator. `stages` are (kick, time, drift) for splitting, (weight, time, next) for Runge-Kutta."""

    name: str
    order: int
    kind: str
    stages: tuple[tuple[float, float, float], ...]
    first_drift: float = 0.0
    pusher: str = ""
    light: float = 0.0
    exact: bool = False
    doc: str = ""

    @property
    def rotates(self) -> tuple[str, bool, bool]:
        """What turns the velocity in a magnetic field: (pusher, relativistic, exact phase); no pusher: a plain kick."""
        return self.pusher, self.light > 0, self.exact

    @property
    def numbers(self) -> list[float]:
        """The scheme's run-time numbers for its kernel: the first drift, then each stage's three, then the speed of light."""
        return [self.first_drift, *(c for stage in self.stages for c in stage), self.light]


_CBRT2 = 2.0 ** (1.0 / 3.0)
_W1 = 1.0 / (2.0 - _CBRT2)
_W0 = -_CBRT2 * _W1
_KDK = ((0.5, 0.0, 1.0), (0.5, 1.0, 0.0))

INTEGRATORS = {
    s.name: s
    for s in (
        Scheme("euler", 1, "runge_kutta", ((1.0, 0.0, 0.0),), doc="explicit; gains energy, for comparison"),
        Scheme("semi_implicit_euler", 1, "splitting", ((1.0, 0.0, 1.0),), doc="kick, then drift; symplectic"),
        Scheme("rk2", 2, "runge_kutta", ((0.0, 0.0, 0.5), (1.0, 0.5, 0.0)), doc="explicit midpoint"),
        Scheme(
            "rk4",
            4,
            "runge_kutta",
            ((1 / 6, 0.0, 0.5), (1 / 3, 0.5, 0.5), (1 / 3, 0.5, 1.0), (1 / 6, 1.0, 0.0)),
            doc="classical; drag is inside its stages",
        ),
        Scheme(
            "position_verlet", 2, "splitting", ((1.0, 0.5, 0.5),), 0.5, doc="drift-kick-drift; one evaluation a step"
        ),
        Scheme("velocity_verlet", 2, "splitting", _KDK, doc="the same scheme as leapfrog"),
        Scheme("leapfrog", 2, "splitting", _KDK, doc="kick-drift-kick; symplectic, reversible"),
        Scheme(
            "yoshida4",
            4,
            "splitting",
            (
                (_W1, _W1 / 2, (_W1 + _W0) / 2),
                (_W0, 0.5, (_W1 + _W0) / 2),
                (_W1, 1.0 - _W1 / 2, _W1 / 2),
            ),
            _W1 / 2,
            doc="three drift-kick-drifts; symplectic",
        ),
        Scheme(
            "boris",
            2,
            "splitting",
            ((1.0, 0.5, 0.5),),
            0.5,
            pusher="boris",
            doc="for magnetic fields; keeps the speed exactly",
        ),
        Scheme(
            "vay",
            2,
            "splitting",
            ((1.0, 0.5, 0.5),),
            0.5,
            pusher="vay",
            doc="for fast charges: keeps the drift in crossed fields at any speed; boris where speed_of_light is left out",
        ),
        Scheme(
            "higuera_cary",
            2,
            "splitting",
            ((1.0, 0.5, 0.5),),
            0.5,
            pusher="higuera_cary",
            doc="for fast charges: keeps phase space and the drift; boris where speed_of_light is left out",
        ),
    )
}


def charged(used: Scheme, forces, light: float | None, exact: bool, interactions=(), colliders=()) -> Scheme:
    """The scheme with a speed of light, m/s, and the exact phase. Raises UsageError for what cannot be combined."""
    pushers = ", ".join(name for name, s in INTEGRATORS.items() if s.pusher)
    if (light is not None or exact) and not used.pusher:
        what = "speed_of_light" if light is not None else "exact_gyration"
        raise UsageError(f"{what} needs an integrator for charges ({pushers}), not {used.name}")
    if light is not None and not (math.isfinite(light) and light > 0):
        raise UsageError(f"speed_of_light must be above 0 m/s, not {light}")
    if light is not None:
        for one in forces:
            if one.provides("damping"):
                raise UsageError(f"{one.name} is not relativistic: leave out speed_of_light, or {one.name}")
            if one.provides("mass_rate") or one.provides("mass_loss"):
                raise UsageError(
                    f"{one.name} takes mass, which a relativistic particle keeps: leave out speed_of_light"
                )
        for one in interactions:
            if one.implicit or len(one.parts) > 1:
                raise UsageError(
                    f"the losses of {one.name} are not relativistic: leave out speed_of_light, or the losses"
                )
        if colliders:
            raise UsageError("colliders bounce slow particles: leave out speed_of_light, or the colliders")
    return replace(used, light=float(light or 0.0), exact=bool(exact))


def stability_limit(used: Scheme) -> float:
    """The largest w dt at which an oscillator's energy stays bounded; 0 where it grows at any step.

    rk2's growth, (w dt)^4 / 8 a step, is counted as bounded up to 0.5.
    """
    return {"euler": 0.0, "rk2": 0.5, "rk4": 2.8284, "yoshida4": 1.5734}.get(used.name, 2.0)


def scheme(name: str) -> Scheme:
    """The integrator of that name; UsageError names the nearest."""
    if name not in INTEGRATORS:
        raise UsageError(f"unknown integrator '{name}'{suggest(name, INTEGRATORS)} (one of {', '.join(INTEGRATORS)})")
    return INTEGRATORS[name]
