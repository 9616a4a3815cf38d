"""The set-ups of lessons 08 to 13 as drawings, from `setups.toml`: how things stand, what each sign depends on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from mathpost.teaching.course.drawings import BOX, captions, write
from mathpost.teaching.course.verdict import toml
from mathpost.teaching.draw import plot

HEAD = np.array([[0, 0], [-1, 0.35], [-1, -0.35]])  # of an arrow that points along x
HEADS = {"arrow": [(-1, -2)], "turn": [(-1, -2)], "size": [(-1, -2), (0, 1)]}  # of a kind: tips, and what is before


def draw(*names: str) -> None:
    """Draw set-ups side by side, by name, each with the machine's axes and from where one looks."""
    _, panels = plot.figure(1, len(names), size=(4.4 * len(names), 4.2))
    for axes, name in zip(np.atleast_1d(panels), names, strict=True):
        drawn = toml("setups")[name]
        cross = []
        for axis, way in drawn["axes"].items():
            ends = [drawn["at"], np.add(drawn["at"], way).tolist()]
            cross.append(["arrow", ends, "machine", axis, [0.3 * (len(axis) - 1) * (way[0] > 0), 0]])
        parts = [(kind, _outline(geometry), geometry, *rest) for kind, geometry, *rest in [*cross, *drawn["parts"]]]
        size = 0.05 * np.ptp(np.concatenate([points for _, points, *_ in parts]), axis=0).max()
        for part in parts:
            _part(axes, size, *part)
        axes.set_title("\n".join([drawn["title"], *captions(drawn)]), fontsize=10)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.15)
        axes.set_axis_off()
    plot.show()


def _outline(geometry: Any) -> np.ndarray:
    """Return the points of a part, shape (n, 2): of a box, of a circle or an arc, or as given."""
    if "box" in geometry:
        x, y, half_width, half_height = geometry["box"]
        return BOX * [half_width, half_height] + [x, y]
    if "circle" in geometry:
        centre, radius, *ends = geometry["circle"]
        start, end = ends or (0, 360)
        angle = np.radians(np.linspace(start, end, 73))
        return np.add(centre, radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    points = geometry["points"] if isinstance(geometry, dict) else geometry
    return np.array(points, dtype=float, ndmin=2)


def _part(
    axes: Axes,
    size: float,
    kind: str,
    points: np.ndarray,
    geometry: Any,
    role: str,
    text: str,
    shift: Sequence[float] = (0, 0),
) -> None:
    """Draw a part in the colour of its role, with its text at the place for its kind."""
    colour, place = plot.COLOUR[role], points[-1]
    if kind == "body":
        axes.fill(*points.T, facecolor=colour, edgecolor=colour, alpha=0.25)
        place = (points.min(axis=0) + points.max(axis=0)) / 2
    elif kind == "point":
        axes.plot(*points.T, "o", color=colour)
        place = place + 0.8 * size
    elif kind == "dial":
        place = _dial(axes, size, points, geometry["moves"] == "dial", colour)
    else:
        axes.plot(*points.T, "--" if kind == "dashed" else "-", color=colour, linewidth=1.2)
        for tip, before in HEADS.get(kind, ()):
            along = _head(axes, size, points[before], points[tip], colour)
        if kind == "arrow":
            place = place + 0.9 * size * along
        elif kind != "ring":
            place = points[len(points) // 2] if len(points) > 2 else points.mean(axis=0)
    if text:
        write(axes, place + size * np.array(shift), text, colour)


def _dial(axes: Axes, size: float, points: np.ndarray, moves: bool, colour: str) -> np.ndarray:
    """Draw a dial, its plunger, and the move that presses the plunger in, so that an ordinary dial reads more.

    `moves` says that the dial moves; otherwise what it touches does. Returns the place for a text.
    """
    body, contact = points
    inwards = (contact - body) / np.linalg.norm(contact - body)
    axes.plot(*np.transpose([body, contact]), color=colour, linewidth=2.5)
    axes.fill(*(body + 1.1 * size * _outline({"circle": [(0, 0), 1]})).T, facecolor="white", edgecolor=colour)
    aside = 1.6 * size * inwards[::-1] * (1, -1)
    start, end = (body, contact) if moves else (contact, body)
    start, end = start + aside, start + 0.75 * (end - start) + aside
    axes.plot(*np.transpose([start, end]), color=colour, linewidth=1.2)
    _head(axes, size, start, end, colour)
    write(axes, (start + end) / 2 + aside * (1.6, 0.6), "reads more", colour)
    return body


def _head(axes: Axes, size: float, before: np.ndarray, tip: np.ndarray, colour: str) -> np.ndarray:
    """Draw the head of an arrow, and return its direction."""
    x, y = along = (tip - before) / np.linalg.norm(tip - before)
    axes.fill(*(tip + 0.8 * size * HEAD @ [[x, y], [-y, x]]).T, color=colour)
    return along
