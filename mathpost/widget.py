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

from mathpost import calibration, curve, datum, five_face, plot
from mathpost.compensation import total_differential
from mathpost.errors import InputError


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


# Lessons 08 to 11: datum, head, calibration


def datum_after_rotation(centre_a, centre_b, point):
    """Turn A and B and see where a point of the part goes: both stack orders, and one centre for both axes."""
    tables = {
        "AB": datum.ab_table(centre_a, centre_b, order="AB"),
        "BA": datum.ab_table(centre_a, centre_b, order="BA"),
    }
    common = (centre_b[0], centre_a[1], centre_b[2])
    tables["AB, one centre"] = datum.with_common_centre(tables["AB"], common)
    colours = (plot.COLOUR["first branch"], plot.COLOUR["second branch"], plot.COLOUR["published"])
    way = np.linspace(0, 1, 60)

    def build(figure):
        views = figure.subplots(1, 2)
        lines = []
        for axes, (across, centre) in zip(views, ((0, centre_b), (1, centre_a)), strict=True):
            reach = 1.1 * max(np.linalg.norm(np.subtract(point, c)) for c in (centre_a, centre_b))
            axes.plot(centre[across], centre[2], "+", color=plot.COLOUR["machine"], markersize=12)
            axes.plot(point[across], point[2], "o", color=plot.COLOUR["workpiece"], fillstyle="none")
            axes.set(xlim=centre[across] + reach * np.array([-1, 1]), ylim=centre[2] + reach * np.array([-1, 1]))
            axes.set(xlabel=f"{'XY'[across]} (mm)", ylabel="Z (mm)", aspect="equal")
            styles = zip(tables, colours, ("-", "--", ":"), strict=True)
            lines.append(
                [axes.plot([], [], s, color=c, marker="o", markevery=[-1], label=n)[0] for n, c, s in styles]
            )
        figure.legend(*views[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)

        def update(A, B):
            text = []
            for index, (name, table) in enumerate(tables.items()):
                path = datum.moved(point, table, {"A": 0, "B": 0}, {"A": A * way, "B": B * way}, degrees=True)
                for across in (0, 1):
                    lines[across][index].set_data(path[:, across], path[:, 2])
                text.append(f"{name}: {datum.words(path[-1])}")
            return "<br>".join(text)

        return update

    return View(build, {"A": (-90, 90, -30, 1), "B": (-180, 180, 70, 1)}, size=(8.0, 4.2))


def five_face_head(fitted):
    """Turn a horizontal head, seen from above: its frame, its vector, and what the printed program would take."""
    table = fitted.head()

    def build(figure):
        axes = figure.subplots()
        reach = 1.5 * np.linalg.norm(table.vectors[0, :2])
        axes.plot(*table.vectors[:, :2].T, color=plot.COLOUR["machine"], linewidth=0.8)
        axes.plot(*fitted.measured.vectors[:, :2].T, "o", color=plot.COLOUR["published"], label="measured")
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="X (mm)", ylabel="Y (mm)", aspect="equal")
        (arm,) = axes.plot(
            [], [], color=plot.COLOUR["tool"], linewidth=3, label="U, from vertical to horizontal head"
        )
        arrows = [
            axes.plot([], [], color=plot.COLOUR[c], linewidth=2, label=n)[0]
            for n, c in (("X'", "first branch"), ("Z'", "workpiece"))
        ]
        figure.legend(loc="outside lower center", ncols=4, fontsize=8)

        def update(angle):
            try:
                head, kind = fitted.measured, "measured"
                vector = head.vector(angle)
            except InputError:
                head, kind = table, "predicted"
                vector = head.vector(angle)
            frame = five_face.lhy(head, (0, 0, 0), angle)
            arm.set_data(*np.array([(0, 0), vector[:2]]).T)
            for arrow, direction in zip(arrows, frame.rotation.T[[0, 2]], strict=True):
                arrow.set_data(*np.array([vector[:2], vector[:2] + 120 * direction[:2]]).T)
            off = np.linalg.norm(vector - fitted.measured.vectors[0])
            block = frame.block.replace("\n", "<br>")
            return f"{block}<br>{kind}; U<sub>0</sub> in its place would be {off:.2f} mm off"

        return update

    return View(build, {"angle": (0, 360, 45, 2.5)}, size=(6.0, 5.0))


