"""A program that somebody else's post wrote: read, simulated along the joints, and compared with the CL data."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mathpost.errors import InputError, one_line
from mathpost.kinematics import Kinematics
from mathpost.machine import UNITS, Machine
from mathpost.path.cl import CLData, from_arrays
from mathpost.path.deviation import AXIS_TOLERANCE, TOLERANCE
from mathpost.path.singular import CONE, from_pole
from mathpost.shop.controls.blocks import Blocks, joined
from mathpost.shop.controls.control import Control, control_for
from mathpost.shop.controls.coordinates import Setup
from mathpost.shop.controls.reader import Program, follow
from mathpost.shop.post.along import SAME_PLACE, Along, Reached, along, kinematics_of, stretches
from mathpost.shop.post.body import BODY
from mathpost.shop.post.clear import HITS, MEETS, UNJUDGED, Ways, judged
from mathpost.shop.post.cuts import touched
from mathpost.shop.post.every_move import why_unsafe
from mathpost.shop.post.explained import Case, explain
from mathpost.shop.post.pace import SAME_FEED, Pace, pace
from mathpost.shop.post.proof import joints_of
from mathpost.shop.post.time_law import asked_by, time_law

SWING = 90.0  # degrees that a rotary axis turns in one block
BETWEEN = (0.25, 0.5, 0.75)  # fractions of a move at which travel is checked, in addition to its ends
SHOWN = 5  # lines of each kind in the report
# Joints, tips and tool axes at the ends of the moves, and the kinematics of each.
Simulated = tuple[np.ndarray, np.ndarray, np.ndarray, list[Kinematics]]


@dataclass(frozen=True)
class Verified:
    """What a program does on a machine; ``print(verified)`` says it."""

    name: str
    control: str
    program: Program
    joints: np.ndarray  # shape (n, 5), mm and radians, at the ends of the moves
    tips: np.ndarray  # shape (n, 3), in the workpiece, mm
    axes: np.ndarray  # shape (n, 3), unit vectors
    names: tuple[str, ...]  # of the joints
    outside: tuple[tuple[int, str], ...]  # a block from 0, which joints are out of travel there or on the way
    swings: tuple[tuple[int, str, float], ...]  # (block, name of the axis, degrees)
    pole: tuple[tuple[int, int, float], ...]  # (first block, last block, least angle from the pole in degrees)
    unsure: tuple[int, ...]  # blocks on whose way in rapid traverse the tool may meet a cut,
    unjudged: tuple[int, ...]  # those that nobody judges: rotary axes turn while others move, each at its own rate,
    hits: tuple[int, ...]  # those on whose way, whatever it is, it hits a fixture,
    blind: tuple[tuple[int, str], ...]  # and lines from or to where nobody knows all axes, with what may be wrong
    together: bool  # whether in rapid traverse all axes arrive together, on a line
    seconds: float  # by the time law; 0 if neither feeds nor rates are known
    records: int  # of the CL data, 0 without
    notes: tuple[str, ...]  # what was made of them
    along: Along | None  # with CL data
    pace: Pace | None  # as far as it is along them
    explained: tuple[str, ...]  # sentences

    @property
    def status(self) -> int:
        """0 agrees, 1 a block is off, out of travel, into a fixture, or rapid where the CL data cut."""
        off = self.along is not None and self.along.off is not None
        return int(bool(self.outside or self.hits) or off or (self.pace is not None and bool(self.pace.rapid)))

    def line(self, block: int) -> int:
        """The line number of a block in the program's text."""
        return int(self.program.lines[block])

    @property
    def cl(self) -> CLData:
        """The poses of the program itself as CL data: for views."""
        return from_arrays(self.tips, self.axes, name=self.name)

    def __str__(self) -> str:
        rows = [("program", f"{self.name}, {self.control}: {len(self.joints)} moves on {self._lines()}")]
        for name, column in zip(self.names, (self.joints * UNITS[: len(self.names)]).T, strict=True):
            unit = "mm" if name in "XYZ" else "°"
            rows.append((name, f"{column.min():z.3f} … {column.max():z.3f} {unit}"))
        if self.seconds:
            rows.append(("time", f"{self.seconds:.1f} s, a control that looks ahead over all axes"))
        rows += self._several("travel", [f"line {self.line(b)}: {why}" for b, why in self.outside], "inside")
        swings = [f"line {self.line(b)}: {name} turns by {turn:.1f}°" for b, name, turn in self.swings]
        rows += self._several("swings", swings, f"no rotary axis turns more than {SWING:g}° in a block")
        passed = [f"lines {self.line(a)} … {self.line(b)}: {least:.3f}° from it" for a, b, least in self.pole]
        rows += self._several("pole", passed, f"never nearer than {np.degrees(CONE):g}°")
        rows += self._ways()
        if skipped := self.program.skipped:
            rows.append(("skipped", ", ".join(f"{count} × {word}" for word, count in skipped.items())))
        rows += [("assumed", sentence) for sentence in self.program.assumed]
        rows += [("made of it", "; ".join(self.notes))] * bool(self.notes)
        rows += self._agreement()
        return "\n".join(f"{key:<10} {one_line(value)}" for key, value in rows)

    def _lines(self) -> str:
        return f"lines {self.line(0)} … {self.line(-1)}"

    def _several(self, key: str, sentences: list[str], otherwise: str) -> list[tuple[str, str]]:
        if not sentences:
            return [(key, otherwise)]
        more = len(sentences) - SHOWN
        return [(key, each) for each in sentences[:SHOWN]] + ([(key, f"and {more} more")] if more > 0 else [])

    def _ways(self) -> list[tuple[str, str]]:
        """What is known of the ways in rapid traverse."""
        order = "the axes arrive together" if self.together else "in whatever order the axes arrive"
        machine, tool = self.program.machines[0][1], f"the tool, {2 * BODY:g} mm across,"
        meets = f"on its way {tool} may meet what is cut{' or the stock' * bool(machine.stock)}, {order}"
        unsure = [f"line {self.line(block)}: {meets}" for block in self.unsure]
        rows = self._several("rapid ways", unsure, f"clear of all cuts, {order}")
        if self.unjudged:
            turn = f"line {self.line(self.unjudged[0])} first, {len(self.unjudged)} in all"
            rows.append(("not judged", f"rapid moves in which rotary axes turn together or with others: {turn}"))
        hits = [f"line {self.line(block)}: on its way {tool} hits it" for block in self.hits]
        rows += self._several("fixture", hits, "clear of all moves") if machine.fixture else []
        if not (machine.stock or machine.fixture):
            rows.append(("not known", "stock and fixture: the machine file names none"))
        if self.blind:
            rows += self._several("not clear", [f"line {line}: {why}" for line, why in self.blind], "")
        if len(self.program.machines) > 1:
            rows.append(("not judged", "a rapid move that is the first after a change of tool or origin"))
        return rows

    def _agreement(self) -> list[tuple[str, str]]:
        if self.along is None:
            return [("CL data", "none: what the program should do was not compared")]
        found, off = self.along, self.along.off
        most = f"tip {found.tip:.4f} mm, tool axis {np.degrees(found.axis):.4f}° off at most"
        over = "over what the CL data cut"
        lifts = [f"lines {self.line(first)} … {self.line(last)}, {over}" for first, last in found.lifts]
        if off is None:
            lifted = self._several("lifted", lifts, "") if lifts else []
            return [("CL data", f"agrees with all {self.records} records: {most}"), *lifted, *self._paces()]
        record = min(int(off.record) + 1, self.records)
        where = {"position": f"line {self.line(off.block)}", "end": f"the end, line {self.line(off.block)},"}
        what = where.get(off.what, f"the way to line {self.line(off.block)}")
        said = f"{what} is off: tip {off.tip:.4f} mm, tool axis {np.degrees(off.axis):.4f}° from record {record}"
        because = [("explained", sentence) for sentence in self.explained] or [
            ("explained", "by nothing that was tried")
        ]
        return [("CL data", said), *because, *self._paces()]

    def _paces(self) -> list[tuple[str, str]]:
        """What is faster or slower than the CL data have it."""
        found = self.pace
        if found is None:
            return []
        rapid = [f"line {self.line(b)}, where the CL data cut to record {r + 1}" for b, r in found.rapid]
        slow = [f"line {self.line(b)}, where they are in rapid traverse to record {r + 1}" for b, r in found.slow]
        feeds = [
            f"line {self.line(b)}: {programmed:.4g} mm/min to record {r + 1}, the CL data have {stated:.4g}"
            for b, r, programmed, stated in found.feeds
        ]
        until = "" if self.along is None or self.along.off is None else ", up to there"
        rows = self._several("rapid", rapid, f"nowhere where the CL data cut{until}")
        rows += self._several("at a feed", slow, "") if slow else []
        same = f"those of the CL data within {SAME_FEED:.0%}, on {found.compared} moves{until}"
        return rows + self._several("feeds", feeds, same if found.compared else "not compared")


