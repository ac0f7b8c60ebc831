"""Rigid bodies: their particles' moments, free turning, rolling, sliding, bouncing, colliding and stacking, against formulas."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.rigid.turns import matrices, product, quaternion, rotation

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


# -- shapes


@pytest.mark.parametrize("hollow", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_second_moments_against_random_points(name, hollow):
    """The closed forms against the mean over points in the solid, or on its surface."""
    for part in ga.body(SHAPES[name]).parts[:1]:
        if hollow:
            x, _, area = part.surface(0.02)
        else:
            low = -part.half - part.radius
            x = np.random.default_rng(1).uniform(low, -low, (400_000, 3)) @ part.axes.T + part.center
            x = x[part.distance(x) < 0]
            area = np.ones(len(x))
        x = x - part.center
        found = np.einsum("n,ni,nj->ij", area, x, x) / area.sum()
        assert np.abs(found - part.moments(hollow)).max() < 6e-3 * np.abs(part.moments(hollow)).max()


@pytest.mark.parametrize("draw", ["cloud", "wire"])
@pytest.mark.parametrize("name", SHAPES)
def test_particles_have_the_body_s_mass_centre_and_moments(name, draw):
    one = ga.body(SHAPES[name], draw=draw, mass=2, spin=(1, 2, 3), turn=(0.3, 0.2, 1), position=(1, 2, 3), points=200)
    group = ga.bodies([one])
    x, m, R = group.position - one.place, group.mass[:, None], matrices(one.attitude)
    assert m.min() > 0 and m.sum() == pytest.approx(2, rel=1e-14)
    assert np.abs((m * x).sum(0)).max() < 1e-14
    L = np.cross(x, m * group.velocity).sum(0)
    assert np.abs(L - R @ (one.inertia * (R.T @ one.spin))).max() < 1e-13
    assert np.linalg.norm(L) > 0.1
    shown = group.radius > 0
    assert (~shown).sum() == 6 and 150 < shown.sum() < 260
    lie = np.min([p.distance(one.local[shown]) for p in one.parts], 0)
    assert np.abs(lie).max() < 1e-12  # on the surface of the whole
    if draw == "cloud" and name != "compound":
        assert group.attributes["area"].sum() == pytest.approx(sum(p.area for p in one.parts) / 2, rel=1e-12)


def test_turns():
    r = np.random.default_rng(0)
    p, q = rotation(r.normal(size=(5, 3))), rotation(r.normal(size=(5, 3)) * 2)
    assert np.abs(matrices(product(p, q)) - matrices(p) @ matrices(q)).max() < 1e-14
    for one in np.concatenate([p, q]):
        assert np.abs(matrices(quaternion(matrices(one))) - matrices(one)).max() < 1e-14


# -- free motion


def test_symmetric_top_precesses():
    """Its axis goes round L at L / I_1: with the body's turn, 1e-4 over a hundred turns asks for 1e-9."""
    one = ga.body({"capsule": [0.5, 0.2]}, mass=1, spin=(0.3, 5, 0.2))
    sim = world([one], forces=[], dt=1 / 6)
    L = one.inertia * np.array([0.3, 5, 0.2])
    sim.step(60)
    way = rotation(L[None] / one.inertia[0] * sim.time)  # the top's axis turns about L
    expected = matrices(way)[0] @ np.array([0, 1, 0])
    found = matrices(inside(sim).q)[0][:, 1]
    assert np.abs(found - expected).max() < 1e-9
    wrong = matrices(rotation(L[None] / one.inertia[1] * sim.time))[0] @ np.array([0, 1, 0])
    assert np.abs(found - wrong).max() > 1e-2


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-8), ("f32", 2e-5)])
def test_middle_axis_turns_over(precision, tolerance):
    """Spun about the middle axis it flips, again and again; energy and angular momentum stay."""
    one = ga.body({"box": [0.6, 0.1, 0.3]}, mass=1, spin=(0.1, 0.01, 9))  # moments: y > z > x
    assert np.argsort(one.inertia)[1] == 2
    sim = world([one], forces=[], dt=1 / 20, precision=precision)
    first, up = sim.diagnostics(), []
    L = inside(sim).L.copy()
    for _ in range(80):
        sim.step(1)
        up.append(inside(sim).R[0, 2, 2])
    now = sim.diagnostics()
    assert min(up) < -0.99 and max(up) > 0.99
    assert abs(now.energy / first.energy - 1) < tolerance
    assert (inside(sim).L == L).all()
    assert np.abs(now.angular_momentum - first.angular_momentum).max() < tolerance * np.abs(L).max()


