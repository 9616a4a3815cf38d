"""Pairs of workbooks, a teacher's and a student's, written from the subjects of a text file alone.

A student's sheet is a way of the subject in a layout of its own: lists down or across, on one worksheet or several,
in an order, a language and with numbers of its own; right, or with one slip. What it is worth is found by Python's
arithmetic on the names of the quantities, which knows no cells.
"""

import random
import re
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import openpyxl
from openpyxl.utils import get_column_letter
from openpyxl.worksheet.formula import ArrayFormula

NAME = re.compile(r"\{(\w+)(:\w*(?:-1)?)?(@-1)?\}")


@dataclass
class Quantity:
    kind: str  # in, col, block, step, cstep, blockstep, out, cout, blockout
    symbol: str
    labels: tuple[str, str]
    content: list  # numbers, or texts of formulas
    own: list = ()
    size: tuple[int, int] = (1, 1)

    @property
    def table(self):
        return self.kind in ("col", "cstep", "cout")

    @property
    def is_result(self):
        return self.kind.endswith("out")


@dataclass
class Subject:
    name: str
    titles: tuple[str, str]
    given: list = field(default_factory=list)
    ways: list = field(default_factory=list)


def subjects(path):
    """The subjects of a text file, by name."""
    found = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("#") or not line.strip():
            continue
        first, *fields = (part.strip() for part in line.split("|"))
        kind, *words = first.split()
        if kind == "==":
            subject = found[words[0]] = Subject(words[0], tuple(fields))
        elif kind == "way":
            subject.ways.append([])
        else:
            rows = [int(word) for word in words[1:]]
            size = tuple(rows) or (1, 1)
            is_given = not subject.ways
            if is_given:
                numbers = [[float(v) for v in re.split("[,;]", text)] for text in fields[2:]]
                quantity = Quantity(kind, words[0], tuple(fields[:2]), numbers[0], numbers[1], size)
                subject.given.append(quantity)
            else:
                formulas = [text.strip() for text in fields[2].split(";")] if kind != "out" else [fields[2]]
                kind = "blockstep" if kind == "block" else kind
                subject.ways[-1].append(Quantity(kind, words[0], tuple(fields[:2]), formulas, (), size))
    return found


# What quantities are, by Python's arithmetic.


def _index(values, row):
    return values[int(np.asarray(row).flat[0]) - 1]


SCOPE = {
    **{
        name: getattr(np, name.lower())
        for name in ("SIN", "COS", "TAN", "SQRT", "ABS", "RADIANS", "DEGREES", "EXP")
    },
    **{"ASIN": np.arcsin, "ACOS": np.arccos, "ATAN": np.arctan, "ATAN2": lambda x, y: np.arctan2(y, x)},
    **{"PI": lambda: np.pi, "SUM": np.sum, "AVERAGE": np.mean, "COUNT": np.size, "LN": np.log},
    "SUMSQ": lambda *values: sum(np.sum(np.square(v)) for v in values),
    "SUMPRODUCT": lambda *values: np.prod([np.ravel(v) for v in values], axis=0).sum(),
    "MAX": lambda a, b=None: np.max(a) if b is None else np.maximum(a, b),
    "MIN": lambda a, b=None: np.min(a) if b is None else np.minimum(a, b),
    **{"MMULT": np.matmul, "TRANSPOSE": np.transpose, "MINVERSE": np.linalg.inv},
    "MATCH": lambda key, values, kind: np.searchsorted(values, key, side="right"),
    "INDEX": _index,
    "IF": np.where,
    "ROUND": lambda value, digits: np.round(value, digits),
    "SLOPE": lambda y, x: np.polyfit(x, y, 1)[0],
    "INTERCEPT": lambda y, x: np.polyfit(x, y, 1)[1],
    "STDEV": lambda values: np.std(values, ddof=1),
}


