"""A machine as a page that moves, with the signs of its axes in words."""

import argparse

from mathpost import machine_file
from mathpost.files import write_text
from mathpost.interface.shell.options import FILE, MACHINE, OUTPUT
from mathpost.kinematics import Kinematics
from mathpost.teaching.course import machine_page


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("machine", **MACHINE)
    parser.add_argument(*OUTPUT, **FILE | {"metavar": "PAGE"}, required=True, help="HTML")


def run(options: argparse.Namespace) -> int:
    """Write the page."""
    write_text(options.output, machine_page.page(Kinematics(machine_file.load(options.machine))))
    return 0
