"""What is found once for a tile of the picture is what its pixels would have found each by itself."""

import numpy as np
import pytest

import gen_art as ga
from gen_art.backend.runtime import kernel, ti
from gen_art.renderer.painter import Painter
from gen_art.renderer.surfaces import draw_surfaces, even_tiles, tile_lists
from gen_art.renderer.surfaces.lamp_shadows import LAMP_POINTS, lamp_disc, solid_shadow
from gen_art.renderer.surfaces.scene import Scene
from gen_art.renderer.surfaces.solids import AXES, BOUND, HALF, RADIUS, SOLID_FLOATS
from tests.render.test_surfaces import preset

F2, L1 = ti.types.ndarray(ti.f32, 2), ti.types.ndarray(ti.i64, 1)
SIZE = (192, 128)
PLACE = {"position": [0.6, 1.1, 3], "target": [0, 0.4, 0]}
CAMERA = PLACE | {"fov": 40}


def painter(given, size=SIZE):
    looks = {name: system.look for name, system in given.systems.items()}
    return Painter(size, ga.Camera.from_spec(given.camera), looks, scene=Scene(given.light, given.ground))


def bodies(count, **look):
    """Boxes on a ground."""
    each = {
        "shape": {"box": [0.3, 0.2, 0.12]},
        "grid": [count, 1, count],
        "pitch": [0.31, 0.1, 0.3],
        "turn": [10, 25, 5],
    }
    each |= {"position": [-0.15 * count, 0.3, -0.15 * count], "static": True}
    system = {"interactions": {"rigid": {}}, "integrator": "leapfrog", "emitters": {"boxes": {"body": each}}}
    return {"boxes": system | {"look": {"draw": "body", "albedo": "white", **look}}}


def pictures_of(keys, size=SIZE):
    return ga.render_frame(ga.Simulation(preset(**keys)), size)


def test_even_light_differs_from_that_of_each_pixel_by_less_than_its_bound(monkeypatch):
    """Between two nodes that lie on a straight line but for d, a curve of one sign is off by d / 4 along a row, and as much along
    a column. Mutants: weights of the other half of the tile; a bound of 0.08."""
    keys = {"ground": {"albedo": "#b08060", "roughness": 0.35}, "sky": {"sun": 40}, "camera": CAMERA}
    even = pictures_of(keys)
    monkeypatch.setattr(even_tiles, "_EVEN", -1.0)
    draw_surfaces.draw_kernel.cache_clear()
    each = pictures_of(keys)
    draw_surfaces.draw_kernel.cache_clear()
    ground = each[72:, :, :3]
    off = np.abs(even[72:, :, :3] - ground)
    assert (off > 0).mean() > 0.3  # some tiles are even
    assert (off <= 0.5 * 0.008 * ground.max(axis=2, keepdims=True) * 1.1).all()


@pytest.mark.parametrize("height", [None, 4.0])
@pytest.mark.parametrize("covering", ["plane", "body"])
def test_the_depths_of_a_face_that_covers_tiles(covering, height):
    """Depth (n.(a - c)) / (n.d) d.forward along the ray of each pixel. Mutant: depth that is linear in the picture."""
    camera = CAMERA | {"target": [0, 0, 0]} | ({} if height is None else {"height": height})
    keys = {"camera": camera, "light": {"direction": [0, -1, 0]}}
    if covering == "plane":
        keys["ground"] = {"roughness": 0.9}
    else:
        wide = {"shape": {"box": [60, 2, 60]}, "position": [0, -1, 0], "static": True}
        keys["systems"] = {
            "floor": {
                "interactions": {"rigid": {}}, "integrator": "leapfrog", "emitters": {"floor": {"body": wide}},
                "look": {"draw": "body", "finish": {"roughness": 0.9}},
            }
        }  # fmt: skip
    scene = preset(**keys)
    sim = ga.Simulation(scene)
    drawn = painter(scene)
    drawn.paint(sim, 0.0)
    view, scale = drawn.view(sim, 0.0), drawn.view(sim, 0.0).scale(SIZE[1])
    x, y = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    offset = ((x - SIZE[0] / 2) / scale)[..., None] * view.axes[0] - ((y - SIZE[1] / 2) / scale)[..., None] * view.axes[
        1
    ]
    if height is None:
        depth = -view.position[1] / (view.axes[2] + offset)[..., 1]
    else:
        depth = -(view.position + offset)[..., 1] / view.axes[2][1]
    inside = (depth > 0) & (depth < 20)
    assert inside.mean() > 0.5
    # a hit is exact to 1/250 of a pixel along the ray's normal, which its slope towards the plane stretches along the ray
    rays = view.axes[2] + offset if height is None else np.broadcast_to(view.axes[2], offset.shape)
    slope = -rays[..., 1] / np.linalg.norm(rays, axis=2)
    bound = 0.004 / scale * (1.0 if height is None else 1.0 / depth) / slope + 2e-6 / slope
    found = drawn._surfaces.depths[:, :, 0]
    assert (np.abs(found / depth - 1) < bound)[inside].all()


