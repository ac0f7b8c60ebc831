"""The arguments `p` and `q` of a force in a kernel: Python objects that exist while Taichi traces and hold expressions.

A `KernelView` passes through ti.func calls by reference. `parameters(Q, term, offset)` is the view `q` of one term's slice of
the run-time parameter array; values that are fixed when the kernel is traced (choices, flags) are Python constants in it;
`q.table(k)` reads the table of a class that has one.
"""

from gen_art.backend.runtime import impl, make_matrix, ti

Expr = ti.lang.expr.Expr

__all__ = ["KernelView", "held_parameters", "parameters", "particle", "traced"]


class KernelView:
    """An object whose attributes are looked up while Taichi traces."""

    _data_oriented = True

    def __init__(self, **attributes):
        self.__dict__.update(attributes)


def traced(function):
    """Mark a plain Python function that is called while tracing, so that Taichi does not warn about it."""
    function._is_wrapped_kernel = True
    return function


@traced
def parameters(array, term, offset: int, index=0):
    """The view `q` of a term: its run-time numbers at `array[offset:]`, its fixed values, and the index of its repeat."""

    def at(k):
        return impl.subscript(None, array, k)

    view = {"index": index}
    for name, start, size in term.layout():
        first = offset + start
        kind = term.parameters[name].kind
        if size == 1:
            view[name] = ti.cast(at(first), ti.i32) if kind == "int" else at(first)
        else:
            view[name] = make_matrix([at(first + c) for c in range(size)])
    if term.tabled:
        place = offset + sum(size for _, _, size in term.layout())
        start = ti.cast(at(place), ti.i32) * 4096 + ti.cast(at(place + 1), ti.i32)
        view["table"] = traced(lambda k: at(start + k))
    for name, parameter in term.parameters.items():
        if not parameter.size:
            view[name] = term.values[name]
    return KernelView(**view)


@traced
def held_parameters(array, term, offset: int):
    """`parameters`, read once: what follows from them alone is then found once for all turns of a loop."""
    view = parameters(array, term, offset)
    held = {
        name: impl.expr_init(value) for name, value in view.__dict__.items() if isinstance(value, (Expr, ti.Matrix))
    }
    return KernelView(**{**view.__dict__, **held})


@traced
def particle(**attributes):
    """The view `p` of one particle."""
    return KernelView(**attributes)
