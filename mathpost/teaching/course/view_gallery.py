"""Several machines side by side, for lessons 03b and 04: turned together, or following one ring."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from mathpost import chain
from mathpost.errors import InputError
from mathpost.teaching.draw import scene
from mathpost.teaching.draw.arrangement import placing
from mathpost.teaching.draw.live import Live, TextLine, formula, slider
from mathpost.teaching.draw.scene import Label, Line, Scene
from mathpost.teaching.draw.solid import Solid, put

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

_DEGREES = 180 / sp.pi
_APART = np.radians(24)  # as it is seen, between two axes of a small picture
_CAMERAS = [*scene.CAMERAS, (20, 35)]


def gallery(
    kinematics: Sequence[Kinematics], *, workpiece: float = 40.0, tool: float = 30.0, senses: bool = False
) -> Live:
    """Several machines, turned together by two sliders, one for the rotary axis next to the workpiece, one for that
    next to the tool; their tips stay in place. Angles in degrees.

    `senses` adds buttons for the sense: with −1 both axes turn against their programmed angles, as when a
    table is modelled as a head.
    """
    symbols = sp.symbols("workpiece tool sense", real=True)
    turned = symbols[2] * symbols[0], symbols[2] * symbols[1]
    drawn, places, text = _side_by_side(kinematics, lambda *_: turned, (workpiece, tool))
    sliders = [slider("next to workpiece", -180, 180, workpiece), slider("next to tool", -90, 90, tool)]
    sliders.append(slider("sense", -1, 1, 1, unit="", hidden=True))
    buttons = [
        ("0, 0", [0, 0, None]),
        ("workpiece side 90°", [90, None, None]),
        ("tool side 90°", [None, 90, None]),
    ]
    if senses:
        text.append(("sense {:0}", symbols[2]))
        buttons += [("sense 1", [None, None, 1]), ("sense −1", [None, None, -1])]
    height = 390 + 170 * ((len(drawn) - 1) // 3)
    return formula(drawn, symbols, sliders, places, text, buttons=buttons, height=height, layout="column")


def ring(kinematics: Sequence[Kinematics], *, radius: float, height: float, lean: float) -> Live:
    """Several machines side by side that follow one ring, tool leaning outwards; the slider of the place plays.

    The ring is given in the workpiece: mm and degrees. Each machine stays on the first of its two branches.
    """
    place = sp.Symbol("place", real=True)
    tip = sp.Matrix([radius * sp.cos(place), radius * sp.sin(place), height])
    sine, cosine = np.sin(np.radians(lean)), np.cos(np.radians(lean))

    def start(kin: Kinematics) -> tuple[float, float]:
        """Return the angles next to the workpiece and next to the tool at the first place, radians."""
        joints = kin.inverse([radius, 0, height], [sine, 0, cosine])[0].round(12)
        return float(joints[kin.workpiece_side]), float(joints[kin.tool_side])

    def turns(kin: Kinematics) -> tuple[sp.Expr, sp.Expr]:
        """Return both angles: the first grows with the place, the second is constant."""
        beside_workpiece, beside_tool = start(kin)
        return place + beside_workpiece, beside_tool

    starts = [np.degrees(start(kin)) for kin in kinematics]
    drawn, places, text = _side_by_side(kinematics, turns, starts, tip)
    circle = np.linspace(0, 2 * np.pi, 73)
    path = np.stack([radius * np.cos(circle), radius * np.sin(circle), np.full_like(circle, height)], axis=-1)
    for number, picture in enumerate(drawn):
        picture.lines.append(Line(f"{number} workpiece", [path], "#000000", 1.4, over=True))
    sliders = [slider("place", 0, 360, 0)]
    return formula(drawn, [place], sliders, places, text, play=0, height=390, layout="column")


def _side_by_side(
    kinematics: Sequence[Kinematics],
    turns: Callable[[Kinematics], tuple[sp.Expr, sp.Expr]],
    start: Sequence[Any],
    tip: sp.Matrix | None = None,
) -> tuple[list[Scene], dict[str, sp.Matrix], list[TextLine]]:
    """Return scenes of machines, the places of their bodies, and lines of slides or tool axes, for `formula`.

    ``turns(kin)`` gives the angles of the axes next to the workpiece and next to the tool; `start` has both at the
    start in degrees, for all machines or for each. The `tip` is given in the workpiece, or stays in place.
    """
    drawn = []
    text: list[TextLine] = []
    places: dict[str, sp.Matrix] = {}
    starts = np.broadcast_to(start, (len(kinematics), 2))
    for number, (kin, beginning) in enumerate(zip(kinematics, starts, strict=True)):
        model, derived = kin.machine, kin.inverse_symbolic
        if kin.tool_side is None:
            raise InputError(model.name, "a machine with two rotary axes", "one")
        picture, made = scene.machine(
            kin, title=f"{number + 1} · {model.arrangement}: {derived.workpiece_side} → {derived.tool_side}"
        )
        at = kin.forward(made.home)[0] if tip is None else tip
        turned = dict(zip((derived.workpiece_side, derived.tool_side), turns(kin), strict=True))
        at_tip = dict(zip(derived.tip, at, strict=True))
        slides = [coordinate.xreplace(at_tip | turned) for coordinate in derived.linear]
        joints = dict(zip(kin.symbols, slides, strict=False)) | turned
        places |= {f"{number} {name}": matrix.xreplace(joints) for name, matrix in chain.bodies(model)}
        angles = beginning if kin.workpiece_side < kin.tool_side else beginning[::-1]
        first = np.array([float(each) for each in kin.forward(made.home)[0]])
        begin = kin.close(first, np.radians(angles))
        stand, still = placing(model)(begin), ("bed", *model.joint_names[:3])
        bodies = [(each.body, each.triangles().reshape(-1, 3)) for each in picture.solids if each.body not in still]
        lines = [(line.body, np.array(part)) for line in picture.lines for part in line.parts]
        reach = [put(stand[body], points) for body, points in (*bodies, *lines)]
        picture.extent = np.concatenate([picture.extent, *reach])
        _, picture = scene.best(kin, picture, [begin], aspect=1.0, cameras=_CAMERAS, apart=_APART)
        parts: list[Solid | Line | Label] = [*picture.solids, *picture.lines, *picture.labels]
        for part in parts:
            part.body = part.body if part.body == "bed" else f"{number} {part.body}"
        drawn.append(picture)
        if tip is None:
            before, *axes = text.pop() if number % 2 else ("",)  # two machines in a line
            line = f"{before}{'; ' * bool(before)}{number + 1} {model.name}: n = ({{:4}}, {{:4}}, {{:4}})"
            text.append((line, *axes, *kin.forward_symbolic()[:3, 2].xreplace(turned)))
        else:
            shown = [joints[symbol] * (1 if n < 3 else _DEGREES) for n, symbol in enumerate(kin.symbols)]
            words = " ".join(f"{symbol}{{:1}}" for symbol in kin.symbols)
            text.append((f"{number + 1} {model.name}: {words}", *shown))
    return drawn, places, text
