"""Where RTCP believes the tool to be, and where it really is: the chain with unknown geometry."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import sympy as sp

from mathpost import chain
from mathpost.formula import numeric
from mathpost.kinematics import Kinematics
from mathpost.machine import Linear, Machine, Rotary
from mathpost.rotation import unit
from mathpost.shop.compensate.model import named_point


def held(
    machine: Machine, target: np.ndarray, angles: np.ndarray, length: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the joints, (n, 5), with which RTCP holds the tip on `target`, and the turns machine_from_workpiece.

    `target` is (n, 3) in the workpiece, `angles` (n, 2) radians, `length` (n,).
    """
    zero, by = tips(machine, np.column_stack([np.zeros((len(angles), 3)), angles]), length)
    turn = np.swapaxes(by[..., :3], 1, 2)
    return np.column_stack([np.einsum("nij,nj->ni", turn, target - zero), angles]), turn


def tips(
    machine: Machine, joints: np.ndarray, length: np.ndarray, real: Machine | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the tip in the workpiece, (n, 3), with tools of any `length`, (n,), and its derivatives, (n, 3, 26).

    They are by the `joints`, by the 18 numbers of `geometry` and by the point that X Y Z name. `real` is the
    machine as it is if that is not `machine`, with which the control reckons.
    """
    numbers = [*geometry(real or machine), *np.moveaxis(named_point(machine, length), -1, 0)]
    formula = _compiled(tuple(each.carries for each in machine.rotary))
    found = formula(*np.transpose(joints), *numbers, length)
    return found[..., 0], found[..., 1:]


def geometry(machine: Machine) -> np.ndarray:
    """The axes and points, origin and tool axis of a machine: 18 numbers."""
    axes, points = [unit(each.axis) for each in machine.rotary], [each.point for each in machine.rotary]
    return np.concatenate([*axes, *points, machine.origin, unit(machine.tool_axis)])


@lru_cache(maxsize=8)
def _compiled(carries: tuple[str, ...]) -> Callable[..., np.ndarray]:
    """Tip and derivatives, (n, 3, 27), of all machines whose rotary axes carry these sides, by their numbers."""
    rotary = tuple(Rotary(name, side, (1, 0, 0), (0, 0, 0)) for name, side in zip("AB", carries, strict=False))
    linear = tuple(Linear(name) for name in "XYZ")
    machine = Machine("", "", rotary, linear, (0, 0, 0), (0, 0, 1), 0.0, (0.0, 0.0, 0.0))
    kin = Kinematics(machine)
    *numbers, length = (each for each in chain.Geometry.symbols(machine).flat() if each.is_Symbol)
    arguments = (*kin.symbols, *numbers, length)
    # The product rule link by link, from the tool on: to differentiate the product takes sympy three times as long.
    tip, slopes = sp.Matrix([0, 0, 0, 1]), sp.zeros(4, len(arguments) - 1)
    for link in reversed(kin.links(parameters=True)):
        own = [chain.product((link.matrix.diff(each), tip)) for each in arguments[:-1]]
        slopes = chain.product((link.matrix, slopes)) + sp.Matrix.hstack(*own)
        tip = chain.product((link.matrix, tip))
    return numeric(sp.ImmutableMatrix.hstack(tip, slopes)[:3, :], arguments)
