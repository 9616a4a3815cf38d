"""What the labels of a sheet say that its cells hold, and which formula the cells should have."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

import sympy as sp

from mathpost.rotation import PASSIVE
from mathpost.workbook.meaning.given import may_turn
from mathpost.workbook.meaning.label import SINGLE, UNIT_WORDS, Role, read_label
from mathpost.workbook.sheet.formula import Area, area_of
from mathpost.workbook.sheet.place import Line

if TYPE_CHECKING:
    from mathpost.workbook.sheet.file import Cell
    from mathpost.workbook.sheet.graph import Graph
    from mathpost.workbook.sheet.place import Place

MATRICES = {"matrix", "transposed"}


class Block(NamedTuple):
    """A role and the places of its cells: one, or nine row by row."""

    role: Role
    places: Line


def read_labels(graph: Graph) -> dict[Place, tuple[str, tuple]]:
    """Return place → (formula, first cell of its array) that the cell should have according to the labels."""
    blocks, implied = labelled(graph), {}
    for n, block in enumerate(blocks):
        later = [b for b in blocks[n + 1 :] if b.role.kind != "negated"]
        implied.update(_formulas(block, blocks[:n][::-1] + later))
    return implied


def labelled(graph: Graph, cells: dict[str, str] | None = None) -> list[Block]:
    """The blocks of what the caller, the names of the workbook and the labels name, as they are read."""
    blocks: list[Block] = []
    taken: set[Place] = set()
    for block in (*_named(graph, cells), *_labelled(graph.cells)):
        if taken.isdisjoint(block.places):
            taken.update(block.places)
            blocks.append(block)
    return sorted(blocks, key=lambda block: graph.reading_order(block.places[0]))


def _named(graph: Graph, cells: dict[str, str] | None) -> Iterator[Block]:
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
        places = graph.named(name, cells[name]).places if cells and name in cells else ()
        yield from (Block(Role(kind, (n,)), (p,)) for n, p in enumerate(places) if len(places) == 3)


def _labelled(cells: dict[Place, Cell]) -> Iterator[Block]:
    """The cells beside the labels: the nine cells of a matrix, or one cell."""
    texts = {p: c.value for p, c in sorted(cells.items()) if isinstance(c.value, str) and not c.error}
    labels = {place: role for place, text in texts.items() if (role := read_label(text))}
    taken: set[Place] = set()
    runs: dict[tuple[str, str, int], list[tuple[Place, Role]]] = {}
    for place, role in labels.items():
        nine = _nine(cells, place, labels, taken) if role.kind in (*MATRICES, "angle") else None
        found = [cells[p].number if p in cells else None for p in nine or ()]
        numbers = [number for number in found if number is not None]
        if nine and (role.kind != "angle" or len(numbers) < len(found) or may_turn(numbers)):
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


def _next(cells: dict[Place, Cell], place: Place, down: int, right: int, labels: dict[Place, Role]) -> Place | None:
    """The first cell beside a label that is neither empty nor a unit; None if that is the next label."""
    for n in (1, 2, 3):
        near = place[0], place[1] + n * down, place[2] + n * right
        if near in cells and str(cells[near].value).strip().lower() not in UNIT_WORDS:
            return None if near in labels else near
    return None


def _nine(cells: dict[Place, Cell], label: Place, labels: dict[Place, Role], taken: set[Place]) -> Line | None:
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


def _formulas(block: Block, others: list[Block]) -> dict[Place, tuple[str, tuple[int, ...]]]:
    """Place → (formula, first cell of the array or ()), from the blocks before this one, the nearest first."""
    kind, word, places = block.role.kind, block.role.word, block.places
    refs: dict[Role, str] = {}
    formula = None
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


def elementary_formulas(axis: str, cosine: str, sine: str) -> list[list[str]]:
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


def _product(refs: dict[Role, str], word: tuple[int, ...], own: Role) -> str | None:
    """MMULT of the matrices in `word`, using products that the sheet already has."""
    role = Role("matrix", word)
    if role in refs and role != own:
        return refs[role]
    for cut in range(len(word) - 1, 0, -1):
        left, right = (_product(refs, part, own) for part in (word[:cut], word[cut:]))
        if left and right:
            return f"MMULT({left},{right})"
    return None


def _ref(places: Line) -> str:
    area = area_of(places)
    return f"'{area.sheet}'!{area}"
