"""A tool axis to every position of a machine, or joints to tip and tool axis."""

import argparse
import json
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from mathpost import machine_file
from mathpost.errors import InputError
from mathpost.interface.shell.options import JSON, MACHINE, PRESENT, THREE, columns, count_of, named, number
from mathpost.kinematics import Kinematics
from mathpost.shop.plane import pose


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add = parser.add_argument
    add("machine", **MACHINE)
    add("--axis", **THREE, metavar=("I", "J", "K"), help="tool axis in the workpiece, of any length")
    add("--tip", **THREE, default=("0", "0", "0"), metavar=("X", "Y", "Z"), help="mm (default 0 0 0)")
    add("--joints", nargs="+", type=number, metavar="Q", help="instead: X Y Z in mm and the rotary angles, degrees")
    add("--from", **PRESENT)
    add("--json", **JSON)


def run(options: argparse.Namespace) -> int:
    """Print the positions, or the pose; return 1 if nothing is inside travel."""
    if (options.axis is None) == (options.joints is None):
        raise InputError("pose", "--axis or --joints", "both" if options.axis else "neither")
    kinematics = Kinematics(machine_file.load(options.machine))
    names, taken = kinematics.machine.joint_names, {}
    present = standing(options, names[3:])
    if options.joints:
        found = [pose.at(kinematics, np.array(count_of(options.joints, names, "--joints")))]
    else:
        axis = floats(options.axis)
        found = pose.positions(kinematics, floats(options.tip), axis, present)
        taken = pose.taken(kinematics, axis, present)
    print(_json(kinematics, found, present, taken) if options.json else _text(kinematics, found, present, taken))
    return int(all(position.reasons for position in found))


def standing(options: argparse.Namespace, names: Sequence[str]) -> list[float]:
    """Return where the rotary axes `names` stand: as --from says, or at 0."""
    return count_of(options.present, names, "--from") if options.present else [0.0] * len(names)


def floats(texts: Iterable[str]) -> np.ndarray:
    """Return numbers that were typed as an array."""
    return np.array([float(text) for text in texts])


def _text(
    kinematics: Kinematics, found: Sequence[pose.Position], present: Sequence[float], taken: dict[str, pose.Taken]
) -> str:
    """Return a table of the positions, and one of those that the controls take."""
    model, first = kinematics.machine, found[0]
    tip, axis = named("XYZ", first.tip), named("ijk", first.axis, 6)
    lines = [f"{model.name} ({model.arrangement})", f"tip {tip} mm"]
    lines += [f"tool axis {axis}, {first.from_pole:.4f}° from the pole", "", *position_rows(kinematics, found)]
    return "\n".join([*lines, "", *control_lines(kinematics, found, present, taken)] if taken else lines)


def position_rows(kinematics: Kinematics, found: Sequence[pose.Position]) -> list[str]:
    """Return the lines of a table of positions."""
    rows = [("", *kinematics.machine.joint_names, "")]
    for n, position in enumerate(found, 1):
        joints = (f"{value:z.4f}" for value in position.joints)
        rows.append((str(n), *joints, "; ".join(position.reasons) or "inside travel"))
    return columns(rows)


def control_lines(
    kinematics: Kinematics, found: Sequence[pose.Position], present: Sequence[float], taken: dict[str, pose.Taken]
) -> list[str]:
    """Return lines that say which of the positions each control takes."""
    names, rows = kinematics.machine.joint_names[3:], []
    for control, choice in taken.items():
        at = "none"
        if choice.angles is not None:
            off = [np.abs(position.joints[3:] - choice.angles).max() for position in found]
            number_of = f"{int(np.argmin(off)) + 1}: " if min(off) < 1e-6 else ""
            at = number_of + named(names, choice.angles)
        rows.append((control, at, choice.why))
    return [f"From {named(names, present)} the control takes", *columns(rows)]


def _json(
    kinematics: Kinematics, found: Sequence[pose.Position], present: Sequence[float], taken: dict[str, pose.Taken]
) -> str:
    names = kinematics.machine.joint_names
    positions = [
        {
            "joints": dict(zip(names, position.joints.tolist(), strict=True)),
            "tip": position.tip.tolist(),
            "axis": position.axis.tolist(),
            "from_pole": position.from_pole,
            "out_of_travel": list(position.reasons),
        }
        for position in found
    ]
    content: dict[str, Any] = {"machine": kinematics.machine.name, "positions": positions}
    if taken:
        standing = dict(zip(names[3:], map(float, present), strict=True))
        content |= {"from": standing, "controls": pose.as_data(kinematics, taken)}
    return json.dumps(content, ensure_ascii=False, indent=1)
