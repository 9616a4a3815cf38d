"""The rules of source 002, section 1.2, by which it chooses the rotary angles, word for word."""

import numpy as np

from mathpost.errors import InputError, ReachError
from mathpost.post.travel import TURN, all_within, out_of_travel, within_travel


def choose(kin, cl, prefer):
    """Return joints (n, 5) and branches (n,) by cases (1) to (3), (6) and the C ± 2π rule, for comparison.

    The result may swing the long way round.

    Parameters
    ----------
    kin : Kinematics
    cl : CLData
    prefer : {1, -1}
        The preferred direction of the tilting axis, the paper's dominant range (优势区间).

    Raises
    ------
    InputError
        If the two solutions of the machine are not opposite angles.
    ReachError
        If the rules lead out of travel.
    """
    derived = kin.inverse_symbolic
    if derived.solutions[0] != -derived.solutions[1]:
        found = f"{kin.machine.name}, where it is elsewhere"
        raise InputError("strategy 'paper'", f"a machine whose two solutions are ±{derived.inner}", found)
    both = kin.inverse(cl.points, cl.axes)
    branch = _branches(kin, cl, both[:, 0, kin.symbols.index(derived.inner)], prefer)
    joints = both[np.arange(len(branch)), branch]
    outer = kin.symbols.index(derived.outer)
    joints[:, outer] = _turned(joints[:, outer].tolist())
    out = np.flatnonzero(~all_within(kin.machine, joints))
    if out.size:
        sentences = out_of_travel(kin.machine, joints[out[0]])
        raise ReachError(f"{cl.where(int(out[0]))}: {'; '.join(sentences)}")
    return joints, branch


def _branches(kin, cl, solution, prefer):
    """The branch of each record, by cases (1) to (3) on the size of the tilting angle, radians."""
    inner = kin.inverse_symbolic.inner
    near, far = sorted(np.abs(kin.machine.limits[kin.symbols.index(inner)]))
    signs, before = [], 0.0
    for record, tilt in enumerate(np.abs(solution).tolist()):
        if not within_travel(tilt, 0.0, far):  # case (1), and out of reach
            raise ReachError(f"{cl.where(record)}: |{inner}| {np.degrees(tilt):.3f}° is outside travel, case (1)")
        sign = prefer  # case (2), equation (5)
        if tilt <= near:  # case (3): the smaller step
            sign = min((prefer, -prefer), key=lambda sign: abs(sign * tilt - before))
        signs.append(sign)
        before = sign * tilt
    return np.where(np.array(signs) > 0, 0, 1)


def _turned(angles):
    """The outer angles, a list of radians, after the C ± 2π rule.

    Each angle between the first and the last takes a turn off if that brings it nearer to both neighbours together.
    The neighbour behind it has not been corrected by then, as the paper has it: an even walk across ±180° stays
    broken.
    """
    for record in range(1, len(angles) - 1):
        before, angle, after = angles[record - 1 : record + 2]
        turned = angle - TURN * np.sign(angle)
        if abs(turned - before) + abs(turned - after) < abs(angle - before) + abs(angle - after):
            angles[record] = turned
    return angles
