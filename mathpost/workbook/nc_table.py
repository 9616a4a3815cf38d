"""A table of CL records against NC words, checked row by row on any machine.

Each row holds a tool tip and axis (x y z i j k, or a cell ``GOTO/…``) and the words of the block (X Y Z and both
rotary axes, or a cell such as ``L X1.5 … B2 C3``). The rotary angles are judged by the tool axis that they make,
X Y Z by the tip; X Y Z that fit wrong angles are a consequence.
"""

import re
from dataclasses import replace
from itertools import product

import numpy as np

from mathpost import machine as machines
from mathpost.detective.misreadings import written_decimals
from mathpost.detective.rotary_axes import JointCase, explain_joints
from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.workbook.file import read
from mathpost.workbook.layout import read_area
from mathpost.workbook.old_report import CONSEQUENCE, RIGHT, WRONG, Judgement, Report

ROWS = 50_000
NUMBER = r"[-+−–]?\s*(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
COLUMN = re.compile(
    r"(?:tip|axis|tool|cl|nc|machine|刀尖|刀轴|机床)?\s*\(?([A-Za-z]\d?)\)?\s*(?:坐标|轴|axis)*\s*[(\[（]?(?:mm|deg|°|度)?[)\]）]?"
)


def check_table(path, machine, *, cells=None):
    """Check a table of CL records and NC words.

    Parameters
    ----------
    path : str or path-like
        An .xlsx workbook with one table: a row of headings (x y z i j k and the machine's X Y Z and rotary names),
        or cells with CL records and NC blocks as text.
    machine : mathpost.machine.Machine, or path of a machine file
    cells : dict, optional, keyword only
        Where the columns stand if there are no headings: ``{"tip": "A2:C6", "axis": "D2:F6", "joints": "G2:K6"}``.

    Returns
    -------
    mathpost.workbook.report.Report
        Its cells are judged row by row; the roles read ``row 40, C``.

    Raises
    ------
    InputError
        If the workbook or the machine cannot be read, no table is found, or a cell of it is not a number.

    Examples
    --------
    >>> report = check_table("data/tables/source_002_table_2.xlsx", "data/machines/dmu50v.toml")
    >>> report.first.cell, report.first.role
    ('Blade!L2', 'row 2, C')
    """
    if isinstance(machine, str) or hasattr(machine, "__fspath__"):
        machine = machines.load(machine)
    book = read(path, rows=ROWS)
    table = _Table.named(book, cells) if cells else _Table.found(book, machine.joint_names)
    kinematics = Kinematics(machine)
    judged = [_judge(kinematics, table, slice(n, n + 5000)) for n in range(0, len(table.numbers), 5000)]
    expected, status = (np.concatenate(parts) for parts in zip(*judged, strict=True))
    judgements = tuple(table.judgements(machine.joint_names, expected, status))
    kinds, why = _explain(kinematics, table, status)
    return Report(book.path, judgements, kinds, why, book.notes)


