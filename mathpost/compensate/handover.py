"""A calibration as files: the machine, its errors, and the terms in which each control wants them.

The terms are those of Heidenhain's kinematics table (iTNC 530: Trans and MachAxis), of Siemens' TRAORI (840D:
MD24500 and so on) and of Fanuc's tool centre point control (30i: 19700 and so on), after the makers' manuals.
"""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np

from mathpost.compensate.calibrate import SMALL, columns
from mathpost.compensate.model import SQUARENESS
from mathpost.errors import InputError, OutputError
from mathpost.files import write_text
from mathpost.machine import find
from mathpost.measure import control_table
from mathpost.measure.fit import Value
from mathpost.rotation import unit
from mathpost.toml_table import read_toml

NUMBERS = {"table-table": (40, 12), "head-head": (24, 2), "head-table": (56, 21)}  # MD24100, parameter 19680
# The vectors that belong to them, with `_entries`' arguments; a table comes before a head.
SIEMENS = {
    "table-table": [("24550 BASE_TOOL", 0), ("24558 JOINT_OFFSET_PART", 1, 0), ("24500 PART_OFFSET", 1, None, -1)],
    "head-head": [("24500 PART_OFFSET", 0), ("24560 JOINT_OFFSET", 1, 0), ("24550 BASE_TOOL", 1, None, -1)],
    "head-table": [
        ("24560 JOINT_OFFSET", 1),
        ("24550 BASE_TOOL", 1, None, -1),
        ("24558 JOINT_OFFSET_PART", 0),
        ("24500 PART_OFFSET", 0, None, -1),
    ],
}
TABLE, HEAD = "19700 + {}, rotary table position", "19709 + {}, tool axis at the nose to its rotary axis"
FANUC = {
    "table-table": [(TABLE, 0), ("19703 + {}, first to second axis of the table", 1, 0)],
    "head-head": [(HEAD, 1), ("19712 + {}, second to first axis of the tool", 0, 1)],
    "head-table": [(TABLE, 0), (HEAD, 1)],
}


def write(calibration, path, folder, inputs=()):
    """Write machine.toml, errors.toml and tables of controls for each axis, and terms.txt; return their paths.

    `path` is the machine file that was calibrated, or the name of one that comes with the package. `folder`, a
    `pathlib.Path`, is made if it does not exist; `inputs` are files that must not be replaced.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: not written, {error.strerror}") from None
    tables, notes = control_tables(calibration)
    files = {"machine.toml": machine_file(calibration, path), **error_files(calibration), **tables}
    files["terms.txt"] = "\n".join([str(calibration), "", terms(calibration), *notes, ""])
    for name, text in files.items():
        write_text(folder / name, text, inputs=[find(path), *inputs])
    return [folder / name for name in files]


def machine_file(calibration, path):
    """Return the machine file `path` with the calibrated axes, points and tool: all else stays as it was."""
    content, machine = read_toml(find(path)), calibration.machine
    content["name"] += ", calibrated"
    for entry, rotary in zip(content["rotary"], machine.rotary, strict=True):
        entry |= {"axis": list(rotary.axis), "point": list(rotary.point)}
    content["tool"]["axis"] = list(machine.tool_axis)
    if not isinstance(machine.programmed_point, str):
        content["tool"]["programmed_point"] = list(machine.programmed_point)
    return toml(content)


def error_files(calibration):
    """Return errors.toml and its tables, names to texts, for ``post --errors`` with the calibrated machine."""
    machine, files, tables = calibration.machine, {}, []
    square = {n: 1e6 * calibration.values[n] for n in SQUARENESS if n in calibration.values}
    for each in calibration.positioning:
        name = machine.joint_names[each.joint]
        entry = {"joint": name, "file": f"errors_{name.lower()}.csv"}
        tables.append(entry | ({"endless": True} if each.endless else {}))
        found = columns(machine, each)
        rows = np.column_stack([each.at, *found.values()])
        lines = ["# source: calibrated from readings; degrees or mm, µm, µrad", ",".join(["position", *found])]
        lines += [",".join(f"{number:.6f}" for number in row) for row in rows]
        files[entry["file"]] = "\n".join(lines) + "\n"
    content = {"name": f"{machine.name}, calibrated", "source": "calibrated from readings"}
    return {"errors.toml": toml(content | {"constant": square, "table": tables}), **files}


def control_tables(calibration):
    """Return positioning tables in the controls' own formats, names to texts, and notes on them."""
    files, notes = {}, []
    for each in calibration.positioning:
        name = calibration.machine.joint_names[each.joint]
        curve = each.curve(each.value)
        step = 360 / len(each.at) if each.endless else np.ptp(each.at) / (len(each.at) - 1)
        unit = np.rad2deg(1) if each.joint > 2 else 1.0
        files[f"siemens_{name.lower()}.ini"] = control_table.siemens(name, step, curve, unit=unit)
        try:
            files[f"fanuc_{name.lower()}.txt"] = control_table.fanuc(each.joint + 1, step, curve, unit=unit)
        except InputError as error:
            notes.append(f"no table for Fanuc, {name}: {error}")
    if files:
        notes.append(control_table.HEIDENHAIN)
        notes.append("positioning: enter a table in the control, or use errors.toml for programs; never both")
    return files, notes


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
    ]
    return "\n".join(lines) + "\n"


def _line(words, value):
    """A line of the terms: a `Value`, or a number that was not measured."""
    if not isinstance(value, Value):
        return f"  {words:52s} {value:z13.5f}  as in the machine file"
    return f"  {words:52s} {value.value:z13.5f}  ± {value.U:.5f} (k {value.k:.2f}, {value.free})"


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
    rows = []
    for words, *which in SIEMENS[kind]:
        parameter, name = words.split()
        rows += vector(f"MD{parameter} $MC_TRAFO5_{name}_1[{{}}]", *which)
    for place, index in enumerate((1, 0) if kind == "head-table" else (0, 1)):
        sign = -1 if nominal.rotary[index].carries == "workpiece" else 1  # a table's axis is entered reversed
        words = f"MD{24570 + 2 * place} $MC_TRAFO5_AXIS{1 + place}_1"
        rows += [(f"{words}[{n}]", sign * number) for n, number in enumerate(machine.rotary[index].axis)]
    yield f"Siemens, TRAORI, MD24100 $MC_TRAFO_TYPE_1 = {siemens}", rows

    rows = [row for words, *which in FANUC[kind] for row in vector(words, *which)]
    yield f"Fanuc, tool centre point control, 19680 = {fanuc}, 19666 = 0", rows


def toml(content):
    """A machine's or an errors' content as TOML: keys, then tables and lists of tables."""
    lines, tables = [], []
    for key, value in content.items():
        if isinstance(value, dict):
            tables.append((f"[{key}]", value))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            tables += [(f"[[{key}]]", entry) for entry in value]
        else:
            lines.append(f"{key} = {_value(value)}")
    for title, entry in tables:
        lines += ["", title, *(f"{name} = {_value(each)}" for name, each in entry.items())]
    return "\n".join(lines) + "\n"


def _value(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False)
