"""Still drawings: turns, frames and coins of lessons 00 and 01, set-ups of lessons 08 to 13."""

import numpy as np
from matplotlib.patches import Circle
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from mathpost import euler
from mathpost.course.verdict import toml
from mathpost.draw import plot

MACHINE, WORKPIECE, POINT = (plot.COLOUR[role] for role in ("machine", "workpiece", "tool"))
AXIS = plot.COLOUR["first branch"]  # of a turn
BOX = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
HEAD = np.array([[0, 0], [-1, 0.35], [-1, -0.35]])  # of an arrow that points along x


def turn_in_plane(axes, degrees):
    """Draw the unit vectors of X and Y before and after a turn, with the coordinates of their ends."""
    _plane(axes)
    named = (("X turned", "left", "cos t", "sin t"), ("Y turned", "right", "−sin t", "cos t"))
    for (x, y), (name, side, along, up) in zip(_turn(degrees).T, named, strict=True):
        axes.plot([0, x], [0, 0], color=POINT, linewidth=4, alpha=0.5)
        axes.plot([x, x], [0, y], color=POINT, linestyle=":")
        axes.text(x / 2, -0.1, along, color=POINT, ha="center")
        axes.text(x + 0.04 * np.sign(x), y / 2, up, color=POINT, ha="left" if x > 0 else "right")
        _arrow(axes, (0, 0), (x, y), WORKPIECE)
        axes.text(1.12 * x, 1.12 * y, name, color=WORKPIECE, ha=side)
    _arc(axes, 0, degrees, 0.3)


def active_and_passive(left, right, point, degrees):
    """Draw the same turn twice: of a point in a fixed frame, and of the frame under a fixed point."""
    turn, point = _turn(degrees), np.array(point)
    for axes, title in ((left, "active: the point turns"), (right, "passive: the frame turns")):
        _plane(axes, title, start=-0.6)
    here = np.degrees(np.arctan2(*point[::-1]))
    _arc(left, here, here + degrees, np.hypot(*point))
    _point(left, point, "P", np.eye(2), MACHINE, "none")
    _point(left, turn @ point, "P'", np.eye(2), POINT)
    for row, name in zip(turn.T, ("X'", "Y'"), strict=True):
        _arrow(right, (0, 0), 1.15 * row, WORKPIECE)
        right.text(*(1.28 * row), name, color=WORKPIECE, ha="center", va="center")
    _arc(right, 0, degrees, 0.3)
    _point(right, point, "P", turn.T, POINT)


def quarter_turns(panels):
    """Draw the three quarter turns of the right hand: X to Y about Z, Y to Z about X, Z to X about Y."""
    for axes, about in zip(panels, (2, 0, 1), strict=True):
        plot.space(axes, 0.75, centre=(0.3, 0.3, 0.3))
        plot.frame(axes, np.eye(3), np.zeros(3), colour=MACHINE)
        start, end = np.eye(3)[(about + 1) % 3], np.eye(3)[(about + 2) % 3]
        turn = np.linspace(0, np.pi / 2, 31)[:, None]
        arc = 0.8 * (np.cos(turn) * start + np.sin(turn) * end)
        axes.plot(*arc.T, color=WORKPIECE, linewidth=2.5)
        axes.quiver(*arc[-4], *(arc[-1] - arc[-4]), color=WORKPIECE, arrow_length_ratio=1.0, linewidth=2.5)
        axes.plot(*np.array([[0, 0, 0], np.eye(3)[about]]).T, color=AXIS, linewidth=3)
        axes.set_title(f"about {'XYZ'[about]}: {'XYZ'[(about + 1) % 3]} goes to {'XYZ'[(about + 2) % 3]}")


def parts(axes, point, axis, degrees):
    """Draw a point turning about an axis: its part along the axis stays, the part across it turns in a circle."""
    point, axis = np.array(point, dtype=float), np.array(axis) / np.linalg.norm(axis)
    along, side = point @ axis * axis, np.cross(axis, point)
    across, moved = point - along, euler.from_axis_angle(axis, degrees, degrees=True) @ point
    turn = np.linspace(0, 2 * np.pi, 91)[:, None]
    plot.space(axes, 0.8, centre=along)
    axes.plot(*(along + np.cos(turn) * across + np.sin(turn) * side).T, color=MACHINE, linewidth=1)
    for start, end, colour, style, name in (
        (-0.1 * axis, 1.5 * axis, AXIS, "--", "v"),
        (0 * axis, along, POINT, "-", "along"),
        (along, point, POINT, "-", "across"),
        (along, along + side, MACHINE, "-", "v × p"),
        (0 * axis, point, WORKPIECE, ":", "p"),
        (along, moved, WORKPIECE, "-", "turned"),
    ):
        axes.plot(*np.array([start, end]).T, color=colour, linestyle=style, linewidth=2)
        beyond = end + 0.15 * (end - start) / np.linalg.norm(end - start)
        axes.text(*((start + end) / 2 if name in ("along", "across") else beyond), name, color=colour, ha="center")


