"""The commands, and running one of them."""

import argparse
import errno
import gc
import io
import os
import re
import signal
import sys
from collections.abc import Sequence
from importlib import import_module

from mathpost.errors import MathpostError, internal, one_line
from mathpost.interface.shell import stopping

COMMANDS = {  # each a file of this folder, with a line of help
    "post": "CL data to a verified NC program",
    "verify": "a program of any post: what it does on the machine, and whether it follows the CL data",
    "calibrate": "readings to a machine file, its errors and a control's terms",
    "head": "a horizontal head from measured vectors: its axis, what is left, blocks for any position",
    "check": "check spreadsheets of rotations or NC words by their formulas",
    "explain": "which misreading of the convention gives this number?",
    "rotation": "a rotation in any notation: all the others, and whether it is one",
    "pose": "a tool axis to every position of a machine, or joints to tip and tool axis",
    "plane": "a tilted plane in every control's words, and a machine's positions on it",
    "controls": "the controls that programs are written for, or the file of one to copy",
    "show": "a machine as a page that moves, with the signs of its axes in words",
    "print": "a machine's functions as JavaScript, C or LaTeX, or a folder that runs it on LinuxCNC",
    "assign": "lessons for students, without solutions",
    "grade": "a class's notebooks and workbooks: marks, mix-ups, what needs a look",
    "lessons": "run lessons anew and say what changed",
    "site": "lessons, machines, commands and reference as pages for any web server, or none",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command, by default that of the command line; return the exit status.

    0: done, or all right. 1: something checked is wrong. 2: refused, with the reason on standard error.
    """
    try:
        if arguments is None:
            stopping.take(stopping.in_order)
            gc.disable()  # all that is loaded stays: to look through it takes a fifth of a short command
        if sys.stderr is None:
            sys.stderr = io.StringIO()  # which nobody reads
        if sys.stdout is None:  # a file that is opened would take its place
            raise OSError(errno.EBADF, "closed")
        for stream in (sys.stdout, sys.stderr):  # names of files may be no UTF-8
            if isinstance(stream, io.TextIOWrapper):
                stream.reconfigure(errors="backslashreplace")
        options = parse(sys.argv[1:] if arguments is None else arguments)
        if arguments is None:
            gc.freeze()
            gc.enable()
        status = options.run(options)
        sys.stdout.flush()
        stopping.over = True
        return status
    except BaseException as error:
        stopping.over = True
        if isinstance(error, KeyboardInterrupt) or stopping.came():
            return _stopped()
        return _refused(error)
    finally:
        if arguments is None:
            stopping.take(signal.SIG_IGN)  # the command is finished
            gc.freeze()  # and nothing needs taking apart


def _stopped() -> int:
    """Print that the command was interrupted; return the exit status."""
    print("mathpost: stopped, no file is half written", file=sys.stderr)
    return stopping.STATUS


def _refused(error: BaseException) -> int:
    """Print in one line why a command ended, and return the exit status; argparse's own exit is raised again."""
    if isinstance(error, MathpostError):
        print(f"mathpost: {error}", file=sys.stderr)
    elif isinstance(error, ModuleNotFoundError):  # one of the extras, which a headless post does without
        print(f"mathpost: this command needs {error.name}, which comes with mathpost[course]", file=sys.stderr)
    elif isinstance(error, BrokenPipeError):  # the reader stopped after the first lines
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    elif isinstance(error, OSError):  # standard output is closed, or its disk is full
        sys.stdout = io.StringIO()  # what is left to be written goes nowhere
        place = "standard output" if error.filename is None else one_line(str(error.filename))  # too long a name
        print(f"mathpost: {place}: {error.strerror or error}", file=sys.stderr)
    elif isinstance(error, Exception):
        print(f"mathpost: {internal(error)}", file=sys.stderr)
    else:
        raise error
    return 2


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options of one command, with its function `run`; argparse raises `SystemExit` for wrong ones."""
    words = _joined(list(arguments))
    return _parser(words).parse_args(words)


def option_actions(command: str) -> list[argparse.Action]:
    """Return the options of a command as argparse has them, to show them in a different form."""
    made = argparse.ArgumentParser(prog=command, add_help=False)
    import_module(f"mathpost.interface.shell.{command}").add_arguments(made)
    return made._actions


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of all commands, with the arguments of the one that `words` begin with."""
    made = argparse.ArgumentParser(
        prog="python -m mathpost", description="Five-axis post-processing and spreadsheets, verified."
    )
    made.add_argument("--version", action="version", version=_version() if words[:1] == ["--version"] else "")
    commands = made.add_subparsers(dest="command", required=True)
    for name, said in COMMANDS.items():
        command = commands.add_parser(name, help=said)
        if words[:1] == [name]:
            module = import_module(f"mathpost.interface.shell.{name}")
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    return made


def _version() -> str:
    from importlib import metadata  # reading it takes as long as all the rest of --help

    return f"mathpost {metadata.version('mathpost')}"


def _joined(arguments: list[str]) -> list[str]:
    """Keep argparse from taking values for options: vectors such as -1,0,2, numbers such as -1e-16 or -54,7356."""
    if arguments[:1] in (["explain"], ["pose"], ["plane"], ["rotation"]):
        return [re.sub(r"^-(?=[\d.,]+(e[+-]?\d+)?°?$)", "−", word) for word in arguments]
    words, vectors = iter(arguments), ("--origin", "--angles", "--point", "--measured")
    return [f"{word}={next(words, '')}" if word in vectors else word for word in words]
