"""Draws the plots of docs/integrators.md, and fills in its table, from real runs.

python docs/make_plots.py           writes docs/images/*.png and the table; takes a minute; needs matplotlib
"""

from pathlib import Path

import matplotlib
import numpy as np

import gen_art as ga
from gen_art.integrators import INTEGRATORS

FOLDER = Path(__file__).resolve().parent
BEGIN, END = "<!-- table: made by docs/make_plots.py, not by hand -->", "<!-- end of the table -->"
F = ga.forces
SPAN = 0.8 * np.pi  # of the orbit, whose period is 2 pi

SHOWN = {  # name: (colour, line); those that take the same steps share one
    "euler": ("#d1495b", "-"), "semi_implicit_euler": ("#e08e45", "-"), "rk2": ("#b8a13a", "-"),
    "position_verlet": ("#3a7d44", "--"), "leapfrog": ("#3a7d44", "-"), "yoshida4": ("#2e86ab", "-"), "rk4": ("#5b3f8c", "-"),
}  # fmt: skip
LABELS = {"leapfrog": "leapfrog, velocity_verlet", "euler": "euler (explicit)"}
# name: (symplectic, reversible, when to use it)
TRAITS = {
    "euler": ("no", "no", "to see what goes wrong"),
    "semi_implicit_euler": ("yes", "no", "implicit springs; the cheapest that keeps an orbit"),
    "rk2": ("no", "no", "forces that depend on the velocity (lift), over short times"),
    "rk4": ("no", "no", "smooth forces and drag over short times, to many digits"),
    "position_verlet": ("yes", "yes", "one evaluation a step whatever the forces: turbulence, many particles"),
    "velocity_verlet": ("yes", "yes", "the default: orbits, springs, contacts, long times"),
    "leapfrog": ("yes", "yes", "the same steps by another name"),
    "yoshida4": ("yes", "yes", "orbits over long times, to many digits"),
    "boris": ("volume", "yes", "magnetic fields: keeps the speed exactly"),
    "vay": ("no", "yes", "fast charges in crossed fields"),
    "higuera_cary": ("volume", "yes", "fast charges in crossed fields, over long times"),
}  # fmt: skip


def on_orbit(t: float, e: float) -> np.ndarray:
    """The position at time t of an orbit with GM = a = 1 from pericentre, by Kepler's equation."""
    E = t
    for _ in range(60):
        E -= (E - e * np.sin(E) - t) / (1 - e * np.cos(E))
    return np.array([np.cos(E) - e, np.sqrt(1 - e * e) * np.sin(E), 0.0])


def kepler(name: str, steps: int, e: float = 0.5) -> float:
    """The distance from the truth after 0.4 periods of an orbit with GM = a = 1; after whole ones first-order errors cancel."""
    star = ga.ParticleSystem(
        position=[[1 - e, 0, 0]],
        velocity=[[0, np.sqrt((1 + e) / (1 - e)), 0]],
        forces=[F.PointGravity(GM=1.0)],
        integrator=name,
    )
    sim = ga.Simulation({"star": star}, dt=SPAN / steps, precision="f64")
    sim.step(steps)
    return float(np.linalg.norm(sim["star"].position[0] - on_orbit(SPAN, e)))


def damped(name: str, steps: int) -> float:
    """The error of x'' + 0.4 x' + x = 0 after t = 10, from rest at 1."""
    ball = ga.ParticleSystem(position=[[1.0, 0, 0]], forces=[F.Spring(stiffness=1.0), F.Damping(0.4)], integrator=name)
    sim = ga.Simulation({"b": ball}, dt=10.0 / steps, precision="f64")
    sim.step(steps)
    w = np.sqrt(1 - 0.04)
    return abs(sim["b"].position[0, 0] - np.exp(-2.0) * (np.cos(10 * w) + 0.2 / w * np.sin(10 * w)))


def adaptive(rtol: float) -> tuple[float, float]:
    """(evaluations, error) of adaptive steps over the same arc."""
    star = ga.ParticleSystem(position=[[0.5, 0, 0]], velocity=[[0, np.sqrt(3.0), 0]], forces=[F.PointGravity(GM=1.0)])
    sim = ga.Simulation({"star": star}, dt=SPAN, precision="f64")
    effort = ga.adaptive(sim, SPAN, rtol=rtol, atol=rtol * 1e-3)
    return effort.evaluations, float(np.linalg.norm(sim["star"].position[0] - on_orbit(SPAN, 0.5)))


def growth(name: str, turns: np.ndarray, steps: int = 64) -> np.ndarray:
    """The factor by which an oscillation's amplitude grows each step, at most, for each w dt: w^2 = 1 / m."""
    r = np.random.default_rng(0)
    phase = r.uniform(0, 2 * np.pi, (16, 1))
    w = np.tile(turns, (16, 1))
    x, v = np.cos(phase) + 0 * w, np.sin(phase) * w
    ball = ga.ParticleSystem(
        position=np.stack([x.ravel(), 0 * x.ravel(), 0 * x.ravel()], 1),
        velocity=np.stack([v.ravel(), 0 * x.ravel(), 0 * x.ravel()], 1),
        mass=1 / w.ravel() ** 2, forces=[F.Spring(stiffness=1.0)], integrator=name,
    )  # fmt: skip
    sim = ga.Simulation({"b": ball}, dt=1.0, precision="f64")
    sizes = []
    for _ in range(4):
        sim.step(steps)
        found = np.hypot(sim["b"].position[:, 0], sim["b"].velocity[:, 0] / w.ravel()).reshape(w.shape)
        sizes.append(np.log(found.max(0)))
    return np.exp((sizes[-1] - sizes[0]) / (3 * steps))


