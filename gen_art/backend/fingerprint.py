"""A digest of all that the trace of a kernel depends on: its code, and the code and the values that it reaches.

Kernels with the same digest, launched with arrays of the same types under the same settings, are the same machine code.
A function is known by its bytecode and by what its closure and the globals that it names hold; an object by its class, the
methods and attributes of that, and its own attributes, or only its attribute `fixed` if it has one: forces, colliders and
emitters have many numbers, which kernels read when they run. What cannot be known so (code of other packages than those below,
open files, locks) raises `Unknown`.
"""

import hashlib
import re
import sys
import types
from collections import OrderedDict, defaultdict, namedtuple
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cache, partial
from operator import attrgetter, itemgetter
from pathlib import Path

import numpy as np

__all__ = ["Fingerprint", "Unknown", "fingerprint"]

OWN = "gen_art"  # the package whose code is read
# packages whose code goes by its name; a key of machine code contains the versions of Python and Taichi
FIXED = sys.stdlib_module_names | {
    "taichi",
    "numpy",
    "pydantic",
    "pydantic_core",
    "annotated_types",
    "typing_extensions",
}
_PLAIN = (int, float, complex, str, bytes, bool, type(None), type(Ellipsis))
_MAPPINGS = (dict, OrderedDict, defaultdict, types.MappingProxyType)
_DESCRIPTORS = (
    types.MemberDescriptorType,
    types.GetSetDescriptorType,
    types.WrapperDescriptorType,
    type(vars(namedtuple("_Pair", "a b"))["a"]),
)


class Unknown(Exception):
    """The kernel reaches something that has no digest."""


@dataclass(frozen=True)
class Fingerprint:
    """digest : of all that was reached; files : the source files of the functions among it that Taichi reads."""

    digest: str
    files: frozenset[str]


def fingerprint(function) -> Fingerprint:
    """The digest of a plain function and of all that it reaches. Raises Unknown."""
    walk = _Walk()
    walk.reach(function)
    return Fingerprint(walk.hash.hexdigest(), frozenset(walk.files))


def _root(name: str | None) -> str:
    return (name or "").partition(".")[0]


