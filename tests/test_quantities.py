"""Quantities of astropy and pint: every unit is one that both know, and a quantity gives the bits of the plain number."""

import subprocess
import sys

import astropy.constants
import astropy.units
import numpy as np
import pint
import pytest

import gen_art as ga
from gen_art import arguments
from gen_art.preset.registered import registry
from gen_art.quantities import plain, units_of

KINDS = ("forces", "interactions", "colliders", "shapes", "velocities", "emitters")
REGISTRY = pint.UnitRegistry()
LIBRARIES = {"astropy": astropy.units.Quantity, "pint": REGISTRY.Quantity}


@pytest.fixture(params=LIBRARIES)
def quantity(request):
    """Makes a quantity of a number and the text of a unit, in either library."""
    return LIBRARIES[request.param]


PARAMETERS = sorted(
    {
        (parameter.unit, name)
        for kind in KINDS
        for name, one in registry(kind).classes.items()
        for parameter in one.parameters.values()
        if parameter.unit
    }
)


@pytest.mark.parametrize("unit", sorted({unit for unit, _ in PARAMETERS}))
def test_units_of_all_parameters_are_known_to_both_libraries(unit, quantity):
    for one in units_of(unit):
        assert plain(quantity(3.0, one), unit, "x") == 3.0


def test_parameters_have_units():
    assert len({unit for unit, _ in PARAMETERS}) > 25  # else the test above passes for want of parameters


@pytest.mark.parametrize(
    "number, given, unit, expected",
    [
        (250.0, "cm", "m", 2.5),
        (36.0, "km/h", "m/s", 10.0),
        (1.0, "minute", "s", 60.0),
        (180.0, "deg", "rad", np.pi),
        (np.pi, "rad", "degrees", 180.0),
        (2.0, "kN/m", "N/m", 2000.0),
        (3.0, "g/cm^3", "kg/m^3", 3000.0),
        (4.0, "km/s", "m/s or m/s^2", 4000.0),
        (4.0, "km/s^2", "m/s or m/s^2", 4000.0),
        (5.0, "percent", "", 0.05),
        (2.0, "kHz", "1/s", 2000.0),
    ],
)
def test_conversion(quantity, number, given, unit, expected):
    assert plain(quantity(number, given), unit, "x") == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("celsius", [astropy.units.Quantity(25.0, "deg_C"), REGISTRY.Quantity(25.0, "degC")])
def test_degrees_celsius_are_kelvin(celsius):
    assert ga.forces.ThermalLift(ambient=celsius).values["ambient"] == pytest.approx(298.15, rel=1e-14)


def test_revolutions_are_no_hertz():
    with pytest.raises(ga.UsageError, match="is in Hz, and 60 revolutions_per_minute cannot be converted to it"):
        plain(60 * REGISTRY.rpm, "Hz", "frequency")
    assert plain(60 * REGISTRY.rpm, "rad/s", "spin") == pytest.approx(2 * np.pi, rel=1e-14)


def test_lists_may_mix_quantities_and_numbers(quantity):
    assert plain([quantity(1.0, "km"), 2.0, [quantity(3.0, "cm")]], "m", "x") == [1000.0, 2.0, [0.03]]
    pair = (1.0, 2.0)
    assert plain(pair, "m", "x") is pair


@pytest.mark.parametrize("value", [1.0, "3 m", None, True, {"a": 1}, np.ones(3), [1, [2]], object()])
def test_other_values_stay_what_they_are(value):
    assert plain(value, "m", "x") is value


def test_parameters(quantity):
    gravity = ga.forces.Gravity(quantity([0.0, -981.0, 0.0], "cm/s^2"))
    assert gravity.values["field"] == pytest.approx((0.0, -9.81, 0.0), rel=1e-14)
    parts = ga.forces.Gravity((quantity(0.0, "m/s^2"), quantity(-981.0, "cm/s^2"), 0.0))
    assert parts.values["field"] == pytest.approx((0.0, -9.81, 0.0), rel=1e-14)
    assert ga.forces.Driver(phase=quantity(90.0, "deg")).values["phase"] == pytest.approx(np.pi / 2, rel=1e-14)
    lengths = quantity([50.0], "cm")
    springs = ga.interactions.Springs([[0, 1]], quantity(1.0, "kN/m"), lengths)
    assert springs.values["stiffness"] == 1000.0 and springs.values["rest_length"].tolist() == [0.5]
    assert ga.interactions.Springs(rest_length=quantity(50.0, "cm")).values["rest_length"] == 0.5
    wind = ga.Medium(density=quantity(1.2, "g/L"), wind=quantity([3.6, 0.0, 0.0], "km/h"))
    assert wind.density == pytest.approx(1.2, rel=1e-14)
    assert wind.terms[0].values["velocity"] == pytest.approx((1.0, 0.0, 0.0), rel=1e-14)


