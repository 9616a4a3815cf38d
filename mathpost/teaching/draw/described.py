"""A picture in numbers: a text that describes every artist of a figure.

The text is saved with the picture in a lesson, so a wrong curve fails the comparison of outputs as a wrong number
does. Screen readers read it, too.
"""

from __future__ import annotations

from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import to_hex, to_rgba_array
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.quiver import Quiver
from matplotlib.text import Text

from mathpost.teaching.draw.described_scene import numbers

Shown = Line2D | Patch | Collection | AxesImage | Text


def describe(figure: Figure) -> str:
    """Return a description of a figure: a line for each axes, with its labels, and one for each artist in it.

    That line has the artist's label, colour, number of points, the range of each coordinate and a few of its
    points, in the units of the axes. Consecutive artists without labels, of one type, colour and number of points,
    share it.
    """
    lines = []
    for axes in figure.axes:
        texts = {"": axes.get_title(), "x": axes.get_xlabel(), "y": axes.get_ylabel()}
        texts |= {"z": axes.get_zlabel()} if hasattr(axes, "get_zlabel") else {}
        labels = ", ".join(f'{name} "{text}"'.strip() for name, text in texts.items() if text)
        lines.append("picture" + f" with {labels}" * bool(labels))
        artists: list[Shown] = [*axes.lines, *axes.collections, *axes.patches, *axes.images, *axes.texts]
        told = [_told(artist, axes) for artist in artists]
        for (kind, label, colour, count), group in groupby(filter(None, told), key=lambda told: told[:4]):
            points = [points for *_, points in group]
            if label:
                lines += [f'  {kind} "{label}"{colour}: {numbers(points, count)}' for points in points]
            else:
                together = np.concatenate(points)
                lines.append(f"  {len(points)} × {kind}{colour}: {numbers(together, count)}")
    return "\n".join(lines)


def _told(artist: Shown, axes: Axes) -> tuple[str, str, str, int, np.ndarray] | None:
    """Type, label, colour, number of points and the points (n, 2 or 3); None if the artist shows nothing."""
    label = artist.get_text() if isinstance(artist, Text) else str(artist.get_label() or "")
    points = places(artist, axes)
    if not len(points) or not artist.get_visible():
        return None
    return type(artist).__name__, "" if label.startswith("_") else label, _colour(artist), len(points), points


def _colour(artist: Shown) -> str:
    """A space and the (first) colour of an artist; "" if it has none, such as an image."""
    for name in ("get_color", "get_facecolor", "get_edgecolor"):
        found = to_rgba_array(getattr(artist, name, list)())
        if len(found) and found[0, 3]:
            return f" {to_hex(found[0])}"
    return ""


def places(artist: Shown, axes: Axes) -> np.ndarray:
    """Return the points (n, 2 or 3) of an artist in the units of its axes; for an image, pixels and values."""
    if isinstance(artist, Text):
        place = getattr(artist, "get_position_3d", artist.get_position)()
        return np.atleast_2d(np.asarray(place, dtype=float))
    if hasattr(artist, "get_data_3d"):
        return np.column_stack(artist.get_data_3d())
    if isinstance(artist, Line2D):
        return np.array(artist.get_xydata(), dtype=float)
    if isinstance(artist, AxesImage):
        left, right, bottom, top = artist.get_extent()
        values: np.ndarray = np.ma.filled(np.ma.asarray(artist.get_array()), np.nan)
        values = values.reshape(*values.shape[:2], -1).mean(axis=2)
        x, y = np.meshgrid(np.linspace(left, right, values.shape[1]), np.linspace(bottom, top, values.shape[0]))
        return np.column_stack([x.ravel(), y.ravel(), values.ravel()])
    if isinstance(artist, Patch):
        return axes.transData.inverted().transform(artist.get_transform().transform(artist.get_path().vertices))
    if (lines := getattr(artist, "_segments3d", None)) is not None:
        return np.concatenate([np.asarray(part) for part in lines])
    if (dots := getattr(artist, "_offsets3d", None)) is not None:
        return np.column_stack([np.ma.filled(part, np.nan) for part in dots])
    offsets = np.ma.filled(artist.get_offsets(), np.nan)
    if len(offsets) > 1 or np.any(offsets):
        return np.column_stack([offsets, *([artist.U, artist.V] if isinstance(artist, Quiver) else [])])
    return np.concatenate([np.empty((0, 2)), *(path.vertices for path in artist.get_paths())])