class _Table:
    """Numbers of shape (n, 11): tip, axis, joints; where each joint stands, and how many digits were written."""

    def __init__(self, book, sheet, rows, notes=()):
        if not rows:
            raise InputError(str(book.path), "rows of CL records and NC words", "none")
        self.sheet, self.notes = sheet, notes
        self.places = [[place for place, _ in row[6:]] for row in rows]
        self.numbers = np.array([[number for _, number in row] for row in rows], dtype=float)
        groups = (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 11))
        digits = [written_decimals(self.numbers[:, group]) for group in groups]
        self.half_tip, self.half_axis, self.half_linear, self.half_angle = (
            0.5 * 10.0**-d * (1 + 1e-6) if d < 9 else 1e-9 for d in digits
        )
        # Whole components such as (0, 0, 1) are meant exactly.
        self.half_axis = self.half_axis if digits[1] else 0.0

    @classmethod
    def named(cls, book, cells):
        areas = {name: read_area(book, f"cells, {name!r}", address) for name, address in cells.items()}
        if set(areas) != {"tip", "axis", "joints"}:
            raise InputError("cells", "tip, axis and joints", ", ".join(cells))
        blocks = []
        for name, columns in (("tip", 3), ("axis", 3), ("joints", 5)):
            sheet, first, last = areas[name]
            if last[1] - first[1] + 1 != columns:
                raise InputError(f"cells, {name!r}", f"{columns} columns", cells[name])
            if last[0] > ROWS:
                raise InputError(f"cells, {name!r}", f"nothing beyond row {ROWS}", cells[name])
            blocks.append([[(r, c) for c in range(first[1], last[1] + 1)] for r in range(first[0], last[0] + 1)])
        if len({len(block) for block in blocks}) > 1:
            raise InputError("cells", "as many rows for the tip, the axis and the joints", repr(cells))
        places = [[*tip, *axis, *joints] for tip, axis, joints in zip(*blocks, strict=True)]
        return cls(book, sheet, [cls.row(book, sheet, row) for row in places])

    @classmethod
    def found(cls, book, names):
        for sheet in book.sheets:
            columns = _headings(sheet, names)
            if columns:
                head, order = columns
                last = max(place[0] for place in sheet.cells)
                rows = [[(r, c) for c in order] for r in range(head + 1, last + 1)]
                filled = [row for row in rows if any(place in sheet.cells for place in row)]
                return cls(book, sheet, [cls.row(book, sheet, row) for row in filled])
            rows = list(_texts(book, sheet, names))
            if rows:
                return cls(book, sheet, rows)
        expected = f"headings x y z i j k {' '.join(names)}, or cells with GOTO/ and with NC words"
        raise InputError(str(book.path), expected, "none")

    @staticmethod
    def row(book, sheet, places):
        cells = [sheet.cells.get(place) for place in places]
        for place, cell in zip(places, cells, strict=True):
            if cell is None or cell.number is None:
                found = "nothing" if cell is None else repr(cell.value)
                raise InputError(f"{book.path}, {sheet.address(place)}", "a number", found)
        return [(place, cell.number) for place, cell in zip(places, cells, strict=True)]

    def judgements(self, names, expected, status):
        for n, places in enumerate(self.places):
            for k, place in enumerate(places):
                yield Judgement(
                    cell=self.sheet.address(place),
                    role=f"row {place[0]}, {names[k]}",
                    status=str(status[n, k]),
                    written=float(self.numbers[n, 6 + k]),
                    expected=float(expected[n, k]),
                    formula=self.sheet.cells[place].formula,
                )


def _headings(sheet, names):
    """The row of the headings and the columns of x y z i j k and the joints, or None."""
    rows = {}
    for (row, column), cell in sorted(sheet.cells.items()):
        if isinstance(cell.value, str) and (label := COLUMN.fullmatch(cell.value.strip())):
            rows.setdefault(row, []).append((column, label[1]))
    for row, labels in rows.items():
        upper = [(column, label.upper()) for column, label in labels]
        where = {name: [column for column, label in upper if label == name] for name in (*"XYZIJK", *names)}
        if all(len(where[name]) >= 2 for name in "XYZ") and all(where[name] for name in (*"IJK", *names[3:])):
            small = {label: column for column, label in labels if label in "xyz"}
            large = {label: column for column, label in labels if label in "XYZ"}
            if len(small) == len(large) == 3:
                tip, linear = [small[n] for n in "xyz"], [large[n] for n in "XYZ"]
            else:
                # The tip stands beside the tool axis, the joints beside the rotary ones.
                near_axis = abs(where["X"][0] - where["I"][0]) <= abs(where["X"][1] - where["I"][0])
                first, second = (0, 1) if near_axis else (1, 0)
                tip, linear = ([where[n][k] for n in "XYZ"] for k in (first, second))
            return row, [*tip, *(where[n][0] for n in "IJK"), *linear, *(where[n][0] for n in names[3:])]
    return None


