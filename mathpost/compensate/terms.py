"""What of a calibration goes where in a control, with its uncertainty, and in which order that is safe.

Sources: Heidenhain's kinematics table (iTNC 530: Trans and MachAxis) and KinematicsOpt (cycle programming manual,
340 49x-05); Siemens' TRAORI (840D: MD24500 and so on) and the swivel data of CYCLE800, whose vectors are those of
TRAORI (commissioning manual 12/2017, 6FC5397-1DP40-6BA1, 21.7); Fanuc's tool centre point control (30i: 19700 and
so on); LinuxCNC's xyzac-trt-kins and xyzbc-trt-kins, 2.8. Haas' numbers of settings were not to be had: by name.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from mathpost.compensate.calibrate import SMALL
from mathpost.measure.fit import Value
from mathpost.rotation import unit

NUMBERS = {"table-table": (40, 12), "head-head": (24, 2), "head-table": (56, 21)}  # MD24100, parameter 19680
# The vectors that belong to them, with `_entries`' arguments; a table comes before a head. Behind the machine data
# stands the first of three $TC_CARR of the same vector.
SIEMENS = {
    "table-table": [
        ("24550 BASE_TOOL 4", 0),
        ("24558 JOINT_OFFSET_PART 15", 1, 0),
        ("24500 PART_OFFSET 18", 1, None, -1),
    ],
    "head-head": [("24500 PART_OFFSET 1", 0), ("24560 JOINT_OFFSET 4", 1, 0), ("24550 BASE_TOOL 15", 1, None, -1)],
    "head-table": [
        ("24560 JOINT_OFFSET 1", 1),
        ("24550 BASE_TOOL 4", 1, None, -1),
        ("24558 JOINT_OFFSET_PART 15", 0),
        ("24500 PART_OFFSET 18", 0, None, -1),
    ],
}
CARR = {"table-table": "P", "head-head": "T", "head-table": "M"}  # $TC_CARR23
TABLE, HEAD = "19700 + {}, rotary table position", "19709 + {}, tool axis at the nose to its rotary axis"
FANUC = {
    "table-table": [(TABLE, 0), ("19703 + {}, first to second axis of the table", 1, 0)],
    "head-head": [(HEAD, 1), ("19712 + {}, second to first axis of the tool", 0, 1)],
    "head-table": [(TABLE, 0), (HEAD, 1)],
}
ORDER = """\
In this order, which keeps the machine safe:
  1. Back up the control's data, and write down the old numbers beside the new ones.
  2. Enter the numbers: in one place only (control, or machine.toml and errors.toml for programs), in its units.
  3. Dry run in the air, 200 mm off, feed at 5 %: one rotary axis at a time under RTCP; the tip must stand still.
  4. Measure again with a different method, and a different ball: what is left must lie within U.
  5. Only then cut, and keep the old numbers until the first part has been measured.
