"""Views with sliders for lessons 01, 02 and 14: rotations, frames, and how their angles are misread."""

import numpy as np
import sympy as sp

from mathpost import angles as euler
from mathpost.detective.misreadings import COMMON
from mathpost.draw import plot
from mathpost.draw.chart import printed, subplots
from mathpost.draw.formula import formula, slider
from mathpost.draw.scene import Label, Line, Scene, clearest
from mathpost.plane.tilted_plane import NOTATIONS
from mathpost.rotation import ACTIVE, PASSIVE, zxz_right, zxz_steps

_MACHINE, _WORKPIECE, _TOOL = (plot.COLOUR[role] for role in ("machine", "workpiece", "tool"))
_AXIS, _NODES = plot.COLOUR["first branch"], plot.COLOUR["second branch"]  # of a turn; where two planes meet
_UNIT = dict(zip("XYZ", np.eye(3, dtype=int).tolist(), strict=True))
_DEGREES = 180 / sp.pi
_NAMES = ("X", "Y", "Z", "X'", "Y'", "Z'")


def turned_point(point):
    """A point in the initial frame and in the one that ZXZ angles turn: sliders alpha, beta, gamma in degrees."""
    symbols, size = sp.symbols("alpha beta gamma", real=True), 0.75 * float(np.linalg.norm(point))
    turned = zxz_right(*symbols)
    x, y, z = new = turned * sp.Matrix(point)
    wrong = zxz_steps("right", symbols, point, elementary=ACTIVE)[-1].value
    angles = {"alpha": (-180, 135.0), "beta": (0, 54.7356), "gamma": (-180, -90.0)}
    frame = zxz_right(*(start for _, start in angles.values()), degrees=True)
    axes = np.concatenate([np.eye(3), frame])
    extent = np.concatenate([1.35 * size * axes, 1.25 * np.array([point, np.zeros(3)])])
    scene = _frames_and_point(point, size, extent)
    coordinates = [sp.Matrix(corner) for corner in ([0, 0, 0], [x, 0, 0], [x, y, 0], [x, y, z])]
    scene.lines.append(Line("turned", [], _TOOL, 2.4, over=True, points=coordinates))
    scene = scene.frame(*clearest(dict(zip(_NAMES, axes, strict=True))))
    sliders = [slider(name, low, 180, start) for name, (low, start) in angles.items()]
    text = [("in the turned frame: x' = {:6}, y' = {:6}, z' = {:6}", *new)]
    text += [("with active elements: {:6}, {:6}, {:6}", *wrong)]
    return formula([scene], symbols, sliders, {"turned": turned.T}, text)


def _frames_and_point(point, size, extent):
    """A point in the frame that stays, and the frame that turns."""
    scene = Scene(["turned"], extent=extent)
    scene.triad("bed", "XYZ", length=size, colour=_MACHINE)
    scene.triad("turned", _NAMES[3:], length=size, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [[np.zeros(3), np.array(point)]], _TOOL, 1.2, dash=True, over=True, dot=True))
    scene.labels.append(Label("bed", 1.1 * np.array(point), "P", _TOOL))
    return scene


def turns(point, angles):
    """A point that stays and a frame that makes three turns, one after the other: a slider from 0 to 3 that plays.

    The angles are those of ZXZ in degrees; dashed is the axis of the present turn.
    """
    s, size = sp.Symbol("s", real=True), 0.75 * float(np.linalg.norm(point))
    done = [sp.Rational(round(1e9 * t), 10**9) * sp.Min(1, sp.Max(0, s - n)) for n, t in enumerate(angles)]
    F = euler.matrix("ZXZ", [t * sp.pi / 180 for t in done])
    conditions = (sp.Or(s <= 1, s > 2), sp.And(s > 1, s <= 2), s <= 1, s > 2)
    about_z, second, first, third = (sp.Piecewise((1, when), (0, True)) for when in conditions)
    v = size * about_z * F[:, 2] + size * second * F[:, 0]
    axes = np.concatenate([np.eye(3), np.array(F.subs(s, 1.5).evalf(), dtype=float).T])
    scene = _frames_and_point(point, size, 1.3 * size * np.concatenate([np.eye(3), -np.eye(3)]))
    scene.lines.append(Line("bed", [], _AXIS, 2.4, dash=True, over=True, points=[-1.2 * v, 1.2 * v]))
    scene = scene.frame(*clearest(dict(zip(_NAMES, axes, strict=True))))
    sliders = [slider("turn", 0, 3, 1.5, step=0.05, unit="")]
    text = "α {:4}°, β {:4}°, γ {:4}°; now it turns {?about Z}{?about the new X}{?about the newest Z}"
    return formula([scene], [s], sliders, {"turned": F}, [(text, *done, first, second, third)], height=420, play=0)


