"""The view with sliders for lesson 14: which misreadings of the angles a number can show."""

import numpy as np
import sympy as sp

from mathpost.detective.misreadings import COMMON, common_matrices
from mathpost.draw import plot
from mathpost.draw.chart import printed, subplots
from mathpost.draw.formula import slider
from mathpost.rotation import PASSIVE, zxz_right


def misreadings_apart(point, names):
    """How far common misreadings carry a point from the right place, as sliders move the three Euler angles.

    `point` has shape (3,); `names` are those of `mathpost.detective.misreadings.COMMON`. A bar that vanishes is a
    misreading that these angles cannot show.
    """
    symbols, point = sp.symbols("alpha beta gamma", real=True), sp.Matrix([sp.Float(x) for x in point])
    figure, panel = subplots()
    panel.set(xlim=(0, 2 * float(point.norm())), ylim=(len(names) - 0.5, -0.5))
    panel.set(xlabel="distance from the right point", yticks=range(len(names)), yticklabels=names)
    bars, distances = {}, []
    for row, name in enumerate(names):
        order, signs = COMMON[name]
        first, second, third = (PASSIVE["ZXZ"[n]](signs[n] * symbols[n]) for n in order)
        distances.append(length := ((first * second * third - zxz_right(*symbols)) * point).norm())
        (bar,) = panel.fill([], [], color=plot.COLOUR["tool"])
        bars[bar] = [(0, row - 0.4), (length, row - 0.4), (length, row + 0.4), (0, row + 0.4)]
    said = [f"{name} {{{n}:3}}" for n, name in enumerate(names)]
    start = zip(symbols, (135.0, 55.0, -90.0), strict=True)
    sliders = [slider(str(symbol), -180, 180, angle) for symbol, angle in start]
    text = ["away from the right point (0.000 cannot be seen): " + ", ".join(said)]
    return printed(figure, bars, distances, symbols, sliders, text, height=520)


def invisible(point, names, angles):
    """Return which of the misreadings leave a point where it belongs; angles in degrees."""
    right, *wrong = common_matrices(("right", *names), np.array(angles)) @ np.array(point, dtype=float)
    return [name for name, each in zip(names, wrong, strict=True) if np.linalg.norm(each - right) < 1e-3]
