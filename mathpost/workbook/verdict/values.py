"""A sheet of numbers without formulas: the labels say what each cell is, and so which formula should stand there.

Each number is compared with what that formula makes of the numbers in the cells before it. So an error is told from
what follows from it; but a slip that is lucky at these numbers cannot be seen.
"""

import re
from functools import reduce
from itertools import chain, count, product
from typing import NamedTuple

import numpy as np
import sympy as sp

from mathpost.detective.misreadings import elementary, written_decimals
from mathpost.rotation import PASSIVE
from mathpost.workbook.meaning.given import may_turn
from mathpost.workbook.meaning.label import SINGLE, UNIT_WORDS, Role, read_label
from mathpost.workbook.meaning.texts import ORIGIN
from mathpost.workbook.report import CONSEQUENCE, RIGHT, UNCLEAR, WRONG, Fault
from mathpost.workbook.sheet.edits import edits
from mathpost.workbook.sheet.formula import Area, area_of
from mathpost.workbook.sheet.graph import Graph
from mathpost.workbook.verdict.threes import Operator, Threes, common_decimals, words

CALCULATED = 3  # decimals that nobody gives
BELOW = 2_000_000  # the first row of matrices that are not in the sheet
EXACT, FULL = 1e-9, 9  # what a spreadsheet's arithmetic may lose; decimals of a number that was not rounded by hand
OPPOSITE = {"degrees for radians": "radians for degrees", "radians for degrees": "degrees for radians"}
GIVEN = ("angle", "coordinate", "outcome")  # what may stand in a row for each of many points
MATRICES = {"matrix", "transposed"}
WORDS = ((0,), (1,), (2,), (2, 1), (1, 0), (2, 1, 0))  # the matrices of source 000's first method


class Block(NamedTuple):
    """A role and the places of its cells: one, or nine row by row."""

    role: Role
    places: tuple


def check_values(graph, found):
    """Judge numbers by labels, and by what becomes of what: place → status, empty if these say too little; the
    faults; what was seen. `found` is the `Recognised` workbook.
    """
    blocks, implied = _by_rows(graph, found)
    if not implied:
        blocks, implied = read_labels(graph, found.task.cells)
        if (found.sequence, found.active) != ("ZXZ", False):  # the labels of matrices are those of source 000
            blocks, implied = [block for block in blocks if block.role.kind == "angle"], {}
        more, told = _by_threes(graph, found, blocks, implied)
        blocks, implied = blocks + more, told | implied
    if not implied:
        return {}, [], []
    whole = Graph(graph.book, implied)
    statuses, faults = _judged(whole, blocks, implied)
    statuses |= dict(_beside(graph, blocks, implied))
    return statuses, faults, [f"{whole.address(b.places[0])}: {b.role}" for b in blocks]


def read_labels(graph, cells=None, *, by_numbers=True):
    """Return the blocks with a role, and place → (formula, first cell of its array) that should stand there."""
    blocks, taken = [], set()
    for block in (*_named(graph, cells), *_labelled(graph.cells)):
        if taken.isdisjoint(block.places):
            taken.update(block.places)
            blocks.append(block)
    blocks += _rows_below(graph, blocks) if by_numbers else ()
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
    single = [elementary("ZXZ"[n], np.deg2rad(given[n])) for n in range(3)]
    known, named = {word: reduce(np.matmul, [single[k] for k in word]).ravel() for word in WORDS}, []
    for role, places in blocks:
        numbers = np.array([graph.value(p) for p in places], dtype=float)
        if role == Role("matrix"):
            fits = {word: (np.abs(numbers - matrix) < 1e-3).sum() for word, matrix in known.items()}
            best = max(fits, key=fits.get)
            role = Role("matrix", best) if fits[best] >= 7 else role
        named.append(Block(role, places))
    return named


