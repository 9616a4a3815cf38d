"""Which misreading of the convention gives this number?"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost import machine_file
from mathpost.detective.euler_angles import explain
from mathpost.detective.positions import explain_linear, explain_tip
from mathpost.detective.rotary_axes import explain_joints
from mathpost.detective.rotations import explain_rotation
from mathpost.errors import InputError
from mathpost.interface.shell.options import FILE, THREE, number
from mathpost.kinematics import Kinematics

if TYPE_CHECKING:
    from mathpost.detective.explanation import Explanation

ROW: dict[str, Any] = {"nargs": "+", "type": number, "action": "append"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("--angles", **THREE, metavar=("α", "β", "γ"), help="three Euler angles, degrees")
    add("--quaternion", nargs=4, type=number, metavar=("W", "X", "Y", "Z"), help="instead of angles")
    add("--sequence", default="ZXZ", metavar="AXES", help="of the angles: ZXZ about turned, zxz about fixed axes")
    add("--result-sequence", metavar="AXES", help="of the angles of the result, if others; xyzw of a quaternion")
    add("--convention", choices=("passive", "active"), help="passive, as points are "
        "read: coordinates in the turned frame; active, as a --result alone is: turned with it")  # fmt: skip
    add("--point", **THREE, action="append", metavar=("X", "Y", "Z"), help="may be given again")
    add("--origin", **THREE, metavar=("X", "Y", "Z"), help="of the turned frame")
    add("--matrix", nargs=9, type=number, metavar="M", help="row by row: the answer "
        "instead of points; with --result, the rotation that is known")  # fmt: skip
    add("--machine", **FILE, help="machine file: explain its words")
    add("--axis", **THREE, action="append", metavar=("I", "J", "K"), help="tool axis of the CL data")
    add("--tip", **THREE, action="append", metavar=("X", "Y", "Z"), help="tool tip of the CL data")
    add("--rotary", **ROW, metavar="Q", help="the rotary words that go with --tip")
    add("--joints", **ROW, metavar="Q", help="all words; the result is the tip that somebody has for them")
    add(
        "--result", **ROW, metavar="N",
        help="what someone got, once for each --point, --axis, --tip or --joints: a point; with --machine rotary "
        "words, X Y Z, both or a tip; without a point angles, a quaternion or a matrix, compared as rotations",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Print what gives the answer; return 0 if it is right, 1 if not."""
    found = _of_machine(options) if options.machine is not None else [_of_rotation(options)]
    print(*found, sep="\n")
    return int(not all(each.right and not each.travel for each in found))


def _need(options: argparse.Namespace, *names: str) -> None:
    for name in names:
        if not getattr(options, name):
            raise InputError("explain", f"--{name}", "nothing")


def _rows(options: argparse.Namespace, *names: str) -> list[list]:
    """Return the rows of several options, equally many, of one length in each; a single row by itself."""
    _need(options, *names)
    rows = [getattr(options, name) for name in names]
    for name, several in zip(names, rows, strict=True):
        if len(several) != len(rows[0]) or len({len(row) for row in several}) > 1:
            raise InputError(f"--{name}", f"{len(rows[0])} of one length", f"{[len(row) for row in several]}")
    return [several[0] if len(several) == 1 else several for several in rows]


def _of_rotation(options: argparse.Namespace) -> Explanation:
    """Explain an answer that involves no machine."""
    given = options.angles or options.quaternion or (options.result and options.matrix)
    convention = options.convention or "passive"
    of_points = {"sequence": options.sequence, "origin": options.origin, "convention": convention}
    if options.matrix is not None and options.matrix is not given:
        _need(options, "angles")
        answer = [options.matrix[n : n + 3] for n in (0, 3, 6)]
        return explain(options.angles, None, answer, **of_points)
    if given and options.result and not options.point and len(options.result) == 1:
        sequences = {"sequence": options.sequence, "answer_sequence": options.result_sequence}
        return explain_rotation(given, _active(options.result[0], options.convention), **sequences)
    _need(options, "angles")
    point, result = _rows(options, "point", "result")
    return explain(options.angles, point, result, **of_points)


def _active(numbers: list[str], convention: str | None) -> list[str]:
    """The numbers of a rotation, those of a passive matrix transposed."""
    passive_matrix = convention == "passive" and len(numbers) == 9
    return [numbers[3 * column + row] for row in range(3) for column in range(3)] if passive_matrix else numbers


def _of_machine(options: argparse.Namespace) -> list[Explanation]:
    """Explain the words of a machine."""
    kinematics = Kinematics(machine_file.load(options.machine))
    if options.joints:
        return [explain_tip(kinematics, *_rows(options, "joints", "result"))]
    if options.tip and options.rotary:
        return [explain_linear(kinematics, *_rows(options, "tip", "rotary", "result"))]
    if not options.tip:
        return [explain_joints(kinematics, *_rows(options, "axis", "result"))]
    rows = _rows(options, "tip", "axis", "result")
    tip, axis, result = (np.atleast_2d(np.array(row, dtype=object)) for row in rows)
    if result.shape[1] != len(kinematics.symbols):
        raise InputError("--result", f"all words, {' '.join(kinematics.machine.joint_names)}", f"{result.shape[1]}")
    return [
        explain_joints(kinematics, axis.tolist(), result[:, 3:].tolist()),
        explain_linear(kinematics, tip.tolist(), result[:, 3:].tolist(), result[:, :3].tolist()),
    ]
