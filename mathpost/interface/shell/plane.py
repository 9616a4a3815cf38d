"""A tilted plane in every control's words, the third angle, and a machine's positions on it."""

from __future__ import annotations

import argparse
import json
import re
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost import euler, machine_file
from mathpost.chain import machine_frames
from mathpost.errors import InputError
from mathpost.files import text_of
from mathpost.frame import Frame
from mathpost.interface.shell.options import FILE, JSON, PRESENT, THREE, named
from mathpost.interface.shell.pose import control_lines, floats, position_rows, standing
from mathpost.kinematics import Kinematics
from mathpost.path.nc_words import Words
from mathpost.rotation import wrap
from mathpost.shop.controls import plane_blocks
from mathpost.shop.controls.plane_forms import FORMS, HEADS
from mathpost.shop.plane import pose, positioning
from mathpost.shop.plane.tilted_plane import NOTATIONS, Plane

if TYPE_CHECKING:
    from mathpost.shop.plane.pose import Position

SAME = 1e-6  # degrees: angles nearer than this are one
SEEN = 10.0  # mm along the plane's X of a point whose place with a wrong K is shown


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add(
        "words", nargs="*", metavar="WORD",
        help="as typed: G68.2 I135 J54.7356 K-90 or any other of its forms (P1 to P4, G68.3, G68.4, G68 I J K R, "
        "G268, CALL OO88), PLANE SPATIAL …, CYCLE800(…)",
    )  # fmt: skip
    add("--point", **THREE, action="append", metavar=("X", "Y", "Z"), help="three of them: origin, on X, towards Y")
    add("--normal", **THREE, metavar=("I", "J", "K"), help="direction of the plane's Z")
    add("--x", **THREE, metavar=("I", "J", "K"), help="direction of its X (default: level, K is 0)")
    add("--origin", **THREE, metavar=("X", "Y", "Z"), help="of the plane in the workpiece, mm")
    add("--keep", choices=("B", "N"), default="", help="of a PLANE VECTOR whose B and N are not square")
    add("--machine", **FILE, help="machine file: its positions, the third angle for it, the work offset")
    add("--from", **PRESENT)
    add("--json", **JSON)


def run(options: argparse.Namespace) -> int:
    """Print the plane; return 1 if the machine has no position inside travel."""
    kinematics = None if options.machine is None else Kinematics(machine_file.load(options.machine))
    names = () if kinematics is None else kinematics.machine.joint_names[3:]
    present = np.array(standing(options, names))
    plane, form = _read(options, kinematics, present)
    plane = plane.to("G68.2")
    answer: dict[str, Any] = {"form": FORMS[form] if form else None, "clockwise": bool(plane.frame.z[2] < -SAME)}
    answer |= {"origin": plane.origin, "x": plane.frame.x, "y": plane.frame.y, "z": plane.frame.z}
    answer |= {"words": _words(plane), "wrong": _wrong(plane)}
    found, lines = [], _plane_lines(plane, answer)
    if options.point or form == "p2":
        lines[:0] = [_order(plane)]
    if form:
        said = FORMS[form]
        beware = f" Beware: {said['beware']}." * bool(said["beware"])
        about = f"{said['words']} is read as {said['is']}. Source: {said['source']}.{beware}"
        lines[:0] = [*textwrap.wrap(about, 110), ""]
    if kinematics is not None:
        found = pose.positions(kinematics, plane.origin, plane.frame.z, present)
        taken = pose.taken(kinematics, plane.frame.z, present)
        left = [_left(kinematics, plane, each) for each in found]
        controls = pose.as_data(kinematics, taken)
        answer["machine"] = {"name": kinematics.machine.name, "positions": left, "controls": controls}
        lines += ["", *_machine_lines(kinematics, plane, found, left), ""]
        lines += control_lines(kinematics, found, present.tolist(), taken)
    if options.json:
        print(json.dumps(answer, default=np.ndarray.tolist, ensure_ascii=False, indent=1))
    else:
        print(*lines, sep="\n")
    return int(bool(found) and all(each.reasons for each in found))


