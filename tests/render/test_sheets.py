"""Cloth in the picture: its light on both sides against closed formulas, its shadow, and what lies between its triangles."""

import math

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.interactions.sheets import whole_faces
from gen_art.output.job import still
from gen_art.renderer.painter import Painter
from gen_art.renderer.surfaces.scene import Scene

DARK = {"ambient_intensity": 0.0}
EVEN = {"intensity": 0, "ambient_intensity": 1.0}
SIZE = (64, 48)
ABOVE = {"position": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 20}


def cloth(corner=(-2, 0, -2), across=(4, 0, 0), down=(0, 0, 4), columns=9, rows=7, pinned="none", **look):
    """A system of one level sheet whose front is up."""
    sheet = {"corner": list(corner), "across": list(across), "down": list(down), "columns": columns, "rows": rows}
    return {
        "flag": {
            "particle": {"mass": 0.01}, "interactions": {"springs": {"stiffness": 1.0}},
            "emitters": {"sheet": {"cloth": {**sheet, "pinned": pinned}}},
            "look": {"draw": "cloth", "albedo": "white", "finish": {"ior": 1}, **look},
        }
    }  # fmt: skip


def preset(**more):
    return ga.load_preset(
        {
            "version": 1,
            "clock": {"duration": 1, "fps": 30, "step": "1/120"},
            "systems": cloth(),
            "camera": ABOVE,
            **more,
        }
    )


def picture(size=SIZE, **more):
    return ga.render_frame(ga.Simulation(preset(**more)), size)


def bent(height, columns=17, rows=17, side=4.0, **look):
    """A simulation of a sheet over a square, at y = height(x, z)."""
    net = ga.cloth((-side / 2, 0, -side / 2), (side, 0, 0), (0, 0, side), columns, rows)
    place = net.position.copy()
    place[:, 1] = height(place[:, 0], place[:, 2])
    keys = {"draw": "cloth", "albedo": "white", "finish": {"ior": 1}, **look}
    given = preset(systems={"flag": {**cloth()["flag"], "look": keys}}).systems["flag"].look
    system = ga.ParticleSystem(place, mass=0.01, interactions=[net.springs(1.0)], look=given)
    return ga.Simulation({"flag": system}, dt=0.01)


@pytest.mark.parametrize("angle", [0, 30, 70])
@pytest.mark.parametrize("side", [1, -1])
def test_a_flat_sheet_has_the_radiance_of_lambert_on_both_sides(angle, side):
    """albedo E cos / pi, E = 4 pi I. Fails if the normal is not turned to the viewer, or if the sheet shadows itself."""
    down = math.radians(angle)
    light = {"direction": [math.sin(down), -side * math.cos(down), 0], "intensity": 0.7, **DARK}
    camera = {**ABOVE, "position": [0, 5 * side, 0]}
    got = picture(systems=cloth(albedo=[0.5, 0.25, 1.0]), light=light, camera=camera)
    albedo = np.array([((c + 0.055) / 1.055) ** 2.4 for c in (0.5, 0.25, 1.0)])
    want = np.broadcast_to(albedo * 4 * 0.7 * math.cos(down), (*SIZE[::-1], 3))
    assert got[..., :3] == pytest.approx(want, rel=0.01) and (got[..., 3] == 1.0).all()


@pytest.mark.parametrize("back", [None, [0.5, 1.0, 1.0]])
def test_what_comes_through_and_what_is_scattered_are_the_albedo_s_part(back):
    """Lit side (1 - T) A, other side T A, together A of the light that arrives; with two colours the lesser comes through.

    Fails for light that comes through beside what is scattered, and for T of the other side's colour.
    """
    light = {"direction": [0.5, -1, 0], "intensity": 0.3, **DARK}
    arriving = 4 * 0.3 / math.sqrt(1.25)
    look = {"albedo": [1.0, 0.5, 0.25], "translucency": 0.35, **({} if back is None else {"back": back})}
    front, rear = (
        np.array([((c + 0.055) / 1.055) ** 2.4 for c in srgb]) for srgb in (look["albedo"], back or look["albedo"])
    )
    lit, other = (
        picture(systems=cloth(**look), light=light, camera={**ABOVE, "position": [0, y, 0]})[24, 32, :3]
        for y in (5, -5)
    )
    assert lit == pytest.approx(0.65 * front * arriving, rel=0.01)
    assert other == pytest.approx(0.35 * np.minimum(front, rear) * arriving, rel=0.01)
    under = {**light, "direction": [0.5, 1, 0]}
    if back is not None:
        lit_back = picture(systems=cloth(**look), light=under, camera={**ABOVE, "position": [0, -5, 0]})[24, 32, :3]
        assert lit_back == pytest.approx(0.65 * rear * arriving, rel=0.01)


