"""Groups of bodies that move as a whole: turned, put somewhere, or on an orbit with another group."""

import numpy as np

from gen_art.emitters.base import Emitter
from gen_art.errors import UsageError
from gen_art.registry import param

__all__ = ["PlacedEmitter", "two_body_orbit"]


def two_body_orbit(G: float, mass: float, other_mass: float, pericenter: float, eccentricity: float, separation: float):
    """Position and velocity of the second of two bodies relative to the first, (2,) and (2,), before they are closest.

    On the conic r = p / (1 + e cos nu), p = pericenter (1 + e), of two points: v = sqrt(G (m1 + m2) / p) (-sin nu, e + cos nu).
    At nu = 0 the second body is at (pericenter, 0) and goes towards +y.
    pericenter, separation : m, their smallest and their present distance
    eccentricity : 0 circle, below 1 ellipse, 1 parabola, above 1 hyperbola
    Raises UsageError for a distance that the orbit never has. Source: Landau & Lifshitz, Mechanics, section 15.
    """
    p = pericenter * (1 + eccentricity)
    if separation < pericenter:
        raise UsageError(f"separation must be at least the pericenter, {pericenter:g}, not {separation:g}")
    cosine = 1.0 if eccentricity == 0 else (p / separation - 1) / eccentricity
    if cosine < -1 or (eccentricity == 0 and separation != pericenter):
        farthest = p / (1 - eccentricity)
        raise UsageError(f"separation must be at most {farthest:g}, where this orbit turns back, not {separation:g}")
    sine = -np.sqrt(max(1 - cosine * cosine, 0.0))
    speed = np.sqrt(G * (mass + other_mass) / p)
    return separation * np.array([cosine, sine]), speed * np.array([-sine, eccentricity + cosine])


class PlacedEmitter(Emitter):
    """Bodies that are drawn about the origin, with +y as their axis, and then turned and moved as a whole.

    With a `companion`, they start on a two-body orbit with another group of that mass: about the common centre of mass, in the
    plane across y, anticlockwise as seen from +y, before they are closest. The companion's own emitter has `second: true` and
    the masses the other way round.
    """

    shares_mass = True
    axis: tuple = param((0.0, 1.0, 0.0), doc="the axis that its own +y is turned to")
    center: tuple = param(
        (0.0, 0.0, 0.0), unit="m", doc="its place; with a companion, that of the common centre of mass"
    )
    drift: tuple = param((0.0, 0.0, 0.0), unit="m/s", doc="its velocity; with a companion, that of the centre of mass")
    companion: float = param(None, unit="kg", min=0, doc="mass of the other group of an encounter")
    pericenter: float = param(1.0, unit="m", min=1e-30, doc="their smallest distance, if they were points")
    eccentricity: float = param(1.0, min=0, max=100, doc="0 is a circle, 1 a parabola, more a hyperbola")
    separation: float = param(None, unit="m", min=1e-30, doc="their distance at the start; 4 pericenters when left out")
    second: bool = param(False, doc="whether this is the companion")

    @property
    def total_mass(self) -> float:
        """The mass, kg, with which it moves on the orbit: its parameter `mass`, where the class says nothing else."""
        return self.values["mass"]

    def prepare(self):
        if not any(self.values["axis"]):
            raise UsageError(f"{self.name}: axis must not be the null vector")
        self.whole_motion()

    def whole_motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Its place and velocity as a whole, (3,) and (3,)."""
        v = self.values
        place, velocity = np.array(v["center"]), np.array(v["drift"])
        if v["companion"] is not None:
            mass, other = self.total_mass, v["companion"]
            if mass + other <= 0:
                raise UsageError(f"{self.name}: an orbit needs a mass above 0")
            distance = 4 * v["pericenter"] if v["separation"] is None else v["separation"]
            x, w = two_body_orbit(v["G"], mass, other, v["pericenter"], v["eccentricity"], distance)
            share = (other if v["second"] else -other) / (mass + other)
            place = place + share * np.array([x[0], 0, -x[1]])  # y is up: anticlockwise from x towards -z
            velocity = velocity + share * np.array([w[0], 0, -w[1]])
        return place, velocity

    def placed(self, born: dict) -> dict:
        """What `sample` returns, turned and moved."""
        turn, (place, velocity) = _turn_to(np.array(self.values["axis"])), self.whole_motion()
        for name, offset in (("position", place), ("velocity", velocity)):
            x, y, z = born[name]
            born[name] = np.stack([row[0] * x + row[1] * y + row[2] * z + o for row, o in zip(turn, offset)])
        return born


def _turn_to(axis: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) that takes +y to an axis the shortest way."""
    a, b, c = axis / np.sqrt((axis * axis).sum())
    if b < -1 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    k = 1 / (1 + b)
    return np.array([[1 - k * a * a, a, -k * a * c], [-a, b, -c], [-k * a * c, c, 1 - k * c * c]])