def verify(
    text: str, machine: Machine, control: Control | str = "heidenhain", *, cl: CLData | None = None,
    setup: Setup | None = None, tolerance: float = TOLERANCE, axis_tolerance: float = AXIS_TOLERANCE,
    name: str = "program",
) -> Verified:  # fmt: skip
    """Read and simulate a program and, given CL data, compare it with them; `axis_tolerance` in radians.

    `InputError` if it cannot be read, or an offset or the length of a tool is needed that `setup` does not have.
    Where the control moves each axis at its own rate, a rapid move is compared with the CL data at its end alone;
    its way is held against what is cut, and against the stock; all ways are against the fixture.
    """
    if not (0 < tolerance < np.inf and 0 < axis_tolerance < np.pi):
        raise InputError("tolerance", "mm and an angle above 0", f"{tolerance:g}, {np.degrees(axis_tolerance):g}°")
    control = control_for(machine, control)
    setup = _with_offsets(setup or Setup(), machine, control)
    program = follow(text, machine, control, setup=setup, name=name)
    if cl is not None:
        cl = _from_one_origin(cl, program.machines[-1][1], control, setup)
    simulated = _simulated(program)
    joints, tips, axes, kin = simulated
    names = machine.joint_names
    compared = None
    paces = None
    explained: tuple[str, ...] = ()
    if cl is not None:
        compared = _compared(program, simulated, cl, control, tolerance, axis_tolerance)
        right = len(joints) if compared.off is None else compared.off.block
        moves = Reached(joints, kin, program.blocks.tcp, program.blocks.rapid)
        paces = pace(moves, program.blocks, program.lines, tips, cl, compared.place[:right], tolerance)
        if compared.off is not None:

            def words(other: str) -> np.ndarray:
                return follow(other, machine, control, setup=setup, name=name).blocks.words

            def follows(other: str) -> bool:
                again = follow(other, machine, control, setup=setup, name=name)
                poses = _simulated(again)
                if along(poses[1], poses[2], cl, tip=tolerance, axis=axis_tolerance).off is not None:
                    return False  # at the ends of its blocks: their ways take longer
                return _compared(again, poses, cl, control, tolerance, axis_tolerance).off is None

            case = Case(
                text, program.lines, program.blocks.words, program.blocks.tcp, kin, tips, axes, cl, tolerance,
                axis_tolerance, control.begin, words, follows,
            )  # fmt: skip
            explained = explain(case, compared.off)
    return Verified(
        name, control.name, program, joints, tips, axes, names, _outside(program, joints, kin),
        _swings(joints, names), _near_pole(axes, kin), *_ways(program, simulated, control, machine, cl, compared),
        control.rapid_interpolated,
        _seconds(program, control), 0 if cl is None else len(cl), () if cl is None else cl.notes,
        compared, paces, explained,
    )  # fmt: skip


