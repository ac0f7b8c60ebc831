"""Plots of an audit: energy, the ledger's residual, momentum, paths, and the errors against the step.

Needs the extra `plots` (matplotlib), which is imported only here.
"""

import base64
import html
import io
import math
from pathlib import Path

import numpy as np

from gen_art.errors import UsageError

__all__ = ["EXTENSIONS", "MOMENTS", "check_plots", "draw"]

EXTENSIONS = (".png", ".svg", ".html")
MOMENTS = 96  # moments of a run that is drawn
_COLOURS = ("#1f5fa8", "#d1662f", "#3f8f4f", "#8a4fa3", "#a8862a", "#5b6670")
_STYLES = {1: "-", 2: "--", 4: ":"}


def check_plots(path: Path) -> None:
    """Raise UsageError for an extension that is not in EXTENSIONS, or if matplotlib is not installed."""
    if path.suffix.lower() not in EXTENSIONS:
        raise UsageError(f"{path}: an audit is drawn as {', '.join(EXTENSIONS)}")
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise UsageError("plots need matplotlib, which is not installed: pip install matplotlib") from None


def draw(report, path: Path) -> None:
    """Write an Audit's plots to .png or .svg, or with its text to one page of .html."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 11), layout="constrained")
    axes = figure.subplots(3, 2)
    figure.suptitle(f"{report.name}: {report.simulated:.4g} s simulated, float64, dt = {report.dt:.4g} s")
    _energy(axes[0, 0], report)
    _residuals(axes[0, 1], report)
    _momentum(axes[1, 0], report)
    _convergence(axes[1, 1], report)
    _paths(axes[2, 0], report, 0, 1)
    _paths(axes[2, 1], report, 0, 2)
    extension = path.suffix.lower().lstrip(".")
    if extension != "html":
        figure.savefig(
            path, format=extension, dpi=110, metadata={"Date": None} if extension == "svg" else {"Software": None}
        )
        return
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    picture = base64.b64encode(buffer.getvalue()).decode("ascii")
    path.write_text(
        f'<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>{html.escape(report.name)}: audit</title>\n'
        f'<img src="data:image/png;base64,{picture}" alt="plots of the audit" style="max-width: 100%">\n'
        f"<pre>{html.escape(report.text())}</pre>\n</html>\n",
        encoding="utf-8",
    )


def _energy(axes, report) -> None:
    history = report.runs[0].history
    total, dotted = history.kinetic + history.potential, (0, (2, 3))
    axes.plot(history.times, history.kinetic, color=_COLOURS[0], label="kinetic")
    axes.plot(history.times, history.potential, color=_COLOURS[1], label="potential")
    axes.plot(history.times, total, color="black", label="total")
    axes.plot(history.times, history.accounted, color=_COLOURS[2], linestyle=dotted, linewidth=3, label="by the ledger")
    _label(axes, "energy", "time, s", "J")


def _residuals(axes, report) -> None:
    scale = max(report.ledger.scale, 1e-300)
    for division, audit_run in zip(_STYLES, report.runs):
        history = audit_run.history
        residual = np.abs(history.kinetic + history.potential - history.accounted) / scale
        label = "dt" if division == 1 else f"dt/{division}"
        axes.plot(history.times, np.maximum(residual, 1e-17), _STYLES[division], color=_COLOURS[0], label=label)
    axes.set_yscale("log")
    _label(axes, "residual of the ledger, relative to the energy that moved", "time, s", "")


def _momentum(axes, report) -> None:
    history = report.runs[0].history
    for axis, name in enumerate("xyz"):
        axes.plot(history.times, history.momentum[:, axis], color=_COLOURS[axis], label=name)
    _label(axes, "momentum", "time, s", "N s")


def _convergence(axes, report) -> None:
    steps = report.dt / np.array([1.0, 2.0, 4.0])
    lines = [(f"energy of {name}", trend) for name, trend in report.energy.items()]
    lines += [(f"positions of {name}", trend) for name, (trend, _) in report.positions.items()]
    for k, (name, trend) in enumerate(line for line in lines if line[1] is not None):
        values = np.maximum(np.array(trend.values), 1e-17)
        colour, order = _COLOURS[k % len(_COLOURS)], trend.order
        slope = "round-off" if order is None or not math.isfinite(order) else f"order {order:.2f}"
        axes.plot(steps[: len(values)], values, "o-", color=colour, label=f"{name}, {slope}")
        if not trend.at_round_off and np.isfinite(values[0]):
            axes.plot(steps, values[0] * (steps / steps[0]) ** trend.expected, ":", color=colour, linewidth=1)
    axes.set_xscale("log")
    axes.set_yscale("log")
    _label(axes, "errors against the step; dotted: the expected order", "step, s", "")


def _paths(axes, report, across: int, up: int) -> None:
    for k, (name, paths) in enumerate(report.runs[0].history.paths.items()):
        for j, path in enumerate(paths):
            label = name if j == 0 else None
            axes.plot(path[:, across], path[:, up], color=_COLOURS[k % len(_COLOURS)], linewidth=0.8, label=label)
    axes.set_aspect("equal", adjustable="datalim")
    _label(axes, "paths of some particles", f"{'xyz'[across]}, m", f"{'xyz'[up]}, m")


def _label(axes, title: str, x: str, y: str) -> None:
    axes.set_title(title, fontsize=10)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color="#dddddd", linewidth=0.5)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8, frameon=False)
