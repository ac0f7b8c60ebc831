"""A patch that makes Taichi 1.7.4 trace kernels faster. It does not change what is traced.

Tracing runs the Python code of a kernel node by node. Taichi repeats four kinds of work, which this patch avoids:

- Taichi finds, formats and parses the source of a function every time the function is inlined. Here a file is parsed once;
  one pass at a time may use the syntax tree of a function, because it writes to it.
- Taichi formats the source line of every node for a possible error message. Here this happens only when an error is raised.
- Taichi looks up the builder of a node by name, and stores its position, for every expression. Here the builder is looked up
  by type, and the position is stored for every statement.
- Taichi reads source text to find out whether a function is defined in a class. Here the calling frame is used; while Taichi
  is imported, one line of source is read.

Kernels, cache keys and error messages stay as they were (tests/physics/test_tracing.py). GEN_ART_STOCK_TAICHI=1 switches
this patch off.
"""

import ast
import inspect
import linecache
import sys
from collections.abc import Callable
from dataclasses import dataclass


def _frame_info(frame, context: int = 1) -> inspect.Traceback:
    """`inspect.getframeinfo` with only the line of source that Taichi reads."""
    code, line = frame.f_code, frame.f_lineno
    return inspect.Traceback(code.co_filename, line, code.co_name, [linecache.getline(code.co_filename, line)], 0)


_getframeinfo, inspect.getframeinfo = inspect.getframeinfo, _frame_info
try:
    from taichi.lang import impl, kernel_impl
    from taichi.lang.ast.ast_transformer import ASTTransformer
    from taichi.lang.ast.ast_transformer_utils import ASTTransformerContext, Builder
finally:
    inspect.getframeinfo = _getframeinfo

__all__ = ["install"]

_stock_transform_tree = kernel_impl.transform_tree
_stock_tree_and_context = kernel_impl._get_tree_and_ctx
_stock_position = ASTTransformerContext.get_pos_info
_stock_build = Builder.__call__


@dataclass
class _File:
    """A parsed source file: its lines, and its functions by name and first line (that of a decorator, as in a code object).

    A function that is defined under an `if` or a `with` is not found here; Taichi then parses it.
    """

    lines: list[str]
    functions: dict[tuple[int, str], ast.FunctionDef]

    @classmethod
    def read(cls, lines: list[str]) -> "_File":
        functions = {}
        blocks: list[ast.Module | ast.ClassDef | ast.FunctionDef] = [ast.parse("".join(lines))]
        while blocks:
            for node in blocks.pop().body:
                if isinstance(node, ast.FunctionDef):
                    first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
                    node.decorator_list = []
                    functions[first, node.name] = node
                if isinstance(node, ast.FunctionDef | ast.ClassDef):
                    blocks.append(node)
        return cls(lines, functions)


_files: dict[str, _File] = {}
_in_use: set[int] = set()  # ids of the trees to which a pass is writing


def _function(code) -> tuple[ast.FunctionDef, _File] | None:
    """The tree of a function and its file; None if its source is not found this way or another pass uses the tree."""
    lines = linecache.getlines(code.co_filename)
    file = _files.get(code.co_filename)
    if lines and (file is None or file.lines is not lines):
        file = _files[code.co_filename] = _File.read(lines)
    node = file.functions.get((code.co_firstlineno, code.co_name)) if file else None
    return (node, file) if file and node and id(node) not in _in_use else None


def _tree_and_context(self, excluded_parameters=(), is_kernel=True, args=None, is_real_function=False, **rest):
    found = _function(self.func.__code__)
    if found is None:
        return _stock_tree_and_context(
            self, excluded_parameters, is_kernel, args=args, is_real_function=is_real_function, **rest
        )
    node, file = found
    variables = kernel_impl._get_global_vars(self.func)
    if is_kernel or is_real_function:
        for slot in self.template_slot_locations:
            variables[self.arguments[slot].name] = args[slot]
    context = ASTTransformerContext(
        excluded_parameters=excluded_parameters,
        is_kernel=is_kernel,
        func=self,
        global_vars=variables,
        argument_data=args,
        src=file.lines,
        start_lineno=1,
        file=self.func.__code__.co_filename,
        is_real_function=is_real_function,
        **rest,
    )
    return ast.Module([node], []), context


def _transform_tree(tree, context):
    function = tree.body[0]
    arguments = function.args.args  # Taichi removes the arguments of a kernel
    _in_use.add(id(function))
    try:
        return _stock_transform_tree(tree, context)
    finally:
        _in_use.discard(id(function))
        function.args.args = arguments


def _position(self, node) -> str:
    if sys.exc_info()[0] is not None:
        return _stock_position(self, node)
    return f'File "{self.file}", line {node.lineno + self.lineno_offset}, in {self.func.func.__name__}:\n'


_builders: dict[type, Callable | None] = {}


class _RaisingBuilder:
    """Replaces the builder of a node that failed, so that Taichi's code raises the error again with its message."""

    def __init__(self, error: Exception):
        self.error = error

    def __getattr__(self, name: str):
        def fail(context, node):
            raise self.error

        return fail


def _build(self, context, node):
    kind = node.__class__
    try:
        build = _builders[kind]
    except KeyError:
        build = _builders[kind] = getattr(self, "build_" + kind.__name__, None)
    if build is None:
        return _stock_build(self, context, node)
    try:
        if not isinstance(node, ast.stmt):
            return build(context, node)
        positions = impl.get_runtime().src_info_stack
        positions.append(_position(context, node))
        try:
            return build(context, node)
        finally:
            positions.pop()
    except Exception as error:
        return _stock_build(_RaisingBuilder(error), context, node)


def _build_name(context, node):
    node.ptr = context.get_var_by_name(node.id)
    return node.ptr


def _inside_class(level_of_class_stackframe: int) -> bool:
    """Whether the frame that defines the function is a class body. The level is that of the frame around it."""
    frame = sys._getframe(level_of_class_stackframe - 1)
    return not frame.f_code.co_flags & inspect.CO_OPTIMIZED and "__qualname__" in frame.f_locals


def install() -> None:
    """Replace five functions of Taichi, for every kernel and function defined from here on."""
    kernel_impl._get_tree_and_ctx = _tree_and_context
    kernel_impl.transform_tree = _transform_tree
    kernel_impl._inside_class = _inside_class
    ASTTransformerContext.get_pos_info = _position
    Builder.__call__ = _build
    ASTTransformer.build_Name = staticmethod(_build_name)
