"""Files that instruments write: a Renishaw laser's target data (.rtl), and those that hold no readings.

The format of .rtl is not published by its maker. It was read off three public programs that read it and one that
writes it, and that agree: sections ``NAME::``, ``Targets :`` over several lines, then ``Run Target Data:`` with a
line for each reading: run, target (from 1) and deviation. Targets of a slide are mm, their deviations µm; about the
unit of a rotary axis they do not agree, so it is asked for.

`FOREIGN` are files without a reading in them. A ballbar's .b5r is XML of which one public program reads the results
(FEATURE, PLANE, TEST_SPEC), none the readings. The log of Heidenhain's KinematicsOpt (TCHPR451, cycle programming
manual of the iTNC 530, 340 49x-05, page 464) and that of Siemens' CYCLE996 hold what the control found.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import InputError
from mathpost.shop.measure import csv_table

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.measure.csv_table import Lines, Table

FOREIGN = {
    r"TCHPR\w*|KinematicsOpt": "a log of KinematicsOpt holds the control's results: probe the ball, method probe",
    r"CYCLE996|_OVR\[": "a log of CYCLE996 holds the control's results: write the ball's centres, method probe",
    r"<BALLBAR|TEST_PLANE=|<QC20": "the layout of .b5r is not public: a table of the bar, method ballbar",
    r"<\?xml|<!DOCTYPE|<html": "markup is no table: save it as CSV",
}


def read(lines: Lines, machine: Machine) -> Table | None:
    """Return the `csv_table.Lines` of an instrument's file as a `csv_table.Table`; None if they are a table."""
    texts = [text for _, text in lines.lines]
    for text in texts[:20]:
        for words, instead in FOREIGN.items():
            if re.search(words, text, re.IGNORECASE):
                raise InputError(lines.path, "readings", f"none ({instead})")
    return _rtl(lines, machine) if any(text.strip() == "HEADER::" for text in texts[:5]) else None


def _rtl(lines: Lines, machine: Machine) -> Table:
    """Runs as columns up1, down1, …: the direction of a run is that of its targets."""
    said, targets, readings, section = {}, [], [], ""
    for number, text in lines.lines:
        text = text.strip()
        key, colon, value = (part.strip() for part in text.partition(":"))
        if text.endswith("::") or colon:
            section = key
            said[key.casefold()] = value
        elif section == "Targets":
            targets += [_number(word, lines.path, number, "a target") for word in text.split()]
        elif section == "Run Target Data":
            row = [_number(word, lines.path, number, "run, target, deviation") for word in text.split()]
            if len(row) != 3 or row[1] not in range(1, len(targets) + 1):
                expected = f"run, target from 1 to {len(targets)}, deviation"
                raise InputError(f"{lines.path}, line {number}", expected, repr(text))
            readings.append((int(row[0]), int(row[1]) - 1, row[2], number))
    counted = said.get("target-count", "")
    if counted.isdigit() and int(counted) != len(targets):
        raise InputError(lines.path, f"{counted} targets, as Target-count says", f"{len(targets)}: cut off?")
    runs = sorted({run for run, *_ in readings})
    if not targets or len(readings) != len(runs) * len(targets):
        expected = f"a deviation of each of {len(targets)} targets in each run"
        raise InputError(lines.path, expected, f"{len(readings)} in {len(runs)} runs: cut off?")
    table = csv_table.Table(lines.path)
    table.header, table.lines = f"{lines.path}, line {lines.lines[0][0]}", tuple(range(1, len(targets) + 1))
    table["position"] = np.array(targets)
    sides = {"up": 0, "down": 0}
    for run in runs:
        order = [(target, value) for each, target, value, _ in readings if each == run]
        side = "up" if order[-1][0] >= order[0][0] else "down"
        sides[side] += 1
        table[f"{side}{sides[side]}"] = np.array([value for _, value in sorted(order)])
    table.settings["method"] = "laser"
    axis = said.get("axis", "").upper()
    if axis in machine.joint_names:
        table.settings["axis"] = axis
    if said.get("file type", "").casefold() == "linear" or axis in "XYZ":
        table.settings["unit"] = "µm"
    table.notes = (f"{lines.path}: target data of a laser, {len(runs)} runs; readings by their targets",)
    return table


def _number(word: str, path: Path | str, line: int, expected: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{path}, line {line}", expected, repr(word)) from None
