"""From CL data to a verified NC program: `run` calls the modules of this room in turn.

Read `run` first, then `selection`, `singular` (and `ways` through it), `between_blocks`, `program` (with
`controls`), `proof`. The CL data are read in `mathpost.path`.
"""

from collections import Counter
from dataclasses import dataclass, replace
from functools import partial
from inspect import signature
from itertools import pairwise
from pathlib import Path

import numpy as np

from mathpost.compensate.compensation import Compensated, Compensator, PoseError
from mathpost.errors import InputError, MathpostError, ReachError
from mathpost.formula import slices
from mathpost.kinematics import Kinematics
from mathpost.machine import UNITS
from mathpost.path.cl import OPPOSITE, CLData, commands
from mathpost.post import between_blocks, program, proof, selection
from mathpost.post.between_blocks import Motion, linearize
from mathpost.post.singular import AXIS_TOLERANCE, CLEARANCE, LEAN, refuse_nonsense, regions
from mathpost.post.ways import Crossing, comparison, through_the_records, unbroken

TOLERANCE = 0.01  # mm; travel between the blocks is never looked at more coarsely
CONE = np.radians(1.0)  # about the singular tool axes
# Radians; how far the printed digits of both rotary axes may turn the tool axis, and what samples miss.
AXIS_DIGITS = np.radians(10.0**-program.DECIMALS) + proof.AXIS_RESOLUTION


@dataclass(frozen=True)
class Report(proof.Proof):
    """All that a person wants to know of a program before running it; ``print(report)`` shows it."""

    settings: dict  # what the program was made with, as text
    time: float  # seconds, by the time law; 0 if neither feed nor rates are known
    peaks: dict  # of each axis: greatest speed and acceleration, mm or degrees, NaN an acceleration without limit
    slowest: tuple | None  # record (from 0) before which the tip loses most time, seconds asked, and taken
    warnings: tuple
    uncompensated: proof.Proof | None  # what the calibrated machine would do, had nothing been compensated
    strategies: tuple  # name; cost; largest step of each rotary axis, degrees; why it is not possible
    ways: dict  # the ways through each singular region (first and last record, from 0), lists of `Way`

    def __str__(self):
        said, peaks = [*self.settings.items()], []
        for name, (speed, acceleration) in self.peaks.items():
            unit = "mm" if name in "XYZ" else "°"
            pulled = "" if np.isnan(acceleration) else f" {acceleration:.0f} {unit}/s²"
            if speed > 0:
                peaks.append(f"{name} {speed:.1f} {unit}/s{pulled}")
        if self.time > 0:
            said += [("time", f"{self.time:.2f} s"), ("peaks", ", ".join(peaks))]
        if self.slowest:
            record, asked, taken = self.slowest
            said += [("slow-down", f"before record {record + 1}: {taken:.3f} s, the feed asks {asked:.3f} s")]
        along = f"{self.path_tip_error:.4f} mm along the path (most before record {self.worst_record})"
        said += [("tip error", f"{self.tip_error:.4f} mm at the records, {along}")]
        along = f"{self.path_axis_error:.4f}° along the path"
        said += [("axis error", f"{self.axis_error:.4f}° at the records, {along}")]
        if self.uncompensated:
            both = [(1e3 * each.tip_error, 3600 * each.axis_error) for each in (self.uncompensated, self)]
            before, after = (f"{tip:.1f} µm and {axis:.1f} arcsec" for tip, axis in both)
            said += [("volumetric", f"at the records {before} before compensation, {after} after it")]
        said += [("warning", warning) for warning in self.warnings]
        lines = [f"{key:<12} {value}" for key, value in said]
        if self.strategies:
            lines += ["", f"{'selection':<14}{'cost':>10}  largest rotary steps"]
        for name, cost, steps, reason in self.strategies:
            figures = f"{cost:10.3f}  " + " ".join(f"{step:8.3f}°" for step in steps)
            lines.append(f"{name:<14}{reason or figures}")
        for region, through in self.ways.items():
            lines += ["", *comparison(region, through)]
        return "\n".join(lines)


