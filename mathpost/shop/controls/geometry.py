"""Where the geometry of a machine is entered in a control, as the control's file states it.

The file has groups of rows. A row is words, one vector of the machine and, if only one number of it is asked for,
X, Y or Z. The vector is the place of a rotary axis ("first" or "second" of the machine file), from the zero of the
machine or from the other axis ("second - first"), or its direction ("axis first"), or either reversed ("- second").
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from mathpost.errors import InputError
from mathpost.files import TomlTable, one_of, only_if, some_text
from mathpost.machine import Machine
from mathpost.rotation import unit

ARRANGEMENTS = ("table-table", "head-table", "head-head")
VECTOR = re.compile(r"(-?) ?(axis )?(first|second)(?: - (first|second))?")
DIRECTIONS = re.compile("[XYZ] [XYZ]")
COUNTED = re.compile(r"\{(\d+|X|x)\}")  # in the words of a row: its three numbers, counted from here


@dataclass(frozen=True)
class Group:
    """Numbers that are entered in one place of a control."""

    title: str
    arrangement: str  # one of `ARRANGEMENTS`
    axes: str  # the names of the two rotary axes that it is for; empty: of any
    directions: str  # what these turn about, the tables the workpiece, positively: "X Z"; empty: about anything
    rows: tuple[tuple[str, str, str], ...]  # words, vector, and which of X Y Z of it, or nothing: all three

    def fits(self, machine: Machine) -> bool:
        """Whether `machine` is entered here."""
        names = "".join(rotary.name for rotary in machine.rotary)
        along = all(abs(share) == 1 for _, share in self._shares(machine))
        return machine.arrangement == self.arrangement and self.axes in ("", names) and along

    def against(self, machine: Machine) -> list[str]:
        """Return the axes that turn the other way than the control takes for granted.

        Examples
        --------
        >>> from mathpost import load_machine
        >>> Group("", "table-table", "AC", "X Z", ()).against(load_machine("ac_table"))  # by ISO 841
        ['A', 'C']
        """
        return [name for name, share in self._shares(machine) if share < 0]

    def _shares(self, machine: Machine) -> list[tuple[str, float]]:
        """Each axis whose direction is stated: its name, and 1 if it lies in that direction, −1 if against it."""
        pairs = zip(machine.rotary, self.directions.split(), strict=False)
        return [(rotary.name, float(unit(rotary.axis)["XYZ".index(letter)])) for rotary, letter in pairs]

    def numbers(self, machine: Machine) -> list[tuple[str, float]]:
        """Return the words and the number of each entry of `machine`: mm, and unit vectors.

        Examples
        --------
        >>> from mathpost import load_machine
        >>> group = Group("", "table-table", "", "", (("R{X} of {second}", "second - first", ""),))
        >>> group.numbers(load_machine("ac_table"))
        [('RX of C', 0.0), ('RY of C', 0.0), ('RZ of C', 50.0)]
        """
        first, second = (rotary.name for rotary in machine.rotary)
        found = []
        for words, vector, only in self.rows:
            named = words.replace("{first}", first).replace("{second}", second)
            for index, number in enumerate(_vector(vector, machine)):
                if only in ("", "XYZ"[index]):
                    found.append((_counted(named, index), number))
        return found


def _vector(text: str, machine: Machine) -> list[float]:
    """The vector of a row."""
    reversed_, axis, name, other = VECTOR.findall(text)[0]
    rotary = dict(zip(("first", "second"), machine.rotary, strict=True))
    found = np.array(unit(rotary[name].axis) if axis else rotary[name].point, dtype=float)
    if other:
        found = found - rotary[other].point
    return (-found if reversed_ else found).tolist()


def _counted(words: str, index: int) -> str:
    """The words of number `index` of three: {15} is 15, 16 and 17, {X} is X, Y and Z."""

    def label(field: re.Match[str]) -> str:
        begin = field[1]
        return str(int(begin) + index) if begin.isdigit() else chr(ord(begin) + index)

    return COUNTED.sub(label, words)


def geometry_of(file: TomlTable) -> tuple[Group, ...]:
    """Read the tables [[geometry]], if there are any."""
    tables = file.take("geometry", only_if(lambda found: isinstance(found, list)), "tables [[geometry]]", [])
    groups = []
    for number, content in enumerate(tables, 1):
        table = TomlTable(content, f"{file.where}, [[geometry]] {number}")
        groups.append(
            Group(
                title=table.take("title", some_text, "a text in quotes"),
                arrangement=table.take("arrangement", *one_of(*ARRANGEMENTS)),
                axes=table.take("axes", some_text, "the names of both rotary axes, as in 'AC'", ""),
                directions=table.take("directions", only_if(DIRECTIONS.fullmatch), "two letters, as in 'X Z'", ""),
                rows=tuple(_row(row, table.where) for row in table.take("rows", list, "a list of rows")),
            )
        )
        table.done()
    return tuple(groups)


def _row(row: object, where: str) -> tuple[str, str, str]:
    """One row of a group."""
    words, vector, only = [*row, ""][:3] if isinstance(row, list) and len(row) in (2, 3) else ("", "", "")
    if not (
        isinstance(words, str) and isinstance(vector, str) and VECTOR.fullmatch(vector) and only in ("", *"XYZ")
    ):
        raise InputError(f"{where}, key 'rows'", '["words", "second - first"], or with "Z" behind it', repr(row))
    return words, vector, only