def test_free_turning_has_order_4():
    from gen_art.rigid.motion import plan, turn_kernel

    inertia, hold, axle = np.array([[1.0, 2.0, 3.0]]), np.array([0]), np.zeros((1, 3))

    def end(parts):
        q, L = rotation(np.zeros((1, 3))), np.array([[1.0, 0.5, 1.5]])
        for _ in range(parts):
            turn_kernel()(q, L, plan(inertia, hold, axle), axle, 2.0 / parts, 100.0)
        return q[0]

    best = end(400)
    errors = [np.abs(end(parts) - best).max() for parts in (8, 16)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4, abs=0.4)
    assert errors[1] > 1e-8


@pytest.mark.parametrize("held", [{"pivot": (0, 0, 0)}, {"pivot": (0, 0, 0), "axle": (0, 0, 2)}])
def test_pivot_and_axle(held):
    """A bar on a pivot swings with T = 2 pi sqrt(I / m g l); one on an axle across gravity as well."""
    period = 2 * np.pi * np.sqrt((1 / 3 + 0.01 / 12) / (G * 0.5))
    one = ga.body({"box": [0.1, 1, 0.1]}, mass=1, position=(0, -0.5, 0), spin=(0, 0, 1e-3), **held)
    sim = world([one], ledger=True)
    sim.step(int(period / 2 / sim.dt))
    before = inside(sim).R[0, 0, 1]
    sim.step(1)
    after = inside(sim).R[0, 0, 1]
    assert before * after < 0
    assert sim.time + sim.dt * after / (before - after) == pytest.approx(period / 2, rel=1e-4)
    assert np.abs(inside(sim).x).max() == 0 and np.abs(inside(sim).w[0, :2]).max() < 1e-12
    assert abs(sim.ledger().residual) < 1e-12


# -- rolling and sliding


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-9), ("f32", 1e-5)])
def test_sliding_sphere_comes_to_roll(precision, tolerance):
    """v = v0 - mu g t until t = 2 v0 / (7 mu g), then 5 v0 / 7; a hollow one rolls at 3 v0 / 5."""
    v0, mu = 2.0, 0.3
    t = 2 * v0 / (7 * mu * G)
    ball = ga.body({"sphere": 0.1}, position=(0, 0.1, 0), velocity=(v0, 0, 0))
    sim = world([ball], floor=mu, dt=4e-3, precision=precision, ledger=True)
    sim.step(round(0.99 * t / sim.dt))
    assert speed(sim)[0] == pytest.approx(v0 - mu * G * sim.time, rel=tolerance)
    assert speed(sim)[0] > 5 * v0 / 7 * 1.001
    sim.step(round(0.02 * t / sim.dt) + 1)
    assert speed(sim)[0] == pytest.approx(5 * v0 / 7, rel=tolerance)
    sim.step(5)
    assert speed(sim)[0] == pytest.approx(5 * v0 / 7, rel=tolerance)
    account = sim.ledger()
    assert abs(account.residual) < tolerance * account.scale
    lost = 0.5 * ball.mass * v0**2 * (1 - 5 / 7)
    assert account.dissipated["b.rigid"] == pytest.approx(lost, rel=max(tolerance, 1e-6))
    assert account.impulse["b.plane"] == pytest.approx(
        [ball.mass * v0 * (5 / 7 - 1), ball.mass * G * sim.time, 0], rel=1e-4, abs=1e-4
    )
    assert np.abs(account.momentum_residual).max() < tolerance * ball.mass


