"""Whether the tool's body stays clear of what is around it, on a known way, and where nobody knows the way.

Where a control moves each axis at its own rate, a rapid move starts all axes at once, and each stops when it is
there. The tool leaves the straight line; how far, and to which side, depends on rates and accelerations. Whatever
they are, the slides stay in the box between both ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mathpost.path.deviation import levers
from mathpost.shop.post.body import ABOVE, AROUND, BODY, LEAST_BODY, MANY_POINTS, Body, in_body, moving
from mathpost.shop.post.cuts import BORDER, Cuts
from mathpost.shop.post.solids import LEAST, Near, in_reach, meets, within

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics

MOST_PARTS = 40  # of a turn that are looked at
TIED = 1.1  # two axes move a point this much farther, at most, than one after the other
MEETS, CLEAR, UNJUDGED, HITS = range(4)  # what is found of a way: cuts or stock, nothing, not known, a fixture


@dataclass(frozen=True)
class Ways:
    """The moves from each row of `joints` to the next, and what is known of how they go."""

    joints: np.ndarray  # shape (n, j), mm and radians
    place: np.ndarray  # shape (n,), how far on the path all cuts before the end of each row are
    straight: np.ndarray  # shape (n,), whether all axes arrive at each row together
    tcp: np.ndarray  # shape (n,), and then the tip goes straight, not the joints
    onto: np.ndarray  # shape (n,), the row at which the CL data go on behind the move to each row, or -1
    lifted: np.ndarray  # shape (n,), whether the move to each row is one of approach or retract
    cutting: np.ndarray  # shape (n,), whether it is in cut: what it may not meet is the fixture alone


def judged(kin: Kinematics, ways: Ways, rows: np.ndarray, cuts: Cuts) -> np.ndarray:
    """Return for the moves to some rows whether the tool is `CLEAR` of all around it, or `MEETS` or `HITS` it.

    Of axes that arrive at their own times every order counts; where that takes too many steps a way is `UNJUDGED`.
    What the tool has in its body, or above, where the CL data go on is theirs, and does not count, but for a
    fixture; if a rapid move comes there along its own axis no more than its end, `BODY` mm, is.
    """
    steps = moving(kin, ways.joints)[rows - 1]
    alone, turns = steps.sum(axis=1) == 1, steps[:, 3:].any(axis=1)
    found = np.where(steps.any(axis=1) & (cuts.ends.size > 0), UNJUDGED, CLEAR)
    cutting = np.flatnonzero((found != CLEAR) & ways.cutting[rows])
    found[cutting[~_reaches(kin, ways, rows[cutting], cuts)]] = CLEAR
    known = alone | ways.straight[rows]
    for move in np.flatnonzero(turns & (known | ways.tcp[rows]) & (found != CLEAR)):
        found[move] = _turned(kin, ways, rows[move], cuts)
    for move in np.flatnonzero(turns & ~known & (~ways.tcp[rows] | (found == CLEAR)) & steps.any(axis=1)):
        found[move] = _in_any_order(kin, ways, rows[move], cuts)
    slides = np.flatnonzero((found != CLEAR) & ~turns)
    if not slides.size:
        return found
    positions, group = np.unique(ways.joints[rows[slides], 3:].round(9), axis=0, return_inverse=True)
    order = np.argsort(group, kind="stable")
    for angles, moves in zip(positions, np.split(slides[order], np.cumsum(np.bincount(group))[:-1]), strict=True):
        found[moves] = _slid(kin, ways, rows[moves], known[moves], angles, cuts)
    return found


def _reaches(kin: Kinematics, ways: Ways, rows: np.ndarray, cuts: Cuts) -> np.ndarray:
    """Which of the moves to some rows may come near the fixture: the body is between its ends, or little beside."""
    if not cuts.fixture:
        return np.zeros(len(rows), bool)
    poses = [(ways.joints[at], *kin.forward(ways.joints[at])) for at in (rows - 1, rows)]
    ends = np.array([tips + length * axes for _, tips, axes in poses for length in (0, _length(kin))])
    turned = np.abs(poses[1][0] - poses[0][0])[:, 3:].sum(axis=1)
    off = BODY + turned * (levers(kin.machine) + np.abs(ends).sum(axis=2).max(axis=0))
    return in_reach(cuts.fixture, ends.min(axis=0) - off[:, None], ends.max(axis=0) + off[:, None])


def _slid(
    kin: Kinematics, ways: Ways, rows: np.ndarray, straight: np.ndarray, angles: np.ndarray, cuts: Cuts
) -> np.ndarray:
    """What is found of ways on which slides move alone, at some angles of the rotary axes."""
    ends = ways.joints[[rows - 1, rows], :3]
    body = _body(kin, angles)
    of_lines = placed(kin, cuts.lines, angles)
    lowest = (ends @ body.axis).mean(axis=0) - np.abs(ends[1] - ends[0]) @ np.abs(body.axis) / 2
    found = np.where(lowest + ABOVE > (placed(kin, cuts.ends, angles) @ body.axis).max(), CLEAR, MEETS)
    boxes = of_lines.min(axis=0).T.copy(), of_lines.max(axis=0).T.copy()
    for move in np.flatnonzero(found == MEETS):
        both, known = ends[:, move], bool(straight[move])
        lines = body.near(both, *boxes)
        lines = lines[body.meets(both, of_lines[:, lines], known)]
        near = _near(kin, body, both, angles, known)
        found[move] = _found(kin, ways, rows[move], cuts, near, cuts.some(lines).points)
    return found


def _turned(kin: Kinematics, ways: Ways, row: int, cuts: Cuts) -> int:
    """What is found of a known way on which rotary axes turn: poses a fifth of the body's radius apart."""
    start, end = ways.joints[row - 1], ways.joints[row]
    length = _length(kin)
    tips, _ = kin.forward(start + np.linspace(0, 1, AROUND + 1)[:, None] * (end - start))
    away = np.linalg.norm(np.diff(tips, axis=0), axis=1).sum() + np.abs(end - start)[3:].sum() * length
    share = np.linspace(0, 1, int(min(MANY_POINTS, 2 + away / (BODY / 5))))[:, None]
    tips, axes = kin.forward(start + share * (end - start))
    if ways.tcp[row]:
        tips = tips[0] + share * (tips[-1] - tips[0])

    def near(points: np.ndarray, margin: float) -> np.ndarray:
        return in_body(points, tips, axes, length, margin)

    return _found(kin, ways, row, cuts, near, cuts.points)


