"""A faster launch of kernels than that of Taichi 1.7.4. It does not change what a launch computes.

At every launch Taichi checks the type of every argument, builds a dozen helper objects and asks its cache for the kernel. This
takes 0.12 ms for a dozen arguments, several times the run time of a small kernel. Here Taichi does the first launch with arrays
of given types, with all its checks; later launches pass only pointers, shapes and numbers, in 0.05 ms.
GEN_ART_STOCK_TAICHI=1 switches it off: Taichi then does every launch.
"""

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

    def launch_context(compiled, args):
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
        compiled_before = known.get(types)
        if compiled_before is None or not all(args[k].flags.c_contiguous for k, _ in arrays):
            with compiling():
                result = function(*args)
                if plain:
                    compiled = primal.compiled_kernels[primal.ensure_compiled(*args)]
                    program = impl.get_runtime().prog
                    data = program.compile_kernel(program.config(), program.get_device_caps(), compiled)
                    known[types] = compiled, program, data
            return result
        compiled, program, data = compiled_before
        program.launch_kernel(data, launch_context(compiled, args))
        return None

    def bound(*args):
        prepared: list = []

        def launch_again():
            if prepared:
                program, data, context, _ = prepared[0]
                program.launch_kernel(data, context)
                return
            launch(*args)
            compiled, program, data = known[signature(args)]
            prepared.append((program, data, launch_context(compiled, args), args))  # args: keeps the arrays alive

        return launch_again

    vars(launch)["bound"] = bound
    return launch


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
