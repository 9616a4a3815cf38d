"""Views that move by sympy expressions: these place bodies, draw lines and give the numbers in the text.

`formula` moves a scene. Curves are a matplotlib figure whose artists (lines, patches, texts) go to the page as
points and colours; `printed` moves them by expressions, `recorded` replays them over one slider.
"""

import re

import numpy as np
import sympy as sp
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from mathpost import codegen
from mathpost.draw.described import places as shown_at
from mathpost.draw.live import Live
from mathpost.draw.plot import COLOUR
from mathpost.rotation import numeric

DASHES = {"-": [], "--": [6, 4], ":": [1, 3], "-.": [7, 3, 1, 3]}
GAP = re.compile(r"\{(?::(\d+)|\?([^}]*))\}")


def slider(name, low, high, value, *, step=1.0, unit="°", **more):
    """Return a slider: an angle in degrees unless `unit` says otherwise; with `hidden=True` only buttons move it.

    Printed functions take its value times its factor: angles in radians, other units as they are.
    """
    made = {"name": name, "low": low, "high": high, "value": value, "step": step, "unit": unit}
    return made | {"factor": np.pi / 180 if unit == "°" else 1.0} | more


def compiled(symbols, sliders, text, ways, **functions):
    """Print what sliders move as JavaScript, and evaluate it at their start.

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

    def filled(gap):
        digits, words = gap.groups()
        return f"{next(numbers):z.{digits}f}" if digits else words * bool(next(numbers))

    lines = [line for line, *_ in text]
    said = "; ".join(GAP.sub(filled, line) for line in lines)
    return {"sliders": list(sliders), "text": lines}, [code], said, ends, values


def formula(scenes, symbols, sliders, places, text, *, buttons=(), play=None, **options):
    """Return a view of one or more `Scene`s that move by printed expressions.

    Each slider, from `slider`, sets one of the `symbols`, angles in radians. `places` maps the name of a body to a
    matrix in the symbols, a 3×3 rotation or a 4×4 transform. A line with `points`, 3×1 matrices in its body's
    coordinates, is redrawn through them. `text` are tuples of a line under the pictures and its numbers: ``{:4}``
    is the next number with four decimals, ``{?words}`` shows the words if the next is not 0. `buttons` are pairs of
    a label and the values to set, None to leave a slider alone; `play` is the number of the slider that plays;
    `options` are those of `Live`.

    Examples
    --------
    >>> from mathpost.draw.scene import Scene
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


def subplots(rows=1, columns=1, *, size=(7.0, 4.2), **shared):
    """Return a figure, `size` in inches, that pyplot does not know, and its axes, as `Figure.subplots` does."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, **shared)


def recorded(figure, update, control, *, height=460):
    """Record what one slider does to a figure, for the page to replay.

    `figure` is from `subplots`. ``update(value)`` moves its artists and returns a list of lines of text; it is
    called at every step of `control`, from `slider`. `height` is in pixels.
    """
    steps = round((control["high"] - control["low"]) / control["step"])
    values = control["low"] + np.arange(steps + 1) * control["step"]
    said, frames = [], []
    for value in values:
        said.append(update(float(value)))
        frames.append([shown_at(artist, artist.axes) for artist in _artists(figure)])
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


class Moving(dict):
    """The lines that `printed` moves: a dict of each to its points, pairs (x, y) of expressions."""

    def line(self, axes, role, points, style="-", **how):
        """Add a line in the colour of a role."""
        (line,) = axes.plot([], [], style, color=COLOUR[role], **how)
        self[line] = points


def printed(figure, points, symbols, sliders, text, *, height=460):
    """Move a figure's artists by printed expressions.

    `figure` is from `subplots`; `points` a dict of artist to pairs (x, y) of sympy expressions, such as a `Moving`.
    `symbols`, `sliders` and `text` are those of `formula`, `height` that of `recorded`.
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
    """Points as a flat list of numbers of five digits; NaN is None."""
    return [float(f"{x:.5g}") if np.isfinite(x) else None for x in np.ravel(points)]


def _spec(figure, moving):
    """The panels of a figure: scales, ticks, artists; the points of a moving artist are None."""
    figure.draw_without_rendering()
    artists = dict(zip(_artists(figure), moving, strict=True))
    panels = []
    for axes in figure.axes:
        panel = {"title": axes.get_title(), "equal": axes.get_aspect() == 1, "drawn": axes.axison, "artists": []}
        for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            limits = list(map(float, getattr(axes, f"get_{name}lim")()))
            marks = axis.get_majorticklocs()
            written = zip(marks, axis.get_major_formatter().format_ticks(marks), strict=True)
            within = [(float(at), text) for at, text in written if min(limits) <= at <= max(limits)]
            ticks = [[at, f"{at:g}" if "$" in text else text] for at, text in within]
            label, log = axis.get_label_text(), axis.get_scale() == "log"
            panel[name] = {"limits": limits, "log": log, "label": label, "ticks": ticks}
        for artist in (*axes.patches, *axes.lines, *axes.texts):
            points = None if artists[artist] else _short(shown_at(artist, axes))
            panel["artists"].append(_drawn(artist) | {"points": points})
        panels.append(panel)
    return {"kind": "chart", "panels": panels, "columns": figure.axes[0].get_gridspec().ncols}


def _drawn(artist):
    """How an artist looks."""
    if isinstance(artist, Text):
        return {"colour": to_hex(artist.get_color()), "text": artist.get_text()}
    if not hasattr(artist, "get_xydata"):
        return {"fill": to_hex(artist.get_facecolor(), keep_alpha=True)}
    label, style = artist.get_label(), artist.get_linestyle()
    looks = {"label": "" if label.startswith("_") else label, "colour": to_hex(artist.get_color())}
    looks |= {"width": artist.get_linewidth() if style in DASHES else 0, "dash": DASHES.get(style, [])}
    looks |= {"marker": str(artist.get_marker()).replace("None", ""), "open": artist.get_fillstyle() == "none"}
    return looks | {"last": artist.get_markevery() is not None}
