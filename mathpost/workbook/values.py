"""A sheet of numbers without formulas: the labels say what each cell is, and so which formula should stand there.

Each number is compared with what that formula makes of the numbers in the cells before it. So an error is told from
what follows from it; but a slip that is lucky at these numbers cannot be seen.
"""

import re
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
import sympy as sp

from mathpost.detective.misreadings import elementary, written_decimals
from mathpost.rotation import PASSIVE
from mathpost.workbook.edits import edits
from mathpost.workbook.file import Cell
from mathpost.workbook.formula import area_of
from mathpost.workbook.graph import Graph, area_named, at
from mathpost.workbook.label import UNIT_WORDS, Role, read_label
from mathpost.workbook.report import CONSEQUENCE, RIGHT, WRONG, Fault

EXACT, FULL = 1e-9, 9  # what a spreadsheet's arithmetic may lose; decimals of a number that was not rounded by hand
OPPOSITE = {"degrees for radians": "radians for degrees", "radians for degrees": "degrees for radians"}
LEVEL = {"cos": "elements", "sin": "elements", "radians": "elements", "transposed": "products"}


@dataclass(frozen=True)
class Block:
    """A role and the places of its cells: one, or nine row by row."""

    role: Role
    places: tuple

    @property
    def level(self):
        """Numbers that are rounded alike."""
        one = self.role.kind == "matrix" and len(self.role.word) == 1
        return (
            "elements"
            if one
            else "products"
            if self.role.kind == "matrix"
            else LEVEL.get(self.role.kind, self.role.kind)
        )


def check_values(graph, cells=None):
    """Judge the numbers of a workbook by its labels.

    Returns
    -------
    statuses : dict
        Place → ``"right"``, ``"wrong"`` or ``"consequence"``; empty if the labels say too little.
    faults : list of `Fault`
    seen : list of str
    """
    blocks, implied = read_labels(graph, cells)
    if not implied:
        return {}, [], []
    whole = with_formulas(graph, implied)
    seen = [f"{whole.address(b.places[0])}: {b.role}" for b in blocks]
    return *_judged(whole, blocks, implied), seen


def read_labels(graph, cells=None, *, by_numbers=True):
    """Return the blocks with a role, and place → (formula, first cell of its array) that should stand there."""
    blocks = list(_named(graph, cells)) + [b for sheet in graph.book.sheets for b in _labelled(graph, sheet)]
    blocks = _read_once(graph, blocks)
    if by_numbers:
        blocks = _by_their_numbers(graph, blocks)
    implied = {}
    for n, block in enumerate(blocks):
        later = [b for b in blocks[n + 1 :] if b.role.kind != "negated"]
        implied.update(_formulas(block, blocks[:n][::-1] + later))
    return blocks, implied


def _by_their_numbers(graph, blocks):
    """Name the matrices whose labels say no product, such as "matrix 2", by the product that their numbers are."""
    given = {b.role.word[0]: graph.value(b.places[0]) for b in blocks if b.role.kind == "angle"}
    if sorted(given) != [0, 1, 2] or None in given.values():
        return blocks
    single = [elementary("ZXZ"[n], np.deg2rad(given[n])) for n in range(3)]
    words = [(0,), (1,), (2,), (2, 1), (1, 0), (2, 1, 0)]
    known = {word: reduce(np.matmul, [single[n] for n in word]) for word in words}
    found = []
    for block in blocks:
        numbers = [graph.cells[p].number for p in block.places if p in graph.cells]
        if block.role == Role("matrix") and len(numbers) == 9:
            entries = np.array([np.nan if n is None else n for n in numbers]).reshape(3, 3)
            fit = {word: (np.abs(entries - matrix) < 1e-3).sum() for word, matrix in known.items()}
            best = max(fit, key=fit.get)
            block = Block(Role("matrix", best), block.places) if fit[best] >= 7 else block
        found.append(block)
    return found


def with_formulas(graph, implied):
    """The graph of the same workbook with the formulas that should stand there."""
    sheets = []
    for sheet in graph.book.sheets:
        cells = dict(sheet.cells)
        for place, (formula, anchor) in implied.items():
            if place[0] == sheet.name:
                old = cells.get(place[1:], Cell(None))
                cells[place[1:]] = Cell(old.value, formula, "x" * bool(anchor), old.error, anchor)
        sheets.append(replace(sheet, cells=cells))
    return Graph(replace(graph.book, sheets=tuple(sheets)))


