"""Still drawings of lessons 00 to 04: a bore, turns, frames and coins; captions are from `setups.toml`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from mathpost import euler
from mathpost.rotation import unit
from mathpost.teaching.course.verdict import toml
from mathpost.teaching.draw import plot
from mathpost.teaching.draw.picture import camera

if TYPE_CHECKING:
    from mathpost.frame import Frame
    from mathpost.kinematics import Kinematics

MACHINE, WORKPIECE, POINT = (plot.COLOUR[role] for role in ("machine", "workpiece", "tool"))
AXIS = plot.COLOUR["first branch"]  # of a turn
NODES = plot.COLOUR["second branch"]  # the line of nodes
ARCS = (plot.COLOUR["tool side"], plot.COLOUR["second branch"], plot.COLOUR["workpiece side"])  # of I, J and K
BOX = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])


Point = Sequence[float] | np.ndarray  # (2,) or (3,)


def captions(drawn: Mapping[str, Any]) -> list[str]:
    """Return what a sign depends on in a drawing, lines: from where one looks, what turns, how a file counts."""
    named = [f"{'-' * (rise < 0)}{name}" for name, (_, rise, *_) in drawn["axes"].items()]
    towards = f", {plot.viewer(*named)}" if len(named) == 2 and set(drawn["axes"]) < set("XYZ") else ""
    turns = [f"{word}: {drawn[word]}" for word in ("turns", "moves") if word in drawn]
    positive = [f"in the file: # positive = {drawn['positive']}"] if "positive" in drawn else []
    return [f"seen from {drawn['seen']}{towards}", *turns, *positive]


def _say(axes: Axes, name: str) -> None:
    """Write the captions of a drawing under its figure."""
    axes.figure.supxlabel("\n".join(captions(toml("setups")[name])), fontsize=9)


def turn_in_plane(axes: Axes, degrees: float) -> None:
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
    _say(axes, "turn_in_plane")


def active_and_passive(left: Axes, right: Axes, point: Point, degrees: float) -> None:
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
        write(right, 1.28 * row, name, WORKPIECE)
    _arc(right, 0, degrees, 0.3)
    _point(right, point, "P", turn.T, POINT)
    _say(left, "active_and_passive")


def quarter_turns(panels: Iterable[Axes3D]) -> None:
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
        _say(axes, "quarter_turns")


def ruined_bore(panels: Iterable[Axes]) -> None:
    """Draw a bored hole seen along the tool: the bar leaves the wall along the frame's X, then along a wrong one.

    The spindle has stopped with the tip of the bar on its own X; the control moves it by 1 mm along minus the
    frame's X. Not to scale except for the mark that the tip leaves.
    """
    radius, retract = 10.0, 1.0  # mm
    circle, reach = np.linspace(0, 2 * np.pi, 121), 1.45 * radius
    rim = radius * np.column_stack([np.cos(circle), np.sin(circle)])
    for axes, angle, title in zip(panels, (0.0, 180.0), ("the right frame", "the wrong frame"), strict=True):
        axes.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach), title=title)
        axes.set_axis_off()
        axes.fill(reach * BOX[:, 0], reach * BOX[:, 1], color=WORKPIECE, alpha=0.25)
        axes.fill(*rim.T, color="white")
        axes.plot(*rim.T, color=WORKPIECE)
        x = euler.from_axis_angle([0, 0, 1], angle, degrees=True)[:2, 0]  # of the frame; the spindle's is (1, 0)
        tip, end = np.array([radius, 0.0]), np.array([radius, 0.0]) - 3 * retract * x
        axes.fill(*(0.55 * rim - 3 * retract * x).T, color=POINT, alpha=0.35)
        axes.plot(*np.array([0.5 * tip - 3 * retract * x, end]).T, color=POINT, linewidth=5)
        free = end[0] < tip[0]
        if not free:
            axes.fill(*(0.1 * rim + (tip + end) / 2).T, color="white")
        said = "clear of the wall" if free else f"a notch of {retract:g} mm"
        write(axes, np.array([0, 1.2 * radius]), said, POINT)
        above = np.array([0, 0.12 * radius])
        _arrow(axes, tip + above, end + above, MACHINE)
        at = (0.9 if free else 1.0) * radius
        axes.text(at, 0.22 * radius, "retract", color=MACHINE, ha="right" if free else "left")
        for height, name, towards in ((-1.13, "spindle", np.array([1.0, 0.0])), (-1.33, "face", x)):
            start = np.array([-0.5 * radius, height * radius]) - 2 * towards
            colour = POINT if name == "spindle" else WORKPIECE
            _arrow(axes, start, start + 4 * towards, colour)
            axes.text(-0.15 * radius, start[1], f"X of the {name}", color=colour, va="center")
        _say(axes, "ruined_bore")


def parts(axes: Axes3D, point: Point, axis: Point, degrees: float) -> None:
    """Draw a point that turns about an axis: its part along the axis, its part across it, and the turned one."""
    p, v = np.array(point, dtype=float), unit(np.array(axis, dtype=float))
    along, side = p @ v * v, np.cross(v, p)
    across, turn = p - along, np.linspace(0, 2 * np.pi, 91)[:, None]
    moved = euler.from_axis_angle(v, degrees, degrees=True) @ p
    plot.space(axes, 0.8, centre=0.8 * along)
    axes.view_init(elev=32, azim=-50)
    axes.plot(*(along + np.cos(turn) * across + np.sin(turn) * side).T, color=MACHINE, linewidth=1)
    axes.plot(*np.array([0 * v, along]).T, color=POINT, linewidth=7, alpha=0.5)
    right, up, _ = camera(-50, 32)
    rows = (  # where a name stands: beside a point, steps to the right and upwards on the page
        (0 * v, 1.5 * v, AXIS, "v", 1.5 * v, 0.08, 0.04),
        (along, p, POINT, "part across", (along + p) / 2, -0.1, 0.12),
        (along, along + side, MACHINE, "v × p", along + side, 0.1, -0.06),
        (along, moved, WORKPIECE, "across,\nturned", (along + moved) / 2, 0.24, -0.1),
        (0 * v, p, MACHINE, "p", p, -0.09, 0.0),
        (0 * v, moved, WORKPIECE, "p turned", moved, 0.2, -0.12),
    )
    for start, end, colour, name, at, across_page, up_page in rows:
        _space_arrow(axes, start, end, colour)
        axes.text(
            *(at + across_page * right + up_page * up), name, color=colour, ha="center", va="center", fontsize=9
        )
    axes.text(*(along / 2 - 0.28 * right - 0.05 * up), "part along v", color=POINT, ha="center", fontsize=9)
    t = np.radians(np.linspace(0, degrees, 31))[:, None]
    _space_arc(axes, along, 0.45 * (np.cos(t) * across + np.sin(t) * side), AXIS, "")
    axes.text(
        *(along + 0.53 * (np.cos(t[23]) * across + np.sin(t[23]) * side)), "t", color=AXIS, ha="center", va="center"
    )
    _say(axes, "parts")


def two_mirrors(axes: Axes, start: float, between: float) -> None:
    """Draw a point and its images in two mirrors, seen along their common line; angles of the normals, degrees."""
    axes.set(aspect="equal", xlim=(-1.3, 1.4), ylim=(-1.1, 1.35))
    axes.set_axis_off()
    normals = {"a": start, "b": start + between}
    phi = start - 40.0
    images = {"P": phi, "P′": 2 * start + 180 - phi, "P″": phi + 2 * between}
    for (name, angle), colour in zip(normals.items(), (MACHINE, WORKPIECE), strict=True):
        normal = _turn(angle)[:, 0]
        along = _turn(angle)[:, 1]
        axes.plot(*np.transpose([-0.65 * along, 1.15 * along]), color=colour, linewidth=3, alpha=0.6)
        write(axes, 1.27 * along, f"mirror {name}", colour)
        _arrow(axes, (0, 0), 0.55 * normal, colour)
        write(axes, 0.65 * normal, name, colour)
    _arc(axes, start, start + between, 0.35)
    for (name, angle), style in zip(images.items(), ("none", "none", "full"), strict=True):
        place = _turn(angle)[:, 0]
        axes.plot(*np.transpose([(0, 0), place]), color=POINT, linestyle=":")
        axes.plot(*place, "o", color=POINT, fillstyle=style)
        write(axes, 1.13 * place, name, POINT)
    _arc(axes, phi, phi + 2 * between, 0.85)
    _say(axes, "two_mirrors")


def euler_discs(axes: Axes3D, i: float, j: float, k: float) -> None:
    """Draw ZXZ angles, degrees: the discs XY and xy, the line of nodes in which they meet, and an arc for each."""
    frame, circle = euler.matrix("ZXZ", (i, j, k), degrees=True), np.linspace(0, 2 * np.pi, 91)
    disc = np.stack([np.cos(circle), np.sin(circle), 0 * circle], axis=-1)
    plot.space(axes, 0.95, centre=(0, 0, 0.15))
    axes.view_init(elev=24, azim=-28)
    for turned, colour, letters in ((np.eye(3), MACHINE, "XYZ"), (frame, WORKPIECE, "xyz")):
        axes.add_collection3d(Poly3DCollection([disc @ turned.T], facecolor=colour, edgecolor=colour, alpha=0.18))
        for arm, letter in zip(turned.T, letters, strict=True):
            _space_arrow(axes, np.zeros(3), 1.12 * arm, colour)
            axes.text(*(1.24 * arm), letter, color=colour, ha="center", va="center")
    node = euler.matrix("ZXZ", (i, 0, 0), degrees=True)[:, 0]
    axes.plot(*np.array([-1.1 * node, 1.1 * node]).T, color=NODES, linestyle="--", linewidth=2)
    axes.text(*(1.3 * node), "line of nodes", color=NODES, ha="center")
    part = np.linspace(0, 1, 31)
    arcs = {
        "I": [(i * s, 0, 0) for s in part],
        "J": [(i, j * s, 0) for s in part],
        "K": [(i, j, k * s) for s in part],
    }
    for (letter, angles), colour, column, size in zip(arcs.items(), ARCS, (0, 2, 0), (0.5, 0.7, 0.75), strict=True):
        _space_arc(
            axes, np.zeros(3), size * euler.matrix("ZXZ", angles, degrees=True)[:, :, column], colour, letter
        )
    _say(axes, "euler_discs")


def frames_and_point(axes: Axes3D, frames: Mapping[str, Frame], point: Point, arm: float) -> None:
    """Draw frames (a dict from a name to a `Frame` in the first one), and from each a way to one point.

    The dotted way goes along X, Y and Z of the frame: its three parts are the point's coordinates there. `arm` is
    the length of the axes, in the units of the point.
    """
    seen = np.array([point, *(each.origin for each in frames.values())])
    centre = (seen.min(axis=0) + seen.max(axis=0)) / 2
    plot.space(axes, 0.42 * np.ptp(seen, axis=0).max() + 0.6 * arm, centre=centre)
    axes.view_init(elev=20, azim=-35)
    right, up, _ = camera(-35, 20)
    for (name, each), colour in zip(frames.items(), (MACHINE, WORKPIECE, POINT), strict=True):
        for direction, letter in zip(each.rotation.T, "XYZ", strict=True):
            _space_arrow(axes, each.origin, each.origin + arm * direction, colour)
            aside = 0.2 * arm * up if letter == "X" else 0  # the way goes on there
            at = each.origin + 1.2 * arm * direction + aside
            axes.text(*at, letter, color=colour, ha="center", va="center", fontsize=9)
        at = each.origin + 0.9 * arm * each.rotation[:, 2] - 0.48 * arm * right
        axes.text(*at, name, color=colour, ha="center", va="center", weight="bold")
        inside = each.inverse().point(point)
        corners = [each.point(inside * (np.arange(3) < count)) for count in range(4)]
        axes.plot(*np.transpose(corners), color=colour, linestyle=":")
    axes.plot(*np.transpose([point]), "o", color="black")
    axes.text(*(np.asarray(point) + 0.3 * arm * right + 0.2 * arm * up), "P", ha="center", va="center")
    _say(axes, "frames_and_point")


def chains(axes: Axes, machines: Mapping[str, Kinematics]) -> None:
    """Draw the chain of each machine as a row of boxes, from the workpiece to the tool: its links, and the bed.

    A box is in the colour of its link: the axis next to the workpiece, the one next to the tool, the slides.
    """
    rows = {name: [link.name for link in kin.links()] for name, kin in machines.items()}
    axes.set(xlim=(-0.7, max(map(len, rows.values())) + 0.55), ylim=(-len(rows) + 0.45, 0.75))
    axes.set_axis_off()
    for row, (name, links) in enumerate(rows.items()):
        kin = machines[name]
        derived = kin.inverse_symbolic
        side = {str(derived.workpiece_side): "workpiece side", str(derived.tool_side): "tool side"}
        side |= {"workpiece": "workpiece", "tool": "tool"}
        place = links.index("linear")
        boxes = [*links[:place], "bed", *links[place:]]
        axes.text(-0.58, 0.36 - row, f"{kin.machine.arrangement}: {' · '.join(links)}", va="center")
        for at, link in enumerate(boxes):
            colour = plot.COLOUR[side.get(link, "machine")]
            words = {"linear": "X Y Z"}.get(link, link)
            style = {"boxstyle": "round,pad=0.4", "facecolor": "white", "edgecolor": colour, "linewidth": 2}
            if link == "bed":
                style |= {"facecolor": colour, "alpha": 0.35}
            axes.text(at or -0.16, -row, words, ha="center", va="center", bbox=style)
            if at:
                _arrow(axes, (at - 0.66, -row), (at - 0.4, -row), MACHINE)


def coins(panels: Iterable[Axes3D], turns: str, title: str) -> None:
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
        _say(axes, "coins")


def _turn(degrees: float) -> np.ndarray:
    return euler.from_axis_angle([0, 0, 1], degrees, degrees=True)[:2, :2]


def _plane(axes: Axes, title: str = "", start: float = -1.2) -> None:
    """Draw a frame X, Y with its unit circle."""
    axes.set(aspect="equal", xlim=(start, 1.4), ylim=(-0.3, 1.4), title=title)
    axes.set_axis_off()
    axes.add_patch(Circle((0, 0), 1.0, fill=False, color=MACHINE, linewidth=0.6))
    for end, name in (((1.25, 0), "X"), ((0, 1.25), "Y")):
        _arrow(axes, (0, 0), end, MACHINE)
        write(axes, 1.06 * np.array(end), name, MACHINE)


def _arrow(axes: Axes, start: Point, end: Point, colour: str) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 2, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (end[0], end[1]), (start[0], start[1]), arrowprops=style)


def write(axes: Axes, at: np.ndarray, text: str, colour: str) -> None:
    """Write a text about a place."""
    axes.text(at[0], at[1], text, color=colour, ha="center", va="center")


def _arc(axes: Axes, start: float, end: float, radius: float) -> None:
    turn = np.radians([*np.linspace(start, end, 41), end - 2])
    *arc, before = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    axes.plot(*np.transpose(arc), color=AXIS)
    _arrow(axes, before, arc[-1], AXIS)


def _space_arrow(axes: Axes3D, start: np.ndarray, end: np.ndarray, colour: str) -> None:
    head = min(0.12 / np.linalg.norm(end - start), 0.5)
    axes.quiver(*start, *(end - start), color=colour, arrow_length_ratio=head)


def _space_arc(axes: Axes3D, centre: np.ndarray, arc: np.ndarray, colour: str, name: str) -> None:
    """Draw an arc about a centre with an arrowhead, and its name outside its middle."""
    at = centre + arc
    axes.plot(*at.T, color=colour, linewidth=2.5)
    axes.quiver(*at[-4], *(at[-1] - at[-4]), color=colour, arrow_length_ratio=1.0, linewidth=2.5)
    axes.text(*(centre + 1.2 * arc[len(arc) // 2]), name, color=colour, ha="center", va="center", weight="bold")


def _point(
    axes: Axes, point: np.ndarray, name: str, directions: Iterable[np.ndarray], colour: str, style: Any = "full"
) -> None:
    """Draw a point, and its coordinates as dotted lines to the axes."""
    axes.plot(*point, "o", color=POINT, fillstyle=style)
    axes.text(point[0] + 0.07, point[1] + 0.05, name, color=POINT)
    for direction in directions:
        axes.plot(*np.array([point, point @ direction * direction]).T, color=colour, linestyle=":")
