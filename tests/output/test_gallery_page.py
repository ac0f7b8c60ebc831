"""The page of the gallery: complete, and good to use in a browser from the file system, by mouse, touch and keyboard."""

import shutil

import numpy as np
import pytest
from PIL import Image

from gen_art.output.gallery import contact_sheet
from gen_art.output.gallery import page as gallery
from gen_art.output.gallery.page import families, page
from gen_art.output.stills import write_still
from gen_art.output.video import film_writer
from gen_art.preset.shipped import course_names, preset_names, presets_folder
from tests.output.delta_e import lab

NAMES = [name for family in families() for name in family.pieces]
SHIPPED = presets_folder().parent / "gallery"


def test_every_shipped_preset_hangs_once():
    assert sorted(NAMES) == sorted([*preset_names(), *course_names()])


def test_the_committed_page_is_what_the_command_writes():
    """After a change of a preset: gen-art gallery --page-only."""
    same = (SHIPPED / "index.html").read_text(encoding="utf-8") == page(
        SHIPPED
    )  # pytest would compare line by line for minutes
    assert same, "gallery/index.html is out of date: gen-art gallery --page-only"


def test_the_committed_files_are_light():
    files = [path for path in SHIPPED.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) < 25e6
    assert not [path for path in files if path.stat().st_size > {".webp": 600e3, ".mp4": 1e6}.get(path.suffix, 1e6)]


def colours(still) -> np.ndarray:
    """How much of a picture is of each colour: a histogram in CIELAB, 12 by 12 by 12 apart, smoothed; black says nothing."""
    with Image.open(still) as image:
        small = np.asarray(image.convert("RGB").resize((160, 90), Image.Resampling.BOX)) / 255
    colour = lab(small).reshape(-1, 3)
    edges = [np.linspace(0, 100, 9), *[np.linspace(-100, 100, 17)] * 2]
    amounts, _ = np.histogramdd(colour[colour[:, 0] > 15], bins=edges)
    for axis in range(3):
        amounts = amounts / 2 + (np.roll(amounts, 1, axis) + np.roll(amounts, -1, axis)) / 4
    return amounts / amounts.sum()


def test_no_two_neighbours_share_a_palette():
    """At most 6 tenths of two neighbours are of the same colours; of pieces that look alike it is 9 tenths."""
    stills = {name: colours(SHIPPED / f"{name}.webp") for name in NAMES}
    alike = [
        (a, b)
        for family in families()
        for a, b in zip(family.pieces, family.pieces[1:])
        if np.minimum(stills[a], stills[b]).sum() > 0.6
    ]
    assert not alike
    assert np.minimum(stills["course/chain"], stills["course/crossed_fields"]).sum() > 0.6  # two pieces on paper


def test_only_pieces_with_a_still_and_a_loop_are_shown(tmp_path):
    (tmp_path / "fire.webp").touch()
    assert "fire.webp" not in page(tmp_path)
    (tmp_path / "fire.mp4").touch()
    assert 'href="fire.webp"' in page(tmp_path) and 'href="smoke.webp"' not in page(tmp_path)


