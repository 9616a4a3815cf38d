"""The steps from the CL data of one tool to the blocks of its program, in the order in which `plan` takes them.

Each is a function of the path, of what the steps before it made, and of the options, and can be called by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, ReachError
from mathpost.formula import slices
from mathpost.path import deviation, selection
from mathpost.path.between_blocks import follow, in_the_air, linearize
from mathpost.path.cl import commands
from mathpost.path.cl_words import in_program
from mathpost.path.deviation import TOLERANCE
from mathpost.path.modal import Command
from mathpost.path.motion import LIFTED, SAFE, Motion
from mathpost.path.region import through_the_records, unbroken
from mathpost.path.selection import Selection
from mathpost.path.singular import regions
from mathpost.shop.compensate.compensation import Compensated, Compensator, PoseError
from mathpost.shop.controls.blocks import Blocks, rounded
from mathpost.shop.post import proof
from mathpost.shop.post.approach import (
    approach_command,
    approached,
    approaches,
    counted_from,
    from_safe,
    unwound,
)
from mathpost.shop.post.clear import CLEAR, judged
from mathpost.shop.post.options import Options
from mathpost.shop.post.time_law import block_times, tcp_times
from mathpost.shop.post.tool_path import ToolPath, what_the_control_holds
from mathpost.shop.post.ways import Crossing


@dataclass(frozen=True)
class Strokes:
    """How a control pecks on the way to the bottom of a hole."""

    place: float  # of the bottom, on the CL path
    parts: np.ndarray  # shape (k,), of the way from where the feed begins to the bottom: where each stroke ends
    rapid: np.ndarray  # shape (k,), whether it is in rapid traverse


@dataclass(frozen=True)
class Moves:
    """The moves of one tool, as they are to be written."""

    motion: Motion  # the n poses at which blocks end
    blocks: Blocks  # one for each pose
    # Where not every pose is the end of a block, see `mathpost.shop.post.own_words`: the poses that the control
    # ends a move at, which of these are ends of an arc, and the records that it replaces by pecks of its own.
    run: np.ndarray | None = None
    turns: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    pecks: np.ndarray = field(default_factory=lambda: np.empty(0, int))
    strokes: tuple[Strokes, ...] = ()  # what these are, if the control's file says it
    cycles: int = 0  # holes that are drilling cycles of the control
    smooth: np.ndarray | None = None  # as read back: which poses are within an arc


@dataclass(frozen=True)
class Plan:
    """What one tool does on its part of the path, and how that came about."""

    path: ToolPath
    chosen: Selection
    regions: list[tuple[int, int]]  # the singular ones, first and last record
    moves: Moves
    uncompensated: proof.Proof | None  # of the machine as it was measured, had nothing been compensated
    cautions: tuple[str, ...]  # what could not be compensated, or is not clear


def plan(
    path: ToolPath,
    options: Options,
    start: ArrayLike | None = None,
    progress: Callable[[str], None] = lambda stage: None,
    *,
    before: Plan | None = None,
) -> Plan:
    """Return the `Plan` of one tool, from `start`, joints of shape (5,), or without it from anywhere.

    Behind the plan of the path `before` it goes on from where that one ended; from the safe position, where both
    have one.
    """
    progress("choosing")
    if before is not None:
        start = counted_from(path, before, before.chosen.joints[-1])
    chosen = choose(path, options, start)
    found = regions(path.kin, path.cl, chosen.joints, cone=options.cone)
    progress("planning")
    motion, free = cross(path, chosen, found, options)
    comes = approaches(path.kin.machine, options)
    goes_on = before is not None and not any(record == 0 for record, _ in commands(path.cl.remarks, "tool"))
    if before is not None and comes and goes_on:
        motion, free = from_safe(path, motion, free, before)
    motion = keep_axis(path, motion, free, options)
    motion = keep_tip(path, motion, options)
    measured: proof.Proof | None = None
    cautions: tuple[str, ...] = ()
    real = options.real(path.kin.machine)
    if real is not None:
        measured = uncompensated(path, motion, options)
        motion, cautions = compensate(path, motion, real)
    moves = to_moves(path, motion, options)
    held = [] if before is None else what_the_control_holds(before.path, options)
    said = tuple((0, line) for line in what_the_control_holds(path, options) if line not in held)
    remarks = [*said, *moves.blocks.remarks]
    stated = [n for n, (row, each) in enumerate(remarks) if row == 0 and isinstance(each, Command)]
    first = stated[0] if stated else sum(row == 0 for row, _ in remarks)
    if path.offset is not None and not any(row == 0 for row, _ in commands(remarks, "work offset")):
        remarks.insert(first, (0, Command("work offset", (path.offset,), "")))
    safe = path.kin.machine.safe
    if safe is not None and comes and not goes_on:
        # Spindle and coolant go on where the tool stands above the part, behind its change.
        begun = [n for n, (row, each) in enumerate(remarks) if row == 0 and _begins(each)]
        behind = 1 + max(begun, default=first - 1)
        remarks.insert(behind, (0, approach_command(path, moves.blocks, safe)))
        if before is None and any(row == 0 for row, _ in commands(remarks, "tool")):
            remarks.insert(min(begun), (0, Command("safe", (safe[2],), "")))
    moves = replace(moves, blocks=replace(moves.blocks, remarks=tuple(remarks)))
    refuse_turning_compensation(path, moves.blocks)
    return Plan(path, chosen, found, moves, measured, cautions)


def _begins(remark: str | Command) -> bool:
    return isinstance(remark, Command) and remark.kind in ("tool", "work offset", "offset")


def choose(
    path: ToolPath, options: Options, start: ArrayLike | None = None, *, strategy: str | None = None
) -> Selection:
    """Choose branch and winding of every record, see `mathpost.path.selection.choose`."""
    return selection.choose(
        path.kin, path.cl, strategy or options.strategy, start=start, split=options.split and strategy is None,
        prefer=options.prefer, sway=options.axis_tolerance / 2,
    )  # fmt: skip


def crossing(path: ToolPath, chosen: Selection, region: tuple[int, int], options: Options) -> Crossing:
    """Return a singular region with what is left of the tolerances for the ways through it."""
    room = options.axis_room(path.kin.machine)
    tip = options.tolerance / 2 * options.share(path.kin.machine)
    return Crossing(path.kin, path.cl, chosen.joints, region, tolerance=tip, axis_tolerance=room)


def cross(
    path: ToolPath, chosen: Selection, found: list[tuple[int, int]], options: Options
) -> tuple[Motion, np.ndarray]:
    """Lead the chosen joints through the singular regions `found`, and over the breaks of the path.

    Returns the motion, and which of its moves, shape (m - 1,), go as their way has them and need not keep to the
    great circle of the tool axis.
    """
    how = {"lean": options.lean, "clearance": options.clearance}
    ways: list[Motion] = []
    if options.singular != "direct":
        for region in unbroken(found, chosen.breaks):
            ways.append(crossing(path, chosen, region, options).possible(options.singular, **how))
    for record in chosen.breaks:
        ways.append(unwound(path, chosen, record, options.clearance))
    motion = through_the_records(chosen.joints, ways)
    if approaches(path.kin.machine, options):
        motion = approached(path, motion, options.clearance)
    taken = np.zeros(len(path.cl), bool)
    for way in ways:
        taken[int(way.place[0]) : int(way.place[-1])] = True
    return motion, taken[np.floor(motion.place[:-1]).astype(int)]


def keep_axis(path: ToolPath, motion: Motion, free: np.ndarray, options: Options) -> Motion:
    """Divide cutting moves, but for those that are `free`, until the tool axis keeps to its great circle."""
    return follow(path.kin, path.cl, motion, options.axis_room(path.kin.machine), free=free)


def keep_tip(path: ToolPath, motion: Motion, options: Options) -> Motion:
    """Divide the moves until the tip keeps to the CL path; with TCP the control does that.

    Travel is looked at between the records, too: `ReachError` names the first pose that is out of it.
    """
    name = f"{path.cl.name}, block"
    keep = in_the_air(motion, _left_for_the_tip(path, motion, options), options.clearance)
    divided = linearize(path.kin, motion, keep, name=name)
    fine = divided if options.tolerance <= TOLERANCE else linearize(path.kin, motion, TOLERANCE, name=name)
    _refuse_out_of_travel(path, fine)
    return motion if options.tcp else divided


def _left_for_the_tip(path: ToolPath, motion: Motion, options: Options) -> np.ndarray:
    """What digits and samples leave of the tolerance of the tip, mm, for each move."""
    tip, _ = path.cl.at(motion.place)  # on the path, or lifted by so little that it does not count here
    lever = deviation.levers(path.kin.machine) + np.linalg.norm(tip, axis=1)
    turned = 2 * np.radians(1.0) * lever * (not options.tcp)  # with TCP the angles do not move the tip
    decimals = options.control.decimals
    moved = 0.5 * 10.0**-decimals * (np.sqrt(3) + turned) + deviation.RESOLUTION
    worst = moved.max()
    if worst > options.tolerance / 2:
        expected = f"at least {2 * worst:.4f} mm, for words of {decimals} decimals on this machine"
        raise InputError("tolerance", expected, f"{options.tolerance}")
    room = max(options.share(path.kin.machine) * options.tolerance, 2 * worst)
    return room - np.maximum(moved[:-1], moved[1:])


def _refuse_out_of_travel(path: ToolPath, motion: Motion) -> None:
    """Raise `ReachError` for the first pose, those between the records included, that is out of travel."""
    out = np.flatnonzero(~path.kin.machine.within(motion.joints).all(axis=1))
    if out.size:
        sentences = path.kin.machine.out_of_travel(motion.joints[out[0]])
        raise ReachError(f"{path.cl.where(int(motion.place[out[0]]))} and on: {'; '.join(sentences)}")


def uncompensated(path: ToolPath, motion: Motion, options: Options) -> proof.Proof:
    """Return what the machine as it was measured would make of the motion as it is."""
    moves = to_moves(path, motion, options)
    real = options.real(path.kin.machine)
    return proof.measured(path.kin, path.cl, moves.blocks, moves.motion, real=real)


def compensate(path: ToolPath, motion: Motion, real: Compensator) -> tuple[Motion, tuple[str, ...]]:
    """Return the motion compensated for the errors of the machine, and sentences on what could not be."""
    parts = [real.compensate(motion.joints[rows]) for rows in slices(motion.joints.shape[:1])]
    found = Compensated(
        joints=np.concatenate([each.joints for each in parts]),
        before=parts[0].before,
        after=PoseError(*(np.concatenate([getattr(each.after, of) for each in parts]) for of in ("tip", "axis"))),
        limited=np.concatenate([each.limited for each in parts]),
        refused=np.concatenate([each.refused for each in parts]),
    )
    compensated = replace(motion, joints=found.joints)
    _refuse_out_of_travel(path, compensated)
    return compensated, found.cautions


def to_moves(path: ToolPath, motion: Motion, options: Options) -> Moves:
    """Return the poses of a motion, but repetitions, as `Moves`: the words, feeds and times of the blocks.

    Lifted moves are rapid, but for the last one onto the part behind an approach. Where the control lets each axis
    run at its own rate then, and not every way is clear, they state the time of the slowest axis instead, or with
    TCP a feed: that of the CL data, or what the slowest slide can.
    """
    kin, cl, joints = path.kin, path.cl, motion.joints
    # X Y Z of the machine at the safe position, and on the way from it to the lifted pose above the part.
    from_safe = (motion.kind == LIFTED) & np.r_[False, motion.kind[:-1] == SAFE]
    tcp = options.tcp & (motion.kind != SAFE) & ~from_safe
    if tcp.any():
        joints = joints.copy()
        joints[tcp, :3] = kin.forward(joints[tcp])[0]
    words = rounded(joints, options.control.decimals)
    kept = np.r_[True, (words[1:] != words[:-1]).any(axis=1)]
    kept[1:] |= tcp[1:] != tcp[:-1]
    if not kept.all():
        motion, words, tcp, from_safe = motion[kept], words[kept], tcp[kept], from_safe[kept]
    record = motion.record
    feeds, rapid = cl.feeds[record], cl.rapid[record]
    tip, _ = cl.at(motion.place)  # in cut it is on the path
    seconds = np.r_[np.nan, block_times(kin.machine, motion.joints, tip, feeds[1:], motion.in_cut)]
    turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
    plunge = np.r_[False, from_safe[:-1]] & ~np.isnan(feeds)  # onto the part: at its feed
    in_air = np.r_[motion.lifted[0], ~motion.in_cut] & ~plunge
    wanted = rapid | in_air
    rapid = wanted.copy()
    if not options.control.rapid_interpolated:
        rows = 1 + np.flatnonzero(wanted[1:])  # the first comes from where nobody knows, at the safe position
        ways = path.ways(motion.joints, motion, ~wanted, tcp)
        rapid[rows] = judged(kin, ways, rows, path.touched) == CLEAR
    by_time = ((turning & ~np.isnan(feeds)) | wanted) & ~rapid
    if options.control.turning_feed != "time":
        by_time &= ~tcp
    elif tcp.any():
        within_rates = np.where(tcp[1:], tcp_times(kin, motion.joints), 0)
        seconds = np.fmax(seconds, np.r_[np.nan, within_rates])
    slow = wanted & ~rapid & np.isnan(feeds) & ~(by_time & ~np.isnan(seconds))
    if slow.any():
        if (unfed := np.isnan(feeds) & ~wanted).any():  # they would cut at the feed of the rapid moves
            expected = "a feed (FEDRAT, --feed) of all moves in cut, where some rapid ones need an F word"
            raise InputError(cl.where(record[unfed.argmax()]), expected, "none")
        feeds = np.where(slow, _instead_of_rapid(path, int(record[slow.argmax()])), feeds)
    if options.control.turning_feed == "degrees" and tcp.any():
        only_turns = turning & tcp & np.r_[False, tcp[:-1] & (words[1:, :3] == words[:-1, :3]).all(axis=1)] & ~rapid
        degrees = np.r_[0.0, np.abs(np.diff(words[:, 3:], axis=0)).max(axis=1)]
        only_turns &= seconds > 0
        feeds = np.where(only_turns, 60 * degrees / np.where(only_turns, seconds, 1), feeds)
    # A remark comes before the first block of the move to its record.
    before = np.searchsorted(motion.place, [record - 1 for record, _ in cl.remarks], side="right").tolist()
    said = ((block, in_program(each) if isinstance(each, str) else each)
            for block, (_, each) in zip(before, cl.remarks, strict=True))  # fmt: skip
    remarks = tuple((block, each) for block, each in said if each)
    blocks = Blocks(words, feeds, np.where(by_time, seconds, np.nan), rapid, tcp, remarks)
    return Moves(motion, blocks)


def _instead_of_rapid(path: ToolPath, record: int) -> float:
    """A feed for moves that cannot be rapid, mm/min: what the slowest slide can, or else one of the CL data."""
    rates = path.kin.machine.max_rates[:3]
    known = path.cl.feeds[~np.isnan(path.cl.feeds)]
    if not np.isnan(rates).any():
        return float(60 * rates.min())
    if not known.size:
        expected = "rates of the slides, or a feed (FEDRAT), for a move that cannot be rapid"
        raise InputError(path.cl.where(record), expected, "none")
    return float(known[0])


def refuse_turning_compensation(path: ToolPath, blocks: Blocks) -> None:
    """Refuse rotary axes that move, a tilted head, and TCP, while the cutter radius is compensated."""
    heads = [joint.carries == "tool" for joint in path.kin.machine.rotary]
    switched = commands(blocks.remarks, "compensation")
    ends = [first for first, _ in switched[1:]] + [len(blocks.words)]
    for (first, side), last in zip(switched, ends, strict=False):
        rotary = blocks.words[max(first - 1, 0) : last + 1, 3:]
        turned = np.ptp(rotary, axis=0).any() or rotary[:1, heads].any()
        if side.values[0] != "OFF" and (blocks.tcp[first:last].any() or turned):
            expected = "rotary axes that stand still, the tool across X and Y, and no TCP"
            raise InputError(f"{path.cl.name}: {side.statement}", expected, "others while it holds")
