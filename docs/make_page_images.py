"""Draws the pictures of the tour and the recipes: what the first `gen-art still` of each page makes, into docs/images.

python docs/make_page_images.py [PAGE ...]      of these pages ("tour/03_forces"), or of all, in about two minutes
"""

import contextlib
import sys
import tempfile
from pathlib import Path

from page_examples import DOCS, examples, pages, write_files
from PIL import Image

from gen_art.commands.main import run

SIZE = "640x360"
QUALITY = 70


def draw(page: Path) -> None:
    """The picture of one page, if it shows one."""
    out = DOCS / "images" / page.relative_to(DOCS).with_suffix(".webp")
    name = out.relative_to(DOCS).as_posix()
    if name not in page.read_text(encoding="utf-8"):
        return
    words = next(command for command in examples(page).commands if command[0] == "still")
    made = words[words.index("-o") + 1]
    with tempfile.TemporaryDirectory() as scratch, contextlib.chdir(scratch):
        write_files(page, Path(scratch))
        if run([*words, "--size", SIZE, "--quality", "final", "--progress", "none"]) != 0:
            sys.exit(f"{name}: the command failed")
        out.parent.mkdir(parents=True, exist_ok=True)
        Image.open(made).convert("RGB").save(out, quality=QUALITY, method=6)
    print(f"{name} {out.stat().st_size / 1000:.0f} KB", flush=True)


if __name__ == "__main__":
    wanted = sys.argv[1:]
    for page in pages():
        if not wanted or page.relative_to(DOCS).with_suffix("").as_posix() in wanted:
            draw(page)
