"""A small piece for the studio: a fountain with knobs, a trail, a gradient, a curve and a comment on most lines."""

TEXT = """\
# A fountain for the studio.
version: 1
seed: 5
knobs:
  push: {value: 9, range: 4..14, unit: m/s}   # how fast
  glow: 3
clock: {duration: 2, fps: 30, step: 1/120, preroll: 0.5}   # short
forces:
  gravity: [0, -9.81, 0]
systems:
  drops:
    particle: {radius: 0.02, lifetime: 1..2}
    emitters:
      nozzle: {rate: 300, velocity: {cone: [0, 1, 0], angle: 10, speed: $push}}
    look:
      draw: disc
      size: [[0, 1], [1, 0.4]]   # shrinks
      emission: {color: ['#ffffff', '#2060ff'], intensity: $glow}
camera: {position: [0, 2, 9], target: [0, 2, 0], fov: 40, size: [320, 180]}
develop: {exposure: 0.5, tone: agx}
"""
TRAILED = TEXT.replace("      draw: disc\n", "      draw: disc\n      trail: {half_life: 0.1}\n")
# a camera that meets its target on the way: only trying it finds that
THROUGH_TARGET = TEXT.replace(
    "position: [0, 2, 9],", "path: [{time: 0, position: [0, 2, 9], easing: linear}, {time: 2, position: [0, 2, -9]}],"
)
