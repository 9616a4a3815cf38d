"""What a person wants to know of a program before running it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mathpost.errors import MathpostError, one_line
from mathpost.machine import Machine
from mathpost.path import deviation, selection
from mathpost.path.cl import CLData, commands, feed_times
from mathpost.path.coordinates import AS_WRITTEN
from mathpost.path.modal import COMMENTS, Command
from mathpost.path.pieces import Hole
from mathpost.shop.controls.blocks import Blocks
from mathpost.shop.controls.control import BETWEEN_BLOCKS
from mathpost.shop.post import proof
from mathpost.shop.post.approach import approaches
from mathpost.shop.post.options import Options
from mathpost.shop.post.steps import Moves, Plan, choose, crossing
from mathpost.shop.post.time_law import SlowDown, law_of, slow_down
from mathpost.shop.post.tool_path import xyz
from mathpost.shop.post.ways import Way, comparison

# A selection: name; cost; largest step of each rotary axis, degrees; why it is not possible.
Compared = tuple[str, float, tuple[float, ...], str]


@dataclass(frozen=True)
class Report(proof.Proof):
    """All that a person wants to know of a program before running it; ``print(report)`` shows it."""

    settings: dict[str, str]  # what the program was made with, as text
    time: float  # seconds, by the time law; 0 if neither feed nor rates are known
    time_law: str  # what it assumes of the control
    # Of each axis: greatest speed, mm or degrees, NaN if it moves in rapid traverse at a rate that the machine file
    # does not state, and acceleration, NaN without limit.
    peaks: dict[str, np.ndarray]
    slowest: SlowDown | None  # record (from 0) before which the tip loses most time, seconds asked, and taken
    warnings: tuple[str, ...]
    uncompensated: proof.Proof | None  # what the calibrated machine would do, had nothing been compensated
    strategies: tuple[Compared, ...]
    ways: dict[tuple[int, int], list[Way]]  # through each singular region (first and last record, from 0)

    def __str__(self) -> str:
        said, peaks = [*self.settings.items()], []
        for name, (speed, acceleration) in self.peaks.items():
            unit = "mm" if name in "XYZ" else "°"
            pulled = "" if np.isnan(acceleration) else f" {acceleration:.0f} {unit}/s²"
            if np.isnan(speed):
                peaks.append(f"{name} not known")
            elif speed > 0:
                peaks.append(f"{name} {speed:.1f} {unit}/s{pulled}")
        if self.time > 0:
            least = "at least " * any(np.isnan(speed) for speed, _ in self.peaks.values())
            said += [("time", f"{least}{self.time:.2f} s, {self.time_law}"), ("peaks", ", ".join(peaks))]
        if self.slowest:
            record, asked, taken = self.slowest
            said += [("slow-down", f"before record {record + 1}: {taken:.3f} s, the feed asks {asked:.3f} s")]
        along = f"{self.path_tip_error:.4f} mm along the path (most before record {self.worst_record})"
        said += [("tip error", f"{self.tip_error:.4f} mm at the records, {along}")]
        along = f"{self.path_axis_error:.4f}° from the arc along the path, lag {self.lag:.4f}°"
        said += [("axis error", f"{self.axis_error:.4f}° at the records, {along}")]
        if self.uncompensated:
            both = [(1e3 * each.tip_error, 3600 * each.axis_error) for each in (self.uncompensated, self)]
            before, after = (f"{tip:.1f} µm and {axis:.1f} arcsec" for tip, axis in both)
            said += [("volumetric", f"at the records {before} before compensation, {after} after it")]
        said += [("warning", warning) for warning in self.warnings]
        lines = [f"{key:<12} {one_line(str(value))}" for key, value in said]
        if self.strategies:
            lines += ["", f"{'selection':<14}{'cost':>10}  largest rotary steps"]
        for name, cost, steps, reason in self.strategies:
            figures = f"{cost:10.3f}  " + " ".join(f"{step:8.3f}°" for step in steps)
            lines.append(f"{name:<14}{reason or figures}")
        for region, through in self.ways.items():
            lines += ["", *comparison(region, through)]
        return "\n".join(lines)


def report_of(
    cl: CLData, machine: Machine, options: Options, plans: list[Plan], proofs: list[proof.Proof], *,
    rounding: float = 0.0, compare: bool = False,
) -> Report:  # fmt: skip
    """Return the `Report` of a program that was made by `plans`, one for each tool, and passed these proofs.

    The moves of the plans are those that were read back: what is timed is what is written. The control may round
    off `rounding`, mm.
    """
    times, each_peaks, slow = zip(*(_timed(each, options, rounding) for each in plans), strict=True)
    peaks, unknown = np.max(each_peaks, axis=0) * machine.units, np.zeros(len(machine.joint_names), bool)
    for blocks in (each.moves.blocks for each in plans):
        rapid = 1 + np.flatnonzero(blocks.rapid[1:])
        unknown |= (blocks.words[rapid] != blocks.words[rapid - 1]).any(axis=0) & np.isnan(machine.max_rates)
    peaks[0, unknown] = np.nan
    before = [each.uncompensated for each in plans if each.uncompensated]
    spindles = bool(commands(cl.remarks, "spindle"))
    return Report(
        **vars(worst_of(proofs)),
        settings=dict(_settings(cl, machine, options, plans)),
        time=sum(times) + sum(each.values[0] for _, each in commands(cl.remarks, "dwell")),
        time_law=BETWEEN_BLOCKS[options.control.between_blocks],
        peaks=dict(zip(machine.joint_names, peaks.T, strict=True)),
        slowest=max(filter(None, slow), key=lambda at: at[2] - at[1], default=None),
        warnings=tuple(
            dict.fromkeys(sentence for each in plans for sentence in _warnings(each, options, spindles))
        ),
        uncompensated=worst_of(before) if before else None,
        strategies=tuple(_strategies(plans, options)) if compare else (),
        ways=_ways(plans, options) if compare else {},
    )


def with_strokes(moves: Moves) -> tuple[Blocks, np.ndarray | None]:
    """Return the blocks of moves with strokes of pecks as blocks between them, and which are within an arc."""
    blocks = moves.blocks
    # For each row which one it is made of, and how much of the way to that it ends at.
    rows, parts, fast = [np.arange(len(blocks.words))], [np.ones(len(blocks.words))], [blocks.rapid]
    for stroke in moves.strokes:
        bottom = int(np.searchsorted(moves.motion.place, stroke.place))
        rows.append(np.full(len(stroke.parts), bottom))
        parts.append(stroke.parts)
        fast.append(stroke.rapid)
    row = np.concatenate(rows)
    own = np.arange(len(row)) < len(blocks.words)  # the end of a row comes after its strokes
    order = np.lexsort([np.arange(len(row)), own, row])
    row, part, rapid = row[order], np.concatenate(parts)[order][:, None], np.concatenate(fast)[order]
    made = blocks[row]
    before = blocks.words[np.maximum(row - 1, 0)]
    words = before + part * (blocks.words[row] - before)
    made = replace(made, words=words, rapid=rapid, feeds=np.where(rapid, np.nan, made.feeds))
    return made, None if moves.smooth is None else moves.smooth[row]


def worst_of(proofs: Sequence[proof.Proof]) -> proof.Proof:
    """Return the `Proof` that says the worst of several."""
    return proof.Proof(
        tip_error=max(each.tip_error for each in proofs),
        axis_error=max(each.axis_error for each in proofs),
        path_tip_error=max(each.path_tip_error for each in proofs),
        path_axis_error=max(each.path_axis_error for each in proofs),
        lag=max(each.lag for each in proofs),
        worst_record=max(proofs, key=lambda each: each.path_tip_error).worst_record,
    )


def _timed(plan: Plan, options: Options, rounding: float) -> tuple[float, np.ndarray, SlowDown | None]:
    """How long a plan takes, the peaks of its axes, and where it loses most time."""
    kin, moves = plan.path.kin, plan.moves
    asked, law = law_of(kin, moves.blocks, options.control, rounding, moves.smooth)
    seconds, peaks = law.seconds, law.peaks
    del law  # which holds the path once more
    slow = _slowest(plan, asked, seconds)
    if moves.strokes:
        pecked, smooth = with_strokes(moves)
        _, law = law_of(kin, pecked, options.control, rounding, smooth)
        seconds, peaks = law.seconds, law.peaks
    return seconds[-1], peaks, slow


def _slowest(plan: Plan, asked: np.ndarray, seconds: np.ndarray) -> SlowDown | None:
    """`slow_down` of a plan whose poses are reached at `seconds`, in records of the whole path."""
    motion, cl, moving = plan.moves.motion, plan.path.cl, asked > 0
    record = motion.record[1:]
    by_feed = np.where(motion.at_feed(cl), feed_times(cl.at(motion.place)[0], cl.feeds[record]), np.nan)
    return slow_down(plan.path.first + record[moving], np.diff(seconds), by_feed[moving])


def _settings(cl: CLData, machine: Machine, options: Options, plans: list[Plan]) -> Iterator[tuple[str, str]]:
    """Lines of the report: how the program was made, what else the CL data say, and what was made of it."""
    first_branch = sum(int((each.chosen.branch == 0).sum()) for each in plans)
    breaks = [each.path.first + record for each in plans for record in each.chosen.breaks]
    found = [(each.path.first + first, each.path.first + last) for each in plans for first, last in each.regions]
    shown = ", ".join([f"{first + 1}–{last + 1}" for first, last in found[:8]] + ["…"] * (len(found) > 8))
    cost = sum(each.chosen.cost for each in plans)
    unit = "mm and degrees of travel" if np.isnan(machine.max_rates).all() else "s"
    if unfed := int((np.isnan(cl.feeds) & ~cl.rapid).sum()):
        yield (
            "no feed",
            f"for {unfed} moves in cut: they have no F word, and the control's last one; --feed states one",
        )
    yield "CL data", f"{cl.name}, {len(cl)} records"
    yield "machine", f"{machine.name} ({machine.arrangement})"
    yield "selection", f"{options.strategy}, cost {cost:.3f} {unit}"
    yield "branches", f"first {first_branch}, second {len(cl) - first_branch}"
    yield "splits", ", ".join(f"before record {record + 1}" for record in breaks) or "none"
    yield "singular", f"records {shown}: {options.singular}" if found else "no region"
    yield "tolerance", f"{options.tolerance:g} mm, tool axis {np.degrees(options.axis_tolerance):g}°"
    yield "rotary", ", ".join(_range(joint.name, plans, 3 + n) for n, joint in enumerate(machine.rotary))
    lengths = [f"{path.kin.machine.tool_length:g} mm" for path in (each.path for each in plans)]
    stated = [length is not None for _, length, _ in cl.by_setup()]
    origins = ["CL data" if each else "machine file" for each in stated]
    yield "tool length", ", ".join(f"{length} ({of})" for length, of in zip(lengths, origins, strict=True))
    setups = {each.path.offset: each.path.kin.machine.origin for each in plans if each.path.offset is not None}
    offsets = [f"{number} at {xyz(origin)}" for number, origin in setups.items()]
    if offsets:
        yield "work offset", ", ".join(offsets)
    named = [f"{len(some)} of {kind}" for kind in ("stock", "fixture") if (some := getattr(machine, kind))]
    yield "solids", ", ".join(named) or "stock and fixture are not known: the machine file names none"
    yield (
        "program",
        f"{sum(len(each.moves.blocks.words) for each in plans)} moves, TCP {'on' if options.tcp else 'off'}",
    )
    texts = [each if isinstance(each, str) else each.statement for _, each in cl.remarks
             if isinstance(each, str) or each.kind in COMMENTS]  # fmt: skip
    comments = Counter(text.upper().replace("/", " ").split()[0] for text in texts)
    orders = Counter(each.kind for _, each in cl.remarks if isinstance(each, Command) and each.kind not in COMMENTS)
    for name, counts in (("comments", comments), ("commands", orders)):
        if counts:
            yield name, ", ".join(f"{word} {count}" for word, count in counts.most_common())
    if cl.coordinates not in ("", AS_WRITTEN):
        yield "coordinates", cl.coordinates
    if cl.notes:
        yield "made of it", "; ".join(cl.notes)


def _range(name: str, plans: list[Plan], joint: int) -> str:
    """The least and the greatest angle of a rotary axis, as text."""
    angles = np.degrees(np.concatenate([each.moves.motion.joints[:, joint] for each in plans]))
    return f"{name} {angles.min():.3f}° … {angles.max():.3f}°"


def _warnings(plan: Plan, options: Options, spindles: bool) -> Iterator[str]:
    """Sentences on what a person should look at in one of the plans; `spindles`: whether the CL data turn one."""
    path, motion = plan.path, plan.moves.motion
    if commands(path.cl.remarks, "compensation"):
        yield "cutter compensation: proved for a radius of 0 in the control's tool table"
    if commands(path.cl.remarks, "tool") and path.kin.machine.programmed_point != "tip" and not options.tcp:
        yield "X Y Z do not name the tip: the length of the tools has to be 0 in the control's tool table"
    slower = path.cl.rapid[motion.record] & ~plan.moves.blocks.rapid
    if slower.any():
        alone = "each axis would run at its own rate, and not every way is clear of what the path touches"
        yield f"blocks at a feed where the CL data are in rapid traverse, {slower.sum()}: {alone}"
    swings = np.degrees(np.abs(np.diff(plan.chosen.joints[:, 3:], axis=0)).max(axis=1))
    if swings.max(initial=0) > 90:
        record = path.first + int(swings.argmax())
        yield f"a rotary axis swings {swings.max():.1f}° from record {record + 1} to the next"
    moves = np.flatnonzero(motion.in_cut & ~motion.at_feed(path.cl))
    worst = np.degrees(deviation.strays(path.kin, path.cl, motion, moves)[1].max(initial=0))
    if worst > 0.1:
        yield f"rapid moves take the tool axis up to {worst:.1f}° off its great circle"
    if commands(path.cl.remarks, "tool") and not approaches(path.kin.machine, options):
        yield "the way from a change of the tool to the part is neither timed nor proved"
    for _, command in commands(path.cl.remarks, "coolant"):
        kind = command.values[-1]
        if not options.control.commands[f"coolant {kind}"]:
            yield f"coolant that stays off: a comment tells which {kind}, {options.control.name} has no word"
    holes = sum(isinstance(each, Hole) for each in path.cl.pieces)
    if options.tcp and options.control.cycles is not None and holes > plan.moves.cycles:
        kept = "controls take no drilling cycles while they keep the tip"
        yield f"holes that are straight moves, {holes - plan.moves.cycles} of {holes}: {kept}"
    turning = [record for record, spindle in commands(path.cl.remarks, "spindle") if spindle.values[-1] != "OFF"]
    cut = np.flatnonzero(~path.cl.rapid)
    changed = commands(path.cl.remarks, "tool")
    if spindles and changed and cut.size and not any(record <= cut[0] for record in turning):
        yield f"tool {changed[0][1].values[0]} cuts, and nothing switches the spindle on behind its change"
    if plan.moves.pecks.size and not plan.moves.strokes:
        yield "pecks of drilling cycles are the control's own: the time has none of them"
    if np.degrees(np.abs(motion.joints[:, 3:])).max() > 360 + 1e-6:
        yield "rotary words beyond 360°: right where the axis counts its turns, or takes the shorter way"
    yield from plan.cautions


def _strategies(plans: list[Plan], options: Options) -> Iterator[Compared]:
    """The rows of `Report.strategies`."""
    for name in selection.STRATEGIES:
        cost, swings, begin = 0.0, np.zeros(2), options.start
        try:
            for each in plans:
                chosen = choose(each.path, options, begin, strategy=name)
                steps = np.degrees(np.abs(np.diff(chosen.joints[:, 3:], axis=0)).max(axis=0, initial=0))
                cost, swings, begin = cost + chosen.cost, np.maximum(swings, steps), chosen.joints[-1]
        except MathpostError as error:
            yield name, np.nan, (), str(error)
            continue
        yield name, cost, tuple(swings.tolist()), ""


def _ways(plans: list[Plan], options: Options) -> dict[tuple[int, int], list[Way]]:
    """The `Report.ways`."""
    ways = {}
    for each in plans:
        for first, last in each.regions:
            through = crossing(each.path, each.chosen, (first, last), options)
            compared = through.compare(lean=options.lean, clearance=options.clearance)
            ways[each.path.first + first, each.path.first + last] = compared
    return ways