@pytest.mark.parametrize("finish", [{"ior": 1}, {"roughness": 0.3}, {"metal": 1, "roughness": 0.3}])
@pytest.mark.parametrize("translucency", [0.0, 0.4])
def test_white_furnace(finish, translucency):
    """In an even light that it does not shadow, a white sheet has the light of its surroundings, at every angle of its waves."""
    sim = bent(lambda x, z: 0.3 * np.sin(2 * x) * np.cos(z), finish=finish, translucency=translucency)
    camera = ga.Camera(position=(0, 5, 3), target=(0, 0, 0), fov=30)
    scene = Scene(preset(light=EVEN).light, shadows=False)
    got = Painter(SIZE, camera, {"flag": sim.members["flag"].look}, scene=scene).paint(sim, 0.0)
    inside = got[got[..., 3] == 1.0][:, :3]
    assert len(inside) > 1500 and np.abs(inside - 1).max() < 0.02


def half_disc(x):
    """The share of a disc of radius 1 on one side of a line at the signed distance x from its middle."""
    x = np.clip(x, -1, 1)
    return (np.arccos(x) - x * np.sqrt(1 - x * x)) / np.pi


@pytest.mark.parametrize("columns", [3, 61])
def test_the_shadow_of_an_edge_and_its_half_shadow(columns):
    """A level sheet that ends at x = 0, y = 1: its shadow ends where the lamp's middle is hidden, to a pixel, and fades as the disc
    is covered, however small the triangles are. Fails for a half-shadow that is followed over a few triangles only.
    """
    size_of_lamp, tilt = 6.0, math.radians(30)
    light = {"direction": [math.sin(tilt), -math.cos(tilt), 0], "intensity": 0.25, "size": size_of_lamp, **DARK}
    sheet = cloth((-3, 1, -4), (3, 0, 0), (0, 0, 8), columns, columns)
    camera = {"position": [0.7, 8, 0], "target": [0.7, 0, 0], "up": [0, 0, -1], "height": 0.02}
    ground = {"albedo": "white", "ior": 1}
    got = picture(systems=sheet, ground=ground, light=light, camera=camera, size=(640, 8))[4, :, 0]
    row, pixel = got / (4 * 0.25 * math.cos(tilt)), 0.02 / 8
    x = 0.7 + (np.arange(640) + 0.5 - 320) * pixel
    seen = x > 0.02
    expected = half_disc(-np.tan(np.arctan(x) - tilt) / math.tan(math.radians(size_of_lamp / 2)))
    edge = np.interp(0.5, row[seen], x[seen])
    assert abs(edge - math.tan(tilt)) < pixel
    assert np.abs(row - expected)[seen].max() < 0.05


def test_a_sheet_looks_like_a_thin_block_there():
    """The same light on it, the same shadow of it, and of a sphere on it. The block's pixels at its rim may differ."""
    light = {"direction": [0.4, -1, -0.3], "intensity": 0.25, "size": 3, **DARK}
    camera = {"position": [2, 2.5, 3], "target": [0, 0.4, 0], "fov": 32}
    matte = {"albedo": "white", "ior": 1}
    sphere = {"sphere": {"center": [0.1, 0.8, 0.1], "radius": 0.12, "look": matte}}
    block = {"block": {"min": [-0.6, 0.4999, -0.4], "max": [0.6, 0.5001, 0.4], "look": matte}}
    common = {"ground": {"albedo": "#808080", "ior": 1}, "light": light, "camera": camera, "size": (160, 120)}
    one = picture(systems=cloth((-0.6, 0.5, -0.4), (1.2, 0, 0), (0, 0, 0.8), 13, 9), colliders=sphere, **common)
    nothing = cloth((0, -99, 0), (0.1, 0, 0), (0, 0, 0.1), 2, 2)
    two = picture(systems=nothing, colliders={**sphere, **block}, **common)
    assert np.mean(np.abs(one - two) > 6 / 64) < 4e-3
    assert np.abs(one.mean(axis=(0, 1)) / two.mean(axis=(0, 1)) - 1).max() < 2e-3


