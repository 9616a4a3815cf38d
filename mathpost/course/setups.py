"""The set-ups of lessons 08 to 13, from `setups.toml`: how things stand, what turns, which way a reading counts."""

import numpy as np

from mathpost.course.verdict import toml
from mathpost.draw import plot

BOX = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
HEAD = np.array([[0, 0], [-1, 0.35], [-1, -0.35]])  # of an arrow that points along x


def show(*names):
    """Draw set-ups beside each other, by their names in the file."""
    _, panels = plot.figure(1, len(names), size=(4.4 * len(names), 3.9))
    for axes, name in zip(np.atleast_1d(panels), names, strict=True):
        drawn = toml("setups")[name]
        parts = [(kind, _points(geometry), *rest) for kind, geometry, *rest in drawn["parts"]]
        size = 0.05 * np.ptp(np.concatenate([points for _, points, *_ in parts]), axis=0).max()
        for part in parts:
            _draw(axes, size, *part)
        axes.set_title(drawn["title"], fontsize=10)
        axes.set_aspect("equal")
        axes.margins(0.12)
        axes.set_axis_off()
    plot.show()


def _points(geometry):
    """The points of a part, shape (n, 2): a box, a circle or a part of one, or points as they are given."""
    if "box" in geometry:
        x, y, half_width, half_height = geometry["box"]
        return BOX * [half_width, half_height] + [x, y]
    if "circle" in geometry:
        centre, radius, *ends = geometry["circle"]
        angle = np.radians(np.linspace(*(ends or (0, 360)), 73))
        return np.add(centre, radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    return np.array(geometry, dtype=float, ndmin=2)


def _draw(axes, size, kind, points, role, text, shift=(0, 0)):
    """Draw a part, without scales, in the colour of its role, and its text where a part of its kind has it."""
    colour, place = plot.COLOUR[role], points[-1]
    if kind == "body":
        axes.fill(*points.T, facecolor=colour, edgecolor=colour, alpha=0.25)
        place = (points.min(axis=0) + points.max(axis=0)) / 2
    elif kind == "point":
        axes.plot(*points.T, "o", color=colour)
        place = place + 0.8 * size
    else:
        axes.plot(*points.T, "--" if kind == "dashed" else "-", color=colour, linewidth=1.2)
        for tip, before in {"arrow": [(-1, -2)], "turn": [(-1, -2)], "size": [(-1, -2), (0, 1)]}.get(kind, ()):
            x, y = along = (points[tip] - points[before]) / np.linalg.norm(points[tip] - points[before])
            axes.fill(*(points[tip] + 0.8 * size * HEAD @ [[x, y], [-y, x]]).T, color=colour)
        if kind == "arrow":
            place = place + 0.9 * size * along
        elif kind != "ring":
            place = points[len(points) // 2] if len(points) > 2 else points.mean(axis=0)
    if text:
        axes.text(*(place + size * np.array(shift)), text, color=colour, ha="center", va="center")
