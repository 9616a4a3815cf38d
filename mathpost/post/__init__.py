"""From CL data to a verified NC program; `run` calls the modules in turn.

Read them in this order: `cl` (with `cl_words` and `arcs`), `plan`, `selection` (with `travel` and `yu_dan`),
`singularity` and `passage`, `deviation` and `linearization`, `motion`, `program` (with `controls` and `text`),
`verification` and `report`.
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mathpost.compensate.compensation import Compensator
from mathpost.errors import InputError, MathpostError
from mathpost.post import controls, program, selection
from mathpost.post.passage import CLEARANCE, LEAN, Crossing
from mathpost.post.plan import CONE, TOLERANCE, plan
from mathpost.post.report import Report
from mathpost.post.verification import verify, worst_of


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
        The way through singular regions, one of `Crossing.SAFE`.
    cone : float or None
        Radians about the singular tool axes; None lets feed and rates decide. See `singularity.regions`.
    lean, clearance : float
        Radians and mm; see `Crossing.way`.
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
        If the program is off the CL path by more than the tolerance.

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
    progress = progress or (lambda stage: None)
    name = name or Path(cl.name).stem
    controls.control_for(machine, dialect)  # refuses what cannot be written before the work
    tools = cl.by_tool()
    if errors is not None and any(length not in (None, machine.tool_length) for _, length in tools):
        raise InputError("errors", f"one tool, {machine.tool_length:g} mm long", "CL data with other lengths")
    real = None if errors is None else Compensator(errors)

    progress("planning")
    plans = []
    for part, length in tools:
        plans.append(
            plan(
                part,
                machine if length is None else machine.with_setup(tool_length=length),
                real=real,
                tcp=tcp,
                tolerance=tolerance,
                strategy=strategy,
                start=plans[-1].chosen.joints[-1] if plans else start,
                prefer=prefer,
                split=split,
                singular=singular,
                cone=cone,
                lean=lean,
                clearance=clearance,
            )
        )

    progress("writing")
    text = program.write(program.joined([each.blocks for each in plans]), machine, dialect, name=name)

    progress("reading back")
    blocks = program.read(text, machine, dialect, name=name)

    progress("proving")
    ends = np.cumsum([len(each.blocks.words) for each in plans])
    if ends[-1] != len(blocks.words):
        raise MathpostError(f"{ends[-1]} blocks were written and {len(blocks.words)} read back")
    parts = [blocks[end - len(each.blocks.words) : end] for each, end in zip(plans, ends, strict=True)]
    proof = worst_of([each.prove(part, real) for each, part in zip(plans, parts, strict=True)])
    worst = max(proof.tip_error, proof.path_tip_error)
    if not worst <= tolerance:
        raise MathpostError(f"{cl.name}: the program is {worst:.6f} mm off the CL path, more than {tolerance} mm")
    uncompensated = None
    if real is not None:
        uncompensated = worst_of([verify(each.kin, each.cl, *each.uncompensated, real=real) for each in plans])

    passages = {}
    if compare:
        progress("comparing")
        for each in plans:
            for (first, last), over in each.crossings.items():
                region = each.cl.first + first, each.cl.first + last
                passages[region] = over.compare(lean=lean, clearance=clearance)
    report = Report(
        verification=proof,
        settings=dict(_settings(cl, machine, plans, strategy, singular, tolerance, len(blocks.words), tcp)),
        time=sum(each.seconds for each in plans),
        uncompensated=uncompensated,
        warnings=tuple(dict.fromkeys(sentence for each in plans for sentence in _warnings(each))),
        strategies=tuple(_strategies(plans, start, prefer)) if compare else (),
        passages=passages,
    )
    return Result(
        np.concatenate([each.chosen.joints for each in plans]),
        blocks,
        np.concatenate([each.cl.first + each.motion.place for each in plans]),
        text,
        report,
    )


def _settings(cl, machine, plans, strategy, singular, tolerance, moves, tcp):
    """The lines of the report that say how the program was made."""
    unit = "s" if not np.isnan(machine.max_rates).all() else "mm and degrees of travel"
    first_branch = sum(int((each.chosen.branch == 0).sum()) for each in plans)
    breaks = [each.cl.first + record for each in plans for record in each.chosen.breaks]
    found = [(each.cl.first + first, each.cl.first + last) for each in plans for first, last in each.crossings]
    ranges = ", ".join(f"{first + 1}–{last + 1}" for first, last in found[:8]) + ", …" * (len(found) > 8)
    yield "CL data", f"{cl.name}, {len(cl)} records"
    yield "machine", f"{machine.name} ({machine.arrangement})"
    yield "selection", f"{strategy}, cost {sum(each.chosen.cost for each in plans):.3f} {unit}"
    yield "branches", f"first {first_branch}, second {len(cl) - first_branch}"
    yield "splits", ", ".join(f"before record {record + 1}" for record in breaks) or "none"
    yield "singular", f"records {ranges}: {singular}" if found else "no region"
    yield "tolerance", f"{tolerance:g} mm"
    yield "program", f"{moves} moves, TCP {'on' if tcp else 'off'}"
    comments = Counter(
        remark.upper().replace("/", " ").split()[0] for _, remark in cl.remarks if isinstance(remark, str)
    )
    commands = Counter(remark.kind for _, remark in cl.remarks if not isinstance(remark, str))
    said = [remark for _, remark in cl.remarks]
    comments = Counter(remark.upper().replace("/", " ").split()[0] for remark in said if isinstance(remark, str))
    commands = Counter(remark.kind for remark in said if not isinstance(remark, str))
    if comments:
        yield "comments", ", ".join(f"{word} {count}" for word, count in comments.most_common())
    if commands:
        yield "commands", ", ".join(f"{kind} {count}" for kind, count in commands.most_common())
    for note in cl.notes:
        yield "note", note


def _warnings(each):
    cl, joints = each.cl, each.chosen.joints
    yield from each.cautions
    kinds = {getattr(remark, "kind", "") for _, remark in cl.remarks}
    if "compensation" in kinds:
        yield "cutter compensation: proved for a radius of 0 in the control's tool table"
    if "tool" in kinds and each.machine.programmed_point != "tip":
        yield "X Y Z do not name the tip: the length of the tools has to be 0 in the control's tool table"
    if (np.isnan(cl.feeds) & ~cl.rapid).any():
        yield "the CL data state no feed for some moves; they carry no F word"
    swings = np.degrees(np.abs(np.diff(joints[:, 3:], axis=0))).max(axis=1)
    if swings.max(initial=0) > 90:
        record = int(swings.argmax())
        record += cl.first + 1
        yield f"a rotary axis swings {swings.max():.1f}° from record {record} to the next"


def _strategies(plans, start, prefer):
    """The rows of `Report.strategies`."""
    for name in selection.STRATEGIES:
        cost, swings, before = 0.0, np.zeros(2), start
        try:
            for each in plans:
                chosen = selection.choose(each.kin, each.cl, name, start=before, prefer=prefer)
                steps = np.degrees(np.abs(np.diff(chosen.joints[:, 3:], axis=0)).max(axis=0, initial=0))
                cost, swings, before = cost + chosen.cost, np.maximum(swings, steps), chosen.joints[-1]
        except MathpostError as error:
            yield name, np.nan, (), str(error)
            continue
        yield name, cost, tuple(swings), ""
