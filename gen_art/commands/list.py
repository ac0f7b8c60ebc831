"""`gen-art list`: the presets and the palettes that are there."""

import click

__all__ = ["command"]


@click.command("list")
@click.argument("what", type=click.Choice(["presets", "course", "palettes"]), default="presets")
def command(what):
    """Name the presets, each with the first line of its file.

    `course` names the small ones that show one law each; `palettes` the palettes, each with what it is made for.
    """
    if what == "palettes":
        from gen_art.preset.palettes import PALETTES, PERCEPTUAL

        for name in PALETTES:
            click.echo(f"{name:12} {'perceptual: lighter from end to end' if name in PERCEPTUAL else 'artistic'}")
        return
    from gen_art.preset.shipped import course_names, preset_names, presets_folder

    names = course_names() if what == "course" else preset_names()
    width = max(12, *map(len, names))
    for name in names:
        with open(presets_folder() / f"{name}.yaml", encoding="utf-8") as file:
            click.echo(f"{name:{width}} {file.readline().lstrip('# ').strip()}")
