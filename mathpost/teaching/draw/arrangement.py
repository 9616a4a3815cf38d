"""The bodies of a machine as simple solids, for any arrangement of its two rotary axes.

A machine file has axes, not castings, so the solids are invented around the axes: from the workpiece down to the
bed, and from the tool up to the slides, each body is the hull between the bearing that carries it and those that it
carries. A bearing is square to its axis: one on both sides where the axis lies across (trunnion, fork), otherwise
one on one side (turntable, nutating head).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost import chain
from mathpost.formula import numeric
from mathpost.rotation import unit
from mathpost.teaching.draw.colours import COLOUR
from mathpost.teaching.draw.part import BLADE_COLOUR, Part
from mathpost.teaching.draw.solid import Hull, Lofted, Profile, Solid, Turned, block, put, ring

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.machine import Machine, Rotary
    from mathpost.path.cl import CLData

UP = np.array([0.0, 0.0, 1.0])
ACROSS = 0.5  # an axis at more than 60 degrees from what it carries gets a bearing on both sides
BLADE = [(0.0, 0.07), (0.5, 0.055), (0.93, 0.035), (0.98, 0.025)]  # height and half width of a blade
# Profiles in shares of radius and height: a round table with a bevel and two grooves, a holder from half the tool's
# length to the spindle's face with cone, groove and flange, a spindle.
TABLE = [(0, 0), (0.94, 0), (1, 0.25), (1, 0.92), (0.98, 1), (0.86, 1), (0.86, 0.85), (0.82, 0.85), (0.82, 1)]
TABLE += [(0.62, 1), (0.62, 0.85), (0.58, 0.85), (0.58, 1), (0, 1)]
HOLDER = [(0, 0.5), (0.55, 0.5), (0.7, 0.82), (1, 0.82), (1, 0.87), (0.9, 0.91), (1, 0.95), (1, 1), (0, 1)]
SPINDLE = [(0, 0), (0.8, 0), (1, 0.24), (1, 1), (0, 1)]
GREYS = {  # the machine's role, one shade a body
    "bed": "#9aa3aa",
    "first": "#b3bcc4",
    "second": "#d3d9de",
    "bearing": "#68737c",
    "wall": "#f4f6f8",
    "holder": "#a7afb6",
}


@dataclass
class Arrangement:
    """The solids of a machine, each in its body's coordinates, and the lines of its rotary axes."""

    size: float  # mm, the unit of all proportions
    home: np.ndarray  # joints (5,) of the layout: rotary zero, the tool above the workpiece
    into: dict[str, np.ndarray]  # body → 4×4 matrix from the machine's coordinates to its own
    solids: list[Solid] = field(default_factory=list)
    # joint → ends of its axis (2, 3), in its body's coordinates
    lines: dict[str, np.ndarray] = field(default_factory=dict)
    plate: np.ndarray = field(init=False)  # the bed's corners (8, 3), once it is placed
    retreat: float = 0.0  # mm, the furthest that the tool's slides go back when the rotary axes turn about the tip

    def hull(self, body: str, shade: str, *corners: np.ndarray) -> None:
        """Add the hull of these points, `shade` one of `GREYS` or a colour."""
        self.solids.append(Hull(body, GREYS.get(shade, shade), put(self.into[body], np.concatenate(corners))))

    def lathe(
        self,
        body: str,
        shade: str,
        profile: Profile,
        radius: float,
        height: float,
        origin: np.ndarray,
        axis: np.ndarray,
    ) -> None:
        """Add a turned solid, its profile in shares of radius and height."""
        scaled, into = [(radius * r, height * h) for r, h in profile], self.into[body]
        self.solids.append(Turned(body, GREYS.get(shade, shade), scaled, put(into, origin), into[:3, :3] @ axis))

    def disc(self, body: str, middle: np.ndarray, axis: np.ndarray, radius: float) -> None:
        """Add a dark disc: a bearing."""
        height, bevel = 0.12 * self.size, 0.08 * radius
        rim = [(radius - bevel, 0), (radius, bevel), (radius, height - bevel), (radius - bevel, height)]
        self.lathe(body, "bearing", [(0, 0), *rim, (0, height)], 1, 1, middle - height / 2 * axis, axis)

    def turns(self, body: str, bearings: list[np.ndarray], axis: np.ndarray, radius: float) -> list[np.ndarray]:
        """Show the axis of a body by a line, and a disc at every bearing; return the bearings."""
        for bearing in bearings:
            self.disc(body, bearing.mean(axis=0), axis, radius)
        self.line(body, bearings, axis)
        return bearings

    def line(self, body: str, bearings: list[np.ndarray], axis: np.ndarray) -> None:
        """Set the line of a rotary axis, a little longer than its bearings."""
        points = np.concatenate(bearings)
        along, foot = points @ axis, points.mean(axis=0)
        ends = np.array([[along.min() - 0.3 * self.size], [along.max() + 0.3 * self.size]])
        self.lines[body] = put(self.into[body], foot - foot @ axis * axis + ends * axis)

    def join(self, body: str, shade: str, carried: list[np.ndarray], bearings: list[np.ndarray]) -> None:
        """Add the hull of every carried ring and every bearing."""
        for pair in product(carried, bearings):
            self.hull(body, shade, *pair)


