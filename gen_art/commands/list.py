"""`gen-art list`: the presets that are there."""

import click

__all__ = ["command"]


@click.command("list")
def command():
    """Name the presets, each with the first line of its file."""
    from gen_art.preset.shipped import preset_names, presets_folder

    for name in preset_names():
        with open(presets_folder() / f"{name}.yaml", encoding="utf-8") as file:
            click.echo(f"{name:12} {file.readline().lstrip('# ').strip()}")