def _texts(book, sheet, names):
    """Rows of a sheet in which one cell is a CL record and another an NC block."""
    rows = {}
    for place, cell in sorted(sheet.cells.items()):
        if isinstance(cell.value, str):
            rows.setdefault(place[0], []).append((place, cell.value))
    words = {name: re.compile(rf"(?<![A-Za-z]){name}\s*=?\s*({NUMBER})") for name in names}
    for texts in rows.values():
        record = next(((p, t) for p, t in texts if re.match(r"\s*GOTO\s*/", t, re.IGNORECASE)), None)
        block = next(((p, t) for p, t in texts if all(word.search(t) for word in words.values())), None)
        if record and block:
            numbers = [_float(text) for text in re.findall(NUMBER, record[1].split("/", 1)[1])]
            if len(numbers) != 6:
                raise InputError(
                    f"{book.path}, {sheet.address(record[0])}", "GOTO/ with six numbers", repr(record[1])
                )
            joints = [_float(words[name].search(block[1])[1]) for name in names]
            yield [(record[0], number) for number in numbers] + [(block[0], number) for number in joints]


def _float(text):
    return float(re.sub(r"\s", "", text).replace("−", "-").replace("–", "-"))


def _judge(kinematics, table, rows):
    """Expected joints and status of some rows, both of shape (n, 5)."""
    numbers = table.numbers[rows]
    tip, axis, joints = numbers[:, :3], numbers[:, 3:6], numbers[:, 6:]
    case = JointCase(kinematics, axis, joints[:, 3:], table.half_angle + 1e-9, table.half_axis)
    values, tolerance = case.both_branches(axis)
    reachable = np.isfinite(values).all(axis=(1, 2))
    off = np.abs((joints[:, None, 3:] - values + 180) % 360 - 180)
    fits = off <= tolerance
    # The branch on which more angles fit, and of two equal ones the nearer.
    score = fits.sum(axis=2) - np.where(reachable[:, None], off.max(axis=2), 0) / 1e3
    branch = np.argmax(score, axis=1)
    n = np.arange(len(numbers))
    at_pole = case.makes_the_axis()
    angle_right = (fits[n, branch] | at_pole[:, None]) & reachable[:, None]
    turns = np.round((joints[:, 3:] - values[n, branch]) / 360) * 360
    angles = np.where(angle_right, joints[:, 3:], values[n, branch] + np.nan_to_num(turns))
    allowed = table.half_linear + 3 * table.half_tip + 1e-9
    demanded = linear_for(kinematics, tip, angles)
    follows = linear_for(kinematics, tip, joints[:, 3:])
    slack = allowed + _moved_by_rounding(kinematics, tip, joints[:, 3:], table.half_angle)
    linear_right = np.abs(joints[:, :3] - demanded) <= slack
    consequence = ~angle_right.all(axis=1)[:, None] & (np.abs(joints[:, :3] - follows) <= 2 * slack)
    status = np.where(np.concatenate([linear_right, angle_right], axis=1), RIGHT, WRONG).astype("<U11")
    status[:, :3][consequence & ~linear_right] = CONSEQUENCE
    return np.concatenate([demanded, np.where(angle_right, joints[:, 3:], angles)], axis=1), status


def linear_for(kinematics, tip, angles):
    """Return the X Y Z that bring the tool tip to `tip` at any rotary angles, shape (..., 3); degrees.

    The tip in the workpiece is an affine function of X Y Z whose matrix is a rotation, so its transpose solves it.
    """
    joints = np.concatenate([np.zeros_like(tip), angles], axis=-1)
    start = kinematics.forward(np.nan_to_num(joints), degrees=True)[0]
    unit_steps = np.concatenate([np.eye(3), np.zeros((3, 2))], axis=1)
    moved = kinematics.forward(np.nan_to_num(joints)[..., None, :] + unit_steps, degrees=True)[0]
    linear = np.einsum("...kj,...j->...k", moved - start[..., None, :], tip - start)
    return np.where(np.isnan(angles).any(axis=-1, keepdims=True), np.nan, linear)


