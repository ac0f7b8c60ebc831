"""The preset that a draft is drawn of: a picture of half the width and height needs fewer particles.

Points and streaks are thinned as the pixels are, to a quarter; soft discs fill a volume, and half the resolution in three
dimensions needs an eighth of them.
Only systems are thinned that are drawn as light or smoke and whose particles move no other particle. The rest looks and moves as
in the film, but bodies of a galaxy, which attract each other, are fewer and heavier.
"""

from typing import TYPE_CHECKING, Any

from gen_art.preset.estimate import estimate
from gen_art.preset.load import load_preset
from gen_art.preset.overrides import plain
from gen_art.preset.thinning import counts_thinned_to, galaxies, independent_systems, overrides_of

if TYPE_CHECKING:
    from gen_art.preset.look import Look, Ramp
    from gen_art.preset.schema import Preset

__all__ = ["drafted"]

SHARE, SHARE_OF_DISCS = 1 / 4, 1 / 8  # of a system's particles; of those of one that is drawn as discs alone
FEWEST = 10_000  # particles of a system at once that a draft keeps
FEWEST_POINTS = 16  # of a ribbon; paths between them are curved, so half of many show the same path
SOFT = ("point", "pixel", "disc", "streak")


def drafted(preset: "Preset") -> "Preset":
    """The preset with fewer particles: of large systems of light or smoke a quarter, of discs an eighth, at least about 10,000.

    Of 1 / k of the particles, soft discs are k^(1/3) times as wide, which is how much farther apart the particles are, and
    k^(1/3) times as bright and as dense; other sprites are k times as bright, and as dense. So the picture has the same light,
    and as much is hidden. Ribbons of many points keep half of them. Numbers follow from the whole film, so that all of its frames
    have the same particles.
    """
    until = preset.clock.simulated
    full = estimate(preset, "f64", until)
    most = {name: max(share * full.peak[name], FEWEST) for name, share in _shares(preset).items()}
    few, changes = counts_thinned_to(preset, until, most)
    born = estimate(few, "f64", until).born if changes else full.born
    overrides = overrides_of(changes)
    for name, system in few.systems.items():
        ratio = full.born[name] / max(born[name], 1.0)
        for key, look in system.all_looks.items():
            if ratio > 1.0:
                overrides |= _compensated(f"systems.{name}.{key}", look, ratio)
            if look.ribbon is not None and look.ribbon.points > FEWEST_POINTS:
                overrides[f"systems.{name}.{key}.ribbon.points"] = max(look.ribbon.points // 2, FEWEST_POINTS)
    return load_preset(preset, overrides=overrides) if overrides else preset


def _shares(preset: "Preset") -> dict[str, float]:
    """What a draft keeps of each system that may have fewer particles."""
    independent, shares = independent_systems(preset), {}
    for name in [*independent, *galaxies(preset)]:
        drawn = {look.draw for look in preset.systems[name].all_looks.values()}
        if drawn.issubset(SOFT):
            shares[name] = SHARE_OF_DISCS if name in independent and drawn == {"disc"} else SHARE
    return shares


def _compensated(path: str, look: "Look", ratio: float) -> dict[str, Any]:
    """What makes a look's sprites, `ratio` times fewer, show and hide as much as all of them."""
    wider = ratio ** (1 / 3) if look.draw == "disc" else 1.0
    changes = {f"{path}.size": _times(look.size, wider)} if wider != 1.0 else {}
    if look.emission is not None:
        changes[f"{path}.emission.intensity"] = _times(look.emission.intensity, ratio / wider**2)
    elif look.blend == "add":
        changes[f"{path}.emission"] = {"intensity": ratio / wider**2}
    if look.blend == "alpha":
        changes[f"{path}.opacity"] = _times(look.opacity, ratio if look.reference is not None else ratio / wider**2)
    return changes


def _times(ramp: "Ramp", factor: float) -> dict[str, Any]:
    """A ramp as in YAML, with the values of its curve multiplied."""
    curve = [[float(x), float(y) * factor] for x, y in ramp.curve.points]
    return {**plain(ramp.model_dump(include={"by", "range"}, exclude_none=True)), "curve": curve}
