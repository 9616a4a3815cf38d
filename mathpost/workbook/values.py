"""A sheet of numbers without formulas: the labels say what each cell is, and so which formula should stand there.

Each number is compared with what that formula makes of the numbers in the cells before it. So an error is told from
what follows from it; but a slip that is lucky at these numbers cannot be seen.
"""

import re
from dataclasses import replace
from functools import reduce
from itertools import chain
from typing import NamedTuple

import numpy as np
import sympy as sp

from mathpost.detective.misreadings import elementary, written_decimals
from mathpost.rotation import PASSIVE
from mathpost.workbook.edits import edits
from mathpost.workbook.file import Cell
from mathpost.workbook.formula import Area, area_of
from mathpost.workbook.graph import Graph
from mathpost.workbook.label import SINGLE, UNIT_WORDS, VECTORS, Role, read_label
from mathpost.workbook.report import CONSEQUENCE, RIGHT, WRONG, Fault

EXACT, FULL = 1e-9, 9  # what a spreadsheet's arithmetic may lose; decimals of a number that was not rounded by hand
OPPOSITE = {"degrees for radians": "radians for degrees", "radians for degrees": "degrees for radians"}
MATRICES = {"matrix", "transposed"}
WORDS = ((0,), (1,), (2,), (2, 1), (1, 0), (2, 1, 0))  # the matrices of source 000's first method


class Block(NamedTuple):
    """A role and the places of its cells: one, or nine row by row."""

    role: Role
    places: tuple

    @property
    def level(self):
        """Numbers that are rounded alike."""
        element = self.role.kind in ("cos", "sin", "radians") or (
            self.role.kind == "matrix" and len(self.role.word) == 1
        )
        return "elements" if element else self.role.kind.replace("transposed", "matrix")


def check_values(graph, cells=None):
    """Judge numbers by their labels: place → status, empty if these say too little; the faults; what was seen."""
    blocks, implied = read_labels(graph, cells)
    if not implied:
        return {}, [], []
    whole = with_formulas(graph, implied)
    return *_judged(whole, blocks, implied), [f"{whole.address(b.places[0])}: {b.role}" for b in blocks]


def read_labels(graph, cells=None, *, by_numbers=True):
    """Return the blocks with a role, and place → (formula, first cell of its array) that should stand there."""
    blocks, taken = [], set()
    for block in (*_named(graph, cells), *(b for sheet in graph.book.sheets for b in _labelled(sheet))):
        if taken.isdisjoint(block.places):
            taken.update(block.places)
            blocks.append(block)
    blocks.sort(key=lambda b: graph.reading_order(b.places[0]))
    blocks, implied = _by_their_numbers(graph, blocks) if by_numbers else blocks, {}
    for n, block in enumerate(blocks):
        later = [b for b in blocks[n + 1 :] if b.role.kind != "negated"]
        implied.update(_formulas(block, blocks[:n][::-1] + later))
    return blocks, implied


def _by_their_numbers(graph, blocks):
    """Name the matrices whose labels say no product, such as "matrix 2", by the product that their numbers are."""
    given = {b.role.word[0]: graph.value(b.places[0]) for b in blocks if b.role.kind == "angle"}
    if sorted(given) != [0, 1, 2] or None in given.values():
        return blocks
    single, named = [elementary("ZXZ"[n], np.deg2rad(given[n])) for n in range(3)], []
    for block in blocks:
        numbers = np.array([graph.value(p) for p in block.places], dtype=float)
        if block.role == Role("matrix") and np.isfinite(numbers).all():
            known = [reduce(np.matmul, [single[k] for k in word]).ravel() for word in WORDS]
            fits = [(np.abs(numbers - matrix) < 1e-3).sum() for matrix in known]
            block = Block(Role("matrix", WORDS[np.argmax(fits)]), block.places) if max(fits) >= 7 else block
        named.append(block)
    return named


def with_formulas(graph, implied):
    """The graph of the same workbook with the formulas that should stand there."""
    cells = {sheet.name: dict(sheet.cells) for sheet in graph.book.sheets}
    for (sheet, *place), (formula, anchor) in implied.items():
        old = cells[sheet].get(tuple(place), Cell(None))
        cells[sheet][tuple(place)] = Cell(old.value, formula, old.error, anchor)
    sheets = tuple(replace(sheet, cells=cells[sheet.name]) for sheet in graph.book.sheets)
    return Graph(replace(graph.book, sheets=sheets))


