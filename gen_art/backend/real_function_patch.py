"""A patch that changes what Taichi 1.7.4 traces: branches and loops inside a real function.

A real function (@ti.real_func) is compiled once and called; a plain one (@ti.func) is inlined where it is used. When a real
function uses a plain one, Taichi 1.7.4 puts the branches and loops of the plain one into the kernel instead of the real
function, and the results are wrong. This patch puts them into the real function.

Colliders rely on it: their distances are one real function with branches (gen_art/colliders/surface.py), so that a kernel
with colliders compiles in one second instead of four to twelve. With GEN_ART_STOCK_TAICHI=1 the patch is off, and that
function is inlined: the same bits, compiled more slowly.
"""

from taichi.lang import impl, kernel_impl

__all__ = ["install"]


def install() -> None:
    """Replace Taichi's `_get_tree_and_ctx` by one that adds branches and loops to the function that is being compiled."""
    parse = kernel_impl._get_tree_and_ctx

    def tree_and_context(self, *args, is_kernel=True, is_real_function=False, **rest):
        if not (is_kernel or is_real_function):
            rest["ast_builder"] = impl.get_runtime().compiling_callable.ast_builder()
        return parse(self, *args, is_kernel=is_kernel, is_real_function=is_real_function, **rest)

    kernel_impl._get_tree_and_ctx = tree_and_context
