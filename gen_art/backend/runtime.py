"""The only place that starts Taichi: backend, threads, cache folder, precision, silence.

Every other module takes `ti` from here. Kernels are wrapped by `kernel(function, precision)`, which compiles them
with the right default float type: otherwise the literals of a float64 kernel silently become float32.

This package replaces parts of Taichi's inside (tracing_patch, real_function_patch, launch_patch) and links LLVM bitcode
into kernels (intrinsics/). With the environment variable GEN_ART_STOCK_TAICHI=1 it does neither: the same bits, more slowly.
"""

from gen_art.backend.environment import STOCK_TAICHI  # isort: skip  (sets the environment that Taichi reads when imported)

import contextlib
import hashlib
import io
import os
import platform
from functools import lru_cache
from itertools import takewhile
from pathlib import Path

if not STOCK_TAICHI:
    from gen_art.backend import tracing_patch  # isort: skip  (before anything of Taichi)
import numpy as np
import taichi as ti
from taichi._lib import core
from taichi.lang import impl
from taichi.lang.expr import make_expr_group
from taichi.lang.matrix import make_matrix

from gen_art.errors import UsageError

if not STOCK_TAICHI:
    from gen_art.backend import real_function_patch
    from gen_art.backend.launch_patch import launch_without_repeats as _launcher

    tracing_patch.install()
    real_function_patch.install()

__all__ = [
    "DTYPES",
    "INDEX_MASK",
    "aligned",
    "cache_folder",
    "call_bitcode",
    "compilations",
    "finish",
    "impl",
    "init",
    "is_f64",
    "kernel",
    "make_matrix",
    "processor",
    "real",
    "threads",
    "ti",
]

DTYPES = {"f32": ti.f32, "f64": ti.f64}
_ALIGNMENT = 128  # bytes: sixteen float64
_state: dict = {"config": None, "kernels": [], "lock": None}


@lru_cache(1)
def processor() -> list[str]:
    """The lines with the first processor's name and what it can do ("flags"); none where the system does not tell."""
    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as lines:
        return [line for line in takewhile(str.strip, lines) if line.startswith(("model name", "flags"))]
    return []


def cache_folder(arch: str) -> Path:
    """Where compiled kernels are kept: $GEN_ART_CACHE, else the user's cache folder.

    The CPU and the compile settings are not part of Taichi's own cache key, so they are part of the folder's name.
    """
    base = os.environ.get("GEN_ART_CACHE")
    root = Path(base) if base else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gen-art"
    cpu = platform.machine() + platform.processor() + "".join(processor())
    tag = hashlib.sha256(cpu.encode()).hexdigest()[:12]
    return root / f"taichi-{'.'.join(map(str, ti.__version__))}-{arch}-{tag}"


def _share_cache(folder: Path) -> bool:
    """Take a share in the cache folder; the first process in removes a lock that a killed one left behind."""
    try:
        import fcntl

        folder.mkdir(parents=True, exist_ok=True)
        handle = open(folder / "processes", "a")  # noqa: SIM115  (held open for the life of the process)
    except (ImportError, OSError):
        return os.access(folder, os.W_OK)
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for stale in folder.glob("*.lock"):
            stale.unlink(missing_ok=True)
    fcntl.flock(handle, fcntl.LOCK_SH)
    _state["lock"] = handle
    return True


def init(arch: str = "cpu", threads: int | None = None) -> None:
    """Start Taichi once for the process. `threads=None` means all processors, or whatever runs already.

    Raises UsageError for another backend, a bad thread count, or a second, different configuration.
    """
    if arch != "cpu":
        raise UsageError(f"arch '{arch}' is not available yet: this version runs on 'cpu' only")
    if threads is not None and not 1 <= threads <= 1024:
        raise UsageError(f"threads must be from 1 to 1024, not {threads}")
    running = _state["config"]
    if running is not None:
        if (arch, threads or running[1]) != running:
            raise UsageError(
                f"this process already runs on arch={running[0]!r} with threads={running[1]}; "
                f"arch={arch!r}, threads={threads} needs a process of its own"
            )
        return
    count = (
        threads or len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else threads or os.cpu_count() or 1
    )
    folder = cache_folder(arch)
    with contextlib.redirect_stdout(io.StringIO()):
        ti.init(
            arch=ti.cpu,
            log_level=ti.ERROR,
            cpu_max_num_threads=count,
            make_cpu_multithreading_loop=False,  # blocks are handed out dynamically: uneven work is balanced
            cfg_optimization=False,  # nine tenths of compiling, for what LLVM does again: the same bits at the same speed
            fast_math=False,  # keeps every particle's arithmetic the same in every lane and in every kernel
            offline_cache=_share_cache(folder),
            offline_cache_file_path=str(folder),
            enable_fallback=False,
        )
    _state["config"] = (arch, count)