class _Walk:
    """Visits objects depth first, and adds what each of them is to the hash."""

    def __init__(self):
        self.hash = hashlib.blake2b(digest_size=32)
        self.files: set[str] = set()
        self._numbers: dict[int, int] = {}  # of the objects that were visited, by id
        self._visited: list = []  # keeps them alive, and so their ids unique
        self._looked_up: set[tuple[str, tuple[str, ...]]] = set()  # modules, and the names looked up in them

    def _say(self, *words) -> None:
        self.hash.update(repr(words).encode())

    def _is_new(self, thing) -> bool:
        """Whether the thing was not visited before; if it was, its number is added to the hash."""
        number = self._numbers.setdefault(id(thing), len(self._visited))
        if number < len(self._visited):
            self._say("again", number)
            return False
        self._visited.append(thing)
        return True

    def reach(self, thing) -> None:
        """Add a value to the hash."""
        kind = type(thing)
        if kind in _PLAIN:
            self._say(kind.__name__, thing.hex() if kind is float else thing)
        elif kind in (tuple, list):
            self._say(kind.__name__, len(thing))
            for item in thing:
                self.reach(item)
        elif kind in _MAPPINGS:
            self._mapping(thing)
        elif kind in (set, frozenset):
            self._say(kind.__name__, len(thing))
            for item in sorted(thing, key=repr):
                self.reach(item)
        elif isinstance(thing, np.ndarray | np.generic) and not thing.dtype.hasobject:
            self._say("array", thing.dtype.str, thing.shape, np.ascontiguousarray(thing).tobytes())
        elif isinstance(thing, types.FunctionType):
            self._function(thing)
        elif isinstance(thing, type):
            self._class(thing)
        elif isinstance(thing, Path):
            self._path(thing)
        elif isinstance(thing, types.ModuleType):
            if _root(thing.__name__) not in FIXED:
                raise Unknown(f"the module {thing.__name__} as a value")
            self._say("module", thing.__name__)
        elif self._is_new(thing):
            self._object(thing)

    def _mapping(self, mapping) -> None:
        if self._is_new(mapping):
            self._say("mapping", len(mapping))
            for key, value in mapping.items():
                self.reach(key)
                self.reach(value)

    def _path(self, path: Path) -> None:
        """A file, or the bitcode in a folder: its content."""
        for file in sorted(path.glob("*.bc")) if path.is_dir() else [path]:
            self._say("file", file.name, file.read_bytes() if file.is_file() else None)

    def _function(self, function) -> None:
        is_traced = getattr(function, "_is_taichi_function", False)
        if is_traced:
            self._say("traced", bool(getattr(function, "_is_real_function", False)))
            function = function.__wrapped__
        if not self._is_new(function):
            return
        root = _root(function.__module__)
        if root == OWN:
            self._say("function", function.__qualname__)
            code, names = _of_code(function.__code__)
            self._say("code", code)
            self._look_up(function.__globals__, names)
            self.reach(function.__defaults__)
            self.reach(function.__kwdefaults__)
            if is_traced or function is self._visited[0]:  # elsewhere annotations are words for readers
                self.reach(list(function.__annotations__.values()))
                self.files.add(function.__code__.co_filename)
        elif root in FIXED or root.startswith("namedtuple_"):
            self._say("of", function.__module__, function.__qualname__)
        else:
            raise Unknown(f"{function.__module__}.{function.__qualname__}")
        for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
            self._say("closure", name)
            try:
                value = cell.cell_contents
            except ValueError:  # it is set later
                raise Unknown(f"{name} of {function.__qualname__}, which is not set yet") from None
            self.reach(value)

    def _look_up(self, space: dict, names: tuple[str, ...]) -> None:
        """Reach what the names mean in a module, and in the modules of this package that they mean there."""
        for name in names:
            if _root(name) == OWN and "." in name:  # imported within the function
                if name not in sys.modules:
                    raise Unknown(f"the module {name}, which is not imported yet")
                value = sys.modules[name]
            elif name in space:
                value = space[name]
            else:  # a builtin, or an attribute
                continue
            self._say("global", name)
            if not isinstance(value, types.ModuleType) or _root(value.__name__) != OWN:
                self.reach(value)
            elif (value.__name__, names) not in self._looked_up:
                self._looked_up.add((value.__name__, names))
                self._look_up(vars(value), names)

    def _class(self, cls: type) -> None:
        if not self._is_new(cls):
            return
        self._say("class", cls.__module__, cls.__qualname__)
        root = _root(cls.__module__)
        if root in FIXED:
            return
        if root != OWN:
            raise Unknown(f"the class {cls.__module__}.{cls.__qualname__}")
        for base in cls.__bases__:
            self.reach(base)
        if issubclass(cls, tuple) and hasattr(cls, "_fields"):  # the other methods of a named tuple follow from them
            self._say("fields", cls._fields)
        for name, value in list(vars(cls).items()):
            functions = list(_functions(value))
            if name == "__init_subclass__":  # it has run
                continue
            self._say("member", name)
            for function in functions:
                self.reach(function)
            if (
                not functions
                and not name.startswith("__")
                and name != "_abc_impl"
                and not isinstance(value, _DESCRIPTORS)
            ):
                self.reach(value)

    def _object(self, thing) -> None:
        """An object that is not a plain value: its class and its attributes."""
        cls = type(thing)
        self._say("object", cls.__module__, cls.__qualname__)
        if hasattr(thing, "__wrapped__"):  # of functools.cache
            self.reach(thing.__wrapped__)
        elif isinstance(thing, types.MethodType):
            self.reach(thing.__self__)
            self.reach(thing.__func__)
        elif isinstance(thing, types.BuiltinFunctionType):
            self._say(thing.__module__, thing.__qualname__)
            if not isinstance(thing.__self__, types.ModuleType | type(None)):
                self.reach(thing.__self__)
        elif isinstance(thing, Enum):
            self._say(thing.name)
            self.reach(thing.value)
        elif isinstance(thing, Fraction | range | slice | np.dtype):
            self._say(repr(thing))
        elif isinstance(thing, re.Pattern):
            self._say(thing.pattern, thing.flags)
        elif isinstance(thing, types.UnionType):
            self.reach(thing.__args__)
        elif isinstance(thing, partial | itemgetter | attrgetter):
            self.reach(thing.__reduce__())
        elif cls.__module__ == "taichi._lib.core.taichi_python":  # a type of numbers, or an option
            self._say(str(thing.to_string() if hasattr(thing, "to_string") else thing))
        elif _root(cls.__module__) in FIXED and not hasattr(thing, "__dict__"):
            if not callable(thing) or not hasattr(thing, "__name__"):
                raise Unknown(f"an object of {cls.__module__}.{cls.__qualname__}")
            self._say(thing.__name__)
        elif isinstance(getattr(thing, "fixed", None), tuple):  # it says what kernels are compiled for
            self.reach(cls)
            self.reach(thing.fixed)
        else:
            self.reach(cls)
            for name, value in _attributes(thing):
                self._say("attribute", name)
                self.reach(value)


@cache
def _of_code(code: types.CodeType) -> tuple[str, tuple[str, ...]]:
    """The digest of bytecode, and the names that it looks up, with those of functions within it."""
    words: list = [code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars, code.co_flags]
    words += [code.co_argcount, code.co_kwonlyargcount, code.co_posonlyargcount]
    names = dict.fromkeys(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            digest, within = _of_code(constant)
            words.append(digest)
            names.update(dict.fromkeys(within))
        else:
            words.append(sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant)
    return hashlib.blake2b(repr(words).encode(), digest_size=32).hexdigest(), tuple(names)


def _functions(member) -> Iterator[types.FunctionType]:
    """The functions in a member of a class."""
    if isinstance(member, types.FunctionType):
        yield member
    elif isinstance(member, staticmethod | classmethod):
        yield from _functions(member.__func__)
    elif isinstance(member, property):
        for part in (member.fget, member.fset):
            yield from _functions(part)
    elif isinstance(getattr(member, "func", None), types.FunctionType):  # of functools.cached_property
        yield member.func


def _attributes(thing) -> list[tuple[str, object]]:
    found = list(vars(thing).items()) if hasattr(thing, "__dict__") else []
    for cls in type(thing).__mro__:
        slots = vars(cls).get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            if name not in ("__dict__", "__weakref__") and hasattr(thing, name):
                found.append((name, getattr(thing, name)))
    if isinstance(thing, tuple | list):
        found.append(("items", list(thing)))
    return found
