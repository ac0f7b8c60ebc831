"""A world of rigid bodies, for the tests of them."""

import numpy as np

import gen_art as ga

G = 9.81
DOWN = [ga.forces.Gravity()]
SHAPES = {
    "sphere": {"sphere": 0.5},
    "capsule": {"capsule": [1, 0.2]},
    "box": {"box": [1, 0.2, 0.5]},
    "compound": [{"box": [1, 0.1, 0.1]}, {"sphere": 0.2, "at": [0.7, 0.1, 0], "density": 2}],
}


def world(
    members,
    forces=DOWN,
    floor=None,
    *,
    dt=1 / 240,
    precision="f64",
    integrator="leapfrog",
    rigid=None,
    ledger=False,
    **others,
):
    """A simulation of these bodies. floor : friction of a plane without restitution, or colliders."""
    walls = [ga.colliders.Plane(restitution=0.0, friction=floor)] if isinstance(floor, (int, float)) else floor or []
    system = ga.bodies(members).system(rigid=rigid, forces=forces, colliders=walls, integrator=integrator, **others)
    return ga.Simulation({"b": system}, dt=dt, precision=precision, ledger=ledger)


def inside(sim):
    return sim["b"].interactions[0]._world


def speed(sim):
    now = sim.diagnostics()
    return now.momentum / now.mass


def slope(degrees):
    """Angle, normal and the way down of an incline."""
    a = np.radians(degrees)
    return a, np.array([np.sin(a), np.cos(a), 0]), np.array([np.cos(a), -np.sin(a), 0])


def tower(count, points=60):
    return [ga.body({"box": [0.2, 0.2, 0.2]}, position=(0, 0.1 + 0.2 * k, 0), points=points) for k in range(count)]
