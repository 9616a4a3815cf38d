"""Texts of a picture that lie on each other, found while it is drawn.

Run in the kernel of a lesson this makes each picture a test, those too that are drawn before a guess and not shown.
It needs matplotlib alone.
"""

from itertools import combinations
from unittest.mock import patch

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

AIR = 1.0  # pixels at each edge of a text's box that no letter reaches


def overlapping(boxes):
    """Pairs of words whose boxes, pairs of words and corners [[left, bottom], [right, top]], overlap."""
    return [
        (one, other)
        for (one, a), (other, b) in combinations(boxes, 2)
        if (np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]) > 2 * AIR).all()
    ]


def watched(canvas, original=FigureCanvasAgg.draw, draw=Text.draw):
    """Draw as `FigureCanvasAgg.draw` does, and refuse a picture in which texts overlap."""
    boxes = []

    def remember(text, renderer, *args, **options):
        if text.get_visible() and (words := text.get_text().strip()):  # in space it has its place only here
            boxes.append((words, text.get_window_extent(renderer).get_points()))
        return draw(text, renderer, *args, **options)

    with patch.object(Text, "draw", remember):
        original(canvas)
    pairs = overlapping(boxes)
    assert not pairs, "texts overlap: " + "; ".join(f"{one!r} and {other!r}" for one, other in pairs)


def watch():
    """From here on every picture is watched."""
    FigureCanvasAgg.draw = watched
