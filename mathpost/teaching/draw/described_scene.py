"""A scene in numbers, and how numbers are told: `described` does the same for a figure."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import numpy as np

from mathpost.teaching.draw.solid import put

if TYPE_CHECKING:
    from mathpost.teaching.draw.scene import Scene

PLACES = 5  # points quoted, from the first to the last
DIGITS = 10


def describe_scene(scene: Scene) -> str:
    """Return a description of a `Scene`: solids by their bounding boxes, lines by points."""

    def placed(body: str, points: np.ndarray) -> np.ndarray:
        points = put(scene.places[body], points)
        return np.where(np.abs(points) < 1e-12 * scene.radius, 0, points)

    title = f' "{scene.title}"' if scene.title else ""
    lines = [f"picture{title}, seen from {scene.azimuth:g}°, {scene.elevation:g}°"]
    for (body, colour), group in groupby(scene.solids, key=lambda solid: (solid.body, solid.colour)):
        corners = placed(body, np.concatenate([solid.triangles().reshape(-1, 3) for solid in group]))
        lines.append(f"  solid on {body} {colour}: {_ranges(corners)}")
    for line in scene.lines:
        points = placed(line.body, np.concatenate([np.reshape(part, (-1, 3)) for part in line.parts or [[]]]))
        if len(points):
            lines.append(f"  line on {line.body} {line.colour}: {numbers(points, len(points))}")
    for label in scene.labels:
        at = placed(label.body, np.reshape(label.at, (1, 3)))
        lines.append(f'  "{label.text}" on {label.body} {label.colour}: {numbers(at, 1)}')
    return "\n".join(lines)


def describe_values(name: str, values: Sequence[Sequence[float | None]]) -> str:
    """Return a line on lists of numbers, some of them None, in the form of an artist's points."""
    points = np.concatenate([np.array(each, dtype=float) for each in values])[:, None]
    return f"  {name}: {numbers(points, len(points))}"


def numbers(points: np.ndarray, count: int) -> str:
    """Return the range of each coordinate of points (n, 2 or 3) as text, and a few of them."""
    at, scale = points[np.unique(np.linspace(0, len(points) - 1, PLACES).round().astype(int))], _scale(points)
    places = " ".join(f"({', '.join(_number(v, top) for v, top in zip(row, scale, strict=True))})" for row in at)
    if count == 1 and len(points) == 1:
        return f"at {places}"
    return f"{count} points, {_ranges(points)}, at {places}"


def _ranges(points: np.ndarray) -> str:
    low = np.min(points, axis=0, initial=np.inf, where=np.isfinite(points))
    high = np.max(points, axis=0, initial=-np.inf, where=np.isfinite(points))
    told = zip("xyz", low, high, _scale(points), strict=False)
    return ", ".join(f"{name} {_number(a, top)} … {_number(b, top)}" for name, a, b, top in told)


def _scale(points: np.ndarray) -> np.ndarray:
    return np.max(np.abs(points), axis=0, initial=0, where=np.isfinite(points))


def _number(value: float, scale: float) -> str:
    """A number as text; noise relative to `scale` is 0, so that every computer writes the same."""
    return "0" if abs(value) <= 1e-12 * scale else f"{value:.{DIGITS}g}"