def _with_offsets(setup: Setup, machine: Machine, control: Control) -> Setup:
    """The tables of a control with the work offsets of the machine file; those that are stated take precedence."""
    numbers: dict[int, tuple[float, ...]] = dict(machine.offsets)
    if machine.offset is not None:
        numbers[machine.offset] = machine.origin
    known = {name: at for number, at in numbers.items() if (name := control.work_offsets.name(number))}
    return replace(setup, offsets=known | setup.offsets)


def _from_one_origin(cl: CLData, machine: Machine, control: Control, setup: Setup) -> CLData:
    """CL data that count from the origin of a machine throughout, whatever known work offsets they name."""
    points = []
    for part, _, number in cl.by_setup():
        name = "" if number is None else control.work_offsets.name(number)
        origin = setup.offsets.get(name, machine.origin)
        points.append(part.points + np.subtract(origin, machine.origin))
    return replace(cl, points=np.concatenate(points))


def _simulated(program: Program) -> Simulated:
    """Joints, tips and tool axes at the ends of the moves, and the kinematics of each."""
    blocks = program.blocks
    kin = kinematics_of(program.machines, len(blocks.words))
    joints = np.empty(blocks.words.shape)
    tips, axes = np.empty((len(kin), 3)), np.empty((len(kin), 3))
    for each, rows in stretches(program.machines, len(kin)):
        joints[rows] = joints_of(each, blocks[rows])
        tips[rows], axes[rows] = each.forward(joints[rows])
    return joints, tips, axes, kin