def _python(formula, values):
    def name(match):
        symbol, whole, before = match.groups()
        if symbol not in values:  # an entry of a block, or a part of it
            block = next(s for s in values if re.fullmatch(rf"{s}\d+", symbol) and np.ndim(values[s]) == 2)
            entries = values[block]
            at = [_entry(s, block, entries) for s in (symbol, whole[1:] if whole else symbol)]
            return f"V[{block!r}][{at[0][0]}:{at[1][0] + 1},{at[0][1]}:{at[1][1] + 1}]" + "[0,0]" * (not whole)
        if before:
            return f"np.roll(V[{symbol!r}],1)"
        return f"V[{symbol!r}]" + "[:-1]" * bool(whole and whole.endswith("-1"))

    text = NAME.sub(name, formula).replace("^", "**")
    return eval(text, {"np": np, "V": values, **SCOPE})


def _entry(symbol, block, entries):
    digits = symbol[len(block) :]
    return (int(digits) - 1, 0) if entries.shape[1] == 1 else (int(digits[0]) - 1, int(digits[1]) - 1)


def results(subject, way, given, slip=None):
    """Symbol → value of the results; `slip` is (symbol, row or entry, formula)."""
    values = dict(given)
    for q in way:
        formulas = list(q.content)
        changed = slip if slip and slip[0] == q.symbol else None
        if q.size != (1, 1):
            if changed:
                formulas[changed[1] or 0] = changed[2]
            made = [_python(f, values) for f in formulas]
            values[q.symbol] = np.reshape(
                made[0] if len(made) == 1 else [float(np.ravel(m)[0]) for m in made], q.size
            )
            continue
        formula = formulas[-1].removeprefix("first: ")
        whole = changed[2] if changed and changed[1] is None else formula
        value = _python(whole, values)
        if q.table:
            rows = next(len(v) for v in values.values() if np.ndim(v) == 1)
            value = np.array(np.broadcast_to(value, rows), float)
            if len(formulas) > 1:
                value[0] = float(formulas[0].removeprefix("first: "))
            if changed and changed[1] is not None:
                value[changed[1]] = np.broadcast_to(_python(changed[2], values), rows)[changed[1]]
        values[q.symbol] = value
    return {q.symbol: np.asarray(values[q.symbol], float) for q in way if q.is_result}


def given_values(subject, own=False, shake=0.0, seed=0):
    rng, found = np.random.default_rng(seed), {}
    for q in subject.given:
        numbers = np.array(q.own if own else q.content)
        numbers = numbers + shake * rng.uniform(-1, 1, numbers.shape) * np.maximum(0.1, np.abs(numbers))
        found[q.symbol] = numbers.reshape(q.size) if q.size != (1, 1) else numbers if q.table else numbers[0]
    return found


# Slips.

CHANGES = {
    "sign": [(r"(?<=[}\d)])\+(?=[{(\dA-Z])", "-"), (r"(?<=[}\d)])-(?=[{(\dA-Z])", "+"), (r"^-", "")],
    "unit": [
        (r"RADIANS\((\{\w+\})\)", r"\1"),
        (r"\*PI\(\)/180", ""),
        (r"^DEGREES\((.*)\)$", r"\1"),
        (r"\*25\.4|25\.4\*", ""),
    ],
    "pi": [(r"PI\(\)", "3.14")],
    "factor": [(r"/2(?!\d)", ""), (r"(?<![\d^])2\*", ""), (r"\b1000\b", "100"), (r"\b60\b", "6")],
    "square": [(r"\^2", "")],
    "atan2": [(r"ATAN2\(([^,()]+(?:\([^()]*\))?),([^,()]+)\)", r"ATAN2(\2,\1)")],
    "function": [(r"\bSIN\(", "COS("), (r"\bCOS\(", "SIN("), (r"^SQRT\((.*)\)$", r"\1")],
    "division": [(r"(?<=\})/(?=\{)", "*")],
    "range": [(r"\{(\w+):\}", r"{\1:-1}")],
}


