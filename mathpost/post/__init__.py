"""From CL data to a verified NC program: `run` calls the modules of this room in turn.

Read `run` first, then `cl`, `selection` (beside it `travel` and `yu_dan`), `singular` (and `ways` through it),
`between_blocks`, `program` (and `text`), `proof`.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mathpost.compensate.compensation import Compensated, Compensator, PoseError
from mathpost.errors import InputError, MathpostError, ReachError
from mathpost.kinematics import Kinematics
from mathpost.post import controls, program, selection, travel
from mathpost.post.between_blocks import levers
from mathpost.post.motion import Motion, block_times, linearize
from mathpost.post.proof import Report, measured, prove
from mathpost.post.singular import regions
from mathpost.post.ways import CLEARANCE, LEAN, Crossing, refuse_nonsense
from mathpost.rotation import blocks as slices

TOLERANCE = 0.01  # mm
CONE = np.radians(1.0)  # about the singular tool axes


@dataclass(frozen=True)
class Result:
    """A verified program and how it came about.

    Attributes
    ----------
    joints : ndarray, shape (n, 5)
        The joints chosen for the n records, mm and radians.
    blocks : mathpost.post.program.Blocks
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


def run(
    cl,
    machine,
    *,
    name=None,
    dialect="heidenhain",
    tcp=False,
    tolerance=TOLERANCE,
    strategy="optimal",
    start=None,
    prefer=None,
    split=False,
    singular="direct",
    cone=CONE,
    lean=LEAN,
    clearance=CLEARANCE,
    errors=None,
    compare=False,
    progress=None,
):
    """Post-process CL data into a verified program.

    No program is handed out unverified: its own text is read back, sent through the forward kinematics and compared
    with the CL data, at the records and along the path that the joints really run between the blocks.

    Parameters
    ----------
    cl : CLData
    machine : Machine
    name : str, optional
        Program name; by default that of the CL file.
    dialect : str
        ``"heidenhain"``, ``"fanuc"`` or ``"siemens"``.
    tcp : bool
        Whether the control keeps the tip (M128, G43.4, TRAORI): X Y Z are then the tip in the workpiece.
    tolerance : float
        mm; how far the tip may be from the CL path, everything included. Without TCP the moves are divided until
        they keep it.
    strategy, start, prefer, split
        As in `mathpost.post.selection.choose`; at a split the tool is retracted, unwound and returned.
    singular : str
        The way through singular regions, one of `mathpost.post.ways.Crossing.SAFE`.
    cone : float or None
        Radians about the singular tool axes; None lets feed and rates decide. See `mathpost.post.singular.regions`.
    lean, clearance : float
        Radians and mm, above 0; see `mathpost.post.ways.Crossing.way`.
    errors : mathpost.compensate.machine_errors.MachineErrors, optional
        What was measured on the machine: the program is compensated for it, and verified on the machine as it is.
    compare : bool
        Whether the report compares all strategies, and all ways through each region.
    progress : callable, optional
        Called with a word for each stage that begins.

    Returns
    -------
    Result

    Raises
    ------
    InputError
        If an option is not known, the errors are those of another machine, or the printed digits alone may use up
        the tolerance.
    ReachError
        If the tool axis, a joint, or a way through a singular region is out of reach, with the record.
    MathpostError
        If the program does not pass its proof; see `mathpost.post.proof.prove`.

    Examples
    --------
    >>> from mathpost import machine
    >>> from mathpost.post import cl as cldata
    >>> result = run(cldata.read("data/cl/blade.cl"), machine.load("data/machines/dmu50v.toml"))
    >>> print("\\n".join(result.program.splitlines()[:4]))
    0 BEGIN PGM BLADE MM
    1 L X-36.7809 Y-68.5751 Z+66.1338 B+11.8172 C+175.8146
    2 L X-38.5803 Y-67.4446 Z+64.5272 B+10.3971 C+176.3180
    3 L X-40.3337 Y-66.2876 Z+62.8983 B+8.9770 C+176.8215
    >>> result.report.tip_error < 0.01
    True
    """
    if singular not in Crossing.SAFE:
        raise InputError("singular", " or ".join(Crossing.SAFE), repr(singular))
    if not tolerance > 0:
        raise InputError("tolerance", "mm above 0", repr(tolerance))
    if errors is not None and errors.machine != machine:
        raise InputError("errors", f"those of {machine.name!r}, set up alike", repr(errors.machine.name))
    refuse_nonsense(lean, clearance)
    controls.control_for(machine, dialect)  # refuses what cannot be written before the work
    progress, name = progress or (lambda stage: None), name or Path(cl.name).stem
    kin, real = Kinematics(machine), None if errors is None else Compensator(errors)

    progress("choosing")
    chosen = selection.choose(kin, cl, strategy, start=start, prefer=prefer, split=split)
    singular_regions = regions(kin, cl, chosen.joints, cone=cone)

    progress("planning")
    options = {"lean": lean, "clearance": clearance}

    def crossing(region):
        return Crossing(kin, cl, chosen.joints, region, tolerance=tolerance / 2)

    ways = [crossing((record - 1, record)).possible("retract", **options) for record in chosen.breaks]
    if singular != "direct":
        ways += [
            crossing(part).possible(singular, **options) for part in _unbroken(singular_regions, chosen.breaks)
        ]
    motion = _through_the_records(chosen.joints, ways)
    tip, _ = cl.at(motion.place)  # on the path, or lifted by so little that it does not count here
    left = tolerance - _rounding(machine, tip, tolerance)
    divided = linearize(
        kin, motion.joints, left, place=motion.place, lifted=motion.lifted, name=f"{cl.name}, block"
    )
    _refuse_out_of_travel(machine, cl, divided)
    ideal = motion if tcp else divided
    motion, cautions = ideal, ()
    if real is not None:
        motion, cautions = _compensated(real, ideal)
        _refuse_out_of_travel(machine, cl, motion)
    motion, planned, seconds = _blocks(kin, cl, motion, tcp)

    progress("writing")
    text = program.write(planned, machine, dialect, name=name)

    progress("reading back")
    blocks = program.read(text, machine, dialect, name=name)

    progress("proving")
    proof = prove(kin, cl, blocks, motion, tolerance, real=real)
    uncompensated = None
    if real is not None:
        ideal, wanted, _ = _blocks(kin, cl, ideal, tcp)
        uncompensated = measured(kin, cl, wanted, ideal, real=real)

    strategies, through = (), {}
    if compare:
        progress("comparing")
        strategies = tuple(_strategies(kin, cl, start, prefer))
        through = {region: crossing(region).compare(**options) for region in singular_regions}
    first_branch = int((chosen.branch == 0).sum())
    ranges = [f"{first + 1}–{last + 1}" for first, last in singular_regions[:8]] + ["…"] * (
        len(singular_regions) > 8
    )
    settings = {
        "CL data": f"{cl.name}, {len(cl)} records",
        "machine": f"{machine.name} ({machine.arrangement})",
        "selection": f"{strategy}, cost {chosen.cost:.3f} "
        + ("mm and degrees of travel" if np.isnan(machine.max_rates).all() else "s"),
        "branches": f"first {first_branch}, second {len(cl) - first_branch}",
        "splits": ", ".join(f"before record {record + 1}" for record in chosen.breaks) or "none",
        "singular": f"records {', '.join(ranges)}: {singular}" if ranges else "no region",
        "tolerance": f"{tolerance:g} mm",
        "program": f"{len(blocks.words)} moves, TCP {'on' if tcp else 'off'}",
    }
    warnings = *_warnings(cl, chosen.joints), *cautions
    report = Report(
        **vars(proof),
        settings=settings,
        time=seconds,
        warnings=warnings,
        uncompensated=uncompensated,
        strategies=strategies,
        ways=through,
    )
    return Result(chosen.joints, blocks, motion.place, text, report)