def _judged(graph, blocks, implied):
    # A text counts as the number that it means where something is given, not where something was to be calculated.
    numbers = {p: c.number if p in implied else c.meant for p, c in graph.cells.items()}
    own = {p: np.array([number]) for p, number in numbers.items() if number is not None}
    ideal, half = graph.run({p: v for p, v in own.items() if p not in implied}), _half_digits(graph, blocks)
    statuses, faults, slack = {}, [], {}
    for place in sorted(implied, key=graph.calculation_order):
        local, sources = _calculated(graph, place, own), [s for s in graph.uses[place] if s in own]
        moved = [_calculated(graph, place, {**own, s: own[s] + slack[s]}) - local for s in sources if slack.get(s)]
        slack[place] = half.get(place, 0) + (sum(map(abs, moved)) if np.isfinite(moved).all() else 0)
        allowed, written = EXACT * max(1, abs(local)) + slack[place], numbers.get(place)
        spoilt = any(statuses.get(s, RIGHT) != RIGHT for s in graph.uses[place])
        lost = graph.cells[place].error if written is None else not np.isfinite(local)
        if written is not None and abs(written - float(ideal[place][0])) <= allowed + slack[place]:
            statuses[place] = RIGHT
        else:
            follows = written is not None and abs(written - local) <= allowed
            follows |= bool(lost) and not np.isfinite(local)
            statuses[place] = CONSEQUENCE if spoilt and follows else WRONG
    wrong = [p for p, status in statuses.items() if status == WRONG]
    for place in wrong:
        mates = [p for b in blocks if place in b.places for p in b.places if p in wrong]
        faults.append(Fault(graph.address(place), *_why(graph, place, mates, own, slack), place))
    return statuses, faults


def _calculated(graph, place, values, tree=None):
    return float(graph.cell(place, values, tree)[0])


def _half_digits(graph, blocks):
    """Half of the last digit written, by place, where all numbers of a kind are rounded alike."""
    digits, found = {}, {}
    for block in blocks:
        numbers = [n for n in map(graph.value, block.places) if n is not None and n % 1]
        digits[block.level] = max([digits.get(block.level, 0), *map(written_decimals, numbers)])
    for block in blocks:
        most = digits[block.level] or FULL
        if (2 if block.role.kind == "outcome" else 3) <= most < FULL:
            found |= {p: 0.5 * 10.0**-most * (1 + 1e-6) for p in block.places if p in graph.trees}
    return found


def _why(graph, place, mates, own, slack):
    """Cause and sentence: the slip in the formula that gives what stands there, in all wrong cells of an array."""
    short, written = graph.short(place), graph.cells[place].number
    if written is None:
        return "wrong value", f"{short} holds {graph.cells[place].value!r} where a number belongs"
    expected = _calculated(graph, place, own)
    known = [p for p in mates if graph.value(p) is not None]
    array = [p for p in known if graph.trees[p] is graph.trees[place]]

    def is_written(p, value):
        return abs(value - graph.value(p)) <= 2e-7 * max(1, abs(value)) + 2 * slack.get(p, 0)

    if len(mates) == 2 and all(is_written(p, -_calculated(graph, p, own)) for p in known):
        return "other convention", f"{short} and 1 more: other convention"
    for group in (array, [place]) if len(array) > 1 else ([place],):
        for cause, _, tree in edits(graph, place):
            if all(is_written(p, _calculated(graph, p, own, tree)) for p in group):
                cause = OPPOSITE.get(cause, cause)
                return cause, f"{short} is {written:.6g}, should be {expected:.6g}: {cause}"
    decimals = written_decimals(written)
    if decimals < FULL and abs(written - expected) <= 10.0**-decimals:
        return "rounded early", f"{short} is rounded to {decimals} decimals"
    return "wrong value", f"{short} is {written:.6g}, should be {expected:.6g}"


# From labels to roles.


def _named(graph, cells):
    names = {n: area_of([(s, *first), (s, *last)]) for n, (s, first, last) in graph.book.names.items()}
    for name, area in (names | {name: graph.named(name, text) for name, text in (cells or {}).items()}).items():
        role, places = read_label(re.sub(r"^(?:recipe|method|m)_?[12]_", "", name.lower())), tuple(area.places)
        if role and role.kind in VECTORS and not role.word and len(places) == 3:
            yield from (Block(Role(role.kind, (n,)), (place,)) for n, place in enumerate(places))
        elif role and len(places) == 9 and role.kind in (*MATRICES, "angle"):
            yield Block(Role(role.kind.replace("angle", "matrix"), role.word), places)
        elif role and len(places) == 1 and role.kind in SINGLE and role.word:
            yield Block(role, places)


def _labelled(sheet):
    """What stands beside the labels of a sheet: the nine cells of a matrix, or one cell."""
    texts = {p: c.value for p, c in sorted(sheet.cells.items()) if isinstance(c.value, str) and not c.error}
    labels, taken, runs = {place: role for place, text in texts.items() if (role := read_label(text))}, set(), {}
    for place, role in labels.items():
        if role.kind in (*MATRICES, "angle") and (nine := _nine(sheet, place, labels, taken)):
            taken.update(nine)
            yield Block(Role(role.kind.replace("angle", "matrix"), role.word), nine)
    for place, role in labels.items():
        if role.kind in SINGLE and role.word:
            before = sum(r == role for run in runs.values() for _, r in run)
            runs.setdefault((role.kind, before), []).append((place, role))
    for run in runs.values():  # all to the right of their labels, or all below
        ways = [[_next(sheet, place, down, labels) for place, _ in run] for down in (False, True)]
        right, down = (sum(p is not None and p not in taken for p in way) for way in ways)
        yield from (Block(r, (p,)) for (_, r), p in zip(run, ways[right < down], strict=True) if p is not None)