def _compared(
    program: Program, simulated: Simulated, cl: CLData, control: Control, tip: float, axis: float
) -> Along:
    joints, tips, axes, kin = simulated
    free = program.blocks.rapid & (not control.rapid_interpolated)
    moves = Reached(joints, kin, program.blocks.tcp, free)
    return along(tips, axes, cl, tip=tip, axis=axis, moves=moves)


def _outside(program: Program, joints: np.ndarray, kin: list[Kinematics]) -> tuple[tuple[int, str], ...]:
    """Blocks that end out of travel, the first of several with the same joints, or on their way under TCP."""
    found: list[tuple[int, str]] = []
    tcp = program.blocks.tcp
    for machine in dict.fromkeys(kin):
        rows = np.flatnonzero([each is machine for each in kin])
        inside = machine.machine.within(joints[rows])
        ok = inside.all(axis=1)
        anew = ~ok & np.r_[True, (inside[1:] != inside[:-1]).any(axis=1)]
        found += [(int(row), "; ".join(machine.machine.out_of_travel(joints[row]))) for row in rows[anew]]
        follows = np.array([row > 0 and kin[row - 1] is machine for row in rows], bool)
        inner = rows[ok & follows & tcp[rows] & tcp[rows - 1]]
        words = program.blocks.joints
        for t in BETWEEN if inner.size else ():
            mixed = words[inner - 1] + t * (words[inner] - words[inner - 1])
            way = machine.close(mixed[:, :3], mixed[:, 3:])
            out = ~machine.machine.within(way).all(axis=1)
            for row, at in zip(inner[out], way[out], strict=True):
                found.append((int(row), "on the way: " + "; ".join(machine.machine.out_of_travel(at))))
    return tuple(sorted(dict(reversed(found)).items()))


def _swings(joints: np.ndarray, names: tuple[str, ...]) -> tuple[tuple[int, str, float], ...]:
    steps = np.degrees(np.diff(joints[:, 3:], axis=0))
    rows, columns = np.nonzero(np.abs(steps) > SWING)
    return tuple((int(r) + 1, names[3 + c], float(steps[r, c])) for r, c in zip(rows, columns, strict=True))


