"""`gen-art watch`: makes a picture again whenever its preset is saved."""

import gc
import secrets
import time
from pathlib import Path

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("watch")
@click.argument("preset")
@options.one_picture_options
@options.size_options
@click.option(
    "--overwrite", is_flag=True, help="Replace OUT even if it exists and is no picture that gen-art has made."
)
@options.TRANSPARENT
@options.preset_options
@options.run_options
def command(
    preset, out, time, bits, size, scale, quality, overwrite, transparent,
    seed, settings, fps, duration, plugins, precision, threads, progress,
):  # fmt: skip
    """Make one picture of PRESET, and again whenever PRESET is saved, or a file that it names, or a plugin.

    OUT is replaced each time. Kernels stay compiled, so a changed number compiles nothing. What is wrong with a preset is
    printed, and the last good picture stays. Ctrl+C ends it. It needs the package watchfiles.
    """
    from gen_art.output.file_watch import FileWatch

    if seed == "random":
        seed = secrets.randbelow(2**31)  # one seed for all pictures, so that they differ by what was changed
    picture = _Picture(
        preset, out, time, plugins=plugins, seed=seed, overrides=options.overrides(settings, fps, duration), overwrite=overwrite,
        progress=progress, precision=precision, threads=threads, size=size, scale=scale, quality=quality,
        transparent=transparent, bits=int(bits) if bits else None,
    )  # fmt: skip
    with FileWatch() as watch:
        why = "first picture"
        while True:
            watch.follow(picture.dependencies())
            picture.make(why)
            gc.collect()  # while nobody waits for it
            why = " and ".join(path.name for path in watch.wait()) + " changed"


class _Picture:
    """The picture that is made again and again; the options are those of `gen_art.output.job.still`.

    Raises UsageError and OutputError for what no change of the preset mends.
    """

    def __init__(self, preset, out, time, *, plugins, seed, overrides, overwrite, progress, **job):
        from gen_art.errors import UsageError
        from gen_art.files import check_input
        from gen_art.output.exr import check_exr
        from gen_art.output.live_plugins import LivePlugins
        from gen_art.preset.shipped import find

        if preset == "-":
            raise UsageError("watch a preset by its name or path: standard input is no file that can be saved again")
        self._preset, self._out, self._time = preset, out, time
        self._seed, self._overrides, self._progress, self._job = seed, overrides, progress, job
        self._overwrite, self._own = overwrite, set()
        self._file = find(preset)
        for path in (self._file, *map(Path, plugins)):
            check_input(path)
        self._plugins = LivePlugins(plugins)
        path = self._path(self._file.stem, 0)
        if path.suffix.lower() == ".exr":
            check_exr()
        if "{seed}" not in out:
            self._check_ours(path)

    def dependencies(self):
        """The files that the picture depends on, with their stamps."""
        from gen_art.output.dependencies import dependencies

        return dependencies(self._file, self._overrides, self._plugins.paths)

    def make(self, why: str) -> None:
        """Make the picture and print a line about it, or print what is wrong."""
        from gen_art.commands.main import print_error

        if not self._file.exists():
            echo(f"{self._file} is gone; watching goes on when it is back", err=True)
            return
        began = time.perf_counter()
        try:
            path = self._make()
        except Exception as error:  # also those of a plugin, which may raise anything
            print_error(error)
            return
        echo(f"{time.strftime('%H:%M:%S')} {path}: {why}, {time.perf_counter() - began:.1f} s")

    def _make(self) -> Path:
        from gen_art.commands.progress import reporter
        from gen_art.errors import UsageError
        from gen_art.output import job
        from gen_art.preset.load import load_preset

        loaded = self._plugins.load()
        preset = load_preset(self._preset, overrides=self._overrides, seed=self._seed)
        path = self._path(preset.name, preset.seed)
        self._check_ours(path)
        if path.resolve() in {file.place.resolve() for file in preset.files}:
            raise UsageError(f"{path} is a file that the preset reads; give the picture another name")
        with reporter(self._progress) as report:
            job.still(preset, self._out, self._time, overwrite=True, progress=report, plugins=loaded, **self._job)
        self._own.add(path)
        return path

    def _path(self, name: str, seed: int) -> Path:
        from gen_art.output.target import find_target

        job = self._job
        return find_target(
            self._out, moving=False, name=name, seed=seed, transparent=job["transparent"], bits=job["bits"]
        ).path

    def _check_ours(self, path: Path) -> None:
        """Raise OutputError if there is something at `path` that gen-art has not made, unless --overwrite is given."""
        from gen_art.errors import OutputError, UsageError
        from gen_art.output.read_recipe import read_recipe

        if path in self._own or self._overwrite or not path.exists():
            return
        try:
            read_recipe(path)
        except UsageError:
            raise OutputError(f"{path} exists, and gen-art has not made it; --overwrite replaces it") from None
