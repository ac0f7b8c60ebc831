"""Kernels as machine code: made by LLVM from the intermediate code into which Taichi has compiled them, loaded, and called.

Taichi 1.7.4 keeps only its intermediate code from one process to the next; each process makes machine code of it anew, which
takes seconds. Here the machine code itself is kept (kernel_store.py).

A compiled kernel is a list of functions ("tasks"), called in order with a pointer to a context: the kernel's arguments as a
C structure, and Taichi's runtime, by which loops are shared out among threads. The version of LLVM is that of Taichi, 15.
"""

import ctypes
import hashlib
import platform
import re
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import taichi as ti
from taichi.lang import impl

__all__ = [
    "IntermediateCode",
    "MachineCode",
    "assemble",
    "available",
    "context_of",
    "emit",
    "intermediate",
    "link",
    "load",
    "runtime_address",
]

_LLVM = 15  # the version of LLVM that Taichi's intermediate code is of


@dataclass(frozen=True)
class IntermediateCode:
    """tasks : names of its functions, in the order in which they run; text : LLVM's language."""

    tasks: tuple[str, ...]
    text: str

    def digest(self) -> str:
        return hashlib.sha256(self.text.encode()).hexdigest()


@dataclass(frozen=True)
class MachineCode:
    """tasks : names of its functions, in the order in which they run; image : an object file."""

    tasks: tuple[str, ...]
    image: bytes


class _Context(ctypes.Structure):
    """What a task is called with."""

    _fields_ = (
        ("arguments", ctypes.c_void_p),
        ("runtime", ctypes.c_void_p),
        ("thread", ctypes.c_int32),
        ("result", ctypes.c_void_p),
    )


_TASK = ctypes.PYFUNCTYPE(None, ctypes.c_void_p)


@cache
def available() -> bool:
    """Whether kernels can be called as machine code here; else Taichi launches them."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return False
    try:
        import llvmlite.binding as llvm
    except ImportError:
        return False
    return llvm.llvm_version_info[0] == _LLVM and runtime_address() is not None


@cache
def _llvm():
    import llvmlite.binding as llvm

    llvm.initialize()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm


def _machine():
    """LLVM's description of this processor."""
    llvm = _llvm()
    features = llvm.get_host_cpu_features().flatten()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=features, opt=2, reloc="pic", codemodel="jitdefault", jit=True
    )


_emitter = cache(_machine)


@cache
def _linker():
    return _llvm().create_lljit_compiler(_machine())


def intermediate(kernel) -> IntermediateCode:
    """The code of a kernel that Taichi has compiled. Its names do not tell how many kernels were compiled before."""
    builder = impl.get_runtime().prog.make_aot_module_builder(ti.cpu, [])
    builder.add("kernel", kernel)
    with tempfile.TemporaryDirectory(prefix="gen-art-") as folder:
        builder.dump(folder, "")
        text = (Path(folder) / "kernel.ll").read_text()
    names = re.findall(r"^define (?:dso_local )?void @(\w+_kernel_\d+_\w+)\(", text, re.MULTILINE)
    names.sort(key=lambda name: int(re.findall(r"_kernel_(\d+)_", name)[-1]))
    tasks = tuple(f"task_{n}" for n in range(len(names)))
    for name, task in zip(names, tasks, strict=True):
        text = re.sub(rf"@{name}\b", f"@{task}", text)
    return IntermediateCode(tasks, text)


def emit(code: IntermediateCode) -> MachineCode:
    """Machine code for this processor."""
    return MachineCode(code.tasks, assemble(code.text))


_libraries: list = []  # keeps the loaded code


def load(code: MachineCode) -> list:
    """Make machine code callable: its tasks, each a function of the address of a context."""
    return [_TASK(address) for address in link(code.image, code.tasks)]


def assemble(text: str) -> bytes:
    """An object file for this processor, of code in LLVM's language."""
    return _emitter().emit_object(_llvm().parse_assembly(text))


def link(image: bytes, names: Sequence[str]) -> list[int]:
    """Load an object file; returns the addresses of these names in it."""
    library = _llvm().JITLibraryBuilder().add_object_img(image).add_current_process()
    for name in names:
        library.export_symbol(name)
    loaded = library.link(_linker(), f"library {len(_libraries)}")
    _libraries.append(loaded)
    return [loaded[name] for name in names]


def context_of(arguments: ctypes.Structure) -> _Context:
    """The context with which a kernel's tasks are called."""
    return _Context(ctypes.addressof(arguments), runtime_address(), 0, None)


@cache
def runtime_address() -> int | None:
    """The address of Taichi's runtime, which Taichi writes into the context of a launch; None where it is not found.

    A kernel is launched whose argument is known, so that the argument shows that the context was found.
    """
    values = np.zeros(1009, np.float32)

    @ti.kernel
    def touch(x: ti.types.ndarray(ti.f32, 1)):
        x[0] = 1.0

    primal = touch._primal
    compiled = primal.compiled_kernels[primal.ensure_compiled(values)]
    program = impl.get_runtime().prog
    context = compiled.make_launch_context()
    context.set_arg_external_array_with_shape((0,), values.ctypes.data, values.nbytes, values.shape, 0)
    program.launch_kernel(program.compile_kernel(program.config(), program.get_device_caps(), compiled), context)
    word = ctypes.sizeof(ctypes.c_void_p)
    builder = _word_at(id(context) + object.__basicsize__)  # the C++ object that Python's object holds
    owned, current = _word_at(builder + word), _word_at(builder + 2 * word)
    if owned != current or values[0] != 1.0:
        return None
    found = _Context.from_address(current)
    length, pointer = ctypes.c_int32.from_address(found.arguments).value, _word_at(found.arguments + word)
    return found.runtime if length == values.size and pointer == values.ctypes.data else None


def _word_at(address: int) -> int:
    return ctypes.c_size_t.from_address(address).value
