"""Particles to draw, without a simulation: what the renderer reads of one, filled from arrays."""

from types import SimpleNamespace

import numpy as np

from gen_art.particles.storage import PADDING as SPARE


def state(position, velocity=None, *, mass=1.0, charge=0.0, radius=0.01, life=np.inf, birth=0.0, tags=(None,), source=0,
          attributes=None, dtype=np.float32):  # fmt: skip
    """Storage of n particles with unused slots behind them, as a tile may read past the end."""
    position = np.asarray(position, dtype=np.float64).reshape(-1, 3)
    n, attributes = len(position), attributes or {}
    floats = np.zeros((10 + len(attributes), n + SPARE), dtype)
    floats[:3, :n] = position.T
    if velocity is not None:
        floats[3:6, :n] = np.asarray(velocity, dtype=np.float64).reshape(-1, 3).T
    for row, value in ((6, mass), (7, charge), (8, radius), (9, life)):
        floats[row, :n] = value
    for row, value in enumerate(attributes.values(), start=10):
        floats[row, :n] = value
    births, sources = np.zeros(n + SPARE), np.zeros(n + SPARE, np.int32)
    births[:n], sources[:n] = birth, source
    return SimpleNamespace(
        floats=floats, birth=births, key=np.random.default_rng(1).integers(0, 2**32, (2, n + SPARE), dtype=np.uint32),
        id=np.arange(n + SPARE), source=sources, sources=[SimpleNamespace(name=str(t), tag=t) for t in tags], count=n,
        channels={name: 10 + k for k, name in enumerate(attributes)}, box=None, entries=(), booked=np.zeros((0, n + SPARE)),
    )  # fmt: skip


def scene(time=0.0, **systems):
    """What the renderer reads of a simulation."""
    members = {name: SimpleNamespace(look=None, colliders=()) for name in systems}
    return SimpleNamespace(time=time, systems=systems, members=members, preset=None)
