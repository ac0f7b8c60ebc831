"""Set up before Taichi is imported: checks its version, whether it runs without this package's patches, and a home folder."""

import importlib.metadata
import os
import tempfile

from gen_art.errors import InstallationError

__all__ = ["HAS_HOME", "STOCK_TAICHI", "TAICHI_VERSION"]

TAICHI_VERSION = "1.7.4"  # the version for which the patches are written
HAS_HOME = os.name != "posix" or bool(os.environ.get("HOME"))
STOCK_TAICHI = os.environ.get("GEN_ART_STOCK_TAICHI", "") not in ("", "0")


def _check_version(installed: str) -> None:
    if installed != TAICHI_VERSION and not STOCK_TAICHI:
        raise InstallationError(
            f"this version needs taichi {TAICHI_VERSION}, but {installed} is installed: "
            f"run pip install 'taichi=={TAICHI_VERSION}', "
            "or set GEN_ART_STOCK_TAICHI=1 to try the installed version without gen-art's patches"
        )


try:
    _check_version(importlib.metadata.version("taichi"))
except importlib.metadata.PackageNotFoundError:
    raise InstallationError(
        f"this version needs taichi {TAICHI_VERSION}, which is not installed: run pip install 'taichi=={TAICHI_VERSION}'"
    ) from None
os.environ.setdefault("TI_SKIP_VERSION_CHECK", "ON")
os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")
os.environ.setdefault("TI_LOG_LEVEL", "error")  # Taichi would tell a notebook that it is one
if not HAS_HOME:  # Taichi ends the process where HOME is not set, though it then writes nothing there
    os.environ["HOME"] = tempfile.gettempdir()
