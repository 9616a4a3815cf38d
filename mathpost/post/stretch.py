"""One stretch of a program: from chosen joints to blocks, and from blocks to text that is read back and proved.

A long program is made stretch by stretch, in no more memory than a short one. `plan` decides what the machine does;
`prove` writes it down from where the stretch before ended, and may therefore run in another process.
"""

from dataclasses import dataclass, replace

import numpy as np

from mathpost.errors import MathpostError, ReachError
from mathpost.post import program
from mathpost.post.cl import CLData
from mathpost.post.motion import Motion
from mathpost.post.passage import Crossing
from mathpost.post.verification import Verification, verify


@dataclass(frozen=True)
class Stretch:
    """Records in a row, with the joints chosen for them.

    Attributes
    ----------
    cl : CLData
    joints : ndarray, shape (n, 5)
    lead : int
        How many of the records at the beginning belong to the stretch before.
    regions : tuple of (int, int)
        The singular regions: first and last record, counted in this stretch.
    breaks : tuple of int
        The records, counted in this stretch, that are reached by retracting and unwinding.
    cost : float
        Of the moves of the stretch, as the selection counts it.
    first_branch : int
        How many of its records are on the first branch.
    last : bool
        Whether the path ends here.
    """

    cl: CLData
    joints: np.ndarray
    lead: int
    regions: tuple
    breaks: tuple
    cost: float
    first_branch: int
    last: bool

    def crossing(self, setting, region):
        """The ways through one of the regions, or over one of the breaks."""
        return Crossing(setting.kin, self.cl, self.joints, region, tolerance=setting.tolerance / 2)

    def way(self, setting, region, name):
        """The way of that name, as a `Passage`; raises `ReachError` if it is not possible."""
        passage = self.crossing(setting, region).way(name, **setting.ways)
        if passage.reason:
            first, last = (self.cl.first + record + 1 for record in region)
            raise ReachError(f"{self.cl.name}: no way {name!r} from record {first} to {last}: {passage.reason}")
        return passage


@dataclass(frozen=True)
class Planned:
    """What the machine does in a stretch.

    Attributes
    ----------
    cl : CLData
        The records, and first of all the one that the stretch before ended with, if there was one.
    motion : Motion
        The poses, those of the first record included; places count in `cl`.
    behind : int
        How many of the poses the stretch before has written.
    blocks : mathpost.post.program.Blocks
        What is to be written.
    seconds : float
        How long the moves take.
    ideal : (Motion, Blocks) or None
        The same as if nothing had been measured on the machine.
    cautions : tuple of str
    """

    cl: CLData
    motion: Motion
    behind: int
    blocks: program.Blocks
    seconds: float
    ideal: tuple | None = None
    cautions: tuple = ()


@dataclass(frozen=True)
class Proved:
    """The text of a stretch, its blocks as read back from that text, and how far they are off.

    `state` is that of the reader at the end; `uncompensated` is what the machine as it is would do without
    compensation.
    """

    text: str
    blocks: program.Blocks
    verification: Verification
    uncompensated: Verification | None
    state: object


def plan(setting, stretch):
    """Return what the machine does in a `Stretch`, as `Planned`.

    Raises
    ------
    ReachError
        If the way through a singular region is not possible, or a pose is out of travel.
    InputError
        If the printed digits alone may use up the tolerance.
    """
    kin, cl, count = setting.kin, stretch.cl, len(stretch.cl)
    motion = Motion(stretch.joints, np.arange(count, dtype=float), np.zeros(count, bool))
    if setting.singular != "direct":
        for region in stretch.regions:
            motion = motion.replaced(stretch.way(setting, region, setting.singular))
    for record in stretch.breaks:
        motion = motion.replaced(stretch.way(setting, (record - 1, record), "retract"))
    behind = min(stretch.lead, 1)
    before = max(stretch.lead - 1, 0)
    cl, motion = cl.part(before, count), motion[np.searchsorted(motion.place, before) :]
    motion = replace(motion, place=motion.place - before)

    linear = motion.linearized(kin, setting.tolerance, cl)
    linear.refuse_out_of_travel(setting.machine, cl)
    ideal, cautions, motion = None, (), motion if setting.tcp else linear
    if setting.calibrated is not None:
        thin, words = motion.thinned(kin, setting.tcp)
        ideal = thin, thin.blocks(setting.machine, cl, words, setting.tcp)[0]
        compensated = setting.calibrated.compensate(motion.joints)
        motion, cautions = replace(motion, joints=compensated.joints), compensated.cautions
        motion.refuse_out_of_travel(setting.machine, cl)
    motion, words = motion.thinned(kin, setting.tcp)
    blocks, seconds = motion.blocks(setting.machine, cl, words, setting.tcp, behind=behind)
    return Planned(cl, motion, behind, blocks, seconds, ideal, cautions)


def prove(setting, planned, *, state=None, foot=""):
    """Write a stretch, read it back and compare it with the CL data.

    Parameters
    ----------
    setting : Setting
    planned : Planned
    state : mathpost.post.program_writer.State, optional
        Of the program where the stretch before ends; by default the program begins here.
    foot : str
        What the program ends with, for the last stretch.

    Returns
    -------
    Proved

    Raises
    ------
    MathpostError
        If the program is off the CL path by more than the tolerance.
    """
    kin, cl, motion = setting.kin, planned.cl, planned.motion
    writer, head = setting.writer(), ""
    if state is None:
        reader, head = program.reader_at(writer, name=setting.name), writer.head()
    else:
        writer.state = state
        reader = program.reader_at(writer, name=setting.name)
    text = head + writer.write(planned.blocks) + foot
    blocks = reader.read(text)
    whole = blocks
    if planned.behind:
        whole = replace(blocks, words=np.concatenate([np.transpose([state.words]), blocks.words.T], axis=1).T)
    proof = verify(kin, cl, whole, motion, real=setting.calibrated)
    worst = max(proof.tip_error, proof.path_tip_error)
    if not worst <= setting.tolerance:
        raise MathpostError(
            f"{cl.name}: the program is {worst:.6f} mm off the CL path, more than {setting.tolerance} mm"
        )
    uncompensated = None
    if planned.ideal:
        uncompensated = verify(kin, cl, planned.ideal[1], planned.ideal[0], real=setting.calibrated)
    return Proved(text, blocks, proof, uncompensated, reader.state)
