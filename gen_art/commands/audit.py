"""`gen-art audit`: runs a preset and prints its ledger and convergence order."""

from pathlib import Path

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("audit")
@click.argument("preset")
@click.option(
    "--time",
    type=options.POSITIVE,
    help="Film time to run to; 2 s, or 1 s with mutual forces or stiff springs, when left out.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("-o", "--output", help="Also write plots: .png, .svg, or .html with the text. Needs matplotlib.")
@click.option("--overwrite", is_flag=True, help="Replace OUTPUT if it exists.")
@options.preset_options
@options.run_options
def command(
    preset, time, as_json, output, overwrite, seed, settings, fps, duration, plugins, precision, threads, progress
):
    """Print the ledger and the convergence of PRESET.

    A copy with few particles runs in f64 at dt, dt/2 and dt/4. The report lists births, deaths, work and dissipation, the
    residual, and the order at which it falls. With --precision f32 it also gives the rounding error of f32. -o writes plots
    of energy, momentum, paths and convergence.
    """
    path = Path(output) if output else None
    if path is not None:
        from gen_art.audit.plots import MOMENTS, check_plots
        from gen_art.files import beside
        from gen_art.output.target import check_writable

        check_plots(path)
        check_writable([path], overwrite)
    preset, _ = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    import json

    from gen_art.audit import audit

    more = {"moments": MOMENTS} if path is not None else {}
    report = audit(preset, time=time, precision=precision, threads=threads, **more)
    if path is not None:
        from gen_art.audit.plots import draw

        with beside(path, overwrite) as temporary:
            draw(report, temporary)
    echo(json.dumps(report.as_dict(), indent=2) if as_json else report.text())