def slips(way, subject, rng):
    """Yield (cause, symbol, row or None, formula) of slips, in an order by chance."""
    known = {q.symbol: q for q in [*subject.given, *way]}
    columns = [s for s, q in known.items() if q.table]
    scalars = [s for s, q in known.items() if not q.table and q.size == (1, 1)]
    found = []
    for n, q in enumerate(way):
        for k, formula in enumerate(q.content):
            if formula.startswith("first:"):
                continue
            entry = k if q.size != (1, 1) else None
            for cause, changes in CHANGES.items():
                for pattern, new in changes:
                    for match in re.finditer(pattern, formula):
                        if cause == "range" and len(re.findall(r":\}", formula)) > 1:
                            continue
                        changed = formula[: match.start()] + match.expand(new) + formula[match.end() :]
                        found.append((cause, q.symbol, entry, changed))
            before = {p.symbol for p in [*subject.given, *way[:n]]}
            for match in re.finditer(r"\{(\w+)\}", formula):
                for pool in (scalars, columns):
                    if match[1] in pool:
                        others = [s for s in pool if s in before and s != match[1]]
                        if others:
                            other = rng.choice(others)
                            changed = f"{formula[: match.start()]}{{{other}}}{formula[match.end() :]}"
                            found.append(("reference", q.symbol, entry, changed))
                        if pool is columns and q.table:
                            changed = f"{formula[: match.start()]}{{{match[1]}@-1}}{formula[match.end() :]}"
                            found.append(("row", q.symbol, 2, changed))
            if q.size == (1, 1) and q.kind in ("step", "cstep"):
                found += [("rounded", q.symbol, None, f"ROUND({formula},{d})") for d in (1, 2)]
            if q.size == (1, 1) and "MATCH" not in formula:
                found.append(("typed", q.symbol, 3 if q.table else None, "typed"))
    rng.shuffle(found)
    seen = {}
    for slip in found:  # one of each cause first, so that the rare ones come as often
        seen.setdefault(slip[0], []).append(slip)
    order = list(seen.values())
    rng.shuffle(order)
    for n in range(max(map(len, order), default=0)):
        yield from (each[n] for each in order if n < len(each))


# Layouts.


@dataclass
class Layout:
    across: bool = False
    table_across: bool = False
    sheets: int = 1
    corner: tuple[int, int] = (1, 1)
    shuffled: bool = False
    language: int = 0
    units: bool = False  # in a column of their own
    merged: bool = False
    copies: bool = False  # the results again, at the end


def layout(rng):
    return Layout(
        rng.random() < 0.4, rng.random() < 0.35, rng.choice((1, 1, 2, 3)), (rng.randint(1, 6), rng.randint(1, 4)),
        rng.random() < 0.6, int(rng.random() < 0.3), rng.random() < 0.3, rng.random() < 0.4, rng.random() < 0.25,
    )  # fmt: skip


