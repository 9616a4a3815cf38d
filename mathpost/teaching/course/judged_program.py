"""The verdict on a learner's program: its own text, read back, against the CL data that it was made for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mathpost.errors import InputError
from mathpost.kinematics import Kinematics
from mathpost.path import singular
from mathpost.path.cl import CLData
from mathpost.shop.controls.reader import read
from mathpost.shop.post.proof import joints_of
from mathpost.shop.post.time_law import block_times
from mathpost.teaching.course.answers import Kind
from mathpost.teaching.course.match import Between, between, match

if TYPE_CHECKING:
    from mathpost.shop.controls.blocks import Blocks

TIP, AXIS = 0.01, 0.1  # tolerances, mm and degrees
LIFTED = 1.0  # mm above the path: not in cut
NEAR_POLE = np.radians(5.0)  # within which a lift may leave out the path between two records
SLOWER = 1.1  # factor by which a block may take longer than feed and rates require
SAME_FEED = 0.5  # mm/min


class Program(Kind):
    """The text of a program."""

    asked = "the text of a Heidenhain program"

    def read(self, answer: Any) -> str:
        if not isinstance(answer, str):
            raise InputError("answer", self.asked, "something else")
        return answer

    def show(self, value: str) -> str:
        lines = value.splitlines()
        return f"{len(lines)} lines, from {lines[0]!r} to {lines[-1]!r}"


def unproved(text: str, kin: Kinematics, path: CLData) -> str:
    """Say what is wrong with a program, or nothing: travel, records in order, moves between them, feeds, times."""
    blocks = read(text, kin.machine, name="your program")
    joints = joints_of(kin, blocks)
    if out := [words for each in joints for words in kin.machine.out_of_travel(each)]:
        return f"Out of travel: {out[0]}."
    found = match(kin, path, joints, tip=TIP, axis=np.radians(AXIS))
    if len(found.blocks) < len(path):
        return (
            f"No block ends at record {len(found.blocks) + 1}, in its turn: the tip comes within {found.tip:.3f} "
            f"mm of it, with the tool axis {np.degrees(found.axis):.3f}° off."
        )
    moves = between(kin, path, joints, found)
    if why := lifted_away(kin, path, moves):
        return why
    for move in np.flatnonzero(moves.height < LIFTED):
        last = moves.record[move] + 1
        if moves.tip[move] > TIP and not blocks.tcp[move + 1]:
            return f"Between records {last - 1} and {last} the tip strays by {moves.tip[move]:.3f} mm."
        if np.degrees(moves.axis[move]) > AXIS:
            lean = np.degrees(moves.axis[move])
            return f"Between records {last - 1} and {last} the tool axis strays by {lean:.3f}°."
    return wrong_feed(kin, path, joints, blocks, found.blocks[0], moves)


def lifted_away(kin: Kinematics, path: CLData, moves: Between) -> str:
    """Say between which records the tool is lifted although the path is not near the pole there."""
    records = np.unique(moves.record[moves.height >= LIFTED])
    _, away = singular.nearest(kin, path.axes[records - 1], path.axes[records])
    far = records[away > NEAR_POLE]
    if far.size:
        return f"Between records {far[0]} and {far[0] + 1} the tool is lifted, and the part is left uncut there."
    return ""


def wrong_feed(
    kin: Kinematics, path: CLData, joints: np.ndarray, blocks: Blocks, first: int, moves: Between
) -> str:
    """Say which block in cut has neither the feed of the path nor the time that this and the rates require."""
    feeds = np.full(len(joints) - 1, np.nan)
    feeds[first : first + len(moves.record)] = path.feeds[moves.record]
    tips = kin.forward(joints)[0]
    asked = block_times(kin.machine, joints, tips, feeds, ~np.isnan(feeds))
    approach = blocks.feeds[first]
    if not blocks.rapid[first] and np.isnan([approach, blocks.seconds[first]]).all():
        return "On the way to record 1 a block states no feed and no time."
    if not blocks.rapid[first] and abs(approach - path.feeds[0]) > SAME_FEED:
        return f"On the way to record 1 the feed is {approach:g} mm/min; the CL data have {path.feeds[0]:g}."
    for move in np.flatnonzero(moves.height < LIFTED):
        block, record, wanted = first + move + 1, moves.record[move] + 1, path.feeds[moves.record[move]]
        seconds, feed, needed = blocks.seconds[block], blocks.feeds[block], asked[block - 1]
        if blocks.rapid[block]:
            return f"On the way to record {record} a block is rapid, and the tool is in cut."
        if not np.isnan(seconds):
            if not 0.99 * needed - 0.001 <= seconds <= SLOWER * needed + 0.01:
                return (
                    f"On the way to record {record} a block takes {seconds:.3f} s; "
                    f"feed and rates of the machine ask for {needed:.3f} s."
                )
        elif np.isnan(feed):
            return f"On the way to record {record} a block states no feed and no time."
        elif abs(feed - wanted) > SAME_FEED:
            return f"On the way to record {record} the feed is {feed:g} mm/min; the CL data have {wanted:g}."
    return ""
