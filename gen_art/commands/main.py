"""`gen-art`: runs a command, and turns every error into a message and an exit status.

0 success, 1 a bug, 2 wrong usage, 3 a wrong preset or numbers that are no longer finite, 4 not enough memory, 5 input or
output failed, 6 the encoder failed, 130 and 143 stopped by a signal.
"""

import difflib
import errno
import gc
import importlib
import os
import signal
import sys
import traceback
import warnings

import click

from gen_art.errors import GenArtError, PresetError

__all__ = ["cli", "main", "run"]

COMMANDS = (
    "render",
    "still",
    "rerun",
    "list",
    "show",
    "new",
    "schema",
    "validate",
    "inspect",
    "audit",
    "gallery",
    "bench",
)
_MAX_PROBLEMS = 8  # problems of a preset that commands other than validate print


class _Terminated(BaseException):
    """The process received SIGTERM."""


class _Commands(click.Group):
    """Commands by name, each imported only when it runs."""

    def list_commands(self, context):
        return list(COMMANDS)

    def get_command(self, context, name):
        if name not in COMMANDS:
            return None
        return importlib.import_module(f"gen_art.commands.{name}").command

    def resolve_command(self, context, args):
        if args and args[0] not in COMMANDS:
            near = difflib.get_close_matches(args[0], COMMANDS, n=1)
            hint = f"did you mean '{near[0]}'?" if near else "there are " + ", ".join(COMMANDS)
            raise click.UsageError(f"there is no command '{args[0]}'; {hint}", context)
        return super().resolve_command(context, args)


def _version(context, parameter, value):
    if value and not context.resilient_parsing:
        from gen_art import __version__

        click.echo(f"gen-art {__version__}")
        context.exit()


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_version, help="Print the version."
)
def cli():
    """Render particle physics, described by presets, to films and stills.

    A PRESET is a name (see gen-art list), the path of a YAML file, or - for standard input.
    """


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and end the process with its exit status."""
    # imports and tracing create many objects that live on, so frequent garbage collections would only cost time
    gc.set_threshold(50_000, 20, 20)
    leave(run(sys.argv[1:] if arguments is None else arguments))


def leave(status: int) -> None:
    """End the process with this exit status."""
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if "gen_art.backend.runtime" in sys.modules:
        sys.modules["gen_art.backend.runtime"].finish()
    gc.freeze()  # skips the last garbage collection of the objects that tracing made, which takes 0.25 s
    sys.exit(status)


def run(arguments: list[str]) -> int:
    """Run one command and return its exit status."""
    restore = _on_sigterm()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", UserWarning)
            warnings.showwarning = _print_warning
            status = cli.main(arguments, prog_name="gen-art", standalone_mode=False)
        return status if isinstance(status, int) else 0
    except BaseException as error:
        status = _status(error)
        original = (
            error.__cause__ if isinstance(error, click.Abort) else error
        )  # click turns KeyboardInterrupt into Abort
        for note in getattr(original, "__notes__", ()):
            _print_error(f"gen-art: {note}")
        return status
    finally:
        restore()


def _on_sigterm():
    """Make SIGTERM raise an exception, so that incomplete files are removed; returns a function that undoes this."""

    def stop(number, frame):
        raise _Terminated

    try:
        before = signal.signal(signal.SIGTERM, stop)
    except ValueError:  # not the main thread
        return lambda: None
    return lambda: signal.signal(signal.SIGTERM, before)


def _print_warning(message, category, filename, lineno, file=None, line=None) -> None:
    if issubclass(category, UserWarning):
        _print_error(f"gen-art: warning: {message}")


def _print_error(text: str) -> None:
    click.echo(text, err=True)


def _status(error: BaseException) -> int:
    """Print an error and return its exit status."""
    if isinstance(error, click.exceptions.Exit):
        return error.exit_code
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        _print_error("gen-art: stopped")
        return 130
    if isinstance(error, _Terminated):
        _print_error("gen-art: terminated")
        return 143
    if isinstance(error, click.ClickException):
        error.show()
        return 2
    if os.environ.get("GEN_ART_DEBUG"):
        traceback.print_exception(error)
    if isinstance(error, PresetError):
        return _print_problems(error)
    if isinstance(error, GenArtError):
        _print_error(f"gen-art: {error}")
        return error.exit_code
    if isinstance(error, BrokenPipeError):
        return 0
    if isinstance(error, MemoryError):
        _print_error("gen-art: out of memory. Try fewer particles, a smaller --size or --quality draft")
        return 4
    if isinstance(error, OSError):
        where = f" ({error.filename})" if error.filename else ""
        _print_error(f"gen-art: {error.strerror or error}{where}")
        return 4 if error.errno == errno.ENOMEM else 5
    if isinstance(error, SystemExit):
        return error.code if isinstance(error.code, int) else 1
    words = " ".join(str(error).split())[:300]
    _print_error(
        f"gen-art: this is a bug: {type(error).__name__}: {words}\n"
        "GEN_ART_DEBUG=1 before the command shows the traceback"
    )
    return 1


def _print_problems(error: PresetError) -> int:
    """Print the problems of a preset and return the exit status."""
    from gen_art.preset.problems import report

    problems = getattr(error, "problems", None)
    _print_error(report(problems, _MAX_PROBLEMS) if problems else str(error))
    return error.exit_code
