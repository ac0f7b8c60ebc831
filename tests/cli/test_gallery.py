"""gen-art gallery, but for its pictures: the page is tested in tests/output/test_gallery_page.py."""

from gen_art.commands.gallery import moments
from gen_art.preset.load import load_preset


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


def test_loops_lie_round_the_still_s_moment_and_within_the_film():
    """Mutants: frames counted at the preset's rate; a loop that begins at the still."""

    def film(**gallery):
        clock = {"duration": 8, "fps": 30, "step": "1/120"}
        return load_preset({"version": 1, "systems": {"a": {}}, "clock": clock, "gallery": gallery})

    assert moments(film(time=3), large=False) == (3, range(15, 75), 15)  # 1 to 5 s
    assert moments(film(time=3), large=True) == (3, range(15, 165), 30)  # 0.5 to 5.5 s
    assert moments(film(time=7.5), large=False)[1] == range(60, 120)
    assert moments(film(time=1, loop="2..6"), large=False)[1] == range(30, 90)