def _moved_by_rounding(kinematics, tip, angles, half):
    """How far the last digit of the angles moves X Y Z."""
    steps = [np.array(step) * half for step in product((-1, 1), repeat=2)]
    middle = linear_for(kinematics, tip, angles)
    return np.max([np.abs(linear_for(kinematics, tip, angles + step) - middle) for step in steps], axis=0)


def _explain(kinematics, table, status):
    """The kinds and the sentence for the first wrong row, of all such rows if one reading explains them."""
    wrong = status == WRONG
    if not wrong.any():
        return (), ""
    row = int(np.argmax(wrong.any(axis=1)))
    numbers, names = table.numbers[row], kinematics.machine.joint_names
    if wrong[row, 3:].any():
        rows = np.flatnonzero(wrong[:, 3:].any(axis=1))[:200]
        for chosen in (rows, [row]):
            axis = table.numbers[chosen, 3:6]
            explanation = explain_joints(
                kinematics, axis, table.numbers[chosen, 9:], decimals=_decimals(table.half_angle)
            )
            if explanation.explained:
                many = f" in all {len(rows)} such rows" if len(rows) > 1 and chosen is rows else ""
                return explanation.misreadings[0].kinds, f"{explanation.misreadings[0]}{many}"
        return ("unexplained",), f"row {table.places[row][0][0]}: {explanation.note}"
    return _explain_linear(kinematics, numbers[:3], numbers[6:], table.half_linear, names)


def _decimals(half):
    return round(-np.log10(2 * half))


def _explain_linear(kinematics, tip, joints, half, names):
    """What in the setup of the machine X Y Z leave out, or which of them was copied wrongly."""
    machine, linear, angles = kinematics.machine, joints[:3], joints[3:]
    zero = (0.0, 0.0, 0.0)
    without = [
        (("setup",), "the tool length is left out", machine.with_setup(tool_length=0.0)),
        (("setup",), "the workpiece origin is left out", machine.with_setup(origin=zero)),
        *(
            (("setup",), f"the offset of the {rotary.name} axis is left out", _without_point(machine, [rotary]))
            for rotary in machine.rotary
        ),
        (("setup",), "the offsets of both rotary axes are left out", _without_point(machine, machine.rotary)),
        *(
            (
                ("setup",),
                f"X Y Z are those of the {said}, not of the {machine.programmed_point}",
                replace(machine, programmed_point=said),
            )
            for said in ("tip", "nose")
            if said != machine.programmed_point
        ),
    ]
    tolerance = 0.01 + 2 * half
    for signs in ((-1, 1), (1, -1), (-1, -1)):
        if np.abs(linear_for(kinematics, tip, angles * signs) - linear).max() <= tolerance:
            turned = [name for name, sign in zip(names[3:], signs, strict=True) if sign < 0]
            return ("sign",), f"X Y Z are turned with the opposite sign of {' and '.join(turned)}"
    if np.abs(tip - linear).max() <= tolerance:
        return ("not turned",), "X Y Z are the tip itself, not turned"
    for kinds, why, other in without:
        if other != machine and np.abs(linear_for(Kinematics(other), tip, angles) - linear).max() <= tolerance:
            return kinds, why
    demanded = linear_for(kinematics, tip, angles)
    off = np.flatnonzero(np.abs(demanded - linear) > tolerance)
    listed = ", ".join(names[n] for n in off)
    if len(off) == 1 and abs(demanded[off[0]] + linear[off[0]]) <= tolerance:
        return ("sign",), f"the sign of {listed} is reversed"
    return (
        "number",
    ), f"{listed} is not what the tip and the angles demand" if listed else "X Y Z are rounded too coarsely"


def _without_point(machine, rotary):
    moved = tuple(replace(r, point=(0.0, 0.0, 0.0)) if r in rotary else r for r in machine.rotary)
    return replace(machine, rotary=moved)
