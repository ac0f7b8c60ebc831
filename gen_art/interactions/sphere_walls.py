"""Colliders at rest as `contacts` sees them: surfaces that press spheres by the same law as other spheres do."""

import numpy as np

from gen_art.integrators.kernel_terms import KernelTerms
from gen_art.interactions.base import ForcePart, ForceRequest
from gen_art.interactions.sphere_wall_kernels import (
    BLOCK,
    ELASTIC_ROW,
    LOSS_ROW,
    STIFFNESS,
    WALL_NUMBERS,
    wall_kernels,
)

__all__ = ["SphereWalls", "is_wall"]


def is_wall(collider) -> bool:
    """Whether contacts press on a collider: it rests, and an impact bounces."""
    moves = any(collider.values["velocity"]) or collider.rotates
    return collider.values["action"] == "bounce" and not moves


class SphereWalls:
    """The walls of one system.

    names : of the colliders in the ledger
    parts : what the ledger records, an elastic part of each wall and a dissipative one of those that take energy
    """

    def __init__(self, walls, names):
        self.walls, self.names = list(walls), list(names)
        self._composition = KernelTerms((), None, self.walls)
        self.parts: tuple[ForcePart, ...] = ()
        self._rows = []  # the first rows of each wall's parts, -1 for none
        for name, wall in zip(self.names, self.walls):
            rows = [3 * len(self.parts), -1]
            self.parts += (ForcePart(name),)
            if wall.takes_energy:
                rows[1] = 3 * len(self.parts)
                self.parts += (ForcePart(name, dissipates=True),)
            self._rows.append(rows)

    def _numbers(self, response, dtype) -> np.ndarray:
        """(walls, WALL_NUMBERS) of the kernels. response(restitution) -> (stiffness, damping) over the mass."""
        out = np.zeros((len(self.walls), WALL_NUMBERS), dtype)
        for k, wall in enumerate(self.walls):
            kinetic, _ = wall.values["friction"]
            out[k, STIFFNESS:ELASTIC_ROW] = *response(wall.values["restitution"]), kinetic
            out[k, ELASTIC_ROW : LOSS_ROW + 1] = self._rows[k]
        return out

    def accelerate(self, request: ForceRequest, response, rate, rolling, spins, spin, out, angular) -> None:
        """Write the accelerations, m/s^2, of each part to `out`, and add the angular ones, 1/s^2, to `angular`.

        response : see _numbers
        rate : the largest relaxation rate of sliding, 1/s
        rolling : coefficient of rolling friction
        spins : whether spheres rotate, with their spins from row `spin` of the state on
        """
        kernel, _ = wall_kernels(self._composition, spins, request.precision)
        kernel(
            request.rows, request.state.floats, request.n, self._composition.numbers(out.dtype),
            self._numbers(response, out.dtype), rate, rolling, spin, out, angular,
        )  # fmt: skip

    def energy(self, rows: np.ndarray, response, precision: str) -> float:
        """The potential energy, J, of the contacts of the particles with these rows of the state."""
        n = rows.shape[1]
        out = np.zeros(max(1, -(-n // BLOCK)))
        _, kernel = wall_kernels(self._composition, False, precision)
        kernel(rows, n, self._composition.numbers(rows.dtype), self._numbers(response, rows.dtype), out)
        return float(out.sum())
