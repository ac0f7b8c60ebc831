"""Births: exact times, keys that depend on nothing else, particles spread within a step, children of events."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.emitters.schedule import Burst, Pulse, Rate
from gen_art.simulation.children import Children


def preset(systems, step=0.01, **more):
    return ga.load_preset(
        {
            "version": 1,
            "seed": 5,
            "clock": {"duration": 1, "fps": 10, "step": step, "speed": 1},
            "systems": systems,
            **more,
        }
    )


def simulate(systems, seconds, step=0.01, precision="f64", **more):
    sim = ga.Simulation(preset(systems, step, **more), precision=precision)
    sim.advance(seconds)
    return sim


FOUNTAIN = {
    "particle": {"lifetime": "0.2..0.6", "radius": "0.01..0.02", "density": 1000},
    "emitters": {
        "a": {"rate": 137.7, "shape": {"ball": 0.3}, "velocity": {"cone": [0, 1, 0], "angle": 30, "speed": "1..3"}},
        "b": {"rate": [[0, 0], [0.5, 400], [1, 50]], "shape": {"disc": 1.0}, "velocity": {"sphere": 2}},
    },
}


@pytest.mark.parametrize(
    "schedule",
    [
        Rate(137.7),
        Rate([[0, 0], [0.5, 400], [1, 50]]),
        Rate(50, 0.123, 0.7),
        Rate(300, 0, None, Pulse(0.3, 0.8)),
        Rate(300, 0, None, Pulse(0.3, 0.8, 0.25)),
        Burst([0.1, 0.25, 0.25, 0.7], [3, 5, 1, 2]),
    ],
)
def test_times_and_counts_agree(schedule):
    """until(t) counts exactly the births whose own times are at or before t."""
    n = schedule.until(1.5)
    times = schedule.times(0, n)
    assert (np.diff(times) >= 0).all() and times[-1] <= 1.5
    for t in [*np.linspace(0, 1.5, 301), *times, *np.nextafter(times, 0)]:
        assert schedule.until(t) == np.count_nonzero(times <= t)


@pytest.mark.parametrize("pulse", [Pulse(0.3, 0.8), Pulse(0.3, 0.8, 0.25), Pulse(0.013, 0.99)])
def test_counts_of_a_dense_pulsed_rate_agree_with_its_times(pulse):
    """A count looks among the five births around its guess, so that at a million a second the guess has to be good to 2e-6 s.
    Mutants: a sine of the other sign, or of a frequency that is a thousandth too high."""
    schedule = Rate(1e6, pulse=pulse)
    times = schedule.times(0, 1_000_000)
    for t in np.random.default_rng(1).uniform(0, 0.9, 200):
        assert schedule.until(t) == np.searchsorted(times, t, "right")


def test_births_follow_the_integral_of_the_rate():
    times = Rate([[0, 0], [0.5, 400], [1, 50]]).times(0, 150)
    rising = times <= 0.5
    assert np.allclose(400 * times[rising] ** 2, np.arange(rising.sum()) + 0.5)  # integral of 800 t
    assert np.allclose(Rate(8.0, 2.0).times(0, 4), 2 + (np.arange(4) + 0.5) / 8)
    assert not np.allclose(Rate(8.0, 2.0).times(0, 4), 2 + np.arange(4) / 8)  # the mutant: births at whole counts


def test_a_pulse_gathers_births_and_keeps_their_number():
    times = Rate(1e5, pulse=Pulse(0.5, 0.8)).times(0, 100_000)
    phase = times / 0.5 % 1
    near, far = np.count_nonzero((phase < 0.002) | (phase > 0.998)), np.count_nonzero(abs(phase - 0.5) < 0.02)
    assert near / 400 == pytest.approx(1 / (1 - 0.8), rel=0.03)  # the peak of 1 / (1 - depth cos) over the mean
    assert far / 4000 == pytest.approx(1 / (1 + 0.8), rel=0.03)
    assert times[-1] == pytest.approx(1.0, abs=1e-4)


def test_a_pulse_of_a_short_duty_has_gaps():
    rate = Rate(1e5, pulse=Pulse(0.5, 0.0, 0.2))
    times = rate.times(0, 100_000)
    phase = (times / 0.5 + 0.5) % 1 - 0.5
    assert abs(phase).max() == pytest.approx(0.1, abs=1e-4)  # births in the 0.2 about each beginning, and evenly there
    assert np.histogram(phase, 10, (-0.1, 0.1))[0] == pytest.approx(np.full(10, 1e4), rel=0.01)
    assert np.all(np.diff(times) >= 0) and times[-1] == pytest.approx(1.0, abs=1e-4)
    for moment in (0.0, 0.03, 0.25, 0.46, 0.5, 0.7):
        assert rate.until(moment) == np.count_nonzero(times <= moment)


@pytest.mark.parametrize("precision,tolerance", [("f64", 1e-12), ("f32", 2e-5)])
def test_same_particles_at_every_time_step(precision, tolerance):
    """Exact but for places: those of float32 are sums of up to 160 equal steps, each rounded to eps of up to 2 m."""
    runs = [simulate({"s": FOUNTAIN}, 0.8, step, precision)["s"] for step in (0.02, 0.01, 0.005)]
    for other in runs[1:]:
        for name in ("ids", "keys", "emitter", "mass", "radius"):
            assert np.array_equal(getattr(runs[0], name), getattr(other, name)), name
        assert np.array_equal(runs[0].attribute("lifetime"), other.attribute("lifetime"))
        assert np.allclose(runs[0].age, other.age, rtol=0, atol=1e-14)
        assert np.allclose(runs[0].position, other.position, rtol=0, atol=tolerance)  # no forces: exact up to rounding


def test_a_step_at_a_time_or_many_are_the_same_bits():
    one, many = ga.Simulation(preset({"s": FOUNTAIN})), ga.Simulation(preset({"s": FOUNTAIN}))
    for _ in range(70):
        one.step(1)
    many.step(70)
    assert one.digest() == many.digest()
    many.step(1)
    assert one.digest() != many.digest()


def by_key(system, emitter):
    of = system.emitter == emitter
    return {
        k: (*x, *v, m) for k, x, v, m in zip(system.keys[of], system.position[of], system.velocity[of], system.mass[of])
    }


def test_emitters_do_not_know_of_each_other():
    forces = {"forces": {"gravity": [0, -9.81, 0], "curl_noise": {"strength": 3, "octaves": 2}}}
    base = by_key(simulate({"s": FOUNTAIN}, 0.7, **forces)["s"], "a")
    louder = {**FOUNTAIN, "emitters": {**FOUNTAIN["emitters"], "b": {"rate": 3000, "velocity": {"sphere": 1}}}}
    added = {**FOUNTAIN, "emitters": {"0new": {"rate": 500}, **FOUNTAIN["emitters"]}}
    turned = {**FOUNTAIN, "emitters": dict(reversed(FOUNTAIN["emitters"].items()))}
    for systems in ({"s": louder}, {"s": added}, {"s": turned}, {"other": FOUNTAIN, "s": FOUNTAIN}):
        assert by_key(simulate(systems, 0.7, **forces)["s"], "a") == base
    faster = {**FOUNTAIN, "emitters": {**FOUNTAIN["emitters"], "a": {**FOUNTAIN["emitters"]["a"], "rate": 138.7}}}
    assert by_key(simulate({"s": faster}, 0.7, **forces)["s"], "b") == by_key(
        simulate({"s": FOUNTAIN}, 0.7, **forces)["s"], "b"
    )
    reseeded = simulate({"s": FOUNTAIN}, 0.7, seed=6, **forces)["s"]
    assert not set(by_key(reseeded, "a")) & set(base)


GIVEN: dict = {}  # what the next `sample` does


@ga.emitter("as_given")
class AsGiven(ga.Emitter):
    """What a test gives."""

    def sample(self, r, n):
        return GIVEN["sample"](self, r, n)


@pytest.mark.parametrize(
    "sample, words",
    [
        (lambda self, r, n: {"position": self.text}, "fails: AttributeError: .* 'text'"),
        (lambda self, r, n: 1 / 0, "fails: ZeroDivisionError"),
        (lambda self, r, n: np.zeros((3, n)), "must return a dict of arrays, not"),
        (lambda self, r, n: {"position": np.zeros((n, 3))}, r"gives position as an array of shape \(20, 3\), not \(3, 20\)"),
        (lambda self, r, n: {"mass": np.ones(n + 1)}, r"gives mass as an array of shape \(21,\)"),
        (lambda self, r, n: {"mass": [[1], [1, 2]]}, "gives mass as .*, not as numbers"),
        (lambda self, r, n: {"position": np.zeros(n)}, r"gives position as an array of shape \(20,\), not \(3, 20\)"),
        (lambda self, r, n: {"velocity": 0.0}, r"gives velocity as an array of shape \(\), not"),
        (lambda self, r, n: {"mass": ["heavy"] * n}, "gives mass as a list of 20, not as numbers"),
        (lambda self, r, n: {"colour": np.ones(n)}, "sets colour, which no particle here has"),
    ],
)  # fmt: skip
def test_what_a_sample_does_wrong_is_a_sentence(sample, words):
    GIVEN["sample"] = sample
    with pytest.raises(ga.UsageError, match=words):
        simulate({"s": {"emitters": {"a": {"count": 20, "as_given": {}}}}}, 0.0)
    if "no particle here" not in words:
        with pytest.raises(ga.UsageError, match=words):
            AsGiven().arrays(20)


def test_a_sample_fills_what_it_gives():
    """NaN leaves the preset's value; a single column is for all. Mutants: NaN written; the origin left out."""
    GIVEN["sample"] = lambda self, r, n: {
        "position": [[1.0], [2.0], [3.0]],
        "mass": np.where(np.arange(n) < 5, np.nan, 7.0),
    }
    systems = {
        "s": {
            "particle": {"mass": 4},
            "emitters": {"a": {"count": 20, "as_given": {}, "motion": {"velocity": [1, 0, 0]}, "at": 0.5}},
        }
    }
    sim = simulate(systems, 0.5)
    assert sim["s"].position == pytest.approx(np.tile([1.5, 2.0, 3.0], (20, 1)))
    assert sim["s"].mass.tolist() == [4.0] * 5 + [7.0] * 15


