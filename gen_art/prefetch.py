"""Memory that a kernel will need soon is asked for ahead, so that nothing waits for it.

Taichi (1.7.4, which is pinned) has no words for this, but links functions from LLVM's bitcode into a kernel: prefetch.bc is
one, of a single instruction, assembled from prefetch.ll. It is laid out for Linux on x86-64; elsewhere nothing is asked for,
and kernels wait as they come to it. No result depends on it.
"""

import platform
from pathlib import Path

from taichi._lib import core
from taichi.lang.expr import make_expr_group

from gen_art.runtime import impl
from gen_art.tracing import traced

__all__ = ["prefetch"]

_BITCODE = Path(__file__).with_suffix(".bc")
_HERE = (platform.system(), platform.machine()) == ("Linux", "x86_64")


@traced
def prefetch(address):
    """Ask for the 64 bytes around an address, a 64-bit whole number. No address is wrong."""
    if _HERE:
        runtime = impl.get_runtime()
        runtime.compiling_callable.ast_builder().insert_external_func_call(
            0, "", str(_BITCODE), "gen_art_prefetch", make_expr_group([impl.expr_init(address)]), make_expr_group([]),
            core.DebugInfo(runtime.get_current_src_info()),
        )  # fmt: skip
