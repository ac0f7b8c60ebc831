"""Whether Taichi works here: compiles a kernel, runs it, and prints what it finds.

`gen-art doctor` runs this as a process of its own: a broken Taichi, or an instruction that the processor lacks, may end it.

Each finding is one line of JSON on standard output, printed as soon as it is known:
{"taichi": version}, {"supported": bool, "patched": bool}, {"cache": {"folder", "bytes", "files", "limit", "problem"}},
{"threads": n, "kept": whether machine code is kept}, or after which nothing follows
{"error": what is wrong, "remedy": what to do, "status": exit status}.
"""

import contextlib
import importlib.metadata
import json
import os
import tempfile

from gen_art.errors import InstallationError, OutputError

__all__ = ["REINSTALL", "run"]

REINSTALL = (
    "install Taichi anew: pip install --force-reinstall taichi; if that does not help, it does not support this system"
)

_LENGTH = 100_000  # numbers that the kernel writes: enough for every thread to get some


def run() -> None:
    """Print the findings."""
    try:
        _taichi()
        _cache()
        _kernel()
    except InstallationError as error:
        what, _, remedy = str(error).partition(": ")
        _print(error=what, remedy=remedy or REINSTALL, status=error.exit_code)
    except OutputError as error:
        remedy = "set TMPDIR to a folder that can be written and has space left"
        _print(error=str(error), remedy=remedy, status=error.exit_code)
    except Exception as error:
        words = " ".join(str(error).split())[:300]
        what = f"Taichi fails with {type(error).__name__}: {words}"
        _print(error=what, remedy=REINSTALL, status=InstallationError.exit_code)
    os._exit(0)  # Taichi may fail while a process ends


def _print(**finding) -> None:
    print(json.dumps(finding), flush=True)


def _taichi() -> None:
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        _print(taichi=importlib.metadata.version("taichi"))
    from gen_art.backend.environment import STOCK_TAICHI, TAICHI_VERSION

    _print(supported=importlib.metadata.version("taichi") == TAICHI_VERSION, patched=not STOCK_TAICHI)


def _cache() -> None:
    from gen_art.backend import runtime

    folder, problem = runtime.cache_folder("cpu"), runtime.cache_problem("cpu")
    sizes = []
    for file in folder.rglob("*") if folder is not None and problem is None else ():
        try:
            sizes.append(file.stat().st_size)
        except OSError:  # another process has just deleted it
            continue
    place = None if folder is None else str(folder)
    limit = runtime.CACHE_LIMIT
    _print(cache={"folder": place, "bytes": sum(sizes), "files": len(sizes), "limit": limit, "problem": problem})


def _kernel() -> None:
    """Compile a kernel, which is why it has an empty cache of its own, and compare what it writes with NumPy's numbers."""
    import numpy as np

    from gen_art.backend import runtime
    from gen_art.backend.runtime import ti

    @ti.kernel
    def line(x: ti.types.ndarray(ti.f32, 1)):
        for i in range(x.shape[0]):
            x[i] = 2.0 * ti.cast(i, ti.f32) + 1.0

    with _temporary_folder() as folder:
        os.environ["GEN_ART_CACHE"] = folder
        runtime.init()
        found = np.zeros(_LENGTH, np.float32)
        runtime.kernel(line)(found)
        if not np.array_equal(found, 2.0 * np.arange(_LENGTH, dtype=np.float32) + 1.0):
            raise InstallationError("a kernel ran and wrote wrong numbers")
        runtime.finish()
    _print(threads=runtime.threads(), kept=runtime.keeps_machine_code())


def _temporary_folder() -> tempfile.TemporaryDirectory:
    try:
        return tempfile.TemporaryDirectory(prefix="gen-art-trial-", ignore_cleanup_errors=True)
    except OSError as error:
        raise OutputError(f"temporary files cannot be written ({error.strerror or error})") from None


if __name__ == "__main__":
    run()