def test_a_fast_emitter_makes_a_line():
    """50 particles a step from a moving emitter are uniform along its path, the partial first step included."""
    systems = {"s": {"emitters": {"jet": {"rate": 5000, "motion": {"velocity": [100, 0, 0]}}}}}
    x = simulate(systems, 0.1)["s"].position[:, 0]
    assert np.allclose(np.sort(x), 100 * (np.arange(500) + 0.5) / 5000, atol=1e-9)


def test_an_emitter_on_a_helix_leaves_its_births_on_it():
    """x = v t + R (cos, sin)(2 pi t / T + phase) about the axis, right-handed, at each one's own time of birth."""
    R, T, v = 0.7, 0.4, 3.0
    orbit = {"radius": R, "period": T, "axis": [1, 0, 0]}
    emitters = {
        name: {"rate": 1000, "tag": name, "motion": {"velocity": [v, 0, 0], "orbit": {**orbit, "phase": phase}}}
        for name, phase in (("a", 0), ("b", 90))
    }
    sim = simulate({"s": {"emitters": emitters}}, 0.5)
    s = sim["s"]
    born = 0.5 - s.age
    angle = np.arctan2(s.position[:, 2], s.position[:, 1]) - 2 * np.pi * born / T
    off = np.angle(np.exp(1j * (angle - angle[s.emitter == "a"][0])))
    assert np.allclose(s.position[:, 0], v * born, atol=1e-9)
    assert np.allclose(np.hypot(s.position[:, 1], s.position[:, 2]), R, atol=1e-9)
    assert np.allclose(np.where(s.emitter == "a", off, np.abs(off) - np.pi / 2), 0, atol=1e-9)
    wrong = angle - 0.01 * 2 * np.pi * born / T  # the mutant: a period 1% off
    assert np.ptp(wrong[s.emitter == "a"] % (2 * np.pi)) > 1e-3


