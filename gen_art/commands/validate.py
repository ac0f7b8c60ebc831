"""`gen-art validate`: lists every problem of each file."""

import click

from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("validate")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option(
    "--plugin", "plugins", multiple=True, metavar="FILE.py", help="Load forces and emitters from a Python file."
)
@click.pass_context
def command(context, files, plugins):
    """List every problem of each FILE.

    Each problem has its line and column. A FILE may also be the name of a preset. Problems are printed on standard error;
    the exit status is 3 if there are any, 5 if a file cannot be read. Parts that have no effect are printed as warnings.
    """
    from gen_art.errors import GenArtError
    from gen_art.output.check import check_preset
    from gen_art.plugins import load_plugin
    from gen_art.preset.load import load_preset
    from gen_art.simulation.no_effect import silent_parts, undrawn_systems

    for path in plugins:
        load_plugin(path)
    worst = 0
    for file in files:
        try:
            preset = load_preset(file)
            check_preset(preset)
        except GenArtError as error:
            echo(str(error), err=True)
            worst = max(worst, error.exit_code)
        else:
            for sentence in (*silent_parts(preset), *undrawn_systems(preset)):
                echo(f"{file}: warning: {sentence}", err=True)
            echo(f"{file}: ok")
    context.exit(worst)
