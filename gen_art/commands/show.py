"""`gen-art show`: prints the YAML of a preset, of a changed preset, or of the preset inside a picture."""

from pathlib import Path

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]

_PICTURES = (".png", ".jpg", ".jpeg", ".webp", ".gif", ".exr", ".mp4", ".mov", ".webm", ".mkv")


@click.command("show")
@click.argument("preset")
@click.option("--resolved", is_flag=True, help="Print JSON, with knobs, options and --set filled in.")
@options.preset_options
def command(preset, resolved, seed, settings, fps, duration, plugins):
    """Print the YAML of PRESET.

    --set, --seed, --fps and --duration change values in it; comments and layout stay. PRESET may also be a picture or film
    made by gen-art: its preset is printed, with knobs filled in.
    """
    if Path(preset).suffix.lower() in _PICTURES:
        from gen_art.output.read_recipe import read_recipe
        from gen_art.output.recipe import check_complete
        from gen_art.particles.entries import LedgerEntry
        from gen_art.preset.overrides import plain
        from gen_art.preset.writing import yaml_text

        recipe = read_recipe(preset)
        check_complete(recipe)
        made = f"{recipe['name']}, from {Path(preset).name}, made by gen-art {recipe['gen_art']}"
        lines = [made]
        for entry in recipe.get("joules", ()):
            title = LedgerEntry.of(entry["by"]).title
            lines.append(f"{entry['system']}: {title}: {entry['total']:.6g} {entry['unit']} in all")
        for line in lines:
            echo(f"# {' '.join(line.split())}")
        preset = recipe["preset"] | {"name": recipe["name"]}
        if not (resolved or seed is not None or settings or fps or duration):
            echo(yaml_text(plain(recipe["preset"])), nl=False)
            return
    overrides = options.overrides(settings, fps, duration)
    if not resolved and not isinstance(preset, dict):
        from gen_art.preset.load import open_source
        from gen_art.preset.writing import changed_text

        source, _ = open_source(preset)
        text = "\n".join(source.lines)
        if overrides or seed is not None:
            changed, _ = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
            if seed is not None:
                overrides |= {"seed": changed.seed}
            text = changed_text(text, overrides).rstrip("\n") + "\n"
        echo(text, nl=bool(source.lines[-1]) and not text.endswith("\n"))
        return
    preset, _ = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    if resolved:
        import json

        echo(json.dumps(preset.resolved(), indent=2, ensure_ascii=False))
    else:
        from gen_art.preset.writing import yaml_text

        echo(yaml_text(preset.resolved()), nl=False)