class Sheet:
    """A workbook in which a way of a subject is written down; `places` has the cells of each symbol."""

    def __init__(self, subject, way, form, own=False, slip=None, rng=None):
        self.form, self.rng = form, rng or random.Random(0)
        self.book, self.places = openpyxl.Workbook(), {}
        self.subject, self.slip = subject, slip
        title, calc, out = (("Data", "Calculation", "Results"), ("Daten", "Rechnung", "Ergebnisse"))[form.language]
        self.pages = [self.book.active]
        self.pages[0].title = title if form.sheets > 1 else ("Sheet1", "Tabelle1")[form.language]
        self.pages += [self.book.create_sheet(name) for name in (calc, out)[: form.sheets - 1]]
        self.next = {page.title: form.corner[0] for page in self.pages}
        page = self.pages[0]
        self.heading(page, subject.titles[form.language], 6)
        given = list(subject.given)
        if form.shuffled:
            self.rng.shuffle(given)
        self.write(page, given, ("Given", "Gegeben")[form.language], own)
        page = self.pages[min(1, len(self.pages) - 1)]
        rows = [q for q in way if q.table]
        lists = [q for q in way if not q.table]
        work = [lists, rows] if rows and lists else [way]
        for part in work:
            self.write(page, part, ("Calculation", "Rechnung")[form.language], own)
        self.fill(way)
        if form.sheets == 3 or form.copies:
            self.copy(self.pages[-1], [q for q in way if q.kind == "out"])

    def heading(self, page, text, width):
        row, column = self.next[page.title], self.form.corner[1]
        page.cell(row, column, text)
        if self.form.merged:
            page.merge_cells(start_row=row, end_row=row, start_column=column, end_column=column + width)
        self.next[page.title] += 2

    def label(self, q):
        text = q.labels[self.form.language]
        return re.sub(r"\s*\[.*?\]", "", text) if self.form.units else text

    def unit(self, q):
        found = re.search(r"\[(.*?)\]", q.labels[self.form.language])
        return found[1] if found and self.form.units else None

    def write(self, page, quantities, title, own):
        lists = [q for q in quantities if not q.table and q.size == (1, 1)]
        blocks = [q for q in quantities if q.size != (1, 1)]
        tables = [q for q in quantities if q.table]
        if quantities:
            self.heading(page, title, 4)
        row, left = self.next[page.title], self.form.corner[1]
        for n, q in enumerate(lists):
            if self.form.across:
                page.cell(row, left + n, self.label(q))
                self.put(page, q, [(row + 1, left + n)], own)
            else:
                page.cell(row + n, left, self.label(q))
                self.put(page, q, [(row + n, left + 1)], own)
                if self.unit(q):
                    page.cell(row + n, left + 2, self.unit(q))
        row += (2 if self.form.across else len(lists)) + 1 if lists else 0
        for q in blocks:
            page.cell(row, left, self.label(q))
            cells = [(row + 1 + r, left + c) for r in range(q.size[0]) for c in range(q.size[1])]
            self.put(page, q, cells, own)
            row += q.size[0] + 2
        for n, q in enumerate(tables):
            count = next(len(g.content) for g in self.subject.given if g.table)
            across = self.form.table_across
            head = (row + n, left) if across else (row, left + n)
            page.cell(*head, self.label(q))
            self.put(
                page,
                q,
                [(head[0], head[1] + k + 1) if across else (head[0] + k + 1, head[1]) for k in range(count)],
                own,
            )
        if tables:
            row += (len(tables) if self.form.table_across else count + 1) + 1
        self.next[page.title] = row

    def put(self, page, q, cells, own):
        self.places[q.symbol] = [(page.title, *cell) for cell in cells]
        if q.kind in ("in", "col", "block"):
            for cell, number in zip(cells, q.own if own else q.content, strict=True):
                page.cell(*cell, int(number) if number == int(number) else number)

    def address(self, place, page):
        text = f"{get_column_letter(place[2])}{place[1]}"
        return text if page == place[0] else f"{place[0]}!{text}"

    def excel(self, formula, page, row):
        def name(match):
            symbol, whole, before = match.groups()
            if symbol not in self.places:
                block = next(s for s in self.places if re.fullmatch(rf"{s}\d+", symbol) and len(self.places[s]) > 1)
                size = next(q.size for q in [*self.subject.given, *self.way] if q.symbol == block)
                at = [_entry(s, block, np.zeros(size)) for s in (symbol, whole[1:] if whole else symbol)]
                first, last = (self.places[block][r * size[1] + c] for r, c in at)
                return self.address(first, page) + (f":{get_column_letter(last[2])}{last[1]}" if whole else "")
            cells = self.places[symbol]
            if whole:
                last = cells[-2] if whole.endswith("-1") else cells[-1]
                return f"{self.address(cells[0], page)}:{get_column_letter(last[2])}{last[1]}"
            return self.address(cells[(row or 0) - bool(before)] if len(cells) > 1 else cells[0], page)

        return NAME.sub(name, formula)

    def fill(self, way):
        self.way = way
        for q in way:
            cells, formulas = self.places[q.symbol], list(q.content)
            page = cells[0][0]
            changed = self.slip if self.slip and self.slip[0] == q.symbol else None
            if q.size != (1, 1) and len(formulas) == 1:
                text = "=" + self.excel(changed[2] if changed else formulas[0], page, None)
                last = cells[-1]
                reference = f"{get_column_letter(cells[0][2])}{cells[0][1]}:{get_column_letter(last[2])}{last[1]}"
                self.book[page].cell(*cells[0][1:]).value = ArrayFormula(reference, text)
                continue
            for n, cell in enumerate(cells):
                formula = formulas[n] if q.size != (1, 1) else formulas[-1]
                if len(formulas) > 1 and q.table and n == 0:
                    formula = formulas[0]
                elif changed and (changed[1] is None or changed[1] == n):
                    formula = changed[2]
                if formula.startswith("first:"):
                    self.book[page].cell(*cell[1:], float(formula.removeprefix("first: ")))
                elif re.fullmatch(r"-?[\d.]+", formula):
                    self.book[page].cell(*cell[1:], float(formula))
                else:
                    text = self.excel(formula, page, n if q.table else None)
                    array = "TRANSPOSE" in formula and q.size != (1, 1)
                    at = f"{get_column_letter(cell[2])}{cell[1]}"
                    self.book[page].cell(*cell[1:]).value = ArrayFormula(at, f"={text}") if array else f"={text}"

    def copy(self, page, quantities):
        if not quantities:
            return
        self.heading(page, ("Results", "Ergebnisse")[self.form.language], 3)
        row, left = self.next[page.title], self.form.corner[1]
        for n, q in enumerate(quantities):
            page.cell(row + n, left, self.label(q))
            page.cell(row + n, left + 1, "=" + self.address(self.places[q.symbol][0], page.title))
        self.next[page.title] = row + len(quantities) + 1


