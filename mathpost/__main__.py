"""The shell: ``python -m mathpost post …``, ``check …``, ``explain …`` and ``lessons …``."""

import argparse
import math
import os
import re
import signal
import sys
from importlib import metadata
from pathlib import Path

from mathpost import codegen, machine, workbook
from mathpost.compensate.model import read_errors
from mathpost.detective.euler_angles import explain
from mathpost.detective.rotary_axes import explain_joints
from mathpost.errors import InputError, MathpostError, read_text, write_bytes, write_text
from mathpost.kinematics import Kinematics
from mathpost.post import AXIS_TOLERANCE, CONE, TOLERANCE, cl, run
from mathpost.post.program import DIALECTS
from mathpost.post.selection import STRATEGIES
from mathpost.post.ways import Crossing

PARSER = argparse.ArgumentParser(
    prog="python -m mathpost", description="Five-axis post-processing and spreadsheets, verified."
)
PARSER.add_argument("--version", action="version", version=f"mathpost {metadata.version('mathpost')}")
COMMANDS = PARSER.add_subparsers(dest="command", required=True)


def _command(name, said, *arguments, among=COMMANDS):
    """Make a command of the function below: its name, its help and its arguments."""
    command = among.add_parser(name, help=said)
    for names, how in arguments:
        command.add_argument(*names, **how)
    return lambda function: command.set_defaults(run=function) or function


def _arg(*names, **how):
    return names, how


def _file(name="-o", *, metavar="FILE", **how):
    names = ("-o", "--output") if name == "-o" else (name,)
    return _arg(*names, type=Path, metavar=metavar, **how)