def _judged(graph, blocks, implied):
    # A text counts as the number that it means where something is given, not where something was to be calculated.
    numbers = {p: c.number if p in implied else c.meant for p, c in graph.cells.items()}
    own = {p: np.array([number]) for p, number in numbers.items() if number is not None}
    ideal = graph.run({p: v for p, v in own.items() if p not in implied})
    half = _half_digits(graph, blocks)
    statuses, faults, slack = {}, [], dict.fromkeys(own, 0.0)
    order = sorted(implied, key=lambda p: (graph.order.index(p), graph.reading_order(p)))
    levels = {}
    for place in order:
        levels[place] = 1 + max((levels.get(s, 0) for s in graph.uses[place]), default=0)
        local = _calculated(graph, place, own)
        moved = sum(
            abs(_calculated(graph, place, {**own, s: own[s] + slack[s]}) - local)
            for s in graph.uses[place]
            if slack.get(s) and s in own
        )
        allowed = EXACT * max(1, abs(local)) + half.get(place, 0) + (moved if np.isfinite(moved) else 0)
        slack[place] = half.get(place, 0) + (moved if np.isfinite(moved) else 0)
        written = numbers.get(place)
        spoilt = any(statuses.get(s) not in (None, RIGHT) for s in graph.uses[place])
        if written is None:
            lost = not np.isfinite(local) and graph.cells[place].error
            statuses[place] = CONSEQUENCE if lost and spoilt else WRONG
        elif abs(written - float(ideal[place][0])) <= allowed + slack[place]:
            statuses[place] = RIGHT
        else:
            statuses[place] = CONSEQUENCE if abs(written - local) <= allowed and spoilt else WRONG
        if not np.isfinite(local) and written is not None and spoilt and statuses[place] == WRONG:
            statuses[place] = CONSEQUENCE
    wrong = sorted((p for p in order if statuses[p] == WRONG), key=lambda p: (levels[p], graph.reading_order(p)))
    for place in wrong:
        mates = [p for b in blocks if place in b.places for p in b.places if statuses.get(p) == WRONG]
        cause, message = _why(graph, place, mates, own, slack)
        faults.append(Fault(graph.address(place), cause, message, place))
    return statuses, faults


def _calculated(graph, place, values, tree=None):
    return float(at(graph.calculate(tree or graph.trees[place], values), graph.part.get(place, (0, 0)))[0])


def _half_digits(graph, blocks):
    """Half of the last digit written, by place, where all numbers of a kind are rounded alike."""
    digits = {}
    for block in blocks:
        for place in block.places:
            value = graph.value(place)
            if value is not None and not float(value).is_integer():
                digits.setdefault(block.level, []).append(written_decimals(value))
    found = {}
    for block in blocks:
        most = max(digits.get(block.level, [FULL]))
        if (2 if block.role.kind == "outcome" else 3) <= most < FULL:
            found.update(dict.fromkeys(block.places, 0.5 * 10.0**-most * (1 + 1e-6)))
    return {p: h for p, h in found.items() if graph.trees.get(p)}


def _why(graph, place, mates, own, slack):
    """Cause and sentence: the slip in the formula that gives what stands in all wrong cells of the block."""
    short, written = graph.short(place), graph.cells[place].number
    if written is None:
        return "wrong value", f"{short} holds {graph.cells[place].value!r} where a number belongs"
    expected = _calculated(graph, place, own)
    best = None
    for cause, _, tree in edits(graph, place, graph.trees[place]):
        value = _calculated(graph, place, own, tree)
        if abs(value - written) <= 2e-7 * max(1, abs(value)) + 2 * slack.get(place, 0):
            best = OPPOSITE.get(cause, cause), tree
            break
    if len(mates) > 1 and (whole := _whole(graph, mates, own, slack)):
        return whole, f"{short} and {len(mates) - 1} more: {whole}"
    if best:
        return best[0], f"{short} is {written:.6g}, should be {expected:.6g}: {best[0]}"
    decimals = written_decimals(written)
    if decimals < FULL and abs(written - expected) <= 10.0**-decimals:
        return "rounded early", f"{short} is rounded to {decimals} decimals"
    return "wrong value", f"{short} is {written:.6g}, should be {expected:.6g}"