def coins(panels, turns, title):
    """Draw a coin at the start and after each quarter turn of a sequence such as ``"ZX"``.

    Upper case is a turn about the coin's own axis, lower case about the table's. The arrow is x, the pin z.
    """
    rim = np.linspace(0, 2 * np.pi, 49)
    disc = np.stack([np.cos(rim), np.sin(rim), 0 * rim], axis=-1)
    frame = np.eye(3)
    for axes, letter in zip(panels, ["", *turns], strict=True):
        if letter:
            quarter = euler.from_axis_angle(np.eye(3)["xyz".index(letter.lower())], 90, degrees=True)
            frame = frame @ quarter if letter.isupper() else quarter @ frame
        plot.space(axes, 1.2)
        plot.frame(axes, 1.15 * np.eye(3), np.zeros(3), colour=MACHINE, linewidth=1)
        coin = Poly3DCollection([disc @ frame.T], facecolor=WORKPIECE, edgecolor=WORKPIECE, alpha=0.3)
        axes.add_collection3d(coin)
        axes.quiver(0, 0, 0, *(0.95 * frame[:, 0]), color=WORKPIECE, arrow_length_ratio=0.3, linewidth=3)
        axes.plot(*np.array([0 * frame[:, 2], 0.45 * frame[:, 2]]).T, color=POINT, linewidth=4)
        whose = "its own" if letter.isupper() else "the table’s"
        axes.set_title(f"{title}\nabout {whose} {letter.upper()}" if letter else title)


def set_ups(*names):
    """Draw set-ups from `setups.toml` beside each other, by name."""
    _, panels = plot.figure(1, len(names), size=(4.4 * len(names), 3.9))
    for axes, name in zip(np.atleast_1d(panels), names, strict=True):
        drawn = toml("setups")[name]
        parts = [(kind, _outline(geometry), *rest) for kind, geometry, *rest in drawn["parts"]]
        size = 0.05 * np.ptp(np.concatenate([points for _, points, *_ in parts]), axis=0).max()
        for part in parts:
            _part(axes, size, *part)
        axes.set_title(drawn["title"], fontsize=10)
        axes.set_aspect("equal")
        axes.margins(0.12)
        axes.set_axis_off()
    plot.show()


def _turn(degrees):
    return euler.from_axis_angle([0, 0, 1], degrees, degrees=True)[:2, :2]


def _plane(axes, title="", start=-1.2):
    """A frame X, Y with its unit circle."""
    axes.set(aspect="equal", xlim=(start, 1.4), ylim=(-0.3, 1.4), title=title)
    axes.set_axis_off()
    axes.add_patch(Circle((0, 0), 1.0, fill=False, color=MACHINE, linewidth=0.6))
    for end, name in (((1.25, 0), "X"), ((0, 1.25), "Y")):
        _arrow(axes, (0, 0), end, MACHINE)
        axes.text(*(1.06 * np.array(end)), name, color=MACHINE, ha="center", va="center")


def _arrow(axes, start, end, colour):
    style = {"arrowstyle": "-|>", "color": colour, "lw": 2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", end, start, arrowprops=style)


def _arc(axes, start, end, radius):
    turn = np.radians([*np.linspace(start, end, 41), end - 2])
    *arc, before = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.plot(*np.transpose(arc), color=AXIS)
    _arrow(axes, before, arc[-1], AXIS)


def _point(axes, point, name, directions, colour, style="full"):
    """A point, and its coordinates as dotted lines to the axes."""
    axes.plot(*point, "o", color=POINT, fillstyle=style)
    axes.text(*(point + np.array([0.07, 0.05])), name, color=POINT)
    for direction in directions:
        axes.plot(*np.array([point, point @ direction * direction]).T, color=colour, linestyle=":")


def _outline(geometry):
    """The points of a part, shape (n, 2): of a box, of a circle or an arc, or as given."""
    if "box" in geometry:
        x, y, half_width, half_height = geometry["box"]
        return BOX * [half_width, half_height] + [x, y]
    if "circle" in geometry:
        centre, radius, *ends = geometry["circle"]
        angle = np.radians(np.linspace(*(ends or (0, 360)), 73))
        return np.add(centre, radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    return np.array(geometry, dtype=float, ndmin=2)


def _part(axes, size, kind, points, role, text, shift=(0, 0)):
    """Draw a part in the colour of its role, and its text where that kind of part has it."""
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