@dataclass(frozen=True)
class Result:
    """A verified program and how it came about."""

    joints: np.ndarray  # chosen for the n records, shape (n, 5), mm and radians
    blocks: program.Blocks  # m moves, as read back from the program
    place: np.ndarray  # where each ends on the CL path, shape (m,): 2.25 is a quarter of the way from record 2 to 3
    program: str  # its text
    report: Report


def run(
    cl, machine, *, name=None, dialect="heidenhain", tcp=False, tolerance=TOLERANCE, axis_tolerance=AXIS_TOLERANCE,
    strategy="optimal", start=None, prefer=None, split=False, singular="direct", cone=CONE, lean=LEAN,
    clearance=CLEARANCE, errors=None, compare=False, progress=None, **unknown,
):  # fmt: skip
    """Post-process CL data into a verified program, as `Result`.

    No program is handed out unverified: its own text is read back, sent through the forward kinematics and compared
    with the CL data, at the records and along the path that the joints really run between the blocks.

    Parameters
    ----------
    cl : CLData
    machine : Machine
    name, dialect : str
        Of the program, by default that of the CL file; and ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    tcp : bool
        Whether the control keeps the tip (M128, G43.4, TRAORI): X Y Z are then the tip in the workpiece.
    tolerance, axis_tolerance : float
        mm, how far the tip may be from the CL path, and radians, the tool axis from its great circle between two
        records, everything included. Moves in cut are divided until they keep both, without TCP that of the tip;
        a way that leaves the circle on purpose is refused if it needs more.
    strategy, start, prefer, split
        As in `mathpost.post.selection.choose`; at a split the tool is retracted, unwound and returned.
    singular, lean, clearance : str, float, float
        The way through singular regions, and how: see `mathpost.post.ways.Crossing.way`, but for the audit's.
    cone : float or None
        Radians about the singular tool axes; None lets feed and rates decide. See `mathpost.post.singular.regions`.
    errors : mathpost.compensate.model.MachineErrors, optional
        What was measured on the machine: the program is compensated for it, and verified on the machine as it is.
    compare : bool
        Whether the report compares all strategies, and all ways through each region.
    progress : callable, optional
        Called with a word for each stage that begins.

    Raises
    ------
    InputError
        If an option is not known, the errors are those of another machine, or the printed digits alone may use up
        a tolerance.
    ReachError
        If the tool axis, a joint, or a way through a singular region is out of reach, with the record.
    MathpostError
        If the program does not pass its proof, `mathpost.post.proof.prove`.

    Examples
    --------
    >>> import mathpost
    >>> result = run(mathpost.read_cl("data/cl/blade.cl"), mathpost.load_machine("dmu50v"))
    >>> print("\\n".join(result.program.splitlines()[:4]))
    0 BEGIN PGM BLADE MM
    1 ; MOTION ONLY: THE MACHINE FILE GIVES NO HEAD AND NO FOOT
    2 L X-36.7809 Y-68.5751 Z+66.1338 B+11.8172 C+175.8146
    3 L X-38.5803 Y-67.4446 Z+64.5272 B+10.3971 C+176.3180
    >>> result.report.tip_error < 0.01
    True
    """
    if unknown:
        known = [name for name, each in signature(run).parameters.items() if each.kind is each.KEYWORD_ONLY]
        raise InputError("run", f"the options {', '.join(known)}", ", ".join(unknown))
    if singular not in Crossing.SAFE:
        raise InputError("singular", " or ".join(Crossing.SAFE), repr(singular))
    if not 0 < tolerance < np.inf:
        raise InputError("tolerance", "mm above 0", repr(tolerance))
    if not 2 * AXIS_DIGITS <= axis_tolerance < np.inf:
        expected = f"at least {np.degrees(2 * AXIS_DIGITS):.4f}°, for words of {program.DECIMALS} decimals"
        raise InputError("axis_tolerance", expected, f"{np.degrees(axis_tolerance):g}°")
    if cone is not None and not 0 < cone < np.pi:
        raise InputError("cone", "radians above 0 and below π, or none", repr(cone))
    if errors is not None and errors.machine != machine:
        raise InputError("errors", f"those of {machine.name!r}, set up alike", repr(errors.machine.name))
    refuse_nonsense(lean, clearance)
    program.control_for(machine, dialect)  # refuses what cannot be written before the work
    progress, name = progress or (lambda stage: None), name or Path(cl.name).stem
    tools, real = cl.by_tool(), None if errors is None else Compensator(errors)
    if real is not None and any(length not in (None, machine.tool_length) for _, length in tools):
        raise InputError("errors", f"one tool, {machine.tool_length:g} mm long", "CL data with other lengths")

    plans, lifting, tolerances = [], {"lean": lean, "clearance": clearance}, (tolerance, axis_tolerance)
    choosing = {"prefer": prefer, "sway": axis_tolerance / 2}
    for part, length in tools:
        _refuse_turns_by_180(part)
        kin = Kinematics(machine if length is None else machine.with_setup(tool_length=length))
        progress("choosing")
        begin = plans[-1].chosen.joints[-1] if plans else start
        chosen = selection.choose(kin, part, strategy, split=split, start=begin, **choosing)
        found = regions(kin, part, chosen.joints, cone=cone)
        progress("planning")
        first = part.first - cl.first
        plans.append(_plan(kin, part, first, chosen, found, singular, lifting, tolerances, tcp, real))

    progress("writing")
    text = program.write(program.joined([each.blocks for each in plans]), machine, dialect, name=name)

    progress("reading back")
    blocks = program.read(text, machine, dialect, name=name)

    progress("proving")
    edges = [0, *np.cumsum([len(each.blocks.words) for each in plans[:-1]], dtype=int), None]
    proofs = []
    for each, edge in zip(plans, pairwise(edges), strict=True):
        found = proof.prove(each.kin, each.cl, blocks[slice(*edge)], each.motion, *tolerances, real=real)
        proofs.append(replace(found, worst_record=each.first + found.worst_record))
    before = [each.uncompensated for each in plans if each.uncompensated]

    strategies, through = (), {}
    if compare:
        progress("comparing")
        strategies = tuple(_strategies(plans, start, choosing))
        for each in plans:
            for first, last in each.regions:
                through[each.first + first, each.first + last] = each.crossing((first, last)).compare(**lifting)
    peaks = np.max([each.law.peaks for each in plans], axis=0) * UNITS
    report = Report(
        **vars(proof.worst_of(proofs)),
        settings=dict(_settings(cl, machine, plans, singular, tolerances, blocks)),
        time=sum(each.law.seconds[-1] for each in plans),
        peaks=dict(zip(machine.joint_names, peaks.T, strict=True)),
        slowest=max((each.slowest for each in plans if each.slowest), key=lambda at: at[2] - at[1], default=None),
        warnings=tuple(dict.fromkeys(sentence for each in plans for sentence in _warnings(each))),
        uncompensated=proof.worst_of(before) if before else None,
        strategies=strategies,
        ways=through,
    )
    joints = np.concatenate([each.chosen.joints for each in plans])
    place = np.concatenate([each.first + each.motion.place for each in plans])
    return Result(joints, blocks, place, text, report)


