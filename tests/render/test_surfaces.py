"""Surfaces in the picture: their light against closed formulas, where they are, and what they hide."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import gen_art as ga
from gen_art.errors import PresetError
from gen_art.output.job import still
from gen_art.preset.surface import surface_look
from gen_art.renderer.painter import Painter
from gen_art.renderer.surfaces.collider_rays import ColliderTerms
from gen_art.renderer.surfaces.reflection import fresnel, reflected_share
from gen_art.renderer.surfaces.scene import Scene

DARK = {"ambient_intensity": 0.0}
SIZE = (64, 48)


def preset(**more):
    """A preset of one invisible particle, with these keys."""
    return ga.load_preset(
        {
            "version": 1, "clock": {"duration": 1, "fps": 30, "step": "1/120"},
            "systems": {"dot": {"emitters": {"one": {"count": 1, "shape": {"point": [0, 0, -1e6]}}}, "look": {"draw": "point"}}},
            "camera": {"position": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 20}, **more,
        }
    )  # fmt: skip


def picture(size=SIZE, step=0, **more):
    sim = ga.Simulation(preset(**more))
    if step:
        sim.step(step)
    return ga.render_frame(sim, size)


def matte(colour="white", **more):
    return {"albedo": colour, "ior": 1, **more}


@pytest.mark.parametrize("angle", [0, 30, 60, 80])
def test_a_matte_plane_has_the_radiance_of_lambert(angle):
    down = math.radians(angle)
    light = {"direction": [math.sin(down), -math.cos(down), 0], "intensity": 0.7, **DARK}
    got = picture(ground=matte([0.5, 0.25, 1.0]), light=light)
    irradiance = 4 * math.pi * 0.7 * math.cos(down)
    albedo = [((c + 0.055) / 1.055) ** 2.4 for c in (0.5, 0.25, 1.0)]  # of sRGB
    # float32: the lamp's direction is off by 6e-8, which at 80 degrees is 4e-7 of its cosine
    assert got[24, 32, :3] == pytest.approx(np.array(albedo) * irradiance / math.pi, rel=1e-5)
    assert got[24, 32, 3] == 1.0


@pytest.mark.parametrize("metal", [0.0, 1.0])
@pytest.mark.parametrize("roughness", [0.0, 0.15, 0.4, 1.0])
def test_white_furnace(roughness, metal):
    """In an even light, a surface that absorbs nothing has the light of its surroundings, whatever its finish and its angle."""
    even = {"intensity": 0, "ambient": "white", "ambient_intensity": 0.8}
    ball = {
        "sphere": {
            "center": [0, 0, 0],
            "radius": 0.6,
            "look": {"albedo": "white", "roughness": roughness, "metal": metal},
        }
    }
    got = picture(colliders=ball, light=even, size=(128, 96))
    inside = got[got[..., 3] == 1.0][:, :3]
    assert len(inside) > 1500 and np.abs(inside / 0.8 - 1).max() < 0.02


def test_fresnel_against_the_law_of_refraction():
    """With Snell's angle inside, Rs = sin^2(a - b) / sin^2(a + b) and Rp = tan^2(a - b) / tan^2(a + b)."""
    for ior in (1.33, 1.5, 2.4):
        a = np.radians(np.arange(1, 90))
        b = np.arcsin(np.sin(a) / ior)
        expected = 0.5 * ((np.sin(a - b) / np.sin(a + b)) ** 2 + (np.tan(a - b) / np.tan(a + b)) ** 2)
        assert fresnel(np.cos(a), ior) == pytest.approx(expected, abs=1e-12)
        assert fresnel(1.0, ior) == pytest.approx(((ior - 1) / (ior + 1)) ** 2, abs=1e-12)


@pytest.mark.parametrize("angle", [0, 40, 70, 85])
def test_a_smooth_black_plane_reflects_an_even_sky_as_fresnel_says(angle):
    a = math.radians(angle)
    camera = {"position": [0, 3 * math.cos(a), 3 * math.sin(a)], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 1}
    even = {"intensity": 0, "ambient_intensity": 1.0}
    ground = {"albedo": "black", "roughness": 0, "ior": 1.5}
    got = picture(ground=ground, light=even, camera=camera, size=(33, 33))[16, 16, 0]
    # within a pixel of 5e-4 rad the share changes evenly, but for its curvature of 50 at most: 50 (5e-4)^2 / 24
    assert got == pytest.approx(float(fresnel(math.cos(a), 1.5)), abs=1e-5)


