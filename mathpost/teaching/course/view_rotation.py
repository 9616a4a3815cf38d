"""Views with sliders for lessons 01 to 04 and 14: rotations, frames, tilted planes, several machines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from mathpost import chain, euler
from mathpost.detective.misreadings import COMMON
from mathpost.rotation import ACTIVE, PASSIVE, about
from mathpost.shop.plane import positioning
from mathpost.shop.plane.positioning import align
from mathpost.shop.plane.tilted_plane import NOTATIONS, Plane
from mathpost.sources.recipes import zxz_right, zxz_steps
from mathpost.teaching.draw import solid
from mathpost.teaching.draw.colours import COLOUR
from mathpost.teaching.draw.live import Live, TextLine, formula, slider
from mathpost.teaching.draw.scene import Label, Line, Scene, clearest
from mathpost.teaching.draw.solid import Hull, Turned, block

if TYPE_CHECKING:
    from mathpost.frame import Frame
    from mathpost.machine import Machine

_MACHINE, _WORKPIECE, _TOOL = (COLOUR[role] for role in ("machine", "workpiece", "tool"))
_AXIS, _NODES = COLOUR["first branch"], COLOUR["second branch"]  # of rotation; line of nodes
_PART = "#8fc0dd"
_ARCS = (COLOUR["tool side"], _NODES, COLOUR["workpiece side"])  # of I, J and K
_UNIT = dict(zip("XYZ", np.eye(3, dtype=int).tolist(), strict=True))
_DEGREES = 180 / sp.pi
_NAMES = ("X", "Y", "Z", "X'", "Y'", "Z'")
_DRILL = "#e9a56b"
_FLOOR, _SHADOW = "#e4e7ea", "#9aa3ab"
HOLE = 10.0  # mm from the origin of the face, down the slope
STEPS = ("start", "turn I", "turn J", "turn K")


def turned_point(point: Sequence[float]) -> Live:
    """A point in the initial frame and in a frame turned by ZXZ angles: sliders alpha, beta, gamma in degrees."""
    symbols, size = sp.symbols("alpha beta gamma", real=True), 0.75 * float(np.linalg.norm(point))
    turned = zxz_right(*symbols)
    x, y, z = new = turned * sp.Matrix(point)
    wrong = zxz_steps("right", symbols, point, elementary=ACTIVE)[-1].value
    angles = {"alpha": (-180, 135.0), "beta": (0, 54.7356), "gamma": (-180, -90.0)}
    frame = zxz_right(*(start for _, start in angles.values()), degrees=True)
    axes = np.concatenate([np.eye(3), frame])
    extent = np.concatenate([1.35 * size * axes, 1.25 * np.array([point, np.zeros(3)])])
    scene = _frames_and_point(point, size, extent)
    scene.solids.append(_disc("turned", _PART, size))
    coordinates = [sp.Matrix(corner) for corner in ([0, 0, 0], [x, 0, 0], [x, y, 0], [x, y, z])]
    scene.lines.append(Line("turned", [], _TOOL, 2.4, over=True, points=coordinates))
    above = sp.Matrix([0, 0, 0.02 * size])  # the floor, which would hide it
    shadow = [sp.diag(1, 1, 0) * turned.T * corner + above for corner in coordinates]
    scene.lines.append(Line("bed", [], _SHADOW, 2.4, points=shadow))
    scene = scene.frame(*clearest(dict(zip(_NAMES, axes, strict=True)), [frame[2]]))
    sliders = [slider(name, low, 180, start) for name, (low, start) in angles.items()]
    text = [("in the turned frame: x' = {:6}, y' = {:6}, z' = {:6}", *new)]
    text += [("with active elements: {:6}, {:6}, {:6}", *wrong)]
    return formula([scene], symbols, sliders, {"turned": turned.T}, text)


def _frames_and_point(point: Sequence[float], size: float, extent: np.ndarray) -> Scene:
    """Return the scene of a point above its place on the disc of a fixed frame, and of a frame that turns."""
    foot = np.array([*point[:2], 0.0])
    extent = np.concatenate([extent, [1.2 * np.array(point), 1.1 * foot]])
    scene = Scene([_disc("bed", _FLOOR, size)], extent=extent)
    scene.triad("bed", "XYZ", length=size, colour=_MACHINE)
    scene.triad("turned", _NAMES[3:], length=size, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [[np.zeros(3), np.array(point)]], _TOOL, 1.2, dash=True, over=True, dot=True))
    scene.lines.append(Line("bed", [[np.array(point), foot, np.zeros(3)]], _SHADOW, 1.2, dash=True, over=True))
    scene.labels.append(Label("bed", 1.1 * np.array(point), "P", _TOOL))
    return scene


def _disc(body: str, colour: str, radius: float) -> Turned:
    """Return a thin disc in the XY plane of a body."""
    half = 0.005 * radius
    return Turned(body, colour, [(0, -half), (radius, -half), (radius, half), (0, half)], np.zeros(3), np.eye(3)[2])


def turns(point: Sequence[float], angles: Sequence[float]) -> Live:
    """A fixed point and a frame that makes three turns in sequence: a slider from 0 to 3 that plays.

    The angles are those of ZXZ in degrees; the axis of the current turn is dashed. It starts after two turns.
    """
    s, size = sp.Symbol("s", real=True), 0.75 * float(np.linalg.norm(point))
    done = [sp.Rational(round(1e9 * t), 10**9) * sp.Min(1, sp.Max(0, s - n)) for n, t in enumerate(angles)]
    F: sp.Matrix = euler.matrix("ZXZ", [t * sp.pi / 180 for t in done])
    conditions = (sp.Or(s <= 1, s > 2), sp.And(s > 1, s <= 2), s <= 1, s > 2)
    about_z, second, first, third = (sp.Piecewise((1, when), (0, True)) for when in conditions)
    v = size * about_z * F[:, 2] + size * second * F[:, 0]
    axes = np.concatenate([np.eye(3), np.array(F.subs(s, 2).evalf(), dtype=float).T])
    scene = _frames_and_point(point, size, 1.3 * size * np.concatenate([np.eye(3), -np.eye(3)]))
    thick = [0.62 * size, 0.42 * size, 0.1 * size]  # a plate carried by the turning frame
    scene.solids.append(Hull("turned", _PART, block([0.0, 0.0, 0.0], thick)))
    scene.lines.append(Line("bed", [], _AXIS, 2.4, dash=True, over=True, points=[-1.2 * v, 1.2 * v]))
    scene = scene.frame(*clearest(dict(zip(_NAMES, axes, strict=True)), [axes[5]]))
    sliders = [slider("turn", 0, 3, 2, step=0.05, unit="")]
    text = "α {:4}°, β {:4}°, γ {:4}°; now it turns {?about Z}{?about the new X}{?about the newest Z}"
    return formula([scene], [s], sliders, {"turned": F}, [(text, *done, first, second, third)], height=420, play=0)


def conjugation(alpha: float, beta: float) -> Live:
    """A turn by `beta` about the new X of a frame that `alpha` has turned about Z, made of three turns: undo the
    first one, turn about the X of the bed, and redo it. One slider plays; angles in degrees.

    There is a picture for each turn, which stays as its turn has left it: at the end, where the slider starts, the
    three poses stand side by side. The axis of each turn is dashed. The text says how far the frame is from what
    `mathpost.rotation.about` makes of it.
    """
    s = sp.Symbol("s", real=True)
    done = [sp.Min(1, sp.Max(0, s - n)) for n in range(3)]
    first, second = (sp.Rational(round(1e9 * t), 10**9) * sp.pi / 180 for t in (alpha, beta))
    Rx, Rz = ACTIVE["X"], ACTIVE["Z"]
    undone = Rz(-first * done[0]) * Rz(first)
    turned = Rx(second * done[1]) * undone
    redone = Rz(first * done[2]) * turned
    begin = euler.matrix("ZXZ", (alpha, 0, 0), degrees=True)
    end = sp.Matrix(about(begin[:, 0], float(second))) * Rz(first)  # what it is to be, by Rodrigues' formula
    scenes: list[Scene] = []
    places: dict[str, sp.Matrix] = {}
    seen = clearest(dict(zip(_NAMES, [*np.eye(3), *np.array(end, dtype=float).T], strict=True)))
    rows = (("undo", undone, "Z"), ("turn", turned, "X"), ("redo", redone, "Z"))
    for number, (title, pose, letter) in enumerate(rows, start=1):
        v = 1.3 * np.array(_UNIT[letter])
        scene = Scene([_disc("bed", _FLOOR, 1.0)], extent=1.25 * np.concatenate([np.eye(3), -0.8 * np.eye(3)[:2]]))
        scene.title = f"{number} · {title}, about {letter}"
        scene.triad("bed", "XYZ", length=1.0, colour=_MACHINE)
        scene.triad(title, _NAMES[3:], length=0.75, colour=_WORKPIECE, width=3)
        scene.solids.append(Hull(title, _PART, block([0.0, 0.0, 0.0], [0.6, 0.4, 0.1])))
        scene.lines.append(Line("bed", [[-0.3 * v, v]], _AXIS, 2.4, dash=True, over=True))
        scenes.append(scene.frame(*seen, aspect=1.0))
        places[title] = pose
    apart = sp.acos(sp.Min(1, ((redone.T * end).trace() - 1) / 2)) * _DEGREES
    text: list[TextLine] = [
        ("undo {:1}°, turn {:1}°, redo {:1}°", -alpha * done[0], beta * done[1], alpha * done[2]),
        (f"from the frame turned by {beta:g}° about its own X: {{:2}}°", apart),
    ]
    sliders = [slider("turn", 0, 3, 3, step=0.05, unit="")]
    return formula(scenes, [s], sliders, places, text, height=420, layout="column", play=0)


def notations(angles: Sequence[float] = (40.0, 50.0, 30.0)) -> Live:
    """One frame in many notations: sliders I, J, K, the ZXZ angles in degrees.

    The rims of the discs XY and xy meet in the line of nodes, pink; three arcs are the angles I, J and K. The axis
    of the one turn that makes the frame is dashed.
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
        *found, sine = euler.angle_expressions(about.sequence, F, lock=about.lock)
        words, locked = " {:3}, ".join(about.words), sp.Piecewise((1, sine < euler.LOCK), (0, True))
        text.append((f"{name}: {words} {{:3}}{{? (locked)}}", *(angle * _DEGREES for angle in found), locked))
    frame = euler.matrix("ZXZ", angles, degrees=True)
    axes = np.concatenate([np.eye(3), frame.T])
    scene = Scene(extent=1.2 * np.concatenate([axes, -axes]))
    scene.triad("bed", "XYZ", length=1.0, colour=_MACHINE)
    scene.triad("turned", "xyz", length=1.0, colour=_WORKPIECE, width=3)
    scene.lines.append(Line("bed", [], _AXIS, 2.4, dash=True, over=True, points=[-v, v]))
    scene.lines.append(Line("bed", [], _NODES, 1.6, over=True, points=[-1.25 * node, 1.25 * node]))
    turn = np.linspace(0, 2 * np.pi, 49)
    rim = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    scene.lines += [Line(body, [rim], colour, 1.0) for body, colour in (("bed", _MACHINE), ("turned", _WORKPIECE))]
    i, j, k = symbols
    steps = [sp.Rational(n, 12) for n in range(13)]
    arcs = (
        [0.5 * euler.matrix("ZXZ", (i * part, 0, 0))[:, 0] for part in steps],
        [0.7 * euler.matrix("ZXZ", (i, j * part, 0))[:, 2] for part in steps],
        [0.75 * euler.matrix("ZXZ", (i, j, k * part))[:, 0] for part in steps],
    )
    scene.lines += [Line("bed", [], c, 3.0, over=True, points=arc) for c, arc in zip(_ARCS, arcs, strict=True)]
    scene = scene.frame(*clearest(dict(zip("XYZxyz", axes, strict=True))))
    pairs = zip("IJK", (-180, 0, -180), angles, strict=True)
    sliders = [slider(name, low, 180, value) for name, low, value in pairs]
    return formula([scene], symbols, sliders, {"turned": F}, text, height=460)


