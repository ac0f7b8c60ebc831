"""`gen-art rerun`: makes a picture again from the recipe inside it."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("rerun")
@click.argument("picture")
@click.option("-o", "--output", "out", required=True, metavar="OUT", help="Where the picture is written.")
@click.option("--overwrite", is_flag=True, help="Replace output that exists.")
@click.option(
    "--plugin", "plugins", multiple=True, metavar="FILE.py", help="A plugin of the recipe, with the same bytes."
)
@click.option("--folder", metavar="DIR", help="The folder of the preset's files.")
@click.option("--cell", type=options.CELL, help="Of a sheet, make the cell in this column and row in full size: 3,2.")
@click.option("--other-version", is_flag=True, help="Accept a picture of another version of gen-art, with a warning.")
@options.process_options
def command(picture, out, overwrite, plugins, folder, cell, other_version, threads, progress):
    """Make PICTURE, also a film or a sheet, again from the recipe inside it.

    The result has the same bytes. This needs the version of gen-art that made PICTURE, its plugins (--plugin) and the files
    that its preset names: the recipe contains the small ones; others are looked for in the current folder and beside
    PICTURE, or in --folder.
    """
    from gen_art.commands.progress import reporter
    from gen_art.output.rerun import rerun
    from gen_art.plugins import load_plugin

    loaded = tuple(load_plugin(path) for path in plugins)
    with reporter(progress) as report:
        paths = rerun(
            picture, out, threads=threads, overwrite=overwrite, progress=report, plugins=loaded, folder=folder,
            other_version=other_version, cell=cell,
        )  # fmt: skip
    for path in paths:
        echo(path)
