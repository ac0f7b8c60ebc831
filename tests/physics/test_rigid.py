"""Rigid bodies: their particles' moments, free turning, rolling, sliding and stacking, against formulas."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.interactions.rigid.quaternions import matrices, product, quaternion, rotation
from tests.physics.bodies import SHAPES, G, inside, slope, speed, tower, world

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
            x = np.random.default_rng(1).uniform(low, -low, (150_000, 3)) @ part.axes.T + part.center
            x = x[part.distance(x) < 0]
            area = np.ones(len(x))
        x = x - part.center
        found = np.einsum("n,ni,nj->ij", area, x, x) / area.sum()
        assert np.abs(found - part.moments(hollow)).max() < 1e-2 * np.abs(part.moments(hollow)).max()


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


def test_eigenvectors_of_symmetric_matrices():
    """A V = V diag(values), V a rotation; equal and zero elements included."""
    from gen_art.interactions.rigid.small_matrices import symmetric_eigen

    r = np.random.default_rng(4).normal(size=(40, 3, 3))
    some = [
        *(r + np.swapaxes(r, 1, 2)),
        np.eye(3),
        np.zeros((3, 3)),
        np.diag([3.0, 1.0, 1.0]),
        np.ones((3, 3)),
        1e-12 * np.ones((3, 3)),
    ]
    for A in some:
        values, V = symmetric_eigen(A)
        assert np.abs(A @ V - V * values).max() <= 1e-14 * max(np.abs(A).max(), 1e-300) * 3
        assert np.abs(V.T @ V - np.eye(3)).max() < 1e-14 and np.linalg.det(V) == pytest.approx(1, rel=1e-14)
        assert (np.diff(values) >= 0).all()


# -- free motion


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-13), ("f32", 5e-7)])
def test_symmetric_top_precesses(precision, tolerance):
    """Its axis goes round L at L / I_1: with the body's turn, 1e-4 over a hundred turns asks for 1e-9.

    Bodies turn in float64 in either precision; their particles' angular momentum is rounded to some eps in float32.
    """
    one = ga.body({"capsule": [0.5, 0.2]}, mass=1, spin=(0.3, 5, 0.2))
    sim = world([one], forces=[], dt=1 / 6, precision=precision)
    L = one.inertia * np.array([0.3, 5, 0.2])
    sim.step(60)
    way = rotation(L[None] / one.inertia[0] * sim.time)  # the top's axis turns about L
    expected = matrices(way)[0] @ np.array([0, 1, 0])
    found = matrices(inside(sim).q)[0][:, 1]
    assert np.abs(found - expected).max() < 1e-9
    assert np.abs(sim.diagnostics().angular_momentum - L).max() < tolerance * np.abs(L).max()
    wrong = matrices(rotation(L[None] / one.inertia[1] * sim.time))[0] @ np.array([0, 1, 0])
    assert np.abs(found - wrong).max() > 1e-2


def test_a_cube_turns_about_any_axis_for_ever():
    """Its three moments are m a^2 / 6 alike, so that every axis is steady: after t it is turned by w t about w."""
    w = np.array([1.9, 0.8, 0.5])
    one = ga.body({"box": [0.5, 0.5, 0.5]}, mass=3, spin=w, turn=(0.3, 0.5, 0.2), draw="wire", points=200)
    assert one.inertia == pytest.approx([3 * 0.25 / 6] * 3, rel=1e-12)
    sim = world([one], forces=[], dt=1 / 30)
    start = sim["b"].position
    sim.step(240)
    expected = start @ matrices(rotation(8 * w[None]))[0].T
    assert np.abs(sim["b"].position - expected).max() < 1e-9
    assert np.abs(sim["b"].position - start @ matrices(rotation(8.08 * w[None]))[0].T).max() > 1e-2


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-8), pytest.param("f32", 2e-5, marks=pytest.mark.proof)])
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
    from gen_art.interactions.rigid.free_motion import rotation_kernel, splitting_table

    inertia, hold, axle = np.array([[1.0, 2.0, 3.0]]), np.array([0]), np.zeros((1, 3))

    def end(parts):
        q, L = rotation(np.zeros((1, 3))), np.array([[1.0, 0.5, 1.5]])
        for _ in range(parts):
            rotation_kernel()(q, L, splitting_table(inertia, hold, axle), axle, 2.0 / parts, 100.0)
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
    account = sim.ledger()
    assert abs(account.residual) < 1e-12
    # also the impulse of the pivot while the bar turns about it
    assert np.abs(account.momentum_residual).max() < 1e-12 * G * sim.time


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
        sim.step(24)
        start[pair] = speed(sim) @ way
    assert abs(start[0.3, 0.6]) < 1e-10
    assert start[0.3, 0.3] == pytest.approx(G * (np.sin(a) - 0.3 * np.cos(a)) / 10, rel=1e-8)


# -- stacks


def creep(count, seconds, precision="f64", **rigid):
    sim = world(tower(count), floor=0.5, precision=precision, rigid=rigid)
    start, energy = inside(sim).x.copy(), sim.diagnostics().energy
    sim.step(round(seconds * 240))
    return np.abs(inside(sim).x - start).max(), (sim.diagnostics().energy - energy) / energy


def pair_of_sweeps(sim):
    """The matrix (6 b, 6 b) by which a pair of sweeps changes the bodies' velocities when every contact presses and sticks.

    Each row J of the contacts' frames in turn takes away the speed J V along it: V -= M^-1 J^T (J V) / (J M^-1 J^T).
    """
    w = inside(sim)
    contacts, size = w.contacts, 6 * len(w.x)
    inverse_mass, F, rows = np.zeros((size, size)), np.eye(size), []
    for b in range(len(w.x)):
        inverse_mass[6 * b : 6 * b + 3, 6 * b : 6 * b + 3] = np.eye(3) * w.inverse_mass[b]
        inverse_mass[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] = w.inverse_inertia[b]
    for i, n in enumerate(contacts.normal):
        frame = [n, np.roll(n, 1), np.roll(n, 2)]  # the normals of this stack are along y
        rows.append(np.zeros((3, size)))
        for b, sign in ((contacts.first[i], 1), (contacts.second[i], -1)):
            if b >= 0:
                rows[-1][:, 6 * b : 6 * b + 3] = sign * np.array(frame)
                rows[-1][:, 6 * b + 3 : 6 * b + 6] = sign * np.cross(contacts.point[i] - w.x[b], frame)
    for contact in rows + rows[::-1]:
        for J in contact:
            F -= np.outer(inverse_mass @ J, J @ F) / (J @ inverse_mass @ J)
    return F


def drift_bound(count, dt, seconds, pairs):
    """The path, m, that a stack can go in `seconds` with `pairs` pairs of sweeps in each half step.

    Let F = pair_of_sweeps and P = F^pairs. A solve leaves the velocities V_1 = P g dt / 2. It starts with the impulses of the
    one before, and the velocities that are left come back as a change of the load: V_n+1 = P (2 V_n - V_n-1), V_0 = 0.
    One solve of two is followed by a drift. The sum of dt max |V_n| over the drifts bounds the path, whatever the phases of the
    modes are; round-off and the extrapolation between pairs of sweeps change the phases, not the rate of the slowest modes.
    (In the slowest, ten boxes rock: F keeps 0.9998 of it, so that 80 pairs are far from the end. That is why a stack moves.)
    """
    P = np.linalg.matrix_power(pair_of_sweeps(world(tower(count), floor=0.5, dt=dt)), pairs)
    V = np.zeros(6 * count)
    V[1::6] = -G * dt / 2
    before, now, path = 0 * V, P @ V, 0.0
    for n in range(2 * round(seconds / dt)):
        if n % 2 == 0:
            path += dt * np.linalg.norm(now.reshape(-1, 6)[:, :3], axis=1).max()
        before, now = now, P @ (2 * now - before)
    return path


def test_a_stack_stays(monkeypatch):
    """Ten boxes sink and lean by no more than the sweeps of the solver leave over."""
    from gen_art.interactions.rigid.contact_set import ContactSet

    moved, gained = creep(10, 1.0)
    bound = drift_bound(10, 1 / 240, 1.0, 80)
    assert moved < bound < 2e-3 * 0.2  # which is 0.2 % of a box
    assert gained < 1e-12
    # with enough sweeps, what is left is the tolerance at which they end, 1e-8 of the largest speed, over 1 - rho
    rho = np.abs(np.linalg.eigvals(pair_of_sweeps(world(tower(10), floor=0.5)))).max()
    assert 0.999 < rho < 0.9999
    assert creep(10, 0.5, iterations=5000)[0] < 1e-8 * G / 240 / (1 - rho) * 0.5
    # the mutants: sweeps cut short, and impulses that do not start from the last ones
    assert creep(10, 1.0, iterations=8)[0] > bound
    last = ContactSet._last_forces
    monkeypatch.setattr(ContactSet, "_last_forces", lambda self: 0 * last(self))
    assert creep(10, 1.0)[0] > bound


@pytest.mark.proof
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_stack_stays_for_ten_seconds(precision):
    moved, gained = creep(10, 10.0, precision)
    assert moved < drift_bound(10, 1 / 240, 10.0, 80) and gained < 1e-6


# -- what a script reads


def thrown() -> ga.Simulation:
    """A box that flies without rotating, and a ball that rotates about z, both turned at their start."""
    box = ga.body({"box": [1.0, 3.0, 2.0]}, mass=2.0, position=(1, 2, 3), turn=(0, 0, np.pi / 2), velocity=(1, 0, 0))
    ball = ga.body({"sphere": 0.5}, mass=4.0, position=(9, 2, 3), turn=(0, 0, 0.3), spin=(0, 0, 2.0), name="ball")
    system = ga.bodies([box, ball]).system(forces=[ga.forces.Gravity((0, -10.0, 0))])
    return ga.Simulation({"s": system}, dt=0.01, precision="f64")


def about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_bodies_say_where_they_are():
    sim = thrown()
    box, ball = sim["s"].bodies
    assert np.allclose(box.rotation, about_z(np.pi / 2), atol=1e-12), "as given, whatever its principal axes are"
    sim.step(100)
    assert np.allclose(box.position, [1, 2, 3]), "what was read stays"
    box, ball = sim["s"].bodies
    assert np.allclose(box.position, [2, -3, 3]) and np.allclose(box.velocity, [1, -10, 0])  # leapfrog is exact here
    assert np.allclose(box.rotation, about_z(np.pi / 2), atol=1e-12) and np.allclose(box.spin, 0, atol=1e-12)
    assert np.allclose(ball.rotation, about_z(0.3 + 2.0), atol=1e-9) and np.allclose(ball.spin, [0, 0, 2])
    assert np.allclose(ball.angular_momentum, [0, 0, 0.4 * 4.0 * 0.25 * 2.0], rtol=1e-9)
    assert repr(ball).startswith("<BodyState 'ball': 4 kg at (9, -3, 3) m, velocity (0, -10, 0) m/s, spin (")


def test_the_same_body_is_made_once_and_nobody_can_change_it():
    """Mutants: bodies of other arguments are the same one; its arrays can be written."""
    one, same = (ga.body({"sphere": 0.5}, velocity=(1, 0, 0)) for _ in range(2))
    for name in ("local", "velocity", "masses", "normals"):
        assert np.array_equal(getattr(one, name), getattr(same, name))
        with pytest.raises(ValueError, match="read-only"):
            getattr(one, name)[...] = 0.0
    for other in (
        ga.body({"sphere": np.nextafter(0.5, 1)}, velocity=(1, 0, 0)),
        ga.body({"sphere": 0.5}, velocity=(1, 0, 1e-300)),
        ga.body({"sphere": 0.5}, velocity=(1, 0, 0), hollow=True),
    ):
        assert other.spec != one.spec and other is not one


def test_a_long_body_keeps_the_axes_of_its_shape():
    """A rod that lies askew has principal axes that are not those of the shape."""
    askew = ga.body([{"box": [4.0, 0.2, 0.2], "turn": [0, 0, 30]}, {"sphere": 0.3}], turn=(0, 0, 0.2), spin=(0, 0, 1.0))
    sim = ga.Simulation({"s": ga.bodies([askew]).system()}, dt=0.01, precision="f64")
    assert np.allclose(sim["s"].bodies[0].rotation, about_z(0.2), atol=1e-9)
    sim.step(50)
    assert np.allclose(sim["s"].bodies[0].rotation, about_z(0.7), atol=1e-6)


def test_bodies_are_asked_of_what_has_none():
    with pytest.raises(ga.UsageError, match="no rigid bodies"):
        ga.ParticleSystem(position=np.zeros((1, 3))).bodies  # noqa: B018
    ball = ga.bodies([ga.body({"sphere": 0.5})])
    with pytest.raises(ga.UsageError, match="not part of a simulation yet"):
        ball.system().bodies  # noqa: B018


def test_bodies_say_what_they_are():
    ball = ga.body({"sphere": 0.5}, mass=2.0, position=(1, 2, 3), spin=(0, 0, 4), pivot=(1, 2, 3), name="ball")
    n = len(ball.masses)
    at = "2 kg at (1, 2, 3) m, velocity (0, 0, 0) m/s, spin (0, 0, 4) rad/s"
    assert repr(ball) == f"<Body 'ball': {at}, on a pivot; {n} particles>"
    assert repr(ga.bodies([ball])) == f"<Bodies: 1 body (ball) of 2 kg, {n} particles>"
    assert "<Bodies: 2 bodies (ball, body) of" in repr(ga.bodies([ball, ga.body({"sphere": 1.0}, position=(9, 9, 9))]))
