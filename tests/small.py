"""Every shipped preset, made small enough for a test: fewer particles, a short preroll, the same physics."""

SMALL: dict[str, dict] = {
    "smoke": {"knobs.rate": 20000, "clock.preroll": 1},
    "fire": {"knobs.fuel": 4000, "clock.preroll": "1/2"},
    "fireworks": {"clock.preroll": 6},
    "wormhole": {"knobs.rate": 8000, "clock.preroll": 3},
    "galaxy": {
        "systems.bodies.emitters.disc.count": 600,
        "systems.bodies.emitters.bulge.count": 200,
        "systems.bodies.emitters.gas.count": 700,
        "systems.bodies.emitters.spurs.count": 500,
        "systems.bodies.emitters.flakes.count": 300,
        "systems.bodies.emitters.dust.count": 250,
        "systems.bodies.emitters.threads.count": 250,
        "clock.preroll": 0.0010227,
    },
    "charged": {
        "systems.ions.emitters.many.rate": 2e6,
        "systems.cloud.emitters.many.rate": 5e7,
        "systems.cloud.emitters.back.rate": 5e7,
        "clock.preroll": 2e-5,
    },
}
