"""The contracts of a birth: where a particle is born (a shape), how fast (a velocity), or both (an emitter)."""

from collections.abc import Callable, Mapping
from typing import ClassVar

import numpy as np

from gen_art import arguments
from gen_art.errors import GenArtError, UsageError
from gen_art.kernel_methods import check_kernel_methods
from gen_art.maths.random import derive
from gen_art.registry import Parametric, Registry

__all__ = [
    "EMITTERS",
    "SHAPES",
    "VELOCITIES",
    "Emitter",
    "Shape",
    "Velocity",
    "emitter",
    "sampled",
    "shape",
    "velocity",
]

SHAPES = Registry("shape")
VELOCITIES = Registry("velocity")
EMITTERS = Registry("emitter")
shape, velocity, emitter = SHAPES, VELOCITIES, EMITTERS


class _Birth(Parametric):
    kernel_methods: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, **kwargs):
        super().__init_subclass__(**kwargs)
        check_kernel_methods(cls, cls.kernel_methods)

    @property
    def fixed(self) -> tuple:
        """What the birth kernel is compiled for: the class and its choices. Numbers are never part of it."""
        values = tuple((k, self.values[k]) for k, p in self.parameters.items() if p.kind in ("bool", "choice", "text"))
        return (type(self), values)


class Shape(_Birth):
    """Where particles are born, relative to the emitter's origin.

    `place(self, r, t, q)` is a @ti.func that returns (3,) m.
    """

    kernel_methods = ("place",)


class Velocity(_Birth):
    """The velocity at birth, relative to the emitter's.

    `velocity(self, r, t, q, x)` is a @ti.func that returns (3,) m/s.
    x : the place of birth relative to the origin, m
    r.ordinal : the number of the particle in its burst
    r.burst : the random stream of the burst
    """

    kernel_methods = ("velocity",)


class Emitter(_Birth):
    """A whole birth in one place: either `birth`, or `sample` for initial conditions.

    birth(self, r, t, q) : a @ti.func that returns (position, velocity), or a dict that also sets mass, charge, radius, lifetime
        or declared attributes
    sample(self, r, n) : NumPy, returns a dict of arrays; r.uniform(channel), r.normal(channel) and r.sphere(channel) give one
        value for each of the n particles. NaN leaves the value that the preset gives
    declares : attributes that its particles have without the preset naming them
    shares_mass : whether its particles share a mass that is given, so that fewer of them attract as much
    """

    kernel_methods = ("birth",)
    sample: ClassVar[Callable | None] = None
    shares_mass: ClassVar[bool] = False
    declares: ClassVar[tuple[str, ...]] = ()

    def arrays(self, count: int, seed: int = 0) -> dict[str, np.ndarray]:
        """Initial conditions for `ga.ParticleSystem(**emitter.arrays(1000))`, of a class with `sample`.

        count : number of particles, at least 1
        seed : selects another sample
        Returns position and velocity, (count, 3), and the other attributes that `sample` sets, (count,).
        Raises UsageError where the class has no `sample`.
        """
        from gen_art.emitters.births import BatchStreams  # which imports this module

        if self.sample is None:
            raise UsageError(f"{type(self).__name__} makes its particles one by one, in a kernel: use it in a preset")
        count = arguments.whole("count", count, 1)
        keys = derive(np.uint64(arguments.whole("seed", seed, 0)), np.arange(count))
        return {name: values.T.copy() for name, values in sampled(self, BatchStreams(keys), count).items()}


def sampled(scripted: Emitter, draws, count: int, who: str = "") -> dict[str, np.ndarray]:
    """What the `sample` of an emitter gives for `count` particles: (3, count) position and velocity, (count,) others, float64.

    draws : what it calls r
    who : how the sentences of errors begin
    Raises UsageError where it fails, and for anything else that it gives.
    """
    assert scripted.sample is not None, "only a class with `sample` is called here"
    name = f"{who}`sample` of {type(scripted).__name__}"
    try:
        born = scripted.sample(draws, count)
    except (GenArtError, MemoryError):
        raise
    except Exception as error:
        raise UsageError(f"{name} fails: {type(error).__name__}: {error}") from error
    if not isinstance(born, Mapping):
        raise UsageError(f"{name} must return a dict of arrays, not {arguments.shown(born)}")
    checked = {}
    for key, given in born.items():
        shape = (3, count) if key in ("position", "velocity") else (count,)
        try:
            values = np.asarray(given, np.float64)
        except (TypeError, ValueError):
            raise UsageError(f"{name} gives {key} as {arguments.shown(given)}, not as numbers") from None
        if values.ndim > len(shape) or (len(shape) == 2 and values.ndim < 2) or not _fits(values, shape):
            raise UsageError(f"{name} gives {key} as an array of shape {values.shape}, not {shape}")
        checked[key] = np.broadcast_to(values, shape)
    return checked


def _fits(values: np.ndarray, shape: tuple[int, ...]) -> bool:
    """Whether each length is that of the shape, or 1 for all."""
    return all(n in (1, wanted) for n, wanted in zip(values.shape[::-1], shape[::-1]))
