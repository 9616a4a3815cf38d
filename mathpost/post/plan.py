"""What the machine does with one tool: joints chosen, ways through the singular regions, moves divided, blocks."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.machine import Machine
from mathpost.post import selection
from mathpost.post.cl import CLData
from mathpost.post.controls import Blocks
from mathpost.post.motion import Motion, along_the_records, compensated
from mathpost.post.passage import CLEARANCE, LEAN, Crossing
from mathpost.post.selection import Selection
from mathpost.post.singularity import regions
from mathpost.post.verification import verify

TOLERANCE = 0.01  # mm
CONE = np.radians(1.0)  # about the singular tool axes


@dataclass(frozen=True)
class Plan:
    """The part of a path that one tool runs through.

    Attributes
    ----------
    machine : Machine
        With the length of this tool.
    kin : Kinematics
    cl : CLData
    chosen : mathpost.post.selection.Selection
    crossings : dict
        The singular regions (first and last record), each with its `Crossing`.
    motion, ideal : Motion
        Where the machine goes, and where it would go if nothing had been measured on it.
    blocks : Blocks
        To be written.
    seconds : float
        That the moves take.
    cautions : tuple of str
    """

    machine: Machine
    kin: Kinematics
    cl: CLData
    chosen: Selection
    crossings: dict
    motion: Motion
    ideal: Motion
    blocks: Blocks
    seconds: float
    cautions: tuple

    @cached_property
    def uncompensated(self):
        """The blocks and the motion if nothing had been measured."""
        ideal, words = self.ideal.thinned(self.kin, self.blocks.tcp)
        return ideal.blocks(self.machine, self.cl, words, self.blocks.tcp)[0], ideal

    def prove(self, blocks, real):
        """Return the `Verification` of blocks that were read back."""
        return verify(self.kin, self.cl, blocks, self.motion, real=real)


def plan(
    cl,
    machine,
    *,
    real=None,
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
):
    """Return the `Plan` of CL data with one tool; see `mathpost.post.run` for the options."""
    turned = np.flatnonzero(np.linalg.norm(cl.axes[1:] + cl.axes[:-1], axis=1) < 1e-6)
    if turned.size:
        raise InputError(
            cl.where(turned[0] + 1), "a tool axis not opposite to the one before", "one turned by 180°"
        )
    kin = Kinematics(machine)
    chosen = selection.choose(kin, cl, strategy, start=start, prefer=prefer, split=split)
    found = regions(kin, cl, chosen.joints, cone=cone)
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
    blocks, seconds = motion.blocks(machine, cl, words, tcp)
    refuse_turning_compensation(cl, machine, blocks)
    return Plan(machine, kin, cl, chosen, crossings, motion, ideal, blocks, seconds, cautions)


def refuse_turning_compensation(cl, machine, blocks):
    """Raise `InputError` if a rotary axis moves while the control compensates the radius of the cutter.

    The control does so in its X-Y plane: the tool has to stand across it, and the rotary axes still.
    """
    switched = [(row, remark) for row, remark in blocks.remarks if getattr(remark, "kind", "") == "compensation"]
    on, rows = None, len(blocks.words)
    for row, remark in [*switched, (rows, None)]:
        if on is not None:
            rotary = blocks.words[max(on[0] - 1, 0) : min(row + 1, rows), 3:]
            heads = [joint.carries == "tool" for joint in machine.rotary]
            if blocks.tcp or np.ptp(rotary, axis=0).any() or rotary[:1, heads].any():
                expected = "rotary axes that stand still, the tool across X and Y, and no TCP"
                raise InputError(f"{cl.name}: {on[1].statement}", expected, "others while it holds")
        on = (row, remark) if remark is not None and remark.values[0] != "OFF" else None
