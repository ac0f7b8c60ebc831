"""The page of the gallery: families of pieces, each with its still, its loop, its command and its YAML."""

import json
import re
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path
from string import Template

from ruamel.yaml import YAML

from gen_art.preset.shipped import presets_folder

__all__ = ["LOOP", "STILL", "Family", "families", "page"]

STILL, LOOP = (1280, 720), (640, 360)  # pixels
HERE = Path(__file__).parent


@dataclass(frozen=True)
class Family:
    """Pieces that hang together.

    pieces : names of presets, in the order in which they hang
    """

    title: str
    text: str
    pieces: tuple[str, ...]


@cache
def families() -> tuple[Family, ...]:
    """The families of all shipped presets, as families.yaml lists them."""
    listed = YAML(typ="safe").load(HERE / "families.yaml")
    return tuple(Family(each["title"], each["text"], tuple(each["pieces"])) for each in listed)


def page(folder: Path) -> str:
    """The HTML of `folder`/index.html, with those pieces whose still and loop (NAME.webp, NAME.mp4) lie in `folder`.

    It needs nothing but these files: style, script and every YAML stand in the page itself.
    """
    shown: list[dict[str, str]] = []
    sections, links = [], []
    for family in families():
        pieces = [name for name in family.pieces if _has(folder, name)]
        if not pieces:
            continue
        anchor = re.sub(r"\W+", "-", family.title.lower())
        links.append(f'<a href="#{anchor}">{escape(family.title)}</a>')
        tiles = []
        for name in pieces:
            piece = _piece(name)
            tiles.append(_TILE.substitute({key: escape(value) for key, value in piece.items()}, number=len(shown)))
            shown.append(piece)
        sections.append(
            f'<section id="{anchor}" aria-labelledby="{anchor}-title">\n<h2 id="{anchor}-title">{escape(family.title)}</h2>\n'
            f"<p>{escape(family.text)}</p>\n<div class=wall>\n{''.join(tiles)}</div>\n</section>"
        )
    data = json.dumps(shown, ensure_ascii=False).replace("<", "\\u003c")  # so that no text ends the script
    template = Template((HERE / "page.html").read_text(encoding="utf-8"))
    return template.substitute(
        links="\n".join(links),
        sections="\n".join(sections),
        data=data,
        count=len(shown),
        script=_text("page.js"),
        style=_text("page.css"),
    )


_TILE = Template("""<figure>
<a class=tile href="$still" data-number="$number">
<img src="$still" width=1280 height=720 loading=lazy alt="$shows">
<video data-source="$loop" muted loop playsinline preload=none tabindex=-1 aria-hidden=true></video>
</a>
<figcaption><b>$title</b> $shows</figcaption>
</figure>
""")


def _has(folder: Path, name: str) -> bool:
    return (folder / f"{name}.webp").is_file() and (folder / f"{name}.mp4").is_file()


def _piece(name: str) -> dict[str, str]:
    """What the page says of a preset; its first three lines tell what is seen, the physics, and what to change first."""
    text = (presets_folder() / f"{name}.yaml").read_text(encoding="utf-8")
    shows, physics, change = (line.lstrip("# ").strip() for line in text.splitlines()[:3])
    return {
        "name": name,
        "title": name.split("/")[-1].replace("_", " ").capitalize(),
        "shows": shows,
        "physics": physics.removeprefix("Physics: "),
        "change": change.removeprefix("Change first: "),
        "still": f"{name}.webp",
        "loop": f"{name}.mp4",
        "command": f"gen-art render {name} -o {name.split('/')[-1]}.mp4",
        "yaml": text,
    }


def _text(name: str) -> str:
    return (HERE / name).read_text(encoding="utf-8")
