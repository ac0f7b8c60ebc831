"""Named palettes: sRGB-encoded colours over 0..1, evenly spaced or as [position, colour], interpolated in OKLab.

The `PERCEPTUAL` palettes increase in OKLab lightness from end to end, so that larger values look brighter: use them to show
a quantity. The others are artistic. `NAME reversed` is the palette in the opposite direction.

Seven palettes have a known name and are within 0.02 of its colours in OKLab, about the smallest difference that an eye can
see: viridis, magma, inferno and plasma (S. van der Walt and N. Smith, 2015), cividis (Nunez, Anderton and Renslow, PLOS ONE
2018), turbo (A. Mikhailov, 2019) and the cyclic twilight (B. Bechtold, 2017). Their stops were fitted so that the largest
difference is smallest.
"""

from gen_art.registry import suggest

__all__ = ["PALETTES", "PERCEPTUAL", "hint", "names", "palette"]

_KNOWN: dict[str, list] = {
    "viridis": ["#450057", "#453986", "#2f688b", "#239090", "#27b87a", "#8dd73c", "#fce70e"],
    "magma": [
        [0, "#000006"], [0.04, "#050412"], [0.125, "#1c104b"], [0.25, "#501081"], [0.375, "#83257c"], [0.5, "#b53880"],
        [0.625, "#e74e5c"], [0.75, "#fa8865"], [1, "#fbfcb8"],
    ],
    "inferno": [
        [0, "#000004"], [0.04, "#050513"], [0.125, "#210a4f"], [0.25, "#570c72"], [0.375, "#872766"], [0.5, "#be3159"],
        [0.625, "#e05d29"], [0.75, "#fd8a20"], [0.875, "#f5cc22"], [1, "#f7ff9f"],
    ],
    "plasma": ["#090c88", "#5f00a9", "#9d10a1", "#cd4574", "#ec7a58", "#ffb122", "#edfa32"],
    "cividis": [
        "#002354", "#143876", "#474d64", "#5d6677", "#80796f", "#979680", "#bfaa61", "#d9cb66", "#ffe511",
    ],
    "turbo": [
        "#301340", "#424fc2", "#4c83fc", "#22bcf2", "#26e3b0", "#4efe7b", "#a3fe2a", "#d7e545", "#fbba28", "#fd812b",
        "#e54201", "#ba2408", "#7c0000",
    ],
    "twilight": [
        "#e5dbe3", "#b6c9cf", "#779fc1", "#6277b8", "#6043aa", "#4e126e", "#2e1132", "#57164c", "#902b4b", "#b55856",
        "#c48768", "#d4bfb0", "#e5dbe3",
    ],
}  # fmt: skip

_RISING: dict[str, list] = {  # even steps of OKLab lightness
    "mono": ["#000000", "#ffffff"],
    "slate": ["#05070f", "#242b39", "#485669", "#6d7e8f", "#94a8b6", "#c1d0c9", "#f8f5ee"],
    "tide": ["#0a071f", "#1e2453", "#264a8e", "#187aad", "#2ba9c2", "#7fd6d0", "#ceffe8"],
    "petal": ["#18031d", "#4e1048", "#911b6a", "#c43f75", "#ec7380", "#feb391", "#ffefdb"],
    "canopy": ["#000f0e", "#013229", "#025c3b", "#3b8841", "#7db138", "#c1d270", "#faf6af"],
    "lava": ["#120102", "#490308", "#8a0700", "#b74503", "#e37710", "#f7b74e", "#fff3ba"],
    "amethyst": ["#0b0027", "#310a65", "#5e1da8", "#8c53c6", "#bb82e3", "#e3b4ee", "#ffebfc"],
}

_ARTISTIC: dict[str, list] = {
    "fire": ["#000000", "#4a0d03", "#b32b06", "#f07414", "#ffc65a", "#fff6dc"],
    "embers": ["#1a0502", "#7a1a05", "#e2560f", "#ffb347"],
    "candle": ["#0b0503", "#5b2408", "#c8691a", "#ffc873", "#fff4d6", "#cfe0ff"],
    "ocean": ["#020a1c", "#0b3a6a", "#1583a8", "#5fd3d0", "#f0fbf3"],
    "abyss": ["#00040a", "#021b2e", "#043f4f", "#0a7a6e", "#4fe0a8"],
    "lagoon": ["#06303f", "#0c7f8c", "#3fcfc0", "#f4efc9", "#f7b48a"],
    "ice": ["#05101f", "#1f4e79", "#6fb1dd", "#d9f1ff", "#ffffff"],
    "glacier": ["#0a1a2b", "#27506e", "#5b93a8", "#a9d5d6", "#eef8f4", "#c6d3f2"],
    "aurora": ["#0a1030", "#11607a", "#1fd6a0", "#b8f58a", "#a86bff"],
    "nebula": ["#0b0620", "#3a1466", "#a3267f", "#f0725e", "#ffe0b0"],
    "dusk": ["#0d1b3d", "#44357c", "#a8487f", "#f08a5d", "#ffd9a0"],
    "sunset": ["#1c1240", "#632064", "#c63d5c", "#ff7f3f", "#ffc94d", "#fff0b8"],
    "dawn": ["#20304f", "#5f6a94", "#c590a8", "#f7bfa0", "#ffe9c2", "#d8ecf7"],
    "storm": ["#0b0e14", "#2a3342", "#56606b", "#8b8f86", "#d8cf9d", "#fffbe0"],
    "moss": ["#0a120a", "#274427", "#5f8a3c", "#b9cf6b", "#f2f0c0"],
    "desert": ["#2a140d", "#7a3a1f", "#c77b42", "#e9bf83", "#f6e7c6", "#8fb4bf"],
    "orchid": ["#170a1f", "#57206b", "#b24aa5", "#ef95bf", "#fde3e1"],
    "peacock": ["#07122b", "#0a3f7a", "#00918f", "#3fc46b", "#d9c53f"],
    "opal": ["#f3e9e4", "#b9e3dc", "#9fc0f0", "#d7b3ec", "#ffc9c4", "#fdf3d0"],
    "neon": ["#0b0018", "#4a00c8", "#ff1fb4", "#ff9d3c", "#3cf5ff"],
    "starlight": ["#9bb8ff", "#cfdcff", "#fff8f0", "#ffd9a8", "#ff9d5c"],
    "dust": ["#120b08", "#3e2a1e", "#7c5a40", "#b99674"],
    "spectrum": ["#ff3b4a", "#ff9f2e", "#f6ee4a", "#3ce07a", "#36a8ff", "#9a5bff"],
}

PERCEPTUAL = ("viridis", "magma", "inferno", "plasma", "cividis", *_RISING)
PALETTES: dict[str, list] = {**_KNOWN, **_RISING, **_ARTISTIC}
_REVERSED = " reversed"


def names() -> list[str]:
    """The names of all palettes, also reversed, for editors."""
    return [name + suffix for name in PALETTES for suffix in ("", _REVERSED)]


def palette(text: str) -> list | None:
    """The stops of `NAME` or `NAME reversed`, or None when there is no such palette."""
    words = " ".join(text.lower().split())
    if words in PALETTES:
        return PALETTES[words]
    stops = PALETTES.get(words.removesuffix(_REVERSED))
    if stops is None:
        return None
    return [[1 - stop[0], stop[1]] if isinstance(stop, list) else stop for stop in reversed(stops)]


def hint(text: str, colours) -> str:
    """A suggestion for a word that is neither a colour nor a palette."""
    name = " ".join(text.split()).removesuffix(_REVERSED)
    return suggest(name, [*colours, *PALETTES])
