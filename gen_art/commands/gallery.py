"""`gen-art gallery`: makes a still and a short loop of each preset, and a page that shows them."""

from html import escape
from pathlib import Path

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]

STILL, LOOP = (1280, 720), (640, 360)
LOOP_BYTES = 750_000  # size of a loop, roughly: the encoder limits the rate within the buffer of each segment only


@click.command("gallery")
@click.argument("names", nargs=-1)
@click.option("-o", "--output", "folder", default="gallery", show_default=True, help="The folder to write to.")
@options.process_options
def command(names, folder, threads, progress):
    """Make a still and a loop of each preset.

    Stills are 1280x720, loops 640x360; of the presets NAMES, or of all. index.html shows them.
    """
    from gen_art.commands.progress import reporter
    from gen_art.files import beside
    from gen_art.output import job
    from gen_art.preset.load import load_preset
    from gen_art.preset.shipped import course_names, preset_names

    out, shipped = Path(folder), {*preset_names(), *course_names()}
    for name in names or preset_names():
        preset = load_preset(name)
        name = name if name in shipped else preset.name  # of a path, the files would lie beside the preset
        time, frames = moments(preset)
        with reporter(progress) as report:
            paths = job.still(
                preset, out / f"{name}.webp", time, size=STILL, overwrite=True, threads=threads, progress=report
            )
            rate = int(LOOP_BYTES * 8 / (len(frames) / preset.clock.fps))
            paths += job.render(
                preset, out / f"{name}.mp4", frames=frames, size=LOOP, overwrite=True, threads=threads, progress=report,
                max_rate=rate,
            )  # fmt: skip
        for path in paths:
            echo(f"{path} {path.stat().st_size / 1000:.0f} KB")
    with beside(out / "index.html") as temporary:
        temporary.write_text(page(preset_names()), encoding="utf-8")
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


def page(names) -> str:
    """index.html: every preset's loop over its still, with the first lines of its file."""
    from gen_art.preset.shipped import presets_folder

    figures = []
    for name in names:
        lines = (presets_folder() / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
        description = " ".join(line.lstrip("# ") for line in lines[:2] if line.startswith("#"))
        figures.append(
            f'<figure><video src="{name}.mp4" poster="{name}.webp" autoplay loop muted playsinline></video>'
            f'<figcaption><a href="{name}.webp">{name}</a> {escape(description)}</figcaption></figure>'
        )
    return _PAGE.format(figures="\n".join(figures))


_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Gen Art: gallery</title>
<style>
body {{ margin: 0; padding: 4vw; background: #0b0b0d; color: #bbb; font: 16px/1.5 system-ui, sans-serif }}
main {{ display: grid; gap: 3vw; grid-template-columns: repeat(auto-fit, minmax(min(30em, 100%), 1fr)) }}
figure {{ margin: 0 }} video {{ width: 100%; display: block; background: #000 }} a {{ color: #fff }}
figcaption {{ padding-top: .5em }}
</style>
<main>
{figures}
</main>
</html>
"""
