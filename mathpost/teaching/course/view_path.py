"""Views with sliders for lessons 05 to 06b: paths past the pole, the spline of source 002."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from mathpost.errors import InputError
from mathpost.path import selection
from mathpost.path.between_blocks import Motion
from mathpost.path.deviation import from_arc, strays
from mathpost.shop.post.time_law import block_times, time_law
from mathpost.sources import yu_dan
from mathpost.teaching.course.lesson_data import with_travel
from mathpost.teaching.course.view_globe import DISTANCE, LONGITUDE, SPEED, TILT
from mathpost.teaching.draw import plot
from mathpost.teaching.draw.curves import Moving, printed, recorded, subplots
from mathpost.teaching.draw.live import Live, slider

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData
    from mathpost.shop.post.ways import Crossing

MOST_POINTS, MOVED_MOST, BLOCKS = 60, 6.0, 21  # of `smoothed`; degrees of `moved_aside`; of `virtual_time`
KEPT = np.radians(0.05)  # from the pole, within which the branch may change while the tool axis stays


def both_angles(kin: Kinematics) -> Live:
    """One tool axis seen from the side and along the axis next to the workpiece, which is Z; a slider for each.

    The side view shows the effect of the tool-side angle alone, the other that of the workpiece-side angle.
    """
    derived, n = kin.inverse_symbolic, kin.forward_symbolic()[:3, 2]
    tool_side, workpiece_side = derived.tool_side, derived.workpiece_side
    w = n.subs(workpiece_side, 0)
    products = (w[0] * n[1] - w[1] * n[0], w[0] * n[0] + w[1] * n[1])

    figure, (side, top) = subplots(1, 2, size=(8.0, 4.4))
    turn = np.linspace(0, 2 * np.pi, 37)
    side.plot(np.cos(turn), np.sin(turn), color=plot.COLOUR["machine"], linewidth=0.8)
    side.plot([0, 0], [-1.2, 1.2], color=plot.COLOUR["machine"])
    square = {"xlim": (-1.25, 1.25), "ylim": (-1.25, 1.25), "aspect": "equal"}
    along = "k, along the workpiece-side axis"
    side.set(xlabel="from the side: across the workpiece-side axis", ylabel=along, **square)
    top.set(xlabel="along the workpiece-side axis: i", ylabel="j", **square)
    moving, ends = Moving(), [(-w[1], w[2]), (w[1], w[2])]
    moving.line(side, "published", ends, ":")
    moving.line(side, "first branch", [(0, 0), ends[0]], label=f"{tool_side}", linewidth=2.5)
    moving.line(side, "second branch", [(0, 0), ends[1]], "--", label=f"−{tool_side}", linewidth=2.5)
    moving.line(top, "published", [tuple(n.subs(workpiece_side, angle)[:2]) for angle in turn], ":", label="same k")
    arc = [tuple(n.subs(workpiece_side, workpiece_side * m / 18)[:2, 0] / 2) for m in range(19)]
    moving.line(top, "workpiece", arc, label=f"{workpiece_side}")
    moving.line(top, "machine", [(0, 0), tuple(w[:2])], label=f"w, at {workpiece_side} = 0", linewidth=2.5)
    moving.line(top, "tool", [(0, 0), tuple(n[:2])], label="n, the tool axis", linewidth=2.5)
    figure.legend(loc="outside lower center", ncols=6, fontsize=8)
    said = "sine product {:4}, cosine product {:4}, atan2 of the two {:2}°"
    text = [("i = {:4}, j = {:4}, k = {:4}", *n), (said, *products, sp.deg(sp.atan2(*products)))]
    sliders = [slider(f"{workpiece_side}", -180, 180, 125), slider(f"{tool_side}", -90, 90, 50)]
    return printed(figure, moving, (workpiece_side, tool_side), sliders, text, height=530)


def past_the_pole(kin: Kinematics) -> Live:
    """A tool that tilts in a plane at a distance from the pole: both branches of both rotary axes."""
    tilts = np.sort(np.r_[20 * np.linspace(-1, 1, 41) ** 3, -0.5, 0.5])  # dense where the workpiece-side axis turns
    pole, names = np.array(kin.inverse_symbolic.pole, dtype=float), kin.machine.joint_names[3:]
    side = np.eye(3)[np.abs(pole).argmin()]
    across = np.cross(pole, side)
    tool_side = names.index(str(kin.inverse_symbolic.tool_side))

    (figure, panels), lines = subplots(2, 1, size=(7.0, 4.6), sharex=True), {}
    for axis, panel in enumerate(panels):
        for branch, role in enumerate(("first branch", "second branch")):
            (lines[axis, branch],) = panel.plot(tilts, tilts, plot.STYLE[role], color=plot.COLOUR[role], label=role)
        panel.set(ylabel=f"{names[axis]}, degrees", ylim=(-60, 60) if axis == tool_side else (-280, 280))
    panels[0].legend(loc="upper center", ncols=2)
    panels[1].set_xlabel("tilt of the tool in its plane, degrees")

    def update(distance: float) -> list[str]:
        plane = np.cos(np.radians(distance)) * pole + np.sin(np.radians(distance)) * across
        axes = np.outer(np.cos(np.radians(tilts)), plane) + np.outer(np.sin(np.radians(tilts)), side)
        angles = np.degrees(np.unwrap(kin.inverse([0, 0, 0], axes)[..., 3:], axis=0))
        angles -= 360 * np.rint(angles[len(tilts) // 2] / 360 - 1e-9)  # at ±180 always the same
        for (axis, branch), line in lines.items():
            line.set_ydata(angles[:, branch, axis])
        turned = np.abs(np.diff(angles[:, 0, 1 - tool_side]))
        middle = turned[(tilts[:-1] >= -0.5) & (tilts[1:] <= 0.5)].sum()
        far = f"{distance:.1f}° from the pole: {names[1 - tool_side]} turns by {turned.sum():.1f}°"
        return [f"{far}, by {middle:.1f}° of it while the tool tilts by 1°"]

    return recorded(figure, update, slider("distance", 0.1, 6.0, 3.0, step=0.1), height=520)


def travel_limit(kin: Kinematics, cl: CLData, records: Sequence[int], high: int) -> Live:
    """The choice of each strategy if the tilting axis, the first one, has a lower limit set by a slider.

    Between records the tool axis may sway, except in "kept", the best way that keeps it. `high` is the other limit,
    degrees.
    """
    both = np.degrees(kin.inverse(cl.points, cl.axes)[:, :, 3])
    ways = {way: (way, np.inf) for way in selection.STRATEGIES} | {"kept": ("optimal", KEPT)}
    found = {}
    for low in np.arange(-30.0, 1.0):
        limited = with_travel(kin, low, high)
        found[low] = {name: selection.choose(limited, cl, way, sway=sway) for name, (way, sway) in ways.items()}
    name = kin.machine.joint_names[3]

    figure, (tilt, price) = subplots(1, 2, size=(8.5, 4.2))
    places = np.arange(len(records))
    for branch, role in enumerate(("first branch", "second branch")):
        tilt.plot(places, both[:, branch], "o", color=plot.COLOUR[role], label=role)
    lowest = tilt.plot(places[[0, -1]], [0, 0], color=plot.COLOUR["machine"], label=f"{name} from")[0]
    tilt.set(xlabel="row", ylabel=f"{name}, degrees", ylim=(-32, 32))
    tilt.set_xticks(places, map(str, records))
    price.set(xlabel=f"{name} from, degrees", ylabel="seconds", ylim=(0, 6.5))
    lines, dots, width = {}, {}, {way: 6.5 - 1.5 * number for number, way in enumerate(ways)}  # all can be seen
    for way in ways:
        costs = [each[way].cost for each in found.values()]
        price.plot(*_stairs(list(found), costs), color=plot.COLOUR[way], linewidth=width[way])
        (lines[way],) = tilt.plot(places, places, linewidth=width[way], color=plot.COLOUR[way], label=way)
        (dots[way],) = price.plot([], [], "o", color=plot.COLOUR[way])
    figure.legend(loc="outside lower center", ncols=7, fontsize=8)

    def update(low: int) -> list[str]:
        lowest.set_ydata([low, low])
        for way, chosen in found[low].items():
            lines[way].set_ydata(np.degrees(chosen.joints[:, 3]))
            dots[way].set_data([low], [chosen.cost])
        costs = ", ".join(f"{way} {chosen.cost:.3f} s" for way, chosen in found[low].items())
        return [f"{name} from {low:.0f}°: {costs}"]

    return recorded(figure, update, slider(f"{name} from", -30, 0, -5, step=1), height=520)


def _stairs(x: Sequence[float], y: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a line that jumps half-way between the whole numbers where it was computed."""
    edges = (np.add(x[1:], x[:-1]) / 2).repeat(2)
    return np.r_[x[0], edges, x[-1]], np.repeat(y, 2)


