"""Several bodies as the particles of one system."""

from functools import cached_property

import numpy as np

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.interactions.rigid.body import STATIC, Body
from gen_art.interactions.rigid.quaternions import matrices
from gen_art.interactions.rigid.small_matrices import apply, cross

__all__ = ["ATTRIBUTES", "Group"]

ATTRIBUTES = ("area", "normal_x", "normal_y", "normal_z", "shade", "tint")


class Group:
    """Bodies and the particles that represent them, one body after the other.

    members : the bodies
    position, velocity : (n, 3) m and m/s
    mass, radius : (n,) kg and m
    fixed : (n,) bool
    attributes : ATTRIBUTES of the particles, by name, each (n,)
    Raises UsageError unless there is at least one body.
    """

    def __init__(self, members):
        self.members: list[Body] = arguments.instances("bodies", members, Body, "ga.body({'sphere': 0.5})")
        if not self.members:
            raise UsageError("bodies must be a list of at least one ga.body(...)")
        self.fixed = self._each([b.constraint == STATIC for b in self.members])

    @cached_property
    def _placed(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, velocities and normals; found when they are asked for, since a preset is read several times."""
        rotations = [matrices(b.attitude) for b in self.members]
        arms = [apply(R, b.local) for b, R in zip(self.members, rotations)]
        return (
            np.concatenate([b.place + arm for b, arm in zip(self.members, arms)]),
            np.concatenate([b.velocity + cross(b.spin, arm) for b, arm in zip(self.members, arms)]),
            np.concatenate([apply(R, b.normals) for b, R in zip(self.members, rotations)]),
        )

    @cached_property
    def position(self) -> np.ndarray:
        return self._placed[0]

    @cached_property
    def velocity(self) -> np.ndarray:
        return self._placed[1]

    @cached_property
    def mass(self) -> np.ndarray:
        return np.concatenate([b.masses for b in self.members])

    @cached_property
    def radius(self) -> np.ndarray:
        return np.concatenate([b.radii for b in self.members])

    @cached_property
    def attributes(self) -> dict[str, np.ndarray]:
        area = np.concatenate([b.areas for b in self.members])
        shade, tint = np.zeros(len(area)), self._each([b.tint for b in self.members])
        return dict(zip(ATTRIBUTES, (area, *self._placed[2].T, shade, tint)))

    def _each(self, values) -> np.ndarray:
        """The value of each body, repeated for all its particles."""
        return np.repeat(np.array(values), [len(b.local) for b in self.members])

    def rigid(self, **parameters):
        """The interaction for a ParticleSystem that consists of these particles, in this order."""
        from gen_art.interactions.rigid.interaction import Rigid

        return Rigid(bodies=[b.spec for b in self.members], **parameters)