def _rows_below(graph, blocks):
    """Yield the blocks of further points, below one of which x y z and x' y' z' stand in a row."""
    rows = {}
    for block in blocks:
        if block.role.kind in ("coordinate", "outcome"):
            rows.setdefault(block.places[0][:2], {})[block.role] = block.places[0]
    taken = {p for block in blocks for p in block.places}
    for row in rows.values():
        for down in count(1) if len(row) == 6 else ():
            below = [Block(role, ((p[0], p[1] + down, p[2]),)) for role, p in row.items()]
            if sum(graph.value(b.places[0]) is not None for b in below) < 4 or taken & {b.places[0] for b in below}:
                break
            yield from below


def _by_rows(graph, found):
    """Blocks and formulas of a table of which each row has angles, a point and what became of it."""
    blocks, implied, ways = [], {}, (Threes(graph, found, (), exchanged) for exchanged in (False, True))
    links = next(filter(None, (threes.link_rows() for threes in ways if threes.threes)), ())
    for n, (angles, radians, point, result) in enumerate(links):
        *_, whole = _out_of_sight(graph, found, angles, radians, n, implied).values()
        blocks += [Block(Role("angle", (k,)), (p,)) for k, p in enumerate(angles)]
        _add_link(point, result, Operator(np.eye(3), whole), blocks, implied)
    return blocks, implied


def _by_threes(graph, found, blocks, implied, exchanged=False):
    """Further blocks and formulas, of points and what became of them, that only the numbers tell.

    What is right only if coordinates stand under each other's headings is told, too, and judged by the headings.
    """
    taken = {p for role, places in blocks if role.kind not in GIVEN for p in places}
    threes, told, more, hidden = Threes(graph, found, taken, exchanged), {}, [], {}
    if len(threes.threes) < 2:
        return [], {}
    named = {role.word: places[0] for role, places in blocks[::-1] if role.kind == "angle"}
    named = tuple(named[n,] for n in range(3)) if len(named) == 3 else None
    if angles := (named and threes.angles(named)) or threes.angles():
        cells, radians = angles
        known = threes.products(threes.look(cells) * radians)
        hidden = _out_of_sight(graph, found, cells, radians, 0, told)
        hidden = {word: Operator(known[word], places) for word, places in hidden.items()}
        more += [Block(Role("angle", (k,)), (p,)) for k, p in enumerate(cells)]
        matrices = [Block(Role("matrix", word), places) for word, places in threes.matrices(known)]
        more += matrices
        for role, places in (*blocks, *matrices):
            if role.kind == "matrix" and role.word in hidden and implied.keys().isdisjoint(places):
                told |= {p: (f"={_ref((q,))}", ()) for p, q in zip(places, hidden[role.word].places, strict=True)}
    shown = [b for b in (*blocks, *more) if b.role.kind in MATRICES]
    shown = [b for b in shown if b.role.kind == "matrix" or len(b.role.word) in (0, 3)]
    shown = [b for b in shown if np.isfinite(n := threes.look(b.places)).all() and may_turn(n)]
    operators = [Operator(n.reshape(3, 3), p, (), _half(n)) for _, p in shown for n in [threes.look(p)]]
    operators += hidden.values()
    origins = [t.places for t in threes.threes if _is_origin(found, threes.look(t.places), t.places[0])]
    operators += [op._replace(origin=origin) for op, origin in product(operators, origins)]
    operators += [Operator(np.eye(3), (), origin) for origin in origins]
    done = (
        told.keys()
        | {p for role, places in (*blocks, *more) if role.kind == "angle" for p in places}
        | implied.keys()
    )
    threes.link(operators, done)
    if not threes.links and angles:  # all turned the other way, which the right matrix in the sheet does not say
        right = [*known.values()][-1]
        whole = [op for op in operators[: len(shown)] if np.allclose(op.matrix, right, atol=1e-3)]
        done |= {p for role, places in blocks if role.kind == "coordinate" for p in places}
        threes.link([op._replace(matrix=op.matrix.T) for op in whole], done)
    if not (threes.links or exchanged):
        return _by_threes(graph, found, blocks, implied, exchanged=True)
    for point, result, operator in threes.links:
        if not exchanged or all(map(found.coordinate, (*point, *result))):
            _add_link(point, result, operator, more, told)
    return more, told


