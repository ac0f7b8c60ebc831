"""`gen-art audit`: runs a preset and prints its ledger and convergence order."""

import click

from gen_art.commands import options

__all__ = ["command"]


@click.command("audit")
@click.argument("preset")
@click.option(
    "--time", type=options.POSITIVE, help="Film time to run to; 2 s, or 1 s with mutual forces, when left out."
)
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@options.preset_options
@options.run_options
def command(preset, time, as_json, seed, settings, fps, duration, plugins, precision, threads, progress):
    """Print the ledger and the convergence of PRESET.

    A copy with few particles runs in f64 at dt, dt/2 and dt/4: what was born, died, worked and dissipated, the
    residual, and the order at which it falls. --precision f32 states its floor too.
    """
    piece, _ = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    import json

    from gen_art.audit import audit

    report = audit(piece, time=time, precision=precision, threads=threads)
    click.echo(json.dumps(report.as_dict(), indent=2) if as_json else report.text())
