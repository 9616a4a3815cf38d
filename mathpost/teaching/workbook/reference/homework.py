"""What a teacher asks: a reference, which of its cells are inputs and results; a file that is written once."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from mathpost.errors import InputError
from mathpost.files import beside, read_toml

NUMBERS = ("any", "given", "own")
HEAD = """\
# What hand-ins are compared with. Take out a result that was not asked for, and an input that is to stay as it is.
# numbers: "given" if hand-ins must have the numbers of the reference, "own" if each has others, "any" if either.
"""
CELLS = """\
# Where hand-ins have a cell of the reference, if they are laid out alike and the check cannot tell:
# "Sheet1!B3" = "Data!C5"
"""


@dataclass(frozen=True)
class Homework:
    """What hand-ins are compared with.

    Attributes
    ----------
    reference : Path
        The right workbook.
    inputs, results : sequence of str or None
        Addresses or ranges in the reference; None: the numbers that its formulas use, the formulas that none uses.
    numbers : str
        ``"given"``, ``"own"`` or ``"any"``: whether a hand-in has the numbers of the reference.
    cells : dict
        Address in the reference → address in the hand-ins.
    """

    reference: Path
    inputs: Sequence[str] | None = None
    results: Sequence[str] | None = None
    numbers: str = "any"
    cells: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.numbers not in NUMBERS:
            raise InputError("numbers", " or ".join(map(repr, NUMBERS)), repr(self.numbers))


def is_homework(path: str | Path) -> bool:
    """Whether a task file names a reference."""
    return "reference" in read_toml(path)


def read_homework(path: str | Path, reference: str | Path | None = None) -> Homework:
    """Read a file of a homework; a `reference` that is given goes before the file's, which is beside it.

    Raises
    ------
    InputError
        If it cannot be read, holds another key or a value of another kind.
    """
    given = read_toml(path)
    kinds = {"reference": str, "numbers": str, "inputs": list, "results": list, "cells": dict}
    for key, value in given.items():
        if key not in kinds:
            raise InputError(f"{path}, {key}", f"one of {', '.join(kinds)}", key)
        texts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else [value]
        if not isinstance(value, kinds[key]) or not all(isinstance(text, str) for text in texts):
            expected = {"str": "a text", "list": "a list of addresses", "dict": "addresses"}[kinds[key].__name__]
            raise InputError(f"{path}, {key}", expected, repr(value))
    if reference is None and "reference" not in given:
        raise InputError(f"{path}, reference", "the name of the right workbook", "none")
    name = given.pop("reference", "")
    own = Path(reference) if reference is not None else beside(path, name, ".xlsx", f"{path}, reference")
    return Homework(own, **given)


def homework_text(reference: str, inputs: Mapping[str, str], results: Mapping[str, str], numbers: str) -> str:
    """The file of a homework; `inputs` and `results` are address → label."""

    def listed(name: str, cells: Mapping[str, str]) -> str:
        lines = [f"  {_quoted(cell)},{f'  # {label}' if label else ''}\n" for cell, label in cells.items()]
        return f"{name} = [\n{''.join(lines)}]\n"

    head = f"{HEAD}reference = {_quoted(reference)}\nnumbers = {_quoted(numbers)}\n"
    return f"{head}{listed('results', results)}{listed('inputs', inputs)}\n[cells]\n{CELLS}"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
