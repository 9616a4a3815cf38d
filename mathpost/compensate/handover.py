"""A calibration as files: the machine, its errors, and the terms in which each control wants them.

The terms are those of Heidenhain's kinematics table (iTNC 530: Trans and MachAxis), of Siemens' TRAORI (840D:
MD24500 and so on) and of Fanuc's tool centre point control (30i: 19700 and so on), after the makers' manuals.
"""

import json

import numpy as np

from mathpost.compensate.calibrate import SMALL, columns
from mathpost.compensate.model import SQUARENESS
from mathpost.errors import InputError, OutputError, write_text
from mathpost.machine import find, read_toml
from mathpost.measure import control_table
from mathpost.rotation import unit

FANUC = {"table-table": 12, "head-head": 2, "head-table": 21}  # parameter 19680
SIEMENS = {"table-table": 40, "head-head": 24, "head-table": 56}  # MD24100


def write(calibration, path, folder, inputs=()):
    """Write machine.toml, errors.toml and tables of controls for each axis, and terms.txt; return their paths.

    Parameters
    ----------
    calibration : mathpost.compensate.calibrate.Calibration
    path : path-like
        The machine file that was calibrated, or the name of a machine that comes with the package: limits, rates
        and program lines are taken over.
    folder : pathlib.Path
        Is made if it does not exist.
    inputs : sequence of paths
        Files that must not be replaced.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: not written, {error.strerror}") from None
    files = {"machine.toml": machine_file(calibration, path), **error_files(calibration)}
    tables, notes = control_tables(calibration)
    files |= tables
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
    machine, square = calibration.machine, [n for n in SQUARENESS if n in calibration.values]
    content = {"name": f"{machine.name}, calibrated", "source": "calibrated from readings"}
    content |= {"constant": {n: 1e6 * calibration.values[n] for n in square}}
    files, content["table"] = {}, []
    for each in calibration.positioning:
        name = machine.joint_names[each.joint]
        entry = {"joint": name, "file": f"errors_{name.lower()}.csv"}
        content["table"].append(entry | ({"endless": True} if each.endless else {}))
        found = columns(machine, each)
        rows = np.column_stack([each.at, *found.values()])
        lines = ["# source: calibrated from readings; degrees or mm, µm, µrad", ",".join(["position", *found])]
        lines += [",".join(f"{number:.6f}" for number in row) for row in rows]
        files[entry["file"]] = "\n".join(lines) + "\n"
    return {"errors.toml": toml(content), **files}


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
    """Return what goes where in the controls, line by line with U, as text: mm, degrees, machine coordinates.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.compensate.calibrate import calibrate
    >>> found = calibrate(machine.load("data/machines/ac_table.toml"), ["data/measurements/ball_c_axis.csv"])
    >>> [line.split() for line in terms(found).splitlines() if "19703 + 1" in line][0][-6:-2]
    ['-0.00594', '±', '0.00037', '(k']
    """
    lines = ["where it goes, the value, U (95 %) with k and degrees of freedom; mm, degrees, machine coordinates"]
    for title, entries in _entries(calibration.nominal):
        lines.append(title)
        for words, function in entries:
            each = calibration.of(function)
            sure = _sure(each) if each.U > 1e-9 else "as in the machine file"
            lines.append(f"  {words:52s} {each.value:z13.5f}  {sure}")
    lines += _bar(calibration)
    lines.append(
        "A kinematics table without axis vectors cannot hold the tilts; a program made with machine.toml does."
    )
    lines.append("(Heidenhain's KinematicsComp can: as Trans A B C before a MachAxis, and back behind it.)")
    return "\n".join(lines) + "\n"


def _bar(calibration):
    """Lines of what source 001 has measured first: length and ball radius of the test bar."""
    length, radius = calibration.bar.get("length"), calibration.bar.get("radius")
    long = calibration.nominal.tool_length + (length.value if length else 0.0)
    said = f"{long:z13.5f}  {_sure(length) if length else 'as in the machine file'}"
    ball = f"{radius.value:z13.5f}  {_sure(radius)}" if radius else f"{'not measured':>13s}"
    return [
        "tool table, test bar (source 001, section 6, 1): enter L before the other readings are taken",
        f"  {'L, length of the test bar':52s} {said}",
        f"  {'R, radius of its ball':52s} {ball}",
    ]


def _sure(value):
    return f"± {value.U:.5f} (k {value.k:.2f}, {value.free})"


def _entries(nominal):
    """Yield titles, and pairs of words and functions of a machine."""
    heads = [n for n, each in enumerate(nominal.rotary) if each.carries == "tool"]
    tables = [n for n, each in enumerate(nominal.rotary) if each.carries == "workpiece"]
    names, kind = [each.name for each in nominal.rotary], nominal.arrangement

    def point(index, other=None, sign=1):
        """Where an axis is, from the machine's zero or the spindle nose, or from another axis."""

        def vector(machine):
            start = np.zeros(3) if other is None else np.array(machine.rotary[other].point)
            return sign * (np.array(machine.rotary[index].point) - start)

        return vector

    def along(words, vector, labels="XYZ"):
        return [(words.format(name), lambda m, n=n: vector(m)[n]) for n, name in enumerate(labels)]

    for index in heads:
        axis, tool = unit(nominal.rotary[index].axis), unit(nominal.tool_axis)
        swing, pivot = np.cross(tool, axis), np.array(nominal.rotary[index].point)
        if np.linalg.norm(swing) < SMALL:  # it turns the tool about itself
            continue

        def alpha(machine, axis=axis, tool=tool):
            return np.cross(tool, unit(machine.tool_axis)) @ axis / (1 - (axis @ tool) ** 2)

        def moved(machine, index=index, axis=axis, alpha=alpha, pivot=pivot):
            return np.array(machine.rotary[index].point) - pivot - alpha(machine) * np.cross(axis, pivot)

        yield (
            f"head, {names[index]}: enter either these or the pivot below, not both",
            [
                ("alpha, where it stands when it shows 0", lambda m, f=alpha: np.degrees(f(m))),
                ("dy, the spindle passes beside the pivot", lambda m, f=moved, s=swing: -f(m) @ s),
                ("dL, the tip is further from the pivot: test bar length", lambda m, f=moved, t=tool: f(m) @ t),
            ],
        )
    if len(tables) == 2 or len(heads) == 2:
        first, second = (unit(each.axis) for each in nominal.rotary)
        normal = unit(np.cross(second, first)) * np.sign(max(np.cross(second, first), key=abs))
        letters = [letter for letter, share in zip("XYZ", normal, strict=True) if abs(share) > 1 - SMALL]
        label = f"{names[0]} to {names[1]}, {f'in {letters[0]}' if letters else 'square to both'}"
        yield "distance of the axes (source 001, section 6, 2)", [(label, lambda m: point(1, 0)(m) @ normal)]

    rows = []
    for before, index in zip([None, *reversed(heads)], [*reversed(heads)], strict=False):
        rows += along(f"Trans {{}} before MachAxis {names[index]}", point(index, before))
    for before, index in zip([None, *tables], tables, strict=False):
        rows += along(f"Trans {{}} before MachAxis {names[index]}", point(index, before))
    yield "Heidenhain, kinematics table (KEY AXIS COORD), vectors of the centres from spindle to workpiece", rows

    rows = []
    if kind == "table-table":
        numbers = [(24550, "BASE_TOOL", point(0)), (24558, "JOINT_OFFSET_PART", point(1, 0))]
        numbers += [(24500, "PART_OFFSET", point(1, sign=-1))]
    elif kind == "head-head":
        numbers = [(24500, "PART_OFFSET", point(0)), (24560, "JOINT_OFFSET", point(1, 0))]
        numbers += [(24550, "BASE_TOOL", point(1, sign=-1))]
    else:
        numbers = [(24560, "JOINT_OFFSET", point(1)), (24550, "BASE_TOOL", point(1, sign=-1))]
        numbers += [(24558, "JOINT_OFFSET_PART", point(0)), (24500, "PART_OFFSET", point(0, sign=-1))]
    for number, name, vector in numbers:
        rows += along(f"MD{number} $MC_TRAFO5_{name}_1[{{}}]", vector, range(3))
    order = (1, 0) if kind == "head-table" else (0, 1)
    for number, index in zip((24570, 24572), order, strict=True):
        sign = -1 if nominal.rotary[index].carries == "workpiece" else 1  # a table's axis is entered reversed
        words = f"MD{number} $MC_TRAFO5_AXIS{1 + order.index(index)}_1[{{}}]"
        rows += along(words, lambda m, n=index, s=sign: s * np.array(m.rotary[n].axis), range(3))
    yield f"Siemens, TRAORI, MD24100 $MC_TRAFO_TYPE_1 = {SIEMENS[kind]}", rows

    rows = []
    if tables:
        rows += along("19700 + {}, rotary table position", point(tables[0]), range(3))
    if len(tables) == 2:
        rows += along("19703 + {}, first to second axis of the table", point(1, 0), range(3))
    if heads:
        rows += along("19709 + {}, tool axis at the nose to its rotary axis", point(heads[-1]), range(3))
    if len(heads) == 2:
        rows += along("19712 + {}, second to first axis of the tool", point(0, 1), range(3))
    yield f"Fanuc, tool centre point control, 19680 = {FANUC[kind]}, 19666 = 0", rows


def toml(content):
    """A machine's or an errors' content as TOML: keys, tables and lists of tables."""
    plain = {key: value for key, value in content.items() if not _is_table(value)}
    lines = [f"{key} = {_value(value)}" for key, value in plain.items()]
    for key, value in content.items():
        for entry in value if isinstance(value, list) and _is_table(value) else [value] * _is_table(value):
            lines += ["", f"[[{key}]]" if isinstance(value, list) else f"[{key}]"]
            lines += [f"{name} = {_value(each)}" for name, each in entry.items()]
    return "\n".join(lines) + "\n"


def _is_table(value):
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _value(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value, ensure_ascii=False)
