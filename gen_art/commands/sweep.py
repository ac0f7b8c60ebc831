"""`gen-art sweep`: a film or picture of each of many variations of a preset."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("sweep")
@click.argument("preset")
@click.option(
    "-o", "--output", "out", required=True, metavar="OUT",
    help="A path with {seed}, {number} or the name of what varies in it: 'out/{seed}_{heat}.mp4'.",
)  # fmt: skip
@options.vary_options
@click.option("--frames", type=options.FRAMES, help="Of films: 12, 0..89 or 0..99..10 (first..last..step).")
@click.option("--time", type=options.NOT_NEGATIVE, help="Of pictures: film time in seconds.")
@options.film_options
@options.picture_options
@options.preset_options
@options.run_options
@click.option("--workers", type=click.IntRange(1, 1024), help="Number of processes that share the work.")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler whose workers do the work: tcp://10.0.0.5:8786.")
def command(
    preset, out, seeds, vary, mutate, count, frames, time, codec, profile, bits, size, scale, quality, overwrite, transparent,
    dry_run, seed, settings, fps, duration, plugins, precision, threads, progress,
    workers, scheduler,
):  # fmt: skip
    """Make a film, or a picture, of each of many variations of PRESET.

    \b
    gen-art sweep fire -o 'takes/{seed}.mp4' --seeds 0..99
    gen-art sweep fire -o 'heat/{heat}.png' --vary knobs.heat=1200..1900..8
    gen-art sweep fire -o 'all/{seed}_{heat}.mp4' --seeds 0..3 --vary knobs.heat=1300,1700

    The file extension of OUT says which, as for render and still. A sweep that was stopped goes on when the same command is
    run again: files that it has made are left as they are. Between the files nothing is compiled.

    With --workers 4 four processes of this machine share the work, with --scheduler those of a cluster: docs/farm.md.
    """
    if workers is not None and scheduler is not None:
        raise click.UsageError(
            "--workers starts processes here, and --scheduler uses those of a cluster: give one of them"
        )
    source, changes, loaded = options.source(preset, seed, settings, fps, duration, plugins)
    rows = options.grid(source, changes, seeds, vary, mutate, count)
    from gen_art.commands.progress import reporter
    from gen_art.output.sweep import plan_sweep, sweep

    units = plan_sweep(
        source, out, rows, overrides=changes, overwrite=overwrite, time=time, frames=frames, plugins=loaded, size=size,
        scale=scale, quality=quality, transparent=transparent, codec=codec, profile=profile, bits=int(bits) if bits else None,
        precision=precision,
    )  # fmt: skip
    made = sum(unit.is_made for unit in units)
    if dry_run:
        for unit in units:
            echo(f"{unit.path}: {unit.label}{', made already' if unit.is_made else ''}")
        return
    if made:
        echo(f"{made} of {len(units)} are made already", err=True)
    if workers is not None or scheduler is not None:
        paths = _on_farm(units, workers, scheduler, threads, overwrite, loaded, progress)
    else:
        with reporter(progress) as report:
            begin = (
                None
                if progress in ("json", "none")
                else lambda k, unit: echo(f"{k + 1} of {len(units)}: {unit.path}", err=True)
            )
            paths = sweep(units, threads=threads, overwrite=overwrite, plugins=loaded, progress=report, begin=begin)
    for path in paths:
        echo(path)


def _on_farm(units, workers, scheduler, threads, overwrite, plugins, progress):
    """Make the units on several processes; a line, or an event of JSON, for each that is made."""
    from gen_art.commands.progress import reporter
    from gen_art.output.farm import sweep_on_farm

    def tell(sentence):
        if progress not in ("json", "none"):
            echo(sentence, err=True)

    with reporter(progress if progress in ("json", "none") else "none") as report:

        def done(k, unit):
            if report is not None:
                report({"event": "unit", "unit": k, "units": len(units), "path": str(unit.path)})
            else:
                tell(f"{k} of {len(units)}: {unit.path}")

        return sweep_on_farm(
            units, workers=workers, scheduler=scheduler, threads=threads, overwrite=overwrite, plugins=plugins,
            tell=tell, done=done,
        )  # fmt: skip
