"""Ways through a singular region, each with the same figures, so that they can be compared.

Among them are the two cubics that source 002 means (the one its table 3 was made with, and the one its equation (7)
describes); they interpolate X Y Z together with the angles, so the tip leaves the part, and are here for the audit.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from mathpost.errors import InputError, MathpostError, ReachError
from mathpost.post import cl as cldata
from mathpost.post import selection, travel
from mathpost.post.deviation import deviation
from mathpost.post.linearization import linearize
from mathpost.post.singularity import distance

STEP = np.radians(5.0)  # rotary step between the nodes of a spline
ASIDE_NODES = 181  # nodes of a path moved aside
LEAN = np.radians(1.0)
CLEARANCE = 20.0  # mm


@dataclass(frozen=True)
class Passage:
    """One way through a region.

    Attributes
    ----------
    name : str
    joints : ndarray, shape (m, 5)
        From the first record of the region to the last, mm and radians; empty if the way is not possible.
    place : ndarray, shape (m,)
        Where each stands on the CL path: 2.25 is a quarter of the way from record 2 to record 3.
    lifted : ndarray of bool, shape (m,)
        Whether the pose is off the part, retracted along the tool axis.
    peak_rate : float
        Largest rate that the outer rotary axis needs in cut to keep the stated feed, rad/s.
    per_record : bool
        Whether no feed is stated and `peak_rate` is in rad per record, the paper's virtual time, instead.
    tip_error, axis_error : float
        Largest distance (mm) and angle (radians) of the moves in cut from the CL data.
    time : float
        Seconds, the slowest axis waited for; what feed or rates are known counts.
    reason : str
        Why the way is not possible, or "".
    """

    name: str
    joints: np.ndarray
    place: np.ndarray
    lifted: np.ndarray
    peak_rate: float = np.nan
    tip_error: float = np.nan
    axis_error: float = np.nan
    time: float = np.nan
    per_record: bool = False
    reason: str = ""

    @property
    def blocks(self):
        """Number of moves."""
        return max(len(self.joints) - 1, 0)


class Crossing:
    """A singular region of a path, and the ways through it.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    joints : array_like, shape (n, 5)
        The chosen joints of the whole path, mm and radians, windings counted.
    region : (int, int)
        First and last record (from 0), as `mathpost.post.singularity.regions` gives them.
    tolerance : float
        mm; how near the tip must stay to the CL data in the ways that recompute X Y Z.
    """

    WAYS = ("direct", "other branch", "linear", "cubic", "aside", "retract", "paper cubic", "paper clamped")
    SAFE = ("direct", "other branch", "linear", "cubic", "aside", "retract")

    def __init__(self, kin, cl, joints, region, *, tolerance=0.01):
        self.kin, self.cl, self.joints, self.tolerance = kin, cl, np.asarray(joints, dtype=float), tolerance
        self.first, self.last = region
        if not 0 <= self.first < self.last < len(self.joints):
            raise InputError("region", f"two records from 0 to {len(self.joints) - 1}", repr(tuple(region)))
        self.outer = kin.symbols.index(kin.inverse_symbolic.outer)

    def compare(self, **options):
        """Return all ways as a list of `Passage`; one that is not possible says why."""
        return [self.way(name, **options) for name in self.WAYS]

    def safe(self, name, **options):
        """Return one of the ways that cut no part, or raise `ReachError` if it is not possible."""
        way = self.way(name, **options)
        if way.reason:
            first, last = self.first + 1, self.last + 1
            raise ReachError(f"{self.cl.name}: no way {name!r} from record {first} to {last}: {way.reason}")
        return way

    def way(self, name, *, lean=LEAN, clearance=CLEARANCE, points=5):
        """Return one way through as a `Passage`.

        Parameters
        ----------
        name : str
            ``"direct"``: as chosen, one block from record to record. ``"other branch"``: on the other solution
            from the largest swing on. ``"linear"``: rotary angles in proportion, X Y Z recomputed. ``"cubic"``:
            clamped cubic in the rotary angles, X Y Z recomputed. ``"aside"``: the tool axis moved aside by at
            most `lean`. ``"retract"``: at the largest swing lifted by `clearance` along the tool axis,
            swung, and returned, so that no record is left uncut.
            ``"paper cubic"`` and ``"paper clamped"``: all five coordinates, for the audit.
        lean : float
            Radians.
        clearance : float
            mm; ΔA of equation (9).
        points : int
            Points that the paper's cubics put in.
        """
        ways = {
            "direct": self._direct,
            "other branch": self._other_branch,
            "linear": self._linear,
            "cubic": self._cubic,
            "aside": lambda: self._aside(lean),
            "retract": lambda: self._retract(clearance),
            "paper cubic": lambda: self._paper(paper_cubic, points),
            "paper clamped": lambda: self._paper(paper_clamped, points),
        }
        if name not in ways:
            raise InputError("way", " or ".join(ways), repr(name))
        try:
            joints, place, lifted = ways[name]()
        except MathpostError as error:
            return Passage(name, np.empty((0, 5)), np.empty(0), np.empty(0, bool), reason=str(error))
        return self._measured(Passage(name, joints, place, lifted))

    def _direct(self):
        return (
            self.joints[self.first : self.last + 1],
            self._records(),
            self._on_the_part(self.last - self.first + 1),
        )

    def _other_branch(self):
        swing = self._largest_swing()
        chosen = [self.joints[self.first : swing + 1]]
        found = selection.candidates(self.kin, self.cl.points, self.cl.axes)
        for record in range(swing + 1, self.last + 1):
            before = chosen[-1][-1]
            now = self.joints[record] - found.joints[record]
            is_chosen = np.abs(travel.nearest(now[:, 3:])).max(axis=1) < 1e-5
            steps = travel.short_way(self.kin.machine, found.joints[record] - before)
            costs = np.where(is_chosen, np.inf, travel.move_costs(self.kin.machine, steps))
            pick = np.where(found.inside[record], costs, np.inf).argmin()
            if not found.inside[record, pick] or is_chosen[pick]:
                out = int(np.where(is_chosen, np.inf, costs).argmin())
                raise MathpostError(f"{self.cl.where(record)}: {found.reason(record, out)}")
            chosen.append((before + steps[pick])[None])
        return np.concatenate(chosen), self._records(), self._on_the_part(self.last - self.first + 1)

    def _linear(self):
        start, end = self.joints[[self.first, self.last], 3:]
        place = self._records()
        t = (place - self.first)[:, None] / (self.last - self.first)
        return self._with_tip_kept(place, start + t * (end - start))

    def _cubic(self):
        start, end = self._end_slopes()
        ends = self.joints[[self.first, self.last], 3:]
        spline = CubicSpline([self.first, self.last], ends, bc_type=((1, start[3:]), (1, end[3:])))
        steps = int(np.ceil(np.abs(np.diff(ends, axis=0)).max() / STEP / (self.last - self.first))) + 1
        place = np.linspace(self.first, self.last, steps * (self.last - self.first) + 1)
        return self._with_tip_kept(place, spline(place))

    def _aside(self, lean):
        place = np.linspace(self.first, self.last, ASIDE_NODES)
        place = np.unique(np.r_[place, self._records()])
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
            moved = cldata.from_arrays(
                tip, np.cos(tilt) * axis + side * np.sin(tilt) * across, name="path moved aside"
            )
            try:
                start = self.joints[self.first]
                joints = selection.choose(self.kin, moved, "shortest", start=start).joints
            except MathpostError as error:
                reasons.append(str(error))
                continue
            if np.abs(joints[-1] - self.joints[self.last])[3:].max() < 1e-6:
                return self._with_tip_kept(place, joints[:, 3:])
            reasons.append("it comes out on another branch or winding")
        raise MathpostError("; ".join(dict.fromkeys(reasons)))

    def _retract(self, clearance):
        swing = self._largest_swing()
        before, after = self.joints[: swing + 1][self.first :], self.joints[swing + 1 : self.last + 1]
        lifted = self.cl.points + clearance * self.cl.axes
        over = self.kin.close(lifted[[swing, swing + 1]], self.joints[[swing, swing + 1], 3:])
        swung = linearize(self.kin, over, self.tolerance)
        joints = np.concatenate([before, swung.joints, after])
        place = np.r_[np.arange(self.first, swing + 1), swing + swung.place, np.arange(swing + 1, self.last + 1)]
        lifted = np.r_[np.zeros(len(before), bool), np.ones(len(swung.place), bool), np.zeros(len(after), bool)]
        return joints, place.astype(float), lifted

    def _paper(self, cubic, points):
        self._end_slopes()
        rows = self.joints[[self.first - 1, self.first, self.last, self.last + 1]]
        t = np.linspace(0, 1, points + 2)
        joints = cubic(rows, t)
        return joints, self.first + t * (self.last - self.first), self._on_the_part(len(t))

    def _with_tip_kept(self, place, rotary):
        """Close the loop at each node and divide the moves until the tip keeps the tolerance."""
        divided = linearize(self.kin, self.kin.close(self.cl.at(place)[0], rotary), self.tolerance)
        return (
            divided.joints,
            np.interp(divided.place, np.arange(len(place)), place),
            self._on_the_part(len(divided.place)),
        )

    def _end_slopes(self):
        """Change of the joints per record before and after the region, equation (7) with Δt = 1."""
        if self.first == 0 or self.last == len(self.joints) - 1:
            raise MathpostError("a spline needs a record before the region and one after it")
        before = self.joints[self.first] - self.joints[self.first - 1]
        return before, self.joints[self.last + 1] - self.joints[self.last]

    def _largest_swing(self):
        swings = np.abs(np.diff(self.joints[self.first : self.last + 1, self.outer]))
        return self.first + int(swings.argmax())

    def _records(self):
        return np.arange(self.first, self.last + 1, dtype=float)

    def _on_the_part(self, count):
        return np.zeros(count, dtype=bool)

    def _measured(self, passage):
        joints, place, cutting = passage.joints, passage.place, in_cut(passage.lifted)
        tips, axes = self.cl.at(place)
        tip_error, axis_error = deviation(
            self.kin, joints[:-1], joints[1:], tips=(tips[:-1], tips[1:]), axes=(axes[:-1], axes[1:])
        )
        reached, feeds = self.kin.forward(joints)[0], self.cl.feeds[np.ceil(place[1:]).astype(int)]
        seconds = feed_times(reached, feeds)
        interval = np.where(np.isnan(seconds), np.diff(place), seconds)
        swing = np.abs(np.diff(joints[:, self.outer]))
        rate = np.divide(swing, interval, out=np.full(len(swing), np.inf), where=interval > 1e-9)
        rate[swing < 1e-12] = 0
        return replace(
            passage,
            peak_rate=rate[cutting].max(initial=0),
            tip_error=tip_error[cutting].max(initial=0),
            axis_error=axis_error[cutting].max(initial=0),
            time=block_times(self.kin.machine, joints, reached, feeds, cutting).sum(),
            per_record=bool(np.isnan(seconds).any()),
        )


def paper_cubic(rows, t):
    """The cubic of table 3 of source 002: one polynomial through four records at −1, 0, 1, 2, all five joints.

    The source does not say so; all 25 printed numbers do. `rows` has shape (4, 5), `t` runs from 0 to 1.
    """
    return CubicSpline([-1, 0, 1, 2], rows, bc_type="not-a-knot")(t)


def paper_clamped(rows, t):
    """The cubic of the text of source 002: between the middle two of four records, end slopes by equation (7)."""
    return CubicSpline([0, 1], rows[1:3], bc_type=((1, rows[1] - rows[0]), (1, rows[3] - rows[2])))(t)


def in_cut(lifted):
    """Whether the moves between poses are in cut: both ends on the part. Shape (m - 1,) from (m,)."""
    return ~(lifted[:-1] | lifted[1:])


def feed_times(tip, feeds):
    """Times (s) that the feed gives the moves between tips (m, 3), shape (m - 1,); NaN where none is stated."""
    step = np.diff(tip, axis=0)
    return 60 * np.sqrt((step * step).sum(axis=1)) / feeds


def block_times(machine, joints, tip, feeds, cutting):
    """Times (s) that the moves between joints (m, 5) take: what the feed asks in cut, or the slowest axis needs.

    `tip`, shape (m, 3), is where the joints put the tool; `feeds` and `cutting`, shape (m - 1,), are those of the
    moves. On a machine that states no rates, no axis goes faster than the feed, in mm and degrees per minute; zero
    where there is no feed either.
    """
    rates, steps = machine.max_rates, np.abs(np.diff(joints, axis=0))
    if np.isnan(rates).all():
        degrees = np.array([1, 1, 1, *np.degrees([1, 1])])
        by_axis = np.nan_to_num(60 * (steps * degrees).max(axis=1) / feeds)
    else:
        by_axis = (steps / np.where(np.isnan(rates), np.inf, rates)).max(axis=1)
    return np.fmax(by_axis, np.where(cutting, feed_times(tip, feeds), 0))
