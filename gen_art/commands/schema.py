"""`gen-art schema`: prints the JSON Schema of presets."""

import click

from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("schema")
@click.option("--plugin", "plugins", multiple=True, metavar="FILE.py", help="Include a plugin's forces and emitters.")
def command(plugins):
    """Print the JSON Schema of presets.

    With it a YAML editor completes and checks presets. It has every key with its meaning, unit, range and default.
    """
    import json

    from gen_art.plugins import load_plugin
    from gen_art.preset.schema import json_schema

    for path in plugins:
        load_plugin(path)
    echo(json.dumps(json_schema(), indent=2, ensure_ascii=False))
