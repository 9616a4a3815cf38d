"""From CL data to a verified NC program; `run` calls the modules in turn.

Read them in this order: `cl`, `selection` (with `travel` and `yu_dan`), `singularity` and `passage`, `deviation`
and `linearization`, `motion`, `program`, `verification` and `report`.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mathpost.compensate.compensation import Compensator
from mathpost.errors import InputError, MathpostError
from mathpost.kinematics import Kinematics
from mathpost.post import controls, program, selection
from mathpost.post.motion import along_the_records, compensated
from mathpost.post.passage import CLEARANCE, LEAN, Crossing
from mathpost.post.report import Report
from mathpost.post.singularity import regions
from mathpost.post.verification import verify

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
    kin, real = Kinematics(machine), None if errors is None else Compensator(errors)

    progress("choosing")
    chosen = selection.choose(kin, cl, strategy, start=start, prefer=prefer, split=split)
    found = regions(kin, cl, chosen.joints, cone=cone)

    progress("planning")
    crossings = {region: Crossing(kin, cl, chosen.joints, region, tolerance=tolerance / 2) for region in found}
    ways = [crossing.safe(singular, lean=lean) for crossing in crossings.values()] if singular != "direct" else []
    for record in chosen.breaks:
        over = Crossing(kin, cl, chosen.joints, (record - 1, record), tolerance=tolerance / 2)
        ways.append(over.safe("retract", clearance=clearance))
    on_path = along_the_records(chosen.joints, ways)
    divided = on_path.linearized(kin, tolerance, cl)
    divided.refuse_out_of_travel(machine, cl)
    ideal = on_path if tcp else divided
    motion, cautions = (ideal, ()) if real is None else compensated(real, ideal)
    motion.refuse_out_of_travel(machine, cl)
    motion, words = motion.thinned(kin, tcp)
    planned, seconds = motion.blocks(machine, cl, words, tcp)

    progress("writing")
    text = program.write(planned, machine, dialect, name=name)

    progress("reading back")
    blocks = program.read(text, machine, dialect, name=name)

    progress("proving")
    proof = verify(kin, cl, blocks, motion, real=real)
    worst = max(proof.tip_error, proof.path_tip_error)
    if not worst <= tolerance:
        raise MathpostError(f"{cl.name}: the program is {worst:.6f} mm off the CL path, more than {tolerance} mm")
    uncompensated = None
    if real is not None:
        ideal, words = ideal.thinned(kin, tcp)
        uncompensated = verify(kin, cl, ideal.blocks(machine, cl, words, tcp)[0], ideal, real=real)

    passages = {}
    if compare:
        progress("comparing")
        passages = {region: over.compare(lean=lean, clearance=clearance) for region, over in crossings.items()}
    unit = "s" if not np.isnan(machine.max_rates).all() else "mm and degrees of travel"
    first_branch = int((chosen.branch == 0).sum())
    ranges = ", ".join(f"{first + 1}–{last + 1}" for first, last in found[:8]) + ", …" * (len(found) > 8)
    report = Report(
        verification=proof,
        settings={
            "CL data": f"{cl.name}, {len(cl)} records",
            "machine": f"{machine.name} ({machine.arrangement})",
            "selection": f"{strategy}, cost {chosen.cost:.3f} {unit}",
            "branches": f"first {first_branch}, second {len(cl) - first_branch}",
            "splits": ", ".join(f"before record {record + 1}" for record in chosen.breaks) or "none",
            "singular": f"records {ranges}: {singular}" if found else "no region",
            "tolerance": f"{tolerance:g} mm",
            "program": f"{len(blocks.words)} moves, TCP {'on' if tcp else 'off'}",
        },
        time=seconds,
        uncompensated=uncompensated,
        warnings=(*_warnings(cl, chosen.joints), *cautions),
        strategies=tuple(_strategies(kin, cl, start, prefer)) if compare else (),
        passages=passages,
    )
    return Result(chosen.joints, blocks, motion.place, text, report)


def _warnings(cl, joints):
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
