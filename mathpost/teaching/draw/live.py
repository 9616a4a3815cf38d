"""Views that move in the browser, in an output or a file, without a kernel, a server or a network.

`formula` moves a scene by sympy expressions; `mathpost.teaching.draw.curves` moves the curves of a figure. In a
notebook a view is a sandboxed iframe over a still picture of the same pose, which is seen where no scripts run.
"""

from __future__ import annotations

import base64
import html
import io
import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

import numpy as np
import sympy as sp
from PIL import Image

from mathpost.files import read_text
from mathpost.formula import numeric
from mathpost.shop import codegen
from mathpost.teaching.draw.described_scene import describe_scene, describe_values
from mathpost.teaching.draw.picture import png, small_png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mathpost.teaching.draw.scene import Scene

HERE = Path(__file__).parent
COLUMNS = 3  # pictures side by side
CURVES, PATHS = ("live.js", "chart.js"), ("live.js", "machine.js", "paths.js")  # each needs those before it
MODULES = {"formula": CURVES[:1], "chart": CURVES, "machine": PATHS[:2], "both": PATHS, "walk": PATHS}
GAP = re.compile(r"\{(?::(\d+)|\?([^}]*))\}")


@dataclass(repr=False, eq=False)
class Live:
    """A view that moves in the browser: scenes, or the curves of a figure."""

    state: dict[str, Any]  # for `live.js`: kind, sliders, texts; the scenes are added here
    machines: list[str]  # printed functions (`mathpost.shop.codegen`), one text per machine
    readings: str  # the numbers at the start, as text
    scenes: Sequence[Scene] = ()
    figure: Figure | None = None  # as it is at the start
    height: int = 440  # pixels on the page
    layout: str = "row"  # the controls beside the picture, or under it: "column"

    def __post_init__(self) -> None:
        self.state = self.state | {"layout": self.layout, "scenes": [scene.state() for scene in self.scenes]}

    def page(self, title: str = "mathpost", *, before: str = "", after: str = "", still: bool = False) -> str:
        """Return a whole HTML page; `before` and `after` are HTML around the view.

        With `still` the still picture is under the view, for browsers that are too old for it.
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

    def picture(self) -> bytes:
        """Return the initial view as a PNG file, bytes."""
        if self.figure:
            file = io.BytesIO()
            self.figure.savefig(file, format="png", dpi=90)
            return small_png(Image.open(file))
        width = 480 if self.layout == "row" else 720
        high, columns = 400 if len(self.scenes) == 1 else 300, min(len(self.scenes), COLUMNS)
        return png(self.scenes, (width // columns, high), columns)

    def _still(self, style: str) -> str:
        still, name = base64.b64encode(self.picture()).decode(), html.escape(self.readings, quote=True)
        return f'<img alt="{name}" src="data:image/png;base64,{still}" style="{style}">'

    def _repr_html_(self) -> str:
        page = self.page().replace("&", "&amp;").replace("'", "&#39;")
        high = f"{self.height}px"  # on a narrow screen more, where a browser knows max()
        high += f";height:max({high},min(860px,{self.height + 600}px - 100vw))"
        return (
            f'<div class="mathpost-live" style="position:relative;max-width:980px;height:{high}">'
            f"{self._still('max-width:100%;max-height:100%')}"
            '<iframe title="view" sandbox="allow-scripts" style="position:absolute;left:0;top:0;width:100%;'
            f"height:100%;border:0\" srcdoc='{page}'></iframe></div>"
        )

    def __repr__(self) -> str:
        return self.readings

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """Print the readings, and the pictures in numbers, so that a wrong picture fails a lesson's test."""
        shown = list(map(describe_scene, self.scenes))
        if self.figure:
            from mathpost.teaching.draw.described import describe  # loads matplotlib, which scenes do not need

            ways = enumerate(zip(*self.state.get("frames", []), strict=True), 1)
            shown = [describe(self.figure), *(describe_values(f"moving artist {n}", way) for n, way in ways)]
        printer.text("\n".join([self.readings, *shown]))


class Slider(TypedDict):
    """A slider of the page; printed functions take its value times its factor."""

    name: str
    low: float
    high: float
    value: float
    step: float
    unit: str
    factor: float
    hidden: NotRequired[bool]


TextLine = tuple[str, *tuple[sp.Expr, ...]]  # a line under the pictures, and its numbers
Points = Sequence[Iterable[sp.Expr]]  # pairs (x, y), or 3×1 matrices
Button = tuple[str, Sequence[float | None]]  # a label, and the values to set


