"""A calibration as files: the machine, its errors, tables of controls, and `terms` of what goes where."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import tomlkit

from mathpost.errors import InputError
from mathpost.files import read_text, read_toml, write_set
from mathpost.machine_file import find
from mathpost.shop.compensate.calibration import Calibration, columns
from mathpost.shop.compensate.model import error_names, fingerprint, shown_in
from mathpost.shop.compensate.terms import terms
from mathpost.shop.controls import compensation_table


def write(
    calibration: Calibration, path: str | Path, folder: Path, inputs: Iterable[Path | str] = ()
) -> list[Path]:
    """Write machine.toml, errors.toml and tables of controls for each axis, and terms.txt; return their paths.

    `path` is the machine file that was calibrated, or the name of one that comes with the package. `folder`, a
    `pathlib.Path`, is made if it does not exist; `inputs` are files that must not be replaced. If the readings do
    not fit, every file begins with the reasons.
    """
    tables, notes = control_tables(calibration)
    files = {"machine.toml": machine_file(calibration, path), **error_files(calibration)}
    files = {name: _doubted(calibration, "#") + text for name, text in files.items()}
    files |= {name: _doubted(calibration, ";") + text for name, text in tables.items()}
    files["terms.txt"] = "\n".join([str(calibration), "", calibration.on_trust, "", terms(calibration), *notes, ""])
    write_set({folder / name: text for name, text in files.items()}, inputs=[find(path), *inputs], folders=True)
    return [folder / name for name in files]


def _doubted(calibration: Calibration, mark: str) -> str:
    """Comments that say why the readings do not fit; nothing if they do."""
    said = "ACCEPTED ALTHOUGH THE READINGS DO NOT FIT:"
    return "".join(f"{mark} {line}\n" for line in (said, *calibration.doubts)) if calibration.doubts else ""


def machine_file(calibration: Calibration, path: str | Path) -> str:
    """Return the machine file `path` with the calibrated axes, points and tool: all else, comments too, stays."""
    read_toml(find(path))  # which says what is wrong with it
    content, machine = tomlkit.parse(read_text(find(path))), calibration.machine
    content["name"] = f"{content['name']}, calibrated"
    for entry, rotary in zip(content["rotary"], machine.rotary, strict=True):
        _replace(entry, "axis", rotary.axis)
        _replace(entry, "point", rotary.point)
    _replace(content["tool"], "axis", machine.tool_axis)
    if machine.programmed_point == "tip" and machine.length_axis is not None:
        _replace(content["tool"], "length_axis", machine.length_axis)
    return tomlkit.dumps(content)


def _replace(table: tomlkit.items.Table, key: str, vector: Iterable[float]) -> None:
    """Replace a vector in a table; the comment behind it stays."""
    if key in table and list(table[key]) == list(vector):
        return
    found = tomlkit.array()
    found.extend(map(float, vector))
    if key in table:
        found.trivia.comment_ws, found.trivia.comment = table[key].trivia.comment_ws, table[key].trivia.comment
    table[key] = found


def error_files(calibration: Calibration) -> dict[str, str]:
    """Return errors.toml and its tables, names to texts, for ``post --errors`` with the calibrated machine."""
    machine, files, tables = calibration.machine, {}, []
    constant = dict(zip(error_names(machine), calibration.errors.constant.tolist(), strict=True))
    sizes = {name: shown_in(name)[0] * value for name, value in constant.items() if value}
    for each in calibration.positioning:
        name = machine.joint_names[each.joint]
        entry = {"joint": name, "file": f"errors_{name.lower()}.csv"}
        tables.append(entry | ({"endless": True} if each.endless else {}))
        errors = columns(machine, each)
        rows = np.column_stack([each.at, *errors.values()])
        place = "degrees" if each.joint > 2 else "mm, machine coordinates while no tool length is active"
        lines = [f"# source: calibrated from readings; position in {place}; µm, µrad"]
        lines.append(",".join(["position", *errors]))
        lines += [",".join(f"{number:.6f}" for number in row) for row in rows]
        files[entry["file"]] = "\n".join(lines) + "\n"
    content = tomlkit.document()
    content.add("name", f"{machine.name}, calibrated")
    content.add("source", "calibrated from readings")
    content.add("machine", tomlkit.item(fingerprint(machine)).comment("of the machine.toml beside this file, only"))
    content.add("constant", tomlkit.item(sizes))
    if tables:
        content.add("table", tomlkit.item(tables))
    return {"errors.toml": tomlkit.dumps(content), **files}


def control_tables(calibration: Calibration) -> tuple[dict[str, str], list[str]]:
    """Return positioning tables in the controls' own formats, names to texts, and notes on them."""
    files, notes = {}, []
    for each in calibration.positioning:
        name = calibration.machine.joint_names[each.joint]
        curve = each.curve(each.value)
        step = 360 / len(each.at) if each.endless else np.ptp(each.at) / (len(each.at) - 1)
        unit = np.rad2deg(1) if each.joint > 2 else 1.0
        files[f"siemens_{name.lower()}.ini"] = compensation_table.siemens(name, step, curve, unit=unit)
        try:
            files[f"fanuc_{name.lower()}.txt"] = compensation_table.fanuc(each.joint + 1, step, curve, unit=unit)
        except InputError as error:
            notes.append(f"no table for Fanuc, {name}: {error}")
    if files:
        notes.append(compensation_table.HEIDENHAIN)
        notes.append("positioning: enter a table in the control, or use errors.toml for programs; never both")
    return files, notes