def test_newborns_move_only_from_their_birth_on():
    systems = {"s": {"emitters": {"jet": {"rate": 5000, "velocity": [0, 7, 0]}}}}
    sim = simulate(systems, 0.03)
    assert np.allclose(sim["s"].position[:, 1], 7 * sim["s"].age, atol=1e-13)
    assert sim["s"].age.min() < 0.01 / 50


def test_deaths_come_at_their_time_and_ids_are_never_reused():
    system = {"particle": {"lifetime": 0.1}, "emitters": {"e": {"rate": 1000}}}
    sim = simulate({"s": system}, 0.5)
    assert sim["s"].count == 100 and sim["s"].ids[0] == 400
    assert (sim["s"].age < 0.1).all() and np.array_equal(np.sort(sim["s"].ids), sim["s"].ids)


BURST = {
    "shells": {
        "particle": {"lifetime": 0.155, "mass": 2},
        "emitters": {"m": {"at": [0, 0.031, 0.2], "velocity": {"cone": [0, 1, 0], "angle": 20, "speed": 5}}},
    },
    "stars": {
        "particle": {"lifetime": "0.3..0.5", "radius": "0.01..0.03", "density": 800},
        "emitters": {
            "burst": {
                "from": {"event": "shells.death", "inherit": "velocity", "balance": "pairs"},
                "choose": {
                    "round": {"weight": 2, "count": 40, "velocity": {"sphere": 9}},
                    "odd": {"count": "7..11", "velocity": {"sphere": 4}, "tag": "t"},
                },
            }
        },
    },
    "glitter": {"particle": {"lifetime": 0.2}, "emitters": {"g": {"from": {"event": "stars.path"}, "rate": 300}}},
}


