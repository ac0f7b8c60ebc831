"""`gen-art list`: lists the presets, and everything that a preset can name."""

import click

from gen_art.commands.terminal import echo

__all__ = ["command"]

_REGISTRIES = ("forces", "shapes", "velocities", "emitters", "interactions", "colliders")


@click.command("list")
@click.argument(
    "what", type=click.Choice(["presets", "course", *_REGISTRIES, "integrators", "palettes"]), default="presets"
)
@click.option("--plugin", "plugins", multiple=True, metavar="FILE.py", help="Include a plugin's forces and emitters.")
def command(what, plugins):
    """List the presets, or the names that a preset can use, one on a line.

    `course` lists the small presets that show one law of physics each. The others list the names that YAML can have under
    forces:, shape:, velocity:, emitters:, interactions:, colliders: and integrator:, and the palettes. docs/forces.md has
    their formulas.
    """
    from gen_art.plugins import load_plugin

    for path in plugins:
        load_plugin(path)
    rows = _rows(what)
    width = max(12, *(len(name) for name, _ in rows))
    for name, description in rows:
        echo(f"{name:{width}} {description}")


def _rows(what: str) -> list[tuple[str, str]]:
    if what in _REGISTRIES:
        from gen_art.preset.registered import registry

        classes = registry(what)
        return [
            (name, " ".join((classes[name].__doc__ or "").strip().split("\n\n")[0].split())) for name in sorted(classes)
        ]
    if what == "integrators":
        from gen_art.integrators import INTEGRATORS

        return [(name, f"order {scheme.order}; {scheme.doc}") for name, scheme in INTEGRATORS.items()]
    if what == "palettes":
        from gen_art.preset.palettes import PALETTES, PERCEPTUAL

        return [
            (n, "perceptual: lightness increases from end to end" if n in PERCEPTUAL else "artistic") for n in PALETTES
        ]
    from gen_art.preset.shipped import course_names, preset_names, presets_folder

    rows = []
    for name in course_names() if what == "course" else preset_names():
        with open(presets_folder() / f"{name}.yaml", encoding="utf-8") as file:
            rows.append((name, file.readline().lstrip("# ").strip()))
    return rows