@pytest.mark.parametrize("parallel", [False, True])
def test_no_ray_passes_between_triangles(parallel):
    """A crumpled bright sheet over the whole picture, at places where rays pass exactly through corners and edges too.

    Fails where a ray on an edge belongs to neither triangle (> in place of >=), and for edges that are found from their own
    triangle's first corner.
    """
    rough = np.random.default_rng(5).uniform(-0.05, 0.05, 10_000)
    for k, side in enumerate((4.0, 4.7, 5.3)):
        sim = bent(lambda x, z, k=k: rough[: len(x)] * (k > 0), columns=65, rows=65, side=side)
        # a picture of 2 x 2 m with 64 x 64 pixels: columns of the flat sheet stand on the sides of pixels, two pixels apart
        shift = 1 / 32 * np.array([0.125, 0.375]) if k == 0 else np.array([0.01, 0.013])
        view = {"height": 2.0} if parallel else {"fov": 2 * math.degrees(math.atan(0.25))}
        camera = ga.Camera(position=(shift[0], 4, shift[1]), target=(shift[0], 0, shift[1]), up=(0, 0, -1), **view)
        got = ga.render_frame(sim, (64, 64), camera, light={"direction": [0, -1, 0]})
        assert (got[..., 3] == 1.0).all() and got[..., 0].min() > 0.1


def test_no_light_passes_between_triangles():
    """The ground in the shadow of a crumpled sheet gets nothing of the lamp."""
    rough = np.random.default_rng(6).uniform(-0.05, 0.05, 10_000)
    sim = bent(lambda x, z: 1.0 + rough[: len(x)], columns=65, rows=65)
    camera = ga.Camera(position=(0, 0.8, 0), target=(0, 0, 0), up=(0, 0, -1), fov=60)
    light = {"direction": [0.1, -1, 0.05], "intensity": 1.0, "size": 1.0, **DARK}
    got = ga.render_frame(sim, (96, 72), camera, light=light, ground={"albedo": "white", "ior": 1})
    assert not got[..., :3].any() and got[..., 3].all()


@pytest.mark.parametrize("tilt,target,height", [(50, 0.0, 1.0), (62, 0.87, 0.2)])
def test_a_bent_sheet_is_smooth_and_does_not_shadow_itself_where_it_faces_the_lamp(tilt, target, height):
    """A quarter of a cylinder, in facets of 11.25 degrees, has the light of its round surface.

    Fails for the triangles' own normals, whose light is off by sin(5.6 degrees) = 10% of the lamp's. In the second case, a facet
    faces away from the lamp where a part of the round surface does not: fails for shadow rays that start from the flat triangles.
    """
    radius, half, facet = 2.0, math.radians(45), math.radians(11.25)
    net = ga.cloth((0, 0, 0), (1, 0, 0), (0, 0, 4), 9, 5)
    angle = (net.position[:, 0] - 0.5) * 2 * half
    place = np.stack([radius * np.sin(angle), radius * np.cos(angle), net.position[:, 2] - 2], axis=1)
    look = bent(lambda x, z: 0 * x).members["flag"].look
    sim = ga.Simulation(
        {"flag": ga.ParticleSystem(place, mass=0.01, interactions=[net.springs(1.0)], look=look)}, dt=0.01
    )
    camera = ga.Camera(position=(target, 9, 0), target=(target, 0, 0), up=(0, 0, -1), height=height)
    down = math.radians(tilt)
    light = {"direction": [math.sin(down), -math.cos(down), 0], "intensity": 0.25, "size": 0.1, **DARK}
    got = ga.render_frame(sim, (480, 200), camera, light=light)[100, :, 0]
    x = target + (np.arange(480) + 0.5 - 240) * (height / 200)
    turned = np.arcsin(np.clip(x / radius, -1, 1)) + down
    want = np.maximum(np.cos(turned), 0.0)
    # the rim's own normals are half a facet off; normals between corners are off by less than facet^2 / 8
    inside = np.abs(x) < radius * math.sin(half - facet)
    assert np.abs(got - want)[inside].max() < 2 * facet**2 / 8
    assert inside.sum() > 300 and np.ptp(want[inside]) > 0.1


def test_a_triangle_at_a_broken_spring_is_a_hole():
    net = ga.cloth((-1, 0, -1), (2, 0, 0), (0, 0, 2), 3, 3)
    ids = np.arange(9) + 100
    assert len(whole_faces(net.faces + 100, ids, np.zeros((0, 2), int))) == 8
    # between the middle and the point to its right lie two triangles; each end of the list of two is one
    assert len(whole_faces(net.faces + 100, ids, np.array([[105, 104]]))) == 6
    gone = np.delete(ids, 4)  # all eight triangles meet in the middle, or six, as the diagonals lie
    left = whole_faces(net.faces + 100, gone, np.zeros((0, 2), int))
    assert len(left) == 8 - (net.faces == 4).any(axis=1).sum() and not (gone[left] == 104).any()
    assert len(whole_faces(net.faces, np.zeros(0, int), np.zeros((0, 2), int))) == 0


