"""A faster start and launch of kernels than those of Taichi 1.7.4. Neither changes what a launch computes.

In each process Taichi traces every kernel anew, and makes machine code of it, which takes seconds. Here the machine code is kept
under a key of all that it depends on (fingerprint.py), so that a later process loads it.

At every launch Taichi checks the type of every argument, builds a dozen helper objects and asks its cache for the kernel. This
takes 0.12 ms for a dozen arguments, several times the run time of a small kernel. Here Taichi checks the arguments when it
compiles the kernel for arrays of given types. Launches pass only pointers, shapes and numbers, and of these only what has changed
since the kernel's latest launch with the same first array.
GEN_ART_STOCK_TAICHI=1 switches it off, and it is off where machine_code.py does not work: Taichi then does every launch.
"""

import contextlib
import ctypes
import hashlib
import os
import sys
import time
import weakref
from collections import OrderedDict
from collections.abc import Callable
from typing import Any

import numpy as np
import taichi as ti
from taichi.lang import impl
from taichi.lang.matrix import MatrixType
from taichi.types.ndarray_type import NdarrayType

from gen_art.backend import machine_code
from gen_art.backend.fingerprint import Unknown, fingerprint
from gen_art.backend.kernel_store import KernelStore

__all__ = ["launch_without_repeats"]

_FORMAT = 1  # of what is kept; part of every key
_STARTED = time.time()
_KEPT_LAUNCHES = 16  # of a kernel, with the arguments that were passed


def launch_without_repeats(primal, function, compiling, settings: tuple, store: Callable[[], KernelStore]):
    """A function that launches the kernel `function`, faster from the second call with arrays of the same types on.

    primal : Taichi's object of the kernel
    compiling : returns the context manager in which Taichi may compile
    settings : what the machine code depends on beside the kernel and Taichi's options; store : returns where it is kept
    The result has an attribute `bound(*args)`: a function without arguments that launches the kernel with `args`, which are
    passed once. Raises ValueError for an array of vectors whose address is not aligned for vector loads.
    """
    name = primal.func.__name__
    annotations = [argument.annotation for argument in primal.arguments]
    kinds = [_kind(annotation) for annotation in annotations]
    plain = primal.return_type is None and None not in kinds
    arrays = [(k, _lanes(annotations[k])) for k, kind in enumerate(kinds) if kind is _ARRAY]
    numbers = [k for k, kind in enumerate(kinds) if kind is not _ARRAY]
    known: dict[tuple, tuple] = {}  # the kernel's tasks and the structure of its arguments, by types of the arrays
    first_array = arrays[0][0] if arrays else None
    recent: OrderedDict[int, _Launch] = OrderedDict()  # by the first array: systems of one kernel take turns

    def tasks_for(args, types: tuple) -> tuple[list, type[ctypes.Structure]]:
        """The kernel's tasks for arrays of these types, from the store or compiled by Taichi, and what they get."""
        place, key = store(), _key(primal.func, types, settings)
        code = place.find(key) if key else None
        if code is None:
            with compiling():
                compiled = machine_code.intermediate(primal.compiled_kernels[primal.ensure_compiled(*args)])
            key = key or compiled.digest()
            code = place.find(key)
            if code is None:
                code = machine_code.emit(compiled)
                place.keep(key, code)
        return machine_code.load(code), _structure(kinds, arrays, types)

    def launch(*args):
        place = 0 if first_array is None else id(args[first_array])
        one = recent.pop(place, None)  # taken out while it is used: another thread may launch the same kernel
        if one is None and len(recent) >= _KEPT_LAUNCHES:
            with contextlib.suppress(KeyError):  # other threads use all of them
                _, one = recent.popitem(last=False)
        if one is None or not one.takes(args):
            for k, lanes in arrays:
                _check_alignment(name, k, args[k], lanes)
            types = _types(arrays, args)
            usual = plain and all(kind is np.ndarray for kind, _, _ in types) and _contiguous(arrays, args)
            if not usual or not machine_code.available():
                with compiling():
                    return function(*args)
            if types not in known:
                known[types] = tasks_for(args, types)
            one = _Launch(name, *known[types], arrays, numbers)
        one.pass_arguments(args)
        one()
        recent[place] = one
        return None

    def bound(*args):
        ready: list[_Launch] = []

        def launch_again():
            if ready:
                ready[0]()
                return
            launch(*args)
            found = known.get(_types(arrays, args))
            if found is not None:
                ready.append(_Launch(name, *found, arrays, numbers))
                ready[0].pass_arguments(args)

        return launch_again

    vars(launch)["bound"] = bound
    vars(launch)["variants"] = known
    return launch