def _in_any_order(kin: Kinematics, ways: Ways, row: int, cuts: Cuts) -> int:
    """What is found of a way on which slides and rotary axes are anywhere between their ends.

    The box of the slides is looked at in the middle of a part of the turn, and as much farther as the rest of that
    part moves anything; what is not clear then is divided.
    """
    ends = ways.joints[[row - 1, row]]
    slides, around = ends[:, :3], np.array([cuts.ends.min(axis=0), cuts.ends.max(axis=0)])
    corners = np.array(list(product(*around.T)))
    parts = [(ends[:, 3:].min(axis=0), ends[:, 3:].max(axis=0))]
    for _ in range(MOST_PARTS):
        low, high = parts.pop()
        angles = (low + high) / 2
        body, at = _body(kin, angles), placed(kin, corners, angles)
        margin = 0.0
        for turned in angles + np.diag(high - angles):
            turns = np.linalg.norm(_body(kin, turned).axis - body.axis) * body.length
            margin += TIED * (np.linalg.norm(placed(kin, corners, turned) - at, axis=1).max() + turns)
        near = _near(kin, body, slides, angles, False, margin)
        lowest = (slides @ body.axis).mean() - np.abs(slides[1] - slides[0]) @ np.abs(body.axis) / 2
        above = lowest + ABOVE - margin > (at @ body.axis).max()
        least = max(LEAST, margin / 2)
        found = CLEAR if above else _found(kin, ways, row, cuts, near, cuts.points, least)
        if found != CLEAR and margin < BODY / 5:
            return found
        if found != CLEAR:
            widest = np.arange(len(low)) == (high - low).argmax()
            parts += [(low, np.where(widest, angles, high)), (np.where(widest, angles, low), high)]
        if not parts:
            return CLEAR
    return UNJUDGED


def _body(kin: Kinematics, angles: np.ndarray) -> Body:
    """The body at rotary angles, in the coordinates of the slides."""
    _, axis = kin.forward(np.r_[np.zeros(3), angles])
    return Body((kin.close(axis, angles) - kin.close(np.zeros(3), angles))[:3], _length(kin))


def _near(
    kin: Kinematics, body: Body, slides: np.ndarray, angles: np.ndarray, straight: bool, margin: float = 0.0
) -> Near:
    """Return what says of points whether the body is near them while slides move between two ends, (2, 3)."""

    def near(points: np.ndarray, more: float) -> np.ndarray:
        return body.meets(slides, placed(kin, points, angles)[None], straight, margin + more)

    return near


def _found(
    kin: Kinematics, ways: Ways, row: int, cuts: Cuts, near: Near, points: np.ndarray, least: float = LEAST
) -> int:
    """What is found of the way to a row, near which the body may have some of the cuts' points, (n, 3)."""
    if any(meets(solid, near, lambda points: np.ones(len(points), bool), least) for solid in cuts.fixture):
        return HITS
    if ways.cutting[row]:
        return CLEAR

    def there(points: np.ndarray, border: float = BORDER) -> np.ndarray:
        return _are_there(kin, ways, row, cuts, points, border)

    points = points[near(points, 0.0)]
    if cuts.stock:  # of what is cut, the rest is air
        points = points[within(cuts.stock, points)]
    met = there(points, 0.0).any() or any(meets(solid, near, there, least) for solid in cuts.stock)
    return MEETS if met else CLEAR


def _length(kin: Kinematics) -> float:
    """That of the body, mm."""
    return max(kin.machine.tool_length, LEAST_BODY)


def placed(kin: Kinematics, points: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Where the slides put the tip on points of the workpiece, (..., 3), at rotary angles, (..., k): (..., 3)."""
    shape = np.broadcast_shapes(points.shape[:-1], angles.shape[:-1])
    points, angles = (np.broadcast_to(each, (*shape, each.shape[-1])) for each in (points, angles))
    return kin.close(points, angles)[..., :3]


def _are_there(
    kin: Kinematics, ways: Ways, row: int, cuts: Cuts, points: np.ndarray, border: float
) -> np.ndarray:  # fmt: skip
    """Whether points, (n, 3), that the body meets on the way to a row are there then, and no cut's own.

    Its own are those in the body, or as near to it as `border`, mm: of a solid the edge of the body is met, too.
    """
    there = ~cuts.gone(points, ways.place[row - 1])
    if (onto := ways.onto[row]) >= 0 and there.any():
        tips, axes = kin.forward(ways.joints[[row - 1, onto]])
        plunge = (
            onto == row and not ways.lifted[row] and np.linalg.norm(np.cross(tips[1] - tips[0], axes[1])) < ABOVE
        )
        there &= ~in_body(points, tips[1:], axes[1:], BODY if plunge else np.inf, border)
    return there
