"""`gen-art doctor`: says what this machine can do."""

from typing import Any

import click

from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("doctor")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.pass_context
def command(context, as_json):
    """Say what this machine can do, and what to do about what it cannot.

    It looks at versions, processor, memory, the cache of kernels, codecs and optional packages, and compiles and runs a small
    kernel. The exit status is 0 if films can be made; otherwise 2 if Taichi does not work, 4 for want of memory, 5 if no
    temporary folder can be written, 6 if no codec can be encoded.
    """
    from gen_art.output.machine import examine

    machine = examine()
    if as_json:
        import json

        echo(json.dumps(machine.as_dict(), indent=2))
    else:
        for title, words in _rows(machine.facts):
            echo(f"{title:<14}{words}".rstrip())
        echo("")
        for problem in machine.problems:
            echo(f"Problem: {problem.what}.\n    What to do: {problem.remedy}.")
        echo("Films can be made." if machine.status == 0 else "Films cannot be made until this is mended.")
    context.exit(machine.status)


def _rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """(title, words) of the report's lines."""
    chip, memory, taichi = facts["processor"], facts["memory"], facts["taichi"]
    rows = [
        ("gen-art", facts["gen_art"]),
        ("Python", facts["python"]),
        ("Taichi", _taichi(taichi)),
        ("system", facts["system"]),
        ("processor", chip["name"]),
        ("vectors", ", ".join(chip["vectors"]) or "neither AVX2, AVX-512 nor NEON is known: films may take longer"),
        ("cores", f"{chip['cores']} of {chip['all_cores']} for this process"),
        ("memory", f"{_gib(memory['bytes'])}, of which {_gib(memory['free'])} are free for this process"),
        ("kernel cache", _cache(facts["cache"])),
        ("kernel", _kernel(facts["kernel"])),
        ("encoders", facts["encoders"] or "none"),
    ]  # fmt: skip
    for codec in facts["codecs"]:
        state = f"{codec['missing']} is missing" if codec["missing"] else "yes"
        rows.append(("  " + codec["name"], f"{' '.join(codec['extensions'])}: {state}"))
    rows.append(("extras", ""))
    for extra in facts["extras"]:
        state = "installed" if extra["installed"] else f"pip install {' '.join(map(repr, extra['missing']))}"
        rows.append(("  " + extra["name"], f"{extra['purpose']}: {state}"))
    return rows


def _taichi(taichi: dict[str, Any]) -> str:
    if taichi["version"] is None:
        return "not installed"
    supported = "the supported version" if taichi["supported"] else "not the supported version"
    return f"{taichi['version']}, {supported}" + ("" if taichi["patched"] else ", without gen-art's patches")


def _kernel(kernel: dict[str, Any]) -> str:
    threads = kernel["threads"]
    if not kernel["runs"]:
        return "did not run"
    kept = (
        "machine code is kept" if kernel["kept"] else "each start compiles anew (llvmlite 0.44 on Linux would keep it)"
    )
    return f"compiled and ran on {threads} thread{'s' * (threads != 1)}; {kept}"


def _cache(cache: dict[str, Any] | None) -> str:
    if cache is None or cache["folder"] is None:
        return "not known"
    if cache["problem"]:
        return f"{cache['folder']}, cannot be written"
    return f"{cache['folder']}, {_gib(cache['bytes'])} of {_gib(cache['limit'])} in {cache['files']:,} files, can be written"


def _gib(size: float) -> str:
    """12345678 -> `0.01 GiB`."""
    return f"{size / 2**30:.{2 if size < 2**30 else 1}f} GiB"