def finish() -> None:
    """Keep what was compiled for the next process; nothing runs after this. Else Taichi does it when Python frees it."""
    if _state["config"]:
        ti.reset()


def threads() -> int:
    """How many threads kernels run on (0 before `init`)."""
    return _state["config"][1] if _state["config"] else 0


def _launch_by_taichi(primal, function, compiling):
    """What `launch_without_repeats` gives, with Taichi's own launch each time."""

    def launch(*args):
        with compiling():
            return function(*args)

    vars(launch)["bound"] = lambda *args: lambda: launch(*args)
    return launch


if STOCK_TAICHI:
    _launcher = _launch_by_taichi


@contextlib.contextmanager
def _compiling(dtype, vectors: bool):
    runtime = impl.get_runtime()
    config = runtime.prog.config()
    old = runtime.default_fp, config.default_fp, config.real_matrix_scalarize
    runtime.default_fp, config.default_fp, config.real_matrix_scalarize = dtype, dtype, not vectors
    try:
        yield
    finally:
        runtime.default_fp, config.default_fp, config.real_matrix_scalarize = old


def kernel(function, precision: str = "f32", vectors: bool = False):
    """Wrap a @ti.kernel so that it is traced, and launched, with `precision` as the default float type.

    vectors : its ti.Vectors (of a power of two of numbers) are the processor's: an operation between two is one instruction, and
    so is loading or storing one of an ndarray of vectors, which must come from `aligned`. Else Taichi takes vectors apart.
    """
    dtype = DTYPES[precision]
    primal = function._primal
    _state["kernels"].append(primal)
    return _launcher(primal, function, lambda: _compiling(dtype, vectors))


# index & NO_SIGN is known to be no sum's overflow: LLVM adds constants to it in the address, and not one by one before.
# It leaves all indices below 2^30 as they are: a film of 16384 x 16384 has 2^28 pixels
INDEX_MASK = 0x3FFFFFFF


def aligned(shape, dtype) -> np.ndarray:
    """Zeros at an address that vectors can be loaded from and stored to whole."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape)) * dtype.itemsize
    raw = np.zeros(size + _ALIGNMENT, np.uint8)
    begin = -raw.ctypes.data % _ALIGNMENT
    return raw[begin : begin + size].view(dtype).reshape(shape)


def compilations() -> int:
    """How many kernels have been compiled (or loaded from the cache) by this process."""
    return sum(len(k.compiled_kernels) for k in _state["kernels"])


def real():
    """The float type of the kernel being traced."""
    return impl.get_runtime().default_fp


def is_f64() -> bool:
    """Whether the kernel being traced computes in float64."""
    return real() == ti.f64


def call_bitcode(file: Path, function: str, values, variables=()) -> None:
    """Call a function of LLVM's bitcode from the kernel being traced. It gets addresses of copies of values, then of variables.

    What it writes to a variable shows after the loop around the call; Taichi does not see it within.
    """
    runtime = impl.get_runtime()
    arguments = make_expr_group([*(impl.expr_init(value) for value in values), *variables])
    runtime.compiling_callable.ast_builder().insert_external_func_call(
        0, "", str(file), function, arguments, make_expr_group([]), core.DebugInfo(runtime.get_current_src_info())
    )


for _function in (real, is_f64):
    vars(_function)["_is_wrapped_kernel"] = True  # plain Python called while tracing: Taichi need not warn
