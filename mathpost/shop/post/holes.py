"""Holes of CL data as drilling cycles of the control, where its file has a word for them."""

import math

import numpy as np

from mathpost.frame import Frame
from mathpost.path.arcs import Cycle
from mathpost.path.modal import Command
from mathpost.path.motion import ON_PART
from mathpost.path.pieces import Hole
from mathpost.shop.controls.phrases import Cycles
from mathpost.shop.post.draft import Draft
from mathpost.shop.post.steps import Strokes

SAME = 1e-3  # mm, between heights that count as one, in addition to the printed digits
OF_KINDS = {"DEEP": "deep", "DEEP2": "deep", "BRKCHP": "chips", "BORE": "bore", "REAM": "ream"}

PECKED = ("deep", "chips")


def kind_of(hole: Hole) -> str:
    """The name of a cycle, one of `mathpost.shop.controls.phrases.KINDS`."""
    if hole.cycle.kind == "TAP":
        right = hole.said[-1].values[1] == "CLW"  # as the spindle turns again behind it
        return "tap" if right else "tap left"
    return OF_KINDS.get(hole.cycle.kind, "dwell" if hole.cycle.dwell else "drill")


def _can_say(lines: tuple[str, ...], kind: str, cycle: Cycle) -> bool:
    """Whether a control has a cycle of a kind, which waits at the bottom if it is to: else it is straight moves."""
    waits = any(f"{{{name}" in line for line in lines for name in ("dwell", "milliseconds"))
    return bool(lines) and (waits or not cycle.dwell or kind.startswith("tap"))


def holes(draft: Draft) -> None:
    """Write the holes of a draft as cycles: each row of equal ones is begun once."""
    known = draft.options.control.cycles
    if known is None:
        return
    # What the row of holes has in common, its last row, and whether its cycle is done wherever the tool goes.
    series: tuple[tuple[str, dict[str, float], Frame | None], int, bool] | None = None
    for piece in draft.path.cl.pieces:
        if not isinstance(piece, Hole):
            continue
        kind = kind_of(piece)
        found = _rows(draft, piece) if _can_say(known.kinds.get(kind, ()), kind, piece.cycle) else None
        if found is None:
            continue
        first, last, comes = found
        if series is not None and first == series[1] + 1:
            _level(draft, series[1], first, last)
        values = _values(draft, piece.cycle, piece, first, last)
        said = kind, values, draft.frames[last]
        goes_on = series is not None and series[0] == said and _follows(draft, piece, series[1], first)
        if series is not None and not goes_on:
            _end(draft, known, *series[1:])
        lines, everywhere = known.kinds[kind], bool(known.modal and comes)
        if everywhere and not (goes_on and series is not None and series[2]):
            modal = (*lines[:-1], f"{known.modal} {lines[-1]}")
            draft.say(first, Command("cycle", (modal, values), ""))
        if everywhere or (goes_on and not known.modal):
            lines = known.again
        draft.say(last + 1, Command("cycle", (lines, values), ""), first=True)
        for row in range(first, last + 2):
            there = draft.said.get(row, [])
            there[:] = [each for each in there if not any(each is command for command in piece.said)]
        draft.kept[first + 1 : last + 1] = False
        draft.drilled.append(last)
        bottom = first + 1 + int(draft.words[first + 1 : last + 1, 2].argmin())
        _leave_out_pecks(draft, first, bottom, values["clearance"])
        if kind in PECKED and known.pecks_from:
            heights, rapid = known.pecks(kind, values)
            deep = values["clearance"] - values["bottom"]
            parts = (values["clearance"] - np.array(heights)) / deep
            draft.strokes.append(Strokes(draft.moves.motion.place[bottom], parts, np.array(rapid, bool)))
        series = said, last, everywhere
    if series is not None:
        _end(draft, known, *series[1:])


def _level(draft: Draft, before: int, first: int, last: int) -> None:
    """Give both ends of a hole the height of the one before, if only the last digits differ: its cycle goes on."""
    height, near = draft.words[before, 2], 2.5 * 10.0**-draft.options.control.decimals
    for row in (first, last):
        if draft.frames[before] is draft.frames[row] and abs(draft.words[row, 2] - height) < near:
            draft.words[row, 2] = height