@pytest.mark.parametrize(
    "shape,hollow,turn",
    [
        ({"sphere": 0.1}, False, (0, 0, 0)),
        ({"sphere": 0.1}, True, (0, 0, 0)),
        ({"capsule": [0.3, 0.1]}, False, (np.pi / 2, 0, 0)),
    ],
)
def test_rolls_down_an_incline(shape, hollow, turn):
    """a = g sin / (1 + I / m r^2): 2/5 for a ball, 2/3 for a shell; half a cylinder's and half a ball's for a capsule."""
    a, n, way = slope(20)
    one = ga.body(shape, hollow=hollow, position=n * 0.1, turn=turn)
    share = one.inertia[1] / (one.mass * 0.01)
    if "sphere" in shape:
        assert share == pytest.approx(2 / 3 if hollow else 2 / 5, rel=1e-12)
    else:
        rod, ball = np.pi * 0.01 * 0.3, 4 / 3 * np.pi * 0.001
        assert share == pytest.approx((rod / 2 + ball * 2 / 5) / (rod + ball), rel=1e-12)
    sim = world([one], floor=[ga.colliders.Plane(normal=n, restitution=0.0, friction=1.0)], ledger=True)
    sim.step(60)
    assert speed(sim) @ way == pytest.approx(G * np.sin(a) / (1 + share) * sim.time, rel=1e-9)
    assert abs(sim.ledger().residual) < 1e-10 * sim.ledger().scale


@pytest.mark.parametrize("degrees", [21.5, 22.1, 30])
def test_box_on_an_incline(degrees):
    """It holds below atan(mu) = 21.8 degrees and slides with a = g (sin - mu cos) above."""
    a, n, way = slope(degrees)
    mu = 0.4
    one = ga.body({"box": [0.4, 0.2, 0.3]}, position=n * 0.1, turn=(0, 0, -a))
    sim = world([one], floor=[ga.colliders.Plane(normal=n, restitution=0.0, friction=mu)], ledger=True)
    start = inside(sim).x.copy()
    sim.step(60)
    expected = max(0.0, G * (np.sin(a) - mu * np.cos(a))) * sim.time
    assert speed(sim) @ way == pytest.approx(expected, rel=1e-8, abs=1e-10)
    assert np.abs(inside(sim).x - start - way * expected * sim.time / 2).max() < 1e-8
    assert abs(sim.ledger().residual) < 1e-10 * max(sim.ledger().scale, 1)


def test_static_friction_holds_more_than_kinetic():
    a, n, way = slope(25)
    start = {}
    for pair in ((0.3, 0.6), (0.3, 0.3)):
        one = ga.body({"box": [0.4, 0.2, 0.3]}, position=n * 0.1, turn=(0, 0, -a))
        sim = world([one], floor=[ga.colliders.Plane(normal=n, restitution=0.0, friction=pair)])
        sim.step(60)
        start[pair] = speed(sim) @ way
    assert abs(start[0.3, 0.6]) < 1e-10
    assert start[0.3, 0.3] == pytest.approx(G * (np.sin(a) - 0.3 * np.cos(a)) / 4, rel=1e-8)


@pytest.mark.parametrize("one", ["sphere", "capsule", "box"])
@pytest.mark.parametrize("two", ["sphere", "capsule", "box"])
def test_contacts_lie_where_the_shapes_are_nearest(one, two):
    """Against the nearest of 10,000 points on one shape to the other: the least gap, and its normal leads apart."""
    from gen_art.rigid.shapes import parts_of
    from gen_art.rigid.touching import Shapes, touching

    r = np.random.default_rng(7)
    parts = [parts_of(SHAPES[k])[0] for k in (one, two)]
    clouds = [np.concatenate([p.surface(np.sqrt(p.area / 4000))[0], p.wires(p.wire_length() / 1000)[0]]) for p in parts]
    errors = []
    for _ in range(16):
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
        found = touching(shapes, np.array([0.05, 0.05]), np.array([True, True]))
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


@pytest.mark.parametrize("restitution,friction", [(1.0, 0.0), (1.0, 0.4), (0.6, 0.3)])
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
    assert inside(sim).meeting.gap.min(initial=0) > -1e-3
    if restitution == 1.0:
        assert energy[-1] > 0.9 * energy[0]  # a contact may rest for a moment, and then takes a little
    else:
        assert energy[-1] < 0.7 * energy[0]
    assert abs(sim.ledger().residual) < 1e-7 * energy[0]