def test_constants_of_astropy():
    constants = astropy.constants
    assert ga.interactions.SelfGravity(G=constants.G).values["G"] == constants.G.value
    assert ga.forces.PointGravity(GM=constants.GM_sun).values["GM"] == constants.GM_sun.value


def test_columns_of_controls(quantity):
    def hand(**controls):
        return ga.forces.Hand(controls=controls)

    one = hand(time=quantity([0.0, 1.0], "minute"), y=quantity([0.0, 50.0], "cm"))
    assert one.numbers() == hand(time=[0.0, 60.0], y=[0.0, 0.5]).numbers()
    assert np.array_equal(one.table(), hand(time=[0.0, 60.0], y=[0.0, 0.5]).table())


def flight(u):
    """The particles of a short run, all of whose numbers are u(number, unit)."""
    system = ga.ParticleSystem(
        position=u([[0.0, 1.0, 0.0], [2.0, 0.0, 0.0]], "m"),
        velocity=u([[1.0, 2.0, 0.0], [0.0, 3.0, 0.0]], "m/s"),
        mass=u([1.0, 2.0], "kg"),
        charge=u(0.5, "C"),
        radius=u(0.25, "m"),
        forces=[ga.forces.Gravity(), ga.forces.Drag(linear=u(0.5, "kg/s"))],
    )
    sim = ga.Simulation({"stars": system}, dt=u(0.125, "s"), precision="f64")
    sim.advance(u(0.5, "s"))
    stars = sim["stars"]
    stars.set(velocity=u([0.0, 1.0, 0.0], "m/s"), where=[0])
    stars.add(position=u([0.0, 4.0, 0.0], "m"), mass=u(3.0, "kg"), lifetime=u(0.25, "s"))
    counts = [stars.count]
    sim.advance(u(0.5, "s"))
    counts.append(stars.count)
    return counts, np.column_stack([stars.position, stars.velocity, stars.mass, stars.charge, stars.radius])


OTHER_UNITS = {"m": "cm", "m/s": "cm/s", "kg": "g", "C": "mC", "s": "ms", "kg/s": "g/s"}


def test_a_run(quantity):
    """In other units the numbers differ by round-off alone, and so do the particles after eight steps."""

    def in_other_units(number, unit):
        other = OTHER_UNITS[unit]
        return quantity(np.asarray(number) * (100.0 if other.startswith("cm") else 1000.0), other)

    counts, rows = flight(in_other_units)
    expected_counts, expected = flight(lambda number, unit: number)
    assert counts == expected_counts == [3, 2]
    assert np.allclose(rows, expected, rtol=1e-13, atol=1e-13)
    assert np.ptp(expected[:, 1]) > 0.1


BODY = {
    "mass": (3.0, "kg"),
    "position": ([0.0, 1.0, 2.0], "m"),
    "turn": ([0.0, 0.5, 0.0], "rad"),
    "velocity": ([1.0, 0.0, 0.0], "m/s"),
    "spin": ([0.0, 2.0, 0.0], "rad/s"),
    "grain": (0.01, "m"),
}


def test_a_body(quantity):
    made = ga.body(
        {"box": quantity([50.0, 100.0, 25.0], "cm"), "turn": quantity([0.0, 0.0, 0.5], "rad")},
        **{key: quantity(number, unit) for key, (number, unit) in BODY.items()},
    )
    turn = [0.0, 0.0, np.degrees(0.5)]
    expected = ga.body({"box": [0.5, 1.0, 0.25], "turn": turn}, **{k: number for k, (number, _) in BODY.items()})
    for key in ("mass", "inertia", "place", "velocity", "spin", "attitude"):
        assert np.allclose(getattr(made, key), getattr(expected, key), rtol=1e-13, atol=1e-13), key
    assert np.allclose(made.local, expected.local, rtol=1e-12, atol=1e-12)
    assert np.allclose(made.radii, expected.radii, rtol=1e-14)
    assert all(type(value) is float for value in (made.spec["mass"], *made.spec["position"]))  # a snapshot holds it
    pivoted = ga.body({"sphere": 0.5}, pivot=quantity([0.0, 100.0, 0.0], "cm"))
    assert pivoted.place.tolist() == [0.0, 1.0, 0.0]


