"""`gen-art list`: the presets and the palettes that are there."""

import click

__all__ = ["command"]


@click.command("list")
@click.argument("what", type=click.Choice(["presets", "palettes"]), default="presets")
def command(what):
    """Name the presets, each with the first line of its file; or the palettes, each with what it is made for."""
    if what == "palettes":
        from gen_art.preset.palettes import PALETTES, PERCEPTUAL

        for name in PALETTES:
            click.echo(f"{name:12} {'perceptual: lighter from end to end' if name in PERCEPTUAL else 'artistic'}")
        return
    from gen_art.preset.shipped import preset_names, presets_folder

    for name in preset_names():
        with open(presets_folder() / f"{name}.yaml", encoding="utf-8") as file:
            click.echo(f"{name:12} {file.readline().lstrip('# ').strip()}")
