"""Sliders that drive one picture.

A figure is made once, its artists are moved and it is drawn into an `ipywidgets.Image`: twice as fast as a new
figure for each position, and nothing but ipywidgets and matplotlib is needed.
"""

import base64
import io
import math

import ipywidgets
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mathpost import euler, plot, positioning
from mathpost.alignment import align
from mathpost.axis_angle import to_axis_angle, to_quaternion
from mathpost.frame import Frame, machine_frames
from mathpost.rotation import ACTIVE, zxz_steps
from mathpost.tilted_plane import Plane


class View(ipywidgets.VBox):
    """Sliders above a picture and a line of numbers.

    Parameters
    ----------
    build : callable
        ``build(figure)`` draws the picture's artists once and returns ``update(**values)``, which moves them
        to the sliders' values and returns the line of numbers as HTML, or None.
    sliders : dict
        Name (a Python identifier, the keyword of `update`) to ``(low, high, start)`` or
        ``(low, high, start, step)``; the label is the name with blanks for underscores.
    size : tuple of 2 floats, keyword only
        Inches, drawn at 72 dots to the inch.

    Examples
    --------
    >>> def build(figure):
    ...     line, = figure.subplots().plot([0, 1], [0, 0])
    ...     def update(height):
    ...         line.set_ydata([0, height])
    ...         return f"height {height:.1f}"
    ...     return update
    >>> view = View(build, {"height": (0, 1, 0.5)})
    >>> view.numbers.value
    'height 0.5'
    >>> view.sliders["height"].value = 0.8
    >>> view.numbers.value
    'height 0.8'
    """

    def __init__(self, build, sliders, *, size=(7.0, 4.2)):
        self.figure = Figure(figsize=size, dpi=72, layout="constrained")
        FigureCanvasAgg(self.figure)
        self.update = build(self.figure)
        self.sliders = {name: _slider(name, *limits) for name, limits in sliders.items()}
        self.image = ipywidgets.Image(format="png", layout=ipywidgets.Layout(width=f"{size[0] * 100:.0f}px"))
        self.numbers = ipywidgets.HTML()
        self.redraw()
        for slider in self.sliders.values():
            slider.observe(self.redraw, names="value")
        super().__init__([*self.sliders.values(), self.image, self.numbers])

    def redraw(self, _change=None):
        """Move the artists to the sliders' values and draw."""
        self.numbers.value = self.update(**{name: s.value for name, s in self.sliders.items()}) or ""
        png = io.BytesIO()
        self.figure.savefig(png, format="png")
        self.image.value = png.getvalue()

    def _repr_mimebundle_(self, **options):
        """Add the picture itself, for a reader who has no running kernel."""
        bundle = super()._repr_mimebundle_(**options)
        return {**bundle, "image/png": base64.b64encode(self.image.value).decode()}

    def __repr__(self):
        return f"View({', '.join(self.sliders)})"


def _slider(name, low, high, start, step=None):
    return ipywidgets.FloatSlider(
        description=name.replace("_", " "),
        min=low,
        max=high,
        value=start,
        step=step or 10.0 ** math.floor(math.log10((high - low) / 100)),
        layout=ipywidgets.Layout(width="600px"),
        style={"description_width": "120px"},
    )


def tool_in_workpiece(kin):
    """Two sliders for the rotary axes of a machine, and the tool axis as the workpiece sees it."""
    names = kin.machine.joint_names[3:]
    limits = np.degrees(kin.machine.limits[3:].clip(-np.pi, np.pi))

    def build(figure):
        axes = figure.add_subplot(projection="3d")
        plot.frame(axes, np.eye(3), np.zeros(3), colour=plot.COLOUR["workpiece"], length=0.8)
        (tool,) = axes.plot([0, 0], [0, 0], [0, 1], color=plot.COLOUR["tool"], linewidth=4)
        (trace,) = axes.plot([], [], [], color=plot.COLOUR["machine"], linewidth=1)
        axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-0.2, 1.2), xticks=[], yticks=[], zticks=[])
        axes.set_box_aspect((2, 2, 1.4))

        def update(**angles):
            joints = np.zeros((91, 5))
            joints[:, 3:] = list(angles.values())
            inner = names.index(str(kin.inverse_symbolic.inner))
            joints[:-1, 3 + inner] = np.linspace(*limits[inner], 90)
            _, axis = kin.forward(joints, degrees=True)
            trace.set_data_3d(*axis[:-1].T)
            tool.set_data_3d(*np.stack([np.zeros(3), axis[-1]], axis=1))
            return f"tool axis i j k = {axis[-1, 0]:z.4f} {axis[-1, 1]:z.4f} {axis[-1, 2]:z.4f}"

        return update

    sliders = {name: (*travel, 30.0, 1.0) for name, travel in zip(names, limits, strict=True)}
    return View(build, sliders, size=(6.0, 4.2))


