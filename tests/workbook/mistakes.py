"""Every slip at every place where it can be made, and the truth about it.

A slip is a cause and the cells that it changes. Whether it is an error is decided by evaluating the sheet at random
inputs: a reference moved to a cell that is always equal is none.
"""

import re
from dataclasses import dataclass, field, replace

import numpy as np

from tests.workbook.cells import FAULT, REFERENCE, SAMPLES, Area, Array, CircularError, Values, formula_of, number

NEIGHBOURS = [(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1) if r or c]
REFERENCES = {"wrong reference", "wrong angle", "wrong point"}
# What a colleague may equally say of the same cell.
ALIKE = {
    "wrong reference": REFERENCES | {"missing $"},
    "wrong angle": REFERENCES,
    "wrong point": REFERENCES,
    "transposed": {"transposed", "other convention", "sign"},
    "other convention": {"other convention", "transposed", "sign", "wrong angle"},
    "wrong value": {"wrong value", "typed over formula", "sign", "offset"},
    "branch": {"branch", "travel"},
    "travel": {"branch", "travel", "offset", "wrong value"},
}


@dataclass
class Slip:
    """What is planted: the cause, the new contents, and where the first wrong cell may be."""

    cause: str
    changes: dict
    causes: set = field(default_factory=set)
    first: set = field(default_factory=set)
    verdict: str = (
        ""  # right, wrong, "not right" (wrong or unclear), "not silent" (or right with a warning), either
    )

    def applied(self, book):
        cells = {**book.cells, **self.changes}
        return replace(book, cells={key: content for key, content in cells.items() if content is not None})


def slips(book, key, values):
    """All slips of one formula: (cause, new content) of the cell `key`."""
    content = book.cells[key]
    formula = formula_of(content)
    for cause, text in formula_slips(book, key, formula):
        if text != formula:
            yield cause, replace(content, formula=text) if isinstance(content, Array) else text
    value = values[key]
    if not isinstance(value, str) and np.isfinite(value[0]) and not isinstance(content, Array):
        yield "typed over formula", float(value[0])
        yield "typed over formula", float(f"{value[0]:.4f}")


def formula_slips(book, key, formula):
    yield from moved_references(book, key, formula)
    yield from other_inputs(book, key, formula)
    yield from angle_units(book, key, formula)
    yield from signs(formula)
    yield from functions(formula)
    yield from missing_terms(formula)
    if "IF(" not in formula and "MAX(" not in formula:
        yield from (("rounded early", f"=ROUND({formula[1:]},{digits})") for digits in (1, 2, 3, 4))


def reference_area(match, sheet):
    prefix, _, column, _, row, _, last_column, _, last_row = match.groups()
    row, column = int(row), number(column)
    rows, columns = (int(last_row) - row + 1, number(last_column) - column + 1) if last_row else (1, 1)
    return Area(prefix[:-1].strip("'") if prefix else sheet, row, column, rows, columns)


def rewritten(formula, match, area, sheet):
    """The formula with the reference `match` to `area` instead, its $ as before."""
    fixed = "$" in match.group()
    return formula[: match.start()] + area.text(sheet, row_fixed=fixed, column_fixed=fixed) + formula[match.end() :]


def moved_references(book, key, formula):
    for match in REFERENCE.finditer(formula):
        area = reference_area(match, key[0])
        for r, c in NEIGHBOURS:
            if area.row + r > 0 and area.column + c > 0:
                moved = area._replace(row=area.row + r, column=area.column + c)
                yield "wrong reference", rewritten(formula, match, moved, key[0])


def other_inputs(book, key, formula):
    """The other angles, or the other coordinates and rows of points, for a single input."""
    groups = [keys for keys, _ in book.inputs]
    for match in REFERENCE.finditer(formula):
        area = reference_area(match, key[0])
        own = next((keys for keys in groups if area.key() in keys), None)
        if own is None or area.rows * area.columns > 1:
            continue
        # An input with no neighbours is of a group of its own.
        cause = "wrong angle" if re.search(r"RADIANS|PI\(|SIN|COS|57\.29", formula) else "wrong point"
        for other in own:
            if other != area.key():
                yield cause, rewritten(formula, match, Area(*other), key[0])
    for name in book.names:
        for other in book.names:
            yield "wrong angle", re.sub(rf"\b{name}\b", other, formula)


