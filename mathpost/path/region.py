"""The singular region of a path, and the motions that lead through it.

Each comes from one idea: follow the great circle, go over to the other branch, interpolate the rotary angles, lift
the tool, or pass beside. `mathpost.shop.post.ways` times them with the rates of a machine. The cubic itself is in
`mathpost.sources.yu_dan`. Among the motions are the two of source 002 that interpolate X Y Z together with the
angles, for the audit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from mathpost.errors import InputError, MathpostError
from mathpost.path import cl as cldata
from mathpost.path import selection
from mathpost.path.between_blocks import follow, in_the_air, linearize
from mathpost.path.deviation import AXIS_TOLERANCE
from mathpost.path.motion import LIFTED, Motion
from mathpost.path.singular import CLEARANCE, LEAN, distance, refuse_nonsense
from mathpost.sources import yu_dan

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData

STEP = np.radians(5.0)  # rotary step between the nodes of a spline
ASIDE_NODES = 181  # nodes of a path moved aside


class Region:
    """A singular region of a path, and the ways through it as motions.

    `joints`, shape (n, 5), are those chosen for the whole path, mm and radians, windings counted; `region` its
    first and last record (from 0). `tolerance` (mm) is that of the tip in the ways that recompute X Y Z,
    `axis_tolerance` (radians) that of the tool axis in those on its great circle.

    Examples
    --------
    >>> import mathpost
    >>> from mathpost.files import data_file
    >>> kin = mathpost.Kinematics(mathpost.load_machine("dmu50v"))
    >>> blade = mathpost.read_cl(data_file("cl/blade.cl"))
    >>> cubic = Region(kin, blade, selection.choose(kin, blade).joints, (1, 2)).motion("cubic")
    >>> print(np.degrees(cubic.joints[[0, -1], 4]).round(3))
    [178.332  -0.825]
    """

    FOLLOWING = ("direct", "other branch", "retract")
    SAFE = ("direct", "other branch", "linear", "cubic", "cubic lifted", "aside", "retract")
    WAYS = (*SAFE, "paper cubic", "paper clamped")

    def __init__(
        self, kin: Kinematics, cl: CLData, joints: ArrayLike, region: tuple[int, int], *, tolerance: float = 0.01,
        axis_tolerance: float = AXIS_TOLERANCE,
    ) -> None:  # fmt: skip
        self.kin, self.cl, self.joints = kin, cl, np.asarray(joints, dtype=float)
        self.tolerance, self.axis_tolerance = tolerance, axis_tolerance
        self.first, self.last = region
        if not 0 <= self.first < self.last < len(self.joints):
            raise InputError("region", f"two records from 0 to {len(self.joints) - 1}", repr(tuple(region)))
        self.records = np.arange(self.first, self.last + 1)

    def motion(self, name: str, *, lean: float = LEAN, clearance: float = CLEARANCE, points: int = 5) -> Motion:
        """Return one way through as a `Motion`, from the first record of the region to its last.

        The tool axis follows its great circle in ``"direct"``: as chosen; in ``"other branch"``: on the other
        solution from the largest swing on; and in ``"retract"``: at the largest swing lifted by `clearance` (mm, ΔA
        of equation (9)) along the tool axis, swung, and returned, so that no record is left uncut. It leaves the
        circle in ``"linear"``: rotary angles in proportion, X Y Z recomputed; in ``"cubic"``: clamped cubic in the
        rotary angles, X Y Z recomputed; in ``"cubic lifted"``: the same in the air, equations (9), (10); and
        in ``"aside"``: moved aside by at most `lean`, radians. ``"paper cubic"`` and ``"paper clamped"``, for the
        audit: all five coordinates, so many `points` put in.

        Raises `MathpostError` with the reason if the way is not possible, `InputError` for a name that is none.
        """
        self.refuse(name, lean, clearance)
        motions = {
            "direct": self._direct,
            "other branch": self._other_branch,
            "linear": self._linear,
            "cubic": self._cubic,
            "cubic lifted": lambda: self._cubic_lifted(clearance),
            "aside": lambda: self._aside(lean),
            "retract": lambda: self._retract(clearance),
            "paper cubic": lambda: self._of_the_paper(yu_dan.paper_cubic, points),
            "paper clamped": lambda: self._of_the_paper(yu_dan.paper_clamped, points),
        }
        motion = motions[name]()
        if name in self.FOLLOWING:
            motion = follow(self.kin, self.cl, motion, self.axis_tolerance)
        if name in self.SAFE:
            motion = linearize(self.kin, motion, in_the_air(motion, self.tolerance, clearance))
        return motion

    def refuse(self, name: str, lean: float = LEAN, clearance: float = CLEARANCE) -> None:
        """Raise `InputError` for a way that is none, or a lean or clearance that leads nowhere."""
        refuse_nonsense(lean, clearance)
        if name not in self.WAYS:
            raise InputError("way", " or ".join(self.WAYS), repr(name))

    def _direct(self) -> Motion:
        return Motion.on_part(self.joints[self.records], self.records)

    def _other_branch(self) -> Motion:
        """From the largest swing on, the cheapest candidate of each record that is not the chosen one."""
        machine, swing = self.kin.machine, self._largest_swing()
        found = selection.candidates(self.kin, self.cl.points[self.records], self.cl.axes[self.records])
        joints = self.joints[self.records]
        for row in range(swing + 1 - self.first, len(joints)):
            chosen = np.abs(selection.nearest((joints[row] - found.joints[row])[:, 3:])).max(axis=1) < 1e-5
            steps = selection.short_way(machine, found.joints[row] - joints[row - 1])
            costs = np.where(chosen, np.inf, selection.move_costs(machine, steps))
            pick = np.where(found.inside[row], costs, np.inf).argmin()
            if chosen[pick] or not found.inside[row, pick]:
                raise MathpostError(f"{self.cl.where(self.first + row)}: {found.reason(row, int(costs.argmin()))}")
            joints[row] = joints[row - 1] + steps[pick]
        return Motion.on_part(joints, self.records)

    def _linear(self) -> Motion:
        start, end = self.joints[[self.first, self.last], 3:]
        t = (self.records - self.first)[:, None] / (self.last - self.first)
        return self._with_tip_kept(self.records, start + t * (end - start))

    def _cubic(self) -> Motion:
        span, swing = self.last - self.first, np.ptp(self.joints[[self.first, self.last], 3:], axis=0).max()
        n = (int(np.ceil(swing / STEP / span)) + 1) * span - 1  # a point at each record, and others evenly between
        place, joints = yu_dan.smooth(self.kin, self.cl, self.joints, (self.first, self.last), n)
        return Motion.on_part(joints, place)

    def _cubic_lifted(self, clearance: float) -> Motion:
        """Lifted at the first record, before anything turns, and returned at the last one."""
        if self.last - self.first > 1:
            raise MathpostError("the records inside the region would be left uncut")
        on_part = self._cubic()
        over = Motion(
            yu_dan.lifted(self.kin, on_part.joints, clearance), on_part.place, np.full(len(on_part.place), LIFTED)
        )
        return Motion.joined([on_part[:1], over, on_part[-1:]])

    def _aside(self, lean: float) -> Motion:
        place = np.unique(np.r_[np.linspace(self.first, self.last, ASIDE_NODES), self.records])
        tip, axis = self.cl.at(place)
        t = (place - self.first) / (self.last - self.first)
        normal = np.cross(self.cl.axes[self.first], self.cl.axes[self.last])
        if np.linalg.norm(normal) < 1e-9:
            raise MathpostError("the tool axis does not turn here, there is no side to move it to")
        across = normal - (axis @ normal)[:, None] * axis
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        # Nothing at both ends, everything where the path comes nearest to the singular tool axis.
        nearest = np.clip(t[distance(self.kin, axis).argmin()], 0.1, 0.9)
        rise = np.where(t < nearest, t / nearest, (1 - t) / (1 - nearest))
        tilt = lean * np.sin(np.pi / 2 * rise)[:, None] ** 2
        reasons = []
        for side in (1, -1):
            axes = np.cos(tilt) * axis + side * np.sin(tilt) * across
            moved = cldata.from_arrays(tip, axes, name="path moved aside")
            try:
                joints = selection.choose(self.kin, moved, "shortest", start=self.joints[self.first]).joints
            except MathpostError as error:
                reasons.append(str(error))
                continue
            if np.abs(joints[-1] - self.joints[self.last])[3:].max() < 1e-6:
                return self._with_tip_kept(place, joints[:, 3:])
            reasons.append("it comes out on a different branch or winding")
        raise MathpostError("; ".join(dict.fromkeys(reasons)))

    def _retract(self, clearance: float) -> Motion:
        swing, on_part = self._largest_swing(), self._direct()
        over = yu_dan.lifted(self.kin, self.joints[swing : swing + 2], clearance)
        swung = Motion(over, np.array([swing, swing + 1.0]), np.full(2, LIFTED))
        before = swing + 1 - self.first
        return Motion.joined([on_part[:before], swung, on_part[before:]])

    def _of_the_paper(self, cubic: Callable[[np.ndarray, np.ndarray], np.ndarray], points: int) -> Motion:
        rows, t = yu_dan.four_records(self.joints, (self.first, self.last)), np.linspace(0, 1, points + 2)
        return Motion.on_part(cubic(rows, t), self.first + t * (self.last - self.first))

    def _with_tip_kept(self, place: np.ndarray, rotary: np.ndarray) -> Motion:
        """Close the loop at each node."""
        return Motion.on_part(self.kin.close(self.cl.at(place)[0], rotary), place)

    def _largest_swing(self) -> int:
        """The record that the workpiece-side axis swings from."""
        return self.first + int(np.abs(np.diff(self.joints[self.records, self.kin.workpiece_side])).argmax())


def unbroken(regions: list[tuple[int, int]], breaks: Sequence[int]) -> Iterator[tuple[int, int]]:
    """The parts of regions between the records at which the path breaks."""
    for first, last in regions:
        inside = [record for record in breaks if first < record <= last]
        for start, end in zip([first, *inside], [*(record - 1 for record in inside), last], strict=True):
            if start < end:
                yield start, end


def through_the_records(joints: np.ndarray, ways: Sequence[Motion]) -> Motion:
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