def _add_link(point, result, operator, blocks, implied):
    """Add the blocks of a point and what became of it, and the formulas that make it so."""
    x = [f"({_ref((p,))}-{_ref((o,))})" for p, o in zip(point, operator.origin, strict=False)]
    x = x or [_ref((p,)) for p in point]
    after = "outcome" if operator.places else "coordinate"
    for n in range(3):
        row = operator.places[3 * n : 3 * n + 3]
        terms = [f"{_ref((a,))}*{each}" for a, each in zip(row, x, strict=True)] if row else [x[n]]
        implied[result[n]] = f"={'+'.join(terms)}", ()
        blocks += [Block(Role("coordinate", (n,)), (point[n],)), Block(Role(after, (n,)), (result[n],))]


def _half(numbers):
    """Half of the last digit of a matrix; 0 of one of zeros and ones."""
    return 0.5 * 10.0 ** -written_decimals(numbers) * bool((numbers % 1).any())


def _is_origin(found, numbers, place):
    """Whether three numbers are the origin: the task's, or one that a label names."""
    asked = found.task.origin is not None and np.allclose(numbers, found.task.origin, atol=1e-9)
    return asked or bool(re.search(ORIGIN, found.label(place), re.I))


def _out_of_sight(graph, found, cells, radians, number, told):
    """Word → places, below the sheet, of the products of elementary matrices of three angles; `told` → formulas."""
    places = {}
    for k, word in enumerate(words(found)):
        top, left = BELOW + 3 * number, 3 * k + 1
        places[word] = tuple(Area(graph.book.sheets[0], top, left, top + 2, left + 2).places)
        if len(word) == 1:
            angle = _ref((cells[word[0]],))
            angle = f"RADIANS({angle})" if radians < 1 else angle
            sine = f"(-SIN({angle}))" if found.active else f"SIN({angle})"
            entries = chain(*elementary_formulas(found.sequence.upper()[word[0]], f"COS({angle})", sine))
            told |= {p: (entry, ()) for p, entry in zip(places[word], entries, strict=True)}
        else:
            product_of = f"=MMULT({_ref(places[word[:1]])},{_ref(places[word[1:]])})"
            told |= dict.fromkeys(places[word], (product_of, (top, left)))
    return places


def _beside(graph, blocks, implied):
    """Yield place and status of other numbers that look calculated: right if the angles and points give them."""
    given = {b.role: graph.value(b.places[0]) for b in blocks if b.role.kind in ("angle", "coordinate")}
    angles = [given.get(Role("angle", (n,))) for n in range(3)]
    known = np.zeros(1)
    if None not in angles:
        radians = np.deg2rad(np.array(angles, dtype=float))
        single = [elementary("ZXZ"[n], radians[n]) for n in range(3)]
        matrices = [reduce(np.matmul, [single[k] for k in word]) for word in WORDS]
        points = [b.places for b in blocks if b.role.kind == "coordinate"]
        points = [[graph.value(p) for (p,) in points[n : n + 3]] for n in range(0, len(points) - 2, 3)]
        is_result = any(b.role.kind == "outcome" for b in blocks)  # else who knows where it is
        points = points if is_result else []
        vectors = [matrix @ np.array(point, dtype=float) for matrix, point in product(matrices, points)]
        known = np.concatenate([radians, np.cos(radians), np.sin(radians), *map(np.ravel, matrices), *vectors])
    rest = graph.component.keys() - {p for b in blocks if b.role.kind in ("angle", "coordinate") for p in b.places}
    rest -= implied.keys()
    for place in rest:
        numbers = [graph.value(p) or 0.0 for p in graph.component[place] if p in rest]
        digits = written_decimals(numbers)
        if digits >= CALCULATED:
            off = np.abs(known - (np.nan if graph.value(place) is None else graph.value(place))).min()
            yield place, RIGHT if off <= 0.6 * 10.0**-digits + EXACT else UNCLEAR


