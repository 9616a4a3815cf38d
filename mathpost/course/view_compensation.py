"""Views with sliders for lessons 12 and 13: knots of a spline, and compensation near the pole."""

import numpy as np

from mathpost.compensate.compensation import total_differential
from mathpost.draw import plot
from mathpost.draw.chart import recorded, subplots
from mathpost.draw.formula import slider
from mathpost.measure import spline


def knot_choice(measured):
    """A slider over the number of knots of `spline.Points`: chosen adaptively, and equally far apart."""
    order = spline.adaptive(measured, np.finfo(float).tiny).knots
    closed = measured.period is not None  # then the last knot is the first
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

    def update(knots):
        fewer, said = max(count for count in possible if count <= knots), []
        fits = spline.Curve(measured, order[: round(knots)]), spline.uniform(measured, fewer)
        for (name, (curve, dots)), fitted in zip(lines.items(), fits, strict=True):
            chosen = sorted(fitted.knots)
            curve.set_data(at, fitted(at))
            dots.set_data(measured.at[chosen], measured.values[chosen])
            said.append(f"{name}: {len(chosen)} knots, residual {fitted.residual:.3f} arcsec")
        return said

    return recorded(figure, update, slider("knots", fewest, len(order), 6, unit=""))


def towards_the_pole(compensator, joints, tilt):
    """A slider that takes joint number `tilt` of `joints` (radians) to zero: one step there, whole and limited.

    `compensator` is a `Compensator`; the slider is the logarithm of the tilt in degrees.
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
    axes.invert_xaxis()
    axes.legend()

    def update(log_tilt):
        at = int(np.argmin(np.abs(np.log10(degrees) - log_tilt)))
        for mark, (_, tip) in zip(marks, curves.values(), strict=True):
            mark.set_data([degrees[at]], [1e3 * max(tip[at], 1e-8)])
        turn = np.rad2deg(np.abs(whole[at, 3:]).max())
        said = "; ".join(f"{name} {1e3 * tip[at]:.3f} µm" for name, (_, tip) in curves.items())
        return [f"tilt {degrees[at]:.4f} deg: {said}; the whole step turns {turn:.4f} deg"]

    return recorded(figure, update, slider("log tilt", -3, 1.5, 1.5, step=0.025, unit=""))
