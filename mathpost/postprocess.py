"""From CL data to a verified program: selection, the singular region, linearization, output, and the proof.

No program is handed out unverified. Its own text is read back, sent through the forward kinematics and compared
with the CL data, at the records and along the path that the joints really run between the blocks.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mathpost import program, selection
from mathpost.compensation import Compensator
from mathpost.errors import InputError, MathpostError, ReachError
from mathpost.kinematics import Kinematics
from mathpost.linearization import deviation, linearize
from mathpost.passage import CLEARANCE, LEAN, Crossing, block_times, in_cut
from mathpost.report import Report, Verification
from mathpost.singularity import regions

TOLERANCE = 0.01  # mm
CONE = np.radians(1.0)  # about the singular tool axes


@dataclass(frozen=True)
class Result:
    """A verified program and how it came about.

    Attributes
    ----------
    joints : ndarray, shape (n, 5)
        The joints chosen for the n records, mm and radians.
    blocks : mathpost.program.Blocks
        The moves as read back from the program.
    place : ndarray, shape (m,)
        Where each block ends on the CL path: 2.25 is a quarter of the way from record 2 to record 3.
    program : str
        The text.
    report : Report
    """

    joints: np.ndarray
    blocks: program.Blocks
    place: np.ndarray
    program: str
    report: Report


@dataclass(frozen=True)
class Motion:
    """The poses that the machine runs through: joints, place on the CL path, whether lifted off the part."""

    joints: np.ndarray
    place: np.ndarray
    lifted: np.ndarray

    def replaced(self, passage):
        """Put a `Passage` in the place of what lies between its ends."""
        before, after = self.place < passage.place[0], self.place > passage.place[-1]
        parts = zip(
            (self.joints, self.place, self.lifted), (passage.joints, passage.place, passage.lifted), strict=True
        )
        return Motion(*(np.concatenate([old[before], new, old[after]]) for old, new in parts))

    def linearized(self, kin, tolerance, cl):
        """Divide the moves until the tip keeps `tolerance`."""
        divided = linearize(kin, self.joints, tolerance, name=f"{cl.name}, block")
        place = np.interp(divided.place, np.arange(len(self.place)), self.place)
        before, after = np.floor(divided.place).astype(int), np.ceil(divided.place).astype(int)
        return Motion(divided.joints, place, self.lifted[before] | self.lifted[after])


def run(
    cl,
    machine,
    *,
    dialect="heidenhain",
    strategy="optimal",
    singular="direct",
    tolerance=TOLERANCE,
    tcp=False,
    split=False,
    start=None,
    prefer=None,
    cone=CONE,
    lean=LEAN,
    clearance=CLEARANCE,
    compare=True,
    name=None,
    errors=None,
):
    """Post-process CL data into a verified program.

    Parameters
    ----------
    cl : CLData
    machine : Machine
    dialect : str
        ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    strategy, start, prefer, split
        As in `mathpost.selection.choose`; at a split the tool is retracted, unwound and returned.
    singular : str
        The way through singular regions, one of `Crossing.SAFE`.
    tolerance : float
        mm; how far the tip may be from the CL path, everything included. Without TCP the moves are divided until
        they keep it.
    tcp : bool
        Whether the control keeps the tip (M128, G43.4, TRAORI): X Y Z are then the tip in the workpiece.
    cone : float or None
        Radians about the singular tool axes; None lets feed and rates decide. See `mathpost.singularity.regions`.
    lean, clearance : float
        Radians and mm; see `Crossing.way`.
    compare : bool
        Whether the report compares all strategies, and all ways through each region.
    name : str, optional
        Program name; by default that of the CL file.
    errors : mathpost.machine_errors.MachineErrors, optional
        What was measured on the machine: the program is compensated for it, and verified on the machine as it is.

    Returns
    -------
    Result

    Raises
    ------
    ReachError
        If the tool axis, a joint or the path is out of reach, with the record.
    InputError
        If an option is not known.

    Examples
    --------
    >>> from mathpost import cldata, machine
    >>> result = run(cldata.read("data/cl/blade.cl"), machine.load("data/machines/dmu50v.toml"))
    >>> print("\\n".join(result.program.splitlines()[:4]))
    0 BEGIN PGM BLADE MM
    1 L X-36.7809 Y-68.5751 Z+66.1338 B+11.8172 C+175.8146
    2 L X-38.5803 Y-67.4446 Z+64.5272 B+10.3971 C+176.3180
    3 L X-40.3337 Y-66.2876 Z+62.8983 B+8.9770 C+176.8215
    >>> result.report.tip_error < 0.01
    True
    """
    program.dialect_named(dialect)
    if singular not in Crossing.SAFE:
        raise InputError("singular", " or ".join(Crossing.SAFE), repr(singular))
    if not tolerance > 0:
        raise InputError("tolerance", "mm above 0", repr(tolerance))
    kin = Kinematics(machine)
    chosen = selection.choose(kin, cl, strategy, start=start, split=split, prefer=prefer)
    found = regions(kin, cl, chosen.joints, cone=cone)
    motion = Motion(chosen.joints, np.arange(len(cl), dtype=float), np.zeros(len(cl), bool))
    crossings = {region: Crossing(kin, cl, chosen.joints, region, tolerance=tolerance / 2) for region in found}
    options = {"lean": lean, "clearance": clearance}
    if singular != "direct":
        for crossing in crossings.values():
            motion = motion.replaced(_possible(crossing.way(singular, **options)))
    for record in chosen.breaks:
        crossing = Crossing(kin, cl, chosen.joints, (record - 1, record), tolerance=tolerance / 2)
        motion = motion.replaced(crossing.way("retract", **options))

    linear = motion.linearized(kin, tolerance - _rounding(kin, motion.joints, tolerance), cl)
    _refuse_out_of_travel(machine, cl, linear)
    real, moves, uncompensated, cautions = kin, motion if tcp else linear, None, ()
    if errors is not None:
        real, moves, uncompensated, cautions = _compensated(kin, cl, moves, errors, tcp)
    motion, words = _thinned(moves, kin, tcp)
    text = program.write(_blocks(kin, cl, motion, words, tcp), machine, dialect, name=name or Path(cl.name).stem)
    blocks = program.read(text, machine, dialect)
    proof = verify(kin, cl, blocks, motion, real=real)
    if not (proof.tip_error <= tolerance and proof.path_tip_error <= tolerance):
        worst = max(proof.tip_error, proof.path_tip_error)
        raise MathpostError(f"{cl.name}: the program is {worst:.6f} mm off the CL path, more than {tolerance} mm")
    report = Report(
        verification=proof,
        settings=_settings(cl, machine, chosen, crossings, singular, tolerance, blocks),
        time=_time(kin, cl, motion),
        uncompensated=uncompensated,
        warnings=(*_warnings(cl, chosen), *cautions),
        strategies=tuple(_compare_strategies(kin, cl, start, prefer)) if compare else (),
        passages={region: crossing.compare(**options) for region, crossing in crossings.items()} if compare else {},
    )
    return Result(chosen.joints, blocks, motion.place, text, report)


def verify(kin, cl, blocks, motion, *, samples=None, real=None):
    """Compare a program's blocks with the CL data, at the records and along the path between the blocks.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    blocks : mathpost.program.Blocks
        As read back from the text.
    motion : Motion
        Where on the CL path each block ends, and which are lifted off the part.
    samples : int, optional
        Intervals between two blocks; see `mathpost.linearization.deviation`.
    real : Kinematics or Compensator, optional
        The forward kinematics of the machine that runs the program, if not those of its control.

    Returns
    -------
    Verification
    """
    real = kin if real is None else real
    if len(blocks.words) != len(motion.place):
        raise MathpostError(f"{len(motion.place)} blocks were written and {len(blocks.words)} read back")
    joints = blocks.joints
    if blocks.tcp:
        joints = kin.close(joints[:, :3], joints[:, 3:])
    tip, axis = real.forward(joints)
    # A record whose block was left out as a repetition has the pose of the block before.
    on_part = np.flatnonzero(~motion.lifted)
    at = on_part[np.searchsorted(motion.place[on_part], np.arange(len(cl)), side="right") - 1]
    tips, axes = cl.at(motion.place)
    steps = slice(None, -1), slice(1, None)
    path_tip, path_axis = deviation(
        real,
        *(joints[part] for part in steps),
        tips=[tips[part] for part in steps],
        axes=[axes[part] for part in steps],
        samples=samples,
    )
    if blocks.tcp:  # the control keeps the tip on the straight line between the blocks
        path_tip = np.linalg.norm(tip - tips, axis=1)[1:]
    cut = in_cut(motion.lifted)
    worst = int(np.argmax(np.where(cut, path_tip, 0))) if len(cut) else -1
    return Verification(
        tip_error=float(np.linalg.norm(tip[at] - cl.points, axis=1).max()),
        axis_error=float(np.degrees(_angle(axis[at], cl.axes).max())),
        path_tip_error=float(path_tip[cut].max(initial=0)),
        path_axis_error=float(np.degrees(path_axis[cut].max(initial=0))),
        worst_record=int(np.ceil(motion.place[worst + 1])) + 1,
    )


def _angle(first, second):
    return 2 * np.arcsin(np.clip(np.linalg.norm(first - second, axis=-1) / 2, 0, 1))


def _possible(passage):
    if passage.reason:
        raise ReachError(f"no way {passage.name!r} through the singular region: {passage.reason}")
    return passage


def _rounding(kin, joints, tolerance):
    """Return how far the printed digits alone may move the tip; refuse a tolerance that leaves no room for it."""
    arm = np.abs(kin.forward(joints)[0] - joints[:, :3]).max() + np.abs(joints[:, :3]).max()
    digit = 0.5 * 10.0**-program.DECIMALS
    moved = digit * (np.sqrt(3) + 2 * np.radians(1.0) * arm)
    if moved > tolerance / 2:
        expected = f"at least {2 * moved:.4f} mm, for words of {program.DECIMALS} decimals on this machine"
        raise InputError("tolerance", expected, f"{tolerance}")
    return moved


def _refuse_out_of_travel(machine, cl, motion):
    """Check every pose, those between the records included."""
    limits = machine.limits + selection.TRAVEL_TOLERANCE * np.array([-1, 1])
    out = np.flatnonzero(((motion.joints < limits[:, 0]) | (motion.joints > limits[:, 1])).any(axis=1))
    if out.size:
        sentences = selection.out_of_travel(machine, motion.joints[out[0]])
        raise ReachError(f"{cl.where(int(motion.place[out[0]]))} and on: {'; '.join(sentences)}")


def _compensated(kin, cl, motion, errors, tcp):
    """The calibrated machine, the motion made for it, how it would miss without that, and what is left to say."""
    machine = kin.machine
    if errors.machine != machine:
        raise InputError("errors", f"those of {machine.name!r}, set up alike", f"{errors.machine.name!r}")
    real = Compensator(errors)
    plain, words = _thinned(motion, kin, tcp)
    uncompensated = verify(kin, cl, _blocks(kin, cl, plain, words, tcp), plain, real=real)
    compensated = real.compensate(motion.joints)
    motion = replace(motion, joints=compensated.joints)
    _refuse_out_of_travel(machine, cl, motion)
    return real, motion, uncompensated, compensated.cautions


def _thinned(motion, kin, tcp):
    """Round to what will be printed, and leave out poses that repeat all words of the one before."""
    joints = motion.joints
    if tcp:
        joints = np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1)
    words = program.rounded(joints)
    keep = np.r_[True, (np.diff(words, axis=0) != 0).any(axis=1)]
    return Motion(motion.joints[keep], motion.place[keep], motion.lifted[keep]), words[keep]


def _blocks(kin, cl, motion, words, tcp):
    """Feeds, inverse times and remarks for the words of a program."""
    record = np.ceil(motion.place).astype(int)
    feeds, rapid = cl.feeds[record], cl.rapid[record]
    rotary_moves = np.r_[False, (np.diff(words[:, 3:], axis=0) != 0).any(axis=1)]
    seconds = np.r_[np.nan, block_times(kin, cl, motion.joints, motion.place, in_cut(motion.lifted))]
    inverse = rotary_moves & ~np.isnan(feeds) & ~rapid & (not tcp)
    # A remark stands before the first block of the move to its record.
    remarks = [(int(np.searchsorted(motion.place, record - 1, side="right")), text) for record, text in cl.remarks]
    return program.Blocks(words, feeds, np.where(inverse, seconds, np.nan), rapid, tcp, tuple(remarks))


def _time(kin, cl, motion):
    return float(block_times(kin, cl, motion.joints, motion.place, in_cut(motion.lifted)).sum())


def _settings(cl, machine, chosen, crossings, singular, tolerance, blocks):
    first = int((chosen.branch == 0).sum())
    unit = "s" if not np.isnan(machine.max_rates).all() else "mm and degrees of travel"
    ranges = ", ".join(f"{a + 1}–{b + 1}" for a, b in list(crossings)[:8]) + (", …" if len(crossings) > 8 else "")
    return {
        "CL data": f"{cl.name}, {len(cl)} records",
        "machine": f"{machine.name} ({machine.arrangement})",
        "selection": f"{chosen.strategy}, cost {chosen.cost:.3f} {unit}",
        "branches": f"first {first}, second {len(cl) - first}",
        "splits": ", ".join(f"before record {record + 1}" for record in chosen.breaks) or "none",
        "singular": f"records {ranges}: {singular}" if crossings else "no region",
        "tolerance": f"{tolerance:g} mm",
        "program": f"{len(blocks.words)} moves, TCP {'on' if blocks.tcp else 'off'}",
    }


def _warnings(cl, chosen):
    if np.isnan(cl.feeds[~cl.rapid]).any():
        yield "the CL data state no feed for some moves; they carry no F word"
    steps = np.degrees(np.abs(np.diff(chosen.joints[:, 3:], axis=0)))
    if len(steps) and steps.max() > 90:
        yield f"a rotary axis swings {steps.max():.1f}° from record {steps.max(axis=1).argmax() + 1} to the next"


def _compare_strategies(kin, cl, start, prefer):
    for name in selection.STRATEGIES:
        try:
            chosen = selection.choose(kin, cl, name, start=start, prefer=prefer)
        except MathpostError as error:
            yield name, np.nan, (), str(error)
            continue
        steps = np.degrees(np.abs(np.diff(chosen.joints[:, 3:], axis=0)).max(axis=0, initial=0))
        yield name, chosen.cost, tuple(steps), ""
