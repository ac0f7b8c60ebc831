"""Functions of large arrays, evaluated block by block: what they compute on the way stays in the processor's cache."""

import math
from collections.abc import Callable
from functools import wraps

import numpy as np

__all__ = ["in_blocks"]

_BLOCK = 1 << 14  # numbers


def in_blocks(function: Callable) -> Callable:
    """The same function of numbers and arrays of one shape, each of whose results depends on one place of the arrays alone."""

    @wraps(function)
    def whole(*arguments):
        arrays = [np.asarray(argument) for argument in arguments]
        n = max(array.size for array in arrays)
        if n <= _BLOCK:
            return function(*arguments)
        shape = max((array.shape for array in arrays), key=len)
        if n != math.prod(shape) or any(array.size > 1 and array.shape != shape for array in arrays):
            return function(*arguments)
        flat = [array.reshape(-1) for array in arrays]
        result = None
        for first in range(0, n, _BLOCK):
            some = slice(first, first + _BLOCK)
            part = function(*(array if array.size == 1 else array[some] for array in flat))
            if result is None:
                result = np.empty(n, part.dtype)
            result[some] = part
        assert result is not None
        return result.reshape(shape)

    return whole
