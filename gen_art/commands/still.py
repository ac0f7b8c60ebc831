"""`gen-art still`: one developed picture."""

import click

from gen_art.commands import options

__all__ = ["command"]


@click.command("still")
@click.argument("preset")
@click.option("-o", "--output", "out", required=True, metavar="OUT", help="The picture: .png .jpg .webp .exr.")
@click.option("--time", type=options.NOT_NEGATIVE, required=True, help="Film time, seconds.")
@options.picture_options
@options.preset_options
@options.run_options
def command(
    preset, out, time, size, scale, quality, overwrite, transparent, dry_run,
    seed, settings, fps, duration, plugins, precision, threads, progress,
):  # fmt: skip
    """Make one picture of PRESET at film time T."""
    piece, loaded = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    from gen_art.commands.progress import reporter
    from gen_art.preset.estimate import refuse_if_too_large

    shape = options.picture_size(piece, size, scale)
    until = piece.clock.preroll + time * piece.clock.speed
    expected = refuse_if_too_large(piece, precision, shape, until)
    from gen_art.output import job

    if dry_run:
        job.check_target(piece, out, size=shape, overwrite=overwrite, moving=False, transparent=transparent)
        click.echo(f"{out}: {shape[0]}x{shape[1]} at {time:g} s, {expected}")
        return
    with reporter(progress) as report:
        paths = job.still(
            piece, out, time, size=shape, quality=quality, precision=precision, threads=threads,
            overwrite=overwrite, transparent=transparent, progress=report, plugins=loaded,
        )  # fmt: skip
    for path in paths:
        click.echo(path)
