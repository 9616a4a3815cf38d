"""The course, the machines, the commands and the reference as pages that need no server and no network."""

import argparse
from pathlib import Path

from mathpost.interface.shell.options import FILE, OUTPUT
from mathpost.interface.site import sources


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add(
        "lessons", nargs="?", default=Path("notebooks"), **FILE | {"metavar": "LESSONS"}, help="folder of notebooks"
    )
    add(*OUTPUT, **FILE | {"metavar": "FOLDER"}, required=True, help="open index.html in it")


def run(options: argparse.Namespace) -> int:
    """Write the pages."""
    return sources.build(options.lessons, options.output)
