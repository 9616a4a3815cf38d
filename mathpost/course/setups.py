"""The set-ups of lessons 08 to 13, from `setups.toml`: how things stand, what turns, which way a reading counts."""

import numpy as np

from mathpost.course.lesson_data import toml
from mathpost.draw import plot
from mathpost.draw.sketch import sketch

BOX, ROUND = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]), np.linspace(0, 2 * np.pi, 49)


def show(*names):
    """Draw set-ups beside each other, by their names in the file."""
    _, panels = plot.figure(1, len(names), size=(4.4 * len(names), 3.9))
    for axes, name in zip(np.atleast_1d(panels), names, strict=True):
        drawn = toml("setups")[name]
        parts = [(kind, _points(geometry), *rest) for kind, geometry, *rest in drawn["parts"]]
        sketch(axes, parts, title=drawn["title"])
    plot.show()


def _points(geometry):
    """A box or a circle as points; what is given by points already as it is."""
    if "box" in geometry:
        x, y, half_width, half_height = geometry["box"]
        return BOX * [half_width, half_height] + [x, y]
    if "circle" in geometry:
        centre, radius = geometry["circle"]
        return np.add(centre, radius * np.column_stack([np.cos(ROUND), np.sin(ROUND)]))
    return geometry
