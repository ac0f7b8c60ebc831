"""`gen-art still`: renders one picture."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("still")
@click.argument("preset")
@options.one_picture_options
@options.picture_options
@options.preset_options
@options.run_options
def command(
    preset, out, time, bits, size, scale, quality, overwrite, transparent, dry_run,
    seed, settings, fps, duration, plugins, precision, threads, progress,
):  # fmt: skip
    """Render one picture of PRESET.

    Missing folders of OUT are created. An .exr contains the light before it is developed (linear, premultiplied RGBA) and the
    layers Z and velocity.
    """
    preset, loaded = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    time = preset.poster_time if time is None else time
    from gen_art.commands.progress import reporter
    from gen_art.output import job

    output = {
        "size": size, "scale": scale, "quality": quality, "overwrite": overwrite, "transparent": transparent,
        "bits": int(bits) if bits else None,
    }  # fmt: skip
    if dry_run:
        plan = job.plan_still(preset, out, time, precision=precision, **output)
        echo(f"{out}: {plan.size[0]}x{plan.size[1]} at {time:g} s, {plan.expected}")
        return
    with reporter(progress) as report:
        paths = job.still(
            preset, out, time, precision=precision, threads=threads, progress=report, plugins=loaded, **output
        )
    for path in paths:
        echo(path)
