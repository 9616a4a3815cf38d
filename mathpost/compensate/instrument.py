"""Files that instruments write: the target data of a Renishaw laser, .rtl.

The format is not published by its maker. It was read off three public programs that read it and one that writes
it, and that agree: sections ``NAME::``, ``Targets :`` over several lines, then ``Run Target Data:`` with a line for
each reading: run, target (from 1) and deviation. Targets of a slide are mm, their deviations µm; what those of a
rotary axis are in they do not agree upon, so it is asked for.

A ballbar's files (.b5r) and their layout are not public, and the log of Heidenhain's KinematicsOpt (TCHPR451) holds
the control's own results and no reading (cycle programming manual of the iTNC 530, 340 49x-05, page 464): neither
is read.
"""

import re

import numpy as np

from mathpost.errors import InputError
from mathpost.measure import csv_table

LOG = re.compile(r"TCHPR45\d|KinematicsOpt", re.IGNORECASE)


def read(lines, machine):
    """Return the `csv_table.Lines` of an instrument's file as a `csv_table.Table`; None if they are a table."""
    texts = [text for _, text in lines.lines]
    if any(LOG.search(text) for text in texts[:20]):
        expected = "readings (a log of KinematicsOpt holds the control's results: probe the ball, method probe)"
        raise InputError(lines.path, expected, "such a log")
    if not any(text.strip() == "HEADER::" for text in texts[:5]):
        return None
    return _rtl(lines, machine)


def _rtl(lines, machine):
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


def _number(word, path, line, expected):
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{path}, line {line}", expected, repr(word)) from None
