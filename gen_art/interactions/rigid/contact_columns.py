"""Columns of the arrays that the contact kernel takes: bodies B, their velocities V, contacts C, and scratch D and M.

Colliders are one more body at the end of B and V, whose numbers are 0.
"""

# B, the bodies
INVERSE_MASS = 0  # 1/kg
INVERSE_INERTIA = 1  # (3, 3) in the world, 1/(kg m^2)
BODY_COLUMNS = 10

# V, the bodies' velocities
VELOCITY = 0  # (3,) m/s, of the origin
SPIN = 3  # (3,) rad/s
VELOCITY_COLUMNS = 6

# C, the contacts
ARM_A, ARM_B = 0, 3  # (3,) m, from each body's origin to the contact
FRAME = 6  # (3, 3), rows: the normal and two tangents
TARGET_SPEED = 15  # m/s, least speed along the normal after the impulse
FRICTION = 16  # coefficient
IMPULSE = 17  # (3,) N s, along the rows of FRAME
SURFACE_SPEED = 20  # (3,) m/s, of the collider along the rows of FRAME
CONTACT_COLUMNS = 23
NO_TARGET = -1e300  # the target speed of a contact that needs no impulse

# D: for row r of FRAME from DIRECTION r on, the levers arm x row of both bodies, and the spins that a unit impulse gives them
LEVER_A, LEVER_B, SPIN_A, SPIN_B, DIRECTION = 0, 3, 6, 9, 12
DIRECTION_COLUMNS = 3 * DIRECTION

# M: for each row of FRAME the effective mass, the impulse before this pair of sweeps, and the change by the last pair
EFFECTIVE_MASS, PREVIOUS, STEP, SCRATCH_COLUMNS = 0, 3, 6, 9