def rotation_centre(rotary, radius=150.0, heights=(50.0, 350.0)):
    """Give a C axis errors, let a ball on its table be followed over a turn, and recover them from the readings."""
    ball = calibration.ball(rotary)
    names = [str(symbol) for symbol in ball.unknowns]
    turn = np.arange(0, 360, 30)
    at = {"angle": np.tile(turn, 2), "x": radius, "y": 0.0, "z": np.repeat(heights, len(turn))}

    def build(figure):
        left, right = figure.subplots(1, 2)
        dots = [
            left.plot([], [], m, color=plot.COLOUR["tool"], label=f"z = {h:.0f}")[0]
            for m, h in zip("ox", heights, strict=True)
        ]
        left.set(xlim=(-90, 90), ylim=(-90, 90), xlabel="e_x (µm)", ylabel="e_y (µm)", aspect="equal")
        left.legend(fontsize=8)
        places = np.arange(4)
        (true,) = right.plot(places, 0 * places, "_", color=plot.COLOUR["published"], markersize=24, label="true")
        (found,) = right.plot(places, 0 * places, "o", color=plot.COLOUR["workpiece"], label="recovered, ±3σ")
        bars = right.vlines(places, 0 * places, 0 * places, color=plot.COLOUR["workpiece"])
        right.set(xlim=(-0.5, 3.5), ylim=(-110, 110), xticks=places, xticklabels=names, ylabel="µm, µrad")
        right.legend(fontsize=8)

        def update(noise_μm, **errors):
            values = 1e-6 * np.array(list(errors.values())) * [1e3, 1e3, 1, 1]
            sigma = max(noise_μm, 1e-6) / 1000
            data = ball.simulate(dict(zip(names, values, strict=True)), at, sigma=sigma, seed=1, degrees=True)
            estimate = ball.identify(data, degrees=True, sigma=sigma)
            unit = np.array([1e3, 1e3, 1e6, 1e6])
            got = unit * list(estimate.values.values())
            spread = 3 * unit * np.sqrt(np.diag(estimate.covariance))
            for dot, rows in zip(dots, (slice(None, len(turn)), slice(len(turn), None)), strict=True):
                dot.set_data(1000 * data["ex"][rows], 1000 * data["ey"][rows])
            true.set_ydata(unit * values)
            found.set_ydata(got)
            bars.set_segments([[(p, g - s), (p, g + s)] for p, g, s in zip(places, got, spread, strict=True)])
            units = ("µm", "µm", "µrad", "µrad")
            return ", ".join(
                f"{n} {g:z.1f} ± {s:.1f} {u}" for n, g, s, u in zip(names, got, spread, units, strict=True)
            )

        return update

    sliders = {
        f"{name}_{unit}": (-60, 60, start, 1)
        for name, unit, start in zip(names, ("μm", "μm", "μrad", "μrad"), (10, -6, -30, 40), strict=True)
    }
    return View(build, sliders | {"noise_μm": (0, 10, 1, 0.5)}, size=(8.0, 4.0))


def rtcp_zero(lengths=(500.0, 700.0)):
    """Give a head a wrong zero and pivot, tilt it to ±ψ with two tools, recover them, and see the source err."""
    tip, way = calibration.rtcp_zero(), np.linspace(-90, 90, 91)

    def build(figure):
        axes = figure.subplots()
        colours = (plot.COLOUR["first branch"], plot.COLOUR["second branch"])
        curves = [
            axes.plot(way, 0 * way, color=c, label=f"L = {x:.0f}")[0] for c, x in zip(colours, lengths, strict=True)
        ]
        dots = [axes.plot([], [], "o", color=c)[0] for c in colours]
        axes.set(xlim=(-95, 95), ylim=(-200, 200), xlabel="ψ (degrees)", ylabel="axial reading (µm)")
        axes.legend(fontsize=8)

        def update(alpha_arcsec, dy_μm, dL_μm, psi, noise_μm):
            true = {"alpha": np.deg2rad(alpha_arcsec / 3600), "dy": dy_μm / 1000, "dL": dL_μm / 1000}
            sigma = max(noise_μm, 1e-6) / 1000
            at = {"angle": np.array([psi, -psi] * 2), "L": np.repeat(lengths, 2)}
            data = tip.simulate(true, at, sigma=sigma, seed=1, degrees=True)
            for line, dot, length, rows in zip(curves, dots, lengths, (slice(2), slice(2, 4)), strict=True):
                line.set_ydata(1000 * tip.predict(true, {"angle": way, "L": length}, degrees=True)["axial"])
                dot.set_data(at["angle"][rows], 1000 * data["axial"][rows])
            estimate = tip.identify(data, degrees=True, sigma=sigma)
            arcsec = 3600 * np.rad2deg(1)
            source = arcsec * calibration.source_zero_angle(data["axial"][2], lengths[1])
            spread = 3 * arcsec * estimate.deviation("alpha")
            return (
                f"alpha {arcsec * estimate['alpha']:z.1f} ± {spread:.1f} arcsec, "
                f"dy {1000 * estimate['dy']:z.1f} µm, dL {1000 * estimate['dL']:z.1f} µm; "
                f"arctan(y/x) of the reading at +ψ: {source:z.1f} arcsec"
            )

        return update

    sliders = {
        "alpha_arcsec": (-40, 40, 29, 1),
        "dy_μm": (-60, 60, 0, 1),
        "dL_μm": (-60, 60, 0, 1),
        "psi": (1, 90, 5, 1),
        "noise_μm": (0, 2, 0, 0.1),
    }
    return View(build, sliders)


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
