"""Views of lessons 03 to 04: a cut corner with its frame, the third angle, machines beside each other."""

from dataclasses import replace

import numpy as np
import sympy as sp

from mathpost import angles, chain
from mathpost.draw import plot, scene
from mathpost.draw.chart import printed, subplots
from mathpost.draw.formula import formula, slider
from mathpost.draw.scene import Line, Scene
from mathpost.draw.solid import Hull, block
from mathpost.plane import positioning
from mathpost.plane.positioning import align
from mathpost.plane.tilted_plane import Plane

_MACHINE, _WORKPIECE, _TOOL = (plot.COLOUR[role] for role in ("machine", "workpiece", "tool"))
STEPS = ("start", "turn I", "turn J", "turn K")


def cut_corner(frame, final):
    """A cube, its zero in the middle of the top face, with the corner (+, +, top) cut off, and a frame on the face.

    The origin of `frame`, that of the face, carries the frame that the sliders I, J, K turn, ZXZ. They start at the
    `final` angles, degrees; buttons go there turn by turn.
    """
    side, cut, symbols = 60.0, 45.0, sp.symbols("I J K", real=True)
    half = side / 2
    corner = np.array([half, half, 0.0])
    corners = block([-half, -half, -side], corner)
    kept = [point for point in corners if np.abs(point - corner).max() > 1e-9]
    solid = Hull("bed", "#8fc0dd", np.array([*kept, *(corner - cut * np.eye(3))]))
    turned = angles.matrix("ZXZ", symbols)
    placed = sp.Matrix.vstack(sp.Matrix.hstack(turned, sp.Matrix(frame.origin)), sp.Matrix([[0, 0, 0, 1]]))
    arm, square = 0.55 * side, 0.3 * side * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0], [-1, -1, 0]])
    extent = np.concatenate([corners, frame.origin + arm * frame.rotation.T, [[0, 0, 1.3 * arm]]])
    drawn = Scene(["feature"], [solid], extent=1.08 * extent)
    drawn.triad("bed", "XYZ", length=arm, colour=_WORKPIECE)
    drawn.triad("feature", "xyz", length=0.75 * arm, colour=_TOOL, width=3)
    drawn.lines.append(Line("feature", [square], _TOOL, 1.6, over=True))
    lean = sp.acos(sp.Min(1, turned[:, 2].dot(sp.Matrix(frame.z)))) * 180 / sp.pi
    off = sp.acos(sp.Min(1, turned[:, 0].dot(sp.Matrix(frame.x)))) * 180 / sp.pi
    after = [[angle if n < step else 0.0 for n, angle in enumerate(final)] for step in range(4)]
    text = ["z = ({0:4}, {1:4}, {2:4}), off the face by {3:2}°"]
    text += ["x = ({4:4}, {5:4}, {6:4}), off the slope by {7:2}°"]
    sliders = [slider(name, -180, 180, value) for name, value in zip("IJK", final, strict=True)]
    more = {"numbers": [*turned[:, 2], lean, *turned[:, 0], off], "buttons": list(zip(STEPS, after, strict=True))}
    return formula(drawn.frame(75, 24), symbols, sliders, {"feature": placed}, text, height=430, **more)


