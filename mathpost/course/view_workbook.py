"""The view with sliders for lesson 14: which misreadings of the angles a number can show."""

import numpy as np

from mathpost.detective.misreadings import common_matrices
from mathpost.draw import plot
from mathpost.draw.widget import View


def misreadings_apart(point, names):
    """How far common misreadings carry a point from the right place, as sliders move the three Euler angles.

    `point` has shape (3,); `names` are those of `mathpost.detective.misreadings.COMMON`. A bar that vanishes is a
    misreading that these angles cannot show.
    """
    point = np.array(point, dtype=float)

    def build(figure):
        panel = figure.subplots()
        bars = panel.barh(names, np.zeros(len(names)), color=plot.COLOUR["tool"])
        panel.set(xlim=(0, 2 * np.linalg.norm(point)), xlabel="distance from the right point")
        panel.invert_yaxis()

        def update(alpha, beta, gamma):
            right, *wrong = common_matrices(("right", *names), np.array([alpha, beta, gamma])) @ point
            apart = [np.linalg.norm(each - right) for each in wrong]
            for bar, distance in zip(bars, apart, strict=True):
                bar.set_width(distance)
            hidden = [name for name, distance in zip(names, apart, strict=True) if distance < 1e-3]
            return f"invisible at these angles: {', '.join(hidden)}" if hidden else "every misreading shows"

        return update

    start = {"alpha": 135.0, "beta": 55.0, "gamma": -90.0}
    return View(build, {name: (-180.0, 180.0, angle, 1.0) for name, angle in start.items()})
