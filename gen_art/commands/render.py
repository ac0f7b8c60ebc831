"""`gen-art render`: renders a film or an image sequence, as the file extension of OUT says."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("render")
@click.argument("preset")
@click.option(
    "-o", "--output", "out", required=True, metavar="OUT", help="a.mp4 .mov .webm .mkv .gif .webp, or frame_####.png."
)
@click.option("--frames", type=options.FRAMES, help="12, 0..89 or 0..99..10 (first..last..step).")
@options.film_options
@options.picture_options
@options.preset_options
@options.run_options
def command(
    preset, out, frames, codec, profile, bits, size, scale, quality, overwrite, transparent, dry_run,
    seed, settings, fps, duration, plugins, precision, threads, progress,
):  # fmt: skip
    """Render PRESET to a film or to frames.

    The file extension of OUT sets the format: .mp4 (H.264), .mov (ProRes), .webm (VP9), .mkv (FFV1, lossless), .gif and
    .webp are films; a pattern such as out/frame_####.png (also .jpg .webp .exr) is an image sequence. {preset} and {seed} in
    OUT are replaced, and missing folders are created. A film is written to NAME.partial.EXT first; if the render is stopped,
    that file stays and can be played.
    """
    preset, loaded = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    from gen_art.commands.progress import reporter
    from gen_art.output import job

    frames = range(preset.clock.frames) if frames is None else frames
    output = {
        "size": size, "scale": scale, "quality": quality, "overwrite": overwrite, "transparent": transparent,
        "frames": frames, "codec": codec, "profile": profile, "bits": int(bits) if bits else None,
    }  # fmt: skip
    if dry_run:
        plan = job.plan_film(preset, out, precision=precision, **output)
        echo(f"{out}: {len(frames)} frames of {plan.size[0]}x{plan.size[1]}, {plan.expected}")
        return
    with reporter(progress) as report:
        paths = job.render(
            preset, out, precision=precision, threads=threads, progress=report, times=report, plugins=loaded, **output
        )
    for path in paths:
        echo(path)