def test_a_torn_cloth_shows_what_is_behind_it():
    sheet = cloth(columns=9, rows=9)
    sheet["flag"] |= {"interactions": {"springs": {"stiffness": 5.0, "tear": 0.5}}, "forces": {"point": None}}
    net = ga.cloth((-1, 0, -1), (2, 0, 0), (0, 0, 2), 9, 9)
    place, look = net.position.copy(), preset(systems=cloth()).systems["flag"].look
    velocity = np.zeros_like(place)
    velocity[place[:, 0] > 0.1, 0] = 20.0
    system = ga.ParticleSystem(place, velocity=velocity, mass=1.0, interactions=[net.springs(1.0, tear=0.2)], look=look)
    sim = ga.Simulation({"flag": system}, dt=0.002)
    before = len(sim.members["flag"].interactions[0].sheet(sim.members["flag"].state))
    sim.step(20)
    after = len(sim.members["flag"].interactions[0].sheet(sim.members["flag"].state))
    assert before == 128 and after == 128 - 2 * 8
    got = ga.render_frame(sim, SIZE, ga.Camera(position=(0, 5, 0), target=(0, 0, 0), up=(0, 0, -1)), light={})
    assert got[24, 33, 3] == 0.0 and got[24, 28, 3] == 1.0


def dot(y):
    return {
        "dot": {
            "emitters": {"one": {"count": 1, "shape": {"point": [0, y, 0]}}}, "particle": {"radius": 0.2},
            "look": {"draw": "disc", "emission": {"intensity": 5}},
        }
    }  # fmt: skip


def test_it_hides_sprites_and_mirrors_show_it():
    dark = {"intensity": 0, **DARK}
    shown, hidden = (picture(systems=cloth() | dot(y), light=dark)[..., :3].sum() for y in (1.0, -1.0))
    assert shown > 1 and hidden == 0.0
    glowing = cloth((-0.5, 0.8, -0.1), (1, 0, 0), (0, -0.6, 0), emission="white", albedo="black")
    below = cloth((-0.5, -0.8, -0.1), (1, 0, 0), (0, 0.6, 0), emission="white", albedo="black")
    mirror = {"albedo": "white", "metal": 1, "roughness": 0, "mirror": True}
    common = {"light": dark, "camera": {"position": [0, 1.2, 4], "target": [0, 0.2, 0], "fov": 40}, "size": (320, 240)}
    got = picture(systems=glowing, ground=mirror, **common)[..., 0]
    image, real = (picture(systems=systems, **common)[..., 0] for systems in (below, glowing))
    assert np.abs(got - (image + real)).max() <= 0.5 and np.mean(np.abs(got - (image + real)) > 0.02) < 2e-3
    assert image.sum() > 500


def test_a_cloth_through_the_mirror_keeps_its_colour_below_and_above():
    """Its corners below the mirror's plane are not drawn there, but they colour the triangles that reach above it."""
    through = cloth((-0.5, 0.3, -0.1), (1, 0, 0), (0, -0.6, 0), 2, 2, emission="#808080", albedo="black")
    mirror = {"albedo": "white", "metal": 1, "roughness": 0, "mirror": True}
    camera = {"position": [0, 1.2, 4], "target": [0, 0.0, 0], "fov": 20}
    got = picture(systems=through, ground=mirror, light={"intensity": 0, **DARK}, camera=camera, size=(160, 120))[
        ..., 0
    ]
    bright = got[got > 0.01]
    assert len(bright) > 400 and np.median(bright) == pytest.approx(((0.50196 + 0.055) / 1.055) ** 2.4, rel=0.02)
    assert bright.max() <= 0.25


@pytest.mark.parametrize("size", [(1, 1), (7, 5)])
@pytest.mark.parametrize(
    "camera",
    [
        {"position": [0, 0.0, 0.3], "target": [0, 0, -1], "fov": 120},  # in the sheet's plane, which reaches behind it
        {"position": [0, 0.2, 0], "target": [0, 0.2, -1], "fov": 160},
        {"position": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "height": 2},
        {
            "position": [0, -5, 0],
            "target": [0, -9, 0],
            "up": [0, 0, -1],
            "height": 2,
        },  # behind a camera of parallel rays
        {"position": [0, 5, 0], "target": [0, 9, 0], "up": [0, 0, -1]},  # behind a camera
    ],
)
def test_tiny_pictures_and_odd_cameras(size, camera):
    got = picture(size=size, light={}, camera=camera)
    assert np.isfinite(got).all() and got.min() >= 0.0
    if camera["position"][1] == 5 and "height" not in camera:
        assert not got.any()
    if "height" in camera:
        assert got[..., 3].min() == 1.0


