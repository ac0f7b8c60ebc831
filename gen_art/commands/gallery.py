"""`gen-art gallery`: makes a still and a short loop of each preset, a page that shows them, and a contact sheet."""

from pathlib import Path

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo
from gen_art.errors import UsageError

__all__ = ["command"]

# size of a loop in bytes, roughly: the encoder limits the rate within the buffer of each segment only
LARGE_LOOP, COURSE_LOOP = 640_000, 125_000
COURSE_FPS, COURSE_SECONDS = 15, 4.0  # of the course's loops, so that fifty pieces take one to two hours


@click.command("gallery")
@click.argument("names", nargs=-1)
@click.option("-o", "--output", "folder", default="gallery", show_default=True, help="The folder to write to.")
@click.option(
    "--page-only",
    is_flag=True,
    help="Write index.html and the contact sheet alone, from the stills and loops in the folder.",
)
@options.process_options
def command(names, folder, page_only, threads, progress):
    """Make a still and a loop of each preset, and a page that shows them.

    Stills are 1280x720, loops 640x360; of the presets NAMES, or of all.
    index.html shows those in the folder, with the YAML and the command of
    each; it opens from the file system. contact_sheet.webp has twelve stills.
    """
    from gen_art.commands.progress import reporter
    from gen_art.files import beside
    from gen_art.output import job
    from gen_art.output.gallery.contact_sheet import write_contact_sheet
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
        time, frames, fps = moments(preset, large)
        with reporter(progress) as report:
            paths = job.still(
                preset, out / f"{name}.webp", time, size=STILL, overwrite=True, threads=threads, progress=report
            )
            rate = int((LARGE_LOOP if large else COURSE_LOOP) * 8 / (len(frames) / fps))
            paths += job.render(
                preset, out / f"{name}.mp4", frames=frames, fps=fps, size=LOOP, overwrite=True, threads=threads,
                progress=report, max_rate=rate,
            )  # fmt: skip
        for path in paths:
            echo(f"{path} {path.stat().st_size / 1000:.0f} KB")
    with beside(out / "index.html") as temporary:
        temporary.write_text(page(out), encoding="utf-8")
    echo(out / "index.html")
    if sheet := write_contact_sheet(out):
        echo(sheet)


def moments(preset, large: bool) -> tuple[float, range, float]:
    """The still's film time, the loop's frames and its frames per second, from `gallery:` in the preset."""
    time, fps = preset.poster_time, preset.clock.fps if large else COURSE_FPS
    if preset.gallery.loop is not None:
        start, end = preset.gallery.loop.lo, preset.gallery.loop.hi
    else:
        length = min(5.0 if large else COURSE_SECONDS, preset.clock.duration)
        start = max(0.0, min(time - length / 2, preset.clock.duration - length))
        end = start + length
    return time, range(round(start * fps), round(end * fps)), fps
