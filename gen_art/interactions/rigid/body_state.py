"""What a rigid body does now, as a script reads it."""

from dataclasses import dataclass

import numpy as np

from gen_art.interactions.rigid.body import motion_text
from gen_art.interactions.rigid.quaternions import matrices, rotation
from gen_art.interactions.rigid.small_matrices import compose, transposed
from gen_art.interactions.rigid.world import World

__all__ = ["BodyState", "body_states"]


@dataclass(frozen=True, eq=False, repr=False)
class BodyState:
    """A rigid body at the time of its simulation; later steps do not change it.

    name : as given to ga.body, or of its emitter
    mass : kg
    position : (3,) m, of the centre of mass, or of the pivot where it has one
    velocity : (3,) m/s, of that point
    rotation : (3, 3) matrix from the frame of its shape to the world: the columns are the shape's axes x, y and z
    spin : (3,) rad/s
    angular_momentum : (3,) kg m^2/s, about that point
    """

    name: str
    mass: float
    position: np.ndarray
    velocity: np.ndarray
    rotation: np.ndarray
    spin: np.ndarray
    angular_momentum: np.ndarray

    def __repr__(self) -> str:
        return f"<BodyState '{self.name}': {motion_text(self.mass, self.position, self.velocity, self.spin)}>"


def body_states(world: World) -> list[BodyState]:
    """The states of a world's bodies, in the order in which they were given."""
    start = matrices(np.array([body.attitude for body in world.members]))
    turned = matrices(rotation(np.array([body.spec["turn"] for body in world.members], float)))
    rotations = compose(compose(world.R, transposed(start)), turned)  # first as given, then what was turned since
    return [
        BodyState(
            body.name,
            body.mass,
            world.x[k].copy(),
            world.v[k].copy(),
            rotations[k],
            world.w[k].copy(),
            world.L[k].copy(),
        )
        for k, body in enumerate(world.members)
    ]
