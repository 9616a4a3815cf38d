"""From a slider to the finished frame, for every view of the lessons, in a page without a network."""

import html
import json
import re
import tempfile
from pathlib import Path

from tests.benchmarks.timing import row

CHROMIUM = Path("/usr/bin/chromium")
FRAMES = 120
# The work of a frame is what runs between the start of an animation frame and the end of painting in it, with the
# slider's own handler; a picture a frame is what a hand sees.
MEASURE = """async count => {
    const frame = () => new Promise(requestAnimationFrame), work = [], apart = [];
    const sliders = [...document.querySelectorAll("input[type=range]")].filter(slider => slider.offsetParent);
    const slider = sliders[sliders.length - 1], low = Number(slider.min), high = Number(slider.max);
    await frame();
    let before = performance.now();
    for (let i = 0; i < count; i++) {
        let start;
        requestAnimationFrame(() => { start = performance.now(); });
        slider.value = low + (i + 1) / (count + 1) * (high - low);
        const handled = performance.now();
        slider.dispatchEvent(new Event("input"));
        const handler = performance.now() - handled;
        await new Promise(done => requestAnimationFrame(() => {
            work.push(performance.now() - start + handler);
            done();
        }));
        const now = performance.now();
        apart.push(now - before);
        before = now;
    }
    const sorted = values => values.sort((a, b) => a - b);
    const at = (values, share) => sorted(values)[Math.floor(share * (count - 1))];
    return [at(work, 0.5), at(work, 0.95), 1000 / at(apart, 0.5)];
}"""


def views():
    """Name and page of every view that the lessons hold."""
    for path in sorted(Path("notebooks").glob("[0-9]*.ipynb")):
        outputs = [
            output for cell in json.loads(path.read_text("utf-8"))["cells"] for output in cell.get("outputs", [])
        ]
        shown = ("".join(output.get("data", {}).get("text/html", "")) for output in outputs)
        for number, page in enumerate(re.findall("srcdoc='(.*?)'></iframe>", "".join(shown), re.DOTALL), start=1):
            yield f"{path.stem}, view {number}", html.unescape(page)


def run():
    from playwright.sync_api import sync_playwright

    print("a slider to the finished frame, of 10 ms; pictures a second:")
    with sync_playwright() as driver, tempfile.TemporaryDirectory() as folder:
        flags = ["--headless", "--no-sandbox", "--disable-gpu"]
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=flags)
        page = browser.new_page(viewport={"width": 980, "height": 470})
        for name, view in views():
            path = Path(folder, "view.html")
            path.write_text(view, encoding="utf-8")
            page.goto(path.as_uri())
            page.locator(".said div").first.wait_for()
            median, late, rate = page.evaluate(MEASURE, FRAMES)
            size = f"page {path.stat().st_size / 1000:.0f} kB, {rate:.0f} pictures a second"
            row(f"{name}: median", median / 10, 1, "10 ms")
            row(f"{name}: 95 of 100", late / 10, None, f"10 ms; {size}")
        browser.close()