def test_a_ball_bounces_to_its_height():
    """e = 0.8: each top is e^2 of the last, above the floor at which it turned."""
    ball = ga.body({"sphere": 0.1}, position=(0, 1.1, 0), mass=1)
    sim = world([ball], floor=[ga.colliders.Plane(restitution=0.8)], dt=1 / 240)
    tops, heights = [], [1.0, 1.0]
    for _ in range(220):
        sim.step(1)
        heights.append(inside(sim).x[0, 1] - 0.1)
        if heights[-3] < heights[-2] > heights[-1]:
            tops.append(heights[-2])
    assert tops[0] == pytest.approx(0.64, rel=3e-2)


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
        deepest = min(deepest, inside(sim).meeting.gap.min(initial=0))
        energy.append(sim.diagnostics().energy)
    assert deepest > -0.012
    assert inside(sim).meeting.gap.min() > -1.5e-3  # what sank in on the way has been taken back
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
    from gen_art.ledger import Bookkeeper

    one = ga.body({"box": [0.2, 0.2, 0.2]}, position=(0, 0.1, 0))
    sim = world([one], floor=0.5)
    inside(sim).x[0, 1] -= 5e-3
    inside(sim).meeting.look(0.0)
    inside(sim)._put(sim["b"].state, True)
    sim._ledger = Bookkeeper(sim)
    for stepper in sim._stepped.values():
        stepper.books = sim._ledger
    energy = sim.diagnostics().energy
    sim.step(60)
    assert inside(sim).meeting.gap.min() == pytest.approx(-1e-3, abs=1e-4)
    assert np.abs(inside(sim).v).max() < 1e-9
    assert sim.diagnostics().energy - energy == pytest.approx(one.mass * G * 4e-3, rel=0.03)
    assert sim.ledger().dissipated["b.rigid"] == pytest.approx(energy - sim.diagnostics().energy, rel=1e-6)


def test_nearest_points_of_segments():
    """Against all pairs of 401 points on each."""
    from gen_art.rigid.touching import _between_segments

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


# -- stacks


def tower(count, points=60):
    return [ga.body({"box": [0.2, 0.2, 0.2]}, position=(0, 0.1 + 0.2 * k, 0), points=points) for k in range(count)]


def creep(count, seconds, precision="f64", **rigid):
    sim = world(tower(count), floor=0.5, precision=precision, rigid=rigid)
    start, energy = inside(sim).x.copy(), sim.diagnostics().energy
    sim.step(round(seconds * 240))
    return np.abs(inside(sim).x - start).max(), (sim.diagnostics().energy - energy) / energy


def test_a_stack_stays():
    """Ten boxes: less than 20 micrometres in a second. A solver cut short lets them sink and lean."""
    moved, gained = creep(10, 1.0)
    assert moved < 2e-5 and -1e-6 < gained < 1e-12
    assert creep(10, 0.25, iterations=2)[0] > 1e-4


@pytest.mark.proof
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_stack_stays_for_ten_seconds(precision):
    moved, gained = creep(10, 10.0, precision)
    assert moved < 1e-3 and gained < 1e-6


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
    with pytest.raises(ga.UsageError, match="at least 8 points"):
        ga.body({"sphere": 0.5}, points=3)
    with pytest.raises(ga.UsageError, match="no rigid bodies"):
        system = ga.ParticleSystem(position=np.zeros((1, 3)), interactions=[ga.interactions.Rigid()])
        ga.Simulation({"s": system}, dt=0.01)


# -- blades


def rotor(pitch, **others):
    """Three thin blades from r = 0.2 to 1.2 m about x, each turned about its own length by `pitch`, rad."""
    blades = []
    for k in range(3):
        about = rotation(np.array([2 * np.pi * k / 3, 0, 0]))
        q = product(about, rotation(np.array([0, pitch, 0])))
        turn = q[1:] / np.linalg.norm(q[1:]) * 2 * np.degrees(np.arctan2(np.linalg.norm(q[1:]), q[0]))
        at = matrices(about) @ [0, 0.7, 0]
        blades.append({"box": [0.002, 1.0, 0.12], "at": at.tolist(), "turn": turn.tolist()})
    return ga.body(blades, axle=(1, 0, 0), **others)


