"""Views with sliders for lessons 05 to 07: paths past the pole."""

import numpy as np
import sympy as sp

from mathpost.course.lesson_data import with_travel
from mathpost.draw import plot
from mathpost.draw.chart import printed, recorded, subplots
from mathpost.draw.formula import slider
from mathpost.post import selection

KEPT = np.radians(0.05)  # from the pole: where the branch may change if the tool axis is to be kept


def inner_and_outer(kin):
    """One tool axis seen from the side and along the outer axis, which is Z: sliders outer and inner angle.

    From the side one sees what the inner angle alone decides, along the axis what the outer angle does.
    """
    inner, outer, n = kin.inverse_symbolic.inner, kin.inverse_symbolic.outer, kin.forward_symbolic()[:3, 2]
    w = n.subs(outer, 0)
    products = (w[0] * n[1] - w[1] * n[0], w[0] * n[0] + w[1] * n[1])

    figure, (side, top) = subplots(1, 2, size=(8.0, 4.4))
    turn = np.linspace(0, 2 * np.pi, 37)
    side.plot(np.cos(turn), np.sin(turn), color=plot.COLOUR["machine"], linewidth=0.8)
    side.plot([0, 0], [-1.2, 1.2], color=plot.COLOUR["machine"])
    square = {"xlim": (-1.25, 1.25), "ylim": (-1.25, 1.25), "aspect": "equal"}
    side.set(xlabel="from the side: across the outer axis", ylabel="k, along the outer axis", **square)
    top.set(xlabel="along the outer axis: i", ylabel="j", **square)
    moving, ends = plot.Moving(), [(-w[1], w[2]), (w[1], w[2])]
    moving.line(side, "published", ends, ":")
    moving.line(side, "first branch", [(0, 0), ends[0]], label=f"{inner}", linewidth=2.5)
    moving.line(side, "second branch", [(0, 0), ends[1]], "--", label=f"−{inner}", linewidth=2.5)
    moving.line(top, "published", [tuple(n.subs(outer, angle)[:2]) for angle in turn], ":", label="same k")
    arc = [tuple(n.subs(outer, outer * m / 18)[:2, 0] / 2) for m in range(19)]
    moving.line(top, "workpiece", arc, label=f"{outer}")
    moving.line(top, "machine", [(0, 0), tuple(w[:2])], label=f"w, at {outer} = 0", linewidth=2.5)
    moving.line(top, "tool", [(0, 0), tuple(n[:2])], label="n, the tool axis", linewidth=2.5)
    figure.legend(loc="outside lower center", ncols=6, fontsize=8)
    said = "sine product {:4}, cosine product {:4}, atan2 of the two {:2}°"
    text = [("i = {:4}, j = {:4}, k = {:4}", *n), (said, *products, sp.deg(sp.atan2(*products)))]
    sliders = [slider(f"{outer}", -180, 180, 125), slider(f"{inner}", -90, 90, 50)]
    return printed(figure, moving, (outer, inner), sliders, text, height=530)


def past_the_pole(kin):
    """A tool that tilts over in a plane at a distance from the pole: both branches of both rotary axes."""
    tilts = np.sort(np.r_[20 * np.linspace(-1, 1, 41) ** 3, -0.5, 0.5])  # dense where the outer axis turns
    pole, names = np.array(kin.inverse_symbolic.pole, dtype=float), kin.machine.joint_names[3:]
    side = np.eye(3)[np.abs(pole).argmin()]
    across = np.cross(pole, side)
    inner = names.index(str(kin.inverse_symbolic.inner))

    (figure, panels), lines = subplots(2, 1, size=(7.0, 4.6), sharex=True), {}
    for axis, panel in enumerate(panels):
        for branch, role in enumerate(("first branch", "second branch")):
            (lines[axis, branch],) = panel.plot(tilts, tilts, plot.STYLE[role], color=plot.COLOUR[role], label=role)
        panel.set(ylabel=f"{names[axis]}, degrees", ylim=(-60, 60) if axis == inner else (-280, 280))
    panels[0].legend(loc="upper center", ncols=2)
    panels[1].set_xlabel("tilt of the tool in its plane, degrees")

    def update(distance):
        plane = np.cos(np.radians(distance)) * pole + np.sin(np.radians(distance)) * across
        axes = np.outer(np.cos(np.radians(tilts)), plane) + np.outer(np.sin(np.radians(tilts)), side)
        angles = np.degrees(np.unwrap(kin.inverse([0, 0, 0], axes)[..., 3:], axis=0))
        angles -= 360 * np.rint(angles[len(tilts) // 2] / 360)
        for (axis, branch), line in lines.items():
            line.set_ydata(angles[:, branch, axis])
        turned = np.abs(np.diff(angles[:, 0, 1 - inner]))
        middle = turned[(tilts[:-1] >= -0.5) & (tilts[1:] <= 0.5)].sum()
        far = f"{distance:.1f}° from the pole: {names[1 - inner]} turns by {turned.sum():.1f}°"
        return [f"{far}, by {middle:.1f}° of it while the tool tilts by 1°"]

    return recorded(figure, update, slider("distance", 0.1, 6.0, 3.0, step=0.1), height=520)


def travel_limit(kin, cl, records, high):
    """What each strategy chooses if the tilting axis, the first one, may go down to a slider's angle.

    The tool may lean between two records, except on the way "kept", the best that keeps the tool axis. `high` is
    the other limit, degrees.
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
    lines, dots = {}, {}
    for way in ways:
        plot.along(price, list(found), [each[way].cost for each in found.values()], way)
        (lines[way],) = tilt.plot(places, places, plot.STYLE[way], linewidth=2.5, color=plot.COLOUR[way])
        (dots[way],) = price.plot([], [], "o", color=plot.COLOUR[way])
    figure.legend(loc="outside lower center", ncols=6, fontsize=8)

    def update(low):
        lowest.set_ydata([low, low])
        for shift, (way, chosen) in enumerate(found[low].items()):
            lines[way].set_ydata(np.degrees(chosen.joints[:, 3]) + 0.5 * (1 - shift))
            dots[way].set_data([low], [chosen.cost])
        costs = ", ".join(f"{way} {chosen.cost:.3f} s" for way, chosen in found[low].items())
        return [f"{name} from {low:.0f}°: {costs}"]

    return recorded(figure, update, slider(f"{name} from", -30, 0, -5, step=1), height=520)
