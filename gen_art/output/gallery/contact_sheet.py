"""The contact sheet: twelve of the gallery's stills side by side in one picture."""

from pathlib import Path

from gen_art.files import beside

__all__ = ["PIECES", "write_contact_sheet"]

PIECES = (
    "fire", "galaxy", "course/lake", "charged",
    "course/marbles", "smoke", "course/flag", "wormhole",
    "fireworks", "course/pendulums", "course/wet_street", "course/rocket",
)  # fmt: skip
COLUMNS, TILE, GAP = 4, (400, 225), 8  # pixels


def write_contact_sheet(folder: Path) -> Path | None:
    """Write `folder`/contact_sheet.webp from the stills NAME.webp of PIECES in `folder`; nothing (None) while one is missing."""
    from PIL import Image

    paths = [folder / f"{name}.webp" for name in PIECES]
    if not all(path.is_file() for path in paths):
        return None
    (width, height), rows = TILE, len(paths) // COLUMNS
    sheet = Image.new("RGB", (COLUMNS * (width + GAP) - GAP, rows * (height + GAP) - GAP), "white")
    for k, path in enumerate(paths):
        with Image.open(path) as still:
            place = (k % COLUMNS * (width + GAP), k // COLUMNS * (height + GAP))
            sheet.paste(still.convert("RGB").resize(TILE, Image.Resampling.LANCZOS), place)
    written = folder / "contact_sheet.webp"
    with beside(written) as temporary:
        sheet.save(temporary, "WEBP", quality=88, method=6)
    return written