def pass_by(limit: int) -> Live:
    """The pass of the globe over time: longitude and its speed; C can do `limit` degrees per second."""
    tilts = np.round(25 * np.linspace(-1, 1, 61) ** 3, 4)

    figure, (above, below) = subplots(2, 1, size=(7.0, 4.6), sharex=True)
    moving, rate = Moving(), -LONGITUDE.diff(TILT) * SPEED
    curve = [(angle / SPEED, 90 - sp.deg(LONGITUDE.subs(TILT, sp.rad(angle)))) for angle in tilts]
    moving.line(above, "machine", curve)
    moving.line(below, "machine", [(angle / SPEED, rate.subs(TILT, sp.rad(angle))) for angle in tilts])
    below.plot([-2, 2], [limit] * 2, color=plot.COLOUR["tool"], linestyle="--", label=f"C can do {limit:g}°/s")
    above.set(ylabel="C, degrees", ylim=(-95, 95), xlim=(-2, 2))
    below.set(ylabel="speed of C, °/s", ylim=(0, 600), xlabel="time, s")
    below.legend(loc="upper right")
    sliders = [slider("distance", 0.2, 20, 4, step=0.1)]
    sliders.append(slider("tool speed", 2, 60, 20, unit="°/s"))
    text, follows = "C has to reach {:0}°/s; it can follow from {:2}° on", sp.deg(sp.asin(SPEED / limit))
    return printed(figure, moving, (DISTANCE, SPEED), sliders, [(text, rate.subs(TILT, 0), follows)], height=520)


