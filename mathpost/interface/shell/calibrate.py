"""Readings to a machine file, its errors and a control's terms."""

import argparse
import sys

from mathpost import machine_file
from mathpost.errors import InputError
from mathpost.interface.shell.options import FILE, MACHINE, OUTPUT, given
from mathpost.shop.compensate import handover, readings
from mathpost.shop.compensate.calibrate import calibrate

SAID = ("method", "unit", "axis", "positive", "sigma", "start")  # settings that a file of readings may leave out


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("machine", **MACHINE | {"help": "machine file, TOML, as the control has it"})
    add("readings", nargs="*", **FILE | {"metavar": "READINGS"}, help="CSV files, or .rtl of a laser")
    add(*OUTPUT, **FILE | {"metavar": "OUT"}, help="folder for what is found")
    add("--template", metavar="METHOD", help=f"print a file to fill in: {', '.join(readings.METHODS)}")
    add("--accept", action="store_true", help="write the files although the readings do not fit")
    for name in SAID:
        add(f"--{name}", help="for the files that do not say it")


def run(options: argparse.Namespace) -> int:
    """Print the estimate; write the machine, its errors and the terms. 1 if the readings do not fit."""
    setup = machine_file.load(options.machine)
    if options.template:
        print(readings.template(options.template, setup), end="")
        return 0
    if not options.readings:
        raise InputError("calibrate", "files of readings, or --template", "none")
    found = calibrate(setup, options.readings, **given(options, SAID))
    print(f"{found}\n\n{found.on_trust}")
    if not (found.fits or options.accept):
        print("The readings do not fit: nothing was written. (--accept writes all the same)", file=sys.stderr)
    elif options.output:
        handover.write(found, options.machine, options.output, inputs=options.readings)
    return 0 if found.fits else 1
