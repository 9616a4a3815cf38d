"""Views with sliders for lessons 01 to 04: rotations, frames, the tilted plane, the chain."""

import numpy as np

from mathpost import angles as euler
from mathpost.draw import plot
from mathpost.draw.widget import View
from mathpost.frame import Frame, machine_frames
from mathpost.plane import positioning
from mathpost.plane.alignment import align
from mathpost.plane.tilted_plane import Plane
from mathpost.rotation import ACTIVE, zxz_steps

_MACHINE, _WORKPIECE, _TOOL = (plot.COLOUR[role] for role in ("machine", "workpiece", "tool"))


def turned_point(point):
    """A point in the initial frame and in the one that ZXZ angles turn: sliders alpha, beta, gamma in degrees."""
    point = np.asarray(point, dtype=float)

    def build(figure):
        axes = figure.add_subplot(projection="3d")
        plot.space(axes, 0.62 * np.linalg.norm(point), centre=point / 3, azimuth=-62)
        size = 0.75 * np.linalg.norm(point)
        plot.Triad(axes, colour=_MACHINE, length=size).move(Frame(np.eye(3)))
        turned = plot.Triad(axes, colour=_WORKPIECE, length=size, labels=("X'", "Y'", "Z'"), lw=2)
        axes.plot(*zip([0, 0, 0], point, strict=True), color=_TOOL, ls=":")
        axes.plot(*point[:, None], "o", color=_TOOL)
        axes.text(*(1.08 * point), "P", color=_TOOL)
        feet = plot.Wire(axes, np.zeros((5, 3)), color=_TOOL, lw=1)

        def update(alpha, beta, gamma):
            frame = Frame(euler.matrix("ZXZ", [alpha, beta, gamma], degrees=True))
            turned.move(frame)
            x, y, z = frame.inverse().point(point)
            feet.points = np.array([[0, 0, 0], [x, 0, 0], [x, y, 0], [x, y, z], [0, 0, z]])
            feet.move(frame)
            wrong = zxz_steps("right", (alpha, beta, gamma), point, elementary=ACTIVE, degrees=True)[-1].value
            return (
                f"in the turned frame: x' = {x:z.6f}, y' = {y:z.6f}, z' = {z:z.6f}"
                f"<br>with active elements: {', '.join(f'{value:z.6f}' for value in wrong)}"
            )

        return update

    sliders = {"alpha": (-180, 180, 135), "beta": (0, 180, 54.7356), "gamma": (-180, 180, -90)}
    return View(build, sliders)


def notations():
    """One frame in many notations: sliders I, J, K, the ZXZ angles in degrees."""

    def build(figure):
        axes = figure.add_subplot(projection="3d")
        plot.space(axes, 0.95)
        plot.Triad(axes, colour=_MACHINE).move(Frame(np.eye(3)))
        turned = plot.Triad(axes, colour=_WORKPIECE, labels="xyz", lw=2)
        (axle,) = axes.plot([], [], [], color=_TOOL, ls="--")

        def update(I, J, K):  # noqa: E741
            frame = Frame(euler.matrix("ZXZ", [I, J, K], degrees=True))
            turned.move(frame)
            axis, angle = euler.to_axis_angle(frame.rotation, degrees=True)
            axle.set_data_3d(*np.stack([-axis, axis], axis=-1))
            lines = [
                f"axis ({', '.join(f'{value:z.4f}' for value in axis)}), angle {angle:.3f} (dashed)",
                f"quaternion ({', '.join(f'{value:z.4f}' for value in euler.to_quaternion(frame.rotation))})",
            ]
            for notation in ("G68.2", "PLANE SPATIAL", "AROT RPY"):
                plane = Plane.from_frame(frame, notation)
                words = ", ".join(f"{w} {v:z.3f}" for w, v in zip(plane.words, plane.values, strict=True))
                lines.append(f"{notation}: {words}{' (locked)' if plane.locked else ''}")
            return "<br>".join(lines)

        return update

    return View(build, {"I": (-180, 180, 135), "J": (0, 180, 54.7356), "K": (-180, 180, -90)})


