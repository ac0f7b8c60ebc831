"""What Dask and its server log, kept off the terminal: what goes wrong in a sweep is raised as an error."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import distributed  # noqa: F401  (sets the levels of its logs when it is imported)

__all__ = ["quiet", "silence"]

_NAMES = ("distributed", "tornado", "asyncio", "bokeh")


def silence() -> dict[logging.Logger, int]:
    """Let them log nothing for the life of the process, or until the levels that are returned are set again."""
    names = [
        *_NAMES,
        *(name for name in logging.root.manager.loggerDict if name.startswith(tuple(f"{n}." for n in _NAMES))),
    ]
    loggers = [logging.getLogger(name) for name in names]
    before = {logger: logger.level for logger in loggers}
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    return before


@contextmanager
def quiet() -> Iterator[None]:
    """Let them log nothing in this block."""
    before = silence()
    try:
        yield
    finally:
        for logger, level in before.items():
            logger.setLevel(level)