def notations(angles=(135.0, 54.7356, -90.0)):
    """One frame in many notations: sliders I, J, K, the ZXZ angles in degrees.

    Dashed is the axis of the single turn that makes the frame; pink is the line of nodes, where XY and xy meet.
    """
    symbols = sp.symbols("I J K", real=True)
    F, node = euler.matrix("ZXZ", symbols), sp.Matrix([sp.cos(symbols[0]), sp.sin(symbols[0]), 0])
    turns = (sp.Quaternion.from_axis_angle(_UNIT[letter], t) for letter, t in zip("ZXZ", symbols, strict=True))
    w, x, y, z = sp.prod(turns).args
    sign, sine = sp.Piecewise((-1, w < 0), (1, True)), sp.sqrt(x**2 + y**2 + z**2)
    ends = zip((0, 0, 1), (x, y, z), strict=True)  # no turn at all has the axis Z
    v = sp.Matrix([sp.Piecewise((e, sine < 1e-12), (sign * x / sp.Max(sine, 1e-12), True)) for e, x in ends])
    angle = 2 * sp.atan2(sine, sign * w) * _DEGREES
    text = [("axis ({:4}, {:4}, {:4}), angle {:3}° (dashed)", *v, angle)]
    text += [("quaternion ({:4}, {:4}, {:4}, {:4})", *(sign * x for x in (w, x, y, z)))]
    for name in ("G68.2", "PLANE SPATIAL", "AROT RPY"):
        about = NOTATIONS[name]
        *found, sine = euler.expressions(about.sequence, F, lock=about.lock)
        words, locked = " {:3}, ".join(about.words), sp.Piecewise((1, sine < euler.LOCK), (0, True))
        text.append((f"{name}: {words} {{:3}}{{? (locked)}}", *(angle * _DEGREES for angle in found), locked))
    frame = euler.matrix("ZXZ", angles, degrees=True)
    axes = np.concatenate([np.eye(3), frame.T])
    scene = Scene(["turned"], extent=1.35 * np.concatenate([axes, -axes[:3] / 2]))
    scene.triad("bed", "XYZ", length=1.0, colour=_MACHINE)
    scene.triad("turned", "xyz", length=1.0, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [], _AXIS, 2.4, dash=True, over=True, points=[-v, v]))
    scene.lines.append(Line("bed", [], _NODES, 1.6, over=True, points=[-1.25 * node, 1.25 * node]))
    scene = scene.frame(*clearest(dict(zip("XYZxyz", axes, strict=True))))
    pairs = zip("IJK", (-180, 0, -180), angles, strict=True)
    sliders = [slider(name, low, 180, value) for name, low, value in pairs]
    return formula([scene], symbols, sliders, {"turned": F}, text, height=460)


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
    start = zip(symbols, (135.0, 55.0, -90.0), strict=True)
    sliders = [slider(str(symbol), -180, 180, angle) for symbol, angle in start]
    said = ", ".join(f"{name} {{:3}}" for name in names)
    text = [(f"away from the right point (0.000 cannot be seen): {said}", *distances)]
    return printed(figure, bars, symbols, sliders, text, height=520)
