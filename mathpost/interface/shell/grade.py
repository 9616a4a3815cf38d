"""A class's notebooks and workbooks: marks, mix-ups, what needs a look."""

import argparse
import os
import sys
from pathlib import Path

from mathpost.errors import INTERNAL, one_line
from mathpost.files import write_set
from mathpost.interface.shell.options import FILE, LANGUAGE, OUTPUT, show_progress
from mathpost.teaching.classroom import grade, grade_page
from mathpost.teaching.classroom.kept import Kept
from mathpost.teaching.workbook import Reference, check_file
from mathpost.teaching.workbook.reference.homework import read_homework


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("folder", **FILE | {"metavar": "FOLDER"}, help="what was handed in, or a zip of it")
    add(
        *OUTPUT,
        **FILE | {"metavar": "REPORT"},
        required=True,
        help="writes .html, .csv and .judged",
    )
    add("--rules", **FILE, help="points, weights and who should hand in, TOML")
    add("--reference", **FILE, help="the right workbook, with which workbooks are compared; or its homework.toml")
    add("--lessons", **FILE | {"metavar": "FOLDER"}, help="what was handed out (default: the course)")
    add("--language", **LANGUAGE)


def run(options: argparse.Namespace) -> int:
    """Write the report; return 1 if something was not read or a verdict was edited, 2 after an internal error."""
    rules = grade.read_rules(options.rules) if options.rules else None
    report = options.output.with_suffix("") if options.output.suffix in (".html", ".csv") else options.output
    among = Path(os.path.realpath(options.folder)) in Path(os.path.realpath(report)).parents
    kept = Kept(None if among else report.with_name(f"{report.name}.judged"))
    reference = None
    if options.reference is not None:
        is_file = options.reference.suffix.lower() == ".toml"
        reference = Reference(read_homework(options.reference) if is_file else options.reference, check_file)
    graded = grade.grade(
        options.folder, rules, lessons=options.lessons, kept=kept, reference=reference, progress=show_progress
    )
    if among:
        graded.notes.append("Nothing was kept for the next time: the report is among the files handed in.")
    graded.notes.append("No notebook was run.")
    for note in graded.notes:
        print(note, file=sys.stderr)
    page, table = (report.with_name(report.name + suffix) for suffix in (".html", ".csv"))
    made = {page: grade_page.to_html, table: grade_page.to_csv}
    write_set({path: text(graded, options.language) for path, text in made.items()})
    print(f"students: {len(graded.results)}; {page}, {table}")
    found = [(each.name, *trouble) for each in graded.results for trouble in each.trouble]
    found += [(each.name, name, "edited") for each in graded.results for name in each.edited]
    for name, what, why in found:
        print(one_line(f"{name}: {what}{': ' * bool(what)}{why}"), file=sys.stderr)
    return 2 if any(why.startswith(INTERNAL) for _, _, why in found) else int(bool(found))
