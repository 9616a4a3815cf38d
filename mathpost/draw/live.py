"""The page of a view that moves: the JavaScript, the printed functions and the state, in an output or a file.

In a notebook it is a sandboxed iframe over a still picture of the same pose, which shows where no scripts run. It
needs no kernel, no server and no network.
"""

import base64
import html
import io
import json
import re
from dataclasses import dataclass
from pathlib import Path

from mathpost.draw.described import describe, describe_scene, describe_values
from mathpost.draw.picture import png
from mathpost.errors import read_text

HERE = Path(__file__).parent
COLUMNS = 3  # pictures beside each other
CURVES, PATHS = ("live.js", "chart.js"), ("live.js", "machine.js", "paths.js")  # each needs those before
MODULES = {"formula": CURVES[:1], "chart": CURVES, "machine": PATHS[:2], "both": PATHS, "walk": PATHS}


@dataclass(repr=False, eq=False)
class Live:
    """A view that moves in the browser: scenes, or the curves of a figure."""

    state: dict  # for `live.js`: kind, sliders, texts; the scenes are added here
    machines: list  # printed functions (`mathpost.codegen`), one text per machine
    readings: str  # the numbers at the start, as text
    scenes: list = ()  # of `Scene`
    figure: object = None  # of matplotlib, as it is at the start
    height: int = 440  # pixels on the page
    layout: str = "row"  # the controls beside the picture, or under it: "column"

    def __post_init__(self):
        self.state = self.state | {"layout": self.layout, "scenes": [scene.state() for scene in self.scenes]}

    def page(self, title="mathpost", *, before="", after="", still=False):
        """Return a whole HTML page; `before` and `after` are HTML around the view.

        With `still` the still picture lies under the view, for browsers that are too old for it.
        """
        style, *modules = (read_text(HERE / name) for name in ("live.css", *MODULES[self.state["kind"]]))
        program = "\n".join(map(_dense, modules))
        code = []
        for text in self.machines:
            names = ", ".join(re.findall(r"^(?:function|const) (\w+)", text, re.MULTILINE))
            code.append(f"(() => {{\n{_dense(text)}\nreturn {{ {names} }};\n}})()")
        state = json.dumps(self.state, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
        under = self._still("position:absolute;z-index:-1;max-width:100%") if still else ""
        return (
            f"<!doctype html><html lang=en><meta charset=utf-8><title>{html.escape(title)}</title>"
            '<meta name=viewport content="width=device-width">'
            f"<style>{style}</style>{before}{under}<div id=live></div>{after}<script type=module>\n"
            f"{program}\n"
            f'start(document.getElementById("live"), {state}, [{",".join(code)}]);\n</script></html>\n'
        )

    def picture(self):
        """Return the start as a PNG file, bytes."""
        if self.figure:
            file = io.BytesIO()
            self.figure.savefig(file, format="png", dpi=90)
            return file.getvalue()
        width = 480 if self.layout == "row" else 720
        high, columns = 400 if len(self.scenes) == 1 else 300, min(len(self.scenes), COLUMNS)
        return png(self.scenes, (width // columns, high), columns)

    def _still(self, style):
        still, name = base64.b64encode(self.picture()).decode(), html.escape(self.readings, quote=True)
        return f'<img alt="{name}" src="data:image/png;base64,{still}" style="{style}">'

    def _repr_html_(self):
        page = self.page().replace("&", "&amp;").replace("'", "&#39;")
        high = f"{self.height}px"  # on a narrow screen more, where a browser knows max()
        high += f";height:max({high},min(660px,{self.height + 600}px - 100vw))"
        return (
            f'<div class="mathpost-live" style="position:relative;max-width:980px;height:{high}">'
            f"{self._still('max-width:100%;max-height:100%')}"
            '<iframe title="view" sandbox="allow-scripts" style="position:absolute;left:0;top:0;width:100%;'
            f"height:100%;border:0\" srcdoc='{page}'></iframe></div>"
        )

    def __repr__(self):
        return self.readings

    def _repr_pretty_(self, printer, cycle):
        """Print the readings, and the pictures in numbers, so that a wrong picture fails a lesson's test."""
        shown = list(map(describe_scene, self.scenes))
        if self.figure:
            ways = enumerate(zip(*self.state.get("frames", []), strict=True), 1)
            shown = [describe(self.figure), *(describe_values(f"moving artist {n}", way) for n, way in ways)]
        printer.text("\n".join([self.readings, *shown]))


def _dense(code):
    """Code without indentation, comment lines, imports and exports."""
    return re.sub(r"(?m)^\s*(?:(?://[^\n]*|(?:import|export) \{[^}]*\}[^\n]*))?\n?", "", code)
