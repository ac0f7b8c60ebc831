"""The birth kernels: generated from a shape and a velocity (or a scripted emitter), they write all attributes of new particles.

Every random number comes from the particle's own stream.

The one-letter names in kernels are in docs/glossary.md.
"""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.kernel_views import KernelView, held_parameters, traced
from gen_art.backend.runtime import ti
from gen_art.maths.random import Stream, channel_of, child_key
from gen_art.particles.rows import MASS, RADIUS, VX
from gen_art.particles.storage import BASE_ROWS

__all__ = ["SETTABLE", "make_birth", "make_scheduled_birth"]

SETTABLE = ("radius", "mass", "charge", "lifetime")
# the same for both particles of a balanced pair, so that their momenta cancel
_PAIRED = ("radius", "mass", "charge", "density")
BLOCK = 512
WORDS, INTEGERS = ti.types.ndarray(ti.u32, 2), ti.types.ndarray(ti.i32, 1)
TIMES, SERIALS = ti.types.ndarray(ti.f64, 1), ti.types.ndarray(ti.i64, 1)


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


@traced
def _numbers(layout, Q):
    """The numbers of the shape, the velocity or the scripted emitter, read once for many particles."""
    parts = [
        ("scripted", layout.scripted, 0),
        ("shape", layout.shape, 0),
        ("velocity", layout.velocity, layout.velocity_offset),
    ]
    return KernelView(**{name: held_parameters(Q, part, first) for name, part, first in parts if part is not None})


@ti.func
def _draw(
    layout: ti.template(), S: ti.template(), Q: ti.template(), q, k, own, paired, t, sign, origin: ti.template(), o
):
    """Write all that the particle in slot k is born with.

    q : of _numbers
    own, paired : its random streams
    sign : factor of place and velocity
    origin, o : column o of (6, m), what place and velocity are relative to
    """
    x = ti.Vector([0.0, 0.0, 0.0])
    v = ti.Vector([0.0, 0.0, 0.0])
    for row, channel, offset, is_paired in ti.static(layout.ranges):
        if ti.static(row >= 0):
            low, high = Q[offset], Q[offset + 1]
            value = low
            if high != low:  # an infinite lifetime must stay out of the arithmetic of a range
                if ti.static(is_paired):
                    value = low + (high - low) * paired.uniform(channel)
                else:
                    value = low + (high - low) * own.uniform(channel)
            S[row, k] = value
    for row, channel, offset, is_paired in ti.static(layout.ranges):
        if ti.static(row < 0):
            density = Q[offset] + (Q[offset + 1] - Q[offset]) * paired.uniform(channel)
            S[MASS, k] = density * 4.1887902047863905 * S[RADIUS, k] * S[RADIUS, k] * S[RADIUS, k]
    if ti.static(layout.is_scripted):
        born = layout.scripted.birth(own, t, q.scripted)
        position, velocity, others = ti.static(split_born(born))
        x += position
        v += velocity
        for name in ti.static(list(others)):
            S[layout.rows[name], k] = others[name]
    else:
        if ti.static(layout.has_shape):
            x = layout.shape.place(paired, t, q.shape)
        if ti.static(layout.has_velocity):
            v = layout.velocity.velocity(paired, t, q.velocity, x)
        x *= sign
        v *= sign
    for c in ti.static(range(3)):
        S[c, k] = origin[c, o] + x[c]
        S[VX + c, k] = origin[VX + c, o] + v[c]


@cache
def make_birth(signature, precision: str):
    """The kernel of births of one kind that events cause: children, whose keys were found from their parents'.

    signature : a hashable BirthKind (births.py); numbers are never part of the key
    The kernel is birth(S, K, slots (m,) i32, paired (2, m) u32, burst (2, m) u32, ordinal (m,) i32, sign (m,), origin (6, m),
    when (m,), Q).
    paired : key of the stream for what a balanced pair shares
    burst : key of the stream for what a burst shares
    sign : factor of place and velocity, 1 or -1 for the two of a pair, 0 for a particle without a partner
    """
    layout = _layout(signature)
    dtype = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(dtype, 2), ti.types.ndarray(dtype, 1)

    @ti.kernel
    def birth(
        S: matrix, K: WORDS, slots: INTEGERS, paired: WORDS, burst: WORDS, ordinal: INTEGERS, sign: vector, origin: matrix,
        when: vector, Q: vector,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range((slots.shape[0] + BLOCK - 1) // BLOCK):
            q = _numbers(layout, Q)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, slots.shape[0])):
                k = slots[i]
                burst_stream = make_stream(burst[1, i], burst[0, i])
                particle_stream = make_stream(K[1, k], K[0, k], ordinal=ordinal[i], burst=burst_stream)
                paired_stream = make_stream(paired[1, i], paired[0, i], ordinal=ordinal[i], burst=burst_stream)
                _draw(layout, S, Q, q, k, particle_stream, paired_stream, when[i], sign[i], origin, i)

    return runtime.kernel(birth, precision)


@cache
def make_scheduled_birth(signature, precision: str):
    """The kernel of scheduled births of one kind, which finds their keys too and writes all columns of their slots but the id.

    The kernel is scheduled_birth(S, birth, K, source, slots (m,) i32, when (m,) f64, serial (m,) i64, origin (6, m) or (6, 1),
    Q, key, source_index).
    serial : the numbers of the births, which their keys are found from
    key : the emitter's, its bits as an i64
    source_index : what is written to `source`
    """
    layout = _layout(signature)
    dtype = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(dtype, 2), ti.types.ndarray(dtype, 1)

    @ti.kernel
    def scheduled_birth(
        S: matrix, birth: TIMES, K: WORDS, source: INTEGERS, slots: INTEGERS, when: TIMES, serial: SERIALS, origin: matrix,
        Q: vector, key: ti.i64, source_index: ti.i32,
    ):  # fmt: skip
        ti.loop_config(block_dim=1)
        for b in range((slots.shape[0] + BLOCK - 1) // BLOCK):
            q = _numbers(layout, Q)
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, slots.shape[0])):
                k = slots[i]
                own_key = child_key(ti.cast(key, ti.u64), ti.cast(serial[i], ti.u64))
                high, low = ti.cast(own_key >> ti.u64(32), ti.u32), ti.cast(own_key & ti.u64(0xFFFFFFFF), ti.u32)
                birth[k], source[k] = when[i], source_index
                K[0, k], K[1, k] = high, low
                ordinal = ti.cast(serial[i] & ti.i64(0x7FFFFFFF), ti.i32)
                stream = make_stream(low, high, ordinal=ordinal, burst=make_stream(low, high))
                _draw(
                    layout, S, Q, q, k, stream, stream, ti.cast(when[i], dtype), ti.cast(1.0, dtype), origin,
                    ti.min(i, origin.shape[1] - 1),
                )  # fmt: skip

    return runtime.kernel(scheduled_birth, precision)


def _layout(signature) -> _Layout:
    return _Layout(signature.shape, signature.velocity, signature.scripted, signature.attributes, signature.channels)
