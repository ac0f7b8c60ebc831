"""Shares the loops of kernels out among threads, in place of Taichi 1.7.4, which wakes all its threads for each loop and sleeps.

That takes 0.1 ms, also for a loop over one particle. Here the thread that launches a kernel begins the loop itself, and wakes
the others when it has worked for some microseconds and two pieces or more are left; or at once, if the kernel's loop of as many
pieces took long the last time. Pieces are taken one by one, so that uneven work is balanced. Which thread does a piece changes
no result: all of them round, and treat numbers below the normal ones, as the thread that has started Taichi.

The code is loop_sharing.ll, in LLVM's language. Taichi's runtime holds the address of the function that shares out a loop; this
module writes another one there.
"""

import atexit
import ctypes
import hashlib
import os
import threading
from pathlib import Path

from gen_art.backend import machine_code
from gen_art.backend.kept_files import KeptFiles

__all__ = ["install"]

# Of Taichi 1.7.4's structure LLVMRuntime: what lies before the address of its thread pool are two chunks of memory of three
# words each, five addresses, and tables of 512 addresses and 512 sizes. The function that shares out a loop comes next.
_WORD = ctypes.sizeof(ctypes.c_void_p)
_SHARES_OUT = (2 * 3 + 5 + 512 + 512 + 1) * _WORD


def install(threads: int, kept: KeptFiles) -> None:
    """Let `threads` threads, of which the calling one is the first, share the loops of all kernels from now on.

    kept : where the machine code is kept from one process to the next
    Where Taichi's runtime is not found or not as expected, Taichi goes on to share them. Call it once a process.
    """
    runtime = machine_code.runtime_address()
    if runtime is None:
        return
    place = ctypes.c_void_p.from_address(runtime + _SHARES_OUT)
    if not _is_taichi(place.value):
        return
    text = Path(__file__).with_suffix(".ll").read_text(encoding="ascii")
    key = hashlib.sha256(text.encode()).hexdigest()
    if (image := kept.read(key)) is None:
        image = machine_code.assemble(text)
        kept.write(key, image)
    run, prepare, help_, stop, workers = machine_code.link(image, ["run", "prepare", "help", "stop", "workers"])
    ctypes.CFUNCTYPE(None)(prepare)()
    count = ctypes.c_int32.from_address(workers)
    count.value = threads - 1
    live, end = ctypes.CFUNCTYPE(None, ctypes.c_int32)(help_), ctypes.CFUNCTYPE(None)(stop)
    team: list[threading.Thread] = []
    for number in range(1, threads):
        thread = threading.Thread(target=live, args=(number,), name=f"gen-art kernels {number}", daemon=True)
        try:
            thread.start()
        except RuntimeError:  # the system allows no more threads
            count.value = number - 1
            break
        team.append(thread)

    def dismiss() -> None:
        """End the lives of the workers, before Python takes its own things apart."""
        end()
        for thread in team:
            thread.join(1.0)

    atexit.register(dismiss)
    place.value = run
    if hasattr(os, "register_at_fork"):  # a fork has one thread, which then does its loops alone
        os.register_at_fork(after_in_child=lambda: setattr(count, "value", 0))


class _Symbol(ctypes.Structure):
    """What the dynamic linker knows of an address."""

    _fields_ = (
        ("file", ctypes.c_char_p),
        ("base", ctypes.c_void_p),
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
    )


def _is_taichi(address: int | None) -> bool:
    """Whether an address is in Taichi's library."""
    symbol = _Symbol()
    found = ctypes.CDLL(None).dladdr(ctypes.c_void_p(address), ctypes.byref(symbol))
    return bool(found) and b"taichi" in os.path.basename(symbol.file or b"")
