"""Taichi (1.7.4, which is pinned) hands a kernel its arguments one by one through Python; this spares it what repeats.

Taichi looks at the type of every argument, builds a dozen helpers and asks its cache for the kernel at every launch: with a
dozen arguments that takes 0.12 ms, several times what a small kernel computes. Here the first launch with arrays of some types is
Taichi's own, with all its checks; later ones hand over pointers, shapes and numbers alone, in 0.05 ms.
"""

import taichi as ti
from taichi.lang import impl
from taichi.lang.matrix import MatrixType
from taichi.types import primitive_types
from taichi.types.ndarray_type import NdarrayType

__all__ = ["lean"]


def lean(primal, function, compiling):
    """The kernel `function`, whose inside is `primal`, to be called more quickly once it has run with such arrays.

    compiling : gives the context in which Taichi may compile
    Its `bound(*args)` is a function that launches it with these arguments, which are handed over but once.
    Raises ValueError for an array of vectors at an address that they cannot be loaded from.
    """
    annotations = [argument.annotation for argument in primal.arguments]
    kinds = [_kind(annotation) for annotation in annotations]
    plain = primal.return_type is None and None not in kinds
    arrays = [(k, _lanes(annotations[k])) for k, kind in enumerate(kinds) if kind == "array"]
    vectors = [(k, lanes) for k, lanes in arrays if lanes]
    integers = [(k, (k,)) for k, kind in enumerate(kinds) if kind == "integer"]
    floats = [(k, (k,)) for k, kind in enumerate(kinds) if kind == "float"]
    known: dict[tuple, tuple] = {}

    def signature(args) -> tuple:
        return tuple([(type(args[k]), args[k].dtype, args[k].ndim) for k, _ in arrays])

    def handed(compiled, args):
        context = compiled.make_launch_context()
        for k, lanes in arrays:
            array = args[k]
            pointer, shape = array.__array_interface__["data"][0], array.shape
            context.set_arg_external_array_with_shape((k,), pointer, array.nbytes, shape[:-1] if lanes else shape, 0)
        for k, slot in integers:
            context.set_arg_int(slot, args[k])
        for k, slot in floats:
            context.set_arg_float(slot, args[k])
        return context

    def launch(*args):
        for k, lanes in vectors:
            if args[k].ctypes.data % (lanes * args[k].itemsize):
                raise ValueError(f"argument {k} of {primal.func.__name__}: vectors need an array from runtime.aligned")
        types = signature(args)
        found = known.get(types)
        if found is None or not all(args[k].flags.c_contiguous for k, _ in arrays):
            with compiling():
                result = function(*args)
                if plain:
                    compiled = primal.compiled_kernels[primal.ensure_compiled(*args)]
                    program = impl.get_runtime().prog
                    data = program.compile_kernel(program.config(), program.get_device_caps(), compiled)
                    known[types] = compiled, program, data
            return result
        compiled, program, data = found
        program.launch_kernel(data, handed(compiled, args))
        return None

    def bound(*args):
        launches: list = []

        def again():
            if launches:
                program, data, context, _ = launches[0]
                program.launch_kernel(data, context)
                return
            launch(*args)
            compiled, program, data = known[signature(args)]
            launches.append((program, data, handed(compiled, args), args))  # the arrays live as long

        return again

    vars(launch)["bound"] = bound
    return launch


def _kind(annotation) -> str | None:
    """How an argument is handed over; None where Taichi's own way is needed."""
    if isinstance(annotation, NdarrayType):
        return "array"
    if id(annotation) in primitive_types.real_type_ids:
        return "float"
    return "integer" if annotation in (ti.i32, ti.i64) else None


def _lanes(annotation) -> int:
    """The numbers of each vector in an array of vectors; 0 in one of numbers."""
    return annotation.dtype.n if isinstance(annotation.dtype, MatrixType) else 0
