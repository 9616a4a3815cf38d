"""Check spreadsheets of rotations or NC words by their formulas."""

import argparse

from mathpost import machine, workbook
from mathpost.errors import InputError
from mathpost.files import write_bytes
from mathpost.shell.options import FILE, LANGUAGE, given, show_progress, vector


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add, out = parser.add_argument, FILE | {"metavar": "OUT"}
    add("path", **FILE | {"metavar": "FILE_OR_FOLDER"}, help="a spreadsheet, or a folder of them")
    add("--task", metavar="TASK", help="zxz, sequence, nc, or a TOML file with the options below")
    add("--sequence", help="ZXZ, ZYX, … about turned axes, zyx about fixed ones")
    add("--convention", choices=("active", "passive"))
    add("--angles", type=vector, metavar="A,B,C", help="degrees, to be found in the input cells")
    add("--point", type=vector, metavar="X,Y,Z", help="to be found in the input cells")
    add("--origin", type=vector, metavar="X,Y,Z", help="to be found in the input cells")
    add("--cells", type=_cells, metavar="NAME=RANGE,…", help="angles=B2:B4,point=C2:C4,result=D2:D4")
    add("--machine", **FILE, help="machine file: a table of CL data and NC words")
    add("--why", metavar="CELL", help="which rule gave the verdict of a cell, and the values it used")
    add("--marked", **out, help="copy with coloured cells; of a folder, a folder")
    add("--csv", **out, help="the table of a folder")
    add("--html", **out, help="the table of a folder")
    add("--language", **LANGUAGE)


def run(options: argparse.Namespace) -> int:
    """Print the faults; for a folder a table, with the progress on standard error."""
    task = asked(options)
    if not options.path.is_dir():
        report = workbook.check_file(options.path, task)
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


def asked(options: argparse.Namespace) -> workbook.Task:
    """Return the task that the options name."""
    if options.machine is not None and len(machine.load(options.machine).rotary) < 2:
        raise InputError("--machine", "a machine with two rotary axes", "one")
    name = options.task or ""
    said = workbook.task_file(name) if name.lower().endswith(".toml") else {"kind": name} if name else {}
    names = ("sequence", "convention", "angles", "point", "origin", "cells", "machine")
    return workbook.Task(**said | given(options, names))


def _cells(text: str) -> dict[str, str]:
    """Parse NAME=RANGE,NAME=RANGE; a range may contain commas within the quotes of a sheet's name."""
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(name.strip() and address.strip() for name, _, address in pairs):
        raise argparse.ArgumentTypeError(f"expected NAME=RANGE,NAME=RANGE…, found {text!r}")
    return {name.strip(): address.strip() for name, _, address in pairs}
