"""`gen-art new`: writes a new preset with the files that it needs."""

import os
import shutil
from pathlib import Path

import click

from gen_art.commands.terminal import echo
from gen_art.errors import UsageError
from gen_art.files import beside, replaces

__all__ = ["command"]


@click.command("new")
@click.argument("name")
@click.option("--from", "source", metavar="PRESET", help="The preset to start from: a name or a path.")
@click.option("--overwrite", is_flag=True, help="Replace files that exist.")
def command(name, source, overwrite):
    """Write NAME.yaml, a commented preset that you can change.

    It is a small fountain of sparks, or with --from a copy of PRESET with the pictures and tables that PRESET names. NAME may
    contain a folder, which is created: mine/sparks.
    """
    from gen_art.preset.load import load_preset, open_source
    from gen_art.preset.shipped import find, starter

    target = Path(name)
    if not target.name or target.name.startswith(".") or "\0" in name or source == "-":
        raise UsageError("give the new preset a name, and --from the name or path of a preset")
    if target.suffix.lower() not in (".yaml", ".yml"):
        target = target.with_name(f"{target.name}.yaml")
    origin = find(source) if source else starter()
    text, _ = open_source(origin)
    preset = load_preset(origin)
    copies = {target.parent / str(file): file.place for file in preset.files}
    same = {path for path, place in copies.items() if path.is_file() and path.read_bytes() == place.read_bytes()}
    for path in (target, *copies):
        if os.path.lexists(path) and not overwrite and path not in same:
            raise replaces(path)
    for path in copies.keys() - same:
        with beside(path, overwrite) as temporary:
            shutil.copyfile(copies[path], temporary)
    with beside(target, overwrite) as temporary:
        temporary.write_text("\n".join(text.lines), encoding="utf-8")
    for path in (target, *copies):
        echo(path)
