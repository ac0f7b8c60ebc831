"""Starts Taichi: backend, threads, cache folder, precision; and wraps its kernels.

Every other module imports `ti` from here. `kernel(function, precision)` compiles a kernel with its default float type;
otherwise the literals of a float64 kernel would silently become float32.

This package replaces parts of Taichi (tracing_patch, real_function_patch, launch_patch, loop_sharing) and links LLVM bitcode
into kernels (intrinsics/). With the environment variable GEN_ART_STOCK_TAICHI=1 it does neither: the bits are the same, but it
is slower.
"""

from gen_art.backend.environment import HAS_HOME, STOCK_TAICHI  # isort: skip  (sets the environment that Taichi reads when imported)

import contextlib
import hashlib
import io
import os
import platform
import tempfile
import warnings
from pathlib import Path

if not STOCK_TAICHI:
    from gen_art.backend import tracing_patch  # isort: skip  (must be imported before Taichi)
import numpy as np
import taichi as ti
from taichi._lib import core
from taichi.lang import impl
from taichi.lang.expr import make_expr_group
from taichi.lang.matrix import make_matrix

from gen_art.arguments import shown, whole
from gen_art.backend import processor
from gen_art.backend.compile_errors import as_sentences
from gen_art.backend.kept_files import KeptFiles
from gen_art.errors import OutputError, UsageError

if not STOCK_TAICHI:
    from gen_art.backend import loop_sharing, machine_code, real_function_patch
    from gen_art.backend.kernel_store import KernelStore
    from gen_art.backend.launch_patch import launch_without_repeats

    tracing_patch.install()
    real_function_patch.install()

__all__ = [
    "CACHE_LIMIT",
    "DTYPES",
    "INDEX_MASK",
    "aligned",
    "cache_folder",
    "cache_problem",
    "call_bitcode",
    "compilations",
    "finish",
    "impl",
    "init",
    "is_f64",
    "kept_files",
    "keeps_machine_code",
    "kernel",
    "make_matrix",
    "real",
    "threads",
    "ti",
]

DTYPES = {"f32": ti.f32, "f64": ti.f64}
_ALIGNMENT = 128  # bytes: a vector of sixteen float64
CACHE_LIMIT = (
    1 << 30
)  # bytes; the shipped presets take a tenth of it, and Taichi's own limit of 100 MiB forgot some of theirs
_state: dict = {"config": None, "kernels": [], "lock": None, "kept": None}


def cache_folder(arch: str) -> Path | None:
    """The folder of compiled kernels: in $GEN_ART_CACHE, or in the user's cache folder; None where no folder is known.

    The processor is not part of Taichi's cache key, so it is part of the folder's name.
    """
    base, shared = os.environ.get("GEN_ART_CACHE"), os.environ.get("XDG_CACHE_HOME")
    if not base and not shared and not HAS_HOME:
        return None
    root = Path(base) if base else Path(shared or Path.home() / ".cache") / "gen-art"
    cpu = platform.machine() + platform.processor() + "".join(processor.lines())
    tag = hashlib.sha256(cpu.encode()).hexdigest()[:12]
    return root / f"taichi-{'.'.join(map(str, ti.__version__))}-{arch}-{tag}"


def cache_problem(arch: str) -> str | None:
    """Why the cache folder cannot be used; None where it can, and this process then shares it with others."""
    folder = cache_folder(arch)
    if folder is None:
        return "HOME is not set"
    try:
        _share_cache(folder)
    except OSError as error:
        return f"the cache folder {folder} cannot be used ({error.strerror})"
    return None


def _usable_cache(arch: str) -> Path:
    """The cache folder, which this process shares with others; where it cannot be written, a temporary one of its own.

    Taichi ends the process when it cannot write to its cache.
    """
    folder, problem = cache_folder(arch), cache_problem(arch)
    if folder is not None and problem is None:
        return folder
    try:
        own = tempfile.TemporaryDirectory(prefix="gen-art-cache-", ignore_cleanup_errors=True)
    except OSError as error:
        raise OutputError(f"{problem}, and a temporary folder cannot be made: {error.strerror or error}") from None
    _state["own cache"] = own  # it is deleted when the process ends
    warnings.warn(
        f"{problem}: every start compiles its kernels anew; set GEN_ART_CACHE to a folder that can be written",
        stacklevel=3,
    )
    return Path(own.name)