def test_no_preset_can_end_the_script(tmp_path, monkeypatch):
    (tmp_path / "fire.yaml").write_text("# <b>hot</b>\n# Physics: </script>\n# Change first: 'x' & \"y\"\n")
    monkeypatch.setattr(gallery, "presets_folder", lambda: tmp_path)
    for name in ("fire.webp", "fire.mp4"):
        (tmp_path / name).touch()
    text = page(tmp_path)
    assert text.count("</script>") == 2 and "&lt;b&gt;hot" in text and "<b>hot" not in text


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The page with a small still and a small loop for every piece."""
    out = tmp_path_factory.mktemp("gallery")
    shades = [np.full((36, 64, 3), shade, np.uint8) for shade in range(40, 160, 8)]
    write_still(out / "one.webp", shades[0], {})
    writer = film_writer(out / "one.mp4", (64, 36), 15)
    for picture in shades:
        writer.add(picture)
    writer.close()
    for name in NAMES:
        (out / name).parent.mkdir(exist_ok=True)
        for suffix in (".webp", ".mp4"):
            shutil.copy(out / f"one{suffix}", out / f"{name}{suffix}")
    (out / "index.html").write_text(page(out), encoding="utf-8")
    return out


@pytest.fixture
def opened(browser, folder):
    """opened(width, height, ...) is the page; at the end of the test nothing has failed in it."""
    contexts, faults = [], []

    def opened(width=1440, height=900, address="", **options):
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda said: faults.append(said.text) if said.type in ("error", "warning") else None)
        tab.on("pageerror", lambda error: faults.append(str(error)))
        tab.on(
            "requestfailed",
            lambda request: (
                faults.append(f"{request.url}: {request.failure}") if "ABORTED" not in request.failure else None
            ),
        )
        tab.goto((folder / "index.html").as_uri() + address)
        return tab

    yield opened
    for context in contexts:
        context.close()
    assert faults == []


def comes(tab, what: str) -> None:
    """Waits until it is true in the page: an event and what follows it there take turns with what the test asks."""
    tab.wait_for_function(what)


@pytest.mark.parametrize("width, height, columns", [(360, 740, 1), (900, 1000, 2), (1600, 1000, 3)])
def test_the_wall_fits_the_screen(opened, width, height, columns):
    tab = opened(width, height)
    assert tab.locator(".tile").count() == len(NAMES)
    assert tab.evaluate("document.documentElement.scrollWidth") == width
    boxes = [tile.bounding_box() for tile in tab.locator(".wall").first.locator(".tile").all()]
    assert len({round(box["x"]) for box in boxes}) == columns
    for box in boxes:
        assert box["x"] >= 8 and box["x"] + box["width"] <= width - 8
        assert box["width"] / box["height"] == pytest.approx(16 / 9, abs=0.01)
    tab.locator(".tile").first.click()
    assert tab.evaluate("document.querySelector('dialog').scrollWidth") <= width
    for button in tab.locator("dialog menu button").all():
        box = button.bounding_box()
        assert min(box["width"], box["height"]) >= 44 and box["x"] >= 0 and box["y"] + box["height"] <= height
    picture = tab.locator("dialog img").bounding_box()
    assert picture["width"] <= width and picture["height"] <= height and picture["width"] >= min(0.7 * width, 1200)


def test_every_link_leads_to_a_file_or_a_place_of_the_page(opened, folder):
    tab = opened()
    targets = tab.evaluate(
        "[...document.querySelectorAll('[href],[src],[data-source]')].map(e => e.getAttribute('href') || e.getAttribute('src') || e.dataset.source)"
    )
    places = {target for target in targets if target.startswith("#")}
    assert places and all(tab.locator(place).count() == 1 for place in places)
    files = {target for target in targets if target} - places - {"data:,"}
    assert len(files) == 2 * len(NAMES) and all((folder / file).is_file() for file in files)


def test_the_keyboard_opens_turns_plays_and_closes(opened):
    tab = opened()
    first = tab.locator(".tile").first
    for _ in range(1 + len(families())):
        tab.keyboard.press("Tab")
    assert first.evaluate("tile => tile === document.activeElement")
    tab.keyboard.press("Enter")
    heading, dialog = tab.locator("dialog h2"), tab.locator("dialog")
    comes(tab, f"location.hash === '#{NAMES[0]}' && document.querySelector('dialog').open")
    title = heading.inner_text()
    tab.keyboard.press("ArrowRight")
    comes(tab, f"location.hash === '#{NAMES[1]}'")
    assert heading.inner_text() != title
    tab.keyboard.press("ArrowLeft")
    tab.keyboard.press("ArrowLeft")
    comes(tab, f"location.hash === '#{NAMES[-1]}'")  # before the first hangs the last
    tab.locator("[data-play]").focus()
    tab.keyboard.press("Enter")
    comes(tab, "(video => video.currentTime > 0 && !video.paused)(document.querySelector('dialog video'))")
    tab.keyboard.press("Enter")
    tab.locator("dialog video").wait_for(state="hidden")
    assert tab.locator("dialog img").is_visible()
    tab.keyboard.press("Escape")
    dialog.wait_for(state="hidden")
    comes(tab, "document.activeElement === [...document.querySelectorAll('.tile')].at(-1)")


def test_a_loop_plays_while_the_mouse_is_on_it(opened):
    tab = opened()
    tile, moves = tab.locator(".tile").nth(1), "document.querySelectorAll('.tile')[1].classList.contains('moves')"
    assert tab.evaluate("[...document.querySelectorAll('.tile video')].filter(v => v.src).length") == 0, (
        "loaded when wanted"
    )
    tile.hover()
    comes(tab, moves)
    assert tab.evaluate("[...document.querySelectorAll('.tile video')].filter(v => v.src).length") == 1
    tab.locator("h1").hover()
    comes(tab, f"!{moves} && document.querySelectorAll('.tile video')[1].paused")


def test_nothing_moves_by_itself_for_those_who_ask_for_calm(opened):
    tab = opened(reduced_motion="reduce")
    tab.locator(".tile").nth(1).hover()
    tab.wait_for_timeout(300)
    assert tab.evaluate("[...document.querySelectorAll('video')].every(video => video.paused && !video.src)")


def test_by_touch_what_stands_in_sight_moves_and_a_tap_opens(opened):
    tab = opened(390, 800, has_touch=True, is_mobile=True)
    tab.locator(".tile").nth(2).scroll_into_view_if_needed()
    comes(tab, "document.querySelectorAll('.tile.moves').length > 0")
    tab.locator(".tile").nth(2).tap()
    tab.locator("dialog").wait_for(state="visible")


@pytest.mark.parametrize("name", [NAMES[0], NAMES[20]])
def test_an_address_opens_a_piece_with_its_yaml_and_its_command(opened, name):
    tab = opened(address="#" + name)
    tab.locator("dialog").wait_for(state="visible")
    assert tab.locator("[data-text=yaml]").text_content() == (presets_folder() / f"{name}.yaml").read_text(
        encoding="utf-8"
    )
    assert tab.locator("[data-text=command]").inner_text() == f"gen-art render {name} -o {name.split('/')[-1]}.mp4"
    tab.locator("[data-copy=command]").click()
    comes(tab, "/Copied|Selected/.test(document.querySelector('[data-copy=command]').textContent)")
    tab.locator("[data-close]").click()
    tab.locator("dialog").wait_for(state="hidden")
    comes(tab, "location.hash === ''")


def test_the_contact_sheet_shows_each_of_its_pieces_in_its_place(tmp_path):
    """Mutants: rows and columns exchanged; the first piece in every place."""
    shades = {}
    for k, name in enumerate(contact_sheet.PIECES):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        assert contact_sheet.write_contact_sheet(tmp_path) is None, "while a still is missing"
        shades[name] = 20 * k
        write_still(tmp_path / f"{name}.webp", np.full((90, 160, 3), shades[name], np.uint8), {})
    (width, height), gap = contact_sheet.TILE, contact_sheet.GAP
    with Image.open(contact_sheet.write_contact_sheet(tmp_path)) as picture:
        sheet = np.asarray(picture.convert("L")).astype(float)
    for k, name in enumerate(contact_sheet.PIECES):
        row, column = divmod(k, contact_sheet.COLUMNS)
        seen = sheet[row * (height + gap) + height // 2, column * (width + gap) + width // 2]
        assert seen == pytest.approx(shades[name], abs=4)  # WebP with loss


def test_the_committed_contact_sheet_shows_shipped_pieces():
    assert len(contact_sheet.PIECES) == len(set(contact_sheet.PIECES)) == 12 and set(contact_sheet.PIECES) <= set(NAMES)
    assert (SHIPPED / "contact_sheet.webp").is_file()
    assert "gallery/contact_sheet.webp" in (SHIPPED.parent / "README.md").read_text(encoding="utf-8")