def past_the_pole(kin):
    """A tool that tilts over in a plane at a distance from the pole: both branches of both rotary axes."""
    tilt = np.radians(np.linspace(-20, 20, 201))
    pole = np.array(kin.inverse_symbolic.pole, dtype=float)
    side = np.eye(3)[np.abs(pole).argmin()]
    across = np.cross(pole, side)
    names = kin.machine.joint_names[3:]

    def build(figure):
        panels = figure.subplots(2, 1, sharex=True)
        lines = {}
        for axis, panel in enumerate(panels):
            for branch, role in enumerate(("first branch", "second branch")):
                (lines[axis, branch],) = panel.plot(
                    np.degrees(tilt), tilt, color=plot.COLOUR[role], linestyle=plot.STYLE[role], label=role
                )
            panel.set(ylabel=f"{names[axis]}, degrees", ylim=(-200, 200) if axis else (-60, 60))
        inner = names.index(str(kin.inverse_symbolic.inner))
        panels[inner].set_ylim(-60, 60)
        panels[1 - inner].set_ylim(-400, 400)
        panels[0].legend(loc="upper right")
        panels[1].set_xlabel("tilt of the tool in its plane, degrees")

        def update(distance):
            plane = np.cos(np.radians(distance)) * pole + np.sin(np.radians(distance)) * across
            axes = np.cos(tilt)[:, None] * plane + np.sin(tilt)[:, None] * side
            angles = np.unwrap(kin.inverse([0, 0, 0], axes)[..., 3:], axis=0)
            for (axis, branch), line in lines.items():
                line.set_ydata(np.degrees(angles[:, branch, axis]))
            fastest = np.abs(np.diff(angles[:, 0, 1 - inner])).max() / (tilt[1] - tilt[0])
            return f"at {distance:.2f}° from the pole the outer axis turns up to {fastest:.1f}° per degree of tilt"

        return update

    return View(build, {"distance": (0.05, 10.0, 3.0, 0.05)}, size=(7.0, 4.6))


def moved_aside(crossing, *, most=5.0):
    """The outer axis through a singular region, with the tool axis moved aside by up to a slider's degrees."""
    direct = crossing.way("direct")

    def build(figure):
        panel = figure.subplots()
        plot.along(panel, direct.place + 1, np.degrees(direct.joints[:, crossing.outer]), "published", "as chosen")
        (line,) = panel.plot([], [], color=plot.COLOUR["first branch"], label="tool axis moved aside")
        panel.set(xlabel="record", ylabel=f"{crossing.kin.machine.joint_names[crossing.outer]}, degrees")
        panel.legend()

        def update(degrees):
            way = crossing.way("aside", lean=np.radians(degrees))
            if way.reason:
                line.set_data([], [])
                return way.reason
            line.set_data(way.place + 1, np.degrees(way.joints[:, crossing.outer]))
            return (
                f"peak {np.degrees(way.peak_rate):.0f}° per {'record' if way.per_record else 's'}, "
                f"tool axis off by {np.degrees(way.axis_error):.2f}°, {way.blocks} blocks"
            )

        return update

    return View(build, {"degrees": (0.1, most, 1.0, 0.1)})


# Frames and tilted planes

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
            axis, angle = to_axis_angle(frame.rotation, degrees=True)
            axle.set_data_3d(*np.stack([-axis, axis], axis=-1))
            lines = [
                f"axis ({', '.join(f'{value:z.4f}' for value in axis)}), angle {angle:.3f} (dashed)",
                f"quaternion ({', '.join(f'{value:z.4f}' for value in to_quaternion(frame.rotation))})",
            ]
            for dialect in ("G68.2", "PLANE SPATIAL", "AROT RPY"):
                plane = Plane.from_frame(frame, dialect)
                words = ", ".join(f"{w} {v:z.3f}" for w, v in zip(plane.words, plane.values, strict=True))
                lines.append(f"{dialect}: {words}{' (locked)' if plane.locked else ''}")
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
        tool = plot.Wire(axes, plot.cutter(6, 90), color=_TOOL, lw=1)

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
