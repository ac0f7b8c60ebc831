"""Builds the documentation site: the pages of docs/, the Python reference, the gallery and a search, in one folder of files.

python docs/make_site.py [FOLDER]       writes it into FOLDER, site/ when left out

The pages are written for code hosts. Here they get what a site needs: the Python reference from docstrings, a thumbnail at each
force and shape, the navigation from the lists of docs/index.md, and links that lead to the site's own places.
"""

import contextlib
import os
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import python_reference
from make_thumbnails import SIZE, names, sheets
from PIL import Image
from sphinx.cmd.build import main as sphinx_build

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
_LINK = re.compile(r"(!?)\[((?:!\[[^\]]*\]\([^)]*\)|[^\[\]])*)\]\(([^)\s]+)\)")
_BLOCK = re.compile(r"^(```.*?^```)", re.M | re.S)  # code, in which nothing is changed
_LIST_LINK = re.compile(r"^- \[([^\]]+)\]\(([^)]+)\)", re.M)


def pages() -> dict[str, str]:
    """The path of each page in the repository -> its path in the site's sources."""
    found = sorted(path.relative_to(ROOT).as_posix() for path in DOCS.rglob("*.md"))
    return {path: path.removeprefix("docs/") for path in found} | {
        "CHANGELOG.md": "changelog.md",
        "CONTRIBUTING.md": "contributing.md",
        "benchmarks/README.md": "benchmarks/index.md",
        "benchmarks/REJECTED.md": "benchmarks/rejected.md",
        "README.md": "index.md",  # for links to it; the first page is docs/index.md
    }


def outside_code(text: str, change: Callable[[str], str]) -> str:
    """A page with a change made everywhere but in its code."""
    parts = _BLOCK.split(text)
    return "".join(part if k % 2 else change(part) for k, part in enumerate(parts))


def relink(text: str, page: str, sources: Path) -> str:
    """A page's text with links that hold in the site; files that it names are copied beside it."""
    here, known = ROOT / page, pages()
    up = "../" * known[page].count("/")

    def changed(match: re.Match) -> str:
        mark, words, link = match.groups()
        words = _LINK.sub(changed, words)
        path, _, anchor = link.partition("#")
        if "://" in link or link.startswith("mailto:") or not path:
            return f"{mark}[{words}]({link})"
        there = Path(os.path.normpath(here.parent / path))
        name = there.relative_to(ROOT).as_posix()
        anchor = f"#{anchor}" if anchor else ""
        if name in known:  # words that only name the file become the title of the page or the heading
            return f"[{'' if words == there.name else words}]({up}{known[name]}{anchor})"
        if name == "gallery" or name.startswith("gallery/"):
            place = f"{up}{name}{anchor}"
            return f'<img alt="{words}" src="{place}">' if mark else f'<a href="{place}">{words}</a>'
        if there.is_dir():  # of the repository: a site cannot show it
            return words
        return f"{mark}[{words}]({copied(there, name)})"

    def copied(file: Path, name: str) -> str:
        target = sources / "files" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target)
        return f"{up}files/{name}"

    return outside_code(text, lambda part: _LINK.sub(changed, part))


def navigation(index: str) -> str:
    """A hidden table of contents for each list of docs/index.md, under the list's heading."""
    parts = re.split(r"^## (.*)\n", index, flags=re.M)
    tables = []
    for heading, text in zip(parts[1::2], parts[2::2]):
        entries = "\n".join(f"{title} <{page.removesuffix('.md')}>" for title, page in _LIST_LINK.findall(text))
        tables.append(f"```{{toctree}}\n:hidden:\n:caption: {heading}\n\n{entries}\n```\n")
    return index + "\n" + "\n".join(tables)


def thumbnails(text: str, kind: str, sources: Path) -> str:
    """The page of all names with each name's part of the sheet under its heading."""
    sheet, of_sheet = sheets()[kind], Image.open(DOCS / "images" / f"{kind}.webp")
    width, height = sheet.get("size", SIZE)
    for k, name in enumerate(names()[kind]):
        row, column = divmod(k, sheet["columns"])
        path = sources / "files" / "thumbnails" / f"{kind}_{name}.webp"
        path.parent.mkdir(parents=True, exist_ok=True)
        left, top = column * width, row * height
        of_sheet.crop((left, top, left + width, top + height)).save(path, quality=90)
        before, heading, after = text.partition(f"\n### {name}\n")
        text = f"{before}{heading}\n![{name}](files/thumbnails/{path.name})\n{after}"
    return text


def write_sources(sources: Path) -> None:
    """Puts together what Sphinx reads."""
    for page, to in pages().items():
        if page == "README.md":
            continue
        text = (ROOT / page).read_text(encoding="utf-8")
        if page == "docs/python.md":
            text = python_reference.page(text)
        text = relink(text, page, sources)
        if page == "docs/index.md":
            text = navigation(text)
        if page == "docs/forces.md":
            for kind in ("forces", "shapes"):
                text = thumbnails(text, kind, sources)
        target = sources / to
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")


def build(site: Path, sources: Path) -> int:
    """Writes the site; returns 0, or what Sphinx returns after a warning or an error."""
    for folder in (site, sources):
        with contextlib.suppress(FileNotFoundError):
            shutil.rmtree(folder)
    write_sources(sources)
    options = ["-W", "--keep-going", "-q", "-j", "2", "-c", str(DOCS / "site"), "-d", str(sources / ".doctrees")]
    status = sphinx_build([*options, str(sources), str(site)])
    shutil.copytree(ROOT / "gallery", site / "gallery")
    return status


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "site")
    status = build(folder, ROOT / "build" / "site")
    print(f"{folder}/index.html")
    sys.exit(status)