def angle_units(book, key, formula):
    yield "degrees for radians", re.sub(r"RADIANS\(([^()]*)\)", r"\1", formula)
    yield "degrees for radians", formula.replace("*PI()/180", "").replace("/57.29577951308232", "")
    if not re.search(r"RADIANS|PI\(|57\.29", formula):
        yield "radians for degrees", re.sub(r"\b(SIN|COS)\(([^()]*)\)", r"\1(RADIANS(\2))", formula)
        for match in re.finditer(r"\b(SIN|COS)\(([^()]*)\)", formula):
            text = f"{match[1]}(RADIANS({match[2]}))"
            yield "radians for degrees", formula[: match.start()] + text + formula[match.end() :]
    for match in re.finditer(r"RADIANS\(([^()]*)\)", formula):
        yield "degrees for radians", formula[: match.start()] + match[1] + formula[match.end() :]
    yield "radians for degrees", unwrapped(formula, "DEGREES(")
    yield "radians for degrees", formula.replace("*180/PI()", "")
    # The angle in degrees where a cell beside it has it in radians.
    for match in REFERENCE.finditer(formula):
        content = book.cells.get(reference_area(match, key[0]).key())
        if reference_area(match, key[0]).key() in book.input_cells() or not isinstance(content, str):
            continue
        if inner := re.fullmatch(r"=RADIANS\((.*)\)", content):
            yield "degrees for radians", formula[: match.start()] + inner[1] + formula[match.end() :]


def unwrapped(formula, start):
    """The formula without the first call of a function: its argument in parentheses."""
    return formula.replace(start, "(", 1)


def signs(formula):
    if re.fullmatch(r"=-[^-+]*", formula):
        yield "sign", "=" + formula[2:]
    elif re.fullmatch(r"=[^-+]*", formula) and not re.match(r"=(MMULT|TRANSPOSE|IF|MAX|MDETERM|SQRT)\(", formula):
        yield "sign", "=-" + formula[1:]
    for n, character in enumerate(formula):
        if character == "-" and n > 1:
            yield "sign", formula[:n] + ("" if formula[n - 1] in "(,*/" else "+") + formula[n + 1 :]
        elif character == "-":
            yield "sign", formula[:n] + formula[n + 1 :]
        elif character == "+":
            yield "sign", formula[:n] + "-" + formula[n + 1 :]


def functions(formula):
    exchange = {"SIN": "COS", "COS": "SIN"}
    for match in re.finditer(r"\b(SIN|COS)\(", formula):
        text = exchange[match[1]] + "("
        yield "sin and cos exchanged", formula[: match.start()] + text + formula[match.end() :]
    for match in re.finditer(r"(?:TRANSPOSE|MINVERSE)\(([^()]*)\)", formula):
        yield "transposed", formula[: match.start()] + match[1] + formula[match.end() :]
    if match := re.fullmatch(r"=MMULT\(([^,()]*|TRANSPOSE\([^()]*\)),(.*)\)", formula):
        yield "order of product", f"=MMULT({match[2]},{match[1]})"
        for k in (1, 2):
            if ":" in match[k] and "TRANSPOSE" not in match[k]:
                yield "transposed", formula[: match.start(k)] + f"TRANSPOSE({match[k]})" + formula[match.end(k) :]
    for start, arguments, end in calls(formula, "ATAN2"):
        a, b = arguments
        yield "atan2 order", formula[:start] + f"ATAN2({b},{a})" + formula[end:]
        yield "atan for atan2", formula[:start] + f"ATAN(({b})/({a}))" + formula[end:]


def calls(formula, name):
    """(start, arguments, end) of each call of a function."""
    for match in re.finditer(rf"\b{name}\(", formula):
        depth, arguments, last = 1, [], match.end()
        for n in range(match.end(), len(formula)):
            depth += {"(": 1, ")": -1}.get(formula[n], 0)
            if (depth == 1 and formula[n] == ",") or depth == 0:
                arguments.append(formula[last:n])
                last = n + 1
            if depth == 0:
                yield match.start(), arguments, last
                break


