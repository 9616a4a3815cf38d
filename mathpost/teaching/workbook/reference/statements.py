"""What is said of a hand-in: what was found, what is open, what each cell is worth, and which rule judged it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from mathpost.teaching.workbook.reference.matched import different
from mathpost.teaching.workbook.report import CONSEQUENCE, RIGHT, UNCLEAR, WRONG, Judgement
from mathpost.teaching.workbook.sheet.file import EMPTY
from mathpost.teaching.workbook.sheet.tree import text_of

if TYPE_CHECKING:
    from mathpost.teaching.workbook.reference.hand_in import HandIn
    from mathpost.teaching.workbook.reference.moved import Telling
    from mathpost.teaching.workbook.sheet.place import Place

BY_NUMBER = "compared as a number, and no more than that: it depends on no input that was found"


def open_questions(hand_in: HandIn, missing: Sequence[Place]) -> Iterator[str]:
    ours, sheet, cells = hand_in.ours, hand_in.sheet, hand_in.matched.cells
    if unsure := [(ours.address(p), sheet.address(cells[p][0])) for p in hand_in.matched.unsure]:
        yield "in a different order, if these do what they should: " + ", ".join(f"{c} for {p}" for p, c in unsure)
        if not missing:
            yield "say whether they do: --cells " + repr(",".join(f"{p}={c}" for p, c in unsure))
    asked: list[Place] = []
    for places in (missing if not hand_in.faults else ()), hand_in.matched.open:
        if places:
            what = "results" if places is not hand_in.matched.open else "inputs"
            if what == "inputs" and not missing:
                continue
            names = [f"{text} {ours.label(ours.named('', text).places[0])}".strip() for text in ours.ranges(places)]
            listed = "; ".join([*names[:6], *["…"] * (len(names) > 6)])
            yield f"{what} of the reference that were not found: {listed}"
            asked += places
    if asked and not hand_in.faults:
        text = ",".join(f"{ours.address(place)}=CELL" for place in asked[:3])
        yield f"say where they are: --cells {text!r}"
    for place in sorted(sheet.unknown, key=sheet.reading_order)[:3]:
        if missing:
            yield f"{sheet.address(place)} is not evaluated: {sheet.why_unknown(place)}"


def seen(hand_in: HandIn) -> Iterator[str]:
    found, sheet = hand_in.comparison.found, hand_in.sheet
    yield (
        f"{len(found)} of {len(hand_in.comparison.asked)} results and {len(hand_in.matched.cells)} of "
        f"{len(hand_in.reference.inputs)} inputs of {hand_in.reference.path.name} found"
    )
    names: dict[str, list[Place]] = {}
    for result, cell in found.items():
        names.setdefault(hand_in.ours.label(result), []).append(cell)
    for name, cells in names.items():
        yield f"{', '.join(sheet.ranges(cells))}: {name or 'a result of the reference'}"


def error_elsewhere(hand_in: HandIn, each: Telling) -> str:
    """An error that the hand-in has at other numbers than its own."""
    numbers = [f"{hand_in.ours.address(p)} of the reference is {v:g}" for p, v in each.given.items()]
    cell = hand_in.sheet.address(hand_in.comparison.found[each.result])
    return f"{cell} is an error, where the reference has a number: if {', '.join(numbers[:3])}"


def warnings(hand_in: HandIn) -> Iterator[str]:
    yield from hand_in.not_compared
    yield from (error_elsewhere(hand_in, each) for each in hand_in.errors if each.is_single)
    for result, cell in hand_in.comparison.found.items():
        if not hand_in.comparison.varies(result):
            yield f"{hand_in.sheet.address(cell)} is {BY_NUMBER}"
    if hand_in.matched.open:
        yield f"not varied, as no cell has them: {', '.join(hand_in.ours.ranges(hand_in.matched.open))}"
    for place, factor in hand_in.matched.factor.items():
        yield f"{hand_in.sheet.address(hand_in.matched.cells[place][0])} is taken as {factor:.6g} times its input"
    if own := different(hand_in.matched, hand_in.ours, hand_in.sheet):
        yield f"numbers of the student's own: {', '.join(hand_in.sheet.ranges(cell for _, cell in own))}"
    yield from hand_in.sheet.book.notes


def judgements(hand_in: HandIn) -> Iterator[Judgement]:
    sheet, comparison = hand_in.sheet, hand_in.comparison
    formulas = [p for p in hand_in.first_trees if p not in sheet.messages]
    cells = dict.fromkeys([*formulas, *hand_in.wrong])
    right = sheet.upstream(comparison.found.values())
    for place in sorted(cells, key=sheet.reading_order):
        known = place in right or (place in comparison.theirs and comparison.theirs[place] in comparison.known)
        status = (
            WRONG
            if place in hand_in.wrong
            else CONSEQUENCE
            if place in hand_in.after
            else RIGHT
            if known
            else UNCLEAR
        )
        cell = sheet.book.cells.get(place, EMPTY)
        yield Judgement(sheet.address(place), place, status, cell.value if cell.number is None else cell.number)


def explain(hand_in: HandIn, text: str) -> list[str]:
    """Which rule judged a cell, and what it used."""
    sheet, comparison = hand_in.sheet, hand_in.comparison
    (place, *_) = sheet.named("why", text).places
    cell, address = sheet.book.cells.get(place, EMPTY), sheet.address(place)
    tree = hand_in.first_trees.get(place)
    lines = [f"{address} is {cell.value}" + (f", ={text_of(tree, place[0])}" if tree else "")]
    for fault in hand_in.faults:
        if fault.place == place:
            lines.append(f"rule: changed so, it makes right what is missing: {fault.cause}: {fault.message}")
    if place in hand_in.wrong and len(lines) == 1:
        lines.append("rule: filled from a formula that is wrong")
    elif place in hand_in.after and place not in hand_in.wrong:
        lines.append("rule: it follows from a cell that is wrong")
    for result, found in comparison.found.items():
        if found == place:
            lines.append(f"rule: at all samples it is {hand_in.ours.address(result)} of the reference")
    if place in hand_in.matched.back:
        lines.append(f"rule: it is the input {hand_in.ours.address(hand_in.matched.back[place])} of the reference")
    if len(lines) == 1 and place in sheet.upstream(comparison.found.values()):
        lines.append("rule: a result that is right uses it")
    if len(lines) == 1 and place in comparison.theirs and (keys := comparison.known.find(comparison.theirs[place])):
        lines.append(f"rule: it is what {hand_in.ours.address(keys[0])} of the reference is, or uses")
    return lines if len(lines) > 1 else [*lines, "not judged: no result of the reference depends on it"]