@dataclass(frozen=True)
class Plan:
    """What one tool does, on its part of the path; records are counted from 0 within it."""

    kin: Kinematics  # of the machine with this tool
    cl: CLData
    first: int  # how many records of the path come before
    chosen: selection.Selection
    regions: list  # the singular ones, first and last record
    crossing: object  # makes the `Crossing` of a region
    motion: Motion  # where the machine goes
    blocks: program.Blocks  # to be written
    law: between_blocks.TimeLaw  # of the moves
    slowest: tuple | None  # from `between_blocks.slow_down`, in records of the whole path
    uncompensated: proof.Proof | None  # of the machine as it was measured, had nothing been compensated
    cautions: tuple


def _plan(kin, cl, first, chosen, found, way, lifting, tolerances, tcp, real):
    """The `Plan` of the chosen joints, `way` through the singular regions `found`.

    First the tool axis must keep to its great circle, then the tip to the CL path; travel is looked at between the
    records, too. With TCP the control divides the moves itself.
    """
    tolerance, room = tolerances[0], tolerances[1] - AXIS_DIGITS
    crossing = partial(Crossing, kin, cl, chosen.joints, tolerance=tolerance / 2, axis_tolerance=room)
    passed = unbroken(found, chosen.breaks) if way != "direct" else ()
    ways = [crossing(region).possible(way, **lifting) for region in passed]
    ways += [crossing((record - 1, record)).possible("retract", **lifting) for record in chosen.breaks]
    going, taken = Motion.on_part(chosen.joints, np.arange(len(cl))), np.zeros(len(cl), bool)
    if ways:
        going = through_the_records(chosen.joints, ways)
    for each in ways:  # they go as they do
        taken[int(each.place[0]) : int(each.place[-1])] = True
    free = taken[np.floor(going.place[:-1]).astype(int)]
    going = between_blocks.follow(kin, cl, going, room, free=free)
    block, keep = f"{cl.name}, block", _left_for_the_tip(kin, cl, going, tolerance, tcp)
    keep = between_blocks.in_the_air(going, keep, lifting["clearance"])
    divided = linearize(kin, going, keep, name=block)
    between = divided if tolerance <= TOLERANCE else linearize(kin, going, TOLERANCE, name=block)
    _refuse_out_of_travel(kin.machine, cl, between)
    going, before, cautions = going if tcp else divided, None, ()
    if real is not None:
        ideal, blocks, *_ = program.from_motion(kin, cl, going, tcp)
        before = proof.measured(kin, cl, blocks, ideal, real=real)
        going, cautions = _compensated(real, going)
        _refuse_out_of_travel(kin.machine, cl, going)
    going, blocks, asked, by_feed = program.from_motion(kin, cl, going, tcp)
    program.refuse_turning_compensation(cl, kin.machine, blocks)
    law, moving = between_blocks.time_law(kin.machine, going.joints, asked), asked > 0
    slowest = between_blocks.slow_down(first + going.record[1:][moving], np.diff(law.seconds), by_feed[moving])
    return Plan(kin, cl, first, chosen, found, crossing, going, blocks, law, slowest, before, cautions)


