"""`gen-art check`: whether what presets expect of their motion holds."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("check")
@click.argument("presets", nargs=-1, metavar="[PRESET]...")
@click.option(
    "--expect", "against", metavar="PRESET", help="Take `expect:` from this preset instead, as a teacher would."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--keep/--no-keep", default=True, show_default=True, help="Keep the verdicts in verdicts.json beside each preset."
)
@options.preset_options
@options.process_options
@click.pass_context
def command(context, presets, against, as_json, keep, seed, settings, fps, duration, plugins, threads, progress):
    """Check the `expect:` of each PRESET, or of all shipped ones.

    A copy with few particles runs in f64 at dt, dt/2 and dt/4, and then as a mutant: a version that is wrong on purpose. A
    claim is good if it holds in the three runs and fails in its mutant. The exit status is 3 unless all are good. Pictures
    of a preset carry its kept verdict in their recipe.
    """
    import json

    from gen_art.audit.expectations import check
    from gen_art.errors import OutputError
    from gen_art.output.recipe import version
    from gen_art.preset import verdicts
    from gen_art.preset.load import load_preset
    from gen_art.preset.shipped import course_names, preset_names

    model = load_preset(against).resolved().get("expect") if against is not None else None
    if against is not None and model is None:
        raise click.UsageError(f"{against} expects nothing: it has no `expect:`")
    changed = bool(settings or fps or duration or seed is not None or model)
    found = {}
    for name in presets or (*preset_names(), *course_names()):
        preset, _ = options.load(name, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
        result = check(load_preset(preset, overrides={"expect": model}) if model else preset, threads)
        found[name] = result.as_dict()
        if not as_json:
            echo(result.text())
        if keep and not changed and name != "-":
            try:
                verdicts.keep(preset, found[name], version())
            except OutputError as error:
                echo(f"gen-art: warning: the verdict is not kept: {error}", err=True)
    good = sum(one["verdict"] == "good" for one in found.values())
    if as_json:
        echo(json.dumps(found, indent=2))
    elif len(found) > 1:
        echo(f"{good} of {len(found)} presets are good")
    context.exit(0 if good == len(found) else 3)