@pytest.mark.parametrize("size", [SIZE, (40, 26)])
def test_a_list_of_a_tile_s_solids_leaves_out_none_that_shadows_it(monkeypatch, size):
    """The same bytes as where every solid of the cell is asked. Mutant: a third of the cone's width."""
    keys = {"ground": {"roughness": 0.9}, "light": {"direction": [0.6, -1, -0.3], "size": 5}, "camera": CAMERA}
    keys["systems"] = bodies(9)
    listed = pictures_of(keys, size)
    assert listed[..., :3].std() > 0.05
    for module in (tile_lists, draw_surfaces):
        monkeypatch.setattr(module, "SOLIDS_OF_TILE", 1)
    draw_surfaces.draw_kernel.cache_clear()
    asked = pictures_of(keys, size)
    draw_surfaces.draw_kernel.cache_clear()
    assert np.array_equal(listed, asked)


@kernel
@ti.kernel
def _shadows(B: F2, D: F2, X: F2, towards: F2, out: L1):
    for i in range(B.shape[0]):
        d = ti.Vector([towards[i, 0], towards[i, 1], towards[i, 2]])
        side = ti.Vector([d[1], -d[0], 0.0]).normalized()
        x = ti.Vector([X[i, 0], X[i, 1], X[i, 2]])
        out[i] = solid_shadow(ti.i64(0), B, i, x, d, side, d.cross(side), 0.08, 0.01, 1e30, D, LAMP_POINTS)


def _meets(p, v, half):
    a, b = (-half - p) / v, (half - p) / v
    low, high = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    return (low <= high) & (high > 0)


def test_the_points_of_the_lamp_that_a_box_hides():
    """Against each ray and the three slabs of the box, in float64. Mutants: a cone as wide as at its start; a depth of half."""
    rng = np.random.default_rng(1)
    n = 4000
    rows = np.zeros((n, SOLID_FLOATS), np.float32)
    rows[:, HALF : HALF + 3] = rng.uniform(0.02, 1.0, (n, 3)) ** 2
    rows[:, BOUND] = np.sqrt((rows[:, HALF : HALF + 3] ** 2).sum(axis=1))
    axes, _ = np.linalg.qr(rng.normal(size=(n, 3, 3)))
    rows[:, AXES : AXES + 9] = axes.reshape(n, 9)
    towards = rng.normal(size=(n, 3)) + [0.0, 0.5, 0.0]
    towards = (towards / np.linalg.norm(towards, axis=1)[:, None]).astype(np.float32)
    places = (-towards * rng.uniform(-0.5, 6.0, (n, 1)) + rng.normal(size=(n, 3)) * 0.6).astype(np.float32)
    disc, out = lamp_disc(), np.zeros(n, np.int64)
    _shadows(rows, disc, places, towards, out)
    assert (rows[:, RADIUS] == 0).all()
    d = towards.astype(np.float64)
    side = np.stack([d[:, 1], -d[:, 0], 0 * d[:, 0]], axis=1)
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(d, side)
    wrong = partly = 0
    for k in range(LAMP_POINTS):
        across = side * disc[k, 0] + up * disc[k, 1]
        p = np.einsum("nij,nj->ni", axes, places + across * 0.01)
        v = np.einsum("nij,nj->ni", axes, d + across * 0.08)
        smaller, larger = (_meets(p, v, rows[:, HALF : HALF + 3] + more) for more in (-1e-5, 1e-5))
        bit = (out >> k) & 1 == 1
        wrong += (bit & ~larger | smaller & ~bit).sum()  # float32 decides in between
        partly += ((out != 0) & (out != -1)).sum()
    assert partly > 1000 and wrong == 0


def test_the_sky_among_solids_follows_them():
    """A film's painter keeps the sky's light while nothing moves. Mutant: it keeps it always."""
    system = {
        "particle": {"radius": 0.2}, "look": {"draw": "sphere", "blend": "opaque", "albedo": "white"},
        "emitters": {"some": {"count": 5, "shape": {"disc": 0.8, "center": [0, 0.3, 0]}, "velocity": {"constant": [1, 0, 0]}}},
    }  # fmt: skip
    scene = preset(ground={}, light={"intensity": 0, "ambient_intensity": 1.0}, camera=CAMERA, systems={"ball": system})
    sim = ga.Simulation(scene)
    kept = painter(scene)
    sim.step(1)
    before = np.array(kept.paint(sim, 0.0))
    sim.step(60)
    after = np.array(kept.paint(sim, 0.0))
    assert not np.array_equal(before, after)
    assert np.array_equal(after, painter(scene).paint(sim, 0.0))