def _refuse_turns_by_180(cl):
    """Raise `InputError` where the tool axis turns over in cut: no great circle is shorter than another there."""
    turned = np.flatnonzero(np.linalg.norm(cl.axes[1:] + cl.axes[:-1], axis=1) < OPPOSITE)
    if turned.size:
        expected = "a tool axis not opposite to the one before, or RAPID"
        raise InputError(cl.where(turned[0] + 1), expected, "a turn by 180°")


def _left_for_the_tip(kin, cl, motion, tolerance, tcp):
    """What digits and samples leave of the tolerance of the tip, mm, for each move."""
    tip, _ = cl.at(motion.place)  # on the path, or lifted by so little that it does not count here
    lever = proof.levers(kin.machine) + np.linalg.norm(tip, axis=1)
    turned = 2 * np.radians(1.0) * lever * (not tcp)  # with TCP the angles do not move the tip
    moved = 0.5 * 10.0**-program.DECIMALS * (np.sqrt(3) + turned) + proof.RESOLUTION
    if (worst := moved.max()) > tolerance / 2:
        expected = f"at least {2 * worst:.4f} mm, for words of {program.DECIMALS} decimals on this machine"
        raise InputError("tolerance", expected, f"{tolerance}")
    return tolerance - np.maximum(moved[:-1], moved[1:])


def _refuse_out_of_travel(machine, cl, motion):
    """Raise `ReachError` for the first pose, those between the records included, that is out of travel."""
    out = np.flatnonzero(~machine.within(motion.joints).all(axis=1))
    if out.size:
        sentences = machine.out_of_travel(motion.joints[out[0]])
        raise ReachError(f"{cl.where(int(motion.place[out[0]]))} and on: {'; '.join(sentences)}")


