"""`gen-art sheet`: many variations of a preset in one picture."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("sheet")
@click.argument("preset")
@click.option("-o", "--output", "out", required=True, metavar="OUT", help="The picture: .png .jpg .webp.")
@options.vary_options
@options.TIME
@click.option("--cell", type=options.SIZE, help="Width and height of a cell in pixels; 320 wide when left out.")
@click.option("--overwrite", is_flag=True, help="Replace output that exists.")
@options.preset_options
@options.run_options
def command(
    preset, out, seeds, vary, mutate, count, time, cell, overwrite,
    seed, settings, fps, duration, plugins, precision, threads, progress,
):  # fmt: skip
    """Make one picture of many variations of PRESET, each with its words below it.

    \b
    gen-art sheet fire -o seeds.png --seeds 0..15
    gen-art sheet fire -o heat.png --vary knobs.heat=1200..1900..6
    gen-art sheet fire -o both.png --vary knobs.heat=1200..1900..4 --vary knobs.turbulence=1,2,3
    gen-art sheet fire -o wild.png --mutate 20% --count 16

    --seeds and --vary are named once or twice in all; of two, the first has a row for each value, the second a column.
    --mutate changes every knob that is a number, within its range, and --seed chooses other mutations. `gen-art rerun
    sheet.png --cell 3,2 -o x.png` makes the cell in column 3, row 2 in full size.
    """
    source, changes, loaded = options.source(preset, seed, settings, fps, duration, plugins)
    rows = options.grid(source, changes, seeds, vary, mutate, count)
    from gen_art.commands.progress import reporter
    from gen_art.output.sheet import make_sheet

    with reporter(progress) as report:
        paths = make_sheet(
            source, out, rows, time=time, size=cell, precision=precision, threads=threads, overwrite=overwrite,
            progress=report, plugins=loaded, overrides=changes,
        )  # fmt: skip
    for path in paths:
        echo(path)
