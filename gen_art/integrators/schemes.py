"""The integrators as data.

A splitting scheme is an initial drift followed by stages of a kick and a drift, all in fractions of dt; the kick is the closed
form of constant acceleration with drag (tile.py). A Runge-Kutta scheme is explicit: each stage has a weight, its time, and the
fraction of dt that leads to the next stage's state.
Sources: Hairer, Lubich, Wanner, Geometric Numerical Integration; Yoshida (1990), Phys. Lett. A 150, 262; Boris (1970).
"""

import math
from dataclasses import dataclass, replace

from gen_art.arguments import shown
from gen_art.errors import UsageError
from gen_art.registry import suggest

__all__ = [
    "AHEAD", "DRIFT", "FIRST_DRIFT", "INTEGRATORS", "KICK", "STAGE", "Scheme", "TIME", "WEIGHT", "charged", "scheme",
]  # fmt: skip

# Places in P, the scheme's numbers: the first drift, then stage g from STAGE g on, and the speed of light as the last number.
FIRST_DRIFT, STAGE = 0, 3
KICK, TIME, DRIFT = 1, 2, 3  # fractions of dt, of a splitting scheme
WEIGHT, AHEAD = 1, 3  # of Runge-Kutta: the stage's weight, and the fraction of dt that leads to the next stage's state


@dataclass(frozen=True)
class Scheme:
    """One integrator.

    stages : (kick, time, drift) for splitting, (weight, time, ahead) for Runge-Kutta, fractions of dt
    first_drift : fraction of dt
    pusher : "boris", "vay" or "higuera_cary"; "" for a plain kick
    light : speed of light, m/s; 0 for Newtonian mechanics
    exact : whether the rotation in a magnetic field has the exact phase
    stability_limit : the largest w dt at which the energy of an oscillator stays bounded; 0 if it grows at any step. rk2's
        growth, (w dt)^4 / 8 a step, counts as bounded up to 0.5
    energy_error : (k, c), the relative change c (w dt)^k of an oscillator's energy in a step; (0, 0) if it stays bounded
    """

    name: str
    order: int
    kind: str
    stages: tuple[tuple[float, float, float], ...]
    first_drift: float = 0.0
    pusher: str = ""
    light: float = 0.0
    exact: bool = False
    doc: str = ""
    stability_limit: float = 2.0
    energy_error: tuple[int, float] = (0, 0.0)

    @property
    def is_leapfrog(self) -> bool:
        """Whether a step is half a kick, a drift, and half a kick."""
        return self.kind == "splitting" and self.stages == _KDK and not self.first_drift

    @property
    def rotation(self) -> tuple[str, bool, bool]:
        """How a magnetic field rotates the velocity: (pusher, relativistic, exact phase)."""
        return self.pusher, self.light > 0, self.exact

    @property
    def numbers(self) -> list[float]:
        """P, the scheme's run-time numbers: the first drift, three numbers of each stage, the speed of light."""
        return [self.first_drift, *(c for stage in self.stages for c in stage), self.light]


_CBRT2 = 2.0 ** (1.0 / 3.0)
_W1 = 1.0 / (2.0 - _CBRT2)
_W0 = -_CBRT2 * _W1
_KDK = ((0.5, 0.0, 1.0), (0.5, 1.0, 0.0))

INTEGRATORS = {
    s.name: s
    for s in (
        Scheme(
            "euler",
            1,
            "runge_kutta",
            ((1.0, 0.0, 0.0),),
            doc="explicit; gains energy, for comparison",
            stability_limit=0.0,
            energy_error=(2, 1.0),
        ),
        Scheme("semi_implicit_euler", 1, "splitting", ((1.0, 0.0, 1.0),), doc="kick, then drift; symplectic"),
        Scheme(
            "rk2",
            2,
            "runge_kutta",
            ((0.0, 0.0, 0.5), (1.0, 0.5, 0.0)),
            doc="explicit midpoint",
            stability_limit=0.5,
            energy_error=(4, 1 / 4),
        ),
        Scheme(
            "rk4",
            4,
            "runge_kutta",
            ((1 / 6, 0.0, 0.5), (1 / 3, 0.5, 0.5), (1 / 3, 0.5, 1.0), (1 / 6, 1.0, 0.0)),
            doc="classical; drag is inside its stages",
            stability_limit=2.8284,
            energy_error=(6, -1 / 72),
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
            stability_limit=1.5734,
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
    """The scheme with a speed of light, m/s, and the exact phase. Raises UsageError for combinations that are impossible."""
    pushers = ", ".join(name for name, s in INTEGRATORS.items() if s.pusher)
    if (light is not None or exact) and not used.pusher:
        what = "speed_of_light" if light is not None else "exact_gyration"
        raise UsageError(f"{what} needs an integrator for charges ({pushers}), not {used.name}")
    if light is not None and not (math.isfinite(light) and light > 0):
        raise UsageError(f"speed_of_light must be above 0 m/s, not {light}")
    for one in forces:
        if one.provides("noise") and (used.kind != "splitting" or any(kick < 0 for kick, _, _ in used.stages)):
            raise UsageError(
                f"{one.name} adds noise in kicks that go forwards in time: use leapfrog, position_verlet, semi_implicit_euler or "
                f"boris, not {used.name}"
            )
    if light is not None:
        for one in forces:
            if one.provides("damping"):
                raise UsageError(f"{one.name} is not relativistic: leave out speed_of_light, or {one.name}")
            if one.provides("mass_rate") or one.provides("mass_loss"):
                raise UsageError(
                    f"{one.name} takes mass, which a relativistic particle keeps: leave out speed_of_light"
                )
        for one in interactions:
            if one.implicit or any(part.dissipates for part in one.parts):
                raise UsageError(
                    f"the losses of {one.name} are not relativistic: leave out speed_of_light, or the losses"
                )
        if colliders:
            raise UsageError("colliders bounce slow particles: leave out speed_of_light, or the colliders")
    return replace(used, light=float(light or 0.0), exact=bool(exact))


def scheme(name: str) -> Scheme:
    """The integrator of that name. Raises UsageError, which suggests the most similar name."""
    if not isinstance(name, str):
        raise UsageError(f"integrator must be a name such as 'leapfrog', not {shown(name)}")
    if name not in INTEGRATORS:
        raise UsageError(f"unknown integrator '{name}'{suggest(name, INTEGRATORS)} (one of {', '.join(INTEGRATORS)})")
    return INTEGRATORS[name]