@lru_cache(maxsize=32)
def placing(machine: Machine) -> Callable[[ArrayLike], dict[str, np.ndarray]]:
    """Compile `mathpost.chain.bodies`: a function from joints, shape (k,), to a dict of 4×4 matrices."""
    pairs = chain.bodies(machine)
    compiled = numeric(sp.ImmutableMatrix.vstack(*(m for _, m in pairs)), chain.joint_symbols(machine))

    def places(joints: ArrayLike) -> dict[str, np.ndarray]:
        matrices = compiled(*np.asarray(joints, dtype=float)).reshape(-1, 4, 4)
        return {"bed": np.eye(4)} | dict(zip([name for name, _ in pairs], matrices, strict=True))

    return places


def arrange(kin: Kinematics, cl: CLData | None = None, part: Part | None = None) -> Arrangement:
    """Lay out the `Arrangement` of a machine, the workpiece fitted to the path `cl` if there is one.

    A `Part` replaces the sketch of a blade.
    """
    machine = kin.machine
    size = _size(machine, cl)
    low, high = _workpiece(size, cl, part)
    tool_axis = unit(np.array(machine.tool_axis))
    tip = 0.3 * size * tool_axis if cl is None else np.array([*(low + high)[:2] / 2, high[2]])
    home, origin = kin.close(tip, np.zeros(len(machine.rotary))), np.array(machine.origin)
    made = Arrangement(size, home, {name: np.linalg.inv(at) for name, at in placing(machine)(home).items()})
    if "Y" in machine.slides_that_carry("tool"):
        angles = np.radians(list(product(range(-180, 181, 30), repeat=len(machine.rotary))))
        made.retreat = kin.close(tip, np.clip(angles, *machine.limits[3:].T))[:, 1].max() - home[1]
    stock = block(origin + low, origin + high)
    made.hull("workpiece", COLOUR["workpiece"], stock)
    if part is not None:
        made.solids.append(part.solid)
    elif cl is not None and _is_point(size, cl):
        rings = [put(made.into["workpiece"], origin + ring) for ring in _blade(size, cl, high[2])]
        made.solids.append(Lofted("workpiece", BLADE_COLOUR, rings))
    _workpiece_side(made, machine, stock)
    _tool_side(made, machine, origin + tip, tool_axis, 0.04 * size if part is None else part.tool_radius)
    return made


def _size(machine: Machine, cl: CLData | None) -> float:
    """The size of a machine: a length that suits its tool, offsets and path."""
    lengths, origin = [80.0, 0.9 * machine.tool_length], np.array(machine.origin)
    for each in machine.rotary:
        if each.carries == "workpiece":
            lengths.append(float(np.linalg.norm(origin - _foot(each, origin))))
        else:
            lengths.append(0.8 * float(np.linalg.norm(_foot(each, np.zeros(3)))))
    if cl is not None:
        lengths += [1.1 * np.ptp(cl.points, axis=0).max(), 1.2 * np.linalg.norm(cl.points, axis=1).max()]
    return max(lengths)


def _workpiece(size: float, cl: CLData | None, part: Part | None) -> tuple[np.ndarray, np.ndarray]:
    """Opposite corners of the workpiece in its frame; a path, a blade or a part is on its top."""
    if part is not None:
        foot = part.rings[0]
    elif cl is not None:
        foot = cl.points
    else:
        return size * np.array([-0.5, -0.35, -0.4]), size * np.array([0.5, 0.35, 0.0])
    low, high = foot.min(axis=0), foot.max(axis=0)
    middle, half = (low + high)[:2] / 2, np.maximum((high - low)[:2] / 2 + 0.08 * size, 0.3 * size)
    under_point = part is None and cl is not None and _is_point(size, cl)
    top = low[2] - (0.5 * size if under_point else 0.0)
    return np.array([*(middle - half), min(0.0, top - 0.3 * size)]), np.array([*(middle + half), top])


def _is_point(size: float, cl: CLData) -> bool:
    return np.ptp(cl.points, axis=0).max() < 0.01 * size


