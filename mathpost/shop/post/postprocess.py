"""From CL data to a verified NC program: all steps in their order."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.errors import InputError, MathpostError
from mathpost.machine import Machine
from mathpost.path.cl import CLData, commands
from mathpost.shop.controls.blocks import Blocks, joined
from mathpost.shop.controls.coordinates import Setup
from mathpost.shop.controls.reader import Program, follow
from mathpost.shop.controls.writer import state_rounding, write
from mathpost.shop.post import proof
from mathpost.shop.post.every_move import begins, lines_of, refuse_unsafe, where
from mathpost.shop.post.options import Options
from mathpost.shop.post.own_words import as_run, own_words
from mathpost.shop.post.report import Report, report_of
from mathpost.shop.post.steps import Plan, plan
from mathpost.shop.post.tool_path import ToolPath, tool_paths

if TYPE_CHECKING:
    from mathpost.shop.post.proof import Proof


@dataclass(frozen=True)
class Result:
    """A verified program and how it came about."""

    joints: np.ndarray  # chosen for the n records, shape (n, 5), mm and radians
    blocks: Blocks  # m moves, as read back from the program
    place: np.ndarray  # where each ends on the CL path, shape (m,): 2.25 is a quarter of the way from record 2 to 3
    program: str  # its text
    report: Report


def postprocess(
    cl: CLData, machine: Machine, *, name: str | None = None, compare: bool = False,
    progress: Callable[[str], None] | None = None, **options: Any,
) -> Result:  # fmt: skip
    """Post-process CL data into a verified program, as `Result`.

    No program is handed out unverified: its own text is read back, sent through the forward kinematics and compared
    with the CL data, at the records and along the path that the joints really run between the blocks.

    Parameters
    ----------
    cl : CLData
    machine : Machine
    name : str, optional
        Name of the program, by default that of the CL file.
    dialect : str, path-like or Control
        The control: one of `mathpost.shop.controls.control.names`, or a file like theirs.
    tcp : bool
        Whether the control keeps the tip (M128, G43.4, TRAORI): X Y Z are then the tip in the workpiece.
    tolerance, axis_tolerance : float
        mm, how far the tip may be from the CL path, and radians, the tool axis from its great circle between two
        records, everything included. Moves in cut are divided until they keep both, without TCP that of the tip;
        a way that leaves the circle on purpose is refused if it needs more.
    expand : bool
        Whether arcs, drilling cycles and operations in a tilted plane are written as straight moves.
    strategy, start, prefer, split
        As in `mathpost.path.selection.choose`; at a split the tool is retracted, unwound and returned.
    singular, lean, clearance : str, float, float
        The way through singular regions, and how: see `mathpost.path.region.Region.motion`, but for the audit's.
    cone : float or None
        Radians about the singular tool axes; None lets feed and rates decide. See `mathpost.path.singular.regions`.
    errors : mathpost.shop.compensate.model.MachineErrors, optional
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
        If the program does not pass its proof, `mathpost.shop.post.proof.prove`.

    Examples
    --------
    >>> import mathpost
    >>> result = postprocess(mathpost.read_cl("data/cl/blade.cl"), mathpost.load_machine("dmu50v"))
    >>> print("\\n".join(result.program.splitlines()[:4]))
    0 BEGIN PGM BLADE MM
    1 ; MOTION ONLY: THE MACHINE FILE GIVES NO HEAD AND NO FOOT
    2 L X-36.7809 Y-68.5751 Z+66.1338 B+11.8172 C+175.8146
    3 L X-38.5803 Y-67.4446 Z+64.5272 B+10.3971 C+176.3180
    >>> result.report.tip_error < 0.01
    True
    """
    asked = Options.of(machine, **options)
    progress = progress or (lambda stage: None)
    name = name or Path(cl.name).stem
    paths = tool_paths(cl, machine)
    origins = _origins(paths, asked)
    plans: list[Plan] = []
    for path in paths:
        plans.append(plan(path, asked, asked.start, progress, before=plans[-1] if plans else None))
        plans[-1] = replace(plans[-1], moves=own_words(path, plans[-1].moves, asked))

    progress("writing")
    text = write(joined([each.moves.blocks for each in plans]), machine, asked.control, name=name)

    progress("reading back")
    own = lines_of(text, machine)
    program = _read_back(text, machine, asked, Setup(offsets=origins, in_order=_lengths(paths)), name, own)
    plans, starts, others = _as_run(plans, program, own)

    progress("proving")
    proofs = [_proof(each, asked) for each in plans]
    interpolated = asked.control.rapid_interpolated
    plans = refuse_unsafe(plans, starts, program, others, text, own, name, interpolated=interpolated)
    left = asked.tolerance - max(each.path_tip_error for each in proofs)
    turned = np.degrees(asked.axis_tolerance) - max(each.path_axis_error for each in proofs)
    text = state_rounding(text, asked.control, left, turned)

    if compare:
        progress("comparing")
    made = report_of(cl, machine, asked, plans, proofs, rounding=left, compare=compare)
    joints = np.concatenate([each.chosen.joints for each in plans])
    place = np.concatenate([each.path.first + each.moves.motion.place for each in plans])
    return Result(joints, joined([each.moves.blocks for each in plans]), place, text, made)


def _origins(paths: list[ToolPath], options: Options) -> dict[str, tuple[float, ...]]:
    """Origins of the work offsets of some paths, by their names; `InputError` where the control has no such one."""
    origins = {}
    for path in paths:
        if path.offset is not None:
            try:
                options.control.work_offset_line(path.offset)
            except InputError as error:
                raise InputError(f"{path.cl.where(0)}: {error.where}", error.expected, error.found) from None
            origins[options.control.work_offsets.name(path.offset)] = path.kin.machine.origin
    return origins


def _lengths(paths: list[ToolPath]) -> tuple[float, ...]:
    """The lengths of the tools of some paths, in the order in which they are changed to, mm."""
    found, held = [], None
    for path in paths:
        numbers = [tool.values[0] for record, tool in commands(path.cl.remarks, "tool") if record == 0]
        if numbers and numbers[-1] != held:
            held = numbers[-1]
            found.append(path.kin.machine.tool_length)
    return tuple(found)


def _read_back(
    text: str, machine: Machine, options: Options, setup: Setup, name: str, own: dict[int, str]
) -> Program:  # fmt: skip
    """The program as its text is read; an error in a line of the user's names its key in the machine file."""
    try:
        return follow(text, machine, options.control, setup=setup, name=name)
    except InputError as error:
        line = re.search(r", line (\d+)$", error.where)
        if line is None:
            raise
        raise InputError(where(text, own, name, int(line[1])), error.expected, error.found) from None


