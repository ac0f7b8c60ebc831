"""`gen-art bench`: the measurements in benchmarks/, side by side with the peers that are installed."""

import subprocess
import sys
from pathlib import Path

import click

from gen_art.errors import GenArtError, UsageError

__all__ = ["command"]


@click.command("bench")
@click.argument("names", nargs=-1)
def command(names):
    """Run benchmarks side by side with peers.

    NAMES, or all; each writes its figures as JSON, with the machine, in benchmarks/.
    """
    folder = Path(__file__).resolve().parent.parent.parent / "benchmarks"
    scripts = {path.stem: path for path in sorted(folder.glob("[!_]*.py"))}
    if not scripts:
        raise UsageError("the benchmarks are part of the source checkout, not of the installed package")
    for name in names:
        if name not in scripts:
            from gen_art.registry import suggest

            raise UsageError(f"no benchmark '{name}'{suggest(name, scripts) or '; there are ' + ', '.join(scripts)}")
    failed = [name for name in names or scripts if subprocess.run([sys.executable, str(scripts[name])]).returncode]
    if failed:
        raise GenArtError(f"failed: {', '.join(failed)}")
