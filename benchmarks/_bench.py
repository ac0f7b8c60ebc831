"""What every benchmark shares: options, the machine, alternating runs, the table and the JSON."""

import argparse
import importlib.metadata
import json
import platform
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))  # the checkout, whether or not it is installed

_PACKAGES = ("taichi", "numpy", "numba", "pytreegrav", "datashader")


class Bench:
    """One benchmark: `figures` and `requirements` are filled in, then `finish` writes and prints them."""

    def __init__(self, name: str, question: str):
        parser = argparse.ArgumentParser(description=question)
        parser.add_argument("--quick", action="store_true", help="few particles, few rounds: does it still run?")
        parser.add_argument("--results", type=Path, default=ROOT / "benchmarks" / "results", help="folder of the JSON")
        options = parser.parse_args()
        self.name, self.question, self.quick, self._folder = name, question, options.quick, options.results
        self.settings: dict = {}
        self.figures: dict = {}
        self.requirements: list[dict] = []
        print(f"{name}: {question}", flush=True)

    def require(self, what: str, measured: float, at_least: float | None = None, at_most: float | None = None) -> None:
        """State a bound and whether it was met."""
        met = (at_least is None or measured >= at_least) and (at_most is None or measured <= at_most)
        bound = {"at_least": at_least} if at_most is None else {"at_most": at_most}
        self.requirements.append({"what": what, "measured": round(measured, 4), **bound, "met": met})

    def table(self, rows: list[tuple]) -> None:
        """Print rows; the first one is the heading."""
        widths = [max(len(str(row[k])) for row in rows) for k in range(len(rows[0]))]
        for row in rows:
            print(
                "  " + "  ".join(f"{cell!s:{'<' if k == 0 else '>'}{widths[k]}}" for k, cell in enumerate(row)),
                flush=True,
            )

    def finish(self) -> None:
        """Print the requirements and write NAME.json."""
        for one in self.requirements:
            low = "at_least" in one
            bound = f"{'at least' if low else 'at most'} {one['at_least' if low else 'at_most']:g}"
            print(f"  {one['what']}: {one['measured']:g} ({bound}){'' if one['met'] else '  MISSED'}")
        self._folder.mkdir(parents=True, exist_ok=True)
        data = {
            "benchmark": self.name,
            "question": self.question,
            "quick": self.quick,
            "machine": machine(),
            "settings": self.settings,
            "figures": self.figures,
            "requirements": self.requirements,
        }
        path = self._folder / f"{self.name}.json"
        path.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")


def machine() -> dict:
    """Processor, cores and versions: what figures depend on."""
    versions = {}
    for package in _PACKAGES:
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    import gen_art
    from gen_art.backend import processor

    return {
        "cpu": processor.name(), "cores": processor.cores(), "system": platform.system(), "python": platform.python_version(),
        "gen_art": gen_art.__version__, **versions,
    }  # fmt: skip


def alternate(rounds: int, again: bool = False, **things) -> dict[str, float]:
    """Median seconds of each function, taken in turns after one warm-up each, so that a slow spell touches all alike.

    again : in each turn a function runs twice, and the second time counts: a core that was idle while another function ran on
    one thread takes some time to be as fast as before
    """
    for function in things.values():
        function()
    taken: dict[str, list[float]] = {name: [] for name in things}
    for _ in range(rounds):
        for name, function in things.items():
            if again:
                function()
            start = time.perf_counter()
            function()
            taken[name].append(time.perf_counter() - start)
    return {name: float(np.median(seconds)) for name, seconds in taken.items()}
