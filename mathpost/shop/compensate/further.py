"""What readings leave open, in a sentence: which unknowns they cannot separate, and what would."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.errors import ReachError
from mathpost.rotation import unit
from mathpost.shop.compensate.held import held
from mathpost.shop.compensate.model import shown_in
from mathpost.shop.compensate.problem import Problem
from mathpost.shop.compensate.readings import METHODS
from mathpost.shop.measure.fit import coverage_factor

if TYPE_CHECKING:
    from mathpost.machine import Machine
    from mathpost.shop.compensate.readings import Readings

    Change = Callable[[Readings], Readings]

MORE = 200  # mm by which a ball or a tool is moved
ANGLES = 4  # of an axis, over its travel
LEVELS = ((1, False), (2, False), (2, True), (3, True))  # how many changes, and whether each of them alone, too
MANY = 1000  # readings beyond which only single changes are tried
FIXED = ("dial", "tip", "ballbar")  # methods that say themselves where they are read, and along what


def reasons(problem: Problem, names: list[str], noise: float) -> dict[str, str]:
    """Return why each of `names` is not determined, what would determine it, and what it is taken for.

    `noise` is the standard deviation of a reading, mm.
    """
    advised = _advised(problem, [name for name in names if problem.reasons.get(name) is not None], noise)
    found = {}
    for name in names:
        most = coverage_factor(np.inf) * problem.prior[problem.names.index(name)]
        size, letters = shown_in(name)
        taken = f"taken for 0 ± {size * most:.0f} {letters}, which is in U"
        others = problem.reasons.get(name)
        if others is None:
            found[name] = f"the readings say too little of it: {taken}"
            continue
        from_what = _listed(others) if others else "where the ball stands"
        advice = f" Also {', or '.join(advised[name][:2])}." if name in advised else ""
        found[name] = f"these readings cannot separate {name} from {from_what}.{advice} {name} is {taken}"
    return found


def _listed(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}" if len(words) > 1 else words[0]


def _advised(problem: Problem, names: list[str], noise: float) -> dict[str, list[str]]:
    """What determines each of `names`, in words: one change of what was read, or up to three of them."""
    single = list(_candidates(problem))
    found: dict[str, list[str]] = {}
    for count, crossed in LEVELS if len(problem.observed) < MANY else LEVELS[:1]:
        left = [name for name in names if name not in found]
        for parts in combinations(single, count) if left else ():
            words, changes = zip(*parts, strict=True)
            try:
                again = _again(problem.blocks, changes, crossed)
                more = Problem(problem.machine, [*problem.blocks, *again], problem.tables)
            except ReachError:  # where no laser has been
                continue
            tied = {each for name, others in more.reasons.items() for each in (name, *(others or []))}
            for name in left:
                first = count == 1 or name not in found
                if first and name not in tied and more.would_tell(name, noise):
                    advice = _listed(list(words)) + (", in all combinations" if crossed else "")
                    found.setdefault(name, []).append(advice)
    return found


def _again(blocks: list[Readings], changes: Sequence[Change], crossed: bool) -> Iterator[Readings]:
    """The readings taken again with all `changes` at once; crossed: with any of them, too."""
    fewest = 1 if crossed else len(changes)
    for count in range(fewest, len(changes) + 1):
        for block, some in product(blocks, combinations(changes, count)):
            for change in some:
                block = change(block)
            yield block


def _candidates(problem: Problem) -> Iterator[tuple[str, Change]]:
    """Words, and how the readings of a file would be taken again; an axis that turned before one that stood."""
    machine, blocks = problem.machine, problem.blocks
    read = {name for block in blocks for _, name in block.rows}
    free = [name for block in blocks if block.method not in FIXED for name in METHODS[block.method]["readings"]]
    missing = [name for name in dict.fromkeys(free) if name not in read]
    if missing:
        yield f"read {_listed(missing)}", _all_three
    turned = [any(np.ptp(block.joints[:, 3 + n]) > 0 for block in blocks) for n in range(len(machine.rotary))]
    order = sorted(range(len(turned)), key=lambda n: not turned[n])
    for rotary in (machine.rotary[n] for n in order):
        if free and rotary.carries == "workpiece":
            words = f"move the ball {MORE} mm along the axis of {rotary.name}"
            yield words, partial(_moved, machine, target=MORE * unit(rotary.axis))
    yield f"take a tool {MORE} mm longer", partial(_moved, machine, length=MORE)
    for n in order:
        yield f"turn {machine.rotary[n].name} to four angles", partial(_turned, machine, n)


def _repeated(block: Readings, times: int) -> Readings:
    """Each reading of a file several times."""
    return block.at(np.repeat(np.arange(len(block.value)), times))


def _all_three(block: Readings) -> Readings:
    """The poses of a file, read along X, Y and Z."""
    if block.method in FIXED:
        return block
    return replace(_repeated(block, 3), direction=np.tile(np.eye(3), (len(block.value), 1)))


def _turned(machine: Machine, n: int, block: Readings) -> Readings:
    """The readings of a file at several angles of an axis, evenly over its travel."""
    low, high = machine.rotary[n].limits
    angles = np.linspace(low, high, ANGLES + 2)[1:-1] if np.isfinite(high - low) else np.arange(ANGLES) * np.pi / 2
    several = _repeated(block, ANGLES)
    several.joints[:, 3 + n] = np.tile(angles, len(block.value))
    return _moved(machine, several)


def _moved(machine: Machine, block: Readings, target: np.ndarray | float = 0.0, length: float = 0.0) -> Readings:
    """The readings of a file with the ball or the tool elsewhere."""
    place = block.target + (0.0 if block.method in FIXED else target)
    tool = block.length + length
    joints = held(machine, place, block.joints[:, 3:], tool)[0]
    reference = block.reference
    if reference is not None:
        reference = held(machine, place, reference[:, 3:], tool)[0]
    return replace(block, joints=joints, believed=joints, reference=reference, target=place, length=tool)
