"""Forward and inverse kinematics: the chain of a machine solved in sympy and compiled.

Between the workpiece and the tool are two rotary joints: the *workpiece-side* one, next to the workpiece, and the
*tool-side* one, next to the tool (shops count them as fourth and fifth axis, or rotary axis 1 and 2). Only the
latter changes the angle between the tool axis and the workpiece-side axis, so it is solved first, from one equation
A·cos θ + B·sin θ = D; the workpiece-side one then turns the tool axis into place, and X Y Z close the loop.
`derive` does this step by step, `Kinematics` compiles what it finds.

A machine with one rotary axis is the same chain with the workpiece-side joint alone: the tool axis keeps its angle
to it, and the first step has nothing to solve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Protocol

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost import chain
from mathpost.errors import as_array
from mathpost.formula import numeric, slices
from mathpost.rotation import about, unit, wrap

if TYPE_CHECKING:
    from mathpost.chain import Geometry, Link
    from mathpost.machine import Machine

REACH_TOLERANCE = 4e-15  # r ∓ D below zero by no more than this is rounding: the edge of reach
PRINTED = 2e-6  # radians that a tool axis printed with six decimals may be off one that a single joint can reach
AT_POLE = 1e-200  # squared: nearer than 1e-100 to the pole, any workpiece-side angle is right
BELOW, ABOVE = sp.symbols("r_minus r_plus", nonnegative=True)


@dataclass(frozen=True)
class Inverse:
    """The derivation of the inverse in sympy, for display; `Kinematics.inverse` compiles these expressions.

    The equation A·cos θ + B·sin θ = D, with r = √(A² + B²), has solutions where neither r − D nor r + D is
    negative. Both are written with the chords from the tool axis to the two ends of the workpiece-side axis, which
    lose no digits at the pole.
    """

    tip: tuple[sp.Symbol, ...]  # x y z of the tool tip in the workpiece, mm
    axis: tuple[sp.Symbol, ...]  # i j k of the tool axis there, a unit vector
    workpiece_side: sp.Symbol  # the rotary joint next to the workpiece
    tool_side: sp.Symbol | None  # and next to the tool; None if there is one rotary joint
    # A·cos(tool_side) + B·sin(tool_side) = D, the component of the tool axis along the workpiece-side axis:
    equation: sp.Eq
    below: sp.Expr  # r − D
    above: sp.Expr  # r + D
    # The tool-side angle on the first and the second branch, in `below` and `above` as symbols, or ():
    solutions: tuple[sp.Expr, ...]
    turn: tuple[sp.Expr, ...]  # the workpiece-side angle is atan2 of these two, given the tool-side one
    linear: tuple[sp.Expr, ...]  # programmed X Y Z, given the tip and both rotary angles
    # The end of the workpiece-side axis, in the workpiece, that is nearest the tool axis where both solutions meet:
    pole: tuple[sp.Expr, ...]
    reach: tuple[sp.Expr, ...]  # smallest and greatest angle between the tool axis and the pole


@lru_cache(maxsize=256)
def derive(machine: Machine) -> Inverse:
    """Derive the inverse of a machine as an `Inverse`."""
    data = chain.Geometry.numbers(machine)
    (workpiece_side, workpiece_side_angle, workpiece_side_sign), *tool_side = chain.rotary_in_chain_order(machine)
    tip, axis = sp.symbols("x y z", real=True), sp.symbols("i j k", real=True)
    u, n = data.axis[workpiece_side.name], sp.Matrix(axis)

    # 1. The tool-side angle. The chain says n = Rot(u, ±workpiece_side)·w with w = Rot(v, ±tool_side)·t. A rotation
    # about u keeps the component along u, hence u·n = u·w, which is linear in the cosine and sine of the tool side.
    w, tool_side_angle = data.tool_axis, None
    for joint, tool_side_angle, sign in tool_side:
        w = about(data.axis[joint.name], sign * tool_side_angle) * w
    along = sp.expand_mul(u.dot(w))
    cosine, sine = (sp.cos(tool_side_angle), sp.sin(tool_side_angle)) if tool_side else (sp.S.Zero, sp.S.Zero)
    a, b = (along.coeff(cosine), along.coeff(sine)) if tool_side else (sp.S.Zero, sp.S.Zero)
    if (a, b) < (0, 0):  # look along the other end of the workpiece-side axis: atan2(B, A) is then in (−90°, 90°]
        u, workpiece_side_sign, along, a, b = -u, -workpiece_side_sign, -along, -a, -b
    constant = along.subs({cosine: 0, sine: 0})
    r = sp.sqrt(sp.expand(a**2 + b**2))

    # θ = atan2(B, A) ± acos(D/r). Near D = ±r, at the pole and at the edge of reach, acos loses half of the
    # digits; ψ = 2·atan2(√(r − D), √(r + D)) loses none, if r ∓ D come from the chords |n ∓ u|: on the unit
    # sphere 1 ∓ u·n = |n ∓ u|²/2, so that r ∓ D is half the difference of two squared chords.
    chord_below, chord_above = _root(2 * (1 - constant - r)), _root(2 * (1 + constant - r))
    middle, half = sp.atan2(b, a), 2 * sp.atan2(sp.sqrt(BELOW), sp.sqrt(ABOVE))

    # 2. The workpiece-side angle. Seen along u, its turn must bring w to n.
    e1, e2 = _perpendicular(u)
    w1, w2, n1, n2 = e1.dot(w), e2.dot(w), e1.dot(n), e2.dot(n)

    return Inverse(
        tip=tip,
        axis=axis,
        workpiece_side=workpiece_side_angle,
        tool_side=tool_side_angle,
        equation=sp.Eq(a * cosine + b * sine, u.dot(n) - constant, evaluate=False),
        below=_half_difference_of_squares(n - u, chord_below),
        above=_half_difference_of_squares(n + u, chord_above),
        solutions=(middle + half, middle - half) if tool_side else (),
        turn=(workpiece_side_sign * (w1 * n2 - w2 * n1), w1 * n1 + w2 * n2),
        linear=_close_the_loop(machine, data, tip),
        pole=tuple(u),
        reach=(2 * sp.asin(chord_below / 2), sp.pi - 2 * sp.asin(chord_above / 2)),
    )


def _close_the_loop(machine: Machine, data: Geometry, tip: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, ...]:
    """3. X Y Z: the tip in the machine, seen from the workpiece, is the tip seen from the tool."""
    links, symbols = chain.links(machine), chain.joint_symbols(machine)
    slides = [link.name for link in links].index("linear")
    from_workpiece = sp.Matrix([*(data.origin + sp.Matrix(tip)), 1])
    for link in links[1:slides]:  # a table's turn, traversed forwards
        turned = link.matrix.xreplace({angle: -angle for angle in symbols[3:]})
        from_workpiece = chain.product((turned, from_workpiece))
    from_tool = chain.product(link.matrix for link in links[slides:])[:, 3]
    return tuple((from_workpiece - from_tool.xreplace(dict.fromkeys(symbols[:3], sp.S.Zero)))[:3])


class ForwardKinematics(Protocol):
    """Maps joints to poses: `Kinematics`, or a measured machine with its errors.

    The latter is `mathpost.shop.compensate.compensation.Compensator`. A proof needs nothing else.
    """

    @property
    def machine(self) -> Machine:
        """The machine that the joints belong to."""

    def forward(self, joints: ArrayLike, /) -> tuple[np.ndarray, np.ndarray]:
        """Return tip and tool axis, (..., 3) each, at joints (..., j), mm and radians."""


class Kinematics:
    """Forward and inverse kinematics of one `mathpost.machine.Machine`.

    Examples
    --------
    >>> from mathpost import load_machine
    >>> kin = Kinematics(load_machine("dmu50v"))
    >>> joints = kin.inverse([50.31991, 58.40925, 52.13969], [0.145196, 0, 0.989403], degrees=True)
    >>> joints.round(3) + 0.0
    array([[-36.781, -68.575,  66.134,  11.817, 175.815],
           [ 47.426,  62.413,  51.653, -11.817,   4.185]])
    >>> tip, axis = kin.forward(joints[0], degrees=True)
    >>> tip.round(5)
    array([50.31991, 58.40925, 52.13969])
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.symbols = chain.joint_symbols(machine)
        # Which joint is next to the workpiece, and which next to the tool, None if there is one rotary joint.
        places = [self.symbols.index(angle) for _, angle, _ in chain.rotary_in_chain_order(machine)]
        self.workpiece_side: int = places[0]
        self.tool_side: int | None = places[1] if len(places) == 2 else None

    def links(self, parameters: bool = False) -> tuple[Link, ...]:
        """Return the chain from the workpiece to the tool as `mathpost.chain.links` builds it."""
        return chain.links(self.machine, parameters)

    def forward_symbolic(self, parameters: bool = False) -> sp.Matrix:
        """Return the 4×4 matrix workpiece_from_tool in the joint symbols (radians).

        Its last column is the tool tip, its third the tool axis. With `parameters` the machine's offsets and
        directions are kept as symbols too, those of `mathpost.chain.Geometry`; the directions are unit vectors.
        """
        return chain.workpiece_from_tool(self.machine, parameters)

    @cached_property
    def inverse_symbolic(self) -> Inverse:
        """The derivation of the inverse as an `Inverse`, by `derive`."""
        return derive(self.machine)

    @cached_property
    def reach(self) -> tuple[float, float]:
        """Smallest and greatest angle between the tool axis and `Inverse.pole`, radians."""
        least, most = self.inverse_symbolic.reach
        return float(sp.N(least)), float(sp.N(most))

    def forward(self, joints: ArrayLike, *, degrees: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Return the tool tip and the tool axis in the workpiece.

        Parameters
        ----------
        joints : array_like, shape (..., 5), or (..., 4) with one rotary axis
            Programmed X, Y, Z in mm and the rotary angles in the order of the machine file; `InputError` is raised
            unless they are finite numbers.
        degrees : bool, keyword only
            Whether the rotary angles are in degrees instead of radians.

        Returns
        -------
        tip : ndarray, shape (..., 3)
            mm, in the workpiece.
        axis : ndarray, shape (..., 3)
            Unit vector from the tip towards the spindle, in the workpiece.
        """
        pose = self._pose(*chain.joint_values(self.machine, joints, degrees))
        return pose[..., :3], pose[..., 3:]

    def inverse(self, tip: ArrayLike, axis: ArrayLike, *, degrees: bool = False) -> np.ndarray:
        """Return the joints of both branches.

        Parameters
        ----------
        tip : array_like, shape (..., 3)
            Tool tip in the workpiece, mm.
        axis : array_like, shape (..., 3)
            Direction from the tip towards the spindle, in the workpiece, of any length above zero; `InputError` is
            raised for length zero and for anything but finite numbers.
        degrees : bool, keyword only
            Whether the rotary angles are returned in degrees instead of radians.

        Returns
        -------
        ndarray, shape (..., 2, 5), or (..., 2, 4) with one rotary axis
            X, Y, Z in mm and the rotary angles in (−180°, 180°], in the order of the machine file. The first branch
            has the tool-side angle midway between the two solutions plus an angle, the second minus the same. NaN
            where the tool axis is out of reach. At the pole, where each workpiece-side angle is right, it is 0.
            With one rotary axis a tool axis has one position: the second branch is NaN.
        """
        tips, axes = np.broadcast_arrays(as_array(tip, 3, "tip"), unit(as_array(axis, 3, "axis")))
        poses, shape = tips.shape[:-1], (2, len(self.symbols))
        tips, axes = tips.reshape(-1, 3), axes.reshape(-1, 3)
        joints = np.empty((*shape, len(tips)))
        for rows in slices((len(tips),)):  # all of the inverse while a piece is in the processor's cache
            joints[..., rows] = np.moveaxis(self._joints(tips[rows], axes[rows]), 0, -1)
        joints = np.moveaxis(joints, -1, 0).reshape(*poses, *shape)
        if degrees:
            np.rad2deg(joints[..., 3:], out=joints[..., 3:])
        return joints

    def _joints(self, tip: np.ndarray, axis: np.ndarray) -> np.ndarray:
        """The joints of both branches, (n, 2, 5), of tips and unit tool axes (n, 3)."""
        with np.errstate(divide="ignore", invalid="ignore"):  # at the pole, mended below
            found = self._both_branches(*tip.T, *axis.T, *self.reach_terms(axis))
        found = found.reshape(len(tip), -1, len(self.symbols) + 1)
        joints, squared = found[..., :-1], found[..., -1]
        if (at_pole := squared < AT_POLE).any():
            joints[at_pole, self.workpiece_side] = 0
            tips = np.broadcast_to(tip[:, None], (*at_pole.shape, 3))
            joints[at_pole] = self.close(tips[at_pole], joints[at_pole, 3:])
        rotary = joints[..., 3:]
        if (beyond := (rotary >= np.pi) | (rotary <= -np.pi)).any():
            rotary[beyond] = wrap(rotary[beyond], 2 * np.pi)
        if self.tool_side is None:
            missed = np.linalg.norm(self.forward(joints)[1] - axis[:, None], axis=-1) > PRINTED
            joints[missed] = np.nan
            joints = np.concatenate([joints, np.full_like(joints, np.nan)], axis=1)
        return joints

    def close(self, tip: ArrayLike, rotary: ArrayLike) -> np.ndarray:
        """Return the joints that put the tool tip at `tip` with the rotary angles given: X Y Z close the loop.

        `tip` has shape (..., 3), mm in the workpiece; `rotary` (..., k) for k rotary axes, radians in the order of
        the machine file.
        """
        tip, rotary, derived = np.asarray(tip, dtype=float), np.asarray(rotary, dtype=float), self.inverse_symbolic
        closing = numeric(derived.linear, (*derived.tip, *self.symbols[3:]))
        linear = closing(*np.moveaxis(tip, -1, 0), *np.moveaxis(rotary, -1, 0))
        return np.concatenate([linear, np.broadcast_to(rotary, (*linear.shape[:-1], rotary.shape[-1]))], axis=-1)

    def reach_terms(self, axis: ArrayLike) -> np.ndarray:
        """Return r − D and r + D of `Inverse` for unit tool axes (..., 3): 0 at the ends of reach, NaN beyond."""
        derived = self.inverse_symbolic
        evaluate = numeric((derived.below, derived.above), derived.axis)
        terms = evaluate(*np.moveaxis(np.asarray(axis, dtype=float), -1, 0))
        terms[terms < -REACH_TOLERANCE] = np.nan
        return np.moveaxis(np.maximum(terms, 0, out=terms), -1, 0)

    @cached_property
    def _pose(self) -> Callable[..., np.ndarray]:
        matrix = self.forward_symbolic()
        return numeric((*matrix[:3, 3], *matrix[:3, 2]), self.symbols)

    @cached_property
    def _both_branches(self) -> Callable[..., np.ndarray]:
        return numeric(*solved(self.inverse_symbolic, self.symbols[3:]))


def solved(
    derived: Inverse, rotary: tuple[sp.Symbol, ...]
) -> tuple[tuple[sp.Expr, ...], tuple[sp.Symbol, ...], tuple[tuple[sp.Symbol, sp.Expr], ...]]:
    """Return an `Inverse` solved for the joints, as expressions, their arguments, and pairs of name and meaning.

    For each branch: X Y Z, the angles `rotary` and the sum of the squares of `Inverse.turn`, which is 0 at the
    pole; the arguments are tip, tool axis, `BELOW` and `ABOVE`. The cosines and sines of both angles are algebraic
    in the arguments of their atan2: none is computed from an angle. The named symbols replace terms in the
    expressions that sympy would otherwise examine each time.
    """
    entries: list[sp.Expr] = []
    # A symbol is known to sympy as real; for the expression that it replaces, sympy would take long to find out.
    named: dict[sp.Symbol, sp.Expr] = {}
    for branch, solution in enumerate(derived.solutions or (None,)):
        cosine, sine, rise, run = sp.symbols([f"{name}_{branch}" for name in ("c", "s", "rise", "run")], real=True)
        squared = sp.Symbol(f"squared_{branch}", positive=True)
        length = sp.sqrt(squared)
        values, angles = {}, {}
        if solution is not None:
            named |= {cosine: sp.expand_trig(sp.cos(solution)), sine: sp.expand_trig(sp.sin(solution))}
            values = {sp.cos(derived.tool_side): cosine, sp.sin(derived.tool_side): sine}
            angles = {derived.tool_side: solution}
        named |= dict(zip((rise, run), (term.xreplace(values) for term in derived.turn), strict=True))
        named[squared] = rise**2 + run**2
        values |= {sp.cos(derived.workpiece_side): run / length, sp.sin(derived.workpiece_side): rise / length}
        angles[derived.workpiece_side] = sp.atan2(rise, run)
        linear = [coordinate.xreplace(values) for coordinate in derived.linear]
        entries += [*linear, *(angles[joint] for joint in rotary), squared]
    return tuple(entries), (*derived.tip, *derived.axis, BELOW, ABOVE), tuple(named.items())


def _perpendicular(u: sp.Matrix) -> tuple[sp.Matrix, sp.Matrix]:
    """Two unit vectors that make a right-handed frame with `u` as its third."""
    nearest_to_square = min(range(3), key=lambda row: abs(float(u[row])))
    e = sp.Matrix([int(row == nearest_to_square) for row in range(3)])
    e1 = e - u * u.dot(e)
    e1 = e1 / sp.sqrt(e1.dot(e1))
    return e1, u.cross(e1)


def _half_difference_of_squares(vector: sp.Matrix, chord: sp.Expr) -> sp.Expr:
    """(|vector|² − chord²)/2, factored so that it keeps its digits where the two are nearly equal."""
    squared = vector.dot(vector)
    return squared / 2 if chord == 0 else (sp.sqrt(squared) - chord) * (sp.sqrt(squared) + chord) / 2


def _root(number: sp.Expr) -> sp.Expr:
    """√number, exactly 0 where the number is a zero that sympy has not recognised."""
    return sp.S.Zero if abs(sp.N(number, 40)) < 1e-30 else sp.sqrt(number)
