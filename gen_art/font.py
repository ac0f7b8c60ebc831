"""The font of text in pictures, DejaVu Sans Condensed: its characters, and sizes of text (docs/looks.md says how it was made)."""

import unicodedata
from functools import lru_cache
from pathlib import Path

__all__ = ["characters", "drawable", "font", "lines_of", "missing", "text_size"]

FOLDER = Path(__file__).parent / "fonts"


@lru_cache(1)
def characters() -> frozenset[str]:
    """The characters that the font has, from fonts/characters.txt."""
    codes: set[int] = set()
    for line in (FOLDER / "characters.txt").read_text(encoding="utf-8").splitlines():
        for part in line.partition("#")[0].replace(",", " ").split():
            first, _, last = part.partition("-")
            codes |= set(range(int(first, 16), int(last or first, 16) + 1))
    return frozenset(map(chr, codes))


def missing(text: str) -> list[str]:
    """The characters of a text that the font does not have, each once; the ends of lines are none."""
    return list(dict.fromkeys(c for c in text if c not in characters() and c != "\n"))


def drawable(text: str) -> str:
    """The text in characters that the font has: without an accent that it lacks, and what has no likeness is a question mark."""
    plain = "".join(c if c in characters() else unicodedata.normalize("NFKD", c) for c in text)
    return "".join(c if c in characters() else "?" for c in plain if not unicodedata.combining(c))


@lru_cache(32)
def font(size: int):
    """The font with letters of `size` pixels (the em). Pillow's basic layout is the same on every system."""
    from PIL import ImageFont

    return ImageFont.truetype(FOLDER / "DejaVuSansCondensed-subset.ttf", size, layout_engine=ImageFont.Layout.BASIC)


def lines_of(text: str) -> list[str]:
    """The lines of a text, without empty ones at its end."""
    return text.rstrip("\n").split("\n")


def text_size(text: str, size: float) -> tuple[float, float]:
    """(width, height) of a text of one or several lines in letters of `size` pixels."""
    measured = font(100)
    width = max(measured.getlength(line) for line in lines_of(text))
    return 0.01 * size * width, 0.01 * size * sum(measured.getmetrics()) * len(lines_of(text))
