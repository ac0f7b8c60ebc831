"""A small piece that renders in a moment: sparks on streaks with a trail, and a puff that hides."""

from gen_art.preset.load import load_preset


def piece(**overrides):
    """The preset, with dotted overrides (`clock__fps=60`)."""
    data = {
        "name": "small",
        "version": 1,
        "seed": 5,
        "clock": {"duration": 0.5, "fps": 20, "step": "1/80", "preroll": 0.25},
        "forces": {"gravity": [0, -2, 0]},
        "systems": {
            "sparks": {
                "particle": {"lifetime": "0.3..0.8"},
                "emitters": {"jet": {"rate": 400, "velocity": {"cone": [0, 1, 0], "angle": 30, "speed": "1..2"}}},
                "look": {
                    "draw": "streak", "width": 0.04, "emission": {"color": ["white", "crimson"], "intensity": 4},
                    "trail": {"half_life": 0.1, "substeps": 2},
                },
            },
            "puff": {
                "particle": {"radius": 0.1},
                "emitters": {"burst": {"at": [0], "count": 200, "shape": {"sphere": 0.3}}},
                "look": {"draw": "disc", "blend": "alpha", "opacity": 0.3, "albedo": "teal"},
            },
        },
        "camera": {"position": [0, 0.3, 5], "target": [0, 0.3, 0], "fov": 35, "size": [96, 54]},
        "develop": {"bloom": 0.1},
    }  # fmt: skip
    return load_preset(data, overrides={key.replace("__", "."): value for key, value in overrides.items()})