def _whole(graph, mates, own, slack):
    """The one slip that explains all wrong cells of a block."""
    trees = {id(graph.trees[p]): graph.trees[p] for p in mates}
    if len(trees) == 1:
        for cause, _, tree in edits(graph, mates[0], next(iter(trees.values()))):
            if all(
                abs(_calculated(graph, p, own, tree) - graph.value(p)) <= 2e-7 + 2 * slack.get(p, 0)
                for p in mates
                if graph.value(p) is not None
            ):
                return OPPOSITE.get(cause, cause)
    if len(mates) == 2 and all(
        abs(_calculated(graph, p, own) + graph.value(p)) <= 2e-7 + 2 * slack.get(p, 0)
        for p in mates
        if graph.value(p) is not None
    ):
        return "other convention"
    return None


# From labels to formulas.


def _read_once(graph, blocks):
    """Blocks in reading order, none of whose cells belongs to an earlier one in the list."""
    taken, found = set(), []
    for block in blocks:
        if taken.isdisjoint(block.places):
            taken.update(block.places)
            found.append(block)
    return sorted(found, key=lambda b: graph.reading_order(b.places[0]))


def _named(graph, cells):
    names = {name: (sheet, first, last) for name, (sheet, first, last) in graph.book.names.items()}
    for name, text in (cells or {}).items():
        area = area_named(graph, name, text)
        names[name] = (area.sheet, (area.top, area.left), (area.bottom, area.right))
    for name, (sheet, first, last) in names.items():
        role = read_label(re.sub(r"^(?:recipe|method|m)_?[12]_", "", name.lower()))
        places = tuple((sheet, r, c) for r in range(first[0], last[0] + 1) for c in range(first[1], last[1] + 1))
        if role and role.kind in ("angles", "point", "result") and len(places) == 3:
            single = {"angles": "angle", "point": "coordinate", "result": "outcome"}[role.kind]
            yield from (Block(Role(single, (n,)), (place,)) for n, place in enumerate(places))
        elif role:
            kind = "matrix" if role.kind == "angle" and len(places) == 9 else role.kind
            if len(places) == (9 if kind in ("matrix", "transposed") else 1):
                yield Block(Role(kind, role.word), places)


def _labelled(graph, sheet):
    labels = {}
    for place, cell in sorted(sheet.cells.items()):
        role = read_label(cell.value) if isinstance(cell.value, str) and not cell.error else None
        if role:
            labels[place] = role
    taken = set()
    for place, role in labels.items():
        if role.kind in ("matrix", "transposed", "angle") and (block := _nine(graph, sheet, place, labels, taken)):
            kind = "matrix" if role.kind == "angle" else role.kind
            taken.update(block)
            yield Block(Role(kind, role.word), block)
    runs = {}
    for place, role in labels.items():
        if role.shape == ():
            runs.setdefault((role.kind, sum(r == role for r in runs.get(role.kind, []))), []).append((place, role))
            runs.setdefault(role.kind, []).append(role)
    for key, run in runs.items():
        if isinstance(key, str):
            continue
        ways = [[_next(sheet, place, step, labels) for place, _ in run] for step in ((0, 1), (1, 0))]
        free = [sum(p is not None and (sheet.name, *p) not in taken for p in way) for way in ways]
        for (_, role), place in zip(run, ways[0] if free[0] >= free[1] else ways[1], strict=True):
            if place is not None:
                yield Block(role, ((sheet.name, *place),))


def _next(sheet, place, step, labels):
    """The first cell beside a label that is neither empty nor a unit; None if that is the next label."""
    for _ in range(3):
        place = (
            (sheet.spans.get(place, place)[0] + step[0], place[1] + step[1])
            if step[0]
            else (place[0], sheet.spans.get(place, place)[1] + 1)
        )
        cell = sheet.cells.get(place)
        if cell is not None and str(cell.value).strip().lower() not in UNIT_WORDS:
            return None if place in labels else place
    return None


