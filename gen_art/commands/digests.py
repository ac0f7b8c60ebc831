"""`gen-art digests`: digests of presets' states, to compare processors."""

from pathlib import Path

import click

from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("digests")
@click.argument("presets", nargs=-1, metavar="[PRESET]...")
@click.option("-o", "--output", help="Write the digests to this .json file.")
@click.option("--overwrite", is_flag=True, help="Replace OUTPUT if it exists.")
@click.option("--compare", metavar="FILE", help="Compare with the digests in FILE, and list the systems that differ.")
@click.option("--threads", type=click.IntRange(1, 1024), help="Number of threads; the digests do not depend on it.")
def command(presets, output, overwrite, compare, threads):
    """Digest the states of each PRESET, or of all shipped ones, after 0, 1 and 16 steps in f32 and f64.

    The result names the processor. Files from two processors show which systems get the same bits on both; the exit status
    is 1 if --compare finds any that differ.
    """
    import json

    from gen_art import __version__
    from gen_art.audit.digests import differences, state_digests
    from gen_art.errors import OutputError, UsageError
    from gen_art.files import beside, check_input
    from gen_art.output.target import check_writable
    from gen_art.preset.load import load_preset
    from gen_art.preset.shipped import course_names, preset_names

    if output is None and compare is None:
        raise UsageError("digests are written to a file, or compared with one: give -o FILE, --compare FILE or both")
    if output is not None:
        check_writable([Path(output)], overwrite)
    theirs = None
    if compare is not None:
        check_input(Path(compare))
        try:
            theirs = json.loads(Path(compare).read_text(encoding="utf-8"))
        except (ValueError, RecursionError):
            raise UsageError(f"{compare}: is no JSON; gen-art digests writes it") from None
        except OSError as error:
            raise OutputError(f"cannot read {compare}: {error.strerror or error}") from None
        differences({"digests": {}}, theirs)  # refuses a wrong file before anything runs
    loaded = [load_preset(name) for name in presets or (*preset_names(), *course_names())]
    ours = {"gen_art": __version__} | state_digests(loaded, threads=threads, progress=lambda name: echo(name, err=True))
    if output is not None:
        with beside(Path(output)) as temporary:
            temporary.write_text(json.dumps(ours, indent=1) + "\n", encoding="utf-8")
        echo(output)
    if theirs is not None:
        lines = differences(ours, theirs)
        for line in lines:
            echo(line)
        same = sum(len(moments) for one in ours["digests"].values() for moments in one.values())
        echo(
            f"{ours['processor']} and {theirs.get('processor')}: {len(lines)} systems differ ({same} digests of presets)"
        )
        return 1 if lines else 0
    return 0
