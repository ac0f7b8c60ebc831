"""The aeroplane and the submarine under recorded control, against what flight mechanics and Archimedes say."""

import math

import numpy as np
import pytest

import gen_art as ga

F = ga.forces
G, RHO, MASS = 9.81, 1.225, 1100.0
TURN = (0.0, -G, 0.0)


def plane(speed=55.0, climb=0.0, dt=0.01, ledger=False, precision="f64", slope=5.0, **inputs):
    """An aeroplane trimmed for level flight at 55 m/s, started at `speed` and with `climb` m/s upwards."""
    attack, throttle = F.Aircraft(lift_slope=slope).trim(55.0, MASS, RHO, G)
    given = {"angle_of_attack": attack, "throttle": throttle, **inputs}
    system = ga.ParticleSystem(
        position=[[0, 1000, 0]], velocity=[[speed, climb, 0]], mass=MASS, integrator="rk4",
        forces=[F.Gravity(TURN), F.Aircraft(density=RHO, **given)],
    )  # fmt: skip
    return ga.Simulation({"p": system}, dt=dt, precision=precision, ledger=ledger)


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-9), ("f32", 2e-3)])
def test_trimmed_it_flies_level(precision, tolerance):
    sim = plane(precision=precision)
    sim.step(3000)
    assert sim["p"].position[0, 1] == pytest.approx(1000, abs=max(tolerance * 1000, 1e-6))
    assert sim["p"].velocity[0, 0] == pytest.approx(55, rel=tolerance)


def test_the_phugoid_has_the_period_of_theory():
    sim = plane(speed=55.5)
    dt, v0 = 0.01, 55.0
    heights = []
    for _ in range(8000):
        sim.step(1)
        heights.append(sim["p"].velocity[0, 1])
    rises = np.array(heights)
    crossings = np.flatnonzero((rises[:-1] < 0) & (rises[1:] >= 0))
    times = dt * (crossings + 1 - rises[crossings + 1] / (rises[crossings + 1] - rises[crossings]))
    period = np.diff(times).mean()
    # small motions: l^2 + 2 (D/L) (g/V) l + 2 (g/V)^2 = 0, thrust held (Lanchester, with drag)
    pressure = 0.5 * RHO * v0**2 * 16.0
    lift = MASS * G / pressure
    drag = 0.03 + lift**2 / (math.pi * 0.8 * 7.5)
    w = G / v0 * math.sqrt(2 - (drag / lift) ** 2)
    assert period == pytest.approx(2 * np.pi / w, rel=2e-3)
    assert period == pytest.approx(math.pi * math.sqrt(2) * v0 / G, rel=0.02)
    assert abs(period - 2 * np.pi * v0 / G) > 5  # the mutant: lift that does not grow with the square of speed
    # and it dies away at the rate of drag
    peaks = [np.abs(rises[a:b]).max() for a, b in zip(crossings, crossings[1:])]
    assert peaks[1] / peaks[0] == pytest.approx(math.exp(-drag / lift * G / v0 * period), rel=0.01)


def test_a_banked_turn_has_the_radius_of_theory_and_goes_to_the_right():
    bank = math.radians(30)
    attack, _ = F.Aircraft().trim(55.0, MASS, RHO, G)
    attack /= math.cos(bank)
    lift = 5.0 * attack
    drag = 0.03 + lift**2 / (math.pi * 0.8 * 7.5)
    throttle = 0.5 * RHO * 55**2 * 16 * drag / 2500
    sim = plane(angle_of_attack=attack, bank=bank, throttle=throttle)
    radius = 55.0**2 / (G * math.tan(bank))
    quarter = 0.5 * math.pi * radius / 55.0
    sim.step(round(quarter / 0.01))
    x = sim["p"].position[0]
    assert x[1] == pytest.approx(1000, abs=1e-6)
    assert np.allclose([x[0], x[2]], radius, rtol=2e-3)  # right of a pilot who flies along x is z


def test_beyond_the_stall_lift_grows_no_more_and_trim_says_what_is_missing():
    a, b = (plane(angle_of_attack=math.radians(k)) for k in (15.0, 40.0))
    for sim in (a, b):
        sim.step(100)
    assert np.array_equal(a["p"].position, b["p"].position)
    with pytest.raises(ga.UsageError, match="wings stall"):
        F.Aircraft().trim(20.0, MASS, RHO)
    with pytest.raises(ga.UsageError, match="engine gives 500 N"):
        F.Aircraft(max_thrust=500.0).trim(55.0, MASS, RHO)


