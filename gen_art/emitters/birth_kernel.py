"""The birth kernel: generated from a shape and a velocity (or a scripted emitter), it writes all attributes of new particles.

Every random number comes from the particle's own stream.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters, traced
from gen_art.backend.runtime import ti
from gen_art.maths.random import Stream, channel_of
from gen_art.particles.rows import MASS, RADIUS, VX
from gen_art.particles.storage import BASE_ROWS

__all__ = ["SETTABLE", "make_birth"]

SETTABLE = ("radius", "mass", "charge", "lifetime")
# the same for both particles of a balanced pair, so that their momenta cancel
_PAIRED = ("radius", "mass", "charge", "density")
BLOCK = 512


@traced
def make_stream(low, high, **extra):
    """A random stream of the two words of a key, with `extra` attributes."""
    result = Stream(low, high)
    result.__dict__.update(extra)
    return result


@traced
def split_born(born):
    """Position, velocity and a dict of the other attributes, from what a scripted emitter returned."""
    if isinstance(born, dict):
        others = dict(born)
        return others.pop("position"), others.pop("velocity"), others
    if isinstance(born, (tuple, list)):
        return born[0], born[1], {}
    others = dict(born.__dict__)
    return others.pop("position"), others.pop("velocity"), others


class _Layout:
    """What the kernel is generated from, and where each part's numbers begin in Q."""

    _data_oriented = True

    def __init__(self, shape, velocity, scripted, attributes, channels):
        self.shape, self.velocity, self.scripted = shape, velocity, scripted
        self.has_shape, self.has_velocity = shape is not None, velocity is not None
        self.is_scripted = scripted is not None
        self.velocity_offset = self._size(shape)
        self.ranges_offset = self._size(scripted) if self.is_scripted else self.velocity_offset + self._size(velocity)
        # (row, channel, offset of (low, high), paired) of each attribute; density has row -1: it sets the mass after the radius
        self.rows = {**BASE_ROWS, **channels}
        rows = [-1 if name == "density" else self.rows[name] for name in attributes]
        self.ranges = [
            (row, channel_of(name), self.ranges_offset + 2 * k, name in _PAIRED)
            for k, (row, name) in enumerate(zip(rows, attributes))
        ]

    @staticmethod
    def _size(part):
        """How many numbers a shape, velocity or emitter takes in Q."""
        return 0 if part is None else sum(s for _, _, s in part.layout())


@cache
def make_birth(signature, precision: str):
    """The birth kernel of a kind of particle.

    signature : a hashable BirthKind (births.py); numbers are never part of the key
    The kernel is birth(S, K, slots (m,) i32, paired (2, m) u32, burst (2, m) u32, ordinal (m,) i32, sign (m,), origin (6, m),
    when (m,), Q).
    paired : key of the stream for what a balanced pair shares
    burst : key of the stream for what a burst shares
    sign : factor of place and velocity, 1 or -1 for the two of a pair, 0 for a particle without a partner
    """
    layout = _Layout(signature.shape, signature.velocity, signature.scripted, signature.attributes, signature.channels)
    dtype = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(dtype, 2), ti.types.ndarray(dtype, 1)
    words = ti.types.ndarray(ti.u32, 2)
    integers = ti.types.ndarray(ti.i32, 1)

    @ti.kernel
    def birth(
        S: matrix, K: words, slots: integers, paired: words, burst: words, ordinal: integers, sign: vector, origin: matrix,
        when: vector, Q: vector,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range((slots.shape[0] + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, slots.shape[0])):
                k = slots[i]
                burst_stream = make_stream(burst[1, i], burst[0, i])
                particle_stream = make_stream(K[1, k], K[0, k], ordinal=ordinal[i], burst=burst_stream)
                paired_stream = make_stream(paired[1, i], paired[0, i], ordinal=ordinal[i], burst=burst_stream)
                t = when[i]
                x = ti.Vector([0.0, 0.0, 0.0])
                v = ti.Vector([0.0, 0.0, 0.0])
                for row, channel, offset, is_paired in ti.static(layout.ranges):
                    if ti.static(row >= 0):
                        low, high = Q[offset], Q[offset + 1]
                        value = low
                        if high != low:  # an infinite lifetime must stay out of the arithmetic of a range
                            if ti.static(is_paired):
                                value = low + (high - low) * paired_stream.uniform(channel)
                            else:
                                value = low + (high - low) * particle_stream.uniform(channel)
                        S[row, k] = value
                for row, channel, offset, is_paired in ti.static(layout.ranges):
                    if ti.static(row < 0):
                        density = Q[offset] + (Q[offset + 1] - Q[offset]) * paired_stream.uniform(channel)
                        S[MASS, k] = density * 4.1887902047863905 * S[RADIUS, k] * S[RADIUS, k] * S[RADIUS, k]
                if ti.static(layout.is_scripted):
                    born = layout.scripted.birth(particle_stream, t, parameters(Q, layout.scripted, 0))
                    position, velocity, others = ti.static(split_born(born))
                    x += position
                    v += velocity
                    for name in ti.static(list(others)):
                        S[layout.rows[name], k] = others[name]
                else:
                    if ti.static(layout.has_shape):
                        x = layout.shape.place(paired_stream, t, parameters(Q, layout.shape, 0))
                    if ti.static(layout.has_velocity):
                        v = layout.velocity.velocity(
                            paired_stream, t, parameters(Q, layout.velocity, layout.velocity_offset), x
                        )
                    x *= sign[i]
                    v *= sign[i]
                for c in ti.static(range(3)):
                    S[c, k] = origin[c, i] + x[c]
                    S[VX + c, k] = origin[VX + c, i] + v[c]

    return runtime.kernel(birth, precision)