def test_each_event_takes_one_kind_by_weight():
    """Of 4,000 bursts, three in four are of the kind with three times the weight, to five standard deviations."""
    bursts, share = 4000, 0.75
    kinds = {"common": {"weight": 3, "count": 2, "mass": 3}, "rare": {"weight": 1, "count": 5, "mass": 7}}
    systems = {
        "shells": {"particle": {"lifetime": 0.05}, "emitters": {"all": {"count": bursts}}},
        "stars": {"emitters": {"burst": {"from": {"event": "shells.death"}, "choose": kinds}}},
    }
    mass = simulate(systems, 0.1)["stars"].mass
    common, rare = np.sum(mass == 3), np.sum(mass == 7)
    assert common + rare == len(mass) and common % 2 == 0 and rare % 5 == 0
    assert common / 2 + rare / 5 == bursts
    assert abs(common / 2 - share * bursts) < 5 * np.sqrt(bursts * share * (1 - share))


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_burst_carries_no_momentum_of_its_own(precision):
    """In its frame, to 4 eps of what its parts carry, in either precision."""
    sim = simulate(BURST, 0.15, precision=precision)
    assert sim["stars"].count == 0
    parent = sim["shells"].velocity[0].astype(float)
    sim.step(1)
    stars = sim["stars"]
    mass, velocity = stars.mass.astype(float), stars.velocity.astype(float)
    momentum = (mass[:, None] * (velocity - parent)).sum(0)
    size = (mass[:, None] * np.abs(velocity - parent)).sum()
    assert np.abs(momentum).max() <= 4 * np.finfo(sim.dtype).eps * size
    lopsided = simulate(
        {
            **BURST,
            "stars": {
                **BURST["stars"],
                "emitters": {"burst": {**BURST["stars"]["emitters"]["burst"], "from": {"event": "shells.death"}}},
            },
        },
        0.16,
    )["stars"]
    assert np.abs((lopsided.mass[:, None] * lopsided.velocity).sum(0)).max() > 1e-3 * size