def _unbroken(regions, breaks):
    """The parts of regions between the records at which the path breaks."""
    for first, last in regions:
        inside = [record for record in breaks if first < record <= last]
        for start, end in zip([first, *inside], [*(record - 1 for record in inside), last], strict=True):
            if start < end:
                yield start, end


def _through_the_records(joints, ways):
    """The `Motion` through the joints (n, 5) chosen for the records, with each of `ways` in its place."""
    parts, record = [], 0  # the next that is to be reached
    for way in sorted(ways, key=lambda way: way.place[0]):
        first, last = int(way.place[0]), int(way.place[-1])
        before = np.arange(record, max(record, first))
        # Where a way begins at the record at which another has ended, that pose is there already.
        parts += [Motion.on_part(joints[before], before), way[1:] if record > first else way]
        record = last + 1
    rest = np.arange(record, len(joints))
    return Motion.joined([*parts, Motion.on_part(joints[rest], rest)])


def _rounding(machine, tip, tolerance):
    """How far the printed digits alone may move the tip, for the moves between tips (m, 3).

    Refuses a tolerance that leaves no room for it.
    """
    lever = levers(machine) + np.linalg.norm(tip, axis=1)
    moved = 0.5 * 10.0**-program.DECIMALS * (np.sqrt(3) + 2 * np.radians(1.0) * lever)
    if (worst := moved.max()) > tolerance / 2:
        expected = f"at least {2 * worst:.4f} mm, for words of {program.DECIMALS} decimals on this machine"
        raise InputError("tolerance", expected, f"{tolerance}")
    return np.maximum(moved[:-1], moved[1:])


