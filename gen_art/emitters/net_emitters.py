"""Chains, ropes and cloths: initial conditions with the springs that join their particles (`interactions: springs`)."""

import numpy as np

from gen_art.emitters.base import Emitter, emitter
from gen_art.interactions import spring_nets
from gen_art.particles.fixed import FIXED
from gen_art.registry import param

__all__ = ["Chain", "Cloth", "Rope"]


class _NetEmitter(Emitter):
    """A net that is placed once, at the start: `births` particles, of which the pinned ones are fixed."""

    net: spring_nets.Net

    @property
    def births(self) -> int:
        return len(self.net.position)

    @property
    def declares(self) -> tuple[str, ...]:  # type: ignore[override]  # depends on the instance: only with a load
        return () if self.values.get("load") is None else ("along",)

    def sample(self, r, n):
        born = {"position": self.net.position.T, "velocity": np.zeros((3, n))}
        pinned = self.net.pinned(self.values["pinned"])
        if len(pinned):
            born["lifetime"] = np.full(n, np.inf)
            born["lifetime"][pinned] = FIXED
        if self.declares:
            born["along"] = np.linspace(0.0, 1.0, n)
            born["mass"] = np.full(n, np.nan)  # NaN: the mass that the preset gives
            born["mass"][-1] = self.values["load"]
        return born


@emitter("chain")
class Chain(_NetEmitter):
    """Particles in a row, each joined to the next by a spring whose rest length is their distance.

    x_k = start + k (end - start) / (count - 1)
    start, end : (3,) m
    count : at least 2
    pinned : which particles stay in place: none, start, end or ends
    load : kg, mass of the last particle. With a load, all particles have the attribute `along`, from 0 at the start to 1 at the
        end
    """

    start: tuple = param((0.0, 0.0, 0.0), unit="m")
    end: tuple = param((1.0, 0.0, 0.0), unit="m")
    count: int = param(20, min=2, max=1_000_000)
    pinned: str = param("ends", choices=("none", "start", "end", "ends"))
    load: float = param(None, unit="kg", min=1e-300, doc="mass of the last particle; default: as the others")

    def prepare(self):
        v = self.values
        self.net = spring_nets.chain(v["start"], v["end"], v["count"])


@emitter("rope")
class Rope(_NetEmitter):
    """A rope of a given length between two points, in the form of a V if it is longer than their distance.

    rest length of each spring = length / (count - 1)
    start, end : (3,) m
    count : at least 2
    length : m, at least the distance of start and end, which is the default
    bend : share of the stiffness that resists folding
    pinned : which particles stay in place: none, start, end or ends
    load : kg, mass of the last particle. With a load, all particles have the attribute `along`, from 0 at the start to 1 at the
        end
    """

    start: tuple = param((0.0, 0.0, 0.0), unit="m")
    end: tuple = param((1.0, 0.0, 0.0), unit="m")
    count: int = param(50, min=2, max=1_000_000)
    length: float = param(None, unit="m", min=0)
    bend: float = param(0.0, min=0, max=1)
    pinned: str = param("ends", choices=("none", "start", "end", "ends"))
    load: float = param(None, unit="kg", min=1e-300, doc="mass of the last particle; default: as the others")

    def prepare(self):
        v = self.values
        self.net = spring_nets.rope(v["start"], v["end"], v["count"], v["length"], v["bend"])


@emitter("cloth")
class Cloth(_NetEmitter):
    """A sheet of particles joined by springs along its threads, its diagonals and over every other point.

    x = corner + column / (columns - 1) across + row / (rows - 1) down
    corner, across, down : (3,) m
    columns, rows : at least 2
    shear, bend : share of the stiffness of the diagonals, and of the springs against folding
    pinned : which particles stay in place: none, top (row 0), left (column 0), corners (of the top) or four corners
    """

    corner: tuple = param((-0.5, 0.5, 0.0), unit="m")
    across: tuple = param((1.0, 0.0, 0.0), unit="m")
    down: tuple = param((0.0, -1.0, 0.0), unit="m")
    columns: int = param(32, min=2, max=4096)
    rows: int = param(32, min=2, max=4096)
    shear: float = param(0.5, min=0, max=1)
    bend: float = param(0.1, min=0, max=1)
    pinned: str = param("top", choices=("none", "top", "left", "corners", "four corners"))

    def prepare(self):
        v = self.values
        self.net = spring_nets.cloth(
            v["corner"], v["across"], v["down"], v["columns"], v["rows"], v["shear"], v["bend"]
        )
