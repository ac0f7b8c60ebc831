"""A faster launch of kernels than that of Taichi 1.7.4. It does not change what a launch computes.

At every launch Taichi checks the type of every argument, builds a dozen helper objects and asks its cache for the kernel. This
takes 0.12 ms for a dozen arguments, several times the run time of a small kernel. Here Taichi does the first launch with arrays
of given types, with all its checks. Later launches pass only pointers, shapes and numbers, and of these only what has changed
since the kernel's latest launch.
GEN_ART_STOCK_TAICHI=1 switches it off: Taichi then does every launch.
"""

import weakref
from typing import Any

import taichi as ti
from taichi.lang import impl
from taichi.lang.matrix import MatrixType
from taichi.types import primitive_types
from taichi.types.ndarray_type import NdarrayType

__all__ = ["launch_without_repeats"]


def launch_without_repeats(primal, function, compiling):
    """A function that launches the kernel `function`, faster from the second call with arrays of the same types on.

    primal : Taichi's object of the kernel
    compiling : returns the context manager in which Taichi may compile
    The result has an attribute `bound(*args)`: a function without arguments that launches the kernel with `args`, which are
    passed to Taichi once. Raises ValueError for an array of vectors whose address is not aligned for vector loads.
    """
    name = primal.func.__name__
    annotations = [argument.annotation for argument in primal.arguments]
    kinds = [_kind(annotation) for annotation in annotations]
    plain = primal.return_type is None and None not in kinds
    arrays = [(k, _lanes(annotations[k])) for k, kind in enumerate(kinds) if kind == "array"]
    integers = [k for k, kind in enumerate(kinds) if kind == "integer"]
    floats = [k for k, kind in enumerate(kinds) if kind == "float"]
    known: dict[tuple, tuple[Any, Any, Any]] = {}  # by types of the arrays: compiled kernel, program, its data
    latest: list[_Launch] = []

    def prepared(args) -> _Launch:
        """The launch with these arguments, after Taichi has launched the kernel with arrays of the same types."""
        launch = _Launch(name, *known[_types(arrays, args)], arrays, integers, floats)
        launch.pass_arguments(args)
        return launch

    def launch(*args):
        # taken out while it is used: another thread may launch the same kernel
        one = latest.pop() if latest else None
        if one is None or not one.takes(args):
            for k, lanes in arrays:
                _check_alignment(name, k, args[k], lanes)
            types = _types(arrays, args)
            if types not in known or not all(args[k].flags.c_contiguous for k, _ in arrays):
                with compiling():
                    result = function(*args)
                    if plain:
                        compiled = primal.compiled_kernels[primal.ensure_compiled(*args)]
                        program = impl.get_runtime().prog
                        data = program.compile_kernel(program.config(), program.get_device_caps(), compiled)
                        known[types] = compiled, program, data
                return result
            one = _Launch(name, *known[types], arrays, integers, floats)
        one.pass_arguments(args)
        one()
        latest[:] = [one]
        return None

    def bound(*args):
        ready: list[_Launch] = []

        def launch_again():
            if ready:
                ready[0]()
                return
            launch(*args)
            ready.append(prepared(args))

        return launch_again

    vars(launch)["bound"] = bound
    return launch


class _Launch:
    """A launch of a compiled kernel, with the arguments that Taichi has of it.

    arrays : (number of the argument, lanes of its vectors or 0); integers, floats : numbers of the arguments
    """

    def __init__(self, name: str, compiled, program, data, arrays: list, integers: list, floats: list):
        self._name, self._program, self._data = name, program, data
        self._arrays, self._integers, self._floats = arrays, integers, floats
        self._context = compiled.make_launch_context()
        self._types: tuple = ()
        self._passed: list = [None] * len(arrays)  # weak references: a launch keeps no array alive
        self._whole = [None] * len(integers)

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
        context = self._context
        if not self._types:
            self._types = _types(self._arrays, args)
        for n, (k, lanes) in enumerate(self._arrays):
            array, passed = args[k], self._passed[n]
            if passed is None or passed() is not array:
                self._passed[n] = None
                _check_alignment(self._name, k, array, lanes)
                pointer, shape = array.__array_interface__["data"][0], array.shape
                context.set_arg_external_array_with_shape(
                    (k,), pointer, array.nbytes, shape[:-1] if lanes else shape, 0
                )
                self._passed[n] = weakref.ref(array)
        for n, k in enumerate(self._integers):
            if self._whole[n] != args[k]:
                context.set_arg_int((k,), args[k])
                self._whole[n] = args[k]
        for k in self._floats:
            context.set_arg_float((k,), args[k])

    def __call__(self) -> None:
        self._program.launch_kernel(self._data, self._context)


def _types(arrays: list, args) -> tuple:
    """What Taichi compiles a kernel for, of each array."""
    return tuple([(type(args[k]), args[k].dtype, args[k].ndim) for k, _ in arrays])


def _check_alignment(name: str, k: int, array, lanes: int) -> None:
    """Raise ValueError if argument k of a kernel, an array of vectors, cannot be loaded by whole vectors."""
    if lanes and array.ctypes.data % (lanes * array.itemsize):
        raise ValueError(f"argument {k} of {name}: vectors need an array from runtime.aligned")


def _kind(annotation) -> str | None:
    """How an argument is passed; None if only Taichi's launch can pass it."""
    if isinstance(annotation, NdarrayType):
        return "array"
    if id(annotation) in primitive_types.real_type_ids:
        return "float"
    return "integer" if annotation in (ti.i32, ti.i64) else None


def _lanes(annotation) -> int:
    """The number of components in an array of vectors; 0 in an array of numbers."""
    return annotation.dtype.n if isinstance(annotation.dtype, MatrixType) else 0
