"""`gen-art inspect`: prints the frames, particles, memory, forces and conserved quantities of a preset."""

import click

from gen_art.commands import options
from gen_art.commands.terminal import echo

__all__ = ["command"]


@click.command("inspect")
@click.argument("preset")
@click.option("--size", type=options.SIZE, help="Width and height in pixels.")
@click.option("--scale", type=options.SCALE, help="Scale the preset's size: 50%.")
@click.option("--precision", type=click.Choice(["f32", "f64"]), default="f32", show_default=True, help="Float type.")
@click.option("--frame", is_flag=True, help="Run ahead, and say how the subject lies in the frame.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, with the resolved preset.")
@options.preset_options
def command(preset, size, scale, precision, frame, as_json, seed, settings, fps, duration, plugins):
    """Print what PRESET contains and needs.

    Frames and steps, particles and memory, forces, conserved quantities, and warnings.
    """
    preset, _ = options.load(preset, seed=seed, settings=settings, fps=fps, duration=duration, plugins=plugins)
    from gen_art.output.job import picture_size

    facts = _facts(preset, picture_size(preset, size, scale), precision)
    if frame:
        facts |= _framing(preset, facts["size"], precision, facts["advice"])
    if as_json:
        import json

        echo(json.dumps({**facts, "resolved": preset.resolved()}, indent=2, ensure_ascii=False))
        return
    clock, memory = facts["clock"], facts["memory"]
    echo(
        f"{preset.name}: {clock['frames']} frames at {clock['fps']:g} a second, {clock['steps_per_frame']} steps of "
        f"{clock['step']:.6g} a frame, {clock['preroll_steps']} before the first; seed {preset.seed}"
    )
    for name, knob in preset.knobs.items():
        echo(f"knob {name}: {knob}")
    if preset.domain is not None:
        echo(f"domain: {preset.domain.box}")
    for name, system in facts["systems"].items():
        echo(f"\n{name}: {system['integrator']}, {system['born']:,} born, at most about {system['peak']:,} at once")
        for label in ("forces", "interactions", "colliders", "medium", "emitters"):
            if system[label]:
                echo(f"  {label:13} {', '.join(system[label])}")
        echo(f"  {'conserved':13} {', '.join(system['should_hold']) or 'nothing by itself'}")
        if system["joules"]:
            echo(f"  {'joules shown':13} {', '.join(system['joules'])}; this keeps the ledger, one launch a step")
        for quantity, reason in system["booked"].items():
            echo(f"  {'in the ledger':13} {quantity}: {reason}")
    if facts["expect"]:
        echo(f"\nexpects ({facts['expect']['verdict']}; `gen-art check` runs it)")
        for claim in facts["expect"]["claims"]:
            echo(f"  {claim}")
    if frame:
        _echo_framing(facts["framing"])
    for sentence in facts["advice"]:
        echo(f"\nwarning: {sentence}")
    from gen_art.preset.estimate import megabytes

    state, still, film = (megabytes(memory[key]) for key in ("state", "still", "film"))
    width, height = facts["size"]
    echo(f"\nmemory: {state} of state; about {still} for a still and {film} for a film of {width}x{height}")


def _facts(preset, size, precision) -> dict:
    from gen_art.audit.advice import advice, step_advice
    from gen_art.audit.invariants import colliders_of, forces_of, invariants
    from gen_art.output.formats import CODECS
    from gen_art.preset.estimate import estimate
    from gen_art.simulation.no_effect import silent_parts, undrawn_systems

    expected, clock = estimate(preset, precision), preset.clock
    systems = {}
    for name, system in preset.systems.items():
        conserved, booked = invariants(preset, system)
        systems[name] = {
            "integrator": system.integrator,
            "born": _count(expected.born[name]),
            "peak": _count(expected.peak[name]),
            "bytes": _count(expected.bytes[name]),
            "forces": [repr(force) for force in forces_of(preset, system)],
            "interactions": [repr(interaction) for interaction in system.interactions],
            "colliders": [_collider_text(collider) for collider in colliders_of(preset, system)],
            "medium": [repr(term) for term in (system.medium or preset.medium).terms],
            "emitters": list(system.emitters),
            "should_hold": conserved,
            "booked": booked,
            "joules": [entry.title for entry in system.ledger_entries],
        }
    return {
        "preset": preset.name,
        "seed": preset.seed,
        "size": list(size),
        "clock": {
            "duration": clock.duration,
            "fps": clock.fps,
            "step": clock.step,
            "speed": clock.speed,
            "frames": clock.frames,
            "steps_per_frame": clock.steps_per_frame,
            "preroll_steps": clock.preroll_steps,
        },
        "knobs": {
            name: {
                "value": knob.value,
                "range": None if knob.range is None else [knob.range.lo, knob.range.hi],
                "unit": knob.unit,
            }
            for name, knob in preset.knobs.items()
        },
        "domain": None if preset.domain is None else {"periodic": preset.domain.box.as_dict()},
        "particles": _count(expected.particles),
        "memory": {
            "state": _count(expected.memory),
            "still": _count(expected.process(size)),
            "film": _count(expected.process(size, CODECS["h264"].memory)),
        },
        "systems": systems,
        "expect": _expectations(preset),
        "advice": list(
            dict.fromkeys([*silent_parts(preset), *undrawn_systems(preset), *advice(preset), *step_advice(preset)])
        ),
    }


def _framing(preset, size, precision, advice: list) -> dict:
    """How the subject lies in the pictures; its advice is added to `advice`."""
    from dataclasses import asdict

    from gen_art.output.check import check_preset
    from gen_art.output.framing import framing_of

    check_preset(preset)
    framing = framing_of(preset, size, precision)
    advice += framing.advice
    found = {"film": framing.film, "still": framing.still, "fit": framing.fit}
    words = {name: str(found[name]) for name in ("film", "still") if found[name] is not None}
    return {
        "framing": {**{k: v and asdict(v) for k, v in found.items()}, "still_time": preset.poster_time, "words": words}
    }


def _echo_framing(framing: dict) -> None:
    names = {"film": "subject over the film", "still": f"subject in the still at {framing['still_time']:.6g} s"}
    for name, words in framing["words"].items():
        echo(f"{chr(10) if name == 'film' else ''}{names[name]}: {words}")
    if framing["fit"]:
        move = ", ".join(f"{x:g}" for x in framing["fit"]["move"])
        echo(
            f"camera.frame: the target moves by [{move}], the distance or height by a factor of {framing['fit']['factor']:g}"
        )


def _expectations(preset) -> dict | None:
    """The claims of `expect:` in words, and their verdict; None without any."""
    from gen_art.audit.claims import claims_of
    from gen_art.output.recipe import version
    from gen_art.preset.verdicts import verdict_of

    verdict = verdict_of(preset, version())
    return verdict and {"verdict": verdict["verdict"], "claims": [claim.words for claim in claims_of(preset)]}


def _collider_text(collider) -> str:
    """A collider as text, without the parameters of a motion that it does not have."""
    values, rotates = collider.values, collider.rotates
    shown = {"velocity": any(values["velocity"]), "angular_velocity": rotates, "pivot": rotates}
    return f"{type(collider).__name__}({', '.join(f'{k}={v!r}' for k, v in values.items() if shown.get(k, True))})"


def _count(value: float) -> int | float:
    return round(value) if value < 1e300 else value