def clamped(rows: np.ndarray) -> Live:
    """The clamped cubic of one angle, degrees at four records `rows`: sliders t, Δt₁, Δt₂ and for both slopes."""
    t, dt_1, dt_2, times_1, times_2 = sp.symbols("t dt_1 dt_2 times_1 times_2")
    k_1, k_2 = times_1 * (rows[1] - rows[0]) / dt_1, times_2 * (rows[3] - rows[2]) / dt_2
    cubic = yu_dan.hermite().subs({"T": 1, "M_s": rows[1], "M_e": rows[2], "k_1": k_1, "k_2": k_2})
    slope = cubic.diff(t)

    (figure, (above, below)), moving = subplots(2, 1, size=(7.0, 5.0), sharex=True), Moving()
    places, width = [sp.Rational(k, 40) for k in range(41)], sp.Rational(3, 20)
    above.plot([2, 3], rows[1:3], "o", color=plot.COLOUR["machine"], label="records s and e")
    above.plot([2, 3], rows[1:3], color=plot.COLOUR["linear"], linestyle="--", label="linear")
    moving.line(above, "cubic", [(2 + at, cubic.subs(t, at)) for at in places], label="clamped cubic")
    for end, row, slope_there, label in ((2, rows[1], k_1, "k₁, k₂"), (3, rows[2], k_2, None)):
        tangent = [(end + step, row + step * slope_there) for step in (-width, width)]
        moving.line(above, "tool", tangent, linewidth=3, label=label)
    moving.line(above, "cubic", [(2 + t, cubic)], "o")
    below.plot([2, 3], [rows[2] - rows[1]] * 2, color=plot.COLOUR["linear"], linestyle="--")
    moving.line(below, "cubic", [(2 + at, slope.subs(t, at)) for at in places])
    moving.line(below, "cubic", [(2 + t, slope)], "o")
    above.set(ylabel="C, degrees", ylim=(-70, 250))
    below.set(ylabel="slope, ° per record", ylim=(-420, 140), xlim=(1.8, 3.2), xlabel="virtual time, records")
    above.legend(loc="upper right")
    sliders = [slider("t", 0, 1, 0.3, step=0.01, unit="")]
    sliders += [slider(name, 0.02, 2, 1, step=0.01, unit="") for name in ("Δt₁", "Δt₂")]
    sliders += [slider(name, -10, 10, 1, step=0.1, unit="") for name in ("k₁ ×", "k₂ ×")]
    text = [("k₁ = {:2}, k₂ = {:2} degrees per record", k_1, k_2)]
    text += [("at t: C = {:3}°, slope {:2}° per record", cubic, slope)]
    return printed(figure, moving, (t, dt_1, dt_2, times_1, times_2), sliders, text, height=590)


