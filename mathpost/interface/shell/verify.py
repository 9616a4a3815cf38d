"""A program of any post: what it does on the machine, and whether it follows the CL data."""

from __future__ import annotations

import argparse
import csv
import html
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from mathpost import machine_file
from mathpost.errors import InputError
from mathpost.files import TomlTable, a_number, only_if, read_bytes, read_text, read_toml, write_text
from mathpost.interface.shell.options import FILE, degrees, vector
from mathpost.kinematics import Kinematics
from mathpost.path import cl
from mathpost.path.deviation import AXIS_TOLERANCE, TOLERANCE
from mathpost.shop.controls import control
from mathpost.shop.controls.coordinates import Setup
from mathpost.shop.post.verify import Verified, verify

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.path.cl import CLData


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("program", **FILE | {"metavar": "PROGRAM"}, help="NC program, whoever wrote it")
    add("--machine", **FILE, required=True, help="machine file, TOML")
    add("--dialect", default="heidenhain", metavar="CONTROL", help=f"{', '.join(control.names())}, or a TOML file")
    add("--cl", **FILE, help="CL file that the program should follow")
    add(
        "--origin", action="append", default=[], metavar="[NAME=]X,Y,Z",
        help="workpiece origin, or that of a work offset such as G55; may be given again",
    )  # fmt: skip
    add("--start", default="", metavar="A0,C0,…", help="where axes stand before the first block, mm and degrees")
    add("--tools", **FILE, help="lengths of the tools: CSV with number,length, or TOML with number = length")
    add("--tool-length", type=float, metavar="MM", help="of the only tool, instead of the machine file's")
    add("--unit", choices=("mm", "inch"), help="of a program or CL data that do not state it (default mm)")
    add("--tolerance", type=float, default=TOLERANCE, metavar="MM", help="default %(default)s")
    add("--axis-tolerance", **degrees(AXIS_TOLERANCE), help="of the tool axis; default %(default)s")
    add(
        "--skip", action="append", default=[], metavar="WORD",
        help="a word of this machine that moves no axis, as M250 or G187 P{}; may be given again",
    )  # fmt: skip
    add("--page", **FILE | {"metavar": "OUT"}, help="the machine as an HTML page that walks through the program")


def run(options: argparse.Namespace) -> int:
    """Print what the program does; return 1 if a block is off its CL path, out of travel, or rapid in the cut."""
    origin, offsets = _origins(options.origin)
    setup = machine_file.load(options.machine).with_setup(origin=origin, tool_length=options.tool_length)
    path = cl.read(options.cl, unit=options.unit) if options.cl else None
    lengths = _lengths(options.tools) if options.tools else _of_cl(path)
    text = read_bytes(options.program).decode("utf-8-sig", "replace")
    tables = Setup(offsets, lengths, start=_start(options.start, setup), unit=options.unit)
    words = control.load(options.dialect).skipping(options.skip, "--skip")
    found = verify(
        text, setup, words, cl=path, setup=tables, tolerance=options.tolerance,
        axis_tolerance=math.radians(options.axis_tolerance), name=options.program.name,
    )  # fmt: skip
    print(found)
    if options.page:
        inputs = filter(None, (options.program, options.machine, options.cl, options.tools))
        write_text(options.page, page(found, Kinematics(setup)), inputs=inputs)
    return found.status


def page(found: Verified, kin: Kinematics) -> str:
    """Return the machine walking through a program, as HTML."""
    from mathpost.teaching.course import view_machine  # draws with matplotlib, of the extras
    from mathpost.teaching.course.machine_page import FRAME

    view, _ = view_machine.short_walk(kin, found.cl, found.joints)
    said = f"{FRAME}<h1>{html.escape(found.name)}</h1>"
    return view.page(found.name, before=said, after=f"<pre>{html.escape(str(found))}</pre>", still=True)


def _origins(texts: Iterable[str]) -> tuple[tuple[float, ...] | None, dict[str, tuple[float, ...]]]:
    """Return the origin given without a name, and the origins of work offsets by their words."""
    origin, offsets = None, {}
    for text in texts:
        name, _, numbers = text.rpartition("=")
        try:
            values = vector(numbers)
        except (argparse.ArgumentTypeError, ValueError):
            raise InputError("--origin", "[NAME=]X,Y,Z", repr(text)) from None
        if name:
            offsets["".join(name.upper().split())] = values
        else:
            origin = values
    return origin, offsets


def _start(text: str, setup: Machine) -> dict[str, float]:
    """Return positions of axes by name."""
    found = {}
    for word in filter(None, text.upper().replace("=", "").split(",")):
        name = next((name for name in setup.joint_names if word.startswith(name)), "")
        if not name or not _is_number(word[len(name) :]):
            raise InputError("--start", f"axes of {' '.join(setup.joint_names)} with numbers, A0,C0", repr(text))
        found[name] = float(word[len(name) :])
    return found


def _of_cl(path: CLData | None) -> dict[str, float]:
    """Return the lengths that the CL data state, by the number of the tool."""
    tools = cl.commands(path.remarks, "tool") if path is not None else []
    return {str(tool.values[0]): tool.values[1] for _, tool in tools if tool.values[1] is not None}


def _lengths(path: Path) -> dict[str, float]:
    """Read tool lengths, mm, by number or name."""
    length = only_if(lambda value: value >= 0, a_number), "a length in mm, not negative"
    if path.suffix.lower() == ".toml":
        table = TomlTable(read_toml(path), str(path))
        return {name: table.take(name, *length) for name in list(table.content)}
    found = {}
    for number, row in enumerate(csv.reader(read_text(path).splitlines()), 1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or (number == 1 and not _is_number(cells[-1])):
            continue
        if len(cells) != 2 or not _is_number(cells[1]) or float(cells[1]) < 0:
            raise InputError(f"{path}, line {number}", "number,length in mm", repr(",".join(row)))
        found[cells[0].lstrip("0") or "0"] = float(cells[1])
    return found


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