def _nine(graph, sheet, label, labels, taken):
    """The nine cells of the matrix that a label names: below it or to its right."""
    row, column = label
    right = sheet.spans.get(label, label)[1] + 1
    for top, left in (
        (row + 1, column),
        (row, right),
        (row + 1, column - 1),
        (row - 1, right),
        (row + 1, column - 2),
    ):
        places = tuple((sheet.name, top + r, left + c) for r in range(3) for c in range(3))
        cells = [sheet.cells.get(p[1:]) for p in places]
        good = sum(
            c is not None and (c.number is not None or c.error or bool(re.search(r"\d", str(c.value))))
            for c in cells
        )
        if (
            top > 0
            and left > 0
            and good >= 7
            and taken.isdisjoint(places)
            and not any(p[1:] in labels for p in places)
        ):
            return places
    return None


def _formulas(block, others):
    """Place → (formula, first cell of the array or ()), from the blocks before this one, the nearest first."""
    nearest = {}
    for other in others:
        nearest.setdefault(other.role, other)
    kind, word = block.role.kind, block.role.word

    def text(role):
        return _ref(nearest[role].places) if role in nearest else None

    if kind == "negated" and text(Role("angle", word)):
        return {block.places[0]: (f"=-{text(Role('angle', word))}", ())}
    angle = text(Role("negated", word)) or text(Role("angle", word))
    if kind in ("cos", "sin", "radians") and angle:
        inner = f"RADIANS({angle})"
        return {block.places[0]: (f"={inner}" if kind == "radians" else f"={kind.upper()}({inner})", ())}
    if kind == "matrix" and len(word) == 1 and angle:
        cosine = text(Role("cos", word)) or f"COS(RADIANS({angle}))"
        sine = text(Role("sin", word)) or f"SIN(RADIANS({angle}))"
        entries = [e for row in elementary_formulas("ZXZ"[word[0]], cosine, sine) for e in row]
        return {p: (e if isinstance(e, str) else f"={e}", ()) for p, e in zip(block.places, entries, strict=True)}
    formula = None
    if kind == "matrix":
        formula = _product(nearest, word or (2, 1, 0), block.role)
    if kind == "transposed":
        source = next(
            (o for o in others if o.role.kind == "matrix" and len(o.role.word) == 3 and word in ((), o.role.word)),
            None,
        )
        formula = source and f"TRANSPOSE({_ref(source.places)})"
    if formula:
        return {p: (f"={formula}", block.places[0][1:]) for p in block.places}
    if kind == "outcome":
        final = next(
            (
                o
                for o in others
                if o.role.kind == "transposed" or (o.role.kind == "matrix" and len(o.role.word) in (0, 3))
            ),
            None,
        )
        point = [text(Role("coordinate", (n,))) for n in range(3)]
        if final and all(point):
            row = final.places[3 * word[0] : 3 * word[0] + 3]
            return {
                block.places[0]: ("=" + "+".join(f"{_ref((a,))}*{x}" for a, x in zip(row, point, strict=True)), ())
            }
    return {}


def elementary_formulas(axis, cosine, sine):
    """Return the passive elementary matrix about `axis` as a nested list of numbers and formulas.

    Examples
    --------
    >>> elementary_formulas("Z", "B9", "C9")
    [['=B9', '=C9', 0], ['=-C9', '=B9', 0], [0, 0, 1]]
    """
    t, c, s = sp.symbols("t c s")
    matrix = PASSIVE[axis](t).subs({sp.cos(t): c, sp.sin(t): s})
    cells = {c: f"={cosine}", s: f"={sine}", -s: f"=-{sine}", -c: f"=-{cosine}"}
    return [
        [cells.get(entry, entry) if entry.free_symbols else int(entry) for entry in row] for row in matrix.tolist()
    ]


def _product(nearest, word, own):
    """MMULT of the matrices in `word`, taking products that stand in the sheet."""
    role = Role("matrix", word)
    if role in nearest and role != own:
        return _ref(nearest[role].places)
    for cut in range(len(word) - 1, 0, -1):
        left, right = (_product(nearest, part, own) for part in (word[:cut], word[cut:]))
        if left and right:
            return f"MMULT({left},{right})"
    return None


def _ref(places):
    area = area_of(places)
    return f"'{area.sheet}'!{area}"