def test_the_reflecting_layer_takes_no_more_than_arrives():
    for roughness in (0.0, 0.1, 0.5, 1.0):
        share = reflected_share(roughness, 1.5)
        assert (share >= 0).all() and (share <= 1).all() and (share[:, 0] + share[:, 1] <= 1.0001).all()
    mirror = reflected_share(0.0, 1.5)
    assert mirror[:, 2] == pytest.approx(fresnel(np.linspace(0, 1, len(mirror)), 1.5), abs=1e-6)


def test_a_checker_is_grey_from_afar_and_exact_near_by():
    light = {"direction": [0, -1, 0], "intensity": 0.25, **DARK}
    ground = matte("white", checker={"size": 0.5, "color": "black"})
    near = picture(
        ground=ground, light=light, camera={"position": [0, 1, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 40}
    )
    assert set(np.unique(np.round(near[::5, 3::5, 0], 4))) <= {0.0, 1.0}
    assert near[20, 28, 0] != pytest.approx(near[20, 36, 0])  # the two sides of x = 0
    far = picture(
        ground=ground, light=light, camera={"position": [0, 800, 1], "target": [0, 0, 0], "up": [0, 0, -1], "fov": 20}
    )
    # the mean over a box w squares wide is off by at most 1 / w along each axis, and their product counts half
    pixel = 2 * 800 * math.tan(math.radians(10)) / SIZE[1]
    assert np.abs(far[..., 0] - 0.5).max() < 0.5 * (0.5 / pixel) ** 2 + 1e-4


def half_disc(x):
    """The share of a disc of radius 1 on one side of a line at the signed distance x from its middle."""
    x = np.clip(x, -1, 1)
    return (np.arccos(x) - x * np.sqrt(1 - x * x)) / np.pi


def test_the_shadow_of_an_edge_and_its_half_shadow():
    """A wall's top edge at height 1: its shadow's edge lies where the lamp's middle is hidden, and fades as the disc is covered."""
    size_of_lamp, tilt = 6.0, math.radians(30)
    light = {"direction": [math.sin(tilt), -math.cos(tilt), 0], "intensity": 0.25, "size": size_of_lamp, **DARK}
    wall = {"block": {"min": [-3, -1, -50], "max": [0, 1, 50], "look": matte()}}
    camera = {"position": [0.5, 8, 0], "target": [0.5, 0, 0], "up": [0, 0, -1], "height": 0.1}
    got = picture(ground=matte(), colliders=wall, light=light, camera=camera, size=(600, 40))
    row = got[20, :, 0] / (4 * 0.25 * math.cos(tilt))
    pixel = 0.1 / 40
    x = 0.5 + (np.arange(600) + 0.5 - 300) * pixel
    # the edge stands at [0, 1]: seen from x, its signed angle from the lamp's middle
    angle = np.arctan(x / 1.0) - tilt
    expected = half_disc(-np.tan(angle) / math.tan(math.radians(size_of_lamp / 2)))
    seen = x > 0.02
    edge = x[seen][np.argmin(np.abs(row[seen] - 0.5))]
    assert abs(edge - math.tan(tilt)) < 1.5 * pixel  # half a pixel to the sample, and the pixel that is asked for
    # n even points on the lamp tell the part on one side of a line to n^(-3/4)
    assert np.abs(row - expected)[seen].max() < 64**-0.75 + 1e-3
    width = np.ptp(x[seen & (row > 0.02) & (row < 0.98)])
    wanted = np.ptp(x[seen & (expected > 0.02) & (expected < 0.98)])
    assert width == pytest.approx(wanted, rel=0.05)


@pytest.mark.parametrize("size_of_lamp", [0.5, 8.0])
def test_a_ball_casts_the_shadow_of_a_sphere(size_of_lamp):
    """A particle that is drawn as a ball, and a collider of the same place and size."""
    light = {"direction": [0.3, -1, 0.2], "intensity": 0.25, "size": size_of_lamp, **DARK}
    camera = {"position": [0, 6, 4], "target": [0, 0.2, 0], "fov": 30}
    ball = {
        "ball": {
            "particle": {"radius": 0.4, "mass": 1}, "emitters": {"one": {"count": 1, "shape": {"point": [0.1, 0.9, 0]}}},
            "look": {"draw": "sphere", "blend": "opaque", "albedo": "white", "finish": {"ior": 1}},
        }
    }  # fmt: skip
    sphere = {"sphere": {"center": [0.1, 0.9, 0], "radius": 0.4, "look": matte()}}
    common = {"ground": matte("#808080"), "light": light, "camera": camera, "size": (160, 120)}
    one, two = picture(systems=ball, **common), picture(colliders=sphere, **common)
    # a ray that grazes may meet one and miss the other, and a lamp's point at the rim counts 1/64
    assert np.abs(one - two).max() <= 0.3 and np.mean(np.abs(one - two) > 4 / 64) < 2e-3
    assert two[..., 0].min() < 0.02  # there is a shadow


def body_system(shape, **body):
    return {
        "bodies": {
            "integrator": "leapfrog", "interactions": {"rigid": {}},
            "emitters": {"one": {"body": {"shape": shape, **body}}},
            "look": {"draw": "body", "albedo": "white", "finish": {"ior": 1}},
        }
    }  # fmt: skip


@pytest.mark.parametrize(
    "shape,collider",
    [
        ({"box": [0.6, 0.4, 0.8]}, {"block": {"min": [-0.3, 0.3, -0.4], "max": [0.3, 0.7, 0.4]}}),
        ({"capsule": [0.8, 0.2]}, {"capsule": {"a": [0, 0.1, 0], "b": [0, 0.9, 0], "radius": 0.2}}),
        ({"sphere": 0.3}, {"sphere": {"center": [0, 0.5, 0], "radius": 0.3}}),
    ],
)
def test_a_body_looks_like_the_collider_of_its_shape(shape, collider):
    light = {"direction": [0.4, -1, -0.3], "intensity": 0.25, "size": 3, **DARK}
    camera = {"position": [2, 2.5, 3], "target": [0, 0.4, 0], "fov": 32}
    ((name, numbers),) = collider.items()
    common = {"ground": matte("#808080"), "light": light, "camera": camera, "size": (160, 120)}
    one = picture(systems=body_system(shape, position=[0, 0.5, 0]), **common)
    two = picture(colliders={name: {**numbers, "look": matte()}}, **common)
    assert np.mean(np.abs(one - two) > 6 / 64) < 4e-3
    assert np.abs(one.mean(axis=(0, 1)) / two.mean(axis=(0, 1)) - 1).max() < 2e-3


@pytest.mark.parametrize("view", [[0, 0, 1], [1, 0, 0], [0.3, 0.6, 0.7]])
def test_a_cylinder_covers_its_outline(view):
    """Across the axis, along it and between: the outline of radius r and length l has the area pi r^2 c + 2 r l s.

    c, s : cosine and sine of the angle between the axis and the view. A pixel at the edge is off by one of 8 rays at most.
    """
    radius, length, rows = 0.4, 1.6, 192
    view = np.array(view) / np.linalg.norm(view)
    cosine = abs(view[0])
    sine = math.sqrt(1 - cosine**2)
    camera = {"position": (5 * view).tolist(), "target": [0, 0, 0], "up": [0, 1, 0], "height": 3}
    drum = {"cylinder": {"a": [-length / 2, 0, 0], "b": [length / 2, 0, 0], "radius": radius, "look": matte()}}
    covered = picture((256, rows), colliders=drum, light=EVEN, camera=camera)[..., 3].sum() * (3 / rows) ** 2
    area = math.pi * radius**2 * cosine + 2 * radius * length * sine
    outline = 2 * math.pi * radius + 2 * length * sine
    off = outline * (3 / rows) / 8
    assert abs(covered - area) < off < 0.02 * area


def test_a_turned_body_is_drawn_turned():
    light = {"direction": [0, -1, 0], "intensity": 0.25, **DARK}
    flat = picture(systems=body_system({"box": [1, 0.2, 0.2]}), light=light, size=(96, 96))
    turned = picture(systems=body_system({"box": [1, 0.2, 0.2], "turn": [0, 90, 0]}), light=light, size=(96, 96))
    assert np.ptp(np.flatnonzero(flat[..., 3].any(axis=0))) > 3 * np.ptp(np.flatnonzero(flat[..., 3].any(axis=1)))
    assert np.abs(turned[..., 3] - np.rot90(flat[..., 3])).mean() < 2e-3


def test_smoke_dims_the_ground_by_the_exponential_of_its_depth():
    """A level slab of smoke of optical depth tau between a lamp overhead and the ground."""
    across, side, tau = 200, 4.0, 0.9  # evenly spaced, so that the column above each place is the same
    n = across * across
    row, column = np.divmod(np.arange(n), across)
    even = ((np.array([column, row]) + 0.5) / across - 0.5) * side
    place = np.column_stack([even[0], 1.0 + 0.4 * ((np.arange(n) * 0.6180339887) % 1.0), even[1]])
    radius, area = 0.06, 0.6277520388  # the kernel's area under a disc of footprint 1
    section = area * (1.5 * radius) ** 2
    opacity = tau * side * side / (n * section)
    smoke = {
        "smoke": {
            "emitters": {"all": {"count": 1}}, "particle": {"radius": radius},
            "look": {"draw": "disc", "blend": "alpha", "opacity": opacity},
        }
    }  # fmt: skip
    light = {"direction": [0, -1, 0], "intensity": 0.25, "resolution": 48, "size": 0.5, **DARK}
    given = preset(
        systems=smoke,
        ground=matte(),
        light=light,
        camera={"position": [0, 0.9, 0], "target": [0, 0, 0], "up": [0, 0, -1]},
    )
    system = ga.ParticleSystem(place, radius=radius, look=given.systems["smoke"].look)
    sim = ga.Simulation({"smoke": system}, dt=0.01)
    scene = Scene(given.light, given.ground)
    painter = Painter(SIZE, ga.Camera.from_spec(given.camera), {"smoke": system.look}, scene=scene)
    got = painter.paint(sim, 0.0)[12:36, 16:48, 0].mean()
    assert got == pytest.approx(math.exp(-tau), rel=0.01)
    bare = Painter(SIZE, ga.Camera.from_spec(given.camera), {"smoke": None}, scene=scene).paint(sim, 0.0)
    assert bare[24, 32, 0] == pytest.approx(1.0, rel=1e-4)


@pytest.mark.parametrize("shadows", [True, False])
def test_solids_and_colliders_shadow_smoke(shadows):
    """A puff in the shadow of a sphere has no lamp's light, and one beside it has all of it."""
    puff = {
        "smoke": {
            "emitters": {
                "dark": {"count": 1, "shape": {"point": [0, 0.5, 0]}}, "lit": {"count": 1, "shape": {"point": [2, 0.5, 0]}},
            },
            "particle": {"radius": 0.1}, "look": {"draw": "disc", "blend": "alpha", "opacity": 0.01},
        }
    }  # fmt: skip
    light = {"direction": [0, -1, 0], "intensity": 1.0, "scatter": 0, **DARK}  # one puff does not light the other
    camera = {"position": [1, 0.5, 5], "target": [1, 0.5, 0], "fov": 40}
    sphere = {"sphere": {"center": [0, 3, 0], "radius": 0.8, "look": matte()}}
    got = picture(systems=puff, colliders=sphere, light=light, camera=camera, shadows=shadows)
    left, right = got[18:30, :32, 0].sum(), got[18:30, 32:, 0].sum()
    assert right > 0 and (left < 1e-6 * right if shadows else left == pytest.approx(right, rel=0.01))


def dot(z, draw="point", **look):
    return {
        "dot": {
            "emitters": {"one": {"count": 1, "shape": {"point": [0, z, 0]}}}, "particle": {"radius": 0.2},
            "look": {"draw": draw, "emission": {"intensity": 5}, **look},
        }
    }  # fmt: skip


@pytest.mark.parametrize("draw", ["point", "disc", "sphere", "streak"])
def test_surfaces_hide_what_is_behind_them(draw):
    more = {"width": 0.1, "length": 0.1} if draw == "streak" else {}
    dark = {"intensity": 0, **DARK}
    shown, hidden = (
        picture(systems=dot(z, draw, **more), ground=matte(), light=dark)[..., :3].sum() for z in (0.5, -0.5)
    )
    assert shown > 0.05 and hidden == 0.0


def test_a_disc_fades_where_it_enters_the_ground():
    """Half of a disc in the ground is hidden: above and below its middle, the shares that are seen add up to 1. Mutant: a cut before
    or behind the middle. A sprite of radius 0.2 at 6 m sees the ground's depth fall off by 0.2 / 6 unevenly, to either side."""
    camera = {"position": [0, 1.5, 6], "target": [0, 0, 0], "fov": 20}
    light = {"intensity": 0, **DARK}
    free = picture(systems=dot(0.0, "disc"), light=light, camera=camera)
    cut = picture(systems=dot(0.0, "disc"), light=light, camera=camera, ground=matte())
    assert cut[..., 0].sum() / free[..., 0].sum() == pytest.approx(0.5, abs=0.2 / 6)


def test_a_box_is_seen_from_inside():
    """A camera outside looks through the near walls of a container onto the far ones."""
    light = {"direction": [0, -1, 0], "intensity": 0.25, **DARK}
    box = {"box": {"min": [-1, 0, -1], "max": [1, 2, 1], "look": matte()}}
    got = picture(colliders=box, light=light, camera={"position": [0, 1, 6], "target": [0, 1, 0], "fov": 30})
    assert got[24, 32, 3] == 1.0 and got[2, 2, 3] == 0.0
    floor = got[40, 32, 0]
    assert floor == pytest.approx(1.0, rel=1e-3)  # lit through the ceiling, which is not seen


def test_a_mirror_shows_things_where_optics_puts_them():
    """The image of a glowing ball in a level mirror lies at the mirrored place, with all its light."""
    camera = {"position": [0, 1.2, 4], "target": [0, 0.2, 0], "fov": 40}
    light = {"intensity": 0, **DARK}
    mirror = {"albedo": "white", "metal": 1, "roughness": 0, "mirror": True, "height": 0.0}
    common = {"light": light, "camera": camera, "size": (320, 240)}
    got = picture(systems=dot(0.8, "sphere"), ground=mirror, **common)[..., 0]
    image = picture(systems=dot(-0.8, "sphere"), **common)[..., 0]  # where it would stand below the ground
    real = picture(systems=dot(0.8, "sphere"), **common)[..., 0]
    assert np.abs(got - (image + real)).max() < 0.02 * got.max()
    assert image.sum() > 100


def test_a_rough_mirror_blurs_and_keeps_the_light():
    camera = {"position": [0, 1.2, 4], "target": [0, 0.0, 0], "fov": 60}
    mirror = {"albedo": "white", "metal": 1, "mirror": True}
    common = {"light": {"intensity": 0, **DARK}, "camera": camera, "size": (320, 240), "systems": dot(0.8, "sphere")}
    smooth, rough = (picture(ground={**mirror, "roughness": r}, **common)[130:, :, 0] for r in (0.0, 0.2))
    assert rough.max() < 0.8 * smooth.max() and rough.sum() == pytest.approx(smooth.sum(), rel=0.1)


def test_film_and_still_show_the_same_surfaces(tmp_path):
    given = {
        "ground": matte(),
        "light": {},
        "colliders": {"sphere": {"center": [0, 0.3, 0], "radius": 0.3, "look": "red"}},
    }
    film = ga.render(preset(**given), tmp_path / "f_####.png", size=SIZE, frames=range(3))
    again = still(preset(**given), tmp_path / "s.png", 2 / 30, size=SIZE)
    assert film[2].read_bytes() == again[0].read_bytes()


@pytest.mark.parametrize(
    "keys,words",
    [
        ({"light": {"size": 0}}, "must be more than 0"),
        ({"ground": {"roughness": 2}}, "from 0 to 1"),
        ({"ground": {"rougness": 0.1}}, "did you mean 'roughness'"),
        ({"ground": 7}, "ground"),
        ({"colliders": {"plane": {"look": {"checker": 0}}}}, "must be more than 0"),
        ({"colliders": {"plane": {"look": {"albdo": "red"}}}}, "did you mean 'albedo'"),
        ({"shadows": "soft"}, "true or false"),
    ],
)  # fmt: skip
def test_wrong_keys_are_sentences(keys, words):
    with pytest.raises(PresetError, match=words):
        preset(**keys)


@pytest.mark.parametrize(
    "keys,words",
    [
        ({"ground": {"mirror": True}, "colliders": {"plane": {"point": [0, 9, 0], "normal": [0, -1, 0], "look": {"mirror": True}}}},
         "a mirror that faces a mirror"),
        ({"colliders": {"sphere": {"look": {"mirror": True}}}}, "only a plane or the ground can be a mirror"),
        ({"colliders": {"sphere": {"radius": 9, "look": "red"}}}, "the camera at .* is inside the sphere"),
        ({"ground": {"height": 8}}, "behind the plane"),
        ({"systems": {"dot": {"emitters": {"one": {"count": 1}}, "look": {"draw": "body"}}}}, "has none"),
        ({"systems": {"dot": {"emitters": {"one": {"count": 1}}, "look": {"draw": "thread"}}}}, "springs"),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_a_sentence(keys, words):
    with pytest.raises((PresetError, ga.errors.UsageError), match=words):
        picture(**keys)


@pytest.mark.parametrize("what,words", [
    ("steep", "changes by 3 .* must not by more than 1"), ("slanted", "changes by 1.5 .* must not by more than 1"),
    ("flat", "changes by 0.05 .* a distance changes by 1"), ("broken", "is not a number near"),
])  # fmt: skip
def test_an_sdf_that_is_no_distance_is_refused(what, words):
    """A plane that leans along (1, 1, 1) changes by 1.5 / sqrt(3) < 1 along each axis: a mutant that probes the axes alone passes it."""
    from gen_art.backend.runtime import ti

    @ti.func
    def steep(x):
        return 3.0 * (x.norm() - 0.5)

    @ti.func
    def slanted(x):
        return 1.5 * (x[0] + x[1] + x[2]) / ti.sqrt(3.0)

    @ti.func
    def flat(x):
        return 0.05 * (x.norm() - 0.5)

    @ti.func
    def broken(x):
        return ti.sqrt(x[0] - 0.5)

    function = {"steep": steep, "slanted": slanted, "flat": flat, "broken": broken}[what]
    system = ga.ParticleSystem([[0, 9, 0]], colliders=[ga.colliders.SDF(function, look="red")])
    with pytest.raises(PresetError, match=words):
        ga.render_frame(ga.Simulation({"far": system}, dt=0.01), SIZE, ga.Camera(position=(0, 0, 5)))


def test_distances_of_shapes_with_edges_and_of_small_grids_are_taken():
    """A box has a distance whose differences along two axes belong to two faces at its edges; beyond a grid nothing changes."""
    from gen_art.backend.runtime import ti
    from gen_art.renderer.surfaces.view_problems import check_distances

    @ti.func
    def box(x):
        return ti.max(abs(x[0]), abs(x[1]), abs(x[2])) - 0.5

    place = np.stack(np.meshgrid(*[np.linspace(-0.1, 0.1, 9)] * 3, indexing="ij"), axis=-1)
    corners = {"min": (-0.1, -0.1, -0.1), "max": (0.1, 0.1, 0.1)}
    ball = ga.colliders.SDF(np.linalg.norm(place, axis=-1) - 0.07, look="red", **corners)
    low = ga.colliders.SDF(0.05 * (np.linalg.norm(place, axis=-1) - 0.07), look="red", **corners)
    view = ga.Camera(position=(0, 0, 5)).at(0.0)
    check_distances(ColliderTerms([ga.colliders.SDF(box, look="red"), ball]), view, 0.0)
    with pytest.raises(PresetError, match=r"changes by 0.05 .* a distance changes by 1"):
        check_distances(ColliderTerms([low]), view, 0.0)


def test_a_script_gives_light_ground_and_looks():
    system = ga.ParticleSystem([[0, 9, 0]], colliders=[ga.colliders.Sphere((0, 0.5, 0), 0.5, look="#ff0000")])
    sim = ga.Simulation({"far": system}, dt=0.01)
    camera = ga.Camera(position=(0, 1, 5), target=(0, 0.5, 0))
    got = ga.render_frame(sim, SIZE, camera, light={"direction": [0, -1, -1]}, ground="white")
    assert got[24, 32, 0] > 3 * got[24, 32, 1] and got[47, 2, 3] == 1.0
    for keys, words in (
        ({"light": {"size": -1}}, "light.size"),
        ({"ground": 3}, "ga.Ground"),
        ({"light": "sun"}, "ga.Light"),
    ):
        with pytest.raises(ga.UsageError, match=words):
            ga.render_frame(sim, SIZE, camera, **keys)
    with pytest.raises(ga.UsageError, match="albdo"):
        ga.ParticleSystem([[0, 0, 0]], colliders=[ga.colliders.Plane(look={"albdo": "red"})])


def test_the_sun_of_a_sky_is_the_lamp_and_what_light_names_replaces_it():
    from gen_art.renderer.lighting import Lighting
    from gen_art.renderer.sky import SkyDome

    dome = SkyDome.of(ga.Sky(sun=50))
    sun = Lighting.of(None, dome)
    assert sun.direction == pytest.approx(-dome.sun_direction) and sun.lamp == pytest.approx(
        dome.sun_irradiance / (4 * math.pi)
    )
    # the mean of the sky's light over all directions, and no light from a sky that is black
    around = np.random.default_rng(3).normal(size=(20_000, 3))
    around /= np.linalg.norm(around, axis=1)[:, None]
    assert sun.ambient[:, 0] == pytest.approx(dome.radiance(around).mean(axis=0), rel=0.03)
    named = Lighting.of(ga.Light(direction=(0, -1, 0), ambient_intensity=0), dome)
    assert named.direction == pytest.approx([0, -1, 0]) and not named.ambient.any()
    assert named.lamp == pytest.approx(sun.lamp)


def test_fog_of_the_sky_needs_one():
    camera = {"position": [0, 1, 5], "target": [0, 0.5, 0], "fog": {"distance": 0.5, "color": "sky"}}
    with pytest.raises(ga.UsageError, match="needs a sky"):
        picture(ground=True, camera=camera)
    far = picture(
        ground="black", light={"intensity": 0, **DARK}, sky="#8090a0", camera={**camera, "position": [0, 1, 900]}
    )
    assert far[30, 32, :3] == pytest.approx(far[2, 2, :3], rel=1e-5)


EVEN = {"intensity": 0, "ambient_intensity": 1.0}


def one_ball(place, radius=0.4, **look):
    return {
        "ball": {
            "particle": {"radius": radius}, "emitters": {"one": {"count": 1, "shape": {"point": place}}},
            "look": {"draw": "sphere", "blend": "opaque", "albedo": "white", "finish": {"ior": 1}, **look},
        }
    }  # fmt: skip


def test_near_and_far_clip_solids_and_do_not_blacken_them():
    camera = {"position": [0, 0, 5], "target": [0, 0, 0], "fov": 30}
    white = picture(systems=one_ball([0, 0, 0]), light=EVEN, camera=camera)[24, 32]
    assert white == pytest.approx([1, 1, 1, 1], abs=0.01)
    for limits in ({"far": 4.0}, {"near": 6.0}):
        assert not picture(systems=one_ball([0, 0, 0]), light=EVEN, camera={**camera, **limits})[24, 32].any()
    # the middle of a ball beside a wide camera may lie behind it
    beside = {"position": [0, 0, 0.3], "target": [0, 0, -1], "fov": 120}
    got = picture(systems=one_ball([1.2, 0, 0.5], 1.0), light=EVEN, camera=beside)
    assert got[..., 3].any() and got[got[..., 3] == 1.0][:, :3].min() > 0.95


def test_an_orthographic_camera_sees_solids_behind_it():
    camera = {"position": [0, 0, 5], "target": [0, 0, 0], "height": 3}
    got = picture(systems=one_ball([0, 0, 8]), light=EVEN, camera=camera)
    assert got[24, 32] == pytest.approx([1, 1, 1, 1], abs=0.01)


def hidden_by_rods(x, z):
    """The share of an even sky that the rods below hide from level ground at (x, z), summed over a thousandth of a metre of each."""
    along = (np.arange(4000) + 0.5) / 1000 - 2 - x
    total = 0.0
    for across in np.arange(5) * 0.5 - z:
        far = np.sqrt(along**2 + 0.5**2 + across**2)
        seen = 0.02 * 0.001 * (0.5 + abs(across)) / far  # their upper and one other side
        total += (seen * (0.5 / far) / (np.pi * far**2)).sum()
    return total


def test_thin_rods_take_little_of_the_sky():
    """Five rods of 4 x 0.02 x 0.02 m, half a metre above the ground, hide 6% of the sky below their middle.

    Matter of their mean shadow, which the grid holds, may differ from rods that all lie level by the ratio of the two: 0.08 m^2 as the
    mean over all directions, and 0.08 to 0.113 m^2 from below. Mutants: twice their area; rods at their middles alone.
    """
    rods = {
        "rods": {
            "integrator": "leapfrog", "interactions": {"rigid": {}},
            "emitters": {"all": {"body": {"shape": {"box": [4, 0.02, 0.02]}, "grid": [1, 1, 5], "pitch": [1, 1, 0.5], "position": [0, 0.5, 0]}}},
            "look": {"draw": "body"},
        }
    }  # fmt: skip
    got = picture(
        systems=rods, ground=matte(), light=EVEN, camera={"position": [0, 3, 4], "target": [0, 0, 1.2], "fov": 20}
    )
    hidden = hidden_by_rods(0, 1.2)
    assert 0.08 / 0.113 * hidden < 1 - np.median(got[..., 0]) < 1.05 * hidden


def test_threads_without_particles_are_nothing():
    springs = ga.interactions.Springs([[0, 1]], 1.0)
    gone = SimpleNamespace(count=0, floats=np.zeros((10, 4)))
    assert len(springs.shapes(gone).particle) == 0


@pytest.mark.parametrize("draw", ["point", "pixel", "disc"])
def test_a_mirror_does_not_show_what_lies_below_it(draw):
    many = {
        "below": {
            "emitters": {"all": {"count": 40_000, "shape": {"sphere": 0.5, "center": [0, -1, 0]}}}, "particle": {"radius": 0.01},
            "look": {"draw": draw},
        }
    }  # fmt: skip
    mirror = {"albedo": "white", "metal": 1, "roughness": 0, "mirror": True}
    camera = {"position": [0, 2, 4], "target": [0, 0, 0], "fov": 40}
    got = picture(systems=many, ground=mirror, light={"intensity": 0, **DARK}, camera=camera)
    assert not got[..., :3].any()


def test_a_mirror_reflects_the_sun_once():
    """A smooth metal shows the sun by the lamp's highlight, with `mirror` or without."""
    sky = {"sun": {"height": 30, "azimuth": 0}}
    camera = {"position": [0, 2, 4], "target": [0, 0, 0.53], "fov": 12}
    metal = {"albedo": "white", "metal": 1, "roughness": 0}
    one, two = (
        picture(ground={**metal, "mirror": m}, sky=sky, camera=camera, size=(160, 120))[..., 0].sum()
        for m in (False, True)
    )
    assert two == pytest.approx(one, rel=0.05)


def test_ground_false_leaves_out_the_preset_s():
    sim = ga.Simulation(preset(ground="white"))
    assert ga.render_frame(sim, SIZE)[..., 3].all() and not ga.render_frame(sim, SIZE, ground=False)[..., 3].any()


@pytest.mark.parametrize("turn", [0, 90])
def test_a_long_body_hides_the_sky_where_it_is(turn):
    """A board over white ground in an even sky: along its middle the ground below is as dark as at its centre, and darker than far beside it.

    The board is 8 m long and 1 m above the ground. Its upper side is as bright at its centre as towards its ends. Mutants: a body hides
    the sky at its centre alone; pieces along the wrong axis.
    """
    board = body_system({"box": [8, 0.2, 1], "turn": [0, turn, 0]}, position=[0, 1, 0], static=True)
    even = {"intensity": 0, "ambient": "white", "ambient_intensity": 0.5}
    common = {"systems": board, "light": even, "size": (96, 96)}
    below = picture(
        ground=matte(), camera={"position": [0, 0.5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "height": 12}, **common
    )
    above = picture(camera={"position": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "height": 12}, **common)
    below, above = (np.rot90(p[..., 0]) if turn else p[..., 0] for p in (below, above))
    row = below[48, 48 + np.array([-20, 0, 20])]
    assert row.max() < 1.08 * row.min() and row.max() < 0.93 * below[8, 48]
    top = above[48, 48 + np.array([-24, -12, 0, 12, 24])]
    assert top.min() > 0.4 and top.max() < 1.05 * top.min()


def test_drawn_colliders_of_one_kind_follow_each_other_with_their_looks():
    """Kernels loop over colliders of one kind, so a scene puts them together, and each keeps its own look."""
    ball, block = ga.colliders.Sphere, ga.colliders.Block
    colliders = [
        ball((0, 0, 0), 0.1, look="red"), block((1, 0, 0), (2, 1, 1), look="green"), ball((3, 0, 0), 0.2, look="blue"),
        block((5, 0, 0), (6, 1, 1), look="white"),
    ]  # fmt: skip
    surfaces = Scene(colliders=tuple(colliders)).surfaces
    assert [collider for collider, _ in surfaces] == [colliders[k] for k in (0, 2, 1, 3)]
    assert all(look == surface_look(collider.values["look"]) for collider, look in surfaces)
    assert [kind.count for kind in ColliderTerms([collider for collider, _ in surfaces]).kinds] == [2, 2]
