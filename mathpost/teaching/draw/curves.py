"""Curves that move in the browser: a matplotlib figure whose lines, patches and texts are points and colours.

`printed` moves them by expressions, `recorded` replays them over sliders.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import sympy as sp
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon
from matplotlib.text import Text
from numpy.typing import ArrayLike

from mathpost.teaching.draw.colours import COLOUR
from mathpost.teaching.draw.described import places as shown_at
from mathpost.teaching.draw.live import Button, Live, Points, Slider, TextLine, compiled

DASHES: dict[Any, list[int]] = {"-": [], "--": [6, 4], ":": [1, 3], "-.": [7, 3, 1, 3]}
Drawn = Patch | Line2D | Text
Movable = Polygon | Line2D | Text


def subplots(
    rows: int = 1, columns: int = 1, *, size: tuple[float, float] = (7.0, 4.2), **shared: Any
) -> tuple[Figure, Any]:
    """Return a figure, `size` in inches, that pyplot does not know, and its axes, as `Figure.subplots` does."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, **shared)


def recorded(figure: Figure, update: Callable[..., list[str]], *controls: Slider, height: int = 460) -> Live:
    """Record a figure at all positions of its sliders, for the page to replay.

    `figure` is from `subplots`. ``update(value, ...)`` moves its artists and returns a list of lines of text; it is
    called at every step of each of the `controls`, from `slider`. `height` is in pixels.
    """
    steps = [each["low"] + np.arange(_steps(each) + 1) * each["step"] for each in controls]
    positions = list(product(*(values.tolist() for values in steps)))  # the last slider runs fastest
    said, frames, artists = [], [], _artists(figure)
    for values in positions:
        said.append(update(*values))
        frames.append([shown_at(*each) for each in artists])
    nearest = [np.abs(values - each["value"]).argmin() for values, each in zip(steps, controls, strict=True)]
    start = int(np.ravel_multi_index(nearest, [len(values) for values in steps]))
    update(*positions[start])
    moving: list[Drawn] = []
    across: list[list | None] = []  # the x of an artist if only its heights change
    moved: list[list[list]] = [[] for _ in positions]
    for (artist, _), *way in zip(artists, *frames, strict=True):  # its points in each position
        if any(not np.array_equal(points, way[0], equal_nan=True) for points in way):
            moving.append(artist)
            upwards = all(np.array_equal(points[:, 0], way[0][:, 0]) for points in way)
            across.append(_short(way[0][:, 0]) if upwards else None)
            for frame, points in zip(moved, way, strict=True):
                frame.append(_short(points[:, 1] if upwards else points))
    state = {"sliders": list(controls), "said": said, "frames": moved, "x": across} | _spec(figure, moving)
    return Live(state, [], "; ".join(said[start]), figure=figure, height=height, layout="column")


def _steps(control: Slider) -> int:
    return round((control["high"] - control["low"]) / control["step"])


class Moving(dict[Movable, Points]):
    """The lines that `printed` moves: a dict of each to its points, pairs (x, y) of expressions."""

    def line(self, axes: Axes, role: str, points: Points, style: str = "-", **how: Any) -> None:
        """Add a line in the colour of a role."""
        (line,) = axes.plot([], [], style, color=COLOUR[role], **how)
        self[line] = points


def printed(
    figure: Figure,
    points: Mapping[Movable, Points],
    symbols: Sequence[sp.Symbol],
    sliders: Sequence[Slider],
    text: Sequence[TextLine],
    *,
    buttons: Sequence[Button] = (),
    height: int = 460,
) -> Live:
    """Move a figure's artists by printed expressions.

    `figure` is from `subplots`; `points` a dict of artist to pairs (x, y) of sympy expressions, such as a `Moving`.
    `symbols`, `sliders`, `text` and `buttons` are those of `formula`, `height` that of `recorded`.
    """
    drawn = [artist for artist, _ in _artists(figure)]
    order = sorted(points, key=drawn.index)
    state, code, said, ends, _ = compiled(symbols, sliders, text, [points[artist] for artist in order])
    for artist, end in zip(order, ends, strict=True):
        if isinstance(artist, Text):
            artist.set_position(end[0])
        elif isinstance(artist, Line2D):
            artist.set_data(*end.T)
        else:
            artist.set_xy(end)
    state |= {"counts": list(map(len, ends))} | _spec(figure, order)
    if buttons:
        state["places"] = [list(button) for button in buttons]
    return Live(state, code, said, figure=figure, height=height, layout="column")


def _artists(figure: Figure) -> list[tuple[Drawn, Axes]]:
    return [(artist, axes) for axes in figure.axes for artist in _drawn_in(axes)]


def _drawn_in(axes: Axes) -> list[Drawn]:
    return [*axes.patches, *axes.lines, *axes.texts]


def _short(points: ArrayLike) -> list[float | None]:
    """Points as a flat list of numbers of five digits; NaN is None."""
    return [float(f"{x:.5g}") if np.isfinite(x) else None for x in np.ravel(points)]


def _spec(figure: Figure, moving: Sequence[Drawn]) -> dict[str, Any]:
    """The panels of a figure: scales, ticks, artists; the points of a moving artist are None."""
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # it is laid out: the still picture need not do it again
    panels = []
    for axes in figure.axes:
        panel: dict[str, Any] = {
            "title": axes.get_title(),
            "equal": axes.get_aspect() == 1,
            "drawn": axes.axison,
            "artists": [],
        }
        for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            limits = list(map(float, getattr(axes, f"get_{name}lim")()))
            marks = axis.get_majorticklocs()
            written = zip(marks, axis.get_major_formatter().format_ticks(list(marks)), strict=True)
            within = [(float(at), text) for at, text in written if min(limits) <= at <= max(limits)]
            ticks = [[at, f"{at:g}" if "$" in text else text] for at, text in within]
            label, log = axis.get_label_text(), axis.get_scale() == "log"
            panel[name] = {"limits": limits, "log": log, "label": label, "ticks": ticks}
        for artist in _drawn_in(axes):
            points = None if artist in moving else _short(shown_at(artist, axes))
            panel["artists"].append(_drawn(artist) | {"points": points})
        panels.append(panel)
    grid = figure.axes[0].get_gridspec()
    return {"kind": "chart", "panels": panels, "columns": grid.ncols if grid else 1}


def _drawn(artist: Drawn) -> dict[str, Any]:
    """The look of an artist."""
    if isinstance(artist, Text):
        return {"colour": to_hex(artist.get_color()), "text": artist.get_text()}
    if isinstance(artist, Patch):
        return {"fill": to_hex(artist.get_facecolor(), keep_alpha=True)}
    label, style = str(artist.get_label()), artist.get_linestyle()
    looks: dict[str, Any] = {"label": "" if label.startswith("_") else label, "colour": to_hex(artist.get_color())}
    looks |= {"width": artist.get_linewidth() if style in DASHES else 0, "dash": DASHES.get(style, [])}
    looks |= {"marker": str(artist.get_marker()).replace("None", ""), "open": artist.get_fillstyle() == "none"}
    return looks | {"last": artist.get_markevery() is not None}