def missing_terms(formula):
    """One term of a sum left out."""
    depth, cuts = 0, [1]
    for n, character in enumerate(formula):
        depth += {"(": 1, ")": -1}.get(character, 0)
        if character in "+-" and depth == 0 and n > 1 and formula[n - 1] not in "*/(,^":
            cuts.append(n)
    if len(cuts) > 1:
        for first, last in zip(cuts, [*cuts[1:], len(formula)], strict=True):
            yield "missing term", "=" + (formula[1:first] + formula[last:]).removeprefix("+")


# Slips of several cells.


def wide_slips(book):
    """Slips that change many cells: a formula copied down without its $, a product, a convention."""
    for column in book.columns:
        yield from copied_down(book, column)
    for area, wrong in book.products:
        for cause, contents in wrong.items():
            changes = {
                key: content for key, content in zip(area.each(), contents, strict=True) if content is not None
            }
            if len(changes) > 1:
                yield cause.rstrip(" 01"), changes
    for matrix in book.turned:
        changes = {key: content for key, content in matrix.items() if content != book.cells.get(key)}
        yield "other convention", changes
        for key in matrix:
            if book.cells.get(key) in (0, 1):
                yield "wrong value", {key: 1 - book.cells[key]}
    if len(book.turned) == 3:
        together = {}
        for matrix in book.turned:
            together.update({key: content for key, content in matrix.items() if content != book.cells.get(key)})
        yield "other convention", together
    yield from nc_slips(book)


