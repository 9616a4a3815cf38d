"""The rules of source 002, section 1.2, by which it chooses the rotary angles, word for word."""

import numpy as np

from mathpost.errors import InputError, ReachError
from mathpost.post.travel import TRAVEL_TOLERANCE, TURN, out_of_travel, within_travel


def apply(kin, pieces, prefer, progress):
    """Yield each piece of a path with joints (n, 5) and branches (n,) by cases (1) to (3), (6) and the C ± 2π rule.

    The C ± 2π rule compares with the next angle before that one is corrected, as the paper has it; it does not
    repair an ordinary crossing of ±180°. The result may swing the long way round, and is for comparison.

    Parameters
    ----------
    kin : Kinematics
    pieces : sequence of CLData
    prefer : {1, -1}
        The preferred direction of the tilting axis, the paper's dominant range (优势区间).
    progress : callable
        Takes how many records have been looked at.

    Raises
    ------
    InputError
        If the solutions of the machine are not opposite angles.
    ReachError
        If the rules lead out of travel anywhere; nothing has been yielded then.
    """
    derived = kin.inverse_symbolic
    if derived.solutions[0] != -derived.solutions[1]:
        found = f"{kin.machine.name}, where it is elsewhere"
        raise InputError("strategy 'paper'", f"a machine whose two solutions are ±{derived.inner}", found)
    fault, done = None, 0
    for piece, joints, _ in _corrected(kin, pieces, prefer):
        fault = fault or _leaves_travel(kin.machine, piece, joints)
        done += len(piece)
        progress(done)
    if fault:
        raise fault
    yield from _corrected(kin, pieces, prefer)


def _tilted(kin, pieces, prefer):
    """Yield each piece with joints and branches by cases (1) to (3)."""
    inner = kin.symbols.index(kin.inverse_symbolic.inner)
    near, far = sorted(abs(kin.machine.limits[inner]))
    before = 0.0
    for number in range(len(pieces)):
        piece = pieces[number]
        joints = kin.inverse(piece.points, piece.axes)
        theta = np.abs(joints[:, 0, inner])
        if (beyond := np.flatnonzero(~(theta <= far + TRAVEL_TOLERANCE))).size:  # case (1), and out of reach
            angle = f"|{kin.symbols[inner]}| {np.rad2deg(theta[beyond[0]]):.3f}°"
            raise ReachError(f"{piece.where(int(beyond[0]))}: {angle} is outside travel, case (1)")
        branch = np.empty(len(theta), dtype=int)
        for record, angle in enumerate(theta.tolist()):
            sign = prefer  # case (2), equation (5)
            if angle <= near:  # case (3)
                sign = min((prefer, -prefer), key=lambda sign: abs(sign * angle - before))
            branch[record], before = (0 if sign > 0 else 1), sign * angle
        yield piece, joints[np.arange(len(branch)), branch], branch


def _corrected(kin, pieces, prefer):
    """Yield each piece with joints and branches, the outer angle corrected by the C ± 2π rule."""
    outer = kin.symbols.index(kin.inverse_symbolic.outer)
    before, held = [], None
    for piece, joints, branch in _tilted(kin, pieces, prefer):
        if held:
            yield _turned(held, outer, before, [joints[0, outer]])
            before = [held[1][-1, outer]]
        held = piece, joints, branch
    if held:
        yield _turned(held, outer, before, [])


def _turned(held, outer, before, after):
    """Correct the outer angles of a piece, between the corrected one before it and the one after it."""
    _, joints, _ = held
    angles = [*before, *joints[:, outer].tolist(), *after]
    for record in range(1, len(angles) - 1):
        choices = angles[record], angles[record] - TURN * np.sign(angles[record])
        change = [abs(angle - angles[record - 1]) + abs(angle - angles[record + 1]) for angle in choices]
        if change[0] > change[1]:
            angles[record] = choices[1]
    joints[:, outer] = angles[len(before) : len(before) + len(joints)]
    return held


def _leaves_travel(machine, piece, joints):
    """The error of the first record out of travel, or None."""
    inside = [within_travel(machine, joint, joints[:, joint]) for joint in range(5)]
    out = np.flatnonzero(~np.all(inside, axis=0))
    if out.size:
        record = int(out[0])
        return ReachError(f"{piece.where(record)}: {'; '.join(out_of_travel(machine, joints[record]))}")