def _judged(graph, blocks, implied):
    # A text counts as the number that it means where something is given, not where something was to be calculated.
    numbers = {p: c.number if p in implied else c.meant for p, c in graph.cells.items()}
    own = {p: np.array([number]) for p, number in numbers.items() if number is not None}
    ideal, half = graph.run({p: v for p, v in own.items() if p not in implied}), _half_digits(graph, blocks)
    own |= {p: ideal[p] for p in implied if p not in graph.book.cells}
    statuses, faults, slack = {}, [], {}
    for place in sorted(implied.keys() & graph.book.cells.keys(), key=graph.calculation_order):
        local, sources = _calculated(graph, place, own), [s for s in graph.uses[place] if s in own]
        moved = [_calculated(graph, place, {**own, s: own[s] + slack[s]}) - local for s in sources if slack.get(s)]
        slack[place] = half.get(place, 0) + (sum(map(abs, moved)) if np.isfinite(moved).all() else 0)
        allowed, written = EXACT * max(1, abs(local)) + slack[place], numbers.get(place)
        spoilt = any(statuses.get(s, RIGHT) != RIGHT for s in graph.uses[place])
        lost = graph.cells[place].error if written is None else not np.isfinite(local)
        right = float(ideal[place][0])
        low, high = sorted((local, right)) if not spoilt else (right - slack[place], right + slack[place])
        least = EXACT * max(1, abs(local)) + half.get(place, 0)  # of what was rounded before, or of what was not
        if written is not None and low - least <= written <= high + least and high - low <= 2 * allowed:
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
    alike, found = {}, {}
    for role, places in blocks:
        kind = role.kind.replace("transposed", "matrix"), len(role.word) == 1
        alike.setdefault(kind, {}).update((p, n) for p in places if (n := graph.value(p)) is not None)
        found |= {p: kind for p in places if p in graph.trees}
    digits = {kind: common_decimals(numbers.values()) for kind, numbers in alike.items()}
    for place, kind in found.items():
        exact = not (2 if kind[0] == "outcome" else 3) <= digits[kind] < FULL
        found[place] = 0 if exact else 0.5 * 10.0 ** -digits[kind] * (1 + 1e-6)
    return found


def _why(graph, place, mates, own, slack):
    """Cause and sentence: the slip in the formula that gives what stands there, in all wrong cells of an array."""
    short, written = graph.short(place), graph.cells[place].number
    if written is None:
        return "wrong value", f"{short} holds {graph.cells[place].value!r} where a number belongs"
    known = [p for p in mates if graph.value(p) is not None]
    array, expected = [p for p in known if graph.trees[p] is graph.trees[place]], _calculated(graph, place, own)

    def fits(places, tree=None):
        values = [_calculated(graph, p, own, tree or ("minus", graph.trees[p])) for p in places]
        allowed = [2e-7 * max(1, abs(value)) + 2 * slack.get(p, 0) for p, value in zip(places, values, strict=True)]
        return all(abs(v - graph.value(p)) <= a for p, v, a in zip(places, values, allowed, strict=True))

    both = ["other convention"] if len(mates) == 2 and fits(known) else []
    tried = product((array, [place]), edits(graph, place))
    causes = (OPPOSITE.get(cause, cause) for group, (cause, *_, tree) in tried if fits(group, tree))
    cause = next(chain(both, causes), "wrong value")
    decimals = written_decimals(written)
    if cause == "wrong value" and decimals < FULL and abs(written - expected) <= 10.0**-decimals:
        return "rounded early", f"{short} is rounded to {decimals} decimals"
    return cause, f"{short} is {written:.6g}, should be {expected:.6g}"


# From labels to roles.


def _named(graph, cells):
    """The cells that a name of the workbook or the caller names."""
    for name, area in graph.names.items():
        if isinstance(area, str):  # a formula
            continue
        role = read_label(re.sub(r"^(?:recipe|method|m)_?[12]_", "", name.lower()))
        if role and role.kind == "angle" and area.shape == (3, 3):
            role = Role("matrix", role.word)
        if role and area.shape == ((1, 1) if role.kind in SINGLE else (3, 3)):
            yield Block(role, tuple(area.places))
    for name, kind in {"angles": "angle", "point": "coordinate", "result": "outcome"}.items():
        places = graph.named(name, cells[name]).places if name in (cells or {}) else ()
        yield from (Block(Role(kind, (n,)), (p,)) for n, p in enumerate(places) if len(places) == 3)


