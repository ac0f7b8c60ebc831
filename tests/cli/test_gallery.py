"""gen-art gallery, but for its pictures: the page is tested in tests/output/test_gallery_page.py."""


def test_what_is_not_shipped_is_refused(gen_art, tmp_path):
    said = gen_art("gallery", "fyre", "-o", tmp_path)
    assert said.status == 2 and "shows the shipped presets, and 'fyre' is none" in said.err
    assert not list(tmp_path.glob("*.html"))


def test_the_page_alone_is_written_of_what_lies_there(gen_art, tmp_path):
    for name in ("smoke.webp", "smoke.mp4", "fire.webp"):
        (tmp_path / name).touch()
    assert gen_art("gallery", "--page-only", "-o", tmp_path).status == 0
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "gen-art render smoke" in text and "gen-art render fire" not in text
