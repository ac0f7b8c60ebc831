"""Writes docs/images/studio.webp: the studio's page as a browser shows it. Needs Chromium and the extra `dev`."""

import io
import subprocess
import sys
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from tests import chromium

server = subprocess.Popen(
    [sys.executable, "-m", "gen_art", "studio", "fire", "--no-browser"], stdout=subprocess.PIPE, text=True
)
assert server.stdout is not None
address = server.stdout.readline().strip()
with sync_playwright() as playwright:
    browser = playwright.chromium.launch(executable_path=chromium.PATH, args=chromium.QUIET)
    page = browser.new_page(viewport={"width": 1280, "height": 760})
    page.goto(address)
    while int(page.locator("#picture").get_attribute("data-shown") or 0) < 2:  # small at once, then in full
        time.sleep(0.2)
    page.locator("#tree details > summary", has_text="systems").first.click()
    page.wait_for_timeout(500)
    shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    shot.save(Path(__file__).parent / "images" / "studio.webp", quality=82, method=6)
    browser.close()
server.terminate()
