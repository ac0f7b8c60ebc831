"""`gen-art check`: whether what presets expect of their motion holds."""

from collections.abc import Iterator

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
@click.option(
    "--stale", is_flag=True, help="Only presets without a good kept verdict of their present state and version."
)
@click.option(
    "--workers",
    type=click.IntRange(1, 1024),
    default=1,
    show_default=True,
    help="Number of processes that share the presets.",
)
@options.preset_options
@options.process_options
@click.pass_context
def command(
    context, presets, against, as_json, keep, stale, workers, seed, settings, fps, duration, plugins, threads, progress
):
    """Check the `expect:` of each PRESET, or of all shipped ones.

    A copy with few particles runs in f64 at dt, dt/2 and dt/4, and then as a mutant: a version that is wrong on purpose. A
    claim is good if it holds in the three runs and fails in its mutant. The exit status is 3 unless all are good. Pictures
    of a preset carry its kept verdict in their recipe.
    """
    import json

    from gen_art.errors import OutputError
    from gen_art.output.recipe import version
    from gen_art.preset import verdicts
    from gen_art.preset.load import load_preset
    from gen_art.preset.shipped import course_names, preset_names

    model = load_preset(against).resolved().get("expect") if against is not None else None
    if against is not None and model is None:
        raise click.UsageError(f"{against} expects nothing: it has no `expect:`")
    changed = bool(settings or fps or duration or seed is not None or model)
    given = {"seed": seed, "settings": settings, "fps": fps, "duration": duration, "plugins": plugins}
    names = presets or (*preset_names(), *course_names())
    if stale and against is not None:
        raise click.UsageError(
            "--stale goes by the verdicts that are kept, and with --expect none is: leave one of them out"
        )
    if "-" in names and (stale or len(names) > 1):
        raise click.UsageError("standard input (-) can be read once only: give - alone, without --stale")
    if stale:
        names = [name for name in names if _kept_verdict(name, given) != "good"]
        if not names and not as_json:
            echo("every kept verdict is good, and of the present preset")
    found = {}
    for name, (text, result, key) in zip(names, _checks(names, min(workers, len(names)), given, model, threads)):
        found[name] = result
        if not as_json:
            echo(text)
        if keep and not changed and name != "-":
            try:
                preset, _ = options.load(name, **given)
                if verdicts.key(preset, version()) != key:
                    raise OutputError(f"{name} was changed while it was checked")
                verdicts.keep(preset, result, version())
            except OutputError as error:
                echo(f"gen-art: warning: the verdict is not kept: {error}", err=True)
    good = sum(one["verdict"] == "good" for one in found.values())
    if as_json:
        echo(json.dumps(found, indent=2))
    elif len(found) > 1:
        echo(f"{good} of {len(found)} presets are good")
    context.exit(0 if good == len(found) else 3)


def _checks(names, workers: int, given: dict, model, threads) -> Iterator[tuple[str, dict, str]]:
    """What `_check` finds of each preset, in their order."""
    if workers <= 1:
        yield from (_check(name, given, model, threads) for name in names)
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    from gen_art.backend.processor import cores

    each = threads or max(1, cores() // workers)
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        tasks = [pool.submit(_check, name, given, model, each) for name in names]
        try:
            yield from (task.result() for task in tasks)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _kept_verdict(name: str, given: dict) -> str:
    """The verdict that is kept of a preset as it is, or "not checked"."""
    from gen_art.output.recipe import version
    from gen_art.preset.verdicts import verdict_of

    return (verdict_of(options.load(name, **given)[0], version()) or {"verdict": "not checked"})["verdict"]


def _check(name: str, given: dict, model, threads) -> tuple[str, dict, str]:
    """What is found of a preset as text and as plain numbers, and the key of the preset that was checked."""
    from gen_art.audit.expectations import check
    from gen_art.output.recipe import version
    from gen_art.preset.load import load_preset
    from gen_art.preset.verdicts import key

    preset, _ = options.load(name, **given)
    result = check(load_preset(preset, overrides={"expect": model}) if model else preset, threads)
    return result.text(), result.as_dict(), key(preset, version())
