"""Rigid bodies that meet: where they touch, what they exchange, colliders of all kinds, and what is refused."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.interactions.rigid.quaternions import matrices, rotation
from tests.physics.bodies import SHAPES, G, inside, slope, speed, world

# -- where they touch


@pytest.mark.parametrize("one", ["sphere", "capsule", "box"])
@pytest.mark.parametrize("two", ["sphere", "capsule", "box"])
def test_contacts_lie_where_the_shapes_are_nearest(one, two):
    """Against the nearest of 10,000 points on one shape to the other: the least gap, and its normal leads apart."""
    from gen_art.interactions.rigid.collision_detection import Shapes, detect_contacts
    from gen_art.interactions.rigid.shapes import parts_of

    r = np.random.default_rng(7)
    parts = [parts_of(SHAPES[k])[0] for k in (one, two)]
    clouds = [np.concatenate([p.surface(np.sqrt(p.area / 4000))[0], p.wires(p.wire_length() / 1000)[0]]) for p in parts]
    errors = []
    for _ in range(8):
        turns = [matrices(rotation(r.normal(size=3) * 2)) for _ in parts]
        way = r.normal(size=3)
        way /= np.linalg.norm(way)
        near, far = 0.0, 3.0
        for _ in range(24):  # to where they are about 5 mm apart
            middle = 0.5 * (near + far)
            gap = nearest(parts, clouds, turns, way * middle)
            near, far = (middle, far) if gap < 5e-3 else (near, middle)
        places = np.array([np.zeros(3), way * near])
        shapes = Shapes(
            np.array([p.kind for p in parts]), np.array([0, 1]), np.array([p.half for p in parts]),
            np.array([p.radius for p in parts]), places, np.array(turns),
        )  # fmt: skip
        found = detect_contacts(shapes, np.array([0.05, 0.05]), np.array([True, True]))
        assert len(found.gap) >= 1
        k = found.gap.argmin()
        errors.append(found.gap[k] - 5e-3)
        sign = 1.0 if found.first[k] == 0 else -1.0
        assert nearest(parts, clouds, turns, way * near - sign * 0.01 * found.normal[k]) > 0.012
    assert np.abs(np.median(errors)) < 1.5e-3 and np.max(errors) < 1e-3 and np.min(errors) > -5e-3


def nearest(parts, clouds, turns, shift):
    """The distance between two shapes, the second of which stands at `shift`, by their points."""
    there = [c @ t.T for c, t in zip(clouds, turns)]
    gaps = parts[1].distance((there[0] - shift) @ turns[1]), parts[0].distance((there[1] + shift) @ turns[0])
    return min(g.min() for g in gaps)


# -- collisions


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-13), ("f32", 3e-6)])
def test_two_spheres_meet(precision, tolerance):
    """Elastic along the line: v = (m1 - m2) v0 / (m1 + m2) and 2 m1 v0 / (m1 + m2); nothing is lost off it either."""
    one = ga.body({"sphere": 0.1}, mass=3, position=(-0.5, 0, 0), velocity=(2, 0, 0))
    two = ga.body({"sphere": 0.15}, mass=1, position=(0.3, 0, 0))
    off = ga.body({"sphere": 0.15}, mass=1, position=(0.3, 0.1, 0.05), velocity=(-1, 0.1, 0), spin=(0, 9, 0))
    for members, friction in (((one, two), 0.0), ((one, off), 0.0), ((one, off), 0.4)):
        sim = world(
            members,
            forces=[],
            precision=precision,
            dt=1 / 120,
            rigid={"restitution": 1.0, "friction": friction},
            ledger=True,
        )
        first = sim.diagnostics()
        sim.step(40)
        now, v = sim.diagnostics(), inside(sim).v
        assert np.abs(now.momentum - first.momentum).max() < tolerance * 6
        assert np.abs(now.angular_momentum - first.angular_momentum).max() < tolerance * 6
        if members[1] is two:
            assert v[:, 0] == pytest.approx([1.0, 3.0], rel=tolerance * 10)
        assert np.abs(v[0] - [2, 0, 0]).max() > 0.1
        if friction == 0:
            assert now.energy == pytest.approx(first.energy, rel=tolerance * 10)
        else:
            assert now.energy < first.energy * 0.999
        assert abs(sim.ledger().residual) < tolerance * 100 * first.energy


@pytest.mark.parametrize(
    "restitution,friction", [pytest.param(1.0, 0.0, marks=pytest.mark.proof), (1.0, 0.4), (0.6, 0.3)]
)
def test_bouncing_block_never_gains_energy(restitution, friction):
    one = ga.body(
        {"box": [0.4, 0.2, 0.3]}, position=(0, 1, 0), turn=(0.3, 0.2, 0.5), spin=(1, 2, 3), velocity=(0.5, 0, 0)
    )
    sim = world([one], floor=[ga.colliders.Plane(restitution=restitution, friction=friction)], ledger=True)
    energy = [sim.diagnostics().energy]
    for _ in range(240):
        sim.step(1)
        energy.append(sim.diagnostics().energy)
    steps = np.diff(energy)
    assert steps.max() < 1e-8 * energy[0]
    assert inside(sim).contacts.gap.min(initial=0) > -1e-3
    if restitution == 1.0:
        assert energy[-1] > 0.9 * energy[0]  # a contact may rest for a moment, and then takes a little
    else:
        assert energy[-1] < 0.7 * energy[0]
    assert abs(sim.ledger().residual) < 1e-7 * energy[0]


@pytest.mark.parametrize("e,tolerance", [(0.8, 2e-4), (1.0, 1e-12)])
def test_a_ball_bounces_to_its_height(e, tolerance):
    """Each top is e^2 of the last, by what height and speed come to: the impact is met in time, inside its step."""
    ball = ga.body({"sphere": 0.1}, position=(0, 1.1, 0), mass=1)
    sim = world([ball], floor=[ga.colliders.Plane(restitution=e)], dt=1 / 240, ledger=True)
    fall = np.sqrt(2 / G)
    for bounce in range(1, 4):
        sim.step(round((fall * (1 + 2 * sum(e**k for k in range(1, bounce)) + e**bounce)) / sim.dt) - sim.steps_done)
        height, speed = inside(sim).x[0, 1] - 0.1, inside(sim).v[0, 1]
        assert height + speed**2 / (2 * G) == pytest.approx(e ** (2 * bounce), rel=tolerance)
        assert abs(speed) < 3e-3 + G * sim.dt  # near the top at its time
    assert abs(sim.ledger().residual) < 1e-12


def test_blocks_of_all_shapes_collide_and_come_to_rest():
    """Thrown together, with colliders of every kind: momentum is kept in flight, nothing sinks in, all rest, the account closes."""
    r = np.random.default_rng(4)
    shapes = [{"sphere": 0.12}, {"capsule": [0.25, 0.08]}, {"box": [0.3, 0.15, 0.2]}, SHAPES["compound"]]
    small = [{k: np.multiply(v, 0.4).tolist() if k != "density" else v for k, v in p.items()} for p in shapes[3]]
    shapes[3] = small
    members = [
        ga.body(shapes[k % 4], position=(0.5 * (k % 3 - 1), 0.6 + 0.5 * (k // 3), 0.1 * (k % 2)), turn=r.normal(size=3), points=60)
        for k in range(9)
    ]  # fmt: skip
    walls = [
        ga.colliders.Box((-1, 0, -1), (1, 5, 1), restitution=0.2, friction=0.5),
        ga.colliders.Sphere((0.1, 0, 0), 0.3, restitution=0.2, friction=0.5),
        ga.colliders.Block((-1, 0, -1), (-0.7, 0.2, 1), restitution=0.2, friction=0.5),
        ga.colliders.Capsule((0.8, 0, -1), (0.8, 0.1, 1), 0.1, restitution=0.2, friction=0.5),
    ]
    sim = world(members, floor=walls, dt=1 / 160, rigid={"restitution": 0.2, "friction": 0.5}, ledger=True)
    deepest, energy = 0.0, [sim.diagnostics().energy]
    for _ in range(12):
        sim.step(20)
        deepest = min(deepest, inside(sim).contacts.gap.min(initial=0))
        energy.append(sim.diagnostics().energy)
    assert deepest > -0.012
    assert inside(sim).contacts.gap.min() > -1.5e-3  # what sank in on the way has been taken back
    assert np.diff(energy).max() < 1e-3 * energy[0]
    assert sim.diagnostics().kinetic_energy < 0.02 * energy[0]
    account = sim.ledger()
    assert abs(account.residual) < 1e-6 * account.scale
    assert np.abs(account.momentum_residual).max() < 1e-9
    assert set(account.impulse) == {"b.gravity", "b.rigid", "b.box", "b.sphere", "b.block", "b.capsule"}
    assert account.impulse["b.sphere"][1] > 0


def test_colliders_that_move_or_are_given_by_distance():
    """A belt carries a block along and books its work; a bowl given as an array of distances holds a ball."""
    block = ga.body({"box": [0.4, 0.2, 0.3]}, position=(0, 0.1, 0))
    belt = ga.colliders.Plane(restitution=0.0, friction=0.3, velocity=(0.5, 0, 0))
    sim = world([block], floor=[belt], ledger=True)
    sim.step(72)
    assert speed(sim)[0] == pytest.approx(0.5, rel=1e-9)  # after v / mu g = 0.17 s
    account = sim.ledger()
    assert account.work["b.plane"] == pytest.approx(
        block.mass * 0.25, rel=1e-6
    )  # half of it to the block, half to heat
    assert account.dissipated["b.rigid"] == pytest.approx(block.mass * 0.125, rel=1e-6)
    assert abs(account.residual) < 1e-9 * account.scale

    axis = np.linspace(-1, 1, 41)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    bowl = ga.colliders.SDF(0.9 - np.sqrt(x**2 + y**2 + z**2), restitution=0.0, friction=0.2)
    ball = ga.body({"sphere": 0.2}, position=(0.5, -0.2, 0))
    sim = world([ball], floor=[bowl], dt=1 / 120)
    sim.step(90)
    far = np.linalg.norm(inside(sim).x[0])
    assert 0.6 < far < 0.71 and inside(sim).x[0, 1] < -0.5


def test_a_lift_takes_a_block_up():
    """A plane, and a block that stands in the way, rise at 0.2 m/s with what lies on them, and work against gravity."""
    up = {"velocity": (0, 0.2, 0), "restitution": 0.0, "friction": 0.3}
    for lift in (ga.colliders.Plane(**up), ga.colliders.Block((-1, -1, -1), (1, 0, 1), **up)):
        one = ga.body({"box": [0.4, 0.2, 0.3]}, position=(0, 0.1, 0))
        sim = world([one], floor=[lift], ledger=True)
        sim.step(48)
        assert inside(sim).x[0, 1] == pytest.approx(0.1 + 0.2 * sim.time, abs=1e-6)
        account = sim.ledger()
        assert account.work[f"b.{lift.name}"] == pytest.approx(one.mass * (0.04 + G * 0.2 * sim.time), rel=1e-2)
        assert abs(account.residual) < 1e-6 * account.scale


def test_what_has_sunk_in_is_taken_back():
    """A block 5 mm in the floor rises to where it may stay, 0.5 % of its size, without speed; the account has the work."""
    one = ga.body({"box": [0.2, 0.2, 0.2]}, position=(0, 0.1, 0))
    sim = world([one], floor=0.5)
    inside(sim).x[0, 1] -= 5e-3
    inside(sim).contacts.detect(0.0)
    inside(sim)._write_particles(sim["b"].state, True)
    sim.keep_ledger()
    energy = sim.diagnostics().energy
    sim.step(60)
    assert inside(sim).contacts.gap.min() == pytest.approx(-1e-3, abs=1e-4)
    assert np.abs(inside(sim).v).max() < 1e-9
    assert sim.diagnostics().energy - energy == pytest.approx(one.mass * G * 4e-3, rel=0.03)
    assert sim.ledger().dissipated["b.rigid"] == pytest.approx(energy - sim.diagnostics().energy, rel=1e-6)


def test_nearest_points_of_segments():
    """Against all pairs of 401 points on each."""
    from gen_art.interactions.rigid.collision_detection import _between_segments

    c, u, d, v = np.random.default_rng(3).normal(size=(4, 60, 3))
    v[:5] = u[:5]  # parallel
    a, b = _between_segments(c, u, d, v)
    found = np.linalg.norm(c + a[:, None] * u - d - b[:, None] * v, axis=1)
    s = np.linspace(-1, 1, 401)
    grid = (c - d)[:, None, None] + s[:, None, None] * u[:, None, None] - s[:, None] * v[:, None, None]
    best = np.sqrt((grid**2).sum(-1)).min((1, 2))
    assert np.abs(found - best).max() < 5e-3


@pytest.mark.parametrize("integrator", ["semi_implicit_euler", "velocity_verlet"])
def test_other_integrators(integrator):
    """A block comes to rest on an incline; one that slides has its acceleration."""
    for mu, degrees in ((0.5, 20), (0.2, 20)):
        a, n, way = slope(degrees)
        one = ga.body({"box": [0.4, 0.2, 0.3]}, position=n * 0.1, turn=(0, 0, -a))
        plane = ga.colliders.Plane(normal=n, restitution=0.0, friction=mu)
        sim = world([one], floor=[plane], integrator=integrator)
        sim.step(40)
        expected = max(0.0, G * (np.sin(a) - mu * np.cos(a))) * sim.time
        assert speed(sim) @ way == pytest.approx(expected, rel=1e-8, abs=1e-10)


# -- what it is asked wrongly


def test_refusals():
    def start(members, **others):
        return world(members, **others)

    near = [ga.body({"sphere": 0.5}, name="one"), ga.body({"box": [1, 1, 1]}, position=(0.9, 0, 0), name="two")]
    with pytest.raises(ga.UsageError, match=r"body 1 \('one'\) and body 2 \('two'\) overlap by 0.1 m"):
        start(near)
    with pytest.raises(ga.UsageError, match=r"body 1 \('low'\) and the plane overlap by 0.2 m"):
        start([ga.body({"sphere": 0.5}, position=(0, 0.3, 0), name="low")], floor=0.1)
    with pytest.raises(ga.UsageError, match="leapfrog, velocity_verlet or semi_implicit_euler"):
        start([ga.body({"sphere": 0.5})], integrator="rk4")
    with pytest.raises(ga.UsageError, match="cannot be kill"):
        start([ga.body({"sphere": 0.5})], floor=[ga.colliders.Plane(action="kill")])
    with pytest.raises(ga.UsageError, match="did you mean 'sphere'"):
        ga.body({"spere": 0.5})
    with pytest.raises(ga.UsageError, match="box must be 3 finite numbers"):
        ga.body({"box": 0.5})
    with pytest.raises(ga.UsageError, match="sizes must be above 0"):
        ga.body({"sphere": 0})
    with pytest.raises(ga.UsageError, match="spin must be along the axle"):
        ga.body({"sphere": 0.5}, axle=(0, 1, 0), spin=(1, 0, 0))
    with pytest.raises(ga.UsageError, match="no velocity of its own"):
        ga.body({"sphere": 0.5}, axle=(0, 1, 0), velocity=(1, 0, 0))
    with pytest.raises(ga.UsageError, match="points must be a whole number from 8"):
        ga.body({"sphere": 0.5}, points=3)
    with pytest.raises(ga.UsageError, match="no rigid bodies"):
        system = ga.ParticleSystem(position=np.zeros((1, 3)), interactions=[ga.interactions.Rigid()])
        ga.Simulation({"s": system}, dt=0.01)


@pytest.mark.parametrize("restitution", [1.0, 0.3])
def test_a_row_hands_on_the_part_of_a_speed_that_its_restitution_leaves(restitution):
    """Newton's cradle: the last of five spheres leaves at ((1 + e) / 2)^4 of the first one's speed."""
    speed, gap, dt = 1.5, 0.014, 1 / 240
    sim = row(restitution, speed, gap, dt)
    last = sim["c"].attribute("tint") == 4
    for _ in range(200):
        sim.step(1)
        out = sim["c"].velocity[last, 0].max()
        if out > 0:
            break
    assert out == pytest.approx(speed * ((1 + restitution) / 2) ** 4, rel=1e-12)
    if restitution == 1.0:  # one in, one out
        assert np.abs(sim["c"].velocity[~last]).max() < 1e-12
    wrong = row(0.99 * restitution, speed, gap, dt)  # the mutant: a restitution 1% off
    wrong.step(60)
    assert abs(wrong["c"].velocity[last, 0].max() - out) > 1e-3 * speed


def row(restitution, speed, gap, dt):
    """Five spheres in a line, `gap` m apart, the first of which comes in at `speed`."""
    bodies = ga.bodies(
        ga.body({"sphere": 0.1}, position=(0.2 * k + gap * k - 0.02 * (k == 0), 0, 0), velocity=(speed * (k == 0), 0, 0), tint=k, points=20)
        for k in range(5)
    )  # fmt: skip
    system = bodies.system(rigid={"restitution": restitution, "friction": 0.0})
    return ga.Simulation({"c": system}, dt=dt, precision="f64")
