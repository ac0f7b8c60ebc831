"""The one place that prints. Text from a file cannot steer the terminal: control characters are shown escaped."""

import re
import sys

import click

from gen_art.errors import OutputError

__all__ = ["echo", "escaped"]

# control characters but line feed and tab, separators of lines, marks that reverse the direction of text, and halves of
# characters, as which Python reads the bytes of a file name that is no UTF-8
_STEERING = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def escaped(text: str) -> str:
    """The text with `\\u001b` for such a character, as JSON and YAML write it."""
    return _STEERING.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def echo(text: object, err: bool = False, nl: bool = True) -> None:
    """Print on standard output, or on standard error. Raises OutputError where standard output is closed."""
    stream = sys.stderr if err else sys.stdout
    if stream is None:
        if err:
            return
        raise OutputError("cannot print the result: standard output is closed")
    encoding = getattr(stream, "encoding", None) or "utf-8"
    words = escaped(str(text)).encode(encoding, "backslashreplace").decode(encoding)
    click.echo(words, nl=nl, err=err)
