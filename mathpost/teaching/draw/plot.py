"""Pictures of kinematics: one colour per role everywhere, and curves along a tool path."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
import sympy as sp
from IPython.display import Math, display
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import ArrayLike
from PIL import Image

from mathpost.path.deviation import true_tip
from mathpost.rotation import unit
from mathpost.teaching.draw.colours import COLOUR, STYLE
from mathpost.teaching.draw.described import describe
from mathpost.teaching.draw.picture import small_png

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.shop.measure.angular_error import Accuracy, Runs
    from mathpost.shop.measure.cutter import Cutter
    from mathpost.shop.measure.spline import Curve
    from mathpost.teaching.workbook.report import FileReport


def figure(
    rows: int = 1, columns: int = 1, *, size: tuple[float, float] = (7.0, 4.2), three_d: bool = False
) -> tuple[Figure, Any]:
    """Return ``(figure, axes)`` in the house style; close it with `show`."""
    projection = {"projection": "3d"} if three_d else None
    return plt.subplots(rows, columns, figsize=size, layout="constrained", subplot_kw=projection)


def show() -> None:
    """Show all open figures, each with its description in numbers, and close them."""
    for number in plt.get_fignums():
        drawn = plt.figure(number)
        canvas = FigureCanvasAgg(drawn)
        canvas.draw()  # `savefig` would go through all artists twice
        png = small_png(Image.fromarray(np.asarray(canvas.buffer_rgba())))
        told = describe(drawn)
        picture = {"image/png": base64.b64encode(png).decode(), "text/plain": told}
        display(picture, raw=True, metadata={"image/png": {"alt": told}})
    plt.close("all")


def frame(axes: Axes3D, matrix: np.ndarray, origin: np.ndarray, *, colour: str, **style: Any) -> None:
    """Draw a frame's three axes: the columns of `matrix`, shape (3, 3), from `origin`, shape (3,)."""
    for column, label in zip(matrix.T, "XYZ", strict=True):
        axes.plot(*zip(origin, origin + column, strict=True), color=colour, **style)
        axes.text(*(origin + 1.15 * column), label, color=colour, ha="center", va="center")


def along(
    axes: Axes, place: ArrayLike, values: ArrayLike, role: str, label: str | None = None, *, points: bool = False
) -> None:
    """Draw one quantity along a path in the colour and style of its `role`, one of `COLOUR`."""
    marker = "o" if points else None
    colour, style = COLOUR[role], STYLE[role]
    axes.plot(place, values, label=label or role, marker=marker, markersize=4, color=colour, linestyle=style)


def travel(axes: Axes, low: float, high: float) -> None:
    """Shade the region outside the travel of an axis, within the current limits of `axes`."""
    bottom, top = axes.get_ylim()
    for start, end in ((bottom, max(low, bottom)), (min(high, top), top)):
        if end > start:
            axes.axhspan(start, end, color=COLOUR["forbidden"], alpha=0.4, zorder=0)
    axes.set_ylim(bottom, top)


def trellis(
    axes: Axes,
    records: Sequence[Any],
    words: Sequence[Sequence[str]],
    inside: np.ndarray,
    seconds: np.ndarray,
    ways: Mapping[str, Sequence[int]] | None = None,
) -> None:
    """Draw m candidates for each of n records, and the costs of the moves between them.

    `words`, n lists of m, label the candidates, first and second branch in turn. Those not `inside` travel, shape
    (n, m), are open circles that no move leads to. `seconds`, the costs, has shape (n - 1, m, m). `ways` maps a
    role, one of `COLOUR`, to the number of the candidate at each record.
    """
    for (at, row), fits in np.ndenumerate(inside):
        colour = COLOUR[("first branch", "second branch")[row % 2]]
        axes.plot(at, -row, "o", color=colour, fillstyle="full" if fits else "none", markersize=9, zorder=3)
        axes.text(at, -row + (0.22 if row == 0 else -0.22), words[at][row], ha="center", va="center", fontsize=8)
    for (at, i, j), cost in np.ndenumerate(seconds):
        if inside[at][i] and inside[at + 1][j]:
            axes.plot([at, at + 1], [-i, -j], color=COLOUR["machine"], linewidth=0.8, zorder=0)
            white = {"facecolor": "white", "edgecolor": "none", "pad": 1}
            axes.text(at + 0.3, -i - 0.3 * (j - i), f"{cost:.2f}", ha="center", va="center", fontsize=8, bbox=white)
    for number, (role, way) in enumerate((ways or {}).items()):
        along(axes, range(len(records)), 0.05 * (1 - number) - np.array(way), role)
    if ways:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncols=len(ways))
    axes.set_xticks(range(len(records)), map(str, records))
    axes.set(xlabel="row", xlim=(-0.4, len(records) - 0.6), ylim=(0.4 - len(words[0]), 0.6))
    axes.set_yticks([])


