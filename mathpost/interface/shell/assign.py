"""Lessons for students, without solutions."""

import argparse
import sys

from mathpost.files import read_text
from mathpost.interface.shell.options import FILE, OUTPUT
from mathpost.teaching.classroom import assign
from mathpost.teaching.course.verdict import EXERCISES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("lessons", **FILE | {"metavar": "LESSONS"}, help="a notebook, or a folder of notebooks")
    add(*OUTPUT, **FILE | {"metavar": "FOLDER"}, required=True)
    add("--students", metavar="FILE", help="a name on each line: a copy for each, with own numbers")


def run(options: argparse.Namespace) -> int:
    """Write the copies, and say what they cannot hide."""
    lines = read_text(options.students).splitlines() if options.students else ()
    students = list(filter(None, map(str.strip, lines)))
    asked = assign.assign(options.lessons, options.output, students)
    for path, names in asked.items():
        print(f"{path}: {', '.join(names) or 'no exercises'}")
    own = sorted(set().union(*asked.values()) & {name for name, each in EXERCISES.items() if each.drawn})
    said = "The numbers of these exercises"
    if students:
        said = f"Each student has numbers of their own in {', '.join(own) or 'no exercise'}"
        said += "; the numbers of the others"
    print(f"{said} are the same for all.", file=sys.stderr)
    print("The package holds the solutions of its own exercises: who has it can read them.", file=sys.stderr)
    return 0