def _order(plane: Plane) -> str:
    """Say on which side of three points Z is, and what it is with two of them exchanged."""
    side, height = "in an upright plane: Z is level", plane.frame.z[2]
    if abs(height) > SAME:
        turn = "clockwise" if height < 0 else "anticlockwise"
        side = f"{turn} seen from above: Z points {'down' if height < 0 else 'up'}"
    exchanged = "Exchanging the second and the third turns the plane over: Z is the opposite."
    return f"The three points run {side}. {exchanged}"


def _fixture(words: Words, kinematics: Kinematics | None) -> Plane:
    """CALL OO88: the workpiece turns with the rotary axes, and the plane is square to the machine."""
    if kinematics is None:
        raise InputError("CALL OO88", "--machine: it states positions of its axes", "none")
    joints = dict.fromkeys(kinematics.machine.joint_names, 0.0)
    for name in joints:
        joints[name] = float(words.take([f"P{name}"], optional=True)[0])
    words.take(["PH", "PP"], optional=True)
    words.done()
    if any(joints[name] for name in "XYZ"):
        raise InputError("CALL OO88", "PX, PY and PZ 0", "another number, and in whose axes it counts is not known")
    workpiece, _ = machine_frames(kinematics.machine, [0, 0, 0, *list(joints.values())[3:]], degrees=True)
    return Plane.from_frame(Frame(workpiece.rotation.T, np.zeros(3)), "G68.2")


def _read(options: argparse.Namespace, kinematics: Kinematics | None, present: np.ndarray) -> tuple[Plane, str]:
    """Return the plane that the options state, in one way or another, and the form of its words."""
    said = [name for name in ("words", "point", "normal") if getattr(options, name)]
    if len(said) != 1:
        raise InputError("plane", "a control's words, three --point, or --normal", " and ".join(said) or "nothing")
    if options.x and not options.normal:
        raise InputError("--x", "--normal beside it", "none")
    origin = floats(options.origin) if options.origin else None
    if options.words:
        text = " ".join(options.words).upper()
        if not text.startswith("CYCLE"):  # a decimal comma
            text = re.sub(r"(?<=\d),(?=\d)", ".", text)
        words = Words(text, "CALL OO88")
        if words.begin("CALL OO88"):
            plane, form = _fixture(words, kinematics), "oo88"
        else:
            tool = None if kinematics is None else kinematics.forward(np.r_[np.zeros(3), present], degrees=True)[1]
            blocks = re.sub(rf"\s+(?=(?:{'|'.join(map(re.escape, HEADS))})\s)", "\n", text)
            plane, form = plane_blocks.read(blocks, keep=options.keep, tool=tool)
        return plane if origin is None else Plane(plane.notation, plane.values, origin, plane.keep), form
    if options.point:
        if len(options.point) != 3:
            expected = "three points: the origin, one on X, one towards Y"
            raise InputError("--point", expected, f"{len(options.point)}")
        place, second, third = map(floats, options.point)
        x, z = second - place, np.cross(second - place, third - place)
    else:
        place, z = np.zeros(3), floats(options.normal)
        x = floats(options.x) if options.x else euler.matrix("ZXZ", euler.from_direction("ZXZ", z))[:, 0]
    return Plane.from_frame(Frame.from_axes(z, x, place if origin is None else origin), "G68.2"), ""


def _words(plane: Plane) -> dict[str, dict[str, str]]:
    """Return each notation with its block, and a note where it locks."""
    found = {}
    for notation in NOTATIONS:
        written = plane.to(notation)
        found[notation] = {"block": plane_blocks.to_text(written), "note": written.note}
    return found


