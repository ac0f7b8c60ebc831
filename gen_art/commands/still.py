"""`gen-art still`: one developed picture."""

import click

from gen_art.commands import options

__all__ = ["command"]


@click.command("still")
@click.argument("preset")
@click.option("-o", "--output", "out", required=True, metavar="OUT", help="The picture: .png .jpg .webp.")
@click.option("--time", type=options.NOT_NEGATIVE, required=True, help="Film time, seconds.")
@click.option(
    "--bits", type=click.Choice(["8", "16"]), default="8", show_default=True, help="Bits a channel; 16 as .png."
)
@options.picture_options
@options.preset_options
@options.run_options
def command(
    preset, out, time, bits, size, scale, quality, overwrite, transparent, dry_run,
    seed, settings, fps, duration, plugins, precision, threads, progress,
):  # fmt: skip
    """Make one picture of PRESET at film time T."""
    piece, loaded = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    from gen_art.commands.progress import reporter
    from gen_art.output import job
    from gen_art.preset.estimate import refuse_if_too_large

    shape = job.picture_size(piece, size, scale, quality)
    expected = refuse_if_too_large(piece, precision, shape, piece.clock.preroll + time * piece.clock.speed)
    if dry_run:
        job.check_target(piece, out, size=shape, overwrite=overwrite, moving=False, transparent=transparent)
        click.echo(f"{out}: {shape[0]}x{shape[1]} at {time:g} s, {expected}")
        return
    with reporter(progress) as report:
        paths = job.still(
            piece, out, time, size=size, scale=scale, quality=quality, precision=precision, threads=threads,
            overwrite=overwrite, transparent=transparent, bits=int(bits), progress=report, plugins=loaded,
        )  # fmt: skip
    for path in paths:
        click.echo(path)
