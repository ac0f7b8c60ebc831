"""Draws the errors of the tree against their cost, and fills in the table of docs/performance.md, from the results of `pairs`.

python docs/make_tree_plot.py       writes docs/images/tree.png and the table; needs matplotlib
"""

import json
from pathlib import Path

from matplotlib.figure import Figure

FOLDER = Path(__file__).resolve().parent
BEGIN, END = "  <!-- table: made by docs/make_tree_plot.py, not by hand -->", "  <!-- end of the table -->"
BODIES, ORDER = 100_000, 5
COLOURS = {3: "#d1662f", 4: "#b8a13a", 5: "#1f5fa8", 6: "#5b3f8c"}
MEASURES = {"median": "#3a7d44", "rms": "#1f5fa8", "99%": "#d1662f", "largest": "#d1495b"}


def draw(figures: dict, path: Path) -> None:
    """Left: what an error costs, by order and theta. Right: how the errors of the default order grow with theta."""
    figure = Figure(figsize=(11, 4.6), dpi=110, layout="constrained")
    left, right = figure.subplots(1, 2)
    for order, colour in COLOURS.items():
        found = figures[f"order {order}"]
        cost = [one["seconds"] / BODIES * 1e6 for one in found.values()]
        left.loglog(cost, [one["rms"] for one in found.values()], "o-", color=colour, ms=4, label=f"order {order}")
        for theta in ("0.3", "1.0"):
            left.annotate(theta, (cost[list(found).index(theta)], found[theta]["rms"]), fontsize=8, color=colour)
    left.set(
        title="What accuracy costs, theta from 0.3 to 1", xlabel="microseconds a body", ylabel="rms error of the forces"
    )
    found = figures[f"order {ORDER}"]
    for name, colour in MEASURES.items():
        right.semilogy(
            [float(t) for t in found], [one[name] for one in found.values()], "o-", color=colour, ms=4, label=name
        )
    right.set(title=f"Errors of order {ORDER}", xlabel="theta", ylabel="relative error of a force")
    for panel in (left, right):
        panel.grid(True, which="major", color="#e4e4e4", linewidth=0.8)
        panel.legend(frameon=False, fontsize=9)
    figure.savefig(path)


def table(figures: dict) -> str:
    rows = ["  | order, theta | bodies a second | rms | median | 99% | largest |", "  |---|---|---|---|---|---|"]
    for order in COLOURS:
        for theta in ("0.4", "0.6", "0.7", "0.8", "1.0"):
            one = figures[f"order {order}"][theta]
            errors = " | ".join(f"{one[name]:.1e}" for name in ("rms", "median", "99%", "largest"))
            rows.append(f"  | {order}, {theta} | {BODIES / one['seconds'] / 1e6:.2f} M | {errors} |")
    return "\n".join(rows)


def main() -> None:
    results = FOLDER.parent / "benchmarks" / "results" / "pairs.json"
    figures = json.loads(results.read_text(encoding="utf-8"))["figures"]
    draw(figures, FOLDER / "images" / "tree.png")
    page = FOLDER / "performance.md"
    head, rest = page.read_text(encoding="utf-8").split(BEGIN)
    page.write_text(f"{head}{BEGIN}\n\n{table(figures)}\n{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