def _share_cache(folder: Path) -> None:
    """Make the cache folder, and note that this process uses it. Raises OSError where it cannot be written.

    If no other process uses it, a lock that a killed process has left is removed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()  # an existing folder may be read-only
    try:
        import fcntl
    except ImportError:  # Windows
        return
    handle = open(folder / "processes", "a")  # noqa: SIM115  (held open for the life of the process)
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        for stale in folder.glob("*.lock"):
            stale.unlink(missing_ok=True)
    with contextlib.suppress(OSError):  # a file system without locks
        fcntl.flock(handle, fcntl.LOCK_SH)
    _state["lock"] = handle


def init(arch: str = "cpu", threads: int | None = None) -> None:
    """Start Taichi once for the process.

    threads : None for all processors, or for the number with which Taichi runs already
    Raises UsageError for another backend, a wrong number of threads, or a second, different configuration.
    """
    if not isinstance(arch, str) or arch != "cpu":
        raise UsageError(f"arch {shown(arch)} is not available yet: this version runs on 'cpu' only")
    if threads is not None:
        threads = whole("threads", threads, 1, 1024)
    running = _state["config"]
    if running is not None:
        if (arch, threads or running[1]) != running:
            raise UsageError(
                f"this process already runs on arch={running[0]!r} with threads={running[1]}; "
                f"arch={arch!r}, threads={threads} needs a process of its own"
            )
        return
    count = threads or processor.cores()
    folder = _usable_cache(arch)
    with contextlib.redirect_stdout(io.StringIO()):
        ti.init(
            arch=ti.cpu,
            log_level=ti.ERROR,
            cpu_max_num_threads=count,
            make_cpu_multithreading_loop=False,  # threads take blocks one by one, which balances uneven work
            # LLVM does the same as Taichi's own passes: same bits and same speed, at a tenth of the compile time
            cfg_optimization=False,
            advanced_optimization=False,
            fast_math=False,  # the arithmetic of a particle must be the same in every lane and in every kernel
            offline_cache=True,
            offline_cache_file_path=str(folder),
            offline_cache_max_size_of_files=CACHE_LIMIT,
            enable_fallback=False,
            unrolling_limit=0,  # no warning of long static loops: the expansions of the tree are such
        )
    _state["config"] = (arch, count)
    _state["kept"] = KeptFiles(folder / "arrays")
    if not STOCK_TAICHI:
        _state["store"] = KernelStore(folder / "machine-code")
        if machine_code.available():
            loop_sharing.install(count, _state["store"])


def finish() -> None:
    """Store the compiled kernels for the next process. No kernel can run after this.

    Raises OutputError when they cannot be stored; Taichi then crashes when the process ends, unless by os._exit.
    """
    if _state["config"]:
        _state["kept"].tidy()
        if not STOCK_TAICHI:
            _state["store"].tidy()
        try:
            ti.reset()
        except RuntimeError as error:
            raise OutputError(f"the compiled kernels were not stored: {error}") from None


def kept_files() -> KeptFiles | None:
    """The folder of arrays that are kept from one process to the next; None before `init`."""
    return _state["kept"]


def threads() -> int:
    """The number of threads on which kernels run; 0 before `init`."""
    return _state["config"][1] if _state["config"] else 0


def _launch_by_taichi(primal, function, compiling, settings):
    """Like `launch_without_repeats`, but Taichi does every launch."""

    def launch(*args):
        with compiling():
            return function(*args)

    vars(launch)["bound"] = lambda *args: lambda: launch(*args)
    vars(launch)["variants"] = primal.compiled_kernels
    return launch


def _launcher(primal, function, compiling, settings):
    """The function that launches a kernel."""
    if STOCK_TAICHI:
        return _launch_by_taichi(primal, function, compiling, settings)
    return launch_without_repeats(primal, function, compiling, settings, lambda: _state["store"])


@contextlib.contextmanager
def _compiling(dtype, vectors: bool):
    runtime = impl.get_runtime()
    config = runtime.prog.config()
    old = runtime.default_fp, config.default_fp, config.real_matrix_scalarize
    runtime.default_fp, config.default_fp, config.real_matrix_scalarize = dtype, dtype, not vectors
    try:
        with as_sentences():
            yield
    finally:
        runtime.default_fp, config.default_fp, config.real_matrix_scalarize = old


def kernel(function, precision: str = "f32", vectors: bool = False):
    """Wrap a @ti.kernel so that it is traced, and launched, with `precision` as the default float type.

    vectors : keep its ti.Vectors, whose length must be a power of two, as LLVM vectors: an operation on two of them is one
    instruction, and so is loading or storing one from an ndarray of vectors, which must come from `aligned`. By default
    Taichi splits vectors into scalars.
    """
    dtype = DTYPES[precision]
    launch = _launcher(function._primal, function, lambda: _compiling(dtype, vectors), (precision, vectors))
    _state["kernels"].append(launch)
    return launch


# Masking an index tells LLVM that adding a small constant to it cannot overflow, so it folds constant offsets into the load.
# Indices below 2^30 are not changed; a picture of 16384 x 16384 has 2^28 pixels.
INDEX_MASK = 0x3FFFFFFF


def aligned(shape, dtype) -> np.ndarray:
    """An array of zeros whose address is aligned for loading and storing whole vectors."""
    dtype = np.dtype(dtype)
    size = int(np.prod(shape)) * dtype.itemsize
    raw = np.zeros(size + _ALIGNMENT, np.uint8)
    begin = -raw.ctypes.data % _ALIGNMENT
    return raw[begin : begin + size].view(dtype).reshape(shape)


def compilations() -> int:
    """The number of kernels that this process has compiled or loaded from the cache."""
    return sum(len(launch.variants) for launch in _state["kernels"])


def keeps_machine_code() -> bool:
    """Whether later processes load the machine code of this one's kernels; else Taichi compiles each kernel in each process."""
    return not STOCK_TAICHI and machine_code.available()


def real():
    """The default float type of the kernel that is being traced."""
    return impl.get_runtime().default_fp


def is_f64() -> bool:
    """Whether the kernel that is being traced computes in float64."""
    return real() == ti.f64


def call_bitcode(file: Path, function: str, values, variables=()) -> None:
    """Call a function of an LLVM bitcode file from the kernel that is being traced.

    values : the function gets the addresses of copies of them
    variables : and the addresses of these, to which it may write
    Taichi does not know that the function writes to a variable: read it only after the loop that contains the call.
    """
    runtime = impl.get_runtime()
    arguments = make_expr_group([*(impl.expr_init(value) for value in values), *variables])
    runtime.compiling_callable.ast_builder().insert_external_func_call(
        0, "", str(file), function, arguments, make_expr_group([]), core.DebugInfo(runtime.get_current_src_info())
    )


for _function in (real, is_f64):
    vars(_function)["_is_wrapped_kernel"] = (
        True  # stops Taichi's warning about plain Python functions called while tracing
    )
