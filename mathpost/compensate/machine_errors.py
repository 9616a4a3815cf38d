"""The errors of one calibrated machine, read from a TOML file and evaluated at any position of its joints.

Bohez (source 001) has two groups of errors. Those that do not depend on position stand under [constant]; the others
in tables, each over the position of one joint::

    name = "…"
    source = "…"
    structure = "w C A b X Y Z t"     # where the slides stand; this is the default for an AC table

    [constant]                        # µm and µrad, named as in mathpost.compensate.error_model
    EXA = 10
    EAA = 30

    [[table]]
    joint = "C"
    file = "c_axis.csv"               # beside this file: the column position (degrees or mm), then ECC, EZC, …
    endless = true                    # repeats after 360°; without it the errors end where the table ends
    interpolation = "spline"          # or "linear"

Positions of slides are machine coordinates: the programmed X Y Z plus the machine's work offset. The workpiece
stands where the ideal machine would have it: what probing it on the machine has taken out must be subtracted.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mathpost.compensate.error_model import COMPONENTS, DEFAULT, Structure, names, structure
from mathpost.errors import InputError, ReachError, as_array
from mathpost.machine import Machine, TomlTable, read_toml
from mathpost.measure import csv_table, spline

MICRO = 1e-6
GREATEST = {"um": 5000, "urad": 20000}  # more than this is another unit, or no machine
MARGIN = 0.1  # mm or degrees by which a corrected joint may leave its table


@dataclass(frozen=True)
class JointTable:
    """Errors over the position of one joint: its index, and a curve for each error by index."""

    joint: int
    curves: dict


@dataclass(frozen=True)
class MachineErrors:
    """Constants and tables of all errors of a machine.

    Attributes
    ----------
    machine : mathpost.machine.Machine
    structure : mathpost.compensate.error_model.Structure
    constant : ndarray, shape (33,)
        In the order of `mathpost.compensate.error_model.names`; mm and radians.
    tables : tuple of JointTable
    drift : ndarray, shape (33,), or 0
        What has been added since the calibration, by heat for instance.
    """

    machine: Machine
    structure: Structure
    constant: np.ndarray
    tables: tuple = ()
    drift: np.ndarray | float = 0.0

    def at(self, joints):
        """Return all errors at `joints`, shape (..., 5) in mm and radians, as shape (..., 33)."""
        return self.constant + self.varying(joints)

    def varying(self, joints):
        """Return the second group alone: what tables and drift add at `joints`.

        Raises
        ------
        ReachError
            If a joint stands where its errors were not measured.
        """
        joints = as_array(joints, 5, "joints")
        errors = np.zeros((*joints.shape[:-1], len(self.constant))) + self.drift
        for each in self.tables:
            position = self._position(joints, each.joint)
            for index, fitted in each.curves.items():
                errors[..., index] += self._evaluate(each.joint, fitted, position) * _unit(index)
        return errors

    def _position(self, joints, index):
        """The joint's position as its table has it: degrees, or mm in machine coordinates."""
        return np.rad2deg(joints[..., index]) if index > 2 else joints[..., index] + self.machine.origin[index]

    def _evaluate(self, joint, fitted, position):
        if fitted.points.period is None:
            low, high = fitted.points.at[[0, -1]]
            inside = np.clip(position, low, high)
            position = np.where(np.abs(position - inside) < MARGIN, inside, position)
        try:
            return fitted(position)
        except ReachError as error:
            raise ReachError(f"{self.machine.joint_names[joint]}: {error}") from None


def constant_only(machine, errors, *, structure=DEFAULT):
    """Return `MachineErrors` with the given constants: a dict of name to mm or radians, all others 0.

    Examples
    --------
    >>> from mathpost import machine
    >>> errors = constant_only(machine.load("data/machines/ac_table.toml"), {"EXC": 0.012, "EAC": 30e-6})
    >>> errors.constant[errors.constant != 0]
    array([1.2e-02, 3.0e-05])
    """
    known = names(machine)
    for name in errors:
        if name not in known:
            raise InputError(f"error {name!r}", f"one of {', '.join(known)}", "another name")
    return MachineErrors(machine, structure, np.array([float(errors.get(name, 0)) for name in known]))


