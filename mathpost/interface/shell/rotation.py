"""A rotation in any notation: all the others, who uses which, and whether it is one."""

import argparse

from mathpost.detective import notations


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("notation", metavar="NOTATION", help=f"what the numbers are: {notations.EXPECTED}")
    add("numbers", nargs="+", metavar="NUMBER", help="brackets and commas between them are passed over")
    add("--unit", choices=("deg", "rad"), help="of angles (default deg, of a rotation vector rad)")


def run(options: argparse.Namespace) -> int:
    """Print the rotation; return 1 if the numbers are none to their digits."""
    radians = None if options.unit is None else options.unit == "rad"
    found = notations.read(options.notation, notations.numbers(options.numbers), radians=radians)
    print(found)
    return int(bool(found.fault))