def test_a_wide_camera_sees_a_sheet_that_reaches_behind_it():
    camera = {"position": [0, 0.2, 0], "target": [0, 0.2, -1], "fov": 120}
    got = picture(systems=cloth(columns=2, rows=2), light=EVEN | {"intensity": 0.0}, camera=camera)
    lower = got[30:, :, 3]
    assert lower.min() == 1.0 and not got[:24, :, 3].any()


def test_near_far_and_fog():
    camera = {**ABOVE, "far": 4.0}
    assert not picture(light=EVEN, camera=camera).any()
    assert not picture(light=EVEN, camera={**ABOVE, "near": 6.0}).any()
    fog = {**ABOVE, "fog": {"distance": 5.0, "color": "black"}}
    clear, dim = picture(light=EVEN, camera=ABOVE, shadows=False), picture(light=EVEN, camera=fog, shadows=False)
    assert dim[24, 32, 0] / clear[24, 32, 0] == pytest.approx(math.exp(-1), rel=0.01)


def test_colours_go_from_corner_to_corner():
    """`by: x` on a sheet of one cell is linear between its corners."""
    look = {"albedo": {"by": "x", "range": "-2..2", "gradient": ["black", "white"]}}
    light = {"direction": [0, -1, 0], "intensity": 0.25, **DARK}
    camera = {**ABOVE, "height": 2.0}
    got = picture(systems=cloth(columns=2, rows=2, **look), light=light, camera=camera)[..., 0]
    step = (
        1 / 96
    )  # of the light from pixel to pixel; where two triangles share a pixel, its light is that of a place in it
    assert np.abs(got - (0.5 + (np.arange(64) + 0.5 - 32) * step)).max() <= 0.5 * step


def test_film_and_still_show_the_same_cloth(tmp_path):
    given = {"ground": {"height": -1}, "light": {}, "forces": {"gravity": [0, -9.81, 0]}}
    film = ga.render(preset(**given), tmp_path / "f_####.png", size=SIZE, frames=range(3))
    again = still(preset(**given), tmp_path / "s.png", 2 / 30, size=SIZE)
    assert film[2].read_bytes() == again[0].read_bytes()


def test_a_cloth_that_moves_shadows_smoke():
    puff = {
        "smoke": {
            "emitters": {
                "dark": {"count": 1, "shape": {"point": [0, -1, 0]}}, "lit": {"count": 1, "shape": {"point": [4, -1, 0]}},
            },
            "particle": {"radius": 0.1}, "look": {"draw": "disc", "blend": "alpha", "opacity": 0.01},
        }
    }  # fmt: skip
    light = {"direction": [0, -1, 0], "intensity": 1.0, "scatter": 0, **DARK}
    camera = {"position": [2, -1, 8], "target": [2, -1, 0], "fov": 40}
    got = picture(systems=cloth((-1, 0, -1), (2, 0, 0), (0, 0, 2)) | puff, light=light, camera=camera)
    left, right = got[22:27, :32, 0].sum(), got[22:27, 32:, 0].sum()
    assert right > 0 and left < 1e-6 * right


@pytest.mark.parametrize(
    "keys,words",
    [
        ({"radius": 0.1}, "leave out `radius`"),
        ({"blend": "alpha"}, "leave out `blend`"),
        ({"translucency": 2}, "from 0 to 1"),
        ({"draw": "point", "back": "red"}, "`back` needs draw: cloth"),
        ({"draw": "disc", "translucency": 0.5}, "`translucency` needs draw: cloth"),
    ],
)
def test_wrong_keys_are_sentences(keys, words):
    with pytest.raises(PresetError, match=words):
        preset(systems=cloth(**keys))


def test_what_is_no_cloth_is_a_sentence():
    rope = {"rope": {**cloth()["flag"], "emitters": {"one": {"chain": {"count": 3}}}}}
    with pytest.raises(ga.UsageError, match="draw: cloth shows the `cloth:`"):
        picture(systems=rope, light={})
    for faces, words in (
        ([[0, 1]], "shape"),
        ([[0, 1, 9]], "no spring holds particle 9"),
        ([[0, 1, 2], [0]], "no triangle"),
    ):
        with pytest.raises(ga.UsageError, match=words):
            ga.interactions.Springs([[0, 1], [1, 2]], 1.0, faces=faces)
    with pytest.raises(ga.UsageError, match="faces go with pairs"):
        ga.interactions.Springs(faces=[[0, 1, 2]])