def third_angle(machine, i, j, *, radius=10.0, retract=1.0, run_out=0.02):
    """Looking along Z onto a tilted plane: what the third angle, slider K, does to a boring bar and to a probe.

    The spindle stops with the bar's tip along its own X, and the control retracts by `retract` against the
    feature's X; a stylus runs out by `run_out` along the spindle's X, and the control corrects along the
    feature's. Both are right only if the spindle's X is the feature's. The rotary axes go where SEQ+ sends them.
    Lengths in mm, angles in degrees.
    """
    turn = np.linspace(0, 2 * np.pi, 181)
    circle = np.stack([np.cos(turn), np.sin(turn)])

    def build(figure):
        bore, probe = figure.subplots(1, 2)
        for axes, title in (
            (bore, "boring bar, retracted along −X"),
            (probe, "stylus ball, believed (dotted) and true"),
        ):
            axes.set(title=title, aspect="equal", xlim=(-1.55, 1.55), ylim=(-1.55, 1.55))
            axes.set_axis_off()
            for direction, label in zip(np.eye(2), "XY", strict=True):
                axes.annotate("", 1.3 * direction, (0, 0), arrowprops={"arrowstyle": "->", "color": _WORKPIECE})
                axes.text(*(1.42 * direction), label, color=_WORKPIECE, ha="center", va="center")
        bore.plot(*circle, color=_WORKPIECE)
        (bar,) = bore.fill([], [], color=_TOOL, alpha=0.35)
        (tip,) = bore.plot([], [], color=_TOOL, lw=5)
        (seen,) = probe.plot([], [], color=_WORKPIECE, ls=":")
        (ball,) = probe.plot([], [], color=_TOOL)
        arrows = [
            (
                axes.plot([], [], color=_MACHINE, lw=2)[0],
                axes.text(0, 0, "", color=_MACHINE, ha="center", va="center"),
            )
            for axes in (bore, probe)
        ]

        def update(K):
            plane = Plane("G68.2", [i, j, K])
            choice = positioning.heidenhain(align(plane.frame, machine), (0, 0), seq="+")
            angle = -np.deg2rad(choice.rho)  # from the feature's X to the spindle's
            spindle = np.array([np.cos(angle), np.sin(angle)])
            for line, text in arrows:
                line.set_data(*np.stack([0.4 * spindle, 1.15 * spindle], axis=-1))
                text.set(position=1.05 * spindle + 0.2 * spindle[::-1] * [1, -1], text="X$_S$")
            shift = np.array([-0.25, 0])  # not to scale
            bar.set_xy((0.6 * circle + shift[:, None]).T)
            tip.set_data(*np.stack([0.6 * spindle + shift, spindle + shift], axis=-1))
            clearance = radius - np.hypot(*(radius * spindle - [retract, 0]))
            ball.set_data(*(0.3 * circle + 0.35 * spindle[:, None]))
            seen.set_data(*(0.3 * circle + [[0.35], [0]]))
            error = run_out * np.hypot(*(spindle - [1, 0]))
            state = "clear of the wall" if clearance > 0 else "IN THE WALL"
            return (
                f"{', '.join(f'{r.name} {a:z.3f}' for r, a in zip(machine.rotary, choice.angles, strict=True))}"
                f", ρ = {choice.rho:z.3f}<br>tip after the retract: {clearance:z.3f} mm {state}"
                f"<br>centre measured by the probe: wrong by {1000 * error:.1f} µm"
            )

        return update

    return View(build, {"K": (-180, 180, -90)}, size=(7.0, 4.0))


def carried(machine):
    """What each rotary axis of a machine carries: sliders named after the two axes, and sense.

    With sense −1 both axes turn against their programmed angle: a table taken for a head, or a head for a table.
    """
    names = [rotary.name for rotary in machine.rotary]
    outer = 1 if machine.arrangement == "table-table" else 0

    def build(figure):
        axes = figure.add_subplot(projection="3d")
        plot.space(axes, 85.0)
        plot.Triad(axes, colour=_MACHINE, length=75).move(Frame(np.eye(3)))
        block = plot.Wire(axes, plot.box(100, 70, 40) - [0, 0, 40], color=_WORKPIECE)
        feature = plot.Triad(axes, colour=_WORKPIECE, length=60, labels="xyz", lw=2)
        tool = plot.Wire(axes, plot.tool_outline(6, 90), color=_TOOL, lw=1)

        def update(sense=1.0, **angles):
            turned = [np.sign(sense) * angles[name] for name in names]
            workpiece, tip = machine_frames(machine, [0, 0, 0, *turned], degrees=True)
            # Seen with the pivots together: what turns is in question here, not where.
            block.move(Frame(workpiece.rotation))
            feature.move(Frame(workpiece.rotation))
            tool.move(Frame(tip.rotation))
            axis = (workpiece.inverse() @ tip).z
            return f"tool axis in the workpiece: ({', '.join(f'{value:z.4f}' for value in axis)})"

        return update

    travel = {name: (-180, 180, 130 if name == names[outer] else 30) for name in names}
    return View(build, {**travel, "sense": (-1, 1, 1, 2)})