def _key(function, types: tuple, settings: tuple) -> str | None:
    """The key of a kernel's machine code; None where it reaches what has no digest, as code of a user has none."""
    try:
        reached = fingerprint(function)
    except Unknown:
        return None
    if not all(_is_as_loaded(file) for file in reached.files):
        return None
    config = impl.get_runtime().prog.config()
    options = [(name, getattr(config, name)) for name in dir(config) if not name.startswith(("_", "offline_cache"))]
    options = [(name, value) for name, value in options if isinstance(value, int | float | str)]
    arrays = [(str(dtype), ndim) for _, dtype, ndim in types]
    words = _FORMAT, ti.__version__, sys.implementation.cache_tag, options, settings, arrays, reached.digest
    return hashlib.sha256(repr(words).encode()).hexdigest()


def _is_as_loaded(file: str) -> bool:
    """Whether a source file is older than this process: Taichi reads what it says now, the digest is of what was loaded."""
    try:
        return os.stat(file).st_mtime < _STARTED
    except OSError:
        return False


class _Launch:
    """A launch of a compiled kernel, with the arguments that were passed to it.

    arrays : (number of the argument, lanes of its vectors or 0); numbers : numbers of the other arguments
    """

    def __init__(self, name: str, tasks: list, structure: type[ctypes.Structure], arrays: list, numbers: list):
        self._name, self._tasks, self._structure = name, tasks, structure
        self._arrays, self._numbers = arrays, [(k, f"_{k}") for k in numbers]
        self._types: tuple = ()
        self._passed: list = [None] * len(arrays)  # weak references: a launch keeps no array alive

    def takes(self, args) -> bool:
        """Whether arrays of these types can be passed to this launch."""
        for n, (k, _) in enumerate(self._arrays):
            array = args[k]
            passed = self._passed[n]
            if (passed is None or passed() is not array) and (
                (type(array), array.dtype, array.ndim) != self._types[n] or not array.flags.c_contiguous
            ):
                return False
        return True

    def pass_arguments(self, args) -> None:
        """Pass the arrays that are not those of the launch before, and the numbers.

        Raises ValueError for an array of vectors whose address is not aligned.
        """
        if not self._types:
            self._types = _types(self._arrays, args)
            self._arguments = self._structure()
            self._context = machine_code.context_of(self._arguments)
            self._address = ctypes.addressof(self._context)
        for n, (k, lanes) in enumerate(self._arrays):
            array, passed = args[k], self._passed[n]
            if passed is None or passed() is not array:
                self._passed[n] = None
                _check_alignment(self._name, k, array, lanes)
                argument = getattr(self._arguments, f"_{k}")
                argument.shape[:] = array.shape[:-1] if lanes else array.shape
                argument.data = array.__array_interface__["data"][0]
                self._passed[n] = weakref.ref(array)
        for k, field in self._numbers:
            setattr(self._arguments, field, args[k])

    def __call__(self) -> None:
        for task in self._tasks:
            task(self._address)


def _structure(kinds: list, arrays: list, types: tuple) -> type[ctypes.Structure]:
    """The C structure in which a kernel gets its arguments; that of an array has its shape and its address."""
    fields: list[Any] = list(kinds)
    for (k, lanes), (_, _, ndim) in zip(arrays, types, strict=True):
        shape = ctypes.c_int32 * (ndim - 1 if lanes else ndim)
        fields[k] = type("Array", (ctypes.Structure,), {"_fields_": (("shape", shape), ("data", ctypes.c_void_p))})
    return type("Arguments", (ctypes.Structure,), {"_fields_": [(f"_{k}", field) for k, field in enumerate(fields)]})


def _contiguous(arrays: list, args) -> bool:
    return all(args[k].flags.c_contiguous for k, _ in arrays)


def _types(arrays: list, args) -> tuple:
    """What Taichi compiles a kernel for, of each array."""
    return tuple([(type(args[k]), args[k].dtype, args[k].ndim) for k, _ in arrays])


def _check_alignment(name: str, k: int, array, lanes: int) -> None:
    """Raise ValueError if argument k of a kernel, an array of vectors, cannot be loaded by whole vectors."""
    if lanes and array.ctypes.data % (lanes * array.itemsize):
        raise ValueError(f"argument {k} of {name}: vectors need an array from runtime.aligned")


_ARRAY = object()
_NUMBERS = {
    id(ti.i32): ctypes.c_int32,
    id(ti.i64): ctypes.c_int64,
    id(ti.f32): ctypes.c_float,
    id(ti.f64): ctypes.c_double,
}


def _kind(annotation):
    """How an argument is passed: an array, or a number's C type; None if only Taichi's launch can pass it."""
    return _ARRAY if isinstance(annotation, NdarrayType) else _NUMBERS.get(id(annotation))


def _lanes(annotation) -> int:
    """The number of components in an array of vectors; 0 in an array of numbers."""
    return annotation.dtype.n if isinstance(annotation.dtype, MatrixType) else 0
