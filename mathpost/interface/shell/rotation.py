"""A rotation in any notation: all the others, who uses which, and whether it is one."""

import argparse
import json

from mathpost import euler
from mathpost.detective import notations
from mathpost.interface.shell.options import JSON


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("notation", metavar="NOTATION", help=f"what the numbers are: {notations.EXPECTED}")
    add("numbers", nargs="+", metavar="NUMBER", help="brackets and commas between them are passed over")
    add("--unit", choices=("deg", "rad"), help="of angles (default deg, of a rotation vector rad)")
    add("--inverse", action="store_true", help="the numbers are those of the inverse, as of a passive matrix")
    add("--json", **JSON)


def run(options: argparse.Namespace) -> int:
    """Print the rotation; return 1 if the numbers are none to their digits."""
    radians = None if options.unit is None else options.unit == "rad"
    found = notations.read(options.notation, notations.numbers(options.numbers), radians=radians)
    if options.inverse:
        found = found.inverse()
    print(json.dumps(_data(found), ensure_ascii=False, indent=1) if options.json else found)
    return int(bool(found.fault))


def _data(found: notations.Rotation) -> dict:
    axis, angle = found.axis_angle
    return {
        "fault": found.fault,
        "found": list(found.found),
        "matrix": found.matrix.tolist(),
        "wxyz": found.quaternion.tolist(),
        "vector": found.vector.tolist(),
        "axis": axis.tolist(),
        "angle": angle,
        "angles": {sequence: found.angles(sequence).tolist() for sequence in euler.SEQUENCES},
        "locked": [sequence for sequence in euler.SEQUENCES if found.locked(sequence)],
    }
