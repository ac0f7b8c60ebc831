"""Checks of the kernel methods of a class that a user has written, from their source, before anything is compiled.

A compiler's error comes late, is long and names the compiler's own files; random numbers that are not a function of a
particle's key would make every run another one.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable, Collection, Iterator

from gen_art.errors import UsageError
from gen_art.registry import suggest

__all__ = ["PARTICLE", "attributes_read", "check_kernel_methods", "is_own"]

PARTICLE = {  # what every particle has
    "position", "velocity", "mass", "charge", "radius", "age", "lifetime", "key", "flow", "since", "step",
}  # fmt: skip
_INDEX = {"index", "table"}  # what q has beside the parameters
_RANDOM_MODULES = ("taichi", "numpy", "random", "gen_art")


def is_own(cls: type) -> bool:
    """Whether a class is one of Gen Art, which tests check."""
    return cls.__module__.startswith("gen_art.")


def check_kernel_methods(cls: type, names: tuple[str, ...]) -> None:
    """Check the methods of these names that a user's class itself defines.

    Raises UsageError for a method without @ti.func, for random numbers that are not a function of the particle's key, and for
    `q.name` where no parameter has that name.
    """
    for name in () if is_own(cls) else names:
        method = cls.__dict__.get(name)
        if not callable(method):
            continue
        where = f"{cls.__name__}.{name}"
        if not getattr(method, "_is_taichi_function", False) and not getattr(method, "_is_real_function", False):
            raise UsageError(f"{where} runs in a kernel: write @ti.func above it")
        source = inspect.unwrap(method)
        if drawn := _random_name(source, set()):
            raise UsageError(
                f"{where} calls {drawn}, whose numbers differ from run to run: make them from p.key, or use the forces langevin, "
                "random_driver or curl_noise"
            )
        parameters = list(getattr(cls, "parameters", {}))
        for read in _attributes_of(source, "q"):
            if read not in (*parameters, *_INDEX):
                raise UsageError(
                    f"{where} reads q.{read}, but {cls.__name__} has the parameters {', '.join(parameters) or '(none)'}"
                    f"{suggest(read, parameters)}"
                )


def attributes_read(
    cls: type, names: tuple[str, ...], particles: tuple[str, ...] = ("p",), but: Collection[str] = PARTICLE
) -> dict[str, str]:
    """The attributes other than those in `but` that these methods read of their arguments `particles`: {attribute: method}."""
    found: dict[str, str] = {}
    for name in names:
        method = getattr(cls, name, None)
        if callable(method):
            source = inspect.unwrap(method)
            found |= {read: name for p in particles for read in _attributes_of(source, p) if read not in but}
    return found


def _random_name(function: Callable, seen: set) -> str | None:
    """The name by which a function, or one that it calls, draws random numbers; None if it does not."""
    code = getattr(function, "__code__", None)
    if code is None or code in seen:
        return None
    seen.add(code)
    names = {name: function.__globals__.get(name) for name in code.co_names}
    modules = [used.__name__.split(".")[0] for used in names.values() if inspect.ismodule(used)]
    for name, used in names.items():
        from_module = (getattr(used, "__module__", None) or "").split(".")[0] in _RANDOM_MODULES
        by_module = (used is None or inspect.ismodule(used)) and any(m in _RANDOM_MODULES for m in modules)
        if name in ("random", "randn") and (from_module or by_module):
            return name
        if callable(used) and not from_module and (found := _random_name(inspect.unwrap(used), seen)):
            return found
    return None


def _attributes_of(function: Callable, argument: str) -> Iterator[str]:
    """The names of the attributes that a function reads of one of its arguments; none if its source is not known."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef) or argument not in [a.arg for a in definition.args.args]:
        return
    for node in ast.walk(definition):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == argument:
            yield node.attr
