"""A picture that shows something else says something else: one wrong thing at a time."""

import numpy as np
import pytest
import sympy as sp
from IPython.lib.pretty import pretty

from mathpost.rotation import ACTIVE
from mathpost.teaching.draw import plot
from mathpost.teaching.draw.curves import printed, recorded, subplots
from mathpost.teaching.draw.described import describe
from mathpost.teaching.draw.live import formula, slider
from mathpost.teaching.draw.scene import Scene
from mathpost.teaching.draw.solid import Hull, block

ANGLE = np.linspace(0, 360, 91)


def picture(
    *, curve=1.0, band=2.0, shift=0.0, turned=False, mirrored=False, scatter=1.0, word=7, scale=1.0, role=0
):
    """A figure with one artist of each kind that the lessons draw; every option makes one of them wrong."""
    drawn, axes = plot.figure(1, 3)
    y = curve * np.sin(np.radians(ANGLE)) + shift
    axes[0].plot(*((y, ANGLE) if turned else (ANGLE, y)), label="error", color=f"C{role}")
    axes[0].fill_between(ANGLE, y - band, y + band, label="±2 s")
    axes[0].axhspan(2 * scale, 3 * scale)
    axes[0].annotate(f"number {word}", (90, 1 * scale))
    values = np.outer(np.arange(4.0), np.arange(5.0) ** 2)
    axes[1].imshow(values[:, ::-1] if mirrored else values)
    axes[1].pcolormesh(values * scale)
    axes[1].scatter(ANGLE, scatter * y**2)
    axes[2].contour(values * curve, levels=[1, 2, 5])
    axes[2].quiver([0, 1], [0, 1], [scale, 2], [1, 1])
    plot.ellipse(axes[2], np.zeros(2), np.diag([scatter, 4.0]))
    text = describe(drawn)
    plot.plt.close(drawn)
    return text


def space(height=1.0, place=1.0):
    drawn, axes = plot.figure(three_d=True)
    axes.plot([0, 1, 2], [0, 1, 0], [0, height, 4], label="path")
    axes.scatter([1, 2], [3, 4], [place, 2])
    axes.text(0, 0, place, "tip")
    text = describe(drawn)
    plot.plt.close(drawn)
    return text


@pytest.mark.parametrize(
    "wrong",
    [
        {"curve": -1.0},
        {"curve": -1000.0},
        {"band": 2.5},
        {"shift": 7.0},
        {"turned": True},
        {"mirrored": True},
        {"scatter": 2.0},
        {"word": 14},
        {"scale": 1.1},
        {"role": 1},
    ],
    ids=str,
)
def test_a_wrong_picture_says_something_else(wrong):
    assert picture(**wrong) != picture()


@pytest.mark.parametrize("wrong", [{"height": -1.0}, {"place": 1.5}], ids=str)
def test_a_wrong_picture_in_space_says_something_else(wrong):
    assert space(**wrong) != space()


def turned(degrees=30.0, letters="XYZ", colour="#0072b2", mirrored=False):
    """A view of a plate with a frame on it, as a notebook saves it in numbers."""
    drawn = Scene([Hull("plate", "#333333", block([0, 0, 0], [3.0, 2.0, -1.0 if mirrored else 1.0]))])
    drawn.triad("plate", letters, length=1.0, colour=colour)
    t = sp.Symbol("t")
    control = slider("t", 0, 90, degrees)
    return pretty(formula([drawn], [t], [control], {"plate": ACTIVE["Z"](t)}, [("it turns",)]))


@pytest.mark.parametrize(
    "wrong", [{"degrees": -30.0}, {"letters": "YXZ"}, {"colour": "#d55e00"}, {"mirrored": True}], ids=str
)
def test_a_wrong_view_says_something_else(wrong):
    assert turned(**wrong) != turned() == turned()


@pytest.mark.parametrize("make", [recorded, printed])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_chart_says_its_curves_also_where_the_slider_does_not_stand(make, sign):
    def told(sign):
        figure, axes = subplots()
        (line,) = axes.plot([0, 1], [0, 0])
        t, control = sp.Symbol("t"), slider("t", 0, 5, 1.0, unit="")
        if make is printed:
            points = {line: [(sp.S(0), sp.S(0)), (sp.S(1), sign * t**2)]}
            return pretty(printed(figure, points, [t], [control], [("it rises",)]))
        update = lambda value: line.set_ydata([0, value**2 if value < 4 else sign * value**2]) or ["it rises"]  # noqa: E731
        return pretty(recorded(figure, update, control))

    assert (told(sign) == told(1.0)) == (sign == 1.0)


def test_the_same_picture_says_the_same():
    assert picture() == picture() and space() == space()


def test_noise_is_zero_and_nothing_is_hidden():
    drawn, axes = plot.figure()
    axes.plot([0, 1e-17, 1], [1e-16, 1, 2], visible=True)
    axes.plot([5], [5], visible=False)
    text = describe(drawn)
    plot.plt.close(drawn)
    assert "e-1" not in text and "5" not in text
