"""Pictures whose bytes must not depend on the number of threads.

`python -m tests.render.thread_scenes THREADS [NAMES]` prints a digest of each.

Together they run every kernel of the renderer. Each picture has more than 512 pixels, particles and rows, so that Taichi shares
the work out, and sprites and surfaces that lie over each other, so that the order of sums would show.
"""

import contextlib
import hashlib
import json
import sys
import tempfile

import numpy as np
from PIL import Image

import gen_art as ga
from gen_art.backend import runtime
from gen_art.output.playback import Playback
from gen_art.preset.look import Look
from gen_art.renderer.auto_exposure import metered_stops
from gen_art.renderer.camera import Camera
from gen_art.renderer.painter import Painter
from gen_art.renderer.tone_map import develop
from tests.render.particles import scene, state

SIZE = (200, 120)
CLOCK = {"duration": 1, "fps": 30, "step": "1/120"}
CAMERA = {"position": [2, 1.5, 3], "target": [0, 0.4, 0]}
SMOKE = {
    "emitters": {"all": {"count": 800, "shape": {"box": [2, 1, 2]}}}, "particle": {"radius": 0.2},
    "look": {"draw": "disc", "blend": "alpha", "opacity": 0.2},
}  # fmt: skip


def played(step=3, size=SIZE, layers=False, **keys):
    """[a picture of a preset with these keys, then its layers if they are wanted]."""
    playback = Playback(ga.load_preset({"version": 1, "clock": CLOCK, "camera": CAMERA, **keys}), size, "f32", None)
    picture = playback.picture(step).copy()
    return [picture, *(playback.aovs().values() if layers else ())]


def balls(count=300, radius=0.05, **look):
    return {
        "particle": {"radius": radius},
        "emitters": {"all": {"count": count, "shape": {"sphere": 1.0, "center": [0, 0.6, 0]}, "velocity": {"radial": 2}}},
        "look": {"draw": "sphere", "blend": "opaque", **look},
    }  # fmt: skip


def surfaces():
    metal = {"sphere": {"center": [0, 0.4, 0], "radius": 0.4, "look": {"metal": 1, "roughness": 0.1}}}
    ground = {"mirror": True, "roughness": 0.2, "checker": 0.3}
    systems = {"beads": balls(), "smooth": balls(40, 0.1, finish=0.05), "smoke": SMOKE}
    return played(sky={"sun": 40}, ground=ground, colliders=metal, systems=systems, layers=True)


def bodies_and_threads():
    systems = {
        "bodies": {"integrator": "leapfrog", "interactions": {"rigid": {}}, "look": {"draw": "body"},
                   "emitters": {"all": {"body": {"shape": {"box": [0.2, 0.1, 0.3]}, "grid": [4, 3, 4], "pitch": [0.4, 0.4, 0.4],
                                                 "position": [0, 0.8, 0], "turn": [20, 30, 40]}}}},
        "net": {"particle": {"mass": 0.01, "radius": 0.01}, "interactions": {"springs": {"stiffness": 10, "damping": 0.01}},
                "emitters": {"sheet": {"cloth": {"corner": [-0.5, 1.6, 0.5], "columns": 12, "rows": 10, "pinned": "corners"}}},
                "look": {"draw": "thread", "radius": 0.01}},
    }  # fmt: skip
    return played(sky={"sun": 30}, ground=True, systems=systems, layers=True)


def maps():
    side = np.random.default_rng(5).integers(0, 255, (48, 64, 3)).astype(np.uint8)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Image.fromarray(side).save("noise.png")
        look = ga.SurfaceLook(image={"file": "noise.png", "size": 0.7})
        system = ga.ParticleSystem([[0, 9, 0]], colliders=[ga.colliders.Sphere((0, 0.5, 0), 0.5, look=look)])
        ground = ga.Ground(puddles=0.4, image={"file": "noise.png", "size": 2}, mirror=True)
        sim = ga.Simulation({"far": system}, dt=0.01)
        return [
            ga.render_frame(sim, SIZE, Camera(**CAMERA), sky=ga.Sky(sun=20), ground=one)
            for one in (ground, ga.Ground(albedo="#0a1c22", roughness=0, ior=1.33, mirror=True, waves=0.08))
        ]


