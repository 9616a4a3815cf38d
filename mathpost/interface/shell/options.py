"""Arguments that several commands share: files, vectors, numbers, angles; and the output of results."""

import argparse
import math
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from mathpost.errors import InputError, one_line
from mathpost.files import text_of, typed_number, write_text

OUTPUT = ("-o", "--output")


def a_path(text: str) -> Path:
    """Return a path; an empty one, as of a variable that a script has not set, is none."""
    if not text:
        raise argparse.ArgumentTypeError("expected a name, found an empty one")
    return Path(text)


FILE: dict[str, Any] = {"type": a_path, "metavar": "FILE"}
MACHINE: dict[str, Any] = {"type": a_path, "metavar": "MACHINE", "help": "machine file, TOML"}
LANGUAGE: dict[str, Any] = {"choices": ("en", "zh"), "default": "en", "help": "of the table"}


def vector(text: str) -> tuple[float, ...]:
    """Parse three numbers, X,Y,Z."""
    values = tuple(map(float, text.split(",")))
    if len(values) != 3:
        raise argparse.ArgumentTypeError(f"expected three numbers X,Y,Z, found {text!r}")
    return values


def number(text: str) -> str:
    """Return a number as it was written, as its digits show its precision; a comma is a decimal point."""
    try:
        return typed_number(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, found {text!r}") from None


def count_of(values: list[str], names: Sequence[str], where: str) -> list[float]:
    """Return values as numbers, one for each name, such as that of a joint."""
    if len(values) != len(names):
        raise InputError(where, f"{len(names)} numbers, {' '.join(names)}", f"{len(values)}")
    return [float(value) for value in values]


def columns(rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a table, columns as wide as their widest text: numbers right-aligned, words left."""
    made = []
    for column in zip(*rows, strict=True):
        width = max(map(len, column))
        numeric = all(re.fullmatch(r"[-\d.]*|[A-Z][0-9]?", text) for text in column)
        made.append([f"{text:>{width}}" if numeric else f"{text:{width}}" for text in column])
    return ["  ".join(row).rstrip() for row in zip(*made, strict=True)]


def named(names: Sequence[str], values: Iterable[float], decimals: int = 4) -> str:
    """Return names with their numbers, as in ``B 54.7356 C 45``."""
    return " ".join(f"{name} {text_of(value, decimals)}" for name, value in zip(names, values, strict=True))


def degrees(default: float) -> dict[str, Any]:
    """Return the settings of an angle in degrees whose default is given in radians."""
    return {"type": float, "default": round(math.degrees(default), 9), "metavar": "DEG"}


def given(options: argparse.Namespace, names: Iterable[str]) -> dict:
    """Return those of the options that were given, by name."""
    return {name: getattr(options, name) for name in names if getattr(options, name) is not None}


THREE: dict[str, Any] = {"nargs": 3, "type": number}
PRESENT: dict[str, Any] = {
    "dest": "present",
    "nargs": "+",
    "type": number,
    "metavar": "Q",
    "help": "rotary angles where it stands (default 0)",
}
JSON: dict[str, Any] = {"action": "store_true", "help": "for scripts, with all digits"}


def write(path: Path | None, text: str, inputs: Iterable[Path] = ()) -> None:
    """Write to a file, or to standard output without a `path`."""
    if path:
        write_text(path, text, inputs=inputs)
    else:
        print(text, end="")


def show_progress(done: int, total: int, name: str) -> None:
    """Show a bar on a terminal, or every twentieth step in a log."""
    name = one_line(name)
    if sys.stderr.isatty():
        bar = "█" * (30 * done // total)
        print(f"\r{bar:30s} {done}/{total} {name[:40]:40s}", end="\n" * (done == total), file=sys.stderr)
    elif done % 20 == 0 or done == total:
        print(f"{done}/{total} {name}", file=sys.stderr)