def cut_corner(frame: Frame, final: Sequence[float]) -> Live:
    """A cube with its zero in the middle of the top face and the corner (+, +, top) cut off, and a frame there.

    The hole is where the drawing has it, the drill is on the frame that turns. Sliders I, J, K (ZXZ) turn a frame
    at the origin of `frame`, the frame of the face. They start at the `final` angles, degrees; buttons go there
    turn by turn.
    """
    side, cut, symbols = 60.0, 45.0, sp.symbols("I J K", real=True)
    half = side / 2
    corner = np.array([half, half, 0.0])
    corners = block([-half, -half, -side], corner)
    kept = [point for point in corners if np.abs(point - corner).max() > 1e-9]
    cube = Hull("bed", _PART, np.array([*kept, *(corner - cut * np.eye(3))]))
    turned = euler.matrix("ZXZ", symbols)
    arm, square = 0.55 * side, 0.3 * side * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
    extent = np.concatenate([corners, frame.origin + arm * frame.rotation.T, [[0, 0, 1.3 * arm]]])
    drawn = Scene([cube], extent=1.08 * extent)
    drawn.triad("bed", "XYZ", length=arm, colour=_WORKPIECE)
    drawn.triad("feature", "xyz", length=0.75 * arm, colour=_TOOL, width=3)
    rim = solid.ring(frame.point([HOLE, 0, 0]), frame.z, 3.0, 25)
    rim = np.concatenate([rim, rim[:1]])
    drawn.lines.append(Line("bed", [rim], "#000000", 2.0, over=True))
    up = np.array([0.0, 0.0, 1.0])  # the drill is along the z of the turned frame, its point 4 mm above it
    drill = [(0.0, 4.0), (3.0, 6.0), (3.0, 26.0), (5.0, 26.0), (5.0, 40.0), (0.0, 40.0)]
    drawn.solids.append(Turned("feature", _DRILL, drill, np.array([HOLE, 0.0, 0.0]), up))
    drawn.lines.append(Line("feature", [square], _TOOL, 1.6, over=True))
    lean = sp.acos(sp.Min(1, turned[:, 2].dot(sp.Matrix(frame.z)))) * 180 / sp.pi
    off = sp.acos(sp.Min(1, turned[:, 0].dot(sp.Matrix(frame.x)))) * 180 / sp.pi
    after = [[angle if n < step else 0.0 for n, angle in enumerate(final)] for step in range(4)]
    text = [("z = ({:4}, {:4}, {:4}), off the face by {:2}°", *turned[:, 2], lean)]
    text += [("x = ({:4}, {:4}, {:4}), off the slope by {:2}°", *turned[:, 0], off)]
    sliders = [slider(name, -180, 180, value) for name, value in zip("IJK", final, strict=True)]
    buttons, drawn = list(zip(STEPS, after, strict=True)), drawn.frame(75, 24)
    places = {"feature": chain.homogeneous(turned, sp.Matrix(frame.origin))}
    return formula([drawn], symbols, sliders, places, text, buttons=buttons, height=430)


