"""Curves that move in the browser: a matplotlib figure, recorded over one slider or moved by printed expressions.

The figure is drawn once, as for print; its artists (lines, patches, texts) go to the page as points and colours.
"""

import numpy as np
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from mathpost.draw.described import places
from mathpost.draw.formula import compiled
from mathpost.draw.live import Live

DASHES = {"-": [], "--": [6, 4], ":": [1, 3], "-.": [7, 3, 1, 3]}


def subplots(rows=1, columns=1, *, size=(7.0, 4.2), **shared):
    """Return a figure of so many inches, which no window shows, and its axes, as `Figure.subplots` does."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, **shared)


def recorded(figure, update, control, *, height=460):
    """Record what one slider does to a figure: Python draws each position once, the page needs no Python.

    `figure` is from `subplots`. ``update(value)`` moves artists to the slider's value and returns a list of lines
    of text. Every step of `control`, from `mathpost.draw.formula.slider`, is recorded. `height` is in pixels.
    """
    steps = round((control["high"] - control["low"]) / control["step"])
    values = control["low"] + np.arange(steps + 1) * control["step"]
    said, frames = [], []
    for value in values:
        said.append(update(float(value)))
        frames.append([places(artist, artist.axes) for artist in _artists(figure)])
    start = int(np.abs(values - control["value"]).argmin())
    update(float(values[start]))
    moving, state = [], {"sliders": [control], "said": said, "frames": [[] for _ in values], "x": []}
    for way in zip(*frames, strict=True):  # the points of one artist in each position
        moving.append(any(not np.array_equal(points, way[0], equal_nan=True) for points in way))
        if moving[-1]:
            upwards = all(np.array_equal(points[:, 0], way[0][:, 0]) for points in way)
            state["x"].append(_short(way[0][:, 0]) if upwards else None)
            for frame, points in zip(state["frames"], way, strict=True):
                frame.append(_short(points[:, 1] if upwards else points))
    state |= _spec(figure, moving)
    return Live(state, [], "; ".join(said[start]), figure=figure, height=height, layout="column")


def printed(figure, points, symbols, sliders, text, *, height=460):
    """Move a figure's artists by printed expressions.

    `figure` is from `subplots`; `points` a dict of artist to pairs (x, y) of sympy expressions, such as a `Moving`.
    `symbols`, `sliders` and `text` are those of `mathpost.draw.formula.formula`, `height` that of `recorded`.
    """
    order = [artist for artist in _artists(figure) if artist in points]
    state, code, said, ends, _ = compiled(symbols, sliders, text, [points[artist] for artist in order])
    for artist, end in zip(order, ends, strict=True):
        if isinstance(artist, Text):
            artist.set_position(end[0])
        else:
            artist.set_data(*end.T) if hasattr(artist, "set_data") else artist.set_xy(end)
    state |= {"counts": list(map(len, ends))} | _spec(figure, [artist in points for artist in _artists(figure)])
    return Live(state, code, said, figure=figure, height=height, layout="column")


def _artists(figure):
    return [artist for axes in figure.axes for artist in (*axes.patches, *axes.lines, *axes.texts)]


def _short(points):
    """Points as numbers of five digits in one list, None where there is none."""
    return [float(f"{x:.5g}") if np.isfinite(x) else None for x in np.ravel(points)]


def _spec(figure, moving):
    """The panels of a figure: scales, ticks, artists; each moving artist with None for its points."""
    figure.draw_without_rendering()
    artists = dict(zip(_artists(figure), moving, strict=True))
    panels = []
    for axes in figure.axes:
        panel = {"title": axes.get_title(), "equal": axes.get_aspect() == 1, "drawn": axes.axison, "artists": []}
        for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            low, high = limits = getattr(axes, f"get_{name}lim")()
            marks = axis.get_majorticklocs()
            ticks = [
                [float(at), f"{at:g}" if "$" in text else text]
                for at, text in zip(marks, axis.get_major_formatter().format_ticks(marks), strict=True)
                if min(low, high) <= at <= max(low, high)
            ]
            label, log = axis.get_label_text(), axis.get_scale() == "log"
            panel[name] = {"limits": [float(v) for v in limits], "log": log, "label": label, "ticks": ticks}
        for artist in (*axes.patches, *axes.lines, *axes.texts):
            points = None if artists[artist] else _short(places(artist, axes))
            panel["artists"].append(_drawn(artist) | {"points": points})
        panels.append(panel)
    return {"kind": "chart", "panels": panels, "columns": figure.axes[0].get_gridspec().ncols}


def _drawn(artist):
    """How an artist looks."""
    if hasattr(artist, "get_xydata"):
        label, every = artist.get_label(), artist.get_markevery()
        return {
            "label": "" if label.startswith("_") else label,
            "colour": to_hex(artist.get_color()),
            "width": artist.get_linewidth() if artist.get_linestyle() in DASHES else 0,
            "dash": DASHES.get(artist.get_linestyle(), []),
            "marker": str(artist.get_marker()).replace("None", ""),
            "open": artist.get_fillstyle() == "none",
            "last": every is not None,
        }
    if hasattr(artist, "get_position"):
        return {"colour": to_hex(artist.get_color()), "text": artist.get_text()}
    return {"fill": to_hex(artist.get_facecolor(), keep_alpha=True)}
