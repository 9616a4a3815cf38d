"""What the machine does with one tool: joints chosen, ways through the singular regions, moves divided, blocks."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from mathpost.compensate.compensation import Compensated, PoseError
from mathpost.errors import InputError, ReachError
from mathpost.kinematics import Kinematics
from mathpost.post import program
from mathpost.post.between_blocks import AXIS_RESOLUTION, RESOLUTION, levers
from mathpost.post.cl import OPPOSITE, CLData
from mathpost.post.controls import Blocks
from mathpost.post.motion import Motion, block_times, feed_times, follow, linearize
from mathpost.post.proof import measured, prove
from mathpost.post.selection import Selection
from mathpost.post.singular import regions
from mathpost.post.time_law import TimeLaw, slow_down, time_law
from mathpost.post.ways import Crossing, in_the_air
from mathpost.rotation import slices

# Radians; how far the printed digits of both rotary axes may turn the tool axis, and what samples miss.
AXIS_DIGITS = np.radians(10.0**-program.DECIMALS) + AXIS_RESOLUTION
TRAVEL_TOLERANCE = 0.01  # mm; between the blocks travel is looked at to this, whatever the tolerance of the tip


@dataclass(frozen=True)
class Plan:
    """The part of a path that one tool runs through.

    Records are counted from 0 within it.
    """

    kin: Kinematics  # of the machine with this tool
    cl: CLData
    first: int  # how many records of the path come before
    chosen: Selection
    regions: list  # the singular ones, first and last record
    singular: str  # the way through them
    crossing: object  # makes the `Crossing` of a region
    motion: Motion  # where the machine goes,
    ideal: Motion  # and where it would go if nothing had been measured on it
    blocks: Blocks  # to be written
    law: TimeLaw  # of the moves
    slowest: tuple | None  # from `slow_down`, in records of the whole path
    cautions: tuple

    def uncompensated(self, real):
        """Return as `Proof` what the real machine would do if nothing had been measured."""
        motion, blocks, *_ = _blocks(self.kin, self.cl, self.ideal, self.blocks.tcp)
        return self._counted(measured(self.kin, self.cl, blocks, motion, real=real))

    def proved(self, blocks, tolerance, axis_tolerance, real):
        """Return the `Proof` of the blocks that were read back, or refuse them."""
        return self._counted(prove(self.kin, self.cl, blocks, self.motion, tolerance, axis_tolerance, real=real))

    def _counted(self, proof):
        return replace(proof, worst_record=self.first + proof.worst_record)

    def compared(self, lean, clearance):
        """Yield for each singular region, in records of the whole path, all ways through it."""
        for first, last in self.regions:
            through = self.crossing((first, last)).compare(lean=lean, clearance=clearance)
            yield (self.first + first, self.first + last), through


def plan(
    cl, first, machine, choose, real, tcp, tolerance, axis_tolerance, singular, cone, lean, clearance, progress
):
    """Return the `Plan` of CL data with one tool, on the machine with this tool, `first` records coming before.

    `choose` is `mathpost.post.selection.choose` with its options, `real` a `Compensator` or None; the others are
    those of `mathpost.post.run`.
    """
    turned = np.flatnonzero(np.linalg.norm(cl.axes[1:] + cl.axes[:-1], axis=1) < OPPOSITE)
    if turned.size:
        raise InputError(
            cl.where(turned[0] + 1), "a tool axis not opposite to the one before, or RAPID", "a turn by 180°"
        )
    kin = Kinematics(machine)
    progress("choosing")
    chosen = choose(kin, cl)
    found = regions(kin, cl, chosen.joints, cone=cone)
    progress("planning")
    room = axis_tolerance - AXIS_DIGITS
    crossing = partial(Crossing, kin, cl, chosen.joints, tolerance=tolerance / 2, axis_tolerance=room)
    options = {"lean": lean, "clearance": clearance}
    passed = _unbroken(found, chosen.breaks) if singular != "direct" else ()
    ways = [crossing(region).possible(singular, **options) for region in passed]
    ways += [crossing((record - 1, record)).possible("retract", **options) for record in chosen.breaks]
    motion = _through_the_records(chosen.joints, ways)
    taken = np.zeros(len(cl), bool)  # by a way that goes as it does
    for way in ways:
        taken[int(way.place[0]) : int(way.place[-1])] = True
    motion = follow(kin, cl, motion, room, free=taken[np.floor(motion.place[:-1]).astype(int)])
    divided = _divided(kin, cl, motion, tolerance, tcp, clearance)
    between = divided if tolerance <= TRAVEL_TOLERANCE else _linearized(kin, cl, motion, TRAVEL_TOLERANCE)
    _refuse_out_of_travel(machine, cl, between)
    ideal, cautions = motion if tcp else divided, ()
    motion = ideal
    if real is not None:
        motion, cautions = _compensated(real, motion)
        _refuse_out_of_travel(machine, cl, motion)
    motion, blocks, asked, by_feed = _blocks(kin, cl, motion, tcp)
    _refuse_turning_compensation(cl, machine, blocks)
    law, moving = time_law(machine, motion.joints, asked), asked > 0
    slowest = slow_down(first + motion.record[1:][moving], np.diff(law.seconds), by_feed[moving])
    return Plan(kin, cl, first, chosen, found, singular, crossing, motion, ideal, blocks, law, slowest, cautions)


def _unbroken(regions, breaks):
    """The parts of regions between the records at which the path breaks."""
    for first, last in regions:
        inside = [record for record in breaks if first < record <= last]
        for start, end in zip([first, *inside], [*(record - 1 for record in inside), last], strict=True):
            if start < end:
                yield start, end


def _through_the_records(joints, ways):
    """The `Motion` through the joints (n, 5) chosen for the records, with each of `ways` in its place."""
    place = np.arange(len(joints))
    parts, record = [], 0  # the next record to be reached
    for way in sorted(ways, key=lambda way: way.place[0]):
        first, last = int(way.place[0]), int(way.place[-1])
        parts.append(Motion.on_part(joints[record:first], place[record:first]))
        # Where a way begins at the record at which another has ended, that pose is there already.
        parts.append(way[1:] if record > first else way)
        record = last + 1
    return Motion.joined([*parts, Motion.on_part(joints[record:], place[record:])])


def _divided(kin, cl, motion, tolerance, tcp, clearance):
    """The motion divided until the tip keeps the tolerance, digits and what samples miss included."""
    tip, _ = cl.at(motion.place)  # on the path, or lifted by so little that it does not count here
    lever = (levers(kin.machine) + np.linalg.norm(tip, axis=1)) * (not tcp)  # the angles do not move the tip then
    moved = 0.5 * 10.0**-program.DECIMALS * (np.sqrt(3) + 2 * np.radians(1.0) * lever) + RESOLUTION
    if (worst := moved.max()) > tolerance / 2:
        expected = f"at least {2 * worst:.4f} mm, for words of {program.DECIMALS} decimals on this machine"
        raise InputError("tolerance", expected, f"{tolerance}")
    keep = tolerance - np.maximum(moved[:-1], moved[1:])
    return _linearized(kin, cl, motion, in_the_air(motion, keep, clearance))


def _linearized(kin, cl, motion, tolerance):
    """The motion with its moves divided until the tip keeps the tolerance."""
    return linearize(
        kin, motion.joints, tolerance, place=motion.place, lifted=motion.lifted, name=f"{cl.name}, block"
    )


def _refuse_out_of_travel(machine, cl, motion):
    """Raise `ReachError` for the first pose, those between the records included, that is out of travel."""
    out = np.flatnonzero(~machine.within(motion.joints).all(axis=1))
    if out.size:
        sentences = machine.out_of_travel(motion.joints[out[0]])
        raise ReachError(f"{cl.where(int(motion.place[out[0]]))} and on: {'; '.join(sentences)}")


def _compensated(real, motion):
    """The `Motion` compensated for the errors of the machine, and sentences on what could not be."""
    parts = [real.compensate(motion.joints[rows]) for rows in slices(motion.joints.shape[:1])]

    def whole(names, parts):
        return (np.concatenate([getattr(part, name) for part in parts]) for name in names)

    after = PoseError(*whole(("tip", "axis"), [part.after for part in parts]))
    joints, limited, refused = whole(("joints", "limited", "refused"), parts)
    return replace(motion, joints=joints), Compensated(joints, parts[0].before, after, limited, refused).cautions


def _blocks(kin, cl, motion, tcp):
    """What a program says of a motion: the poses, the `program.Blocks` that end at them, and seconds of the moves.

    The seconds are those that feed and rates ask for, and those of the feed alone, NaN where it does not count. A
    pose that repeats all words of the one before is left out.
    """
    joints = motion.joints
    words = np.concatenate([kin.forward(joints)[0], joints[:, 3:]], axis=1) if tcp else joints
    words = program.rounded(words)
    kept = np.r_[True, (words[1:] != words[:-1]).any(axis=1)]
    if not kept.all():
        motion, words = motion[kept], words[kept]
    record = motion.record
    feeds, rapid, (tip, _) = cl.feeds[record], cl.rapid[record], cl.at(motion.place)  # in cut it is on the path
    seconds = np.r_[np.nan, block_times(kin.machine, motion.joints, tip, feeds[1:], motion.in_cut)]
    turning = np.r_[False, (words[1:, 3:] != words[:-1, 3:]).any(axis=1)]
    by_time = turning & ~np.isnan(feeds) & ~rapid & (not tcp)
    # A remark stands before the first block of the move to its record.
    before = np.searchsorted(motion.place, [record - 1 for record, _ in cl.remarks], side="right").tolist()
    remarks = tuple((block, text) for block, (_, text) in zip(before, cl.remarks, strict=True))
    planned = program.Blocks(words, feeds, np.where(by_time, seconds, np.nan), rapid, tcp, remarks)
    fed = np.where(motion.in_cut & ~rapid[1:], feed_times(tip, feeds[1:]), np.nan)
    return motion, planned, seconds[1:], fed


def _refuse_turning_compensation(cl, machine, blocks):
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
