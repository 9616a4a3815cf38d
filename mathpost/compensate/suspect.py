"""Why readings do not fit: a sign, two columns exchanged, another unit, another method; sought by trying them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mathpost.compensate import readings as files
from mathpost.compensate.readings import METHODS, Read, Readings
from mathpost.errors import MathpostError

if TYPE_CHECKING:
    from mathpost.compensate.calibrate import Calibration
    from mathpost.machine import Machine
    from mathpost.measure.csv_table import Table

BETTER = 3  # times less noise, by which a cause is taken for one
INCH = 25.4


def causes(
    machine: Machine, paths: Sequence[Path | str], read: Sequence[Read], settings: dict[str, Any],
    found: Calibration, estimate: Callable[[Machine, Sequence[Read]], Calibration],
) -> list[str]:  # fmt: skip
    """Return sentences on the likely cause for each file that scatters too much, found by mending it."""
    sentences = []
    for number, (path, block) in enumerate(zip(paths, read, strict=True)):
        if not isinstance(block, files.Readings) or not any(str(path) in doubt for doubt in found.doubts):
            continue
        before, best = found.noise[block.where][0], None
        for words, change in _changes(block, machine):
            try:
                mended = files.read(path, machine, change=change, **settings)
                other = estimate(machine, [*read[:number], mended, *read[number + 1 :]])
            except MathpostError:
                continue
            noise = other.noise[block.where][0]
            if BETTER * noise < before and not _too_much(other, block) and (best is None or noise < best[0]):
                best = noise, words
        if best is not None:
            said = f"readings would scatter by {1e3 * best[0]:.1f} instead of {1e3 * before:.1f} µm"
            sentences.append(f"{block.where}: likely cause: {best[1]}; {said}")
    return sentences


def _too_much(found: Calibration, block: Readings) -> bool:
    return 1e3 * found.noise[block.where][0] > METHODS[block.method]["noise"]


def _changes(block: Readings, machine: Machine) -> Iterator[tuple[str, Callable[[Table], None]]]:
    """What may be wrong, in words, and what mends a table."""
    columns = list(dict.fromkeys(column for _, column in block.rows))
    axes = [each.name for each in machine.rotary]
    for name in (*axes, "angle"):
        yield f"the sign of {name}, in the readings or in the machine file", _scaled([name], -1)
    yield f"the columns {' and '.join(axes)} exchanged", _exchanged(*axes)
    for one, other in combinations(columns, 2):
        yield f"the columns {one} and {other} exchanged", _exchanged(one, other)
    for one, other in combinations("xyz", 2):
        if one not in columns:
            yield f"the columns {one} and {other} exchanged", _exchanged(one, other)
    for name in columns:
        yield f"the sign of {name}", _scaled([name], -1)
    yield "the sign of all readings", _scaled(columns, -1)
    if block.method in ("ball", "sensor"):
        yield "places in inches", _scaled("xyz", INCH)
        other = {"ball": "sensor", "sensor": "ball"}[block.method]
        yield (
            f"another method: {other} (along the {'table' if other == 'sensor' else 'machine'}'s axes)",
            _method(other),
        )


def _scaled(names: Iterable[str], factor: float) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        found = [name for name in names if name in table]
        if not found:
            raise MathpostError("no such column")
        for name in found:
            table[name] = factor * table[name]

    return change


def _exchanged(one: str, other: str) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        if one not in table or other not in table:
            raise MathpostError("no such column")
        table[one], table[other] = table[other], table[one]

    return change


def _method(name: str) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        table.settings["method"] = name

    return change
