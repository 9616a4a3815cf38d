"""The carrier of a view: what a browser gets that is too old for it, and that none of today's is."""

import io
import re
from itertools import product

import numpy as np
import pytest
from PIL import Image

from mathpost.teaching.course import view_machine
from mathpost.teaching.draw import live
from tests.test_browser import Live, browser, opened  # noqa: F401, a fixture

# Syntax and methods that came after 2018: a browser that does not know them shows the still picture for ever.
NEW = re.compile(
    r"\?\?|\?\.[\w([]|(?:\|\||&&|\?\?)=|(?<!\.)\.(?:replaceChildren|replaceAll|at|findLast)\(|^ {4}[#\w]+ = ",
    re.MULTILINE,
)


@pytest.mark.parametrize("path", sorted(live.HERE.glob("*.js")), ids=lambda path: path.name)
def test_modules_need_no_new_browser(path):
    assert not NEW.findall(path.read_text(encoding="utf-8"))


def test_a_machine_carries_less_than_twenty_kilobytes_of_program():
    sent = [live._dense((live.HERE / name).read_text(encoding="utf-8")) for name in live.MODULES["machine"]]
    assert len("".join(sent).encode()) < 20_000


def test_what_is_new_is_found():
    for code in ("a ?? b", "a?.b", "a?.(b)", "a ||= b", "list.at(-1)", "box.replaceChildren(a)", "    field = 3;"):
        assert NEW.search(code)
    assert not NEW.search("a ? .5 : b || c")


def test_a_view_that_cannot_start_leaves_the_still_picture(browser, dmu50v, tmp_path):  # noqa: F811
    """Chromium without what older browsers have not: on a page and in an output, the picture and no empty frame."""
    view = view_machine.machine(dmu50v)
    pages = {"page": view.page(still=True), "output": f"<body style='margin:0'>{view._repr_html_()}"}
    still = np.asarray(Image.open(io.BytesIO(view.picture())).convert("RGB"), dtype=float)
    page = opened(browser)
    page.set_viewport_size({"width": 980, "height": 440})
    for name, missing in product(pages, ("", "delete window.ResizeObserver", "delete Array.prototype.flatMap")):
        path = tmp_path / "old.html"
        text = pages[name].replace("<script", f"<script>{missing}</script><script", 1)
        path.write_text(text, encoding="utf-8")
        if missing:
            with page.expect_event("pageerror"):
                page.goto(path.as_uri())
        else:
            page.goto(path.as_uri())
            Live(page.frames[-1]).picture()  # it is drawn
        seen = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB"), dtype=float)
        apart = np.abs(seen[: len(still), : len(still[0])] - still).mean()
        assert (apart < 1) == bool(missing), f"{name}, {missing}: {apart:.1f} apart"