def smoothed(kin: Kinematics, cl: CLData, joints: np.ndarray, region: tuple[int, int]) -> Live:
    """The method of source 002 with n points, slider n, and the errors of tip and tool axis between the blocks."""
    name = kin.machine.joint_names[workpiece_side := kin.symbols.index(kin.inverse_symbolic.workpiece_side)]
    counts = np.arange(1, MOST_POINTS + 1)
    ways = [yu_dan.smooth(kin, cl, joints, region, int(n)) for n in counts]
    tip, axis = np.empty((2, MOST_POINTS))
    for n, (place, rows) in enumerate(ways):
        tip[n], axis[n] = (each.max() for each in strays(kin, cl, Motion.on_part(rows, place)))

    figure, (left, right) = subplots(1, 2, size=(8.5, 3.9))
    fine = yu_dan.smooth(kin, cl, joints, region, 200)
    plot.along(left, fine[0] + 1, np.degrees(fine[1][:, workpiece_side]), "cubic", "clamped cubic")
    (points,) = left.plot([], [], "o", color=plot.COLOUR["tool"], label="blocks")
    left.set(xlabel="virtual time, records", ylabel=f"{name}, degrees")
    left.legend(loc="upper right")
    right.plot(counts, tip, color=plot.COLOUR["tool"], label="tip, mm")
    right.plot(counts, np.degrees(axis), "--", color=plot.COLOUR["machine"], label="tool axis, degrees")
    (dot,) = right.plot([], [], "o", color=plot.COLOUR["tool"])
    right.set(xlabel="points n", ylabel="error between the blocks", yscale="log", ylim=(0.01, 100))
    right.legend(loc="upper right")

    def update(n: float) -> list[str]:
        n = round(n)
        place, rows = ways[n - 1]
        points.set_data(place + 1, np.degrees(rows[:, workpiece_side]))
        dot.set_data([n], [tip[n - 1]])
        off = f"the tip is off by up to {tip[n - 1]:.3f} mm, the axis by {np.degrees(axis[n - 1]):.2f}°"
        return [f"n = {n}: {off}"]

    return recorded(figure, update, slider("n", 1, MOST_POINTS, 5, unit=""), height=470)


