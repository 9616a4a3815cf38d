"""Which results of a calibration are entered where in a control, with their uncertainty, and in which safe order.

The entries of each control, and their sources, are in its file in data/controls. Statements about KinematicsOpt are
from Heidenhain's cycle programming manual, 340 49x-05.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mathpost.rotation import unit
from mathpost.shop.compensate.calibration import SMALL, Calibration
from mathpost.shop.controls import control
from mathpost.shop.measure.fit import Value

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.controls.geometry import Group

ORDER = """\
In this order, which keeps the machine safe:
  1. Back up the control's data, and write down the old numbers beside the new ones.
  2. Enter the numbers: in one place only (control, or machine.toml and errors.toml for programs), in its units.
  3. Dry run in the air, 200 mm off, feed at 5 %: one rotary axis at a time under RTCP; the tip must stand still.
  4. Measure again with a different method, and a different ball: what is left must lie within U.
  5. Only then cut, and keep the old numbers until the first part has been measured.
KinematicsOpt (cycle 451) and CYCLE996 probe a ball and find the same pivots, in the control: let one of them check
this in step 4, without letting it write. What two of them write in turn, nobody can tell apart afterwards."""


def terms(calibration: Calibration) -> str:
    """Return what goes where in the controls, line by line with U, as text: mm, degrees, machine coordinates."""
    lines = ["where it goes, the value, U (95 %) with k and degrees of freedom; mm, degrees, machine coordinates"]
    nominal = calibration.nominal
    stated = (group for name in control.names() for group in control.load(name).geometry if group.fits(nominal))
    groups = list(dict.fromkeys(stated))  # a control may inherit them from another one

    def entered(machine: Machine) -> list[float]:
        return [number for _, rows in _entries(nominal, machine, groups) for _, number in rows]

    found = iter(calibration.of(entered))
    for title, rows in _entries(nominal, nominal, groups):
        lines.append(title)
        for (words, _), each in zip(rows, found, strict=False):
            lines.append(_line(words, each if each.U > 1e-9 else each.value))
    length, radius = calibration.bar.get("length"), calibration.bar.get("radius")
    tool = nominal.tool_length
    lines += [
        "tool table, test bar (source 001, section 6, 1): enter L before the other readings are taken",
        _line("L, length of the test bar", replace(length, value=tool + length.value) if length else tool),
        _line("R, radius of its ball", radius) if radius else f"  {'R, radius of its ball':52s}  not measured",
        "A kinematics table without axis vectors cannot hold the tilts; a program made with machine.toml does.",
        "(Heidenhain's KinematicsComp can: as Trans A B C before a MachAxis, and back behind it.)",
        *_tables(calibration),
        "",
        ORDER,
    ]
    return "\n".join(lines) + "\n"


def _tables(calibration: Calibration) -> Iterator[str]:
    """What Siemens needs in addition to a positioning table, in the names of machine axes."""
    for each in calibration.positioning:
        name = calibration.machine.joint_names[each.joint]
        count = len(each.at) + 1
        yield f"Siemens, positioning of {name}: the table wants the name of the *machine* axis, see MD10000"
        yield f"  MD38000 $MA_MM_ENC_COMP_MAX_POINTS[0,{name}] at least {count}: clears memory, back up before it"
        yield f"  MD32700 $MA_ENC_COMP_ENABLE[0,{name}] = 0, load the table, = 1, then approach the reference point"


def _line(words: str, value: Value | float) -> str:
    """A line of the terms: a `Value` to the digits that its U has, or a number that was not measured."""
    if not isinstance(value, Value):
        return f"  {words:52s} {value:z13.6f}  as in the machine file"
    digits = min(max(5, 1 - int(np.floor(np.log10(value.U)))), 9)
    found = f"{value.value:z13.{digits}f}  ± {value.U:.{digits}f}"
    return f"  {words:52s} {found} (k {value.k:.2f}, {value.free})"


def _entries(
    nominal: Machine, machine: Machine, groups: list[Group]
) -> Iterator[tuple[str, list[tuple[str, float]]]]:
    """Yield titles with rows, words and a number: what is entered of `machine`, which was `nominal`."""
    heads = [n for n, each in enumerate(nominal.rotary) if each.carries == "tool"]
    tables = [n for n, each in enumerate(nominal.rotary) if each.carries == "workpiece"]
    names = [each.name for each in nominal.rotary]
    points = [np.array(each.point) for each in machine.rotary]
    axes = [unit(each.axis) for each in nominal.rotary]
    tool = unit(nominal.tool_axis)
    for index in heads:
        axis, pivot = axes[index], np.array(nominal.rotary[index].point)
        if np.linalg.norm(np.cross(tool, axis)) > SMALL:  # else it turns the tool about itself
            alpha = np.cross(tool, unit(machine.tool_axis)) @ axis / (1 - (axis @ tool) ** 2)
            moved = points[index] - pivot - alpha * np.cross(axis, pivot)
            yield (
                f"head, {names[index]}: enter either these or the pivot below, not both",
                [
                    ("alpha, where it stands when it shows 0", np.degrees(alpha)),
                    ("dy, the spindle passes beside the pivot", -moved @ np.cross(tool, axis)),
                    ("dL, the tip is further from the pivot: test bar length", moved @ tool),
                ],
            )
    if len(tables) == 2 or len(heads) == 2:
        square = np.cross(axes[1], axes[0])
        normal = unit(square) * np.sign(max(square, key=abs))
        letters = [letter for letter, share in zip("XYZ", normal, strict=True) if abs(share) > 1 - SMALL]
        label = f"{names[0]} to {names[1]}, {f'in {letters[0]}' if letters else 'square to both'}"
        yield "distance of the axes (source 001, section 6, 2)", [(label, (points[1] - points[0]) @ normal)]
    for group in groups:
        if against := group.against(nominal):
            yield f"{group.title}; NOT FOR THIS MACHINE: {' and '.join(against)} turn the other way", []
        else:
            yield group.title, group.numbers(machine)
    yield 'LinuxCNC, other kinematics: "print machine.toml --to linuxcnc" holds any geometry, tilts too', []