@dataclass
class Pair:
    name: str
    reference: Sheet
    handed_in: Sheet
    cause: str = ""  # empty: right
    first: tuple = ()  # places of the first wrong cell, any of which may be named


def pair(subject, seed):
    """A pair by chance, always the same for one seed."""
    rng = random.Random(f"{subject.name} {seed}")
    ways = rng.choices(subject.ways, k=2)
    reference = Sheet(subject, ways[0], Layout(across=rng.random() < 0.15, table_across=rng.random() < 0.15))
    form, own = layout(rng), rng.random() < 0.35
    form.language = 0 if own else form.language
    cause, slip = "", None
    if rng.random() < 0.62:
        cause, slip = _slip(subject, ways[1], own, rng)
    sheet = Sheet(subject, ways[1], form, own, slip, rng)
    first = ()
    if slip:
        cells = sheet.places[slip[0]]
        q = next(q for q in ways[1] if q.symbol == slip[0])
        one = slip[1] if slip[1] is not None else int(len(q.content) > 1)
        first = tuple(cells) if q.size != (1, 1) and len(q.content) == 1 else (cells[one if len(cells) > 1 else 0],)
    return Pair(f"{subject.name} {seed}", reference, sheet, cause, first)


def _slip(subject, way, own, rng):
    for cause, symbol, row, formula in slips(way, subject, rng):
        here = given_values(subject, own)
        if formula == "typed":
            value = _all(subject, way, here)[symbol]
            formula = f"{float(np.ravel(value)[row or 0]):.{rng.choice((4, 6, 9))}g}"
            if float(formula) == 0 or not re.fullmatch(r"-?[\d.]+", formula):
                continue
        with np.errstate(all="ignore"):
            try:
                seen = [
                    _differs(subject, way, given_values(subject, own, shake, 3), (symbol, row, formula))
                    for shake in (0.0, 0.01)
                ]
            except (TypeError, ValueError, IndexError, StopIteration):
                continue
        if seen[1] and (seen[0] or cause == "typed"):
            return cause, (symbol, row, formula)
    raise ValueError(f"no slip in {subject.name}")


def _all(subject, way, given):
    """Symbol → value of all that is computed."""
    kinds = {q.symbol: "cout" if q.table else "out" for q in way}
    return results(subject, [replace(q, kind=kinds[q.symbol]) for q in way], given)


def _differs(subject, way, given, slip):
    right, wrong = (results(subject, way, given, each) for each in (None, slip))
    if not all(np.isfinite(v).all() for v in wrong.values()):
        return False
    return any(np.max(np.abs(right[s] - wrong[s]) / (1e-9 + np.abs(right[s]))) > 1e-4 for s in right)


def agreeing_ways(subject, own=False):
    """The largest relative difference between the ways of a subject."""
    with np.errstate(all="ignore"):
        made = [results(subject, way, given_values(subject, own, 0.01, 5)) for way in subject.ways]
    return max(np.max(np.abs(a[s] - made[0][s])) / (1 + np.max(np.abs(a[s]))) for a in made for s in a)


HERE = Path(__file__).parent
SUBJECTS = subjects(HERE / "subjects.txt")
LATER = subjects(HERE / "subjects_later.txt")  # written after the check
