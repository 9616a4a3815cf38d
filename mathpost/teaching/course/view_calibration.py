"""Views with sliders for lessons 08 to 13b: datum, head, rotation centre, RTCP zero, knots, compensation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from mathpost.shop.compensate.compensation import Compensator, total_differential
from mathpost.shop.measure import horizontal_head, rotary_axis, spline, work_offset
from mathpost.shop.measure.fit import Measurement, coverage_factor
from mathpost.teaching.draw import plot
from mathpost.teaching.draw.curves import Moving, printed, recorded, subplots
from mathpost.teaching.draw.live import Live, slider

if TYPE_CHECKING:
    from mathpost.machine import Rotary
    from mathpost.shop.measure.horizontal_head import FittedHead
    from mathpost.shop.measure.spline import Points

K = float(coverage_factor(np.inf))  # U = K u where the noise is known


def datum_after_rotation(centre_a: Sequence[float], centre_b: Sequence[float], point: Sequence[float]) -> Live:
    """A point of the part moved by A and B, for both stack orders, and for one common centre."""
    tables = {order: work_offset.ab_table(centre_a, centre_b, order=order) for order in ("AB", "BA")}
    common = (centre_b[0], centre_a[1], centre_b[2])
    tables["AB, one centre"] = work_offset.ab_table(common, common, order="AB")
    symbols = sp.symbols("A B", real=True)
    paths = {}
    for name, table in tables.items():
        place, free = work_offset.moved_symbolic(table)
        moved = sp.lambdify(free, place, "sympy")
        to = [[*map(float, axis.point), 0, symbols["AB".index(axis.name)]] for axis in table]
        ways = ([k / 20 * x if x in symbols else x for axis in to for x in axis] for k in range(21))
        paths[name] = [moved(*map(float, point), *way) for way in ways]

    (figure, views), moving = subplots(1, 2, size=(8.0, 4.2)), Moving()
    for axes, (across, centre) in zip(views, ((0, centre_b), (1, centre_a)), strict=True):
        reach = 1.1 * max(np.linalg.norm(np.subtract(point, c)) for c in (centre_a, centre_b))
        axes.plot(centre[across], centre[2], "+", color=plot.COLOUR["machine"], markersize=12)
        axes.plot(point[across], point[2], "o", color=plot.COLOUR["workpiece"], fillstyle="none")
        axes.set(xlim=centre[across] + reach * np.array([-1, 1]), ylim=centre[2] + reach * np.array([1, -1]))
        title = f"seen from {plot.viewer('XY'[across], '-Z')}"
        axes.set(xlabel=f"{'XY'[across]} (mm)", ylabel="Z (mm)", title=title, aspect="equal")
        for (name, points), role in zip(paths.items(), ("first branch", "second branch", "published"), strict=True):
            seen = [(point[across], point[2]) for point in points]
            moving.line(axes, role, seen, plot.STYLE[role], marker="o", markevery=[-1], label=name)
    figure.legend(*views[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    sliders = [slider("A", -90, 90, -30), slider("B", -180, 180, 70)]
    text = [(f"{name}: X{{:3}} Y{{:3}} Z{{:3}}", *points[-1]) for name, points in paths.items()]
    return printed(figure, moving, symbols, sliders, text, height=540)


def five_face_head(fitted: FittedHead) -> Live:
    """A horizontal head seen from above: its frame, its vector, and the error of the printed program."""
    table = fitted.head()
    figure, axes = subplots(size=(6.0, 5.0))
    reach = 1.5 * np.linalg.norm(table.vectors[0, :2])
    axes.plot(*table.vectors[:, :2].T, color=plot.COLOUR["machine"], linewidth=0.8)
    axes.plot(*fitted.measured.vectors[:, :2].T, "o", color=plot.COLOUR["published"], label="measured")
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="X (mm)", ylabel="Y (mm)", aspect="equal")
    looks = {"tool": (3, "U, from vertical to horizontal head"), "first branch": (2, "X'"), "workpiece": (2, "Z'")}
    for role, (width, label) in looks.items():
        axes.plot([], [], color=plot.COLOUR[role], linewidth=width, label=label)
    arm, *arrows = axes.lines[-3:]
    figure.legend(loc="outside lower center", ncols=4, fontsize=8)

    def update(angle: float) -> list[str]:
        measured = angle % 360 in fitted.measured.angles
        head, kind = (fitted.measured, "measured") if measured else (table, "predicted")
        vector = head.vector(angle)
        frame = horizontal_head.lhy(head, (0, 0, 0), angle)
        arm.set_data(*np.array([(0, 0), vector[:2]]).T)
        for arrow, direction in zip(arrows, frame.rotation.T[[0, 2]], strict=True):
            arrow.set_data(*np.array([vector[:2], vector[:2] + 120 * direction[:2]]).T)
        off = np.linalg.norm(vector - fitted.measured.vectors[0])
        return [*frame.block.splitlines(), f"{kind}; U₀ in its place would be {off:.2f} mm off"]

    return recorded(figure, update, slider("angle", 0, 360, 45, step=2.5), height=560)


def _fit(
    measurement: Measurement, errors: Sequence[sp.Expr], at: Sequence[Sequence[sp.Expr]], sigma: sp.Expr
) -> tuple[list[list[sp.Expr]], list[sp.Expr], list[sp.Expr]]:
    """Return noisy readings, the errors found from them to first order, and their standard deviations.

    This is the first step of a fit from zero; for errors of some hundredths of a mm the next steps change less than
    0.01 µm. `errors` are the true values of the unknowns, `at` the settings of each reading, `sigma` its standard
    deviation, all sympy expressions in mm and radians.
    """
    random, unknowns, zero = np.random.default_rng(1), measurement.unknowns, dict.fromkeys(measurement.unknowns, 0)
    read, noise, slopes = [], [], []
    for kind in measurement.readings.values():
        reading = sp.lambdify((*unknowns, *measurement.settings), kind, "sympy")
        slope = sp.lambdify(measurement.settings, [kind.diff(each).subs(zero) for each in unknowns], "sympy")
        normal = random.standard_normal(len(at))
        read.append([reading(*errors, *values) + sigma * x for values, x in zip(at, normal, strict=True)])
        slopes += [slope(*values) for values in at]
        noise += list(normal)
    slopes = sp.Matrix(slopes)
    normal = slopes.T * slopes
    inverse = normal.adjugate() / normal.det()  # `inv` would spend seconds on proving that there is one
    found = sp.Matrix(errors) + sigma * inverse * (slopes.T * sp.Matrix(noise))
    return read, list(found), [sigma * sp.sqrt(entry) for entry in inverse.diagonal()]


def rotation_centre(rotary: Rotary) -> Live:
    """A C axis with errors: a ball on its table is measured over a turn, and the errors are recovered."""
    radius, heights = 150.0, (50.0, 350.0)
    ball = rotary_axis.ball(rotary)
    names, symbols = [str(symbol) for symbol in ball.unknowns], (*ball.unknowns, sp.Symbol("noise", real=True))
    at = [(float(np.radians(30 * k)), radius, 0.0, height) for height in heights for k in range(12)]
    scale = (1000, 1000, 10**6, 10**6)  # the sliders are in µm and µrad, the formulas in mm and radians
    set_to = [symbol / factor for symbol, factor in zip(symbols, scale, strict=False)]
    read, found, deviation = _fit(ball, set_to, at, symbols[-1] / 1000)
    got = [factor * value for factor, value in zip(scale, found, strict=True)]
    spread = [K * factor * value for factor, value in zip(scale, deviation, strict=True)]

    (figure, (left, right)), moving = subplots(1, 2, size=(8.0, 4.0)), Moving()
    for marker, height, part in zip("ox", heights, (slice(12), slice(12, 24)), strict=True):
        dots = [(1000 * x, 1000 * y) for x, y in zip(read[0][part], read[1][part], strict=True)]
        moving.line(left, "tool", dots, marker, label=f"z = {height:.0f}")
    left.set(xlim=(-130, 130), ylim=(-130, 130), xlabel="e_x (µm)", ylabel="e_y (µm)", aspect="equal")
    moving.line(right, "published", list(enumerate(symbols[:4])), "_", markersize=24, label="true")
    moving.line(right, "workpiece", list(enumerate(got)), "o", label="recovered, ± U (95 %)")
    for place, (value, half) in enumerate(zip(got, spread, strict=True)):
        moving.line(right, "workpiece", [(place, value - half), (place, value + half)])
    right.set(xlim=(-0.5, 3.5), ylim=(-110, 110), xticks=range(4), xticklabels=names, ylabel="µm, µrad")
    for axes in (left, right):
        axes.legend(fontsize=8)
    rows = list(zip(names, (10, -6, -30, 40), ("µm", "µm", "µrad", "µrad"), strict=True))
    sliders = [slider(name, -50, 50, start, unit=unit) for name, start, unit in rows]
    sliders.append(slider("noise", 0, 10, 1, step=0.5, unit="µm"))
    text = ", ".join(f"{name} {{:1}} ± {{:1}} {unit}" for name, _, unit in rows)
    numbers = [number for pair in zip(got, spread, strict=True) for number in pair]
    return printed(figure, moving, symbols, sliders, [(text, *numbers)], height=560)


def rtcp_zero() -> Live:
    """A head with a wrong zero and pivot: tilted to ±ψ with two tools, they are recovered; the source errs."""
    tip, arcsec, lengths = rotary_axis.rtcp_zero(), 3600 * 180 / sp.pi, (500.0, 700.0)
    symbols = alpha, dy, dl, psi, noise = sp.symbols("alpha dy dL psi noise", real=True)
    true = (alpha / arcsec, dy / 1000, dl / 1000)
    at = [(a, length) for length in lengths for a in (psi, -psi)]
    read, found, deviation = _fit(tip, true, at, noise / 1000)
    axial = tip.readings["axial"].subs(dict(zip(tip.unknowns, true, strict=True)))

    (figure, axes), moving = subplots(), Moving()
    roles = ("first branch", "second branch")
    for role, length, (plus, minus) in zip(roles, lengths, (read[0][:2], read[0][2:]), strict=True):
        along = ((a, (float(np.radians(a)), length)) for a in range(-90, 91, 5))
        curve = [(a, 1000 * axial.subs(dict(zip(tip.settings, at, strict=True)))) for a, at in along]
        moving.line(axes, role, curve, label=f"L = {length:.0f}")
        moving.line(axes, role, [(psi * 180 / sp.pi, 1000 * plus), (-psi * 180 / sp.pi, 1000 * minus)], "o")
    axes.set(xlim=(-95, 95), ylim=(-200, 200), xlabel="ψ (degrees)", ylabel="axial reading (µm)")
    axes.legend(fontsize=8)
    source = arcsec * sp.atan(read[0][2] / lengths[1])
    numbers = arcsec * found[0], K * arcsec * deviation[0], 1000 * found[1], 1000 * found[2], source
    sliders = [slider("alpha", -40, 40, 29, unit="″"), *(slider(d, -60, 60, 0, unit="µm") for d in ("dy", "dL"))]
    sliders += [slider("psi", 1, 90, 5), slider("noise", 0, 2, 0, step=0.1, unit="µm")]
    said = "alpha {:1} ± {:1} arcsec, dy {:1} µm, dL {:1} µm; arctan(y/x) of the reading at +ψ: {:1} arcsec"
    return printed(figure, moving, symbols, sliders, [(said, *numbers)], height=620)


def knot_choice(measured: Points) -> Live:
    """Splines through `spline.Points` with a slider for the number of knots: adaptive, and equally spaced."""
    order = spline.adaptive(measured, np.finfo(float).tiny).knots
    closed = measured.period is not None  # if so, the last knot is the first
    fewest, gaps = 2 + closed, len(measured.at) - 1 + closed
    possible = [count for count in range(fewest, len(measured.at) + 1) if gaps % (count - 1 + closed) == 0]

    figure, axes = subplots()
    at = np.linspace(measured.at[0], measured.at[-1], 181)
    axes.plot(measured.at, measured.values, "x", color=plot.COLOUR["published"], markersize=4)
    lines = {}
    for name, role in (("adaptive", "first branch"), ("uniform", "second branch")):
        (curve,) = axes.plot([], [], plot.STYLE[role], color=plot.COLOUR[role], label=name)
        lines[name] = curve, *axes.plot([], [], "o", color=plot.COLOUR[role], fillstyle="none")
    margin = 0.1 * np.ptp(measured.values)
    limits = measured.values.min() - margin, measured.values.max() + margin
    axes.set(xlabel="angle, deg", ylabel="error, arcsec", ylim=limits)
    axes.legend()

    def update(knots: float) -> list[str]:
        fewer, said = max(count for count in possible if count <= knots), []
        fits = spline.Curve(measured, order[: round(knots)]), spline.uniform(measured, fewer)
        for (name, (curve, dots)), fitted in zip(lines.items(), fits, strict=True):
            chosen = sorted(fitted.knots)
            curve.set_data(at, fitted(at))
            dots.set_data(measured.at[chosen], measured.values[chosen])
            said.append(f"{name}: {len(chosen)} knots, residual {fitted.residual:.3f} arcsec")
        return said

    return recorded(figure, update, slider("knots", fewest, len(order), 6, unit=""))


def towards_the_pole(compensator: Compensator, joints: np.ndarray, tilt: int) -> Live:
    """One compensation step, whole and limited, as a slider takes joint number `tilt` of `joints` to zero.

    `joints` are in mm and radians; the slider is the logarithm of the tilt in degrees.
    """
    degrees = np.logspace(1.5, -3, 181)
    path = np.tile(joints, (len(degrees), 1))
    path[:, tilt] = np.deg2rad(degrees)
    wanted = compensator.wanted(path)
    whole, _ = total_differential(compensator.model, path, compensator.errors.at(path))
    curves = {
        "before": ("machine", compensator.miss(path, wanted).tip),
        "one whole step": ("second branch", compensator.miss(path + whole, wanted).tip),
        "limited": ("first branch", compensator.compensate(path).after.tip),
    }

    figure, axes = subplots()
    for name, (role, tip) in curves.items():
        style = "-." if name == "before" else plot.STYLE[role]
        axes.loglog(degrees, 1e3 * np.maximum(tip, 1e-8), style, color=plot.COLOUR[role], label=name)
    marks = [axes.plot([], [], "o", color=plot.COLOUR[role])[0] for role, _ in curves.values()]
    axes.set(xlabel="tilt, deg", ylabel="error at the tip, µm")
    axes.legend()

    def update(log_tilt: float) -> list[str]:
        at = int(np.argmin(np.abs(np.log10(degrees) - log_tilt)))
        for mark, (_, tip) in zip(marks, curves.values(), strict=True):
            mark.set_data([degrees[at]], [1e3 * max(tip[at], 1e-8)])
        turn = np.rad2deg(np.abs(whole[at, 3:]).max())
        said = "; ".join(f"{name} {1e3 * tip[at]:.3f} µm" for name, (_, tip) in curves.items())
        return [f"tilt {degrees[at]:.4f} deg: {said}; the whole step turns {turn:.4f} deg"]

    return recorded(figure, update, slider("log tilt", -3, 1.5, -2, step=0.025, unit=""))
