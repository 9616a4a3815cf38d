"""Drawings of set-ups: parts in a plane, each described by one tuple, in the colours of their roles."""

import numpy as np

from mathpost.draw.plot import COLOUR

HEAD = np.array([[0, 0], [-1, 0.35], [-1, -0.35]])  # of an arrow that points along x


def sketch(axes, parts, *, title=""):
    """Draw parts without scales: what a set-up looks like, which way things count.

    A part is a tuple of kind, geometry, role (one of `COLOUR`), text, and for some a shift of the text, such as
    ``("arrow", [(0, 0), (0, 1)], "tool", "Z")``. Kinds are ``"body"``, a polygon; ``"line"`` and ``"dashed"``,
    points; ``"arrow"``, start and end; ``"size"``, an arrow with two heads; ``"ring"``, centre and radius;
    ``"turn"``, centre, radius and two angles in degrees, from the first to the second; ``"point"``, a place.
    """
    drawn = [(kind, np.array(_points(kind, geometry), dtype=float), *rest) for kind, geometry, *rest in parts]
    everything = np.concatenate([points for _, points, *_ in drawn])
    size = 0.05 * np.ptp(everything, axis=0).max()
    for kind, points, role, text, *shift in drawn:
        colour, place = COLOUR[role], points[-1]
        if kind == "body":
            axes.fill(*points.T, facecolor=colour, edgecolor=colour, alpha=0.25)
            place = (points.min(axis=0) + points.max(axis=0)) / 2
        elif kind == "point":
            axes.plot(*points.T, "o", color=colour)
            place = points[0] + size * np.array([0.8, 0.8])
        else:
            axes.plot(*points.T, "--" if kind == "dashed" else "-", color=colour, linewidth=1.2)
            if kind in ("arrow", "turn", "size"):
                along = points[-1] - points[-2]
                _head(axes, points[-1], along, size, colour)
                place = points[-1] + 0.9 * size * along / np.linalg.norm(along)
            if kind == "size":
                _head(axes, points[0], points[0] - points[1], size, colour)
            if kind in ("size", "turn", "line", "dashed"):
                place = points[len(points) // 2] if len(points) > 2 else points.mean(axis=0)
        if text:
            place = place + size * np.ravel(shift or (0, 0))
            axes.text(*place, text, color=colour, ha="center", va="center")
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.margins(0.12)
    axes.set_axis_off()


def _points(kind, geometry):
    if kind == "ring":
        centre, radius, start, end = *geometry, 0, 360
    elif kind == "turn":
        centre, radius, start, end = geometry
    else:
        return [geometry] if kind == "point" else geometry
    angle = np.radians(np.linspace(start, end, 73))
    return np.add(centre, radius * np.column_stack([np.cos(angle), np.sin(angle)]))


def _head(axes, tip, along, size, colour):
    x, y = along / np.linalg.norm(along)
    axes.fill(*(tip + 0.8 * size * HEAD @ [[x, y], [-y, x]]).T, color=colour)