def test_the_density_of_a_hollow_body_is_that_of_its_surface(quantity):
    solid = ga.body({"sphere": 1.0}, density=quantity(1.0, "g/cm^3"))
    shell = ga.body({"sphere": 1.0}, density=quantity(1.0, "g/cm^2"), hollow=True)
    assert solid.mass == pytest.approx(4e3 / 3 * np.pi, rel=1e-13)
    assert shell.mass == pytest.approx(4 * np.pi * 10, rel=1e-13)
    with pytest.raises(ga.UsageError, match=r"density is in kg/m\^2, and 1.0 .* cannot be converted"):
        ga.body({"sphere": 1.0}, density=quantity(1.0, "g/cm^3"), hollow=True)


def test_joints(quantity):
    given = {
        "ball": ([0.0, 50.0, 0.0], "cm", {"ball": ["rod", "world"]}, [0.0, 0.5, 0.0]),
        "distance": (
            [[0.0, 50.0, 0.0], [0.0, 150.0, 0.0]],
            "cm",
            {"distance": ["rod", "world"]},
            [[0, 0.5, 0], [0, 1.5, 0]],
        ),
    }
    for name, (at, unit, bodies, expected) in given.items():
        points = [quantity(one, unit) for one in at] if name == "distance" else quantity(at, unit)
        joint = ga.interactions.Rigid(joints={name: {**bodies, "at": points}}).values["joints"][name]
        assert np.allclose(joint["at"], expected, rtol=1e-14)
    hinge = {"hinge": ["rod", "world"], "at": [0, 0, 0], "range": quantity([-0.5, 0.5], "rad")}
    hinge["motor"] = {"speed": quantity(180.0, "deg/s"), "torque": quantity(2.0, "kN m")}
    made = ga.interactions.Rigid(joints={"arm": hinge}).values["joints"]["arm"]
    assert np.allclose(made["range"], np.degrees([-0.5, 0.5]), rtol=1e-14)
    assert made["motor"] == {"speed": pytest.approx(np.pi), "torque": 2000.0}
    slider = {"slider": ["rod", "world"], "at": [0, 0, 0], "range": (0.0, quantity(50.0, "cm"))}
    slider["motor"] = {"speed": quantity(1.0, "cm/s"), "force": quantity(1.0, "kN")}
    made = ga.interactions.Rigid(joints={"arm": slider}).values["joints"]["arm"]
    assert made["range"] == (0.0, 0.5) and made["motor"] == {"speed": 0.01, "force": 1000.0}
    with pytest.raises(ga.UsageError, match=r"^joint 'arm': speed is in m/s, and 1.0 k.* cannot be converted to it$"):
        ga.interactions.Rigid(joints={"arm": {**slider, "motor": {"speed": quantity(1.0, "kg")}}})


def test_nets_orbits_and_cameras(quantity):
    rope = ga.rope(quantity([0, 0, 0], "cm"), quantity([100, 0, 0], "cm"), 5, length=quantity(120, "cm"))
    plain_rope = ga.rope([0, 0, 0], [1, 0, 0], 5, length=1.2)
    assert np.allclose(rope.position, plain_rope.position, rtol=1e-14, atol=1e-14)
    sides = [quantity(side, "cm") for side in ([0, 0, 0], [100, 0, 0], [0, -100, 0])]
    assert np.allclose(ga.cloth(*sides, 3, 3).position, ga.cloth([0, 0, 0], [1, 0, 0], [0, -1, 0], 3, 3).position)
    orbit = ga.orbital_elements(
        quantity([1.0, 0.0, 0.0], "km"), quantity([0.0, 1.0, 0.0], "km/s"), quantity(1.0, "km^3/s^2")
    )
    assert orbit.semi_major_axis == pytest.approx(1000.0, rel=1e-13)
    assert orbit.period == pytest.approx(2 * np.pi, rel=1e-13)
    camera = ga.Camera(position=quantity([0, 0, 500], "cm"), fov=quantity(0.5, "rad"), lens=(quantity(5, "cm"), None))
    assert camera.position == (0, 0, 5) and camera.fov == pytest.approx(np.degrees(0.5)) and camera.lens == (0.05, None)