def _near_pole(axes: np.ndarray, kin: list[Kinematics]) -> tuple[tuple[int, int, float], ...]:
    """Runs of blocks whose tool axis is near the pole."""
    angle = from_pole(kin[0], axes, (0, np.inf))
    near = np.r_[False, angle < CONE, False]
    edges = np.flatnonzero(near[1:] != near[:-1]).reshape(-1, 2)
    return tuple((int(a), int(b) - 1, float(np.degrees(angle[a:b].min()))) for a, b in edges)


def _ways(
    program: Program, simulated: Simulated, control: Control, machine: Machine, cl: CLData | None,
    along: Along | None,
) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...], tuple[tuple[int, str], ...]]:  # fmt: skip
    """Blocks on whose way the tool may meet a cut, those not judged, those into a fixture, and other lines.

    The last are lines with moves from or to where nobody knows all axes, and what may be wrong with each. What is
    cut the CL data say; without them it is all that the program runs along at a feed.
    """
    joints, tips, axes, kin = simulated
    blocks, interpolated = program.blocks, control.rapid_interpolated
    blind = {each.block for each in program.blind if not np.isnan(each.end).any()}
    from_known = ~np.isin(np.arange(len(kin)), list(blind))
    if cl is not None and along is not None:
        origin = kin[-1].machine.origin
        cuts = touched([(part, origin) for part, _, _ in cl.by_setup()], machine, machine.origin)
        place = np.nan_to_num(np.fmax.accumulate(along.place), nan=-1.0)
    else:
        origins = np.array([each.machine.origin for each in kin])
        run = replace(from_arrays(tips + origins, axes), rapid=blocks.rapid | ~from_known)
        cuts = touched([(run, np.zeros(3))], machine, machine.origin)
        place = np.arange(len(kin), dtype=float)
    never, cutting = np.zeros(len(kin), bool), ~blocks.rapid
    if cl is not None and along is not None:  # in cut are those alone that the CL data have in cut
        on = np.ceil(np.nan_to_num(along.place) - SAME_PLACE).astype(int)
        cutting = cutting & ~np.isnan(along.place) & ~cl.rapid[np.minimum(on, len(cl) - 1)]
    onto = np.where(np.append(cutting[1:], False), np.arange(len(kin)), -1)
    ways = Ways(joints, place, interpolated | ~blocks.rapid, blocks.tcp, onto, never, cutting)
    unsure, unjudged, hits = [], [], []
    for each, rows in stretches(program.machines, len(kin)):
        first = rows.start + 1
        moves = first + np.flatnonzero(from_known[first : rows.stop])
        found = judged(each, ways, moves, cuts.moved(np.negative(each.machine.origin)))
        unsure += moves[found == MEETS].tolist()
        unjudged += moves[found == UNJUDGED].tolist()
        hits += moves[found == HITS].tolist()
    others = []
    for step in program.blind:
        before = float(place[step.block - 1]) if step.block else -1.0
        if why := why_unsafe(step, cuts.moved(np.negative(step.machine.origin)), before, interpolated):
            others.append((step.line, why))
    return tuple(unsure), tuple(unjudged), tuple(hits), tuple(others)


def _seconds(program: Program, control: Control) -> float:
    total, edges = program.dwell, [first for first, _ in program.machines] + [len(program.lines)]
    for (first, machine), stop in zip(program.machines, edges[1:], strict=True):
        part = program.blocks[first:stop]
        if not first and not np.isnan(program.began).any():
            missing = np.array([np.nan])
            start = Blocks(program.began[None], missing, missing, np.array([True]), part.tcp[:1])
            part = joined([start, part])
        if len(part.words) > 1:
            joints, asked = asked_by(Kinematics(machine), part, control)
            total += float(time_law(machine, joints, np.nan_to_num(asked)).seconds[-1])
    return total