def _blade(size: float, cl: CLData, root: float) -> list[np.ndarray]:
    """The rings of a blade under a path that is a point, where the tool fans; `root` is the lowest height."""
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)[:, None]
    tip, fan = cl.points.mean(axis=0), np.ptp(cl.axes[:, :2], axis=0)
    across = unit(fan) if np.hypot(*fan) > 1e-9 else np.array([1.0, 0.0])
    along, camber = np.array([-across[1], across[0]]), 0.06 * size * np.sin(turn) ** 2
    rings = []
    for height, width in BLADE:
        flat = (width * np.cos(turn) * size + camber) * across + 0.3 * size * np.sin(turn) * along
        rings.append(np.column_stack([tip[:2] + flat, np.full(len(turn), root + height * (tip[2] - root))]))
    return [*rings, tip[None]]


def _workpiece_side(made: Arrangement, machine: Machine, stock: np.ndarray) -> None:
    """Add turntable and cradle from the workpiece down, then the bed."""
    size, tables = made.size, [r for r in machine.rotary if r.carries == "workpiece"]
    lowest, radius = stock[:, 2].min(), 0.3 * size
    carried = [ring([*stock.mean(axis=0)[:2], lowest], UP, radius)]
    if tables:
        turntable, axis = tables[-1], _along(tables[-1], UP)
        across = stock - stock @ axis[:, None] * axis - _foot(turntable, np.zeros(3))
        radius = max(1.05 * np.linalg.norm(across, axis=1).max(), 0.4 * size)
        under, hub = _foot(turntable, (stock @ axis).min() * axis) - 0.12 * size * axis, 0.6 * radius
        made.lathe(turntable.name, "second", TABLE, radius, 0.12 * size, under, axis)
        carried = [ring(under - 0.12 * size * axis, axis, hub)]
        made.disc(turntable.name, under - 0.06 * size * axis, axis, hub)
        made.line(turntable.name, carried, axis)
        lowest = carried[0][:, 2].min()
    if len(tables) == 2:
        cradle, across = tables[0], axis
        axis, foot = _along(cradle, UP), _foot(cradle, carried[0].mean(axis=0))
        bearings = _bearings(foot, axis, across, clear=1.12 * radius, thin=0.45 * radius, radius=0.35 * radius)
        made.join(cradle.name, "first", carried, bearings)
        carried = made.turns(cradle.name, bearings, axis, 0.35 * radius)
        lowest = min(foot[2] - 0.8 * max(np.linalg.norm(stock - foot, axis=1).max(), radius), lowest)
    floor, half = lowest - 0.15 * size, 1.55 * max(radius, 0.6 * size)
    bed, slides = "bed", machine.slides_that_carry("workpiece")
    for bearing in carried:
        middle, reach = bearing.mean(axis=0)[:2], np.ptp(bearing, axis=0).max() / 2
        foot = block([*(middle - reach), floor], [*(middle + reach), floor + 0.01 * size])
        if np.ptp(bearing[:, 2]) < 1e-6:  # a column under a table or a vice
            foot = ring([*middle, floor], UP, 1.1 * reach, count=24)
            bearing = ring(bearing.mean(axis=0), UP, reach, count=24)
        made.hull([bed, *slides][-1], "bed", bearing, foot)
    (left, front), (right, back) = stock.mean(axis=0)[:2] - half, stock.mean(axis=0)[:2] + half
    for name in [*reversed(slides), bed]:  # a plate for each slide under the workpiece, then the bed's
        made.plate = block([left, front, floor - 0.12 * size], [right, back, floor])
        made.hull(name, "bed" if name == bed else "first", made.plate)
        floor, left, right = floor - 0.12 * size, left - 0.1 * size, right + 0.1 * size


