"""`gen-art`: runs a command, and turns every error into a message and an exit status.

0 success, 1 a bug, 2 wrong usage or no Taichi of the right version, 3 a wrong preset or numbers that are no longer finite,
4 not enough memory, 5 input or output failed, 6 the encoder failed; stopped by a signal: 130
(Ctrl+C), 143 (SIGTERM), 129 (SIGHUP).
"""

import contextlib
import difflib
import errno
import gc
import importlib
import io
import os
import signal
import sys
import traceback
import warnings

import click

from gen_art.commands.terminal import echo
from gen_art.errors import GenArtError, OutputError, PresetError, UsageError

__all__ = ["cli", "main", "print_error", "run"]

COMMANDS = (
    "render",
    "still",
    "watch",
    "rerun",
    "sheet",
    "sweep",
    "studio",
    "list",
    "show",
    "new",
    "schema",
    "validate",
    "inspect",
    "audit",
    "check",
    "digests",
    "gallery",
    "bench",
    "doctor",
)
_MAX_PROBLEMS = 8  # problems of a preset that commands other than validate print


class _Terminated(BaseException):
    """The process received SIGTERM or SIGHUP, whose number is the argument."""


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

        echo(f"gen-art {__version__}")
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
    _open_standard_files()
    # imports and tracing create many objects that live on, so frequent garbage collections would only cost time
    gc.set_threshold(50_000, 20, 20)
    leave(run(sys.argv[1:] if arguments is None else arguments))


def _open_standard_files() -> None:
    """Put the null device where standard input, output or error is closed; a file would otherwise get its number."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115  (for the life of the process)


def leave(status: int) -> None:
    """End the process with this exit status."""
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if "gen_art.backend.runtime" in sys.modules:
        try:
            sys.modules["gen_art.backend.runtime"].finish()
        except OutputError as error:  # the result is written, so this changes no exit status
            echo(f"gen-art: warning: {error}", err=True)
            os._exit(status)
    gc.freeze()  # skips the last garbage collection of the objects that tracing made, which takes 0.25 s
    sys.exit(status)


def run(arguments: list[str]) -> int:
    """Run one command and return its exit status."""
    restore = _on_signals()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", UserWarning)
            warnings.showwarning = _print_warning
            if any("\0" in argument for argument in arguments):  # no file's name can contain it
                raise UsageError("an argument contains the character 0")
            status = cli.main(arguments, prog_name="gen-art", standalone_mode=False)
        return status if isinstance(status, int) else 0
    except BaseException as error:
        status = print_error(error)
        original = (
            error.__cause__ if isinstance(error, click.Abort) else error
        )  # click turns KeyboardInterrupt into Abort
        for note in getattr(original, "__notes__", ()):
            echo(f"gen-art: {note}", err=True)
        return status
    finally:
        restore()


def _print_warning(message, category, filename, lineno, file=None, line=None) -> None:
    if issubclass(category, UserWarning):
        echo(f"gen-art: warning: {message}", err=True)


def _on_signals():
    """Make SIGTERM, and the SIGHUP of a terminal that closes, raise an exception, so that incomplete files are removed.

    Returns a function that undoes this.
    """

    def stop(number, frame):
        raise _Terminated(number)

    before = {}
    with contextlib.suppress(ValueError):  # not the main thread
        for number in {signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)}:
            if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup sets it
                before[number] = signal.signal(number, stop)
    return lambda: [signal.signal(number, handler) for number, handler in before.items()]


def print_error(error: BaseException) -> int:
    """Print an error and return its exit status."""
    if isinstance(error, click.exceptions.Exit):
        return error.exit_code
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        echo("gen-art: stopped", err=True)
        return 130
    if isinstance(error, _Terminated):
        echo("gen-art: terminated", err=True)
        return 128 + error.args[0]
    if isinstance(error, click.ClickException):
        message = io.StringIO()
        error.show(message)
        echo(message.getvalue(), err=True, nl=False)
        return 2
    if os.environ.get("GEN_ART_DEBUG"):
        echo("".join(traceback.format_exception(error)), err=True)
    if isinstance(error, PresetError):
        return _print_problems(error)
    if isinstance(error, GenArtError):
        echo(f"gen-art: {error}", err=True)
        return error.exit_code
    if isinstance(error, BrokenPipeError):
        return 0
    from gen_art.backend.memory import out_of_memory

    if out_of_memory(error):
        echo(
            "gen-art: out of memory, or past a limit of it (ulimit -v). Try fewer particles, a smaller --size or --quality draft",
            err=True,
        )
        return 4
    if isinstance(error, OSError):
        where = f" ({error.filename})" if error.filename else ""
        echo(f"gen-art: {error.strerror or error}{where}", err=True)
        return 4 if error.errno == errno.ENOMEM else 5
    if isinstance(error, SystemExit):
        return error.code if isinstance(error.code, int) else 1
    words = " ".join(str(error).split())[:300]
    echo(
        f"gen-art: this is a bug: {type(error).__name__}: {words}\n"
        "GEN_ART_DEBUG=1 before the command shows the traceback",
        err=True,
    )
    return 1


def _print_problems(error: PresetError) -> int:
    """Print the problems of a preset and return the exit status."""
    from gen_art.preset.problems import report

    problems = getattr(error, "problems", None)
    echo(report(problems, _MAX_PROBLEMS) if problems else str(error), err=True)
    return error.exit_code
