"""A sweep on several processes, of this machine or of a cluster, by Dask distributed: one task for each film or picture.

A task is plain data, from which the worker loads the preset again; the files that the preset names, the plugins and the file
that is made are at the same paths for all. A worker process makes one unit at a time. When it dies, its unit is made again by
another one.
"""

import importlib.util
import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings, simplefilter, warn

from gen_art import arguments
from gen_art.backend import processor
from gen_art.errors import GenArtError, OutputError, UsageError
from gen_art.output import job
from gen_art.output.partial_film import PartialFilm, partial_path
from gen_art.output.recipe import version
from gen_art.output.sweep import Unit, is_of
from gen_art.plugins import Plugin, load_plugins
from gen_art.preset.load import PresetSource

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["sweep_on_farm"]

_ALLOWED_DEATHS = 10  # of worker processes on one unit, until it counts as the unit's fault
_ANSWER = 10.0  # seconds in which a scheduler must answer


def sweep_on_farm(
    units: Sequence[Unit], *, workers: int | None = None, scheduler: str | None = None, threads: int | None = None,
    overwrite: bool = False, plugins: Sequence[Plugin | str | Path] = (),
    tell: Callable[[str], None] | None = None, done: Callable[[int, Unit], None] | None = None,
) -> list[Path]:  # fmt: skip
    """Make the units that are not made yet, in any order; returns the paths of all. The files are those that `sweep` makes.

    workers : number of processes to start on this machine, 1 to 1024; or
    scheduler : address of a Dask scheduler that runs already, "tcp://10.0.0.5:8786"
    threads : of each process; when None, an equal share of this machine's cores, or all cores of the worker's machine
    tell : called with sentences on the scheduler: its address, or that it has no workers yet
    done : called when a unit is made, with the number of those that are made by then and the unit
    A unit that fails stops no other: its error is raised at the end, with a note that names the unit.
    Raises UsageError without the package `distributed`, OutputError when no scheduler answers.
    """
    if (workers is None) == (scheduler is None):
        raise UsageError("--workers starts processes here, and --scheduler uses those of a cluster: give one of them")
    if importlib.util.find_spec("distributed") is None:
        raise UsageError(
            "a sweep on several processes needs the package distributed, which is not installed: "
            "pip install 'gen-art[farm]'"
        )
    from gen_art.output.farm_logs import quiet

    tell = tell or (lambda sentence: None)
    if all(unit.is_made for unit in units):
        return [unit.path for unit in units]
    with quiet():
        if scheduler is not None:
            connected = _connected(arguments.text("scheduler", scheduler), tell)
        else:
            workers = arguments.whole("workers", workers, 1, 1024)
            threads = threads or max(1, processor.cores() // workers)
            connected = _started(workers, tell)
        try:
            with connected as client:
                _make(client, units, threads, overwrite, load_plugins(plugins), done)
        except Exception:
            raise
        except BaseException as stop:  # Ctrl+C, or the signal that ends the process
            if workers is not None:
                _note_kept(stop, units)
            raise
    return [unit.path for unit in units]


@dataclass(frozen=True)
class _Task:
    """What a worker needs to make a unit.

    preset : as plain data
    version : of gen-art, which the worker must have too
    """

    preset: PresetSource
    path: Path
    is_film: bool
    options: dict[str, Any]
    threads: int | None
    overwrite: bool
    plugins: tuple[Path, ...]
    version: str


def _task(unit: Unit, threads: int | None, overwrite: bool, plugins: Sequence[Plugin]) -> _Task:
    found = PresetSource.of(unit.preset)
    source = PresetSource(found.name, found.text, found.folder.resolve(), found.written)
    paths = tuple(plugin.path.resolve() for plugin in plugins)
    return _Task(source, unit.path.absolute(), unit.is_film, unit.options, threads, overwrite, paths, version())


_one_at_a_time = threading.Lock()


def _run(task: _Task) -> list[str]:
    """Make the file of a task in this process; returns the warnings."""
    if task.version != version():
        raise UsageError(f"a worker has gen-art {version()}, and this is {task.version}: install the same on both")
    with _one_at_a_time, catch_warnings(record=True) as caught:
        simplefilter("always", UserWarning)
        plugins = load_plugins(task.plugins)
        preset = task.preset.load()
        if not _made_before(task, preset, plugins):
            make = job.render if task.is_film else job.still
            make(preset, task.path, threads=task.threads, overwrite=task.overwrite, plugins=plugins, **task.options)
    return [str(warning.message) for warning in caught if issubclass(warning.category, UserWarning)]


def _made_before(task: _Task, preset: Any, plugins: Sequence[Plugin]) -> bool:
    """Whether a worker that died later has made the file; the partial film of one that died earlier is removed.

    There was none of them when the sweep began, or both were to be replaced.
    """
    if task.path.is_file() and is_of(task.path, preset, task.is_film, task.options, plugins) and not task.overwrite:
        return True
    partial = partial_path(task.path)
    if task.is_film and partial.exists():
        old = PartialFilm(partial, overwrite=True)
        old.remove()
        old.close()
    return False


def _make(
    client: "Client", units: Sequence[Unit], threads: int | None, overwrite: bool, plugins: Sequence[Plugin],
    done: Callable[[int, Unit], None] | None,
) -> None:  # fmt: skip
    from distributed import as_completed

    futures = {
        client.submit(_run, _task(unit, threads, overwrite, plugins), pure=False): unit
        for unit in units
        if not unit.is_made
    }
    made = len(units) - len(futures)
    told: set[str] = set()
    failed: list[tuple[Unit, BaseException]] = []
    try:
        for future in as_completed(futures, loop=client.loop):
            unit = futures[future]
            error = future.exception()
            if error is not None:
                failed.append((unit, error))
                continue
            for sentence in future.result():
                if sentence not in told:
                    told.add(sentence)
                    warn(sentence, stacklevel=2)
            made += 1
            if done is not None:
                done(made, unit)
    finally:
        with suppress(Exception):  # of a scheduler that is gone
            client.cancel(list(futures))
    if failed:
        raise _error_of(sorted(failed, key=lambda pair: units.index(pair[0])))


def _note_kept(stop: BaseException, units: Sequence[Unit]) -> None:
    """Name the partial films that the workers have left."""
    for unit in units:
        partial = partial_path(unit.path)
        with suppress(OSError):
            if unit.is_film and not unit.is_made and partial.stat().st_size:
                stop.add_note(f"the finished part of a film is kept in {partial}")


def _error_of(failed: Sequence[tuple[Unit, BaseException]]) -> BaseException:
    """The error of the first unit that failed, with a note that names each of them."""
    errors = [_as_sentence(error) for _, error in failed]
    first = errors[0]
    first.add_note(f"this is of {failed[0][0].path} ({failed[0][0].label})")
    for (unit, _), error in zip(failed[1:], errors[1:]):
        first.add_note(f"{unit.path} ({unit.label}) failed too: {error}")
    return first


def _as_sentence(error: BaseException) -> BaseException:
    from concurrent.futures import CancelledError

    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        return GenArtError(
            "every worker process that began it died, most likely for want of memory: take fewer workers, or a smaller "
            "--size"
        )
    if isinstance(error, CancelledError):
        return OutputError("the scheduler was lost before it was made")
    if isinstance(error, ModuleNotFoundError) or "deserializ" in str(error):
        return UsageError(
            f"the scheduler or a worker cannot read the task ({error}): install the same gen-art and Dask on all"
        )
    return error


@contextmanager
def _started(workers: int, tell: Callable[[str], None]) -> Iterator["Client"]:
    """A client of so many worker processes on this machine, which end with it."""
    import dask
    from distributed import Client, LocalCluster

    settings = {"distributed.scheduler.allowed-failures": _ALLOWED_DEATHS, "distributed.scheduler.worker-ttl": None}
    with (
        dask.config.set(settings),
        LocalCluster(
            n_workers=workers, threads_per_worker=1, host="127.0.0.1", memory_limit=0, silence_logs=logging.CRITICAL,
            dashboard_address="127.0.0.1:0" if _has_pages() else None,
        ) as cluster,
        Client(cluster) as client,
    ):  # fmt: skip
        _tell_address(client, cluster.scheduler_address, tell)
        client.register_plugin(_worker_plugin(own=True))
        yield client


@contextmanager
def _connected(address: str, tell: Callable[[str], None]) -> Iterator["Client"]:
    """A client of a scheduler that runs already. Raises UsageError for what is no address, OutputError if none answers."""
    from distributed import Client

    try:
        client = Client(address, timeout=_ANSWER, set_as_default=False)
    except ValueError as error:
        raise UsageError(f"--scheduler {address}: is no address such as tcp://10.0.0.5:8786 ({error})") from None
    except OSError:
        raise OutputError(f"--scheduler {address}: no Dask scheduler answers there") from None
    with client:
        _tell_address(client, address, tell)
        if not client.nthreads():
            tell("it has no workers yet: the sweep begins when the first one comes")
        client.register_plugin(_worker_plugin(own=False))
        yield client


def _has_pages() -> bool:
    """Whether the dashboard has pages, which are made by bokeh."""
    return importlib.util.find_spec("bokeh") is not None


def _tell_address(client: "Client", address: str, tell: Callable[[str], None]) -> None:
    if _has_pages() and client.dashboard_link:
        tell(f"Dask's dashboard is at {client.dashboard_link}")
    else:
        tell(f"Dask's scheduler is at {address}")


def _worker_plugin(own: bool) -> Any:
    from gen_art.output.farm_worker import FarmWorker

    return FarmWorker(own)