def virtual_time(kin: Kinematics, cl: CLData, joints: np.ndarray, region: tuple[int, int]) -> Live:
    """Both angles on the clamped cubic of source 002, sliders Δt₁ and Δt₂, its axis error and the path's time.

    The time is that of 21 blocks; the axis error is that of the curve itself, at ten times as many points.
    """
    first, last = region
    names = kin.machine.joint_names[3:]
    figure, panels = subplots(1, 2, size=(8.5, 3.7))
    curves = []
    for panel, name, around in zip(panels, names, (4, 40), strict=True):
        ends = np.degrees(joints[[first, last], 3 + names.index(name)])
        panel.plot([first + 1, last + 1], ends, "o", color=plot.COLOUR["machine"], label="records s and e")
        curves += panel.plot([], [], color=plot.COLOUR["cubic"], label="clamped cubic")
        panel.set(xlabel="virtual time, records", ylabel=f"{name}, degrees")
        panel.set_ylim(ends.min() - around, ends.max() + around)
    panels[1].legend(loc="upper right")

    def update(before: float, after: float) -> list[str]:
        place, fine = yu_dan.smooth(kin, cl, joints, region, 10 * BLOCKS - 1, dt=(before, after))
        rows = fine[::10]
        for curve, angle in zip(curves, rows[:, 3:].T, strict=True):
            curve.set_data(place[::10] + 1, np.degrees(angle))
        off = np.degrees(from_arc(kin.forward(fine)[1], *cl.axes[[first, last]]).max())
        path = np.concatenate([joints[:first], rows, joints[last + 1 :]])
        no_feed, cutting = np.full(len(path) - 1, np.nan), np.ones(len(path) - 1, dtype=bool)
        asked = block_times(kin.machine, path, kin.forward(path)[0], no_feed, cutting)
        seconds = time_law(kin.machine, path, asked).seconds[-1]
        least = np.degrees(fine[:, 3].min())
        return [f"least {names[0]} {least:.2f}°, tool axis off by {off:.2f}°, {seconds:.2f} s in {BLOCKS} blocks"]

    sliders = [slider(name, 0.1, 2, 1, step=0.1, unit="") for name in ("Δt₁", "Δt₂")]
    return recorded(figure, update, *sliders, height=490)


def moved_aside(crossing: Crossing) -> Live:
    """The tool axis moved aside by a slider's degrees: a map about the pole, and the swinging axis over time."""
    direct, kin = crossing.way("direct"), crossing.kin
    if direct.law is None:
        raise InputError("crossing", "one that the direct way makes", direct.reason)
    name = kin.machine.joint_names[crossing.kin.workpiece_side]

    figure, (chart, over_time) = subplots(1, 2, size=(8.5, 4.2))
    plot.pole_map(chart, kin, crossing.cl.axes, role="workpiece", label="records")
    moved = plot.pole_map(chart, kin, crossing.cl.axes, role="aside", label="moved aside")
    moved.set(marker="", linestyle="-", linewidth=2)
    chart.set(xlim=(-18, 10), ylim=(-14, 14))
    chart.legend(loc="upper left")
    seconds = np.linspace(0, direct.time, 50)
    plot.along(over_time, seconds, np.degrees(direct.law.at(seconds)[:, crossing.kin.workpiece_side]), "direct")
    (line,) = over_time.plot([], [], plot.STYLE["aside"], color=plot.COLOUR["aside"], linewidth=2)
    over_time.set(xlabel="time, s", ylabel=f"{name}, degrees")

    def update(degrees: float) -> list[str]:
        way = crossing.way("aside", lean=np.radians(degrees))
        if way.law is None:
            return [way.reason]
        _, axes = kin.forward(way.joints[:: max(1, len(way.joints) // 60)])
        moved.set_data(*plot.on_pole_map(kin, axes))
        seconds = np.linspace(0, way.time, 50)
        line.set_data(seconds, np.degrees(way.law.at(seconds)[:, crossing.kin.workpiece_side]))
        peaks = f"C up to {np.degrees(way.peak_speed):.0f}°/s and {np.degrees(way.peak_acceleration):.0f}°/s²"
        return [f"{way.time:.2f} s, {peaks}, tool axis off by {np.degrees(way.axis_error):.2f}°"]

    return recorded(figure, update, slider("moved by", 0.25, MOVED_MOST, 1.0, step=0.25), height=500)
