"""Run lessons anew and say what changed."""

import argparse
from pathlib import Path

from mathpost.interface.shell.options import FILE
from mathpost.teaching.classroom import lessons


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    rerun = parser.add_subparsers(required=True).add_parser("rerun", help="run lessons anew and say what changed")
    rerun.add_argument("path", nargs="*", **FILE | {"metavar": "NOTEBOOK"}, help="default: notebooks/*.ipynb")
    rerun.add_argument("--accept", action="store_true", help="write the new outputs")


def run(options: argparse.Namespace) -> int:
    """Print the numbers and pictures that changed; return 1 if there are any that were not accepted."""
    changed = 0
    for path in options.path or sorted(Path("notebooks").glob("*.ipynb")):
        changes = lessons.rerun(path, accept=options.accept)
        changed += len(changes)
        print(f"{path}: {len(changes)} changed" if changes else f"{path}: as before")
        print(*changes, sep="\n", end="\n" * bool(changes))
    return int(bool(changed) and not options.accept)