def flown(times, banks):
    """The heading after 10 s, by the equations of flight in speed, climb angle and heading, with banks in degrees."""
    attack, throttle = F.Aircraft().trim(55.0, MASS, RHO, G)
    lift = 5.0 * attack
    drag = 0.03 + lift**2 / (math.pi * 0.8 * 7.5)

    def slope(t, y):
        pressure, bank = 0.5 * RHO * y[0] ** 2 * 16.0, math.radians(np.interp(t, times, banks))
        return np.array([
            (throttle * 2500.0 - pressure * drag) / MASS - G * math.sin(y[1]),
            (pressure * lift * math.cos(bank) / MASS - G * math.cos(y[1])) / y[0],
            pressure * lift * math.sin(bank) / (MASS * y[0] * math.cos(y[1])),
        ])  # fmt: skip

    y, h = np.array([55.0, 0.0, 0.0]), 0.01
    for n in range(1000):
        t = n * h
        k1 = slope(t, y)
        k2 = slope(t + h / 2, y + h / 2 * k1)
        k3 = slope(t + h / 2, y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + slope(t + h, y + h * k3))
    return y[2]


def test_recorded_inputs_act_as_they_were_flown(tmp_path):
    path = tmp_path / "roll.csv"
    path.write_text("time, bank\n# a gentle turn\n1, 0\n3, 10\n5, 10\n7, 0\n")
    sim = plane(controls=str(path))
    sim.step(1000)
    v = sim["p"].velocity[0]
    assert math.atan2(v[2], v[0]) == pytest.approx(flown([1, 3, 5, 7], [0, 10, 10, 0]), rel=1e-6)
    assert math.atan2(v[2], v[0]) != pytest.approx(flown([1, 3, 5, 7], [0, 10, 10, 1]), rel=1e-3)
    given = plane(controls={"time": [1, 3, 5, 7], "bank": [0, 10, 10, 0]})
    given.step(1000)
    assert np.array_equal(given["p"].position, sim["p"].position)
    sim.save(tmp_path / "a.gas")
    again = ga.Simulation.restore(tmp_path / "a.gas")
    sim.step(10)
    again.step(10)
    assert again.digest() == sim.digest()


def test_the_account_of_a_flight_closes():
    sim = plane(speed=57.0, ledger=True)
    sim.step(2000)
    account = sim.ledger()
    assert abs(account.residual) <= 1e-9 * account.scale
    assert abs(account.work["p.aircraft"]) > 1e3


def boat(y=-20.0, v=(0.0, 0.0, 0.0), dt=0.01, forces=(), mass=1000.0, **ballast):
    given = {"volume": 1.1, "tanks": 0.25, "density": 1000.0, "gravity": TURN, "height": 1.5, **ballast}
    system = ga.ParticleSystem(
        position=[[0, y, 0]], velocity=[v], mass=mass, forces=[F.Gravity(TURN), F.Ballast(**given), *forces]
    )
    return ga.Simulation({"s": system}, dt=dt, precision="f64", ledger=True)


def test_a_submarine_hovers_sinks_and_rises_by_its_tanks():
    hover = boat(flooded=0.4)  # 1000 (1.1 - 0.1) kg of water: its own mass
    hover.step(500)
    assert hover["s"].position[0, 1] == pytest.approx(-20, abs=1e-9)
    drag = [F.Drag(quadratic=800.0)]
    for flooded, way in ((1.0, -1), (0.0, 1)):
        sim = boat(y=-500.0, flooded=flooded, forces=drag)
        sim.step(3000)
        excess = abs(1000.0 * (1.1 - 0.25 * flooded) - 1000.0) * G
        assert sim["s"].velocity[0, 1] == pytest.approx(way * math.sqrt(excess / 800.0), rel=1e-6)
        assert abs(sim.ledger().residual) <= 1e-6 * sim.ledger().scale


def test_it_floats_at_its_draught_and_bobs_at_the_frequency_of_theory():
    lift = 1.1 * 1000.0
    draught = (0.5 - 1000.0 / lift) * 1.5  # height of its middle where it floats
    sim = boat(y=draught + 0.02, flooded=0.0, dt=0.002)
    heights = []
    for _ in range(2000):
        sim.step(1)
        heights.append(sim["s"].position[0, 1] - draught)
    h = np.array(heights)
    down = np.flatnonzero((h[:-1] > 0) & (h[1:] <= 0))
    period = np.diff(down).mean() * 0.002
    assert period == pytest.approx(2 * np.pi / math.sqrt(lift * G / (1000.0 * 1.5)), rel=2e-3)
    assert abs(period - 2 * np.pi / math.sqrt(lift * G / 1000.0)) > 0.1  # the mutant: the hull's height left out


def test_a_dive_that_was_recorded(tmp_path):
    path = tmp_path / "dive.csv"
    path.write_text("time,flooded\n0,0.4\n10,0.4\n12,0.8\n30,0.8\n34,0.1\n")
    sim = boat(controls=str(path), forces=[F.Drag(quadratic=500.0), F.Propeller(max_thrust=500.0)])
    sim.step(1000)
    assert sim["s"].position[0, 1] == pytest.approx(-20, abs=1e-9)
    sim.step(2000)
    deep = sim["s"].position[0, 1]
    assert deep < -25
    sim.step(1500)
    assert sim["s"].position[0, 1] > deep + 3
    v = sim["s"].velocity[0]
    assert v[0] * np.linalg.norm(v) == pytest.approx(1.0, rel=0.05)  # 500 v abs(v) = 500 N