def test_children_are_the_same_at_every_time_step_and_exact_in_time():
    runs = [simulate(BURST, 0.4, step) for step in (0.02, 0.01, 0.005)]
    for name in ("stars", "glitter"):
        for other in runs[1:]:
            assert set(runs[0][name].keys) == set(other[name].keys)
    stars = runs[0]["stars"]
    assert np.allclose(np.unique(np.round(0.4 - stars.age, 9)), [0.155, 0.186, 0.355])
    assert np.array_equal(stars.ids, runs[2]["stars"].ids)
    assert np.array_equal(stars.keys, runs[2]["stars"].keys)


@pytest.mark.parametrize("interactions", [{}, {"self_gravity": {"softening": 0.1, "G": 1e-9}}])
def test_particles_that_live_for_less_than_a_step_have_children_too(interactions):
    """A spark of 4 ms, born of a death at 53 ms: on its way a birth every half millisecond, and two at its end, where it ended.
    Mutants: the dead are removed before their events are seen; their path goes on to the end of the step."""
    systems = {
        "shell": {"particle": {"lifetime": 0.05}, "emitters": {"m": {"at": 0.003, "velocity": [1, 0, 0]}}},
        "spark": {
            "particle": {"lifetime": 0.004, "mass": 1},
            "interactions": interactions,
            "emitters": {
                "m": {"from": {"event": "shell.death", "inherit": "velocity"}, "count": 1, "velocity": [0, 1, 0]}
            },
        },
        "glitter": {
            "particle": {"lifetime": 3},
            "emitters": {
                "way": {"from": {"event": "spark.path", "inherit": "none"}, "rate": 2000},
                "end": {"from": {"event": "spark.death", "inherit": "none"}, "count": 2},
            },
        },
    }
    sim = ga.Simulation(preset(systems), precision="f64", advice="none")
    sim.advance(0.2)
    glitter = sim["glitter"]
    after = np.append((np.arange(8) + 0.5) / 2000, [0.004, 0.004])  # the spark's birth
    place = np.stack([0.05 + after, after, 0 * after], axis=1)
    assert glitter.count == 10
    assert np.allclose(0.2 - glitter.age, 0.053 + after, rtol=0, atol=1e-12)
    assert np.allclose(glitter.position, place, rtol=0, atol=1e-9)


QUIET = {  # now and then something happens, and between that nothing does
    "long": {
        "particle": {"lifetime": "0.11..0.31"},
        "emitters": {"m": {"at": [0.05, 0.052, 0.5], "velocity": [0, 1, 0]}},
    },
    "hit": {
        "particle": {"lifetime": 5},
        "colliders": {"plane": {"point": [0, 0.303, 0], "normal": [0, -1, 0], "action": "kill"}},
        "emitters": {"m": {"at": [0.1, 0.6], "velocity": [0, 1, 0]}},
    },
    "bouncing": {
        "particle": {"lifetime": 0.4},
        "colliders": {"plane": {"point": [0, 0.2, 0], "normal": [0, -1, 0], "action": "emit"}},
        "emitters": {"m": {"at": [0.02, 0.7], "velocity": [0, 2, 0]}},
    },
    "children": {
        "particle": {"lifetime": "0.002..0.09"},
        "emitters": {
            "new": {"from": {"event": "long.birth"}, "count": 3, "velocity": {"sphere": 1}},
            "dead": {"from": {"event": "long.death"}, "count": 3, "velocity": {"sphere": 1}},
            "hit": {"from": {"event": "hit.death"}, "count": 3, "velocity": {"sphere": 1}},
            "impact": {"from": {"event": "bouncing.impact"}, "count": 3, "velocity": {"sphere": 1}},
        },
    },
    "grandchildren": {
        "particle": {"lifetime": 3},
        "emitters": {
            "new": {"from": {"event": "children.birth"}, "count": 1, "velocity": {"sphere": 1}},
            "dead": {"from": {"event": "children.death"}, "count": 2, "velocity": {"sphere": 1}},
        },
    },
}


