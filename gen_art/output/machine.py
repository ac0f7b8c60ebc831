"""What this machine can do: facts and problems, each problem with what to do about it.

Nothing here imports Taichi: its part is found by a process of its own (gen_art/backend/trial.py).
"""

import json
import os
import platform
import signal
import subprocess
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from gen_art.backend import processor
from gen_art.backend.memory import available_memory, installed_memory
from gen_art.backend.trial import REINSTALL
from gen_art.errors import EncoderError, InstallationError, MemoryRefused
from gen_art.output.extras import extras

__all__ = ["Machine", "Problem", "examine"]

LEAST_MEMORY = 512 * 2**20  # bytes; the process of a film of 64 x 36 pixels takes 0.28 GB
_TRIAL_SECONDS = 300  # after which the trial kernel counts as hanging


@dataclass(frozen=True)
class Problem:
    """What is wrong, and a sentence that says what to do.

    status : the exit status if no film can be made because of it; 0 if films can be made all the same
    """

    what: str
    remedy: str
    status: int = 0


@dataclass
class Machine:
    """The facts by name, in the order in which they are shown, and the problems."""

    facts: dict[str, Any] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    @property
    def status(self) -> int:
        """0 if films can be made, otherwise the exit status of the first problem that prevents them."""
        return next((problem.status for problem in self.problems if problem.status), 0)

    def as_dict(self) -> dict[str, Any]:
        return {"films": self.status == 0, **self.facts, "problems": [asdict(problem) for problem in self.problems]}


def examine() -> Machine:
    """Look at everything that a film needs."""
    from gen_art import __version__

    machine = Machine({"gen_art": __version__, "python": platform.python_version()})
    found = _trial()
    machine.facts["taichi"] = {
        "version": found.get("taichi"), "supported": found.get("supported", False), "patched": found.get("patched", True),
    }  # fmt: skip
    machine.facts["system"] = f"{platform.system()} {platform.release()} {platform.machine()}"
    machine.facts["processor"] = {
        "name": processor.name(), "vectors": processor.vectors(), "cores": processor.cores(), "all_cores": os.cpu_count(),
    }  # fmt: skip
    _memory(machine)
    _cache(machine, found.get("cache"))
    _kernel(machine, found)
    _codecs(machine)
    machine.facts["extras"] = [{**asdict(extra), "installed": extra.installed} for extra in extras()]
    return machine


def _trial() -> dict[str, Any]:
    """The findings of gen_art/backend/trial.py."""
    root = str(Path(__file__).resolve().parents[2])
    paths = os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH"))))
    command = [sys.executable, "-P", "-m", "gen_art.backend.trial"]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": paths}, timeout=_TRIAL_SECONDS
        )
    except subprocess.TimeoutExpired:
        return {"error": f"a kernel did not end within {_TRIAL_SECONDS} s", "status": InstallationError.exit_code}
    found: dict[str, Any] = {}
    for line in done.stdout.splitlines():
        if line.startswith("{"):
            found |= json.loads(line)
    if "threads" not in found and "error" not in found:
        found |= {"error": _ended(done.returncode, done.stderr), "status": InstallationError.exit_code}
    return found


def _ended(status: int, words: str) -> str:
    if status < 0:
        return f"Taichi ended the process by the signal {signal.Signals(-status).name}"
    last = words.strip().splitlines()[-1] if words.strip() else f"exit status {status}"
    return f"Taichi ended the process: {last[:300]}"


def _memory(machine: Machine) -> None:
    free = available_memory()
    machine.facts["memory"] = {"bytes": installed_memory(), "free": free}
    if free < LEAST_MEMORY:
        machine.problems.append(
            Problem(
                f"only {free / 2**20:.0f} MiB of memory are free for this process",
                f"close other programs, or raise the limit of the container or of ulimit to {LEAST_MEMORY / 2**20:.0f} MiB",
                MemoryRefused.exit_code,
            )
        )


def _cache(machine: Machine, cache: dict[str, Any] | None) -> None:
    machine.facts["cache"] = cache
    if cache is not None and cache["problem"]:
        remedy = "set GEN_ART_CACHE to a folder that can be written; until then every start compiles its kernels anew"
        machine.problems.append(Problem(cache["problem"], remedy))


def _kernel(machine: Machine, found: dict[str, Any]) -> None:
    machine.facts["kernel"] = {
        "runs": "threads" in found, "threads": found.get("threads", 0), "kept": found.get("kept", False),
    }  # fmt: skip
    if "error" not in found:
        return
    machine.problems.append(Problem(found["error"], found.get("remedy", REINSTALL), found["status"]))


def _codecs(machine: Machine) -> None:
    from gen_art.output.encoders import encodable, library_version

    again = "install PyAV anew, with the libraries inside it: pip install --force-reinstall --only-binary av av"
    try:
        codecs, machine.facts["encoders"] = encodable(), library_version()
    except (ImportError, OSError) as error:
        machine.facts["encoders"], machine.facts["codecs"] = None, []
        machine.problems.append(Problem(f"PyAV cannot be loaded ({error})", again, EncoderError.exit_code))
        return
    machine.facts["codecs"] = [
        {"name": one.codec.name, "extensions": list(one.codec.extensions), "missing": one.missing} for one in codecs
    ]
    some = any(not one.missing for one in codecs)
    for one in codecs:
        if one.missing:
            status = 0 if some else EncoderError.exit_code
            machine.problems.append(
                Problem(f"{one.codec.title} cannot be made: {one.missing} is missing", again, status)
            )