def slider(
    name: str, low: float, high: float, value: float, *, step: float = 1.0, unit: str = "°", hidden: bool = False
) -> Slider:
    """Return a slider: an angle in degrees unless `unit` says otherwise; with `hidden` only buttons move it.

    Its box takes no number below `low` or above `high`. Printed functions take angles in radians, other units as
    they are.
    """
    factor = np.pi / 180 if unit == "°" else 1.0
    made = Slider(name=name, low=low, high=high, value=value, step=step, unit=unit, factor=factor)
    return Slider(**made, hidden=True) if hidden else made


def compiled(
    symbols: Sequence[sp.Symbol],
    sliders: Sequence[Slider],
    text: Sequence[TextLine],
    ways: Sequence[Points],
    **functions: Sequence[sp.Expr],
) -> tuple[dict[str, Any], list[str], str, list[np.ndarray], dict[str, np.ndarray]]:
    """Print the expressions that sliders move as JavaScript, and evaluate them at the sliders' start.

    `text` is as in `formula`, `ways` are lists of points, `functions` expressions by name. Returns the state for
    the browser, the JavaScript, the text and the ways at the start, and the values of the functions, a dict.
    """
    functions["points"] = [entry for way in ways for point in way for entry in point]
    functions["numbers"] = [entry for _, *entries in text for entry in entries]
    code = "\n".join(codegen.function(name, entries, symbols) for name, entries in functions.items())
    start = [each["value"] * each["factor"] for each in sliders]
    values = {name: numeric(tuple(entries), tuple(symbols))(*start) for name, entries in functions.items()}
    numbers, left = iter(values["numbers"]), iter(values["points"])
    ends = [np.reshape([[next(left) for _ in point] for point in way], (len(way), -1)) for way in ways]

    def filled(gap: re.Match[str]) -> str:
        digits, words = gap.groups()
        return f"{next(numbers):z.{digits}f}" if digits else words * bool(next(numbers))

    lines = [line for line, *_ in text]
    said = "; ".join(GAP.sub(filled, line) for line in lines)
    return {"sliders": list(sliders), "text": lines}, [code], said, ends, values


def formula(
    scenes: Sequence[Scene],
    symbols: Sequence[sp.Symbol],
    sliders: Sequence[Slider],
    places: dict[str, sp.Matrix],
    text: Sequence[TextLine],
    *,
    buttons: Sequence[Button] = (),
    play: int | None = None,
    **options: Any,
) -> Live:
    """Return a view of one or more `Scene`s that move by printed expressions.

    Each slider, from `slider`, sets one of the `symbols`, angles in radians. `places` maps the name of a body to a
    matrix in the symbols, a 3×3 rotation or a 4×4 transform. A line with `points`, 3×1 matrices in its body's
    coordinates, is redrawn through them. `text` are tuples of a line under the pictures and its numbers: ``{:4}``
    is the next number with four decimals, ``{?words}`` shows the words if the next is not 0. `buttons` are pairs of
    a label and the values to set, None to leave a slider alone; `play` is the number of the slider that plays;
    `options` are those of `Live`.

    Examples
    --------
    >>> from mathpost.teaching.draw.scene import Scene
    >>> from mathpost.rotation import ACTIVE
    >>> t = sp.Symbol("t")
    >>> plate = {"plate": ACTIVE["Z"](t)}
    >>> formula([Scene()], [t], [slider("t", 0, 90, 60)], plate, [("cosine {:2}", sp.cos(t))])
    cosine 0.50
    """
    placed = [matrix if matrix.rows == 4 else sp.diag(matrix, 1) for matrix in places.values()]
    lines = [line for scene in scenes for line in scene.lines if line.points]
    entries = [entry for matrix in placed for entry in matrix[:3, :]]
    state, code, said, ends, start = compiled(symbols, sliders, text, [e.points for e in lines], places=entries)
    for line, way in zip(lines, ends, strict=True):
        line.parts = [way]
    rows = start["places"].reshape(-1, 3, 4)
    at = {"bed": np.eye(4)} | {n: np.vstack([r, [0, 0, 0, 1]]) for n, r in zip(places, rows, strict=True)}
    for scene in scenes:
        scene.places = at
    state |= {"kind": "formula", "play": play, "places": [list(button) for button in buttons]}
    return Live(state, code, said, scenes, **options)


def _dense(code: str) -> str:
    """Code without indentation, comment lines, imports and exports."""
    return re.sub(r"(?m)^\s*(?:(?://[^\n]*|(?:import|export) \{[^}]*\}[^\n]*))?\n?", "", code)