@pytest.mark.parametrize("make,words", [
    (lambda d: F.Aircraft(controls=str(d / "none.csv")), "no such file"),
    (lambda d: F.Aircraft(controls=_file(d, "bank\n1\n")), "needs a column `time`"),
    (lambda d: F.Aircraft(controls=_file(d, "time\n0\n1\n")), "no input beside time; give at least one of angle_of_attack, bank"),
    (lambda d: F.Aircraft(controls=_file(d, "time,bnk\n0,1\n")), "no column bnk.*angle_of_attack, bank, throttle"),
    (lambda d: F.Aircraft(controls=_file(d, "time,bank\n0,1\n0,2\n")), "times must rise"),
    (lambda d: F.Aircraft(controls=_file(d, "time,bank\n0,1\n1\n")), "line 3 has 1 numbers for 2 columns"),
    (lambda d: F.Aircraft(controls=_file(d, "time,bank\n0,left\n")), "line 2: 'left' is not a number"),
    (lambda d: F.Aircraft(controls=_file(d, "time,throttle\n0,1.5\n")), "csv: throttle must be from 0 to 1, not 1.5"),
    (lambda d: F.Aircraft(controls=_file(d, "# deg\ntime,bank\n\n0,1\n1,x\n")), "line 5: 'x'"),
    (lambda d: F.Aircraft(controls={"time": [0], "angle_of_attack": [500]}), "from -90 to 90 degrees, not 500"),
    (lambda d: F.Aircraft(controls=_file(d, "time,throttle\n0,nan\n")), "not finite"),
    (lambda d: F.Aircraft(controls={"time": [0, 1], "bank": [0]}), "one length"),
    (lambda d: F.Aircraft(up=(0, 0, 0)), "null vector"),
    (lambda d: F.Ballast(volume=1.0, tanks=2.0), "do not fit"),
    (lambda d: ga.ParticleSystem(position=np.zeros((1, 3)), forces=[F.Aircraft()]), "density"),
])  # fmt: skip
def test_bad_controls_are_refused_with_a_sentence(make, words, tmp_path):
    with pytest.raises(ga.UsageError, match=words):
        make(tmp_path)


def _file(folder, text):
    path = folder / "c.csv"
    path.write_text(text)
    return str(path)


def steered(force, velocity=(0.0, 0.0, 0.0), ledger=False):
    system = ga.ParticleSystem(position=[[1.0, 0.5, 0.0]], velocity=[velocity], mass=2.0, forces=[force])
    return ga.Simulation({"p": system}, dt=0.01, precision="f64", ledger=ledger)


@pytest.mark.parametrize("share,thrust", [((0.6, 0.0, 0.0), 1.8), ((0.0, 0.0, -1.0), 3.0), ((1.0, 1.0, 0.0), 3.0)])
def test_a_thruster_gives_its_share_and_no_more_than_all_of_it(share, thrust):
    sim = steered(F.Thruster(max_thrust=3.0, **dict(zip("xyz", share))))
    sim.step(100)
    along = np.array(share) / np.linalg.norm(share)
    assert sim["p"].velocity[0] == pytest.approx(along * thrust / 2.0, rel=1e-12)  # v = F t / m, after a second


def test_an_attractor_at_rest_is_point_gravity_and_pushes_where_its_pull_is_negative():
    still = {"time": [0.0, 1.0], "x": [0.2, 0.2], "pull": [1.0, 1.0]}
    runs = [
        steered(force, (0.0, 0.3, 0.1))
        for force in (
            F.Attractor(still, GM=2.0, softening=0.1),
            F.PointGravity((0.2, 0.0, 0.0), 2.0, 0.1),
            F.Attractor({**still, "pull": [-1.0, -1.0]}, GM=2.0, softening=0.1),
        )
    ]
    for sim in runs:
        sim.step(20)
    pulled, point, pushed = (sim["p"].position[0] for sim in runs)
    assert pulled == pytest.approx(point, rel=1e-13)
    assert pushed[0] > 1.0 > pulled[0]


def test_the_account_of_a_moving_attractor_and_of_a_thruster_closes():
    path = {"time": [0.0, 1.0], "x": [0.0, 1.0], "pull": [1.0, 0.2]}
    forces = {
        "attractor": F.Attractor(path, GM=2.0, softening=0.4),
        "thruster": F.Thruster({"time": [0, 1], "x": [1, 0]}),
    }
    for name, force in forces.items():
        sim = steered(force, (0.0, 0.5, 0.0), ledger=True)
        sim.step(100)
        account = sim.ledger()
        assert abs(account.work[f"p.{name}"]) > 1e-3
        assert abs(account.residual) <= 1e-9 * account.scale