def _refuse_out_of_travel(machine, cl, motion):
    """Raise `ReachError` for the first pose, those between the records included, that is out of travel."""
    out = np.flatnonzero(~travel.all_within(machine, motion.joints))
    if out.size:
        sentences = travel.out_of_travel(machine, motion.joints[out[0]])
        raise ReachError(f"{cl.where(int(motion.place[out[0]]))} and on: {'; '.join(sentences)}")


def _compensated(real, motion):
    """The `Motion` compensated for the errors of the machine, and sentences on what could not be."""
    parts = [real.compensate(motion.joints[rows]) for rows in slices(motion.joints.shape[:1])]
    after = PoseError(*(np.concatenate([getattr(part.after, name) for part in parts]) for name in ("tip", "axis")))
    joints, limited, refused = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("joints", "limited", "refused")
    )
    whole = Compensated(joints, parts[0].before, after, limited, refused)
    return replace(motion, joints=joints), whole.cautions


def _blocks(kin, cl, motion, tcp):
    """What a program says of a motion: `program.Blocks`, the poses they end at, and the time they take in s.

    A pose that repeats all words of the one before is left out.
    """
    joints = motion.joints
    words = np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1) if tcp else joints
    words = program.rounded(words)
    kept = np.r_[True, (words[1:] != words[:-1]).any(axis=1)]
    if not kept.all():
        motion, words = motion[kept], words[kept]
    record = np.ceil(motion.place).astype(int)
    feeds, rapid, (tip, _) = cl.feeds[record], cl.rapid[record], cl.at(motion.place)  # in cut it is on the path
    seconds = np.r_[np.nan, block_times(kin.machine, motion.joints, tip, feeds[1:], motion.in_cut)]
    turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
    by_time = turning & ~np.isnan(feeds) & ~rapid & (not tcp)
    # A remark stands before the first block of the move to its record.
    before = np.searchsorted(motion.place, [record - 1 for record, _ in cl.remarks], side="right").tolist()
    remarks = tuple((block, text) for block, (_, text) in zip(before, cl.remarks, strict=True))
    planned = program.Blocks(words, feeds, np.where(by_time, seconds, np.nan), rapid, tcp, remarks)
    return motion, planned, float(seconds[1:].sum())


def _warnings(cl, joints):
    """Sentences on what a person should look at."""
    if (np.isnan(cl.feeds) & ~cl.rapid).any():
        yield "the CL data state no feed for some moves; they carry no F word"
    swings = np.degrees(np.abs(np.diff(joints[:, 3:], axis=0))).max(axis=1)
    if swings.max(initial=0) > 90:
        record = int(swings.argmax())
        yield f"a rotary axis swings {swings[record]:.1f}° from record {record + 1} to the next"


def _strategies(kin, cl, start, prefer):
    """The rows of `Report.strategies`."""
    for name in selection.STRATEGIES:
        try:
            chosen = selection.choose(kin, cl, name, start=start, prefer=prefer)
        except MathpostError as error:
            yield name, np.nan, (), str(error)
            continue
        swings = np.degrees(np.abs(np.diff(chosen.joints[:, 3:], axis=0)).max(axis=0, initial=0))
        yield name, chosen.cost, tuple(swings), ""
