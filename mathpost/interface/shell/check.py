"""Check spreadsheets by their formulas: whatever they compute beside a right one, else rotations and NC words."""

import argparse
from dataclasses import replace
from pathlib import Path

from mathpost import machine_file
from mathpost.errors import InputError
from mathpost.files import write_bytes, write_text
from mathpost.interface.shell.options import FILE, LANGUAGE, given, show_progress, vector
from mathpost.teaching import workbook
from mathpost.teaching.workbook.reference.homework import Homework, is_homework, read_homework

NAMES = ("sequence", "convention", "angles", "point", "origin", "machine")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add, out = parser.add_argument, FILE | {"metavar": "OUT"}
    add("path", **FILE | {"metavar": "FILE_OR_FOLDER"}, help="a spreadsheet, or a folder of them")
    add("--reference", **FILE, help="the right workbook: hand-ins are compared with it, whatever it computes")
    add(
        "--task",
        metavar="TASK",
        help="with a reference, a file, made if it is not there; else zxz, sequence, nc, a file",
    )
    add("--sequence", help="ZXZ, ZYX, … about turned axes, zyx about fixed ones")
    add("--convention", choices=("active", "passive"))
    add("--angles", type=vector, metavar="A,B,C", help="degrees, to be found in the input cells")
    add("--point", type=vector, metavar="X,Y,Z", help="to be found in the input cells")
    add("--origin", type=vector, metavar="X,Y,Z", help="to be found in the input cells")
    add(
        "--cells",
        type=_cells,
        metavar="NAME=RANGE,…",
        help="angles=B2:B4,result=D2:D4; with a reference, its cell=theirs",
    )
    add("--machine", **FILE, help="machine file: a table of CL data and NC words")
    add("--why", metavar="CELL", help="which rule gave the verdict of a cell, and the values it used")
    add("--marked", **out, help="copy with coloured cells; of a folder, a folder")
    add("--csv", **out, help="the table of a folder")
    add("--html", **out, help="the table of a folder")
    add("--language", **LANGUAGE)


def run(options: argparse.Namespace) -> int:
    """Print the faults; for a folder a table, with the progress on standard error."""
    task = asked(options)
    if isinstance(task, workbook.Reference) and options.task and not Path(options.task).exists():
        write_text(options.task, task.text(), inputs=[task.path])
        print(f"{options.task} is what was compared; take out what you did not ask for")
    if not options.path.is_dir():
        report = judge(options.path, task)
        print(report)
        if options.why is not None:
            known = report.explain(options.why) if report.explain else ["nothing was judged"]
            print("\n".join(known))
        if options.marked is not None:
            workbook.mark(report, options.marked)
        return report.status
    summary = workbook.check_folder(
        options.path, task, marked=options.marked, language=options.language,
        progress=lambda done, total, path: show_progress(done, total, path.name),
    )  # fmt: skip
    for path, text in ((options.csv, summary.to_csv), (options.html, summary.to_html)):
        if path is not None:
            write_bytes(path, text().encode())
    print(summary)
    return summary.status


def judge(path: Path, task: workbook.Task | workbook.Reference) -> workbook.FileReport:
    """Check one file, with a reference or without."""
    return task.check(path) if isinstance(task, workbook.Reference) else workbook.check_file(path, task)


def asked(options: argparse.Namespace) -> workbook.Task | workbook.Reference:
    """Return the task that the options name, or the reference."""
    if options.machine is not None and len(machine_file.load(options.machine).rotary) < 2:
        raise InputError("--machine", "a machine with two rotary axes", "one")
    path = Path(options.task or "")
    is_file = path.suffix.lower() == ".toml"
    if options.reference is not None or (is_file and is_homework(path)):
        if options.task and not is_file:
            raise InputError("--task", "with a reference a file, such as homework.toml", repr(options.task))
        known = is_file and (path.exists() or options.reference is None)
        homework = read_homework(path, options.reference) if known else Homework(options.reference)
        homework = replace(homework, cells={**homework.cells, **(options.cells or {})})
        known_kind = workbook.Task(**given(options, NAMES))
        return workbook.Reference(homework, lambda file: workbook.check_file(file, known_kind))
    name = options.task or ""
    said = workbook.task_file(name) if name.lower().endswith(".toml") else {"kind": name} if name else {}
    return workbook.Task(**said | given(options, (*NAMES, "cells")))


def _cells(text: str) -> dict[str, str]:
    """Parse NAME=RANGE,NAME=RANGE; a range may contain commas within the quotes of a sheet's name."""
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(name.strip() and address.strip() for name, _, address in pairs):
        raise argparse.ArgumentTypeError(f"expected NAME=RANGE,NAME=RANGE…, found {text!r}")
    return {name.strip(): address.strip() for name, _, address in pairs}