def _compensated(real, motion):
    """The motion compensated for the errors of the machine, and sentences on what could not be."""
    parts = [real.compensate(motion.joints[rows]) for rows in slices(motion.joints.shape[:1])]
    columns = [(each.joints, each.after.tip, each.after.axis, each.limited, each.refused) for each in parts]
    joints, tip, axis, *what = (np.concatenate(column) for column in zip(*columns, strict=True))
    found = Compensated(joints, parts[0].before, PoseError(tip, axis), *what)
    return replace(motion, joints=joints), found.cautions


def _settings(cl, machine, plans, way, tolerances, blocks):
    """Lines of the report: how the program was made, what else the CL data say, and what was made of it."""
    first_branch = sum(int((each.chosen.branch == 0).sum()) for each in plans)
    breaks = [each.first + record for each in plans for record in each.chosen.breaks]
    found = [(each.first + first, each.first + last) for each in plans for first, last in each.regions]
    shown = ", ".join([f"{first + 1}–{last + 1}" for first, last in found[:8]] + ["…"] * (len(found) > 8))
    cost, rates = sum(each.chosen.cost for each in plans), machine.max_rates
    unit = "mm and degrees of travel" if np.isnan(rates).all() else "s"
    yield "CL data", f"{cl.name}, {len(cl)} records"
    yield "machine", f"{machine.name} ({machine.arrangement})"
    yield "selection", f"{plans[0].chosen.strategy}, cost {cost:.3f} {unit}"
    yield "branches", f"first {first_branch}, second {len(cl) - first_branch}"
    yield "splits", ", ".join(f"before record {record + 1}" for record in breaks) or "none"
    yield "singular", f"records {shown}: {way}" if found else "no region"
    yield "tolerance", f"{tolerances[0]:g} mm, tool axis {np.degrees(tolerances[1]):g}°"
    yield "program", f"{len(blocks.words)} moves, TCP {'on' if blocks.tcp else 'off'}"
    remarks = [remark for _, remark in cl.remarks]
    comments = Counter(remark.upper().replace("/", " ").split()[0] for remark in remarks if isinstance(remark, str))
    orders = Counter(remark.kind for remark in remarks if not isinstance(remark, str))
    for name, counts in (("comments", comments), ("commands", orders)):
        if counts:
            yield name, ", ".join(f"{word} {count}" for word, count in counts.most_common())
    if cl.notes:
        yield "made of it", "; ".join(cl.notes)


def _warnings(each):
    """Sentences on what a person should look at in one of the plans."""
    cl, joints = each.cl, each.chosen.joints
    if commands(cl.remarks, "compensation"):
        yield "cutter compensation: proved for a radius of 0 in the control's tool table"
    if commands(cl.remarks, "tool") and each.kin.machine.programmed_point != "tip":
        yield "X Y Z do not name the tip: the length of the tools has to be 0 in the control's tool table"
    if (np.isnan(cl.feeds) & ~cl.rapid).any():
        yield "the CL data state no feed for some moves; they carry no F word"
    swings = np.degrees(np.maximum(*(np.abs(np.diff(joint)) for joint in joints.T[3:])))
    if swings.max(initial=0) > 90:
        record = each.first + int(swings.argmax())
        yield f"a rotary axis swings {swings.max():.1f}° from record {record + 1} to the next"
    rapid = np.flatnonzero(each.motion.in_cut & ~each.motion.at_feed(cl))
    worst = np.degrees(proof.strays(each.kin, cl, each.motion, rapid)[1].max(initial=0))
    if worst > 0.1:
        yield f"rapid moves take the tool axis up to {worst:.1f}° off its great circle"
    yield from each.cautions


def _strategies(plans, start, choosing):
    """The rows of `Report.strategies`."""
    for name in selection.STRATEGIES:
        cost, swings, begin = 0.0, np.zeros(2), start
        try:
            for each in plans:
                chosen = selection.choose(each.kin, each.cl, name, start=begin, **choosing)
                steps = np.degrees(np.abs(np.diff(chosen.joints[:, 3:], axis=0)).max(axis=0, initial=0))
                cost, swings, begin = cost + chosen.cost, np.maximum(swings, steps), chosen.joints[-1]
        except MathpostError as error:
            yield name, np.nan, (), str(error)
            continue
        yield name, cost, tuple(swings), ""
