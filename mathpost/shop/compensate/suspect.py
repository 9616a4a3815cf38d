"""Why readings do not fit: a sign, two columns exchanged, another unit, another method; sought by trying them.

Each is tried in one linear step, and compared by likelihood: twice the logarithm of how much better the readings
would fit. What is decisively better is estimated in full, and named if that fits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.errors import MathpostError
from mathpost.machine import MM_PER_INCH
from mathpost.shop.compensate import readings as files
from mathpost.shop.compensate.estimate import estimate
from mathpost.shop.compensate.positioning import Positioning
from mathpost.shop.compensate.problem import Problem
from mathpost.shop.compensate.readings import METHODS, Read, Readings

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.calibration import Calibration
    from mathpost.shop.measure.csv_table import Table

DECISIVE = 20.0  # twice the logarithm of the odds, 20,000 to 1, by which a cause is taken for one
BETTER = 3  # times less noise, by which one is named although what it leaves does not fit either
FILES = 3  # of those that do not fit, in which a cause is sought
MOST = 1000  # readings of a file with which causes are tried
TRIED = 3  # causes that are estimated in full, with all readings


@dataclass(frozen=True)
class Cause:
    """What may be wrong, in words, and the readings if it is mended."""

    words: str
    where: tuple[str, ...]  # the files
    read: tuple[Read, ...]
    misfit: float


def causes(
    machine: Machine, paths: Sequence[Path | str], read: Sequence[Read], settings: dict[str, Any],
    found: Calibration | None,
) -> list[str]:  # fmt: skip
    """Return a sentence on the likely cause if there is one; `found` is the estimate as it is, if there is one."""
    blocks = {n: each for n, each in enumerate(read) if isinstance(each, Readings)}
    if not blocks:
        return []
    doubts = found.doubts if found else ()
    named = [n for n in blocks if any(str(paths[n]) in doubt for doubt in doubts)][:FILES]
    sets = list(dict.fromkeys([tuple(blocks), *((n,) for n in named)]))
    noise = [_noise(each, found) for each in blocks.values()]
    some = [_some(each) for each in blocks.values()]
    problem = Problem(machine, some, [each for each in read if isinstance(each, Positioning)])
    before = problem.misfit(noise)
    tables = {n: files.read_table(paths[n], machine, **settings) for n in blocks}
    tried = [each for own in sets for each in _tried(problem, read, {n: tables[n] for n in own}, noise)]
    tried = sorted((each for each in tried if before - each.misfit > DECISIVE), key=lambda each: each.misfit)
    likely: dict[str, tuple[Cause, Calibration]] = {}
    for each in tried[:TRIED]:
        if each.misfit - tried[0].misfit > DECISIVE and likely:
            break
        try:
            mended = estimate(machine, each.read)
        except MathpostError:
            continue
        if _better(mended, found, each):
            likely.setdefault(each.words, (each, mended))
    return _sentences(list(likely.values()), found)


def _some(block: Readings) -> Readings:
    """At most `MOST` of a file's readings, evenly from its first to its last."""
    count = len(block.value)
    return block if count <= MOST else block.at(np.linspace(0, count - 1, MOST).astype(int))


def _noise(block: Readings, found: Calibration | None) -> float:
    """The scatter of a file's readings, mm: as stated, or as found but at most the one usual for the method."""
    most = 1e-3 * METHODS[block.method]["noise"]
    return block.sigma if np.isfinite(block.sigma) else min(most, found.noise[block.where][0] if found else most)


def _tried(
    problem: Problem, read: Sequence[Read], tables: dict[int, Table], noise: Sequence[float]
) -> Iterator[Cause]:
    """Yield what each change of `tables`, files by number, would make of all readings."""
    blocks = [each for n, each in enumerate(read) if n in tables and isinstance(each, Readings)]
    for words, change in _changes(blocks, problem.machine):
        mended, changed = list(read), []
        with suppress(MathpostError):  # what makes a file unreadable is no cause
            for n, table in tables.items():
                other = deepcopy(table)
                if change(other):
                    changed.append(str(table.path))
                    mended[n] = files.taken(other, problem.machine)
            if changed:
                again = problem.read_again([_some(each) for each in mended if isinstance(each, Readings)])
                yield Cause(words, tuple(changed), tuple(mended), again.misfit(noise))


def _better(mended: Calibration, found: Calibration | None, cause: Cause) -> bool:
    """Whether the mended readings fit, or scatter by so much less that a second fault may be left."""
    if mended.fits or found is None:
        return mended.fits
    methods = {each.where: METHODS[each.method] for each in cause.read if isinstance(each, Readings)}
    scatter = {where: mended.noise[where][0] for where in cause.where}
    return all(
        BETTER * sigma < found.noise[where][0] and 1e3 * sigma <= methods[where]["noise"]
        for where, sigma in scatter.items()
    )


def _sentences(likely: list[tuple[Cause, Calibration]], found: Calibration | None) -> list[str]:
    if not likely:
        return []
    (cause, mended), where = likely[0], likely[0][0].where[0]
    said = f"{1e3 * mended.noise[where][0]:.1f}"
    said += f" instead of {1e3 * found.noise[where][0]:.1f}" if found else ""
    words = ", or ".join(each.words for each, _ in likely)
    return [f"{', '.join(cause.where)}: likely cause: {words}; readings would scatter by {said} µm"]


def _changes(blocks: Sequence[Readings], machine: Machine) -> Iterator[tuple[str, Callable[[Table], bool]]]:
    """What may be wrong, in words, and what mends a table; False if that has nothing of the kind."""
    columns = list(dict.fromkeys(column for block in blocks for _, column in block.rows))
    methods = {block.method for block in blocks}
    axes = [each.name for each in machine.rotary]
    for name in (*axes, "angle"):
        yield f"the sign of {name}, in the readings or in the machine file", _scaled([name], -1)
    for one, other in (*combinations(axes, 2), *combinations(columns, 2)):
        yield f"the columns {one} and {other} exchanged", _exchanged(one, other)
    for one, other in combinations("xyz", 2):
        if one not in columns:
            yield f"the columns {one} and {other} exchanged", _exchanged(one, other)
    for name in columns:
        yield f"the sign of {name}", _scaled([name], -1)
    yield "the sign of all readings", _scaled(columns, -1)
    if methods & {"ball", "sensor"}:
        yield "places in inches", _scaled("xyz", MM_PER_INCH)
    for method, other, whose in (("ball", "sensor", "table"), ("sensor", "ball", "machine")):
        if method in methods:
            yield f"another method: {other} (along the {whose}'s axes)", _method(method, other)


def _scaled(names: Iterable[str], factor: float) -> Callable[[Table], bool]:
    def change(table: Table) -> bool:
        found = [name for name in names if name in table]
        for name in found:
            table[name] = factor * table[name]
        return bool(found)

    return change


def _exchanged(one: str, other: str) -> Callable[[Table], bool]:
    def change(table: Table) -> bool:
        if one not in table or other not in table:
            return False
        table[one], table[other] = table[other], table[one]
        return True

    return change


def _method(one: str, other: str) -> Callable[[Table], bool]:
    def change(table: Table) -> bool:
        if table.settings["method"] != one:
            return False
        table.settings["method"] = other
        return True

    return change