def _labelled(cells):
    """What stands beside the labels: the nine cells of a matrix, or one cell."""
    texts = {p: c.value for p, c in sorted(cells.items()) if isinstance(c.value, str) and not c.error}
    labels, taken, runs = {place: role for place, text in texts.items() if (role := read_label(text))}, set(), {}
    for place, role in labels.items():
        nine = _nine(cells, place, labels, taken) if role.kind in (*MATRICES, "angle") else None
        numbers = [cells[p].number if p in cells else None for p in nine or ()]
        if nine and (role.kind != "angle" or None in numbers or may_turn(numbers)):
            taken.update(nine)
            yield Block(Role(role.kind.replace("angle", "matrix"), role.word), nine)
    for place, role in labels.items():
        if role.kind in SINGLE and role.word:
            before = sum(r == role for run in runs.values() for _, r in run)
            runs.setdefault((place[0], role.kind, before), []).append((place, role))
    for run in runs.values():  # all to the right of their labels, or all below
        ways = [[_next(cells, place, *step, labels) for place, _ in run] for step in ((0, 1), (1, 0))]
        right, down = (sum(p is not None and p not in taken for p in way) for way in ways)
        yield from (Block(r, (p,)) for (_, r), p in zip(run, ways[right < down], strict=True) if p is not None)


def _next(cells, place, down, right, labels):
    """The first cell beside a label that is neither empty nor a unit; None if that is the next label."""
    for n in (1, 2, 3):
        near = place[0], place[1] + n * down, place[2] + n * right
        if near in cells and str(cells[near].value).strip().lower() not in UNIT_WORDS:
            return None if near in labels else near
    return None


def _nine(cells, label, labels, taken):
    """The nine cells of the matrix that a label names: below it or to its right."""
    sheet, row, column = label
    for down, right in ((1, 0), (0, 1), (1, -1), (-1, 1), (1, -2), (1, 1)):
        top, left = row + down, column + right
        places = tuple(Area(sheet, top, left, top + 2, left + 2).places)
        near = [cells[p] for p in places if p in cells]
        good = sum(cell.error or bool(re.search(r"\d", str(cell.value))) for cell in near)
        if good >= 7 and min(top, left) > 0 and taken.isdisjoint(places) and labels.keys().isdisjoint(places):
            return places
    return None


# From roles to formulas.


def _formulas(block, others):
    """Place → (formula, first cell of the array or ()), from the blocks before this one, the nearest first."""
    refs, formula, (kind, word), places = {}, None, (block.role.kind, block.role.word), block.places
    for other in others:
        refs.setdefault(other.role, _ref(other.places))
    angle = refs.get(Role("negated", word)) or refs.get(Role("angle", word))
    if kind == "matrix" and len(word) == 1 and angle:
        parts = [refs.get(Role(name, word)) or f"{name.upper()}(RADIANS({angle}))" for name in ("cos", "sin")]
        entries = chain(*elementary_formulas("ZXZ"[word[0]], *parts))
        return {p: (entry, ()) for p, entry in zip(places, entries, strict=True)}
    whole = [o for o in others if o.role.kind == "matrix" and len(o.role.word) in (0, 3)]
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
    return {p: (f"={formula}", places[0][1:] if len(places) > 1 else ()) for p in places if formula}


def elementary_formulas(axis, cosine, sine):
    """Return the passive elementary matrix about `axis` as a nested list of formulas.

    Examples
    --------
    >>> elementary_formulas("Z", "B9", "C9")
    [['=B9', '=C9', '=0'], ['=-C9', '=B9', '=0'], ['=0', '=0', '=1']]
    """
    cells, matrix = {"cos(t)": cosine, "sin(t)": sine}, PASSIVE[axis](sp.Symbol("t")).tolist()
    return [
        [re.sub(r"(cos|sin)\(t\)", lambda found: cells[found[0]], f"={entry}") for entry in row] for row in matrix
    ]


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
