"""`gen-art rerun`: a picture again, from the recipe inside it."""

import click

from gen_art.commands import options

__all__ = ["command"]


@click.command("rerun")
@click.argument("picture")
@click.option("-o", "--output", "out", required=True, metavar="OUT", help="Where the picture is written.")
@click.option("--overwrite", is_flag=True, help="Replace output that exists.")
@click.option("--plugin", "plugins", multiple=True, metavar="FILE.py", help="The plugins of the recipe, byte for byte.")
@click.option(
    "--folder", metavar="DIR", help="Where the preset's own files lie; here, or beside PICTURE, when left out."
)
@options.process_options
def command(picture, out, overwrite, plugins, folder, threads, progress):
    """Make PICTURE again from the recipe inside it.

    The preset, seed, size and version are in its metadata; the result is the same, byte for byte.
    """
    from gen_art.commands.progress import reporter
    from gen_art.output import job
    from gen_art.plugins import load_plugin

    loaded = tuple(load_plugin(path) for path in plugins)
    with reporter(progress) as report:
        paths = job.rerun(
            picture, out, threads=threads, overwrite=overwrite, progress=report, plugins=loaded, folder=folder
        )
    for path in paths:
        click.echo(path)