@pytest.mark.parametrize("left_out", [(), ("bouncing",), ("hit",), ("hit", "bouncing"), ("hit", "bouncing", "long")])
def test_steps_without_events_are_taken_together_and_keep_their_bits(left_out, monkeypatch):
    """Mutants: a death, a birth, an end by a collider, an impact, or an event of particles born in the step before is overlooked."""
    systems = {name: system for name, system in QUIET.items() if name not in left_out}
    emitters = {k: e for k, e in QUIET["children"]["emitters"].items() if e["from"]["event"].split(".")[0] in systems}
    systems["children"] = {**QUIET["children"], "emitters": emitters}
    if not emitters:
        systems["children"] = {"emitters": {"m": {"at": [0.21, 0.5]}}, "particle": {"lifetime": 0.15}}
    together = ga.Simulation(preset(systems, 0.01))
    launches = []
    advance = ga.Simulation._advance
    monkeypatch.setattr(ga.Simulation, "_advance", lambda *args: launches.append(advance(*args)) or launches[-1])
    together.step(150)
    assert max(launches) >= 8 and sum(launches) == 150
    monkeypatch.setattr(Children, "steps_without_events", lambda self, first, most, dt: 0)
    one_by_one = ga.Simulation(preset(systems, 0.01))
    one_by_one.step(150)
    assert len(one_by_one["grandchildren"].ids) > 1
    assert together.digest() == one_by_one.digest()


def test_glitter_lies_on_its_parents_path():
    """Without forces a star's path is a straight line from the burst, and its glitter stays where it was dropped."""
    sim = simulate(BURST, 0.3)
    stars, glitter = sim["stars"], sim["glitter"]
    assert glitter.count > 500
    lines = stars.velocity / np.linalg.norm(stars.velocity, axis=1)[:, None]
    nearest = np.array([np.linalg.norm(np.cross(x - stars.position, lines), axis=1).min() for x in glitter.position])
    assert nearest.max() < 1e-9


def test_momentum_of_a_crossette_is_its_parents():
    systems = {
        "star": {"particle": {"lifetime": 0.05, "mass": 4}, "emitters": {"m": {"at": 0, "velocity": [1, 2, 3]}}},
        "bits": {
            "emitters": {
                "x": {"from": {"event": "star.death", "inherit": "velocity"}, "count": 4, "velocity": {"cross": 30}}
            }
        },
    }
    bits = simulate(systems, 0.1)["bits"]
    assert np.allclose(bits.velocity.mean(0), (1, 2, 3), atol=1e-12)
    angles = (bits.velocity - (1, 2, 3)) @ (bits.velocity - (1, 2, 3)).T / 900
    assert np.allclose(angles, [[1, 0, -1, 0], [0, 1, 0, -1], [-1, 0, 1, 0], [0, -1, 0, 1]], atol=1e-12)


SHAPES = {
    "ball": ({"ball": 2.0}, lambda x: ((x**2).sum(1) / 4) ** 1.5),
    "disc": ({"disc": 2.0, "inner": 1.0}, lambda x: ((x**2).sum(1) - 1) / 3),
    "line": ({"line": [[0, 0, 0], [2, 0, 0]]}, lambda x: x[:, 0] / 2),
    "box": ({"box": {"min": [0, 0, 0], "max": [1, 2, 3]}}, lambda x: x[:, 2] / 3),
    "ring": ({"ring": 2.0}, lambda x: np.arctan2(x[:, 0], x[:, 2]) / (2 * np.pi) + 0.5),
    "sphere": ({"sphere": 2.0}, lambda x: x[:, 1] / 4 + 0.5),
    "gaussian": (
        {"gaussian": [2, 2, 2]},
        lambda x: 0.5 * (1 + np.vectorize(__import__("math").erf)(x[:, 1] / np.sqrt(8))),
    ),
    "point": ({"point": [1, 2, 3]}, None),
}


