"""Sliders that drive one picture.

A figure is made once, its artists are moved and it is drawn into an `ipywidgets.Image`: twice as fast as a new
figure for each position, and nothing but ipywidgets and matplotlib is needed.
"""

import io
import math

import ipywidgets
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mathpost import curve, plot
from mathpost.compensation import total_differential


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


def knot_choice(measured):
    """A slider over the number of knots of `mathpost.curve.Points`: chosen adaptively, and equally far apart."""
    order = curve.adaptive(measured, np.finfo(float).tiny).knots
    fewest = 2 if measured.period is None else 3
    possible = [count for count in range(fewest, len(measured.at) + 1) if _divides(measured, count)]

    def build(figure):
        axes = figure.subplots()
        at = np.linspace(measured.at[0], measured.at[-1], 500)
        axes.plot(measured.at, measured.values, "x", color=plot.COLOUR["published"], markersize=4)
        lines = {}
        for name, role in (("adaptive", "first branch"), ("uniform", "second branch")):
            lines[name] = (
                axes.plot([], [], plot.STYLE[role], color=plot.COLOUR[role], label=name)[0],
                axes.plot([], [], "o", color=plot.COLOUR[role], fillstyle="none")[0],
            )
        axes.set(xlabel="angle, deg", ylabel="error, arcsec", ylim=_with_margin(measured.values))
        axes.legend()

        def update(knots):
            fewer = max(count for count in possible if count <= knots)
            fits = {
                "adaptive": curve.Curve(measured, order[: int(knots)]),
                "uniform": curve.uniform(measured, fewer),
            }
            for name, fitted in fits.items():
                chosen = sorted(fitted.knots)
                lines[name][0].set_data(at, fitted(at))
                lines[name][1].set_data(measured.at[chosen], measured.values[chosen])
            return "; ".join(
                f"{name}: {len(fitted.knots)} knots, residual {fitted.residual:.3f} arcsec"
                for name, fitted in fits.items()
            )

        return update

    return View(build, {"knots": (fewest, len(order), 6, 1)})


def towards_the_pole(compensator, joints, tilt):
    """A slider that takes joint number `tilt` of `joints` (radians) to zero: one step there, whole and limited.

    `compensator` is a `mathpost.compensation.Compensator`; the slider is the logarithm of the tilt in degrees.
    """
    degrees = np.logspace(1.5, -3, 181)
    path = np.tile(joints, (len(degrees), 1))
    path[:, tilt] = np.deg2rad(degrees)
    wanted, errors = compensator.wanted(path), compensator.errors.at(path)
    whole, _ = total_differential(compensator.model, path, errors)
    curves = {
        "before": ("machine", compensator.miss(path, wanted).tip),
        "one whole step": ("second branch", compensator.miss(path + whole, wanted).tip),
        "limited": ("first branch", compensator.compensate(path).after.tip),
    }

    def build(figure):
        axes = figure.subplots()
        for name, (role, tip) in curves.items():
            axes.loglog(
                degrees,
                1e3 * np.maximum(tip, 1e-8),
                plot.STYLE.get(role, "-."),
                color=plot.COLOUR[role],
                label=name,
            )
        marks = [axes.plot([], [], "o", color=plot.COLOUR[role])[0] for role, _ in curves.values()]
        axes.set(xlabel="tilt, deg", ylabel="error at the tip, µm")
        axes.invert_xaxis()
        axes.legend()

        def update(log_tilt):
            at = int(np.argmin(np.abs(np.log10(degrees) - log_tilt)))
            for mark, (_, tip) in zip(marks, curves.values(), strict=True):
                mark.set_data([degrees[at]], [1e3 * max(tip[at], 1e-8)])
            turn = np.rad2deg(np.abs(whole[at, 3:]).max())
            said = "; ".join(f"{name} {1e3 * tip[at]:.3f} µm" for name, (_, tip) in curves.items())
            return f"tilt {degrees[at]:.4f} deg: {said}; the whole step turns {turn:.4f} deg"

        return update

    return View(build, {"log_tilt": (-3, 1.5, 1.5, 0.025)})


def _divides(measured, count):
    gaps = len(measured.at) - (measured.period is None)
    return gaps % (count - (measured.period is None)) == 0


def _with_margin(values):
    margin = 0.1 * np.ptp(values)
    return values.min() - margin, values.max() + margin
