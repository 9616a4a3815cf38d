"""Views of lessons 03 and 04: a cut corner with its frame, and machines of every arrangement beside each other."""

from dataclasses import replace

import numpy as np
import sympy as sp

from mathpost import angles, chain
from mathpost.draw import plot, scene
from mathpost.draw.arrangement import arrange
from mathpost.draw.formula import formula, slider
from mathpost.draw.scene import Line, Scene
from mathpost.draw.solid import Hull, block

_WORKPIECE, _TOOL = plot.COLOUR["workpiece"], plot.COLOUR["tool"]
STEPS = ("start", "turn I", "turn J", "turn K")


def cut_corner(frame, final, *, side=60.0, cut=45.0):
    """A cube, its zero in the middle of the top face, with the corner (+, +, top) cut off, and a frame on the face.

    Parameters
    ----------
    frame : mathpost.frame.Frame
        Of the face; its origin carries the frame that the sliders I, J, K turn, ZXZ.
    final : sequence of 3 floats
        The angles at the start, degrees; buttons go there turn by turn.
    """
    symbols, half = sp.symbols("I J K", real=True), side / 2
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
    return formula(
        drawn.frame(75, 24),
        symbols,
        [slider(name, -180, 180, value) for name, value in zip("IJK", final, strict=True)],
        {"feature": placed},
        ["z = ({0:4}, {1:4}, {2:4}), off the face by {3:2}°", "x = ({4:4}, {5:4}, {6:4}), off the slope by {7:2}°"],
        numbers=[*turned[:, 2], lean, *turned[:, 0], off],
        buttons=list(zip(STEPS, after, strict=True)),
        height=430,
    )


def gallery(kinematics, *, outer=40.0, inner=30.0):
    """Machines beside each other, turned together by two sliders, outer and inner; their tips stay where they are.

    The outer axis is the one next to the workpiece in the chain, the inner one next to the tool.

    Parameters
    ----------
    kinematics : sequence of Kinematics
    """
    symbols, places, drawn, text, numbers = sp.symbols("outer inner", real=True), {}, [], [], []
    for number, kin in enumerate(kinematics):
        model, derived = kin.machine, kin.inverse_symbolic
        made = arrange(kin)
        turns = dict(zip((derived.outer, derived.inner), symbols, strict=True))
        tip = dict(zip(derived.tip, kin.forward(made.home)[0], strict=True))
        slides = [coordinate.subs(tip).subs(turns) for coordinate in derived.linear]
        joints = dict(zip(chain.joint_symbols(model), slides, strict=False)) | turns
        places |= {f"{number} {name}": matrix.subs(joints) for name, matrix in chain.bodies(model)}
        rotary = [
            np.radians(outer if symbol == derived.outer else inner) for symbol in chain.joint_symbols(model)[3:]
        ]
        at = kin.close(kin.forward(made.home)[0], rotary)
        title = f"{number + 1} · {model.arrangement}: outer {derived.outer}, inner {derived.inner}"
        picture, _ = scene.best_camera(kin, scene.machine(kin, title=title)[0], at, aspect=1.0)
        for part in (*picture.solids, *picture.lines, *picture.labels):
            part.body = part.body if part.body == "bed" else f"{number} {part.body}"
        drawn.append(picture)
        first = len(numbers)
        text.append(f"{number + 1} {model.name}: n = ({{{first}:4}}, {{{first + 1}:4}}, {{{first + 2}:4}})")
        numbers += kin.forward_symbolic()[:3, 2].subs(turns)
    pictures = [replace(picture, bodies=list(places)) for picture in drawn]
    return formula(
        pictures[0],
        symbols,
        [slider("outer", -180, 180, outer), slider("inner", -90, 90, inner)],
        places,
        ["; ".join(text[n : n + 2]) for n in range(0, len(text), 2)],
        numbers=numbers,
        buttons=[("0, 0", [0, 0]), ("outer 90°", [90, None]), ("inner 90°", [None, 90])],
        beside=pictures[1:],
        layout="column",
        height=390 + 240 * ((len(pictures) - 1) // 3),
    )