def _wrong(plane: Plane) -> list[dict[str, Any]]:
    """Return the effect of wrong values of K: the plane stays, but everything on it turns about its origin."""
    first, middle, third = plane.values
    rows = {"left out": 0.0, "with the other sign": -third, "of the twin, with these I and J": third + 180}
    by_value: dict[float, list[str]] = {}
    for why, other in rows.items():
        if abs(wrap(other - third)) > SAME:
            by_value.setdefault(round(float(wrap(other)), 9), []).append(why)
    found = []
    for other, reasons in by_value.items():
        frame = Plane("G68.2", np.array([first, middle, other]), plane.origin).frame
        row = {"why": " or ".join(reasons), "K": other, "turned": float(wrap(other - third))}
        found.append(row | {"point": frame.point([SEEN, 0, 0])})
    return found


def _left(kinematics: Kinematics, plane: Plane, position: Position) -> dict[str, Any]:
    """Return the rotation left between feature and machine at a position, and the work offset there."""
    angles = position.joints[3:]
    alignment = positioning.align(plane.frame, kinematics)
    solution = alignment.at(angles)
    workpiece, _ = machine_frames(kinematics.machine, [0, 0, 0, *angles], degrees=True)
    return {
        "joints": dict(zip(kinematics.machine.joint_names, position.joints.tolist(), strict=True)),
        "out_of_travel": list(position.reasons),
        "rho": solution.rho,
        "K": solution.third_angle(),
        "parallel": ["".join(pair) for pair in solution.parallel],
        "offset": workpiece.point(plane.origin),
    }


def _plane_lines(plane: Plane, answer: dict[str, Any]) -> list[str]:
    lines = [f"origin {named('XYZ', plane.origin)} mm"]
    lines += [f"{name.upper()} {' '.join(f'{x:z.6f}' for x in answer[name])}" for name in "xyz"]
    lines.append("")
    for notation, said in answer["words"].items():
        *before, last = said["block"].splitlines()
        axes = notation.removeprefix("CYCLE800 ") if notation.startswith("CYCLE800") else ""
        lines += [*before, f"{last}  ; {axes}" if axes else last]
        lines += [f"   ({said['note']})"] * bool(said["note"])
    lines.append(f"The same plane: G68.2 {named('IJK', euler.twin('ZXZ', plane.values, degrees=True))}")
    here = " ".join(text_of(x) for x in plane.frame.point([SEEN, 0, 0]))
    said = f"K turns what lies on the plane, not the plane. X{SEEN:g} of it is at {here} in the workpiece. With a K"
    lines += ["", said] if answer["wrong"] else []
    for row in answer["wrong"]:
        at, turned = " ".join(text_of(x) for x in row["point"]), text_of(row["turned"])
        lines.append(f"   {row['why']} (K {text_of(row['K'])}): all is turned by {turned}°, X{SEEN:g} is at {at}")
    return lines


def _machine_lines(
    kinematics: Kinematics, plane: Plane, found: Sequence[Position], left: Sequence[dict[str, Any]]
) -> list[str]:
    """Return lines on the positions, the rotation left at each, and the work offset."""
    model = kinematics.machine
    lines = [f"{model.name} ({model.arrangement})", *position_rows(kinematics, found), ""]
    for n, row in enumerate(left, 1):
        said = "the spindle's X lies along the plane's X"
        if abs(wrap(row["rho"])) > SAME:
            turned, right = text_of(-row["rho"]), text_of(row["K"])
            said = f"the spindle's X is {turned}° from the plane's X, with K {right} along it"
        beside = [f"{pair[0]} along the plane's {pair[1]}" for pair in row["parallel"] if pair[1] != "Z"]
        parallel = ", ".join(beside) or "no slide is parallel to its X or Y"
        lines.append(f"{n}: K {text_of(float(plane['K']))}: {said}; {parallel}")
    if "table" in model.arrangement:
        lines.append("Work offset at the plane's origin when the table has turned there, machine coordinates, mm:")
        lines += [f"{n}: {named('XYZ', row['offset'])}" for n, row in enumerate(left, 1)]
    return lines