@pytest.mark.parametrize("name", sorted(ga.emitters.SHAPES))
def test_shapes_are_uniform(name):
    """What should be uniform in (0, 1) is: Kolmogorov-Smirnov at p about 1e-3; a mutant distribution is not."""
    shape, quantile = SHAPES[name]
    x = simulate({"s": {"emitters": {"e": {"count": 4000, "shape": shape}}}}, 0.0)["s"].position
    assert len(x) == 4000
    if quantile is None:
        assert np.array_equal(np.unique(x, axis=0), [[1, 2, 3]])
        return

    def distance(u):
        return np.abs(np.sort(u) - (np.arange(4000) + 0.5) / 4000).max()

    u = quantile(x)
    assert (u > -1e-12).all() and (u < 1 + 1e-12).all()
    assert distance(u) < 1.95 / np.sqrt(4000)
    assert distance(np.clip(u, 0, 1) ** 1.2) > 1.95 / np.sqrt(4000)


def orbits(v, x):
    """Born at the pericentre of e = 0.25 with GM = 4: E = -GM / 2a, across the arm, turning about +z, carried along at 2 m/s."""
    arm, v = x - (3, 0, 0), v - (0, 0, 2)
    r = np.linalg.norm(arm, axis=1)
    energy = 0.5 * (v**2).sum(1) - 4 / r
    turns = np.cross(arm, v)[:, 2] > 0
    return np.allclose(energy, -4 * 0.75 / (2 * r)) and np.allclose((arm * v).sum(1), 0, atol=1e-9) and turns.all()


VELOCITIES = {
    "constant": ([1, 2, 3], lambda v, x: np.allclose(v, (1, 2, 3))),
    "cone": ({"cone": [0, 0, 1], "angle": 30, "speed": "2..3"}, lambda v, x: (v[:, 2] >= np.cos(np.pi / 6) * np.linalg.norm(v, axis=1) - 1e-9).all()),
    "sphere": ({"sphere": 2}, lambda v, x: np.allclose(np.linalg.norm(v, axis=1), 2) and np.abs(v.mean(0)).max() < 0.1),
    "radial": ({"radial": 2}, lambda v, x: np.allclose(v, 2 * x / np.linalg.norm(x, axis=1)[:, None])),
    "thermal": ({"thermal": 3, "mean": [1, 0, 0]}, lambda v, x: np.allclose(v.std(0), 3, rtol=0.05) and np.allclose(v.mean(0), (1, 0, 0), atol=0.2)),
    "cross": ({"cross": 3}, lambda v, x: np.allclose(np.linalg.norm(v, axis=1), 3)),
    "ring": ({"ring": 3, "axis": [0, 1, 0]}, lambda v, x: np.allclose(v[:, 1], 0, atol=1e-12) and np.allclose(np.linalg.norm(v, axis=1), 3)),
    "orbit": ({"orbit": 4, "center": [3, 0, 0], "axis": [0, 0, 1], "eccentricity": 0.25, "mean": [0, 0, 2]}, orbits),
    "pitched": ({"pitched": [1, 0, 0], "pitch": 60, "speed": 2}, lambda v, x: np.allclose(v[:, 0], 1) and np.allclose((v * x)[:, 1:].sum(1), 0, atol=1e-12)),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(ga.emitters.VELOCITIES))
def test_velocities(name):
    velocity, right = VELOCITIES[name]
    s = simulate({"s": {"emitters": {"e": {"count": 3000, "shape": {"ball": 1}, "velocity": velocity}}}}, 0.0)["s"]
    assert right(s.velocity, s.position)
    assert not right(s.velocity * 1.3 + 0.2, s.position)
