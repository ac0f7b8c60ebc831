"""The tree against the sum over all pairs: its errors, its momentum, its energy, its bits."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.backend import runtime
from gen_art.backend.runtime import ti
from gen_art.interactions import tree_sum as tree
from gen_art.interactions.expansions import CENTRE, MOMENTS, expansion
from gen_art.interactions.octree import build_octree
from tests.threads import digests

I = ga.interactions


def plummer(n, seed=0):
    r = np.random.default_rng(seed)
    radius = (r.uniform(0, 0.999, n) ** (-2 / 3) - 1) ** -0.5
    way = r.normal(size=(3, n))
    return way / np.linalg.norm(way, axis=0) * radius


def exact(x, sources, amounts, soft, of):
    """(3, len(of)): gradient of the sum of amounts / s at the targets `of`, none acting on itself."""
    out = np.zeros((3, len(of)))
    for k, i in enumerate(of):
        d = sources - x[:, i : i + 1]
        r2 = (d * d).sum(0)
        g = np.where(r2 > 0, (r2 + soft**2 + (r2 == 0)) ** -0.5, 0.0)
        out[:, k] = (amounts * g**3 * d).sum(1)
    return out


def errors(found, right):
    e = np.linalg.norm(found - right, axis=0) / np.linalg.norm(right, axis=0)
    return np.sqrt((e**2).mean()), np.quantile(e, 0.99)


@pytest.fixture(autouse=True)
def started():
    runtime.init()


@pytest.mark.parametrize("n", [8000, pytest.param(32_000, marks=pytest.mark.proof)])
@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_forces_and_momentum(n, precision):
    dtype = np.float64 if precision == "f64" else np.float32
    x, m = plummer(n).astype(dtype), (np.random.default_rng(1).uniform(0.5, 1.5, n) / n).astype(dtype)
    of = np.arange(0, n, n // 500)
    found = tree.sum_by_tree(x, None, m, 0.01, 0.6, 5, precision)
    rms, worst = errors(found[:, of], exact(x.astype(float), x.astype(float), m.astype(float), 0.01, of))
    assert rms <= 3e-3 and worst <= 1.5e-2
    force = m * found.astype(np.float64)
    assert np.abs(force.sum(1)).max() <= 1e-6 * np.abs(force).sum()


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_errors_fall_with_theta_as_the_order_says(order):
    """The first terms left out are of order + 1 in the sizes of cells over their distance, and the field itself is of order 1."""
    x, m = plummer(4000), np.full(4000, 1 / 4000)
    of = np.arange(0, 4000, 10)
    right = exact(x, x, m, 0.01, of)
    coarse, fine = (
        errors(tree.sum_by_tree(x, None, m, 0.01, theta, order, "f64")[:, of], right)[0] for theta in (0.5, 0.25)
    )
    assert fine < coarse / (0.7 * 2**order)
    assert errors(tree.sum_by_tree(x, None, m, 0.01, 0.5, order - 1, "f64")[:, of], right)[0] > 1.5 * coarse


def test_moments_of_a_cell_are_those_of_its_particles():
    """Moments are raised from children to parents; a mutant that forgets the shift has the moments about other centres."""
    r = np.random.default_rng(11)
    x, m = r.normal(size=(3, 700)), r.uniform(-1, 1, 700)
    cells = tree._Cells(x, m, 5, "f64")
    root = cells.moments[0]
    d = x - root[CENTRE : CENTRE + 3, None]
    size = np.abs(m) @ (d * d).sum(0)
    assert root[MOMENTS] == pytest.approx(m.sum())
    assert root[MOMENTS + 1 : MOMENTS + 4] == pytest.approx(d @ m, abs=1e-12 * size)
    second = [(d[i] * d[j] * m).sum() / (2 if i == j else 1) for i in range(3) for j in range(i, 3)]
    assert root[MOMENTS + 4 : MOMENTS + 10] == pytest.approx(second, abs=1e-12 * size)
    fourth = (d[0] ** 4 * m).sum() / 24
    assert root[MOMENTS + 20] == pytest.approx(fourth, abs=1e-12 * np.abs(m) @ (d * d).sum(0) ** 2)


def test_quadrupoles_count(monkeypatch):
    r = np.random.default_rng(4)  # a rod, seen from afar by a small crowd: its quadrupole counts
    rod, crowd = (
        r.uniform(-1, 1, (3, 300)) * [[1.0], [0.1], [0.1]],
        r.uniform(-0.1, 0.1, (3, 50)) + [[4.0], [2.0], [0.0]],
    )
    right = exact(crowd, rod, np.ones(300), 0.01, np.arange(50))
    whole = errors(tree.sum_by_tree(crowd, rod, np.ones(300), 0.01, 0.5, 3, "f64"), right)[0]
    walk = tree.walk_kernel(False, 3, "f64")

    def without_quadrupoles(*arguments):
        arguments[10][:, MOMENTS + 4 :] = 0  # of the sources
        walk(*arguments)

    monkeypatch.setattr(tree, "walk_kernel", lambda *of: without_quadrupoles)
    assert errors(tree.sum_by_tree(crowd, rod, np.ones(300), 0.01, 0.5, 3, "f64"), right)[0] > 5 * whole  # the mutant


def test_what_one_cell_does_to_another_comes_back_even_between_cells_of_one_size():
    """On a lattice many cells have the same radius, and either could be opened first."""
    x = np.stack(np.meshgrid(*[np.arange(24.0)] * 3)).reshape(3, -1)
    charges = np.random.default_rng(1).choice([-1.0, 1.0], 24**3)
    force = charges * tree.sum_by_tree(x, None, charges, 0.1, 0.8, 4, "f64")
    assert np.abs(force.sum(1)).max() <= 24**3 * np.finfo(float).eps * np.abs(force).sum()


def test_short_lists_are_made_longer(monkeypatch):
    x, m = plummer(3000), np.full(3000, 1 / 3000)
    right = tree.sum_by_tree(x, None, m, 0.01, 0.3, 4, "f64")
    launches, walk = [], tree.walk_kernel

    def counted(*of):
        return lambda *arguments: (launches.append(1), walk(*of)(*arguments))

    monkeypatch.setattr(tree, "walk_kernel", counted)
    monkeypatch.setattr(tree, "_SHORT", 40)
    assert np.array_equal(tree.sum_by_tree(x, None, m, 0.01, 0.3, 4, "f64"), right)
    assert len(launches) > 1


def test_the_gradient_is_that_of_the_value():
    x, m = plummer(2000), np.full(2000, 1 / 2000)
    probe, h = plummer(50, 9), 1e-5
    found = tree.sum_by_tree(probe, x, m, 0.3, 0.3, 3, "f64")
    for axis in range(3):
        step = np.zeros((3, 1))
        step[axis] = h
        up, down = (tree.sum_by_tree(probe + s * step, x, m, 0.3, 0.3, 3, "f64", valued=True) for s in (1, -1))
        assert np.abs((up - down) / (2 * h) - found[axis]).max() <= 1e-2 * np.abs(found).max()


def test_a_shifted_expansion_is_the_same_polynomial():
    doubles, terms = ti.types.ndarray(ti.f64, 1), expansion(4)
    everything = list(range(terms.coefficients))

    @ti.kernel
    def shift(C: doubles, way: doubles, out: doubles):
        for _ in range(1):
            old = [C[k] for k in ti.static(everything)]
            new = [ti.f64(0.0) for _ in ti.static(everything)]
            whole = [ti.cast(k, ti.f64) for k in ti.static(range(terms.whole))]
            terms.add_shifted(new, old, [way[k] for k in ti.static(range(3))], whole, everything)
            for k in ti.static(everything):
                out[k] = new[k]

    r = np.random.default_rng(8)
    old, shifted, there, both = r.normal(size=terms.coefficients), *np.zeros((3, terms.coefficients))
    way, further = r.normal(size=(2, 3))
    kernel = runtime.kernel(shift, "f64")
    kernel(old, way, shifted)
    kernel(shifted, further, there)
    kernel(old, way + further, both)
    assert np.abs(there - both).max() <= 1e-13 * np.abs(both).max()


@pytest.mark.parametrize("law,k", [("self_gravity", 1.0), ("coulomb", 1.0)])
def test_the_interactions_use_it_and_know_its_energy(law, k):
    r = np.random.default_rng(2)
    n, h = 3000, 1e-3
    x, m, q = r.normal(size=(n, 3)), r.uniform(0.5, 1.5, n), r.choice([-1.0, 1.0], n)

    def sim(method):
        one = I.SelfGravity(G=k, softening=0.02, method=method) if law == "self_gravity" else I.Coulomb(k, 0.02, method)
        system = ga.ParticleSystem(position=x, mass=m, charge=q, interactions=[one], integrator="semi_implicit_euler")
        return ga.Simulation({"s": system}, dt=h, precision="f64")

    a, b = sim("direct"), sim("tree")
    assert b.diagnostics().potential_energy == pytest.approx(a.diagnostics().potential_energy, rel=2e-3)
    a.step(1)
    b.step(1)
    v, w = a["s"].velocity, b["s"].velocity
    assert np.sqrt(((v - w) ** 2).sum() / (v**2).sum()) <= 3e-3
    assert np.abs((m[:, None] * w).sum(0)).max() <= 1e-6 * np.abs(m[:, None] * w).sum()


def test_a_field_of_others_and_of_massless_targets():
    r = np.random.default_rng(3)
    x, y, m = r.normal(size=(3, 2000)) * 2, r.normal(size=(3, 1500)), r.uniform(0.5, 1.5, 1500)
    found = tree.sum_by_tree(x, y, m, 0.05, 0.6, 5, "f64")
    rms, worst = errors(found, exact(x, y, m, 0.05, np.arange(2000)))
    assert rms <= 3e-3 and worst <= 1.5e-2


def test_another_system_attracts_by_the_tree_as_by_all_pairs():
    """Numbers that are no multiples of a vector: the positions are then parts of longer rows."""
    r = np.random.default_rng(10)
    x, y = r.normal(size=(1003, 3)), r.normal(size=(1501, 3)) + 3

    def velocity(method):
        attraction = I.SelfGravity(G=1.0, softening=0.1, method=method, sources="far")
        near = ga.ParticleSystem(position=x, mass=1.0, interactions=[attraction])
        sim = ga.Simulation({"near": near, "far": ga.ParticleSystem(position=y, mass=2.0)}, dt=1e-3, precision="f64")
        sim.step(1)
        return sim["near"].velocity

    direct, tree = velocity("direct"), velocity("tree")
    assert np.sqrt(((direct - tree) ** 2).sum() / (direct**2).sum()) <= 3e-3


def test_energy_of_a_steady_sphere():
    n = 4000
    x = plummer(n, 5).T
    r = np.random.default_rng(6)
    speed = np.sqrt(2.0) * (1 + (x**2).sum(1)) ** -0.25
    q = r.uniform(
        size=(40, n)
    )  # velocities of Plummer's distribution function, by rejection (Aarseth, Henon & Wielen 1974)
    height = r.uniform(0, 0.1, (40, n))
    ok = height < q**2 * (1 - q**2) ** 3.5
    share = q[ok.argmax(0), np.arange(n)]
    way = r.normal(size=(n, 3))
    v = way / np.linalg.norm(way, axis=1)[:, None] * (share * speed)[:, None]
    stars = ga.ParticleSystem(
        position=x, velocity=v, mass=1 / n, interactions=[I.SelfGravity(G=1.0, softening=0.05, method="tree")]
    )
    sim = ga.Simulation({"s": stars}, dt=0.02, precision="f32")
    start = sim.diagnostics()
    sim.step(50)
    end = sim.diagnostics()
    assert abs(end.energy / start.energy - 1) < 1e-3
    assert np.abs(end.momentum - start.momentum).max() < 1e-6


def test_every_particle_has_one_leaf_even_where_many_share_a_place():
    r = np.random.default_rng(7)
    x = np.concatenate([r.normal(size=(3, 500)), np.zeros((3, 200)), np.full((3, 3), 1e6)], axis=1)
    made = build_octree(x)
    leaves = np.flatnonzero(made.links[:, 1] == 0)
    covered = np.sort(np.concatenate([np.arange(made.begin[c], made.end[c]) for c in leaves]))
    assert np.array_equal(covered, np.arange(703)) and np.array_equal(np.sort(made.order), np.arange(703))
    found = tree.sum_by_tree(x, None, np.ones(703), 0.1, 0.6, 5, "f64")
    rms, _ = errors(found[:, :700], exact(x, x, np.ones(703), 0.1, np.arange(700)))
    assert np.isfinite(found).all() and rms < 3e-3


SCRIPT = """
import sys
import numpy as np
import gen_art as ga
r = np.random.default_rng(0)
s = ga.ParticleSystem(position=r.normal(size=(3000, 3)), mass=1.0, interactions=[ga.interactions.SelfGravity(G=1e-4, softening=0.1, method="tree")])
sim = ga.Simulation({"s": s}, dt=0.01, threads=int(sys.argv[1]))
sim.step(3)
print(sim.digest())
"""


def test_thread_counts_give_the_same_bits():
    runs = digests(SCRIPT)
    assert runs[0] and len(set(runs)) == 1


def test_what_it_cannot_do_is_a_sentence():
    for make, words in (
        (lambda: I.SelfGravity(theta=2.0), "theta must be from 0.05 to 1"),
        (lambda: I.SelfGravity(order=7), "order must be from 2 to 6"),
        (lambda: I.Coulomb(method="trees"), "auto, direct, tree"),
    ):
        with pytest.raises(ga.UsageError, match=words):
            make()