def third_angle(machine, i, j, k=-90.0, *, radius=10.0, retract=1.0, run_out=0.02):
    """Looking along Z onto a tilted plane: what the third angle, slider K, does to a boring bar and to a probe.

    The spindle stops with the bar's tip along its own X, and the control retracts by `retract` against the
    feature's X; a stylus runs out by `run_out` along the spindle's X, and the control corrects along the
    feature's. Both are right only if the spindle's X is the feature's. The rotary axes go where SEQ+ sends them.
    Lengths in mm, angles in degrees.
    """
    choice = positioning.heidenhain(align(Plane("G68.2", [i, j, 0]).frame, machine), (0, 0), seq="+")
    K, turn = sp.Symbol("K", real=True), np.linspace(0, 2 * np.pi, 61)
    rho = K + float(np.radians(choice.rho))
    x, y = sp.cos(rho), -sp.sin(rho)  # the spindle's X in the feature
    clearance = radius - sp.sqrt((radius * x - retract) ** 2 + (radius * y) ** 2)
    numbers = [sp.atan2(-y, x) * 180 / sp.pi, clearance, sp.Piecewise((1, clearance > 0), (0, True))]
    numbers += [1 - numbers[2], 1000 * run_out * sp.sqrt((x - 1) ** 2 + y**2)]
    circle, moving = np.stack([np.cos(turn), np.sin(turn)]), plot.Moving()
    figure, (bore, probe) = subplots(1, 2, size=(7.0, 4.0))
    titles = {bore: "boring bar, retracted along −X", probe: "stylus ball, believed (dotted) and true"}
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
    angles = ", ".join(f"{r.name} {a:z.3f}" for r, a in zip(machine.rotary, choice.angles, strict=True))
    text = [
        f"{angles}, ρ = {{0:3}}",
        "tip after the retract: {1:3} mm {2?clear of the wall}{3?IN THE WALL}",
        "centre measured by the probe: wrong by {4:1} µm",
    ]
    return printed(figure, moving, numbers, [K], [slider("K", -180, 180, k, step=5.0)], text, height=500)


def gallery(kinematics, *, outer=40.0, inner=30.0, senses=False):
    """Machines beside each other, turned together by two sliders, outer and inner; their tips stay where they are.

    The outer axis is next to the workpiece in the chain, the inner one next to the tool; degrees. With `senses`
    there are buttons for the sense: with −1 both axes turn against their programmed angles, as a table does that is
    taken for a head, or a head for a table.
    """
    symbols, places, drawn, text, numbers = sp.symbols("outer inner sense", real=True), {}, [], [], []
    for number, kin in enumerate(kinematics):
        model, derived = kin.machine, kin.inverse_symbolic
        title = f"{number + 1} · {model.arrangement}: outer {derived.outer}, inner {derived.inner}"
        picture, made = scene.machine(kin, title=title)
        tip = kin.forward(made.home)[0]
        turns = {derived.outer: symbols[2] * symbols[0], derived.inner: symbols[2] * symbols[1]}
        at_tip = dict(zip(derived.tip, tip, strict=True))
        slides = [coordinate.subs(at_tip).subs(turns) for coordinate in derived.linear]
        joints = dict(zip(kin.symbols, slides, strict=False)) | turns
        places |= {f"{number} {name}": matrix.subs(joints) for name, matrix in chain.bodies(model)}
        start = [outer if symbol == derived.outer else inner for symbol in kin.symbols[3:]]
        picture, _ = scene.best_camera(kin, picture, kin.close(tip, np.radians(start)), aspect=1.0)
        for part in (*picture.solids, *picture.lines, *picture.labels):
            part.body = part.body if part.body == "bed" else f"{number} {part.body}"
        drawn.append(picture)
        first = len(numbers)
        text.append(f"{number + 1} {model.name}: n = ({{{first}:4}}, {{{first + 1}:4}}, {{{first + 2}:4}})")
        numbers += kin.forward_symbolic()[:3, 2].subs(turns)
    pictures = [replace(picture, bodies=list(places)) for picture in drawn]
    sliders = [slider("outer", -180, 180, outer), slider("inner", -90, 90, inner)]
    sliders.append(slider("sense", -1, 1, 1, unit="", hidden=True))
    text = ["; ".join(text[n : n + 2]) for n in range(0, len(text), 2)]
    buttons = [("0, 0", [0, 0, None]), ("outer 90°", [90, None, None]), ("inner 90°", [None, 90, None])]
    if senses:
        text.append(f"sense {{{len(numbers)}:0}}")
        buttons += [("sense 1", [None, None, 1]), ("sense −1", [None, None, -1])]
    numbers.append(symbols[2])
    more = {"numbers": numbers, "buttons": buttons, "beside": pictures[1:], "layout": "column"}
    height = 390 + 170 * ((len(pictures) - 1) // 3)
    return formula(pictures[0], symbols, sliders, places, text, height=height, **more)