WRONG = {
    "a parameter": (lambda kg: ga.forces.Gravity(kg), r"Gravity: field is in m/s\^2, and 3.0 .*"),
    "a number without a unit": (
        lambda kg: ga.forces.Drag(linear=1.0, cd=kg),
        "Drag: cd is a number without a unit, not 3.0 k.*",
    ),
    "a choice": (lambda kg: ga.interactions.Springs(method=kg), "Springs: method is a number without a unit.*"),
    "dt": (lambda kg: simulation(dt=kg), "dt, the time step, is in s, and 3.0 k.*"),
    "a seed": (lambda kg: simulation(seed=kg), "seed is a number without a unit, not 3.0 k.*"),
    "a time": (lambda kg: simulation().advance(kg), "the time to advance by is in s, and 3.0 k.*"),
    "positions": (lambda kg: ga.ParticleSystem(position=[[kg, 0, 0]]), "position is in m, and 3.0 k.*"),
    "an attribute": (
        lambda kg: ga.ParticleSystem(position=[[0, 0, 0]], attributes={"hue": kg}),
        "hue is a number without a unit, not 3.0 k.*",
    ),
    "ids": (lambda kg: simulation()["stars"].remove(kg), "ids is a number without a unit, not 3.0 k.*"),
    "a velocity": (
        lambda kg: simulation()["stars"].set(velocity=[kg, 0, 0]),
        "velocity is in m/s, and 3.0 k.*",
    ),
    "a body": (lambda kg: ga.body({"sphere": 1}, position=[kg, 0, 0]), "body: position is in m, and 3.0 k.*"),
    "a shape": (lambda kg: ga.body({"sphere": kg}), "sphere of a shape is in m, and 3.0 k.*"),
    "a name": (lambda kg: simulation()[kg], "the name of a system must be text, not 3.0 k.*"),
    "a key of a preset": (
        lambda kg: simulation(domain={"periodic": {"min": (0, 0, 0), "max": (kg, 1, 1)}}),
        "the keys of a preset hold plain numbers, not 3.0 k.*",
    ),
    "an override": (
        lambda kg: ga.load_preset({"version": 1}, overrides={"clock.duration": kg}),
        "the keys of a preset hold plain numbers, not 3.0 k.*",
    ),
    "a camera": (lambda kg: ga.Camera(height=kg), "the camera's height is in m, and 3.0 k.*"),
}


def simulation(**changes):
    return ga.Simulation({"stars": ga.ParticleSystem(position=[[0.0, 0.0, 0.0]])}, **{"dt": 0.01, **changes})


@pytest.mark.parametrize("call, sentence", WRONG.values(), ids=WRONG)
def test_a_wrong_dimension_is_a_sentence(call, sentence, quantity):
    with pytest.raises(ga.UsageError, match=f"^{sentence}$"):
        call(quantity(3.0, "kg"))


def test_a_wrong_array_is_named_by_its_shape(quantity):
    with pytest.raises(ga.UsageError, match=r"^position is in m, and an array in .* with the shape \(2, 3\) cannot be"):
        ga.ParticleSystem(position=quantity(np.ones((2, 3)), "s"))


def test_ranges_are_checked_after_the_conversion(quantity):
    with pytest.raises(ga.UsageError, match="above 0 s, not "):
        simulation(dt=quantity(-1.0, "ms"))
    with pytest.raises(ga.UsageError, match="must be a finite number"):
        simulation(dt=quantity(np.nan, "ms"))
    assert arguments.shown(quantity(3.0, "m")).startswith("3.0 m")


def test_neither_library_is_imported_without_a_quantity():
    code = (
        "import sys, gen_art as ga; sim = ga.Simulation({'s': ga.ParticleSystem([[0, 0, 0]], forces=[ga.forces.Gravity()])}, dt=1);"
        "print([name for name in ('astropy', 'pint') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
