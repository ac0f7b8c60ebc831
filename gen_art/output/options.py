"""Checks of the options of `render` and `still` that Python callers pass; the command line has checked its own."""

from collections.abc import Sequence

from gen_art import arguments
from gen_art.errors import UsageError
from gen_art.renderer.painter import check_size

__all__ = ["check_options"]


def check_options(
    *, out, size, precision, threads, plugins, progress, scale=None, fps=None, quality=None, bits=None, codec=None, profile=None,
    time=None,
) -> None:  # fmt: skip
    """Raise UsageError for an option that is not of its kind; None stands for an option that is left out."""
    arguments.path("out", out)
    for name, value in (("quality", quality), ("precision", precision), ("codec", codec), ("profile", profile)):
        if value is not None:
            arguments.text(name, value)
    for name, value in (("scale", scale), ("fps", fps)):
        if value is not None:
            arguments.number(name, value, above=0.0)
    if time is not None:
        arguments.number("time", time, "s", low=0.0)
    if threads is not None:
        arguments.whole("threads", threads, 1, 1024)
    if bits is not None:
        arguments.whole("bits", bits, 8, 32)
    if size is not None:
        check_size(size)
    if isinstance(plugins, (str, bytes)) or not isinstance(plugins, Sequence):
        raise UsageError(f"plugins must be a list of Python files, not {arguments.shown(plugins)}")
    if progress is not None and not callable(progress):
        raise UsageError(f"progress must be a function of one mapping, not {arguments.shown(progress)}")
