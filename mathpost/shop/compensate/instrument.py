"""Files that instruments and controls write: a Renishaw laser's target data (.rtl), LinuxCNC's log of touches.

The format of .rtl is not published by its maker. It was read off three public programs that read it and one that
writes it, and that agree: sections ``NAME::``, ``Targets :`` over several lines, then ``Run Target Data:`` with a
line for each reading: run, target (from 1) and deviation. Targets of a slide are mm, their deviations µm; about the
unit of a rotary axis they do not agree, so it is asked for.

LinuxCNC writes a line of nine numbers, X Y Z A B C U V W in the coordinates of the program, for each touch between
``(PROBEOPEN file)`` and ``(PROBECLOSE)`` (src/emc/task/emccanon.cc, GET_EXTERNAL_PROBE_POSITION). Four touches or
more of one ball at each pose, without TCP, are its centre there: method probe. The work offset is asked for as
``start``.

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
from mathpost.shop.measure.fit import least_squares

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.measure.csv_table import Lines, Table

FOREIGN = {
    r"TCHPR\w*|KinematicsOpt": "a log of KinematicsOpt holds the control's results: probe the ball, method probe",
    r"CYCLE996|_OVR\[": "a log of CYCLE996 holds the control's results: write the ball's centres, method probe",
    r"<BALLBAR|TEST_PLANE=|<QC20": "the layout of .b5r is not public: a table of the bar, method ballbar",
    r"<\?xml|<!DOCTYPE|<html": "markup is no table: save it as CSV",
}
LEAST = 4  # touches of a ball at one pose that give its centre
MOST = 200  # poses of a log


def read(lines: Lines, machine: Machine, said: dict[str, str]) -> Table | None:
    """Return the `csv_table.Lines` of an instrument's file as a `csv_table.Table`; None if they are a table.

    `said` are the settings of the file and of the call.
    """
    texts = [text for _, text in lines.lines]
    for text in texts[:20]:
        for words, instead in FOREIGN.items():
            if re.search(words, text, re.IGNORECASE):
                raise InputError(lines.path, "readings", f"none ({instead})")
    if any(text.strip() == "HEADER::" for text in texts[:5]):
        return _rtl(lines, machine)
    if texts and all(_nine(text) for text in texts):
        return _touches(lines, machine, said.get("start"))
    return None


def _nine(text: str) -> list[float]:
    """The nine numbers of a line, or none."""
    words = text.split(None, 9)
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return []
    return numbers if len(numbers) == 9 and np.isfinite(numbers).all() else []


def _touches(lines: Lines, machine: Machine, start: str | None) -> Table:
    """The centre of a ball at each pose from the touches of LinuxCNC's log: all have one radius."""
    rows = np.array([_nine(text) for _, text in lines.lines])
    axes = [each.name for each in machine.rotary if each.name in "ABC"]
    if start is None:
        expected = "a line # start = X Y Z, the work offset in which LinuxCNC logged the touches"
        raise InputError(lines.path, expected, "none")
    poses, first, pose = np.unique(rows[:, 3:6], axis=0, return_index=True, return_inverse=True)
    pose, counts = pose.ravel(), np.bincount(pose.ravel())
    if len(poses) > MOST:
        raise InputError(lines.path, f"at most {MOST} poses", f"{len(poses)}")
    if (few := np.flatnonzero(counts < LEAST)).size:
        number = lines.lines[first[few[0]]][0]
        said = f"{counts[few[0]]} at {' '.join(f'{x:g}' for x in poses[few[0]])}"
        raise InputError(f"{lines.path}, line {number}", f"{LEAST} touches of a ball or more at each A B C", said)

    def distances(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How far each touch is from its pose's centre less the radius, and the derivatives."""
        away = rows[:, :3] - x[:-1].reshape(-1, 3)[pose]
        far = np.linalg.norm(away, axis=1)
        slopes = np.zeros((len(rows), len(x)))
        for n in range(3):
            slopes[np.arange(len(rows)), 3 * pose + n] = -away[:, n] / far
        slopes[:, -1] = -1
        return far - x[-1], slopes

    middles = np.array([rows[pose == n, :3].mean(axis=0) for n in range(len(poses))])
    radius = np.linalg.norm(rows[:, :3] - middles[pose], axis=1).mean()
    guess = np.append(middles.ravel(), radius)
    found, _, left, _ = least_squares(distances, np.zeros(len(rows)), np.ones(len(rows)), guess, lines.path)
    order = np.argsort(first)
    table = csv_table.Table(lines.path)
    table.header = f"{lines.path}, line {lines.lines[0][0]}"
    table.lines = tuple(lines.lines[first[n]][0] for n in order)
    table |= {name: poses[order, "ABC".index(name)] for name in axes}
    table |= dict(zip("xyz", found[:-1].reshape(-1, 3)[order].T, strict=True))
    table.settings["method"] = "probe"
    off = f"{np.abs(left).max():.4f}, radius with the tip's {found[-1]:.4f}"
    table.notes = (
        f"{lines.path}: {len(rows)} touches of a ball at {len(poses)} poses, off a sphere by at most {off}",
    )
    return table


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