def third_angle(machine: Machine, i: float, j: float, k: float = -90.0, *, seq: str = "+") -> Live:
    """The effect of the third angle, slider K, on a boring bar and a probe, seen along Z of a tilted plane.

    The spindle stops with the bar's tip along its own X, and the control retracts by 1 mm against the feature's X;
    a stylus runs out by 20 µm along the spindle's X, and the control corrects along the feature's. Both are right
    only if the spindle's X is the feature's. Buttons choose between the two positions of the rotary axes; it starts
    with that of `seq`. Angles in degrees.
    """
    from mathpost.teaching.draw import curves  # loads matplotlib, which views of scenes do not need

    radius, retract, run_out = 10.0, 1.0, 0.02  # mm
    alignment = align(Plane("G68.2", np.array([i, j, 0.0])).frame, machine)
    both = [positioning.heidenhain(alignment, (0, 0), seq=sign) for sign in "+-"]
    name = machine.rotary[alignment.tool_side].name
    K, side, turn = sp.Symbol("K", real=True), sp.Symbol("side", real=True), np.linspace(0, 2 * np.pi, 61)
    left = [float(np.radians(round(choice.rho, 9))) for choice in both]  # the same on every machine
    rho = K + (left[0] + left[1]) / 2 + side * (left[0] - left[1]) / 2  # side is 1 or -1
    x, y = sp.cos(rho), -sp.sin(rho)  # the spindle's X in the feature
    clearance = radius - sp.sqrt((radius * x - retract) ** 2 + (radius * y) ** 2)
    clear = sp.Piecewise((1, clearance > 0), (0, True))
    circle, moving = np.stack([np.cos(turn), np.sin(turn)]), curves.Moving()
    figure, (bore, probe) = curves.subplots(1, 2, size=(7.0, 4.0))
    bored = f"bore of radius {radius:g} mm,\nbar retracted by {retract:g} mm along −X"
    titles = {bore: bored, probe: f"stylus ball, run-out {1000 * run_out:g} µm:\nbelieved (dotted) and true"}
    for axes, title in titles.items():
        axes.set(title=title, aspect="equal", xlim=(-1.55, 1.55), ylim=(-1.55, 1.55))
        axes.set_axis_off()
        for direction, label in zip(np.eye(2), "XY", strict=True):
            axes.plot(*np.array([(0, 0), 1.3 * direction]).T, color=_WORKPIECE)
            axes.text(*(1.42 * direction), label, color=_WORKPIECE, ha="center", va="center")
        moving.line(axes, "machine", [(r * x, r * y) for r in (0.4, 1.15)], lw=2)
        label = axes.text(0, 0, "Xₛ", color=_MACHINE, ha="center", va="center")
        moving[label] = [(1.05 * x + 0.2 * y, 1.05 * y - 0.2 * x)]
    bore.plot(*circle, color=_WORKPIECE)
    bore.fill(*(0.6 * circle - [[0.25], [0]]), color=_TOOL, alpha=0.35)  # the retract is not to scale
    moving.line(bore, "tool", [(r * x - 0.25, r * y) for r in (0.6, 1.0)], lw=5)
    probe.plot(*(0.3 * circle + [[0.35], [0]]), color=_WORKPIECE, ls=":")
    moving.line(probe, "tool", [(0.35 * x + right, 0.35 * y + up) for right, up in 0.3 * circle.T.round(6)])
    names = [rotary.name for rotary in machine.rotary]
    said = [", ".join(f"{n} {a:z.3f}" for n, a in zip(names, choice.angles, strict=True)) for choice in both]
    first = sp.Piecewise((1, side > 0), (0, True))
    text: list[TextLine] = [
        (f"{{?{said[0]}}}{{?{said[1]}}}, ρ = {{:3}}", first, 1 - first, sp.atan2(-y, x) * 180 / sp.pi),
        ("tip after the retract: {:3} mm {?clear of the wall}{?IN THE WALL}", clearance, clear, 1 - clear),
        ("centre measured by the probe: wrong by {:1} µm", 1000 * run_out * sp.sqrt((x - 1) ** 2 + y**2)),
    ]
    sliders = [slider("K", -180, 180, k, step=5.0)]
    sliders.append(slider("side", -1, 1, 1 if seq == "+" else -1, unit="", hidden=True))
    buttons = [(f"{name} {sign} 0", [None, value]) for sign, value in ((">", 1), ("<", -1))]
    return curves.printed(figure, moving, [K, side], sliders, text, buttons=buttons, height=500)


