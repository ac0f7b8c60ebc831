"""The birth kernel: every attribute of a new particle from its random stream, generated from a shape and a velocity."""

from functools import cache

from gen_art.backend import runtime
from gen_art.backend.kernel_views import parameters, traced
from gen_art.backend.runtime import ti
from gen_art.maths.random import Stream, channel_of
from gen_art.particles.rows import MASS, RADIUS, VX
from gen_art.particles.storage import BASE_ROWS

__all__ = ["SETTABLE", "make_birth"]

SETTABLE = ("radius", "mass", "charge", "lifetime")
_PAIRED = ("radius", "mass", "charge", "density")  # alike for both of a balanced pair, so that momenta cancel
BLOCK = 512


@traced
def stream(low, high, **extra):
    made = Stream(low, high)
    made.__dict__.update(extra)
    return made


@traced
def parts(born):
    """Position, velocity and a dict of the rest, from what a scripted emitter returned."""
    if isinstance(born, dict):
        rest = dict(born)
        return rest.pop("position"), rest.pop("velocity"), rest
    if isinstance(born, (tuple, list)):
        return born[0], born[1], {}
    rest = dict(born.__dict__)
    return rest.pop("position"), rest.pop("velocity"), rest


class _Layout:
    _data_oriented = True

    def __init__(self, place, speed, scripted, attributes, channels):
        self.place, self.speed, self.scripted = place, speed, scripted
        self.is_placed, self.is_moving, self.is_scripted = place is not None, speed is not None, scripted is not None
        self.at_speed = 0 if place is None else sum(s for _, _, s in place.layout())
        numbers = scripted if scripted is not None else None
        self.at_ranges = sum(s for _, _, s in numbers.layout()) if numbers else self.at_speed + self._size(speed)
        # (row, channel, offset of (low, high), paired) of each attribute; density last, with row -1
        self.ranges = [
            (
                -1 if name == "density" else {**BASE_ROWS, **channels}[name],
                channel_of(name),
                self.at_ranges + 2 * k,
                name in _PAIRED,
            )
            for k, name in enumerate(attributes)
        ]
        self.rows = {**BASE_ROWS, **channels}

    @staticmethod
    def _size(thing):
        return 0 if thing is None else sum(s for _, _, s in thing.layout())


@cache
def make_birth(signature, precision: str):
    """The birth kernel of a kind of particle; `signature` is a hashable _Kind (emission.py). Numbers are never in the key.

    birth(S, K, slots (m,) i32, paired (2, m) u32, burst (2, m) u32, ordinal (m,) i32, sign (m,), origin (6, m), when (m,), Q)
    """
    layout = _Layout(signature.shape, signature.velocity, signature.scripted, signature.attributes, signature.channels)
    dtype = runtime.DTYPES[precision]
    matrix, vector = ti.types.ndarray(dtype, 2), ti.types.ndarray(dtype, 1)
    words = ti.types.ndarray(ti.u32, 2)
    whole = ti.types.ndarray(ti.i32, 1)

    @ti.kernel
    def birth(
        S: matrix,
        K: words,
        slots: whole,
        paired: words,
        burst: words,
        ordinal: whole,
        sign: vector,
        origin: matrix,
        when: vector,
        Q: vector,
    ):
        ti.loop_config(block_dim=1)
        for b in range((slots.shape[0] + BLOCK - 1) // BLOCK):
            for i in range(b * BLOCK, ti.min((b + 1) * BLOCK, slots.shape[0])):
                k = slots[i]
                group = stream(burst[1, i], burst[0, i])
                own = stream(K[1, k], K[0, k], ordinal=ordinal[i], burst=group)
                pair = stream(paired[1, i], paired[0, i], ordinal=ordinal[i], burst=group)
                t = when[i]
                x = ti.Vector([0.0, 0.0, 0.0])
                v = ti.Vector([0.0, 0.0, 0.0])
                for row, channel, at, is_paired in ti.static(layout.ranges):
                    if ti.static(row >= 0):
                        low, high = Q[at], Q[at + 1]
                        value = low
                        if high != low:  # an infinite lifetime must not meet the arithmetic of a range
                            if ti.static(is_paired):
                                value = low + (high - low) * pair.uniform(channel)
                            else:
                                value = low + (high - low) * own.uniform(channel)
                        S[row, k] = value
                for row, channel, at, is_paired in ti.static(layout.ranges):
                    if ti.static(row < 0):
                        density = Q[at] + (Q[at + 1] - Q[at]) * pair.uniform(channel)
                        S[MASS, k] = density * 4.1887902047863905 * S[RADIUS, k] * S[RADIUS, k] * S[RADIUS, k]
                if ti.static(layout.is_scripted):
                    born = layout.scripted.birth(own, t, parameters(Q, layout.scripted, 0))
                    where, speed, rest = ti.static(parts(born))
                    x += where
                    v += speed
                    for name in ti.static(list(rest)):
                        S[layout.rows[name], k] = rest[name]
                else:
                    if ti.static(layout.is_placed):
                        x = layout.place.place(pair, t, parameters(Q, layout.place, 0))
                    if ti.static(layout.is_moving):
                        v = layout.speed.velocity(pair, t, parameters(Q, layout.speed, layout.at_speed), x)
                    x *= sign[i]
                    v *= sign[i]
                for c in ti.static(range(3)):
                    S[c, k] = origin[c, i] + x[c]
                    S[VX + c, k] = origin[VX + c, i] + v[c]

    return runtime.kernel(birth, precision)
