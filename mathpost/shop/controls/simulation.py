"""A folder that runs a machine on LinuxCNC, in simulation: its kinematics as a module, and all that starts it."""

import re
from pathlib import Path
from string import Template

import numpy as np

from mathpost.errors import InputError
from mathpost.files import read_text, write_set
from mathpost.kinematics import Kinematics
from mathpost.machine import UNITS, Machine
from mathpost.path.nc_words import written
from mathpost.shop import codegen
from mathpost.shop.controls import control

TEMPLATES = Path(__file__).parent / "linuxcnc"
RATE, ACCELERATION = 100.0, 1000.0  # mm or degrees per s and s², assumed where the machine file states none
LINUXCNC_OFFSETS = 9  # G54 … G59.3
FAR = 1e6  # mm or degrees, for travel without an end


def write_folder(kin: Kinematics, folder: str | Path) -> list[Path]:
    """Write the files of `texts` to a folder, made if there is none; return their paths."""
    folder, contents = Path(folder), texts(kin)
    write_set({folder / name: text for name, text in contents.items()}, folders=True)
    return [folder / name for name in contents]


def texts(kin: Kinematics) -> dict[str, str]:
    """Return the files that run a machine on LinuxCNC, name to content.

    Joints are in machine coordinates, so that their travel is that of the machine file; G54 holds what the words of
    a program count from. `InputError` is raised if a rotary axis is not called A, B or C.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> sorted(texts(Kinematics(load_machine("dmu50v"))))
    ['README.txt', 'kins_dmu_50v_45_degree_b_tabl.c', 'machine.hal', 'machine.ini', 'machine.tbl', 'machine.var']
    """
    machine = kin.machine
    control.control_for(machine, "linuxcnc")
    for joint in machine.rotary:
        if joint.name not in ("A", "B", "C"):
            raise InputError("rotary axis name", "A, B or C, for LinuxCNC", repr(joint.name))
    module = f"kins_{re.sub('[^a-z0-9]+', '_', machine.name.lower())[:24]}".strip("_")
    zero = machine.slides
    rates = _stated(machine.max_rates, RATE)
    joints = len(machine.joint_names)
    fields: dict[str, object] = {
        "title": re.sub(r"[^\w ,.()+-]", " ", machine.name.encode("ascii", "replace").decode()),
        "module": module,
        "joints": joints,
        "printed": codegen.machine(kin, "c"),
        "zero": ", ".join(f"{value + 0.0!r}" for value in zero.tolist()),
        "angles": ", ".join(f"&world->{joint.name.lower()}" for joint in machine.rotary),
        "letters": "".join(machine.joint_names),
        "fastest": f"{2 * rates[:3].max():g}",
        "turning": f"{2 * rates[3:].max():g}",
        "length": f"{machine.tool_length:g}",
        "origin": written(dict(zip("XYZ", machine.origin, strict=True))),
        "offset": written(dict(zip("XYZ", zero, strict=True))),
        "tables": _parameters(machine),
    }
    ini, hal = _filled("machine.ini", fields), _filled("machine.hal", fields)
    return {
        f"{module}.c": _filled("kinematics.c", fields),
        "machine.ini": ini + _joints(machine, rates),
        "machine.hal": hal
        + "".join(f"net joint{n} joint.{n}.motor-pos-cmd => joint.{n}.motor-pos-fb\n" for n in range(joints)),
        "machine.tbl": "T1 P1 Z0 ;the length is in the kinematics and in G54\n",
        "machine.var": "".join(f"{number}\t{value:.6f}\n" for number, value in _work_offsets(machine).items()),
        "README.txt": _filled("README.txt", fields),
    }


def _work_offsets(machine: Machine) -> dict[int, float]:
    """The parameters of G54 to G59.3, six of every twenty from 5221 on, with G54 selected (5220)."""
    values: dict[int, float] = {5220: 1}
    for number, origin in sorted([(machine.offset or 1, machine.origin), *machine.offsets]):
        if number <= LINUXCNC_OFFSETS:
            slides = machine.with_setup(origin=origin).slides
            values |= dict(enumerate([*slides.tolist(), 0, 0, 0], 5221 + 20 * (number - 1)))
    return values


def _filled(name: str, fields: dict[str, object]) -> str:
    return Template(read_text(TEMPLATES / name)).substitute(fields)


def _stated(values: np.ndarray, assumed: float) -> np.ndarray:
    """What the machine file states of each joint, mm and degrees, or what is assumed."""
    return np.nan_to_num(np.asarray(values, float) * UNITS[: len(values)], nan=assumed)


def _joints(machine: Machine, rates: np.ndarray) -> str:
    """The INI sections of axes and joints. Without TCP an axis is its joint, with TCP the tip: wide limits."""
    limits = machine.limits.copy()
    limits[:3] += machine.slides[:, None]
    limits = np.clip(limits * UNITS[: len(limits), None], -FAR, FAR)
    accelerations = _stated(machine.max_accelerations, ACCELERATION)
    lines = []
    for n, name in enumerate(machine.joint_names):
        moved = [f"MAX_VELOCITY = {rates[n]:g}", f"MAX_ACCELERATION = {accelerations[n]:g}"]
        low, high = limits[n]
        lines += ["", f"[AXIS_{name}]", f"MIN_LIMIT = {-FAR:g}", f"MAX_LIMIT = {FAR:g}", *moved]
        lines += ["", f"[JOINT_{n}]", f"TYPE = {'LINEAR' if n < 3 else 'ANGULAR'}"]
        lines += [f"MIN_LIMIT = {low:.6g}", f"MAX_LIMIT = {high:.6g}", *moved]
        lines += [
            f"HOME = {np.clip(0, low, high):g}",
            "HOME_SEQUENCE = 0",
            "HOME_SEARCH_VEL = 0",
            "HOME_LATCH_VEL = 0",
        ]
        lines += ["FERROR = 1000", "MIN_FERROR = 1000"]
    return "\n".join(lines) + "\n"


def _parameters(machine: Machine) -> str:
    """What LinuxCNC's own module for two tables would have to be told, or why it does not fit."""
    own = next((group for group in control.load("linuxcnc").geometry if group.fits(machine)), None)
    if own is None:
        both = "LinuxCNC's own xyzac-trt-kins and xyzbc-trt-kins are for two tables"
        return f"{both}, A along X or B along Y\n   that carries C along Z: not for this machine."
    module = own.rows[0][0].partition(".")[0]
    told = ", ".join(f"{words.partition('.')[2]} {value:g}" for words, value in own.numbers(machine))
    sign = "turns the workpiece positively, as this machine does"
    if against := own.against(machine):
        these = f"{' and '.join(against)} {'does' if len(against) == 1 else 'do'} not (ISO 841)"
        sign = f"turns the workpiece positively; here {these}: it would put the tip elsewhere"
    return f"LinuxCNC's own {module} takes {told},\n   tool-offset {machine.tool_length:g}. It {sign}."
