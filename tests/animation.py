"""``python -m tests.animation``: the picture at the top of the README, a lesson whose machine moves."""

import io
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from mathpost.interface.site import sources
from tests.conftest import ROOT

CHROMIUM = Path("/usr/bin/chromium")
PICTURE = ROOT / "notebooks/images/machine.webp"
FRAMES, RATE = 30, 12  # and pictures a second


def main():
    """Publish lesson 00, turn B and C of its machine with the tip kept, and write what is seen."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        sources.build(ROOT / "notebooks", Path(folder))
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--headless", "--no-sandbox"])
        page = browser.new_page(viewport={"width": 1100, "height": 640})
        page.goto(Path(folder, "lessons/00_start_here.html").as_uri())
        page.locator(".mathpost-live").evaluate("view => view.scrollIntoView({block: 'center'})")
        view = page.locator(".mathpost-live iframe").content_frame
        view.get_by_role("checkbox").check()
        pictures = []
        for turn in np.linspace(0, 2 * np.pi, FRAMES, endpoint=False):
            for name, angle in (("B", 55 - 35 * np.cos(turn)), ("C", 30 + 60 * np.sin(turn))):
                box = view.get_by_label(f"{name}, °")
                box.fill(f"{angle:.3f}")
                box.press("Enter")
            page.wait_for_timeout(60)
            shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            pictures.append(shot.resize((825, 480), Image.Resampling.LANCZOS))
        browser.close()
    PICTURE.parent.mkdir(exist_ok=True)
    options = {"save_all": True, "append_images": pictures[1:], "duration": 1000 // RATE, "loop": 0}
    pictures[0].save(PICTURE, quality=45, method=6, **options)
    print(f"{PICTURE}: {PICTURE.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
