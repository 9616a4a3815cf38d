"""A picture in numbers: what every artist of a figure shows, as text.

The text stands beside the picture in a lesson's saved outputs, so that a wrong curve fails a comparison of outputs
as a wrong printed number does; it is also what a screen reader reads.
"""

from itertools import groupby

import numpy as np
from matplotlib.text import Text

PLACES = 5  # an artist is told at so many places, from its first point to its last
DIGITS = 10


def describe(figure):
    """Return what a figure shows: a line for every axes, with its labels, and one for every artist in it.

    An artist is told by its label, how many points it has, the range of each coordinate, and its points at a few
    places, in the units of the axes. Artists in a row that have no label, one type and the same number of points
    are told together.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> figure = Figure()
    >>> axes = figure.subplots()
    >>> _ = axes.plot([0, 1, 2], [0, 1, 4], label="square")
    >>> _ = axes.set_xlabel("side")
    >>> print(describe(figure))
    picture with x "side"
      Line2D "square": 3 points, x 0 … 2, y 0 … 4, at (0, 0) (1, 1) (2, 4)
    """
    lines = []
    for axes in figure.axes:
        lines.append(f"picture{_labels(axes)}")
        told = [_told(artist, axes) for artist in _artists(axes)]
        for (kind, label, count), group in groupby(filter(None, told), key=lambda told: told[:3]):
            points = [points for *_, points in group]
            if label:
                lines += [f'  {kind} "{label}": {_numbers(points, count)}' for points in points]
            else:
                together = np.concatenate(points)
                lines.append(f"  {len(points)} × {kind}: {_numbers(together, count)}")
    return "\n".join(lines)


def _labels(axes):
    texts = {"": axes.get_title(), "x": axes.get_xlabel(), "y": axes.get_ylabel()}
    if hasattr(axes, "get_zlabel"):
        texts["z"] = axes.get_zlabel()
    said = [f'{name} "{text}"'.strip() for name, text in texts.items() if text]
    return f" with {', '.join(said)}" if said else ""


def _artists(axes):
    return [*axes.lines, *axes.collections, *axes.patches, *axes.images, *axes.texts]


def _told(artist, axes):
    """Type, label, number of points and the points (n, 2 or 3) of an artist; None of one that shows nothing."""
    label = str(artist.get_label() or "")
    if isinstance(artist, Text):
        place = artist.get_position_3d() if hasattr(artist, "get_position_3d") else artist.get_position()
        label, points = artist.get_text(), np.atleast_2d(np.asarray(place, dtype=float))
    elif hasattr(artist, "get_data_3d"):
        points = np.column_stack(artist.get_data_3d())
    elif hasattr(artist, "get_xydata"):
        points = np.asarray(artist.get_xydata(), dtype=float)
    elif hasattr(artist, "get_extent"):  # an image: its corners, and its values as a third coordinate
        values, (left, right, bottom, top) = np.ma.filled(artist.get_array(), np.nan), artist.get_extent()
        values = values.reshape(*values.shape[:2], -1).mean(axis=2)
        x, y = np.meshgrid(np.linspace(left, right, values.shape[1]), np.linspace(bottom, top, values.shape[0]))
        points = np.column_stack([x.ravel(), y.ravel(), values.ravel()])
    else:
        points = _outline(artist, axes)
    if not len(points) or not artist.get_visible():
        return None
    return type(artist).__name__, "" if label.startswith("_") else label, len(points), points


def _outline(artist, axes):
    """The points of a patch, or of a collection: its outlines, and where they are set down."""
    to_data = axes.transData.inverted()
    if hasattr(artist, "get_paths"):
        if getattr(artist, "_segments3d", None) is not None:
            return np.concatenate([np.asarray(part) for part in artist._segments3d])
        if getattr(artist, "_offsets3d", None) is not None:
            return np.column_stack([np.ma.filled(part, np.nan) for part in artist._offsets3d])
        offsets = np.ma.filled(artist.get_offsets(), np.nan)
        if len(offsets) > 1 or np.any(offsets):
            arrows = [artist.U, artist.V] if hasattr(artist, "U") else []
            return np.column_stack([offsets, *arrows])
        outlines = [path.vertices for path in artist.get_paths()]
        return np.concatenate(outlines) if outlines else np.empty((0, 2))
    vertices = artist.get_path().vertices
    return to_data.transform(artist.get_transform().transform(vertices))


def _numbers(points, count):
    at = points[np.unique(np.linspace(0, len(points) - 1, PLACES).round().astype(int))]
    scale = np.nanmax(np.abs(points), axis=0, initial=0, where=np.isfinite(points))
    ranges = [
        f"{name} {_number(low, top)} … {_number(high, top)}"
        for name, low, high, top in zip("xyz", _least(points), -_least(-points), scale, strict=False)
    ]
    places = " ".join(f"({', '.join(_number(v, top) for v, top in zip(row, scale, strict=True))})" for row in at)
    if count == 1 and len(points) == 1:
        return f"at {places}"
    return f"{count} points, {', '.join(ranges)}, at {places}"


def _least(points):
    return np.min(points, axis=0, initial=np.inf, where=np.isfinite(points))


def _number(value, scale):
    """A number to so many digits; what is noise beside `scale` is 0, so that it is the same on every machine."""
    return "0" if abs(value) <= 1e-12 * scale else f"{value:.{DIGITS}g}"
