"""CL data to a verified NC program."""

import argparse
import ctypes
import logging
import math
import sys
from collections.abc import Callable

from mathpost import machine_file
from mathpost.interface.shell.options import FILE, OUTPUT, degrees, given, vector, write
from mathpost.machine import Machine
from mathpost.path import cl
from mathpost.path.cl import CLData
from mathpost.path.deviation import AXIS_TOLERANCE, TOLERANCE
from mathpost.path.region import Region
from mathpost.path.selection import STRATEGIES
from mathpost.path.singular import CLEARANCE, CONE, LEAN
from mathpost.shop.compensate.model import read_errors
from mathpost.shop.controls import control
from mathpost.shop.post.options import Options
from mathpost.shop.post.postprocess import Result
from mathpost.shop.post.postprocess import postprocess as post


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("cl", **FILE | {"metavar": "CL"}, help="APT CL file")
    add("--machine", **FILE, required=True, help="machine file, TOML")
    add("--dialect", default="heidenhain", metavar="CONTROL", help=f"{', '.join(control.names())}, or a TOML file")
    add("--tcp", action="store_true", help="let the control keep the tip: M128, G43.4, TRAORI")
    add("--expand", action="store_true", help="straight moves only: no arcs, drilling cycles and tilted planes")
    add("--tolerance", type=float, default=TOLERANCE, metavar="MM", help="default %(default)s")
    add("--axis-tolerance", **degrees(AXIS_TOLERANCE), help="of the tool axis; default %(default)s")
    add("--selection", dest="strategy", choices=STRATEGIES, default=Options.strategy)
    add("--singular", choices=Region.SAFE, default=Options.singular, help="way through singular regions")
    add("--cone", **degrees(CONE), help="half angle of the singular region (default %(default)g)")
    add("--lean", **degrees(LEAN), help="how far the way aside moves the tool axis (default %(default)g)")
    add("--clearance", type=float, default=CLEARANCE, metavar="MM", help="of ways that lift (default %(default)g)")
    add("--split", action="store_true", help="retract and unwind where travel ends")
    add("--tool-length", type=float, metavar="MM", help="instead of the machine file's")
    add("--origin", type=vector, metavar="X,Y,Z", help="workpiece origin, instead of the machine file's")
    add("--errors", **FILE, help="errors of the calibrated machine, TOML, to compensate for")
    add("--compare", action="store_true", help="report other strategies and ways through singular regions, too")
    add(
        "--feed",
        type=float,
        metavar="MM/MIN",
        help="of the moves before the first FEDRAT; without one they have no F",
    )
    add("--unit", choices=("mm", "inch"), help="of CL data that have no UNITS (default mm)")
    add("--ignore", default="", metavar="WORD,…", help="words of the CL file that move nothing, as comments")
    add(*OUTPUT, **FILE, help="program; by default standard output")


def run(options: argparse.Namespace) -> int:
    """Write the program, and the report to standard error."""
    keep_freed_memory()
    progress = None
    if sys.stderr.isatty():
        stages = logging.getLogger("mathpost")
        stages.setLevel(logging.INFO)
        said = logging.StreamHandler()
        said.setFormatter(logging.Formatter("%(message)s …"))
        stages.addHandler(said)
        progress = stages.info
    result = made(options, *read(options), progress)
    write(options.output, result.program, inputs=filter(None, (options.cl, options.machine, options.errors)))
    print(result.report, file=sys.stderr)
    return 0


def keep_freed_memory() -> None:
    """Let the C library keep the memory that arrays free: fetching each page again takes a tenth of the time."""
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "mallopt"):
        most = 2**31 - 1
        library.mallopt(ctypes.c_int(-3), ctypes.c_int(most))  # M_MMAP_THRESHOLD
        library.mallopt(ctypes.c_int(-1), ctypes.c_int(most))  # M_TRIM_THRESHOLD


def read(options: argparse.Namespace) -> tuple[CLData, Machine]:
    """Return the CL data, and the machine with its setup."""
    setup = machine_file.load(options.machine).with_setup(origin=options.origin, tool_length=options.tool_length)
    ignored = tuple(word.strip() for word in options.ignore.split(",") if word.strip())
    chords = min(cl.ARC_TOLERANCE, options.tolerance / 5)
    stated = given(options, ("unit", "feed"))
    return cl.read(options.cl, tolerance=chords, ignored=ignored, **stated), setup


def made(
    options: argparse.Namespace, path: CLData, setup: Machine, progress: Callable[[str], None] | None
) -> Result:
    """Return the program that the options ask for, from the result of `read`; see `mathpost.postprocess`."""
    return post(
        path,
        setup,
        axis_tolerance=math.radians(options.axis_tolerance),
        cone=math.radians(options.cone),
        lean=math.radians(options.lean),
        errors=read_errors(options.errors, setup) if options.errors else None,
        progress=progress,
        **given(
            options,
            ("dialect", "strategy", "singular", "clearance", "tolerance", "tcp", "expand", "split", "compare"),
        ),
    )