def _end(draft: Draft, cycles: Cycles, last: int, everywhere: bool) -> None:
    there = draft.said[last + 1]
    place = 1 + max(n for n, remark in enumerate(there) if _is_cycle(remark))
    there.insert(place, Command("cycle off", (cycles.off if everywhere or not cycles.modal else (),), ""))


def _is_cycle(remark: str | Command) -> bool:
    return isinstance(remark, Command) and remark.kind == "cycle"


def _follows(draft: Draft, piece: Hole, before: int, first: int) -> bool:
    """Whether a hole comes right behind another one, at the height where the tool has left that."""
    level = draft.words[first, 2] == draft.words[before, 2]
    quiet = all(_is_cycle(remark) for remark in draft.said.get(first, []))
    return first == before + 1 and level and quiet and bool(draft.moves.blocks.rapid[first])


def _rows(draft: Draft, piece: Hole) -> tuple[int, int, bool] | None:
    """The row above a hole, the last one of it, and whether a block goes there; else the tool stands there already.

    None where the control's cycle would do something else.
    """
    motion, blocks = draft.moves.motion, draft.moves.blocks
    first, last = (int(np.searchsorted(motion.place, at, side="right")) - 1 for at in (piece.first, piece.last))
    there = motion.place[first] == piece.first  # or the tool has been above the hole before
    if last - first < 2 or not (there or _stands(draft, first, piece)):
        return None
    body = slice(first, last + 1)
    if not draft.still(first, last) or blocks.tcp[body].any() or (motion.kind[body] != ON_PART).any():
        return None
    start = draft.point(last, draft.path.cl.points[piece.first])
    points = np.r_[start[None], draft.words[first + 1 : last + 1, :3]]
    said = [remark for row in range(first + 1, last + 1) for remark in draft.said.get(row, [])]
    other = any(not any(remark is each for each in piece.said) for remark in said)
    along_z = np.abs(points[:, :2] - points[0, :2]).max() < SAME
    tool = draft.point(last, draft.path.cl.points[piece.first] + draft.path.cl.axes[piece.first]) - start
    comes = draft.path.cl.rapid[motion.record[first]] or not there
    inside = slice(first + 1, last + 1)
    same = (blocks.rapid[inside] == draft.path.cl.rapid[motion.record[inside]]).all()
    fed = comes and same and not np.isfinite(blocks.seconds[inside]).any()
    if other or not along_z or tool[2] < 1 - 1e-7 or not fed:
        return None
    return first, last, bool(there)


def _stands(draft: Draft, row: int, piece: Hole) -> bool:
    """Whether the tool is above a hole already."""
    tip, _ = draft.path.kin.forward(draft.moves.motion.joints[row])
    here = np.linalg.norm(tip - draft.path.cl.points[piece.first]) < SAME
    return bool(here)


def _leave_out_pecks(draft: Draft, first: int, bottom: int, clearance: float) -> None:
    """The rows between the clearance, which may be the height of the first row, and the bottom."""
    begin = first + 1 if abs(draft.words[first + 1, 2] - clearance) < SAME else first
    pecks = np.arange(begin + 1, bottom)
    draft.run[pecks] = False
    draft.pecks += draft.moves.motion.record[pecks].tolist()


def _values(draft: Draft, cycle: Cycle, piece: Hole, first: int, last: int) -> dict[str, float]:
    """The numbers of a cycle, mm, seconds and turns per minute; heights are coordinates but for depth and above."""
    heights = draft.words[first + 1 : last + 1, 2]
    bottom, leave = float(heights.min()), float(heights[-1])
    surface = bottom + cycle.depth
    speeds = [command.values[0] for command in piece.said if command.kind == "spindle"]
    speed = float(speeds[0]) if speeds else 0.0
    steps = [step for step in (cycle.first, cycle.following) if step]
    return {
        "surface": surface,
        "depth": cycle.depth,
        "bottom": bottom,
        "clearance": surface + cycle.clearance,
        "above": cycle.clearance,
        "leave": leave,
        "retract": leave - surface,
        "step": min(steps, default=cycle.depth),
        "dwell": cycle.dwell,
        "milliseconds": 1000 * cycle.dwell,
        "feed": math.floor(1000 * cycle.feed + 1e-6) / 1000,
        "pitch": cycle.feed / speed if speed else 0.0,
        "speed": speed,
    }