def load(path, machine):
    """Read the errors of `machine` from a TOML file.

    Parameters
    ----------
    path : str or path-like
    machine : mathpost.machine.Machine

    Returns
    -------
    MachineErrors

    Raises
    ------
    InputError
        If a file cannot be read, a key or a column is missing or unknown, an error belongs to no joint of the
        machine, or a value suggests other units than µm, µrad, mm and degrees.

    Examples
    --------
    >>> from mathpost import machine
    >>> errors = load("data/errors/ac_table.toml", machine.load("data/machines/ac_table.toml"))
    >>> [errors.machine.joint_names[each.joint] for each in errors.tables]
    ['X', 'A', 'C']
    """
    file, known = TomlTable(read_toml(path), str(path)), names(machine)
    for key in ("name", "source"):
        file.take(key, _text, "text in quotes")
    place = DEFAULT
    if "structure" in file.content:
        code = file.take("structure", _text, "text in quotes")
        place = structure(code, machine, f"{path}, key 'structure'")
    constant, values = file.table("constant", optional=True), np.zeros(len(known))
    for index, name in enumerate(known):
        unit = _unit_name(index)
        read, expected = _within(GREATEST[unit]), f"a number in {unit}, within ±{GREATEST[unit]} (other units?)"
        values[index] = constant.take(name, read, expected, 0.0) * _unit(index)
    entries = file.take("table", list, "[[table]] entries", [])
    tables = [_table(TomlTable(entry, f"{path}, table {n}"), path, machine) for n, entry in enumerate(entries, 1)]
    constant.done()
    file.done()
    return MachineErrors(machine, place, values, tuple(tables))


def _table(entry, path, machine):
    """Read one [[table]] and the CSV file that it names."""
    joints = machine.joint_names
    joint = entry.take("joint", joints.index, f"one of {', '.join(joints)}")
    file = entry.take("file", _text, "a file name in quotes")
    endless = entry.take("endless", _switch, "true or false", False)
    kind = entry.take("interpolation", ("spline", "linear").index, '"spline" or "linear"', 0)
    entry.done()
    if endless and joint < 3:
        raise InputError(f"{entry.where}, key 'endless'", "a rotary joint", joints[joint])

    known = names(machine)
    columns = [f"E{component}{joints[joint]}" for component in COMPONENTS]
    read = csv_table.read(Path(path).parent / file, ["position"], optional=columns)
    if joint > 2:
        read.check_angles("position")
    read.check_increasing("position")
    curves = {}
    for name in (column for column in columns if column in read):
        index = known.index(name)
        unit = _unit_name(index)
        read.require(name, np.abs(read[name]) <= GREATEST[unit], f"{unit} within ±{GREATEST[unit]} (other units?)")
        measured = spline.points(read["position"], read[name], period=360.0 if endless else None)
        curves[index] = spline.Polyline(measured) if kind else spline.through_all(measured)
    if not curves:
        raise InputError(read.path, f"at least one of the columns {', '.join(columns)}", "only 'position'")
    return JointTable(joint, curves)


def _unit_name(index):
    """Displacements are µm, rotations and squareness µrad; six errors to a joint, then squareness."""
    return "um" if index < 30 and index % 6 < 3 else "urad"


def _unit(index):
    """From the file's µm or µrad to mm or radians."""
    return 1e-3 if _unit_name(index) == "um" else MICRO


def _within(greatest):
    def read(value):
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= greatest:
            raise ValueError
        return float(value)

    return read


def _text(value):
    if not isinstance(value, str) or not value.strip():
        raise ValueError
    return value


def _switch(value):
    if not isinstance(value, bool):
        raise ValueError
    return value
