"""`gen-art gallery`: makes a still and a short loop of each preset, and a page that shows them."""

from pathlib import Path

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo
from gen_art.errors import UsageError

__all__ = ["command"]

# size of a loop in bytes, roughly: the encoder limits the rate within the buffer of each segment only
LARGE_LOOP, COURSE_LOOP = 750_000, 280_000


@click.command("gallery")
@click.argument("names", nargs=-1)
@click.option("-o", "--output", "folder", default="gallery", show_default=True, help="The folder to write to.")
@click.option("--page-only", is_flag=True, help="Write index.html alone, from the stills and loops in the folder.")
@options.process_options
def command(names, folder, page_only, threads, progress):
    """Make a still and a loop of each preset, and a page that shows them.

    Stills are 1280x720, loops 640x360; of the presets NAMES, or of all.
    index.html shows those in the folder, with the YAML and the command of
    each; it opens from the file system.
    """
    from gen_art.commands.progress import reporter
    from gen_art.files import beside
    from gen_art.output import job
    from gen_art.output.gallery.page import LOOP, STILL, page
    from gen_art.preset.load import load_preset
    from gen_art.preset.shipped import course_names, preset_names

    out, shipped = Path(folder), [*preset_names(), *course_names()]
    for name in names:
        if name not in shipped:
            raise UsageError(f"the gallery shows the shipped presets, and {name!r} is none (`gen-art list` names them)")
    for name in () if page_only else names or shipped:
        preset = load_preset(name)
        large = name in preset_names()
        time, frames = moments(preset)
        with reporter(progress) as report:
            paths = job.still(
                preset, out / f"{name}.webp", time, size=STILL, overwrite=True, threads=threads, progress=report
            )
            rate = int((LARGE_LOOP if large else COURSE_LOOP) * 8 / (len(frames) / preset.clock.fps))
            paths += job.render(
                preset, out / f"{name}.mp4", frames=frames, size=LOOP, overwrite=True, threads=threads, progress=report,
                max_rate=rate,
            )  # fmt: skip
        for path in paths:
            echo(f"{path} {path.stat().st_size / 1000:.0f} KB")
    with beside(out / "index.html") as temporary:
        temporary.write_text(page(out), encoding="utf-8")
    echo(out / "index.html")


def moments(preset) -> tuple[float, range]:
    """The still's film time and the loop's frames, from `gallery:` in the preset."""
    time = preset.poster_time
    loop, fps = preset.gallery.loop, preset.clock.fps
    if loop is None:
        length = min(5.0, preset.clock.duration)
        start = max(0.0, min(time - length / 2, preset.clock.duration - length))
        return time, range(round(start * fps), round((start + length) * fps))
    return time, range(round(loop.lo * fps), round(loop.hi * fps))