def thin_plate(w, n):
    """Force over 1/2 density area: Newton's plate, 2 sin a along the normal, and friction 0.02 along the stream."""
    speed = np.linalg.norm(w, axis=1)
    return -2 * n * ((w @ n) * speed)[:, None] - 0.02 * w * speed[:, None]


def test_panel_is_a_thin_plate():
    r = np.random.default_rng(5)
    v, n, area = r.normal(size=(40, 3)), r.normal(size=(40, 3)), r.uniform(0.1, 1, 40)
    n /= np.linalg.norm(n, axis=1)[:, None]
    names = dict(area=area, normal_x=n[:, 0], normal_y=n[:, 1], normal_z=n[:, 2])
    wind = np.array([1.0, 0.5, 0.0])

    def kick(**numbers):
        system = ga.ParticleSystem(
            position=np.zeros((40, 3)), velocity=v, mass=2.0, forces=[ga.forces.Panel(**numbers)], attributes=names,
            medium=ga.Medium(density=1.2, wind=wind), integrator="semi_implicit_euler",
        )  # fmt: skip
        sim = ga.Simulation({"s": system}, dt=1e-6, precision="f64")
        sim.step(1)
        return (sim["s"].velocity - v) / 1e-6 * 2.0 / (0.6 * area[:, None])

    expected = np.concatenate([thin_plate(v[k : k + 1] - wind, n[k]) for k in range(40)])
    assert np.abs(kick() - expected).max() < 1e-5
    lift = kick(drag=0.0, friction=0.0)
    w = v - wind
    speed = np.linalg.norm(w, axis=1)
    sine = (w * n).sum(1) / speed
    assert np.abs((lift * w).sum(1)).max() < 1e-5  # lift is across the stream
    assert np.linalg.norm(lift, axis=1) == pytest.approx(2 * np.abs(sine) * np.sqrt(1 - sine**2) * speed**2, rel=1e-5)
    with pytest.raises(ga.UsageError, match="needs particles with the attribute area"):
        ga.ParticleSystem(position=np.zeros((1, 3)), forces=[ga.forces.Panel(density=1.0)])
    with pytest.raises(ga.UsageError, match="panel needs the fluid's density"):
        ga.ParticleSystem(
            position=np.zeros((1, 3)), forces=[ga.forces.Panel()], attributes={k: np.ones(1) for k in names}
        )


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_rotor_runs_at_the_speed_of_its_blade_elements(precision):
    """Free-running: the torque of the elements, integrated along the blade, is zero. The edges, 2 mm, brake as panels too."""
    pitch, wind = np.radians(15), 8.0
    r = 0.2 + (np.arange(4000) + 0.5) / 4000
    n, edge = np.array([np.cos(pitch), 0, -np.sin(pitch)]), np.array([np.sin(pitch), 0, np.cos(pitch)])

    def torque(spin):
        w = np.stack([0 * r - wind, 0 * r, spin * r], 1)
        return ((0.12 * thin_plate(w, n) + 0.002 * thin_plate(w, edge))[:, 2] * r).sum()

    slow, fast = 0.0, -100.0
    for _ in range(60):
        slow, fast = ((slow + fast) / 2, fast) if torque((slow + fast) / 2) < 0 else (slow, (slow + fast) / 2)
    assert 3 < -slow * 1.2 / wind < 4  # tip speed ratio
    found = []
    for begin in (0.98, 1.02):
        one = rotor(pitch, mass=0.1, points=900, spin=(begin * slow, 0, 0))
        sim = world([one], [ga.forces.Panel()], precision=precision, medium=ga.Medium(density=1.2, wind=(wind, 0, 0)))
        sim.step(120)
        found.append(inside(sim).w[0, 0])
    assert found[0] == pytest.approx(found[1], rel=1e-3)  # from either side
    assert found[0] == pytest.approx(slow, rel=1e-2)


# -- bits, snapshots, presets