def misreadings_apart(point: Sequence[float], names: Sequence[str]) -> Live:
    """The distances by which common misreadings displace a point: sliders for the three Euler angles.

    `point` has shape (3,); `names` are those of `mathpost.detective.misreadings.COMMON`. Where a bar vanishes, the
    angles cannot reveal that misreading.
    """
    from mathpost.teaching.draw import curves  # loads matplotlib, which views of scenes do not need

    symbols, at = sp.symbols("alpha beta gamma", real=True), sp.Matrix([sp.Float(x) for x in point])
    figure, panel = curves.subplots()
    panel.set(xlim=(0, 2 * float(at.norm())), ylim=(len(names) - 0.5, -0.5))
    panel.set(xlabel="distance from the right point", yticks=range(len(names)), yticklabels=names)
    bars, distances = {}, []
    for row, name in enumerate(names):
        order, signs = COMMON[name]
        first, second, third = (PASSIVE["ZXZ"[n]](signs[n] * symbols[n]) for n in order)
        distances.append(length := ((first * second * third - zxz_right(*symbols)) * at).norm())
        (bar,) = panel.fill([], [], color=COLOUR["tool"])
        bars[bar] = [(0, row - 0.4), (length, row - 0.4), (length, row + 0.4), (0, row + 0.4)]
    start = zip(symbols, (135.0, 55.0, -90.0), strict=True)
    sliders = [slider(str(symbol), -180, 180, angle) for symbol, angle in start]
    said = ", ".join(f"{name} {{:3}}" for name in names)
    text: list[TextLine] = [(f"away from the right point (0.000 cannot be seen): {said}", *distances)]
    return curves.printed(figure, bars, symbols, sliders, text, height=520)
