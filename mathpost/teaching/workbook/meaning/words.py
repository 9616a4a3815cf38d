"""The rows of tables of NC words: tip, tool axis, five words. They are judged as numbers, not as functions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mathpost import machine_file as machines
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.teaching.workbook.meaning.calculation import Calculation
from mathpost.teaching.workbook.meaning.machine_table import Table, find_tables, is_whole

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.teaching.workbook.meaning.recognise import Recognised
    from mathpost.teaching.workbook.sheet.graph import Graph
    from mathpost.teaching.workbook.sheet.place import Line, Place

COLUMNS = {"tip": 3, "axis": 3, "joints": 5}


@dataclass(eq=False)
class Words(Calculation):
    """One row of a table; `results` are the five words in the machine's joint order, `point` is the tip."""

    typed: bool = True
    kinematics: Kinematics = field(kw_only=True)
    units: tuple[float, ...] = (1.0, 1.0)  # degrees of 1 of a rotary word
    table: int = 0  # of a workbook with several
    by_formulas: bool = False


def rows_of(
    found: Recognised, machine: Machine | str | Path, cells: dict[str, str] | None = None
) -> tuple[list[Words], list[str]]:
    """Return the rows of the tables as `Words`, and the ranges that look like a table and are not understood.

    `cells` says where the columns are, for example ``{"tip": "A2:C6", "axis": "D2:F6", "joints": "G2:K6"}``.
    Raise `InputError` if the machine has one rotary axis.
    """
    graph = found.graph
    kinematics = Kinematics(machines.load(machine) if isinstance(machine, str | Path) else machine)
    if len(kinematics.machine.rotary) < 2:
        expected = "a machine with two rotary axes: tables are recognised by both angles of a tool axis"
        raise InputError("machine", expected, f"{kinematics.machine.name}, with one")
    if cells:
        named = [*zip(*(_column_block(graph, name, cells) for name in COLUMNS), strict=False)]
        tables = [Table([row for row in named if is_whole(graph, chain(*row))])]
        left = [graph.range(tuple(chain(*row))) for row in named if row not in tables[0].rows]
    else:
        tables, left = find_tables(graph, kinematics)
    rows = []
    for n, table in enumerate(tables):
        said = f"NC words, each against tool tip and tool axis: {table.said(graph)}"
        for tip, axis, words in table.rows:
            row = Words(words, (), tip, (), axis, said, kinematics=kinematics, units=table.units, table=n)
            row.by_formulas, said = not graph.trees.keys().isdisjoint(words), ""
            rows.append(row)
    names = " ".join(kinematics.machine.joint_names)
    none = f"no table with the headings x y z i j k {names}: say where it is, --cells tip=…,axis=…,joints=…"
    return rows, [*(f"{area}: numbers that are no row of a table" for area in left), *([] if rows else [none])]


def _column_block(graph: Graph, name: str, cells: Mapping[str, str]) -> list[Line]:
    if name not in cells:
        raise InputError("cells", "tip, axis and joints", ", ".join(cells))
    area = graph.named(name, cells[name])
    if area.shape[1] != COLUMNS[name]:
        raise InputError(f"cells, {name!r}", f"{COLUMNS[name]} columns", repr(cells[name]))
    return list(zip(*[iter(area.places)] * COLUMNS[name], strict=True))


def numbers_of(rows: list[Words], values: Mapping[Place, float | None]) -> list[np.ndarray]:
    """The tips, tool axes and words of rows, shape (rows, …), rotary words in degrees."""
    parts = ([getattr(row, part) for row in rows] for part in ("point", "axis", "results"))
    found = [np.array([[values.get(p) for p in places] for places in part], dtype=float) for part in parts]
    found[2][:, 3:] *= rows[0].units
    return found