def main(arguments=None):
    """Run one command; return the exit status.

    0 is done, or all right; 1 something wrong in what was checked; 2 refused, with the reason on standard error.
    """
    options = PARSER.parse_args(_joined(sys.argv[1:] if arguments is None else arguments))
    if arguments is None:
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # as Ctrl-C
    try:
        status = options.run(options)
        sys.stdout.flush()
        return status
    except MathpostError as error:
        print(f"mathpost: {error}", file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:  # of the extras that a headless post does without
        print(f"mathpost: this command needs {error.name}, which comes with mathpost[course]", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("mathpost: stopped, nothing was written", file=sys.stderr)
        return 130
    except BrokenPipeError:  # somebody reads the first lines only
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:  # standard output is closed, or its disk is full
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, what is left to be written goes nowhere
        print(f"mathpost: standard output: {error.strerror or error}", file=sys.stderr)
        return 2


def _joined(arguments):
    """Keep argparse from taking values for options: vectors such as -1,0,2, numbers such as -1e-16 or -54,7356."""
    if arguments[:1] == ["explain"]:
        return [re.sub(r"^-(?=[\d.,]+(e[+-]?\d+)?°?$)", "−", word) for word in arguments]
    words, vectors = iter(arguments), ("--origin", "--angles", "--point")
    return [f"{word}={next(words, '')}" if word in vectors else word for word in words]


def _vector(text):
    values = tuple(map(float, text.split(",")))
    if len(values) != 3:
        raise argparse.ArgumentTypeError(f"expected three numbers X,Y,Z, found {text!r}")
    return values


def _cells(text):
    """NAME=RANGE,NAME=RANGE; a range may itself hold commas if quoted by the sheet's name."""
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(name.strip() and address.strip() for name, _, address in pairs):
        raise argparse.ArgumentTypeError(f"expected NAME=RANGE,NAME=RANGE…, found {text!r}")
    return {name.strip(): address.strip() for name, _, address in pairs}


def _number(text):
    """The number as it was written, whose digits tell how precise it is; a comma is a decimal point."""
    number = text.replace(",", ".").replace("−", "-").removesuffix("°")
    try:
        float(number)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, found {text!r}") from None
    return number


def _degrees(default):
    return {"type": float, "default": round(math.degrees(default), 9), "metavar": "DEG"}


SAID = ("method", "unit", "axis", "positive", "sigma")  # what a file of readings may leave unsaid
THREE = {"nargs": 3, "type": _number}
MACHINE = _file("machine", metavar="MACHINE", help="machine file, TOML")
LANGUAGE = _arg("--language", choices=("en", "zh"), default="en", help="of the table")


@_command(
    "post",
    "CL data to a verified NC program",
    _file("cl", metavar="CL", help="APT CL file"),
    _file("--machine", required=True, help="machine file, TOML"),
    _arg("--dialect", choices=DIALECTS, default="heidenhain"),
    _arg("--tcp", action="store_true", help="let the control keep the tip: M128, G43.4, TRAORI"),
    _arg("--tolerance", type=float, default=TOLERANCE, metavar="MM", help="default %(default)s"),
    _arg("--axis-tolerance", **_degrees(AXIS_TOLERANCE), help="of the tool axis; default %(default)s"),
    _arg("--selection", dest="strategy", choices=STRATEGIES, default="optimal"),
    _arg("--singular", choices=Crossing.SAFE, default="direct", help="way through singular regions"),
    _arg("--cone", **_degrees(CONE), help="half angle of the singular region (default %(default)g)"),
    _arg("--split", action="store_true", help="retract and unwind where travel ends"),
    _arg("--tool-length", type=float, metavar="MM", help="instead of the machine file's"),
    _arg("--origin", type=_vector, metavar="X,Y,Z", help="workpiece origin, instead of the machine file's"),
    _file("--errors", help="errors of the calibrated machine, TOML, to compensate for"),
    _arg("--compare", action="store_true", help="report other strategies and ways through singular regions, too"),
    _arg("--ignore", default="", metavar="WORD,…", help="words of the CL file taken for comments"),
    _file(help="program; by default standard output"),
)  # fmt: skip
def _post(options):
    """Write the program, and the report to standard error."""
    setup = machine.load(options.machine).with_setup(origin=options.origin, tool_length=options.tool_length)
    ignored = tuple(word.strip() for word in options.ignore.split(",") if word.strip())
    result = run(
        cl.read(options.cl, tolerance=min(cl.ARC_TOLERANCE, options.tolerance / 5), ignored=ignored),
        setup,
        axis_tolerance=math.radians(options.axis_tolerance),
        cone=math.radians(options.cone),
        errors=read_errors(options.errors, setup) if options.errors else None,
        progress=(lambda name: print(f"{name} …", file=sys.stderr)) if sys.stderr.isatty() else None,
        **_given(options, ("dialect", "strategy", "singular", "tolerance", "tcp", "split", "compare")),
    )
    _write(options.output, result.program, inputs=filter(None, (options.cl, options.machine, options.errors)))
    print(result.report, file=sys.stderr)
    return 0


def _given(options, names):
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


def _write(path, text, inputs=()):
    """Write a file, or to standard output if there is no `path`."""
    if path:
        write_text(path, text, inputs=inputs)
    else:
        print(text, end="")


@_command(
    "calibrate",
    "readings to a machine file, its errors and a control's terms",
    _file("machine", metavar="MACHINE", help="machine file, TOML, as the control has it"),
    _file("readings", nargs="*", metavar="READINGS", help="CSV files"),
    _file(metavar="OUT", help="folder for what is found"),
    _arg("--template", metavar="METHOD", help="print a file to fill in: dial, ball, laser, …"),
    _arg("--squareness", action="store_true", help="seek it although no ballbar saw the slides"),
    *(_arg(f"--{name}", help="for the files that do not say it") for name in SAID),
)
def _calibrate(options):
    """Print the estimate; write the machine, its errors and the terms."""
    from mathpost.compensate import handover, readings
    from mathpost.compensate.calibrate import calibrate

    setup = machine.load(options.machine)
    if options.template:
        print(readings.template(options.template, setup), end="")
        return 0
    if not options.readings:
        raise InputError("calibrate", "files of readings, or --template", "none")
    found = calibrate(setup, options.readings, squareness=options.squareness or None, **_given(options, SAID))
    print(found)
    if options.output:
        handover.write(found, options.machine, options.output, inputs=options.readings)
    return 0


@_command(
    "check",
    "check spreadsheets of rotations or NC words by their formulas",
    _file("path", metavar="FILE_OR_FOLDER", help="a spreadsheet, or a folder of them"),
    _arg("--task", metavar="TASK", help="zxz, sequence, nc, or a TOML file with the options below"),
    _arg("--sequence", help="ZXZ, ZYX, … about turned axes, zyx about fixed ones"),
    _arg("--convention", choices=("active", "passive")),
    _arg("--angles", type=_vector, metavar="A,B,C", help="degrees, to be found in the input cells"),
    _arg("--point", type=_vector, metavar="X,Y,Z", help="to be found in the input cells"),
    _arg("--origin", type=_vector, metavar="X,Y,Z", help="to be found in the input cells"),
    _arg("--cells", type=_cells, metavar="NAME=RANGE,…", help="angles=B2:B4,point=C2:C4,result=D2:D4"),
    _file("--machine", help="machine file: a table of CL data and NC words"),
    _file("--marked", metavar="OUT", help="copy with coloured cells; of a folder, a folder"),
    *(_file(f"--{name}", metavar="OUT", help="the table of a folder") for name in ("csv", "html")),
    LANGUAGE,
)
def _check(options):
    """Print what is wrong; of a folder a table, with the progress on standard error."""
    name = options.task or ""
    said = workbook.task_file(name) if name.lower().endswith(".toml") else {"kind": name} if name else {}
    names = ("sequence", "convention", "angles", "point", "origin", "cells", "machine")
    task = workbook.Task(**said | _given(options, names))
    if not options.path.is_dir():
        report = workbook.check_file(options.path, task)
        print(report)
        if options.marked is not None:
            workbook.mark(report, options.marked)
        return report.status
    summary = workbook.check_folder(
        options.path, task, marked=options.marked, language=options.language,
        progress=lambda done, total, path: _step(done, total, path.name),
    )  # fmt: skip
    for path, text in ((options.csv, summary.to_csv), (options.html, summary.to_html)):
        if path is not None:
            write_bytes(path, text().encode())
    print(summary)
    return summary.status


@_command(
    "print",
    "forward, inverse and Jacobian of a machine as JavaScript, C or LaTeX",
    MACHINE,
    _arg("--to", choices=codegen.LANGUAGES, required=True),
    _file(help="by default standard output"),
)
def _print(options):
    """Print the functions of a machine."""
    _write(options.output, codegen.machine(Kinematics(machine.load(options.machine)), options.to))
    return 0


@_command(
    "show",
    "a machine as a page that moves, with the signs of its axes in words",
    MACHINE,
    _file(metavar="PAGE", required=True, help="HTML"),
)
def _show(options):
    """Write the page."""
    from mathpost.course import machine_page

    write_text(options.output, machine_page.page(Kinematics(machine.load(options.machine))))
    return 0


@_command(
    "explain",
    "which misreading of the convention gives this number?",
    _arg("--angles", **THREE, metavar=("α", "β", "γ"), help="three Euler angles, degrees"),
    _arg("--sequence", default="ZXZ", metavar="AXES", help="their axes (default %(default)s)"),
    _arg("--point", **THREE, action="append", metavar=("X", "Y", "Z"), help="may be given again"),
    _arg("--origin", **THREE, metavar=("X", "Y", "Z"), help="of the turned frame"),
    _arg("--matrix", nargs=9, type=_number, metavar="M", help="the answer, row by row, instead of points"),
    _file("--machine", help="machine file: explain its rotary words"),
    _arg("--axis", **THREE, action="append", metavar=("I", "J", "K"), help="tool axis of the CL data"),
    _arg(
        "--result", nargs="+", type=_number, action="append", metavar="N",
        help="what someone got: a point, or with --machine two rotary words; once for each --point or --axis",
    ),
)  # fmt: skip
def _explain(options):
    """Print what gives the answer; 0 if it is right, 1 if not."""
    if options.machine is None and options.matrix is not None:
        needed, given = ["angles"], None
        results = [options.matrix[n : n + 3] for n in (0, 3, 6)]
    else:
        needed = ["angles", "point", "result"] if options.machine is None else ["axis", "result"]
        given, results = getattr(options, needed[-2]), options.result
    for name in needed:
        if not getattr(options, name):
            raise InputError("explain", f"--{name}", "nothing")
    if given:
        if len({len(row) for row in results}) > 1 or len(given) != len(results):
            raise InputError("--result", f"{len(given)} of one length", f"{[len(row) for row in results]}")
        given, results = (given[0], results[0]) if len(given) == 1 else (given, results)
    if options.machine is not None:
        found = explain_joints(Kinematics(machine.load(options.machine)), given, results)
    else:
        found = explain(options.angles, given, results, sequence=options.sequence.upper(), origin=options.origin)
    print(found)
    return int(not found.right)


LESSONS = COMMANDS.add_parser("lessons", help="run lessons anew and say what changed")


@_command(
    "rerun",
    "run lessons anew and say what changed",
    _file("path", nargs="*", metavar="NOTEBOOK", help="default: notebooks/*.ipynb"),
    _arg("--accept", action="store_true", help="write the new outputs"),
    among=LESSONS.add_subparsers(required=True),
)
def _rerun(options):
    """Print the numbers and pictures that changed; 1 if there are any that were not accepted."""
    from mathpost.course import lessons

    changed = 0
    for path in options.path or sorted(Path("notebooks").glob("*.ipynb")):
        changes = lessons.rerun(path, accept=options.accept)
        changed += len(changes)
        print(f"{path}: {len(changes)} changed" if changes else f"{path}: as before")
        print(*changes, sep="\n", end="\n" * bool(changes))
    return int(bool(changed) and not options.accept)


@_command(
    "grade",
    "a class's notebooks and workbooks: marks, mix-ups, what needs a look",
    _file("folder", metavar="FOLDER", help="what was handed in, or a zip of it"),
    _file(metavar="REPORT", required=True, help="writes .html and .csv"),
    _file("--rules", help="points, weights and who should hand in, TOML"),
    _file("--lessons", metavar="FOLDER", help="what was handed out (default: the course)"),
    LANGUAGE,
    _arg("--rerun", action="store_true", help="run the notebooks, too, in a bounded place"),
)
def _grade(options):
    """Write the report; 1 if something was not read or a verdict does not fit its answer."""
    from mathpost.course import grade, grade_page
    from mathpost.course.rerun import Place

    rules = grade.read_rules(options.rules) if options.rules else None
    place = Place() if options.rerun else None
    graded = grade.grade(options.folder, rules, lessons=options.lessons, rerun=place, progress=_step)
    graded.notes += place.open if place else ["No notebook was run."]
    for note in graded.notes:
        print(note, file=sys.stderr)
    report = options.output.with_suffix("") if options.output.suffix in (".html", ".csv") else options.output
    page, table = (report.with_name(report.name + suffix) for suffix in (".html", ".csv"))
    write_text(page, grade_page.to_html(graded, options.language))
    write_text(table, grade_page.to_csv(graded, options.language))
    print(f"students: {len(graded.results)}; {page}, {table}")
    found = [(each.name, *trouble) for each in graded.results for trouble in each.trouble]
    found += [(each.name, name, "edited") for each in graded.results for name in each.edited]
    for name, what, why in found:
        print(f"{name}: {what}{': ' * bool(what)}{why}", file=sys.stderr)
    return int(bool(found))


@_command(
    "assign",
    "lessons for students, without solutions",
    _file("lessons", metavar="LESSONS", help="a notebook, or a folder of notebooks"),
    _file(metavar="FOLDER", required=True),
    _arg("--students", metavar="FILE", help="a name on each line: a copy for each, with own numbers"),
)
def _assign(options):
    """Write the copies, and say what they do not hide."""
    from mathpost.course import assign
    from mathpost.course.verdict import EXERCISES

    lines = read_text(options.students).splitlines() if options.students else ()
    students = list(filter(None, map(str.strip, lines)))
    asked = assign.assign(options.lessons, options.output, students)
    for path, names in asked.items():
        print(f"{path}: {', '.join(names) or 'no exercises'}")
    own = sorted(set().union(*asked.values()) & {name for name, each in EXERCISES.items() if each.drawn})
    said = "The numbers of these exercises"
    if students:
        said = (
            f"Each student has numbers of their own in {', '.join(own) or 'no exercise'}; the numbers of the others"
        )
    print(f"{said} are the same for all.", file=sys.stderr)
    print("The package holds the solutions of its own exercises: who has it can read them.", file=sys.stderr)
    return 0


def _step(done, total, name):
    """A bar on a terminal, a line now and then in a log."""
    if sys.stderr.isatty():
        bar = "█" * (30 * done // total)
        print(f"\r{bar:30s} {done}/{total} {name[:40]:40s}", end="\n" * (done == total), file=sys.stderr)
    elif done % 20 == 0 or done == total:
        print(f"{done}/{total} {name}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
