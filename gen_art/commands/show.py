"""`gen-art show`: a preset's text, or what it comes to."""

import click

from gen_art.commands import options

__all__ = ["command"]


@click.command("show")
@click.argument("preset")
@click.option("--resolved", is_flag=True, help="As JSON, with knobs, options and --set filled in.")
@options.preset_options
def command(preset, resolved, seed, settings, fps, duration, plugins):
    """Print the YAML of PRESET: the text to start your own from."""
    changed = seed is not None or settings or fps or duration
    if not resolved and not changed:
        from gen_art.preset.load import open_source

        source, _ = open_source(preset)
        click.echo("\n".join(source.lines), nl=bool(source.lines[-1]))
        return
    import json

    piece, _ = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    click.echo(json.dumps(piece.resolved(), indent=2, ensure_ascii=False))