PRESET = {
    "version": 1,
    "clock": {"duration": 1, "fps": 30, "step": "1/240"},
    "forces": {"gravity": [0, -9.81, 0]},
    "systems": {
        "blocks": {
            "integrator": "leapfrog",
            "interactions": {"rigid": {"restitution": 0.2, "friction": 0.4}},
            "colliders": {"plane": {"restitution": 0.2, "friction": "0.3..0.4"}},
            "emitters": {
                "wall": {
                    "body": {"shape": {"box": [0.2, 0.1, 0.1]}, "grid": [3, 2, 1], "pitch": [0.21, 0.101, 0.1],
                             "position": [0, 0.05, 0], "points": 60, "tint": "0..1"},
                },
                "ball": {"body": {"shape": {"sphere": 0.08}, "position": [-0.3, 0.1, 0.01], "velocity": [4, 0, 0], "points": 60}},
            },
            "look": {"draw": "sphere", "blend": "opaque", "emission": {"color": {"by": "tint", "range": "0..1", "gradient": "ice"},
                     "intensity": {"by": "shade", "range": "0..1", "curve": [[0, 0.1], [1, 1]]}}},
        }
    },
}  # fmt: skip


def test_a_preset_with_bodies_and_its_snapshot(tmp_path):
    """Laid by emitters in a grid; saved in the middle of a collision it goes on to the same bits."""
    preset = ga.load_preset(PRESET)
    sim = ga.Simulation(preset)
    blocks = sim["blocks"]
    assert blocks.interactions[0]._world.x.shape == (7, 3)
    assert sorted(np.unique(blocks.attribute("tint")).round(6)) == pytest.approx(
        [k * 0.6180339887 % 1 for k in (0, 5, 2, 4, 1, 3)]
    )
    assert 0.99 < np.linalg.norm([blocks.attribute(f"normal_{a}")[0] for a in "xyz"]) < 1.01
    assert blocks.attribute("shade").max() > 0.9
    sim.step(20)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    assert again.digest() == sim.digest()
    sim.step(20)
    again.step(20)
    assert again.digest() == sim.digest()
    assert np.abs(blocks.interactions[0]._world.v).max() > 0.1


def test_a_snapshot_of_bodies_made_in_python(tmp_path):
    sim = world(tower(3), floor=0.4, precision="f32")
    sim.step(5)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    sim.step(5)
    again.step(5)
    assert again.digest() == sim.digest()
    inside(again).L[0, 0] += 1e-9
    assert again.digest() != sim.digest()  # what particles do not hold is part of the state


SCRIPT = """
import sys
import gen_art as ga
r = [ga.body(s, position=(0.02 * k, 0.16 + 0.36 * k, 0.01 * k), points=700)
     for k, s in enumerate([{"box": [0.3, 0.3, 0.3]}, {"sphere": 0.15}, {"capsule": [0.2, 0.1]}, {"box": [0.4, 0.2, 0.3]}])]
system = ga.bodies(r).system(forces=[ga.forces.Gravity()], colliders=[ga.colliders.Plane(friction=0.4)], integrator="leapfrog")
sim = ga.Simulation({"b": system}, dt=1 / 240, threads=int(sys.argv[1]))
sim.step(40)
print(sim.digest())
"""


@pytest.mark.parametrize("threads", ["14", pytest.param("124", marks=pytest.mark.proof)])
def test_threads_do_not_change_bits(threads):
    import os
    import subprocess
    import sys
    from pathlib import Path

    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    runs = [subprocess.Popen([sys.executable, "-c", SCRIPT, n], stdout=subprocess.PIPE, env=env) for n in threads]
    digests = {run.communicate()[0] for run in runs}
    assert len(digests) == 1 and len(digests.pop()) > 60


def test_other_particles_need_a_system_of_their_own():
    preset = {**PRESET, "systems": {"blocks": {**PRESET["systems"]["blocks"], "emitters": {
        **PRESET["systems"]["blocks"]["emitters"], "dust": {"count": 5}}}}}  # fmt: skip
    with pytest.raises(ga.UsageError, match="give other particles a system of their own"):
        ga.Simulation(ga.load_preset(preset))


def test_an_audit_leaves_bodies_whole():
    from gen_art.audit.thinning import thinned

    piece = ga.load_preset(PRESET)
    few, changes = thinned(piece, 0.1, 10)
    assert not changes and few == piece
