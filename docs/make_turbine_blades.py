"""Print the boxes of presets/course/wind_turbine.yaml, of which its rotors are made: of the large one, then of the small ones.

.venv/bin/python docs/make_turbine_blades.py

A blade is a row of boxes along y: a round root that becomes a wide, thin blade, and tapers along its trailing edge. Three of them
stand at 120 degrees round x. Lengths in metres, angles in degrees.
"""

import numpy as np

PITCH, ROOT, WIDEST, TIP = 16.4, 0.1, 0.5, 2.3
FINE = [*np.linspace(ROOT, WIDEST, 27), *np.linspace(WIDEST, TIP, 36)[1:]]
COARSE = [0.1, 0.25, 0.36, 0.5, 0.75, 1.0, 1.3, 1.6, 1.9, 2.1, 2.3]


def rotation(vector):
    """The matrix that turns about a vector by its length, in degrees (Rodrigues)."""
    angle = np.radians(np.linalg.norm(vector))
    x, y, z = np.asarray(vector) / max(np.linalg.norm(vector), 1e-300)
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def vector_of(matrix):
    """The vector about which a matrix turns, as long as the angle, in degrees."""
    angle = np.arccos(np.clip((np.trace(matrix) - 1) / 2, -1, 1))
    twice = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    return np.degrees(angle) * twice / (2 * np.sin(angle))


def chord(r):
    if r < WIDEST:
        u = max(0.0, (r - 0.12) / (WIDEST - 0.12))
        return 0.09 + 0.15 * u * u * (3 - 2 * u)
    u = (r - WIDEST) / (2.31 - WIDEST)
    return 0.24 * (1 - u) ** 0.75 * (1 - 0.35 * u) + 0.012


def thickness(r):
    return 0.075 * max(0.0, 1 - r / 0.55) + 0.036 * (1 - r / 2.6)


def row(numbers):
    return ", ".join(f"{0 if abs(v) < 1e-4 else v:.3g}" for v in numbers)


def blades(edges):
    pitch = rotation([0, PITCH, 0])
    for k in range(3):
        turn = rotation([120 * k, 0, 0])
        for a, b in zip(edges, edges[1:]):
            r = (a + b) / 2
            back = pitch @ np.array([0, 0, -0.22 * (chord(r) - 0.09)])  # so that the leading edge is nearly straight
            size, at = (thickness(r), b - a + 0.012, chord(r)), turn @ (np.array([0, r, 0]) + back)
            yield f"{{box: [{row(size)}], at: [{row(at)}], turn: [{row(vector_of(turn @ pitch))}]}}"


if __name__ == "__main__":
    for edges in (FINE, COARSE):
        boxes = list(blades(edges))
        for k in range(0, len(boxes), 4):
            print("            " + ", ".join(boxes[k : k + 4]) + ",")
        print()