def copied_down(book, column):
    content = book.cells[column[0]]
    formula = formula_of(content)
    spans = [match.span() for match in REFERENCE.finditer(formula) if "$" in match.group()]
    for spoiled in [*({span} for span in spans), set(spans)]:
        if not spoiled:
            continue
        for first in sorted({1, len(column) // 2, len(column) - 1} - {0}):
            changes = {}
            for n in range(first, len(column)):
                above = formula_of(book.cells[column[n]])
                text = shifted(above, spoiled, n - first + 1, formula, column[0][0])
                own = book.cells[column[n]]
                changes[column[n]] = replace(own, formula=text) if isinstance(own, Array) else text
            yield "missing $", changes


def shifted(formula, spoiled, by, model, sheet):
    """The formula with the references at the places `spoiled` of the model moved down, without their $."""
    places = [match.span() in spoiled for match in REFERENCE.finditer(model)]
    parts, last = [], 0
    for match, wrong in zip(REFERENCE.finditer(formula), places, strict=True):
        if wrong:
            area = reference_area(match, sheet)
            parts += [formula[last : match.start()], area._replace(row=area.row + by).text(sheet)]
            last = match.end()
    return "".join(parts) + formula[last:]


def wrong_inputs(book):
    """An input that is not what the task gives: its last digit but one, its sign, two of them exchanged."""
    if "angles" not in book.task:
        return
    angles, point = book.inputs[0][0], book.inputs[1][0]
    for keys in (angles, point):
        for n, key in enumerate(keys):
            content, following = book.cells[key], book.cells[keys[(n + 1) % 3]]
            if isinstance(content, str):
                continue
            for changes in ({key: content + 0.7}, {key: -content}, {key: following, keys[(n + 1) % 3]: content}):
                causes = {"wrong angle", "wrong point", "wrong value", "sign"}
                yield Slip("wrong input", changes, causes, set(changes), "wrong")


def nc_slips(book):
    """An offset of a whole column, a branch that flips in one row, an angle beyond travel, a wrong value."""
    if not book.rows:
        return
    middle = book.rows[len(book.rows) // 2]
    for name, key in middle.items():
        if name in "XYZ":
            yield "offset", {row[name]: book.cells[row[name]] + "+12.5" for row in book.rows}
        yield "wrong value", {key: book.cells[key] + "+0.75"}
    tilting = next(name for name in middle if name in "AB")
    for row in (book.rows[1], middle):
        flipped = {row[tilting]: "=-(" + book.cells[row[tilting]][1:] + ")"}
        if "SQRT(2)" not in book.cells[row["C"]]:  # else C is calculated from B
            flipped[row["C"]] = book.cells[row["C"]] + "+180"
        yield "branch", flipped
    yield "travel", {middle[tilting]: book.cells[middle[tilting]] + "+360"}


# The truth.


def same(a, b):
    if a is None or b is None or isinstance(a, str) or isinstance(b, str):
        return str(a) == str(b)
    is_close = (np.abs(a - b) <= 1e-9 * (1 + np.abs(b))).all()
    return bool(is_close) or np.allclose(a, b, rtol=1e-9, atol=1e-9, equal_nan=True)  # an error is like an error


def judge(book, values, cause, changes):
    """The slip with its truth, or None if it says nothing (a number typed over a constant)."""
    slip = Slip(cause, changes)
    wrong = slip.applied(book)
    try:
        spoiled = Values(wrong, given=values.given)
        after = spoiled.all()
    except CircularError:
        slip.verdict, slip.causes = "not right", {cause}
        return slip
    before = {key: values[key] for key in after}
    different = {key for key in after if not same(before[key], after[key])}
    if not different:
        slip.verdict = "either" if blanks(book, changes) > blanks(book, dict.fromkeys(changes)) else "right"
        return None if cause == "typed over formula" else slip
    reached = {cell for key in changes for cell in spilled(book, key)}
    # First are the changed cells that are wrong even where all that they use is right.
    lone = {}
    for key, content in changes.items():
        lone |= dict(zip(spilled(book, key), at_place(values, key, content), strict=True))
    slip.first = {cell for cell in reached if not same(lone.get(cell), values[cell])} or different
    if cause == "transposed":
        slip.first |= set(book.whole)  # a matrix written down at once may as well be said to be the transposed one
    slip.first |= {key for key in changes if slip.first.intersection(spilled(book, key))}
    slip.verdict = "not right" if different <= book.extras else "wrong"
    if cause in ("branch", "travel"):
        slip.verdict = "not silent"
    slip.causes = {cause} | ALIKE.get(cause, set())
    if any(not isinstance(after[key], str) and np.isnan(after[key]).all() for key in reached):
        slip.causes.add("wrong value")  # an error such as #VALUE! may be called that
    if len(changes) == 1 and changes.keys() <= set(book.formulas()):
        (key,) = changes
        for other, content in slips(book, key, values):
            if other in slip.causes:
                continue
            pairs = zip(at_place(values, key, content), spilled(book, key), strict=True)
            if all(same(value, after[cell]) for value, cell in pairs):
                slip.causes |= {other} | ALIKE.get(other, set())
    return slip


def blanks(book, changes):
    """The number of references to cells without a number; one too many may be called wrong."""
    count = 0
    for key, content in changes.items():
        for match in REFERENCE.finditer(formula_of(content or book.cells[key]) or ""):
            cells = reference_area(match, key[0]).each()
            contents = [book.cells.get(cell) for cell in cells if cell not in Values(book).spilled]
            count += sum(
                content is None or (formula_of(content) is None and isinstance(content, str))
                for content in contents
            )
    return count


def at_place(values, key, content):
    """What `content` gives in the cell `key` and where it spills, all other cells being right."""
    if not isinstance(content, Array):
        return [values.formula(key, content)]
    result = values.run(key, content.formula)
    if getattr(result, "ndim", 0) != 3 or result.shape[:2] != (content.rows, content.columns):
        return [FAULT] * (content.rows * content.columns)
    return list(result.reshape(-1, SAMPLES))


def spilled(book, key):
    content = book.cells.get(key)
    if isinstance(content, Array):
        return Area(*key, content.rows, content.columns).each()
    return [key]


def candidates(book, values):
    """All slips that can be made in the sheet, as (cause, changes)."""
    used = {
        cell
        for key in book.formulas()
        for match in REFERENCE.finditer(formula_of(book.cells[key]))
        for cell in reference_area(match, key[0]).each()
    }
    for key in book.formulas():
        for cause, content in slips(book, key, values):
            if cause == "rounded early" and not used.intersection(spilled(book, key)):
                continue  # rounding what is shown is no slip
            if cause == "typed over formula" and key in book.extras - used:
                continue  # a number that nothing uses: nobody can tell that it was a formula
            yield cause, {key: content}
    yield from wide_slips(book)
