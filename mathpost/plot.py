"""Pictures of kinematics: one colour per role everywhere, and curves along a tool path."""

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp
from IPython.display import Math

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


def tool_axes(axes, cl, *, length=1.0, colour=COLOUR["tool"], lift=0.0):
    """Draw the tip and the tool axis of every record in 3-D; `lift` moves each record up, to tell them apart."""
    for record, (point, axis) in enumerate(zip(cl.points, cl.axes, strict=True)):
        start = point + np.array([0, 0, lift * record])
        axes.plot(*zip(start, start + length * axis, strict=True), color=colour, linewidth=2)
        axes.plot(*start[:, None], "o", color=COLOUR["workpiece"], markersize=4)


def along(axes, place, values, role, label=None, *, points=False):
    """Draw one quantity along a path in the colour and style of its `role`, one of `COLOUR`."""
    style = {"color": COLOUR[role], "linestyle": STYLE.get(role, "-")}
    axes.plot(place, values, label=label or role, marker="o" if points else None, markersize=4, **style)


def travel(axes, low, high):
    """Shade what is outside the travel of an axis, within the limits that the axes show at present."""
    bottom, top = axes.get_ylim()
    for start, end in ((bottom, max(low, bottom)), (min(high, top), top)):
        if end > start:
            axes.axhspan(start, end, color=COLOUR["forbidden"], alpha=0.4, zorder=0)
    axes.set_ylim(bottom, top)


def pole_map(axes, kin, tool_axes, *, cone=None, role="tool", label=None):
    """Draw tool axes (n, 3) as seen along the outer axis: distance from the middle is the angle from the pole.

    The pole is the middle; the singular cone of half angle `cone` (radians) is shaded.
    """
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    side = np.eye(3)[np.abs(pole).argmin()]
    y = np.cross(pole, side) / np.linalg.norm(np.cross(pole, side))
    x = np.cross(y, pole)
    angle = np.degrees(np.arctan2(np.hypot(tool_axes @ x, tool_axes @ y), tool_axes @ pole))
    direction = np.arctan2(tool_axes @ y, tool_axes @ x)
    line = axes.plot(angle * np.cos(direction), angle * np.sin(direction), "o-", color=COLOUR[role], label=label)
    if cone is not None:
        axes.add_patch(plt.Circle((0, 0), np.degrees(cone), color=COLOUR["forbidden"], alpha=0.6, zorder=0))
    axes.plot(0, 0, "+", color=COLOUR["machine"], markersize=12)
    axes.set(xlabel="degrees from the pole", aspect="equal")
    return line[0]


def tip_path(axes, kin, joints, *, role, label=None, samples=40):
    """Draw, seen from above, where the tip really goes when all joints move linearly from row to row."""
    t = np.linspace(0, 1, samples)[:, None, None]
    tip = kin.forward(joints[:-1] + t * np.diff(joints, axis=0))[0]
    tip = np.swapaxes(tip, 0, 1).reshape(-1, 3)
    axes.plot(tip[:, 0], tip[:, 1], color=COLOUR[role], linestyle=STYLE.get(role, "-"), label=label or role)
    axes.set(xlabel="x in the workpiece, mm", ylabel="y, mm", aspect="equal")


# Frames, machines and tilted planes


def formulas(*pairs, decimals=6):
    """Return named matrices side by side as one formula: pairs of a LaTeX name and a matrix, exact or numbers."""
    exact = [
        (name, sp.Matrix(np.round(m, decimals) + 0.0) if isinstance(m, np.ndarray) else m) for name, m in pairs
    ]
    return Math(r" \qquad ".join(f"{name} = {sp.latex(matrix)}" for name, matrix in exact))


def space(axes, radius, *, centre=(0.0, 0.0, 0.0), elevation=22.0, azimuth=-55.0):
    """Prepare three-dimensional `axes` for a cube of half-width `radius`: equal scales, no panes."""
    axes.set(**{f"{name}lim": (c - radius, c + radius) for name, c in zip("xyz", centre, strict=True)})
    axes.set_box_aspect((1, 1, 1), zoom=1.25)
    axes.view_init(elevation, azimuth)
    axes.set_axis_off()


class Wire:
    """A line through points of a child frame, shape (n, 3), that moves with the frame; NaN rows break it."""

    def __init__(self, axes, points, **style):
        self.points = np.asarray(points, dtype=float)
        (self.line,) = axes.plot(*self.points.T, **style)

    def move(self, frame):
        """Redraw at a `mathpost.frame.Frame`; return the points in its parent."""
        moved = self.points @ frame.rotation.T + frame.origin
        self.line.set_data_3d(*moved.T)
        return moved


class Triad:
    """A frame's three axes with their labels, as artists that move."""

    def __init__(self, axes, *, colour, length=1.0, labels="XYZ", **style):
        self.wires = [Wire(axes, [np.zeros(3), length * e], color=colour, **style) for e in np.eye(3)]
        self.texts = [axes.text(0, 0, 0, label, color=colour, ha="center", va="center") for label in labels]

    def move(self, frame):
        """Redraw at a `mathpost.frame.Frame`."""
        for wire, text in zip(self.wires, self.texts, strict=True):
            start, end = wire.move(frame)
            text.set_position_3d(start + 1.15 * (end - start))


def box(width, depth, height):
    """The edges of a box on the XY plane, centred, as points for a `Wire`."""
    x, y = width / 2, depth / 2
    floor = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0], [-x, -y, 0]])
    roof = np.add(floor, [0, 0, height])
    posts = [[floor[n], roof[n], np.full(3, np.nan)] for n in range(4)]
    return np.concatenate([floor, [np.full(3, np.nan)], roof, [np.full(3, np.nan)], *posts])


def cutter(radius, length, shank=0.45):
    """The outline of a tool with its tip at the origin and its axis along Z, as points for a `Wire`."""
    turn = np.linspace(0, 2 * np.pi, 25)
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(25)], axis=-1)
    gap = [np.full(3, np.nan)]
    levels = [(radius, 0), (radius, length * shank), (2 * radius, length * shank), (2 * radius, length)]
    rings = [np.concatenate([r * ring + [0, 0, h], gap]) for r, h in levels]
    sides = [
        np.array([[r * c, r * s, a], [r * c, r * s, b], [np.nan] * 3])
        for r, a, b in [(radius, 0, length * shank), (2 * radius, length * shank, length)]
        for c, s in [(1, 0), (0, 1), (-1, 0), (0, -1)]
    ]
    return np.concatenate([*rings, *sides])
