"""`gen-art`: finds the command, and turns every error into a sentence and an exit status.

0 done, 1 a bug, 2 wrong usage, 3 a bad preset, 4 refused for want of memory or disk, 5 input/output failed,
6 the encoder failed, 130 and 143 stopped by a signal.
"""

import difflib
import errno
import gc
import importlib
import os
import signal
import sys
import traceback

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
_SCREEN = 8  # problems shown by commands other than validate


class _Terminated(BaseException):
    """SIGTERM arrived."""


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
            raise click.UsageError(f"no command '{args[0]}'; {hint}", context)
        return super().resolve_command(context, args)


def _version(context, parameter, value):
    if value and not context.resilient_parsing:
        from gen_art import __version__

        click.echo(f"gen-art {__version__}")
        context.exit()


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_version, help="Say which version."
)
def cli():
    """Physics makes the picture: render presets of particles to films and stills.

    A PRESET is a name (gen-art list), the path of a YAML file, or - for standard input.
    """


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave the process with its exit status."""
    # imports and tracing make much that stays: looking for rubbish among it finds none
    gc.set_threshold(50_000, 20, 20)
    leave(run(sys.argv[1:] if arguments is None else arguments))


def leave(status: int) -> None:
    """End the process."""
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if "gen_art.backend.runtime" in sys.modules:
        sys.modules["gen_art.backend.runtime"].finish()
    gc.freeze()  # or the interpreter looks through all that tracing made for what could be freed: a quarter of a second
    sys.exit(status)


def run(arguments: list[str]) -> int:
    """Run one command; its exit status."""
    restore = _on_sigterm()
    try:
        status = cli.main(arguments, prog_name="gen-art", standalone_mode=False)
        return status if isinstance(status, int) else 0
    except BaseException as error:
        status = _status(error)
        first = error.__cause__ if isinstance(error, click.Abort) else error  # click's own word for KeyboardInterrupt
        for note in getattr(first, "__notes__", ()):
            _say(f"gen-art: {note}")
        return status
    finally:
        restore()


def _on_sigterm():
    """Let SIGTERM unwind the stack, so that half-written files are removed; returns the undoing."""

    def stop(number, frame):
        raise _Terminated

    try:
        before = signal.signal(signal.SIGTERM, stop)
    except ValueError:  # not the main thread
        return lambda: None
    return lambda: signal.signal(signal.SIGTERM, before)


def _say(text: str) -> None:
    click.echo(text, err=True)


def _status(error: BaseException) -> int:
    """The exit status of an error, after saying what happened."""
    if isinstance(error, click.exceptions.Exit):
        return error.exit_code
    if isinstance(error, (KeyboardInterrupt, click.Abort)):
        _say("gen-art: stopped")
        return 130
    if isinstance(error, _Terminated):
        _say("gen-art: terminated")
        return 143
    if isinstance(error, click.ClickException):
        error.show()
        return 2
    if os.environ.get("GEN_ART_DEBUG"):
        traceback.print_exception(error)
    if isinstance(error, PresetError):
        return _bad_preset(error)
    if isinstance(error, GenArtError):
        _say(f"gen-art: {error}")
        return error.exit_code
    if isinstance(error, BrokenPipeError):
        return 0
    if isinstance(error, MemoryError):
        _say("gen-art: out of memory. Try fewer particles, a smaller --size or --quality draft")
        return 4
    if isinstance(error, OSError):
        where = f" ({error.filename})" if error.filename else ""
        _say(f"gen-art: {error.strerror or error}{where}")
        return 4 if error.errno == errno.ENOMEM else 5
    if isinstance(error, SystemExit):
        return error.code if isinstance(error.code, int) else 1
    words = " ".join(str(error).split())[:300]
    _say(
        f"gen-art: this is a bug: {type(error).__name__}: {words}\n"
        "GEN_ART_DEBUG=1 before the command shows the traceback"
    )
    return 1


def _bad_preset(error: PresetError) -> int:
    from gen_art.preset.problems import report

    problems = getattr(error, "problems", None)
    _say(report(problems, _SCREEN) if problems else str(error))
    return error.exit_code
