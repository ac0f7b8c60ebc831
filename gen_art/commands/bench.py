"""`gen-art bench`: runs the benchmarks in benchmarks/, also for comparable programs that are installed."""

import subprocess
import sys
from pathlib import Path

import click

from gen_art.errors import GenArtError, UsageError

__all__ = ["command"]


@click.command("bench")
@click.argument("names", nargs=-1)
def command(names):
    """Run the benchmarks NAMES, or all of them.

    Comparable programs that are installed are measured too. Each benchmark writes its figures and the machine's name as JSON
    in benchmarks/.
    """
    folder = Path(__file__).resolve().parent.parent.parent / "benchmarks"
    scripts = {path.stem: path for path in sorted(folder.glob("[!_]*.py"))}
    if not scripts:
        raise UsageError("the benchmarks are part of the source checkout, not of the installed package")
    for name in names:
        if name not in scripts:
            from gen_art.registry import suggest

            hint = suggest(name, scripts) or "; there are " + ", ".join(scripts)
            raise UsageError(f"there is no benchmark '{name}'{hint}")
    failed = [name for name in names or scripts if subprocess.run([sys.executable, str(scripts[name])]).returncode]
    if failed:
        raise GenArtError(f"failed: {', '.join(failed)}")