def _as_run(plans: list[Plan], program: Program, own: dict[int, str]) -> tuple[list[Plan], list[int], list[int]]:
    """The plans with the moves that were read back, the rows at which each begins, and those that none has made."""
    found: list[Plan] = []
    starts: list[int] = []
    others: list[int] = []
    row = 0
    for each in plans:
        starts.append(begins(program, each, row, own))
        held = [machine for first, machine in program.machines if first <= starts[-1]][-1].tool_length
        if held != (length := each.path.kin.machine.tool_length):
            place = f"{each.path.kin.machine.name}, [program] tool_change"
            raise InputError(place, f"a word that loads the tool of {length:g} mm", f"that of {held:g} mm")
        others += range(row, starts[-1])
        moves, row = as_run(each.path, each.moves, program, starts[-1])
        found.append(replace(each, moves=moves))
    foot = range(row, len(program.lines))
    if row > len(program.lines) or any(program.lines[each] not in own for each in foot):
        raise MathpostError(f"{row} ends of moves were written and {len(program.lines)} read back")
    return found, starts, [*others, *foot]


def _proof(plan: Plan, options: Options) -> Proof:
    """The proof of the moves of one tool, as read back; records are those of the whole path."""
    moves, kin = plan.moves, plan.path.kin
    found = proof.prove(
        kin, plan.path.cl, moves.blocks, moves.motion, options.tolerance, options.axis_tolerance,
        real=options.real(kin.machine), rapid_interpolated=options.control.rapid_interpolated, left_out=moves.pecks,
    )  # fmt: skip
    return replace(found, worst_record=plan.path.first + found.worst_record)