def glass():
    clear = {"transmission": 1, "roughness": 0, "attenuation_distance": 0.3}
    ball = {"sphere": {"center": [0, 0.4, 0], "radius": 0.4, "look": {**clear, "albedo": "gold"}}}
    return played(sky={"sun": 40}, ground="white", colliders=ball, systems={"drops": balls(60, 0.1, finish=clear)})


def cloth():
    flag = {
        "particle": {"mass": 0.01}, "interactions": {"springs": {"stiffness": 10, "damping": 0.01}},
        "emitters": {"sheet": {"cloth": {"corner": [-0.5, 1.2, 0], "columns": 24, "rows": 20, "pinned": "corners"}}},
        "look": {"draw": "cloth", "translucency": 0.3, "back": "red"},
    }  # fmt: skip
    keys = {"sky": {"sun": 40}, "ground": {"mirror": True, "roughness": 0.2}, "forces": {"gravity": [0, -9.81, 0]}}
    return played(24, systems={"flag": flag}, layers=True, **keys)


def liquids():
    from tests.render.test_liquid import PIECE

    return played(0, layers=True, **PIECE)


def glow():
    flame = {"emitters": {"all": {"count": 5000, "shape": {"ball": 0.5, "center": [-0.3, 0.6, 0]}}},
             "look": {"draw": "disc", "radius": 0.05,
                      "emission": {"color": {"by": "y", "range": "0..2", "gradient": "magma"}}}}  # fmt: skip
    sphere = {"sphere": {"center": [0.6, 0.4, 0], "radius": 0.4, "look": "white"}}
    keys = {"ground": {"roughness": 0.3}, "colliders": sphere, "light": {"glow": "flame"}}
    return played(systems={"flame": flame, "smoke": SMOKE}, **keys)


def smoke_in_full_light():
    """Light that is scattered many times, and shadows that solids throw into smoke."""
    keys = {"light": {"scatter": "full", "phase": 0.4}, "ground": True}
    return played(systems={"smoke": SMOKE, "balls": balls()}, **keys)


def lens_before_surfaces():
    camera = {**CAMERA, "lens": 0.05}
    return played(size=(96, 54), light={}, ground=True, camera=camera, systems={"beads": balls(), "smoke": SMOKE})


def trails_and_ribbons():
    dust = {
        "emitters": {"all": {"count": 3000, "shape": {"ball": 0.8, "center": [0, 0.6, 0]}, "velocity": {"radial": 1}}}
    }
    trail = {**dust, "look": {"draw": "point", "trail": 0.2}}
    ribbon = {**dust, "look": {"draw": "streak", "width": 0.01, "ribbon": {"length": 0.05, "points": 6}}}
    ground = {"mirror": True, "roughness": 0.1}
    return played(systems={"trail": trail, "ribbon": ribbon}, ground=ground, light={})


def clouds(looks: dict, camera: Camera, exposure=0.05, times=1, remembered=()):
    """Forty thousand particles for each look, each cloud one unit beside the one before."""
    rng = np.random.default_rng(0)
    x, v = rng.normal(0, 1, (40000, 3)), rng.normal(0, 2, (40000, 3))
    painter = Painter((320, 200), camera, looks, exposure, times)
    for k in range(4):
        for name in remembered:
            painter.paths[name].remember(state(x - (1 - k / 4) * v, v + (1 - k / 4)), 0.25 * k)
    return painter.paint(scene(1.0, **{name: state(x + i, v) for i, name in enumerate(looks)}), 0.0)


LIGHT = dict(
    points=Look(draw="point"), dots=Look(draw="pixel"), soft=Look(draw="disc", pixels=6),
    streaks=Look(draw="streak", width=0.02, emission={"blackbody": 1800}),
)  # fmt: skip
DENSE = dict(
    smoke=Look(draw="disc", blend="alpha", radius=0.04, size={"by": "random", "curve": [[0, 1], [1, 8]]}, opacity=0.2, light={}),
    balls=Look(draw="sphere", blend="opaque", radius=0.01),
)  # fmt: skip
BEFORE = {"position": (0, 0, 6)}