def _next(sheet, place, down, labels):
    """The first cell beside a label that is neither empty nor a unit; None if that is the next label."""
    for _ in range(3):
        last = sheet.spans.get(place, place)
        place = (last[0] + 1, place[1]) if down else (place[0], last[1] + 1)
        cell = sheet.cells.get(place)
        if cell is not None and str(cell.value).strip().lower() not in UNIT_WORDS:
            return None if place in labels else (sheet.name, *place)
    return None


def _nine(sheet, label, labels, taken):
    """The nine cells of the matrix that a label names: below it or to its right."""
    (row, column), right = label, sheet.spans.get(label, label)[1] + 1
    corners = (row + 1, column), (row, right), (row + 1, column - 1), (row - 1, right), (row + 1, column - 2)
    for top, left in (corner for corner in corners if min(corner) > 0):
        places = tuple(Area(sheet.name, top, left, top + 2, left + 2).places)
        cells = [cell for p in places if (cell := sheet.cells.get(p[1:]))]
        good = sum(cell.error or bool(re.search(r"\d", str(cell.value))) for cell in cells)
        if good >= 7 and taken.isdisjoint(places) and not any(p[1:] in labels for p in places):
            return places
    return None


# From roles to formulas.


def _formulas(block, others):
    """Place → (formula, first cell of the array or ()), from the blocks before this one, the nearest first."""
    refs, formula = {}, None
    for other in others:
        refs.setdefault(other.role, _ref(other.places))
    kind, word = block.role.kind, block.role.word
    angle = refs.get(Role("negated", word)) or refs.get(Role("angle", word))
    whole = [o for o in others if o.role.kind == "matrix" and len(o.role.word) in (0, 3)]
    if kind == "matrix" and len(word) == 1 and angle:
        parts = [refs.get(Role(name, word)) or f"{name.upper()}(RADIANS({angle}))" for name in ("cos", "sin")]
        entries = chain(*elementary_formulas("ZXZ"[word[0]], *parts))
        return {p: (e if isinstance(e, str) else f"={e}", ()) for p, e in zip(block.places, entries, strict=True)}
    if kind == "matrix":
        formula = _product(refs, word or (2, 1, 0), block.role)
    elif kind == "transposed":
        source = [o for o in whole if o.role.word and word in ((), o.role.word)]
        formula = f"TRANSPOSE({_ref(source[0].places)})" if source else None
    elif kind == "negated" and Role("angle", word) in refs:
        formula = f"-{refs[Role('angle', word)]}"
    elif kind in ("cos", "sin", "radians") and angle:
        formula = f"{kind.upper().replace('RADIANS', '')}(RADIANS({angle}))"
    elif kind == "outcome":
        final = [o for o in others if o in whole or o.role.kind == "transposed"]
        point = [refs.get(Role("coordinate", (n,))) for n in range(3)]
        row = [_ref((p,)) for o in final[:1] for p in o.places[3 * word[0] : 3 * word[0] + 3]]
        formula = "+".join(f"{a}*{x}" for a, x in zip(row, point, strict=False)) if all(point) else None
    places = block.places if formula else ()
    return {p: (f"={formula}", block.places[0][1:] if len(places) > 1 else ()) for p in places}


def elementary_formulas(axis, cosine, sine):
    """Return the passive elementary matrix about `axis` as a nested list of numbers and formulas.

    Examples
    --------
    >>> elementary_formulas("Z", "B9", "C9")
    [['=B9', '=C9', 0], ['=-C9', '=B9', 0], [0, 0, 1]]
    """
    t, c, s = sp.symbols("t c s")
    matrix = PASSIVE[axis](t).subs({sp.cos(t): c, sp.sin(t): s}).tolist()
    cells = {c: f"={cosine}", s: f"={sine}", -s: f"=-{sine}"}
    return [[cells[entry] if entry.free_symbols else int(entry) for entry in row] for row in matrix]


def _product(refs, word, own):
    """MMULT of the matrices in `word`, taking products that stand in the sheet."""
    role = Role("matrix", word)
    if role in refs and role != own:
        return refs[role]
    for cut in range(len(word) - 1, 0, -1):
        left, right = (_product(refs, part, own) for part in (word[:cut], word[cut:]))
        if left and right:
            return f"MMULT({left},{right})"
    return None


def _ref(places):
    area = area_of(places)
    return f"'{area.sheet}'!{area}"
