"""The rows of a system's state array, (rows, capacity), which kernels call S."""

__all__ = [
    "CHARGE", "FIRST_ATTRIBUTE", "LIFETIME", "MASS", "POSITION", "PX", "PY", "PZ", "RADIUS", "VELOCITY", "VX", "VY", "VZ",
]  # fmt: skip

PX, PY, PZ = 0, 1, 2  # position, m
VX, VY, VZ = 3, 4, 5  # velocity, m/s
MASS = 6  # kg
CHARGE = 7  # C
RADIUS = 8  # m
LIFETIME = 9  # s after birth; infinite for particles that do not die
FIRST_ATTRIBUTE = 10  # the declared attributes, in order of name

POSITION = slice(PX, PZ + 1)
VELOCITY = slice(VX, VZ + 1)
