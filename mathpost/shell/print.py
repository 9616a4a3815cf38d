"""Forward, inverse and Jacobian of a machine as JavaScript, C or LaTeX."""

import argparse

from mathpost import codegen, machine
from mathpost.kinematics import Kinematics
from mathpost.shell.options import FILE, MACHINE, OUTPUT, write


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    parser.add_argument("machine", **MACHINE)
    parser.add_argument("--to", choices=codegen.LANGUAGES, required=True)
    parser.add_argument(*OUTPUT, **FILE, help="by default standard output")


def run(options: argparse.Namespace) -> int:
    """Print the functions of a machine."""
    write(options.output, codegen.machine(Kinematics(machine.load(options.machine)), options.to))
    return 0
