"""Pictures of kinematics: one colour per role everywhere, and curves along a tool path."""

import matplotlib.pyplot as plt

# Okabe and Ito's palette: distinct for the colour-blind and, by line style, in grey.
COLOUR = {
    "machine": "#7f7f7f",
    "workpiece": "#0072b2",
    "tool": "#d55e00",
    "first branch": "#009e73",
    "second branch": "#cc79a7",
    "published": "#000000",
    "forbidden": "#f0e442",
}
STYLE = {"first branch": "-", "second branch": "--", "published": ":"}


def figure(rows=1, columns=1, *, size=(7.0, 4.2), three_d=False):
    """Return ``(figure, axes)`` in the house style; close it with `show`."""
    drawn, axes = plt.subplots(
        rows, columns, figsize=size, layout="constrained", subplot_kw={"projection": "3d"} if three_d else None
    )
    return drawn, axes


def show():
    """Show the picture once, and leave no figure open behind a notebook cell."""
    plt.show()
    plt.close("all")


def frame(axes, matrix, origin, *, colour, length=1.0, labels="XYZ", **style):
    """Draw a frame's three axes: the columns of `matrix`, shape (3, 3), from `origin`, shape (3,)."""
    for column, label in zip(matrix.T, labels, strict=True):
        end = origin + length * column
        axes.plot(*zip(origin, end, strict=True), color=colour, **style)
        axes.text(*(origin + 1.15 * length * column), label, color=colour, ha="center", va="center")