def _tool_side(made: Arrangement, machine: Machine, tip: np.ndarray, tool_axis: np.ndarray, radius: float) -> None:
    """Add tool, spindle and heads from the tool up, then the slides."""
    size, width = made.size, 0.17 * made.size
    nose = tip + machine.tool_length * tool_axis
    face = tip + max(machine.tool_length, 0.45 * size) * tool_axis  # a tool of length zero is drawn, too
    reach, turn = float(np.linalg.norm(face - tip)), np.linspace(0, np.pi / 2, 7)
    ball = [*zip(radius * np.sin(turn), radius * (1 - np.cos(turn)), strict=True)]
    cutter = [*ball, (radius, 0.55 * reach), (0, 0.55 * reach)]
    made.lathe("tool", COLOUR["tool"], cutter, 1, 1, tip, tool_axis)
    made.lathe("tool", "holder", HOLDER, 0.1 * size, reach, tip, tool_axis)
    moving, heads = machine.slides_that_carry("tool"), [r for r in machine.rotary if r.carries == "tool"]
    slides = [*["bed"] * (3 - len(moving)), *moving]
    if heads:  # the spindle's housing is one body; its carrier may have two arms
        swivel, axis = heads[-1], _along(heads[-1], tool_axis)
        foot = nose + _foot(swivel, face - nose, tool_axis)
        bearings = _bearings(foot, -axis, tool_axis, clear=1.1 * width, thin=0.3 * width, radius=0.9 * width)
        made.hull(swivel.name, "second", ring(face, tool_axis, width), *bearings)
        carried = made.turns(swivel.name, bearings, axis, 0.8 * width)
    else:
        carried = [ring(face + 0.5 * size * tool_axis, tool_axis, width)]
        made.lathe(slides[2], "second", SPINDLE, width, 0.5 * size, face, tool_axis)
    if len(heads) == 2:
        turning, across = heads[0], axis
        axis, middle = _along(heads[0], tool_axis), np.concatenate(carried).mean(axis=0)
        foot = nose + _foot(turning, middle - nose)
        above = max(((np.concatenate(carried) - foot) @ axis).max(), 0.0) + 0.2 * width
        bearings = _bearings(foot, -axis, across, clear=1.5 * width, thin=above, radius=0.9 * width)
        if abs(axis @ tool_axis) >= ACROSS:  # a turning head that a fork or a nutating swivel hangs from
            bearings = [ring(foot + above * axis, axis, 1.1 * width)]
        made.join(turning.name, "first", carried, bearings)
        carried = made.turns(turning.name, bearings, axis, 0.8 * width)
    top = np.concatenate(carried).mean(axis=0)
    foot = top + max(1.2 * width, np.concatenate(carried)[:, 2].max() - top[2] + 0.4 * width) * UP
    wide = 1.1 * width * np.array([1, 1, 0])
    ram = block(foot - wide, foot + wide + 3 * size * UP)
    shade = "first" if heads else "second"
    made.join(slides[2], shade, carried, [ram[ram[:, 2] < foot[2] + 1e-9]])
    made.hull(slides[2], shade, ram)
    _slides(made, slides, foot, width)


def _slides(made: Arrangement, slides: Sequence[str], foot: np.ndarray, width: float) -> None:
    """Add the outer slide on a wall behind the bed, and the beam of the next, the ram of the last at its end."""
    size, (left, _, floor), (right, edge, top) = made.size, made.plate.min(axis=0), made.plate.max(axis=0)
    back, bottom = foot[1] + max(0.6 * size, made.retreat + 1.2 * width), foot[2] + 0.45 * size
    if back > edge:
        made.hull("bed", "bed", block([left, edge, floor], [right, back, top]))
    back = max(back, edge)
    rail, behind = bottom - 0.12 * size, back + 0.4 * size
    made.hull("bed", "wall", block([left, back, floor], [right, behind, rail]))
    low, high = foot[0] - 0.4 * size, foot[0] + 0.4 * size
    made.hull(slides[0], "first", block([low, back, rail], [high, behind, bottom]))
    low, high = [foot[0] - 0.25 * size, foot[1] + 1.1 * width], [foot[0] + 0.25 * size, behind + 0.1 * size]
    made.hull(slides[1], "second", block([*low, bottom], [*high, bottom + 0.35 * size]))


def _bearings(
    foot: np.ndarray, axis: np.ndarray, carried_axis: np.ndarray, *, clear: float, thin: float, radius: float
) -> list[np.ndarray]:
    """Rings square to `axis` about `foot`: two if it lies across `carried_axis`, otherwise one against `axis`."""
    if abs(axis @ carried_axis) < ACROSS:
        return [ring(foot + side * clear * axis, axis, radius) for side in (-1, 1)]
    return [ring(foot - thin * axis, axis, 1.2 * radius)]


def _along(rotary: Rotary, direction: np.ndarray) -> np.ndarray:
    """The unit vector of a rotary axis, turned towards `direction`."""
    axis = unit(np.array(rotary.axis))
    return axis if axis @ direction > -1e-9 else -axis


def _foot(rotary: Rotary, point: np.ndarray, direction: np.ndarray | None = None) -> np.ndarray:
    """The point of a rotary axis nearest to `point`, or to the line through it along `direction`."""
    axis, on = unit(np.array(rotary.axis)), np.array(rotary.point, dtype=float)
    away = point - on
    if direction is None:
        return on + away @ axis * axis
    slope = axis @ direction
    return on + (away @ axis - slope * (away @ direction)) / (1 - slope**2) * axis