KinematicsOpt (cycle 451) and CYCLE996 probe a ball and find the same pivots, in the control: let one of them check
this in step 4, without letting it write. What two of them write in turn, nobody can tell apart afterwards."""


def terms(calibration):
    """Return what goes where in the controls, line by line with U, as text: mm, degrees, machine coordinates."""
    lines = ["where it goes, the value, U (95 %) with k and degrees of freedom; mm, degrees, machine coordinates"]
    nominal = calibration.nominal
    found = iter(calibration.of(lambda machine: [n for _, rows in _entries(nominal, machine) for _, n in rows]))
    for title, rows in _entries(nominal, nominal):
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


def _tables(calibration):
    """What Siemens needs besides a positioning table, in the names of machine axes."""
    for each in calibration.positioning:
        name = calibration.machine.joint_names[each.joint]
        count = len(each.at) + 1
        yield f"Siemens, positioning of {name}: the table wants the name of the *machine* axis, see MD10000"
        yield f"  MD38000 $MA_MM_ENC_COMP_MAX_POINTS[0,{name}] at least {count}: clears memory, back up before it"
        yield f"  MD32700 $MA_ENC_COMP_ENABLE[0,{name}] = 0, load the table, = 1, then approach the reference point"


def _line(words, value):
    """A line of the terms: a `Value` to the digits that its U has, or a number that was not measured."""
    if not isinstance(value, Value):
        return f"  {words:52s} {value:z13.6f}  as in the machine file"
    digits = min(max(5, 1 - int(np.floor(np.log10(value.U)))), 9)
    found = f"{value.value:z13.{digits}f}  ± {value.U:.{digits}f}"
    return f"  {words:52s} {found} (k {value.k:.2f}, {value.free})"


def _entries(nominal, machine):
    """Yield titles with rows, words and a number: what the controls want of `machine`, which was `nominal`."""
    heads = [n for n, each in enumerate(nominal.rotary) if each.carries == "tool"]
    tables = [n for n, each in enumerate(nominal.rotary) if each.carries == "workpiece"]
    names, kind = [each.name for each in nominal.rotary], nominal.arrangement
    points = [np.array(each.point) for each in machine.rotary]
    first, second = (unit(each.axis) for each in nominal.rotary)

    def vector(words, index, other=None, sign=1, labels=range(3)):
        """Where an axis is, from the zero or the spindle nose, or from another axis."""
        place = sign * (points[index] - (0 if other is None else points[other]))
        return [(words.format(label), number) for label, number in zip(labels, place, strict=True)]

    tool = unit(nominal.tool_axis)
    for index in heads:
        axis, pivot = (first, second)[index], np.array(nominal.rotary[index].point)
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
        normal = unit(np.cross(second, first)) * np.sign(max(np.cross(second, first), key=abs))
        letters = [letter for letter, share in zip("XYZ", normal, strict=True) if abs(share) > 1 - SMALL]
        label = f"{names[0]} to {names[1]}, {f'in {letters[0]}' if letters else 'square to both'}"
        yield "distance of the axes (source 001, section 6, 2)", [(label, (points[1] - points[0]) @ normal)]

    rows = []
    for chain in ([None, *reversed(heads)], [None, *tables]):  # each axis from the one before it
        for before, index in pairwise(chain):
            rows += vector(f"Trans {{}} before MachAxis {names[index]}", index, before, labels="XYZ")
    yield "Heidenhain, kinematics table (KEY AXIS COORD), vectors of the centres from spindle to workpiece", rows

    siemens, fanuc = NUMBERS[kind]
    rows, carrier = [], []
    for words, *which in SIEMENS[kind]:
        parameter, name, start = words.split()
        rows += vector(f"MD{parameter} $MC_TRAFO5_{name}_1[{{}}]", *which)
        carrier += vector("$TC_CARR{}[n]", *which, labels=range(int(start), int(start) + 3))
    for place, index in enumerate((1, 0) if kind == "head-table" else (0, 1)):
        sign = -1 if nominal.rotary[index].carries == "workpiece" else 1  # a table's axis is entered reversed
        axis = [sign * number for number in machine.rotary[index].axis]
        words = f"MD{24570 + 2 * place} $MC_TRAFO5_AXIS{1 + place}_1"
        rows += [(f"{words}[{n}]", number) for n, number in enumerate(axis)]
        carrier += [(f"$TC_CARR{7 + 3 * place + n}[n]", number) for n, number in enumerate(axis)]
    yield f"Siemens, TRAORI, MD24100 $MC_TRAFO_TYPE_1 = {siemens}", rows
    yield (
        f'Siemens, CYCLE800, swivel data n: $TC_CARR23[n] = "{CARR[kind]}"; the same vectors, which must agree',
        carrier,
    )

    rows = [row for words, *which in FANUC[kind] for row in vector(words, *which)]
    yield (
        f"Fanuc, tool centre point control, 19680 = {fanuc}, 19666 = 0; the place of a table also stands in the "
        "parameters of rotary table dynamic fixture offset, if that is fitted, and must be the same there",
        rows,
    )
    if tables:
        rows = [row for n in tables for row in vector(f"rotary zero point of {names[n]}, {{}}", n, labels="XYZ")]
        yield (
            "Haas, machine rotary zero point (MRZP offsets in the settings), machine coordinates at rotary zero",
            rows,
        )
    yield from _linuxcnc(names, points, kind)


def _linuxcnc(names, points, kind):
    """The parameters of xyzac-trt-kins and xyzbc-trt-kins: C, and how far A or B passes beside it."""
    if kind != "table-table" or names[1] != "C" or names[0] not in "AB":
        return
    module, along = f"xyz{names[0].lower()}c-trt-kins", {"A": "y", "B": "x"}[names[0]]
    (tilt, turn), beside = points, "xyz".index({"A": "y", "B": "x"}[names[0]])
    yield (
        f"LinuxCNC, {module}: setp in the HAL file; tool-offset from motion.tooloffset.z; no tilts",
        [
            (f"{module}.x-rot-point", turn[0]),
            (f"{module}.y-rot-point", turn[1]),
            (f"{module}.z-rot-point", turn[2]),
            (f"{module}.{along}-offset", tilt[beside] - turn[beside]),
            (f"{module}.z-offset", tilt[2] - turn[2]),
        ],
    )
