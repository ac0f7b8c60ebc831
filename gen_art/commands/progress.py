"""Progress on standard error: a bar for people, JSON lines for programs, or nothing.

A reporter is called with events: {"event": "frame", "frame": k, "frames": n, "particles": count, "fps": ..., "eta": s}, and
of a film or a sequence at the end with the seconds of its stages: {"event": "times", "total": s, "simulate": s, ...}. Where more
than ten seconds pass before the first picture, {"event": "wait", "steps": done, "of": n, "eta": s} tells about once a second.
Of a sweep on several processes, {"event": "unit", "unit": made, "units": n, "path": ...} tells of each file that is made.
Among JSON lines a warning is one too: {"event": "warning", "text": ...}.
"""

import json
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from gen_art.commands.terminal import echo

__all__ = ["reporter"]


@contextmanager
def reporter(mode: str) -> Iterator[Callable[[dict], None] | None]:
    """Yield the function that is called with progress events, or None if nothing is to be shown."""
    if mode == "auto":
        mode = "rich" if sys.stderr.isatty() else "times"
    if mode == "json":
        with warnings.catch_warnings():
            warnings.showwarning = _json_warning
            yield _json
    elif mode == "rich":
        with _bar() as show:
            yield show
    elif mode == "times":
        yield _Lines().show
    else:
        yield None


_DID = {"simulate": "simulated", "draw": "drew", "develop": "developed", "encode": "waited for the encoder"}


class _Lines:
    """Prints how long the wait for the first picture is, once, and where the time of a film went."""

    def __init__(self):
        self._told = False

    def show(self, event: dict) -> None:
        """`110 steps until the first picture, about 0:48 left`; `12.3 s: simulated 4.1, drew 6.0, ...`."""
        if event.get("event") == "wait" and not self._told:
            self._told = True
            echo(f"{event['of']:,} steps until the first picture, about {_clock(event['eta'])} left", err=True)
        elif event.get("event") == "times":
            parts = ", ".join(f"{did} {event[stage]:.1f}" for stage, did in _DID.items())
            echo(f"{event['total']:.1f} s: {parts}", err=True)


def _json(event: dict) -> None:
    print(json.dumps(event, allow_nan=False, default=float), file=sys.stderr, flush=True)


def _json_warning(message, category, filename, lineno, file=None, line=None) -> None:
    _json({"event": "warning", "text": str(message)})


@contextmanager
def _bar() -> Iterator[Callable[[dict], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (
        TextColumn("frame"),
        MofNCompleteColumn(),
        BarColumn(),
        TextColumn("{task.fields[particles]:,} particles"),
        TextColumn("{task.fields[rate]}"),
        TextColumn("{task.fields[left]}"),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        lines = _Lines()
        task = progress.add_task("", total=None, particles=0, rate="", left="")

        def show(event: dict) -> None:
            if event.get("event") == "wait":
                progress.update(
                    task, completed=0, rate=f"step {event['steps']:,} of {event['of']:,} until the first picture",
                    left=f"{_clock(event['eta'])} left",
                )  # fmt: skip
                return
            if event.get("event") != "frame":
                lines.show(event)
                return
            rate, eta = event.get("fps") or 0.0, event.get("eta")
            progress.update(
                task,
                total=event["frames"],
                completed=event["frame"] + 1,
                particles=int(event.get("particles") or 0),
                rate=f"{rate:.2f} frames/s" if rate else "",
                left=f"{_clock(eta)} left" if eta is not None else "",
            )

        yield show


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(max(0, round(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
