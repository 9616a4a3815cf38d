"""Which misreading of the convention gives this number?"""

import argparse

from mathpost import machine
from mathpost.detective.euler_angles import explain
from mathpost.detective.rotary_axes import explain_joints
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.shell.options import FILE, number

THREE = {"nargs": 3, "type": number}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    add = parser.add_argument
    add("--angles", **THREE, metavar=("α", "β", "γ"), help="three Euler angles, degrees")
    add("--sequence", default="ZXZ", metavar="AXES", help="their axes (default %(default)s)")
    add("--point", **THREE, action="append", metavar=("X", "Y", "Z"), help="may be given again")
    add("--origin", **THREE, metavar=("X", "Y", "Z"), help="of the turned frame")
    add("--matrix", nargs=9, type=number, metavar="M", help="the answer, row by row, instead of points")
    add("--machine", **FILE, help="machine file: explain its rotary words")
    add("--axis", **THREE, action="append", metavar=("I", "J", "K"), help="tool axis of the CL data")
    add(
        "--result", nargs="+", type=number, action="append", metavar="N",
        help="what someone got: a point, or with --machine two rotary words; once for each --point or --axis",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Print what gives the answer; 0 if it is right, 1 if not."""
    if options.machine is None and options.matrix is not None:
        needed, given = ["angles"], None
        results = [options.matrix[n : n + 3] for n in (0, 3, 6)]
    else:
        needed = ["angles", "point", "result"] if options.machine is None else ["axis", "result"]
        given, results = getattr(options, needed[-2]), options.result
    for name in needed:
        if not getattr(options, name):
            raise InputError("explain", f"--{name}", "nothing")
    if given:
        if len({len(row) for row in results}) > 1 or len(given) != len(results):
            raise InputError("--result", f"{len(given)} of one length", f"{[len(row) for row in results]}")
        given, results = (given[0], results[0]) if len(given) == 1 else (given, results)
    if options.machine is not None:
        found = explain_joints(Kinematics(machine.load(options.machine)), given, results)
    else:
        found = explain(options.angles, given, results, sequence=options.sequence.upper(), origin=options.origin)
    print(found)
    return int(not found.right)