def charged_end(name: str, steps: int) -> np.ndarray:
    ion = ga.ParticleSystem(
        position=[[1.0, 0, 0.2]], velocity=[[0, 0.8, 0.1]], charge=1.0, integrator=name, speed_of_light=2.0,
        forces=[F.Spring(stiffness=2.0), F.MagneticMirror(2.0)],
    )  # fmt: skip
    sim = ga.Simulation({"i": ion}, dt=2.0 / steps, precision="f64")
    sim.step(steps)
    return sim["i"].position[0]


def measured_order(name: str) -> float:
    """From dt to dt / 2: of the orbit's error, or for pushers of the change of a fast charge's end."""
    n = {1: 40000, 2: 1600, 4: 600}[INTEGRATORS[name].order]
    if INTEGRATORS[name].pusher:
        a, b, c = (charged_end(name, k) for k in (100, 200, 400))
        return float(np.log2(np.linalg.norm(a - b) / np.linalg.norm(b - c)))
    return float(np.log2(kepler(name, n) / kepler(name, 2 * n)))


def table() -> str:
    rows = [
        "| name | order | measured | evaluations a step | symplectic | reversible | stable for w dt below | when to use it |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, one in INTEGRATORS.items():
        symplectic, reversible, use = TRAITS[name]
        kept = " (1: see below)" if one.stages[-1][2] == 0 and one.kind == "splitting" else ""
        limit = f"{one.stability_limit:.3g}" if name not in ("euler", "rk2") else "never"
        rows.append(
            f"| `{name}` | {one.order} | {measured_order(name):.2f} | {len(one.stages)}{kept} | {symplectic} | {reversible} "
            f"| {limit} | {use} |"
        )
    return "\n".join(rows)


def _axes(figure, count: int):
    panels = figure.subplots(1, count)
    for one in panels:
        one.grid(True, which="major", color="#e4e4e4", linewidth=0.8)
        one.set_axisbelow(True)
        for side in ("top", "right"):
            one.spines[side].set_visible(False)
    return panels


def draw_orders(path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.6), dpi=110, layout="constrained")
    left, right = _axes(figure, 2)
    counts = np.unique(np.geomspace(12, 12000, 15).round().astype(int))
    for name, (colour, line) in SHOWN.items():
        for panel, error, span in ((left, kepler, SPAN), (right, damped, 10.0)):
            found = np.array([error(name, int(n)) for n in counts])
            seen = (found < 1) & (found > 0)
            panel.loglog(span / counts[seen], found[seen], line, color=colour, lw=1.8, label=LABELS.get(name, name))
    for panel, title in (
        (left, "An orbit with e = 0.5, after 0.4 periods"),
        (right, "A damped oscillator, w = 1, after t = 10"),
    ):
        panel.set(title=title, xlabel="time step", ylabel="error of the position", ylim=(1e-14, 2))
    right.legend(frameon=False, fontsize=9, loc="lower right")
    figure.savefig(path)


def draw_effort(path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.6), dpi=110, layout="constrained")
    left, right = _axes(figure, 2)
    counts = np.unique(np.geomspace(12, 12000, 15).round().astype(int))
    for name, (colour, line) in SHOWN.items():
        one = INTEGRATORS[name]
        cost = 1 if one.stages[-1][2] == 0 and one.kind == "splitting" else len(one.stages)
        found = np.array([kepler(name, int(n)) for n in counts])
        seen = found < 1
        left.loglog(cost * counts[seen], found[seen], line, color=colour, lw=1.8, label=LABELS.get(name, name))
    steps = np.array([adaptive(10.0**-k) for k in range(3, 13)])
    left.loglog(*steps.T, "-", color="#222222", lw=1.8, label="adaptive")
    left.set(
        title="What 0.4 periods of the orbit cost", xlabel="evaluations of the force", ylabel="error of the position"
    )
    left.set_ylim(1e-13, 2)
    left.legend(frameon=False, fontsize=9, loc="lower left")
    turns = np.linspace(0.02, 3.2, 400)
    for name, (colour, line) in SHOWN.items():
        right.plot(turns, growth(name, turns), line, color=colour, lw=1.8, label=LABELS.get(name, name))
    right.axhline(1, color="#888888", lw=0.8)
    right.set(
        title="Stability: an undamped oscillator", xlabel="w dt", ylabel="growth of the amplitude a step",
        xlim=(0, 3.2), ylim=(0.85, 1.6),
    )  # fmt: skip
    figure.savefig(path)


def main() -> None:
    matplotlib.use("Agg")
    images = FOLDER / "images"
    images.mkdir(exist_ok=True)
    draw_orders(images / "orders.png")
    draw_effort(images / "effort.png")
    page = FOLDER / "integrators.md"
    text = page.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    page.write_text(f"{head}{BEGIN}\n{table()}\n{END}{rest.split(END)[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
