"""The documentation site: it builds without a warning, fits a phone and a desk, and its search works from the file system."""

import importlib
import re
import sys
from pathlib import Path

import pytest

import gen_art as ga

DOCS = Path(__file__).resolve().parent.parent / "docs"
PHONE, DESK = (390, 844), (1280, 900)


def _module(name: str):
    sys.path.insert(0, str(DOCS))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(DOCS))


make_site = _module("make_site")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    assert make_site.build(folder / "site", folder / "sources") == 0, "Sphinx warns"
    return folder / "site"


@pytest.fixture
def opened(browser, site):
    """Opens pages of the site; at the end there was no error and no request that left the folder."""
    complaints: list[str] = []
    tabs = []

    def open_at(size):
        tab = browser.new_page(viewport={"width": size[0], "height": size[1]})
        tabs.append(tab)
        tab.on("console", lambda message: complaints.append(message.text) if message.type == "error" else None)
        tab.on("pageerror", lambda error: complaints.append(str(error)))
        tab.on("request", lambda request: complaints.append(request.url) if re.match("https?:", request.url) else None)
        return tab

    yield open_at
    for tab in tabs:
        tab.close()
    assert not complaints


@pytest.mark.parametrize("size", [PHONE, DESK], ids=["phone", "desk"])
def test_no_page_is_wider_than_the_window(opened, site, size):
    tab = opened(size)
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 40
    wide = []
    for page in pages:
        tab.goto(page.as_uri())
        if tab.evaluate("document.documentElement.scrollWidth") > size[0]:
            wide.append(page.relative_to(site).as_posix())
    assert not wide


def test_a_page_that_is_too_wide_is_noticed(opened, site):
    """The mutant: a table's frame that does not scroll."""
    tab = opened(PHONE)
    tab.goto((site / "forces.html").as_uri())
    tab.add_style_tag(content=".table-wrapper, .content { overflow: visible !important; min-width: 900px }")
    assert tab.evaluate("document.documentElement.scrollWidth") > PHONE[0]


def test_the_search_finds_a_name_from_the_file_system(opened, site):
    tab = opened(DESK)
    tab.goto((site / "search.html").as_uri() + "?q=self_gravity")
    tab.locator("#search-results li a", has_text="> self_gravity").first.wait_for()
    tab.locator("#search-results li a", has_text="> self_gravity").first.click()
    tab.locator("section#self-gravity").wait_for()  # until it is seen
    assert "forces.html" in tab.url and tab.url.endswith("#self-gravity")


def test_pictures_are_there(opened, site):
    """Of the first page, of a force and of the tour; and the gallery opens."""
    tab = opened(DESK)
    for page, picture in (
        ("index.html", "img[src*=contact_sheet]"), ("forces.html", "section#drag img"), ("tour/03_forces.html", "article img"),
    ):  # fmt: skip
        tab.goto((site / page).as_uri())
        assert tab.locator(picture).first.evaluate("img => img.complete && img.naturalWidth > 200"), page
    tab.goto((site / "index.html").as_uri())
    tab.locator("a", has_text="gallery").first.click()
    tab.locator(".tile").nth(40).wait_for(state="attached")  # the page is still being read


def test_every_public_name_is_in_the_python_reference(site):
    text = (site / "python.html").read_text(encoding="utf-8")
    missing = [name for name in ga.__all__ if name != "__version__" and f">ga.{name}<" not in text]
    assert not missing


def test_every_page_of_the_repository_is_in_the_navigation(site):
    text = (site / "index.html").read_text(encoding="utf-8")
    sidebar = text[text.index('class="sidebar-tree"') :]
    for page, to in make_site.pages().items():
        if to != "index.md":
            assert f'href="{to.removesuffix(".md")}.html"' in sidebar, page


@pytest.mark.parametrize("text,becomes", [
    ("a : one\n    and more\nb, c : two\nRaises UsageError.", "`a`\n: one and more\n\n`b, c`\n: two\n\nRaises UsageError."),
    ("Words\nof one line.\n\n    call(1)\n\n    call(2)\n\nx  (3,) m", "Words of one line.\n\n```python\ncall(1)\n\ncall(2)\n```\n\n`x`\n: (3,) m"),
    ("m * v < `a * b`\nkind : one\nor the other", "m \\* v \\< `a * b`\n\n`kind`\n: one or the other"),
])  # fmt: skip
def test_docstrings_become_markdown(text, becomes):
    assert _module("python_reference").markdown(text) == becomes


def test_links_lead_to_the_places_of_the_site(tmp_path):
    """Pages keep their anchors, words that are a file's name become its title, code stays, folders lose their link."""
    text = "[presets.md](presets.md#time) [it](../CHANGELOG.md) [tests](../tests)\n```\n[a](../CHANGELOG.md)\n```\n[g](../gallery/index.html)"
    assert make_site.relink(text, "docs/looks.md", tmp_path) == (
        '[](presets.md#time) [it](changelog.md) tests\n```\n[a](../CHANGELOG.md)\n```\n<a href="gallery/index.html">g</a>'
    )
    assert (
        make_site.relink("[c](../../CONTRIBUTING.md)", "docs/tour/01_first_picture.md", tmp_path)
        == "[c](../contributing.md)"
    )