def small_sprites():
    linear = clouds(LIGHT, Camera(**BEFORE))
    return [linear, develop(linear)]


def small_sprites_through_a_lens():
    linear = clouds(LIGHT, Camera(**BEFORE, lens=(0.05, None)))
    return [linear, develop(linear)]


def sprites_that_hide_others():
    linear = clouds({**LIGHT, **DENSE}, Camera(**BEFORE), times=2)
    return [linear, develop(linear)]


def ellipses_and_curved_streaks():
    looks = dict(
        add=Look(draw="disc", radius=0.03, stretch=0.1), haze=Look(draw="disc", radius=0.01, spread=0.3),
        smoke=Look(draw="disc", blend="alpha", radius=0.04, stretch=0.2, opacity=0.2, light={}),
        streaks=Look(draw="streak", width=0.02),
        threads=Look(draw="disc", radius=0.02, stretch={"by": "neighbours", "reach": 0.2}),
    )  # fmt: skip
    return [clouds(looks, Camera(**BEFORE), 0.5, remembered=("streaks",))]


def pictures_as_sprites():
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Image.fromarray(np.random.default_rng(5).integers(0, 255, (48, 64, 4)).astype(np.uint8)).save("leaf.png")
        return [clouds({"leaves": Look(draw="picture", picture="leaf.png", radius=0.02)}, Camera(**BEFORE))]


def sky():
    haze = {"emitters": {"one": {"count": 1, "shape": {"point": [0, 0.6, 0]}}},
            "look": {"draw": "disc", "radius": 0.5, "blend": "alpha", "opacity": 0.5}}  # fmt: skip
    camera = {"position": [0, 0.5, 4], "target": [0, 0.9, 0]}
    sky = {"sun": {"height": 4, "azimuth": 3}, "stars": True, "band": True}
    return played(size=(161, 91), sky=sky, systems={"haze": haze}, camera=camera)


def wormhole():
    preset = ga.load_preset("wormhole", overrides={"knobs.rate": 4000, "clock.preroll": 2})
    playback = Playback(preset, (96, 54), "f32", None)
    picture = playback.picture(playback.step_of(2.5))
    return [picture, *playback.aovs().values()]


def black_hole():
    disc = {"emitters": {"gas": {"count": 20_000, "shape": {"disc": 3, "inner": 1}, "velocity": {"orbit": 20}}},
            "look": {"draw": "streak", "length": 0.05, "width": 0.02}}  # fmt: skip
    camera = {"position": [0, 1.2, 8], "target": [0, 0, 0]}
    return played(
        size=(161, 91), black_hole=0.33, sky={"stars": True, "band": True}, systems={"disc": disc}, camera=camera
    )


def exposure():
    rng = np.random.default_rng(7)
    return [
        np.array([metered_stops(rng.exponential(1.0, (h, w, 4)).astype(np.float32)) for h, w in ((180, 320), (37, 61))])
    ]


SCENES = {
    each.__name__: each
    for each in (
        surfaces, bodies_and_threads, maps, glass, cloth, liquids, glow, smoke_in_full_light, lens_before_surfaces,
        trails_and_ribbons, small_sprites, small_sprites_through_a_lens, sprites_that_hide_others, ellipses_and_curved_streaks,
        pictures_as_sprites, sky, wormhole, black_hole, exposure,
    )
}  # fmt: skip


def digest_of(name: str) -> str:
    """SHA-256 of the arrays of a scene. Raises AssertionError for one that shows nothing or what is no number."""
    arrays = [np.ascontiguousarray(array) for array in SCENES[name]()]
    assert all(np.isfinite(array).all() for array in arrays) and np.ptp(arrays[0]) > 0, f"{name} shows nothing"
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()


if __name__ == "__main__":
    runtime.init("cpu", int(sys.argv[1]))
    print(json.dumps({name: digest_of(name) for name in sys.argv[2:] or SCENES}))
