"""Forward, inverse and Jacobian of a machine as JavaScript, C or LaTeX, or a folder that runs it on LinuxCNC."""

import argparse
import sys

from mathpost import machine_file
from mathpost.errors import InputError
from mathpost.interface.shell.options import FILE, MACHINE, OUTPUT, write
from mathpost.kinematics import Kinematics
from mathpost.shop import codegen
from mathpost.shop.controls.simulation import write_folder


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("machine", **MACHINE)
    parser.add_argument("--to", choices=(*codegen.LANGUAGES, "linuxcnc"), required=True)
    parser.add_argument(*OUTPUT, **FILE, help="by default standard output; for linuxcnc a folder")


def run(options: argparse.Namespace) -> int:
    """Print the functions of a machine."""
    kin = Kinematics(machine_file.load(options.machine))
    if options.to != "linuxcnc":
        write(options.output, codegen.machine(kin, options.to))
        return 0
    if options.output is None:
        raise InputError("-o", "a folder, for linuxcnc", "none")
    for path in write_folder(kin, options.output):
        print(path, file=sys.stderr)
    return 0