def pole_map(
    axes: Axes,
    kin: Kinematics,
    tool_axes: np.ndarray,
    *,
    cone: float | None = None,
    role: str = "tool",
    label: str | None = None,
) -> Line2D:
    """Draw tool axes (n, 3) seen along the workpiece-side axis, around the pole at their angle from it.

    The singular cone of half angle `cone` (radians) is shaded.
    """
    line = axes.plot(*on_pole_map(kin, tool_axes), "o-", color=COLOUR[role], label=label)
    if cone is not None:
        axes.add_patch(plt.Circle((0, 0), np.degrees(cone), color=COLOUR["forbidden"], alpha=0.6, zorder=0))
    axes.plot(0, 0, "+", color=COLOUR["machine"], markersize=12)
    axes.set(xlabel="degrees from the pole", aspect="equal")
    return line[0]


def on_pole_map(kin: Kinematics, tool_axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return where `pole_map` draws tool axes (n, 3): across and up, degrees, shape (n,) each."""
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    y = unit(np.cross(pole, np.eye(3)[np.abs(pole).argmin()]))
    across, up = tool_axes @ np.cross(y, pole), tool_axes @ y
    angle = np.degrees(np.arctan2(np.hypot(across, up), tool_axes @ pole))
    direction = np.arctan2(up, across)
    return angle * np.cos(direction), angle * np.sin(direction)


def pole_globe(axes: Axes3D, kin: Kinematics, paths: Mapping[str, np.ndarray]) -> None:
    """Draw tool axes near the pole on a globe, their angles from it enlarged eight times, up to 6 degrees.

    `paths` maps a role, one of `COLOUR`, to tool axes (n, 3); `axes` are three-dimensional.
    """

    def lifted(across: np.ndarray, up: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        angle, heading = np.radians(8) * np.hypot(across, up), np.arctan2(up, across)
        return np.sin(angle) * np.cos(heading), np.sin(angle) * np.sin(heading), np.cos(angle)

    turn, grey = np.linspace(0, 2 * np.pi, 73), {"color": COLOUR["machine"], "linewidth": 0.6}
    for degrees in range(1, 7):
        axes.plot(*lifted(degrees * np.cos(turn), degrees * np.sin(turn)), **grey)
    spoke = np.linspace(0, 6, 25)
    for heading in turn[:-1:6]:
        axes.plot(*lifted(spoke * np.cos(heading), spoke * np.sin(heading)), **grey)
    for role, tool_axes in paths.items():
        axes.plot(*lifted(*on_pole_map(kin, tool_axes)), STYLE[role], color=COLOUR[role], linewidth=2.2, label=role)
    axes.set_box_aspect((1, 1, 0.5), zoom=1.4)
    axes.view_init(elev=50, azim=-75)
    axes.set_axis_off()


def tip_path(axes: Axes, kin: Kinematics, joints: np.ndarray, *, role: str, label: str) -> None:
    """Draw, seen from above, the true path of the tip when all joints move linearly from row to row."""
    tip = true_tip(kin, joints, samples=40)
    axes.plot(tip[:, 0], tip[:, 1], color=COLOUR[role], linestyle=STYLE[role], label=label)
    axes.set(xlabel="x in the workpiece, mm", ylabel="y, mm", aspect="equal")


def turned_point(axes: Axes, path: ArrayLike, centre: ArrayLike, *, names: Sequence[str]) -> None:
    """Draw the path of a point about an axis seen end on, from a ring to a dot, with the radius at both ends.

    `path` has shape (n, 2), `centre` is where the axis is seen; `names` are those of the machine's axes in the
    plane, the one to the right and the one upwards, or downwards with a minus before it.
    """
    path, centre = np.asarray(path), np.asarray(centre)
    axes.plot(*np.array([path[0], centre, path[-1]]).T, color=COLOUR["machine"], linewidth=0.8)
    axes.plot(*centre, "+", color=COLOUR["machine"], markersize=12)
    axes.plot(*path.T, color=COLOUR["workpiece"])
    axes.plot(*path[0], "o", color=COLOUR["workpiece"], fillstyle="none")
    axes.plot(*path[-1], "o", color=COLOUR["workpiece"])
    right, up = names[0], names[1][-1]
    axes.set(xlabel=f"{right} (mm)", ylabel=f"{up} (mm)", aspect="equal", title=f"seen from {viewer(*names)}")
    axes.yaxis.set_inverted(up != names[1])


def viewer(right: str, up: str) -> str:
    """Return the direction of the machine from which one looks at two of its axes; a minus is one that points down.

    Examples
    --------
    >>> viewer("X", "Y"), viewer("X", "Z"), viewer("X", "-Z")
    ('+Z', '−Y', '+Y')
    """
    (third,) = set("XYZ") - {right, up[-1]}
    towards = np.cross(*(np.eye(3)["XYZ".index(name[-1])] for name in (right, up))).sum() * (1 - 2 * (len(up) > 1))
    return f"{'+' if towards > 0 else '−'}{third}"


def ellipse(axes: Axes, centre: ArrayLike, covariance: np.ndarray, **style: Any) -> None:
    """Draw the ellipse about `centre` that contains 95 % of a normal cloud with this covariance, shape (2, 2)."""
    values, directions = np.linalg.eigh(covariance)
    turn = np.linspace(0, 2 * np.pi, 181)
    size = np.sqrt(-2 * np.log(0.05))  # a circle of that radius contains 95 % if both deviations are 1
    ring = directions @ (size * np.sqrt(values)[:, None] * [np.cos(turn), np.sin(turn)])
    axes.plot(*(ring + np.reshape(centre, (2, 1))), **style)


def cutter(axes: Axes, cutter: Cutter, tip: Sequence[float]) -> None:
    """Fill the outline of an upright `Cutter`, 14 mm of it, its `tip` at (x, z)."""
    rise = np.linspace(0, np.pi / 2, 30)
    flat = cutter.diameter / 2 - cutter.rim
    across = np.concatenate([[0], flat + cutter.rim * np.sin(rise), [cutter.diameter / 2, 0]])
    up = np.concatenate([[0], cutter.rim * (1 - np.cos(rise)), [14, 14]])
    x, z = tip[0] + np.concatenate([across, -across[::-1]]), tip[1] + np.concatenate([up, up[::-1]])
    axes.fill(x, z, color=COLOUR["tool"], alpha=0.3)
    axes.set_aspect("equal")


def runs(axes: Axes, measured: Runs, result: Accuracy) -> None:
    """Draw bidirectional runs (`angular_error.Runs`) with the means ± 2 s of their `Accuracy`."""
    for role, label in (("first branch", "up"), ("second branch", "down")):
        each, mean, s = getattr(measured, label), measured.mean(label), getattr(result, f"s_{label}")
        axes.plot(measured.angles, each, ".", color=COLOUR[role], markersize=3)
        axes.plot(measured.angles, mean, STYLE[role], color=COLOUR[role], label=f"{label}: mean, ± 2 s")
        axes.fill_between(measured.angles, mean - 2 * s, mean + 2 * s, color=COLOUR[role], alpha=0.25)
    axes.axhline(0, color=COLOUR["machine"], linewidth=0.8)
    axes.set(xlabel="angle, deg", ylabel="actual − target, arcsec")
    axes.legend()


def knots(axes: Axes, fitted: Curve) -> None:
    """Draw a `mathpost.shop.measure.spline.Curve` over its measured points, the knots as circles."""
    measured = fitted.points
    end = measured.at[-1] if measured.period is None else measured.at[0] + measured.period
    fine = np.linspace(measured.at[0], end, 721)
    chosen = sorted(fitted.knots)
    axes.plot(measured.at, measured.values, "x", color=COLOUR["published"], markersize=4, label="measured")
    axes.plot(fine, fitted(fine), color=COLOUR["workpiece"], label=f"spline, {len(chosen)} knots")
    axes.plot(measured.at[chosen], measured.values[chosen], "o", color=COLOUR["workpiece"], fillstyle="none")
    axes.set(xlabel="angle, deg", ylabel="error, arcsec")
    axes.legend(loc="lower left")


def costs(axes: Axes, position: ArrayLike, priced: Mapping[str, np.ndarray], *, label: str) -> None:
    """Draw the costs of the six worst errors along a path; `priced` is from `Compensator.costs`."""
    lines = ("-", "--", "-.", ":", "-", "--")
    for index, (line, (name, cost)) in enumerate(zip(lines, priced.items(), strict=False)):
        axes.plot(position, 1e3 * cost, line, color=f"C{index}", label=name)
    axes.set(xlabel=label, ylabel="µm at the tip", ylim=(0, None))
    axes.legend(loc="upper left", bbox_to_anchor=(1, 1))


def formulas(*pairs: tuple[str, np.ndarray | sp.Matrix]) -> Math:
    """Return named matrices side by side as one formula: pairs of a LaTeX name and a matrix, exact or numbers."""
    exact = (sp.Matrix(np.round(m, 6) + 0.0) if isinstance(m, np.ndarray) else m for _, m in pairs)
    return Math(r" \qquad ".join(f"{name} = {sp.latex(m)}" for (name, _), m in zip(pairs, exact, strict=True)))


def space(axes: Axes3D, radius: float, *, centre: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0)) -> None:
    """Prepare three-dimensional `axes` for a cube of half-width `radius`: equal scales, no panes."""
    axes.set(**{f"{name}lim": (c - radius, c + radius) for name, c in zip("xyz", centre, strict=True)})
    axes.set_box_aspect((1, 1, 1), zoom=1.25)
    axes.view_init(elev=22, azim=-55)
    axes.set_axis_off()


LETTERS = 11  # that one cell of a drawn worksheet can show


def worksheet(axes: Axes, report: FileReport) -> None:
    """Draw the first sheet that was judged, from its first number on, with its labels.

    Judged cells are green, red or amber; the first wrong one has a frame, and its formula stands below.
    """
    from openpyxl.utils import get_column_letter  # slow to import, and all but one lesson draw no sheet

    from mathpost.teaching.workbook.report import STATUS_COLOUR
    from mathpost.teaching.workbook.sheet.file import read

    sheet = report.cells[0].place[0]
    held = {place[1:]: cell for place, cell in read(report.path).cells.items() if place[0] == sheet}
    judged = {cell.place[1:]: cell for cell in report.cells if cell.place[0] == sheet}
    numbers = [place for place, cell in held.items() if isinstance(cell.value, float | int)]
    top, bottom = min(numbers)[0], max(numbers)[0]
    right = max(column for _, column in numbers)
    first = report.first.place[1:] if report.first else None
    for place, cell in held.items():
        row, column = place
        if place in judged:
            written = judged[place].written
            text = f"{written:z.3f}" if cell.formula and isinstance(written, float) else str(cell.value or "?")
            colour = STATUS_COLOUR[judged[place].status]
        else:
            text, colour = str("" if cell.value is None else cell.value), "white"
        if place in judged or isinstance(cell.value, float | int):
            axes.add_artist(plt.Rectangle((column - 0.5, row - 0.5), 1, 1, facecolor=colour, edgecolor="#bfbfbf"))
            weight = "bold" if place == first else "normal"
            axes.text(column, row, text[:LETTERS], ha="center", va="center", fontsize=6, weight=weight)
        elif row >= top:
            free = next((n for n in range(1, right) if (row, column + n) in held), right + 1 - column)
            label = _latin(text)[: LETTERS * free]
            axes.text(column - 0.4, row, label, va="center", fontsize=6, color="#555555")
    if first:
        row, column = first
        axes.add_artist(plt.Rectangle((column - 0.5, row - 0.5), 1, 1, fill=False, linewidth=2.5, zorder=3))
        axes.set_xlabel(f"{report.faults[0].cell}  {held[first].formula or 'a number'}", fontsize=8)
    for drawn in (*axes.patches, *axes.texts):  # inside the limits: nothing to make room for
        drawn.set_in_layout(False)
    axes.set(xlim=(0.2, right + 0.8), ylim=(bottom + 0.8, top - 0.8))
    axes.set_xticks(range(1, right + 1), map(get_column_letter, range(1, right + 1)))
    axes.xaxis.tick_top()
    rows = sorted({row for row, _ in numbers})
    axes.set_yticks([row for row in rows if row - 1 not in rows])
    axes.spines[:].set_visible(False)
    axes.tick_params(length=0)


def _latin(text: str) -> str:
    """The part of a label in two languages that the font of the pictures has."""
    return re.sub(r" ?\(?[\u2e80-\uffef]+\)?:? ?", " ", text).replace(" ,", ",").strip(" ·")
