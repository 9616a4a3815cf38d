"""Where a rotary axis jumps from one record to the next, and why: the pole, the travel, or the way as a whole."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mathpost.kinematics import Kinematics
from mathpost.path import selection, singular
from mathpost.path.cl import CLData

JUMP = 60.0  # degrees between two records; more is a jump
NEAR = np.radians(10.0)  # from a singular tool axis: beyond, it is no reason


@dataclass(frozen=True)
class Jump:
    """A rotary axis turns far between two records; ``print(jump)`` says from where to where, and why."""

    record: int  # from 0, at which it starts
    axis: str
    start: float  # degrees
    end: float
    why: str

    def __str__(self) -> str:
        turned = (
            f"{self.axis} turns by {abs(self.end - self.start):.1f}°, from {self.start:z.3f}° to {self.end:z.3f}°"
        )
        return f"record {self.record + 1} to {self.record + 2}: {turned}. {self.why}"


def jumps(kin: Kinematics, cl: CLData, joints: np.ndarray) -> list[Jump]:
    """Return the moves on which a rotary axis turns by more than `JUMP` degrees, in order.

    `joints`, shape (n, j), mm and radians, are those of the records, as in `mathpost.shop.post.postprocess.Result`.

    Examples
    --------
    >>> import mathpost
    >>> kin = Kinematics(mathpost.load_machine("dmu50v"))
    >>> blade = mathpost.read_cl("data/cl/blade.cl")
    >>> print(*jumps(kin, blade, selection.choose(kin, blade).joints))
    record 2 to 3: C turns by 179.2°, from 178.332° to -0.825°. The tool axis passes 0.00° from the pole, ...
    """
    steps = np.degrees(np.diff(joints[:, 3:], axis=0))
    found = []
    for record in np.flatnonzero((np.abs(steps) > JUMP).any(axis=1)).tolist():
        axis = int(np.abs(steps[record]).argmax())
        start, end = np.degrees(joints[record : record + 2, 3 + axis]).tolist()
        why = " ".join([*_at_the_pole(kin, cl, record), _instead(kin, cl, joints, record)])
        found.append(Jump(record, kin.machine.rotary[axis].name, start, end, why))
    return found


def _at_the_pole(kin: Kinematics, cl: CLData, record: int) -> Iterator[str]:
    """A sentence if the tool axis passes near a singular one."""
    if kin.tool_side is None:
        return
    _, away = singular.nearest(kin, cl.axes[record, None], cl.axes[record + 1, None])
    if away[0] < NEAR:
        yield (
            f"The tool axis passes {np.degrees(away[0]):.2f}° from the pole, "
            f"where {kin.machine.joint_names[kin.workpiece_side]} has to turn far."
        )


def _instead(kin: Kinematics, cl: CLData, joints: np.ndarray, record: int) -> str:
    """A sentence on the solution of the next record that turns least, and what speaks against it."""
    before = selection.candidates(kin, cl.points[record, None], cl.axes[record, None])
    after = selection.candidates(kin, cl.points[record + 1, None], cl.axes[record + 1, None])
    turned = _largest_turn(kin, after.joints[0] - joints[record])
    taken = np.degrees(np.abs(joints[record + 1] - joints[record])[3:].max())
    least = int(np.nanargmin(turned))
    if turned[least] > taken - 1e-6:
        return "No solution turns less."
    other = np.degrees(after.joints[0, least, 3:])
    words = " ".join(f"{axis.name} {angle:z.3f}°" for axis, angle in zip(kin.machine.rotary, other, strict=True))
    said = f"The solution {words} would turn by {turned[least]:.1f}° at most"
    if reason := after.reason(0, least):
        return f"{said}, but {reason}."
    here = int(np.nanargmin(_largest_turn(kin, before.joints[0] - joints[record])))
    if before.branch[here] != after.branch[least]:
        return f"{said}, but it is on the other branch: to change there takes the tool axis off its arc."
    return f"{said}, but the way as a whole, or the rule of the selection, is against it."


def _largest_turn(kin: Kinematics, steps: np.ndarray) -> np.ndarray:
    """Degrees by which the rotary axis turns that turns most, steps (m, j)."""
    return np.degrees(np.abs(selection.short_way(kin.machine, steps))[:, 3:].max(axis=1))
