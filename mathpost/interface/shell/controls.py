"""The controls that programs are written for, and one of their files to copy."""

import argparse

from mathpost.errors import InputError
from mathpost.files import data_file, read_text
from mathpost.interface.shell.options import FILE, OUTPUT, write
from mathpost.shop.controls import control


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("name", nargs="?", help="print the file of this control, to be copied and changed")
    parser.add_argument(*OUTPUT, **FILE, help="by default standard output")


def run(options: argparse.Namespace) -> int:
    """List the controls with their sources, or print one."""
    if options.name is None:
        for name in control.names():
            print(f"{name:12} {control.load(name).source}")
        return 0
    if options.name not in control.names():
        raise InputError("controls", " or ".join(control.names()), repr(options.name))
    write(options.output, read_text(data_file(f"controls/{options.name}.toml")))
    return 0
