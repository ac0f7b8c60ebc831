"""A small preset that uses most of the format, for tests to read and to break."""

TEXT = """\
# A fountain that bursts.
# Physics: gravity, drag.
# Change first: the knob.
version: 1
seed: 5
knobs: {push: 9, life: 1..2}
clock: {duration: 2, fps: 30, step: 1/120, preroll: 0.5}
medium: {density: 1.2, wind: [1, 0, 0]}
forces:
  gravity: [0, -9.81, 0]
  drag: {cd: 0.5}
systems:
  drops:
    particle: {radius: 0.01, density: 1000, lifetime: $life, attributes: {hue: 0..1}}
    emitters:
      nozzle:
        rate: 200
        shape: {disc: 0.1}
        velocity: {cone: [0, 1, 0], angle: 10, speed: $push}
        tag: wet
  splash:
    particle: {radius: 0.002, mass: 1e-6, lifetime: 0.5}
    emitters:
      burst:
        from: {event: drops.death, tag: wet, inherit: velocity, balance: pairs}
        count: 4
        velocity: {sphere: 1..2}
    look: {draw: point, emission: {color: {by: age, gradient: [white, blue]}}}
camera: {position: [0, 2, 8], target: [0, 2, 0]}
"""
